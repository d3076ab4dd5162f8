//! Division of indirect light between camera paths and photon estimates.
//!
//! At a diffuse first receiver, two techniques find the light that other receivers reflect to it:
//! continued camera paths, and a density estimate in the interreflection map. Their weights sum
//! to 1. In pass number i, let v be the variance of the mean of the continued paths, u that of the
//! photon estimate, and b its bias. Photons get the weight v/(v + u + i·b²). Bias counts i times
//! because it is common to all passes, while their noise averages out. As gather discs shrink by
//! the relative area A, u grows as 1/A and b falls as A. So camera paths take over in the long run,
//! and the mean of the passes converges as fast as theirs.
//!
//! The variances and the bias differ from place to place. A pilot measures them for the cells of a
//! grid over the film; between the centers of the cells they are interpolated.

use crate::color::Rgb;
use glam::Vec2;

/// Weights of both techniques at one pixel in one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct IndirectWeights {
    /// Weight of the photon estimate. If it is 0, all camera paths continue.
    pub photons: f32,
    /// Number of the pixel's camera paths that continue: the first ones by sample index.
    pub continued: u32,
    /// Number of camera paths of the pixel.
    pub samples: u32,
}

/// Indirect light that a camera path of a pilot finds by each technique, times its weight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IndirectLight {
    /// Light found by the continued path \[W/(m² sr)].
    pub paths: Rgb,
    /// Light found by the photon estimate \[W/(m² sr)].
    pub photons: Rgb,
    /// Photon estimate minus that with half the disc area, if nested estimates are made.
    pub photon_step: Rgb,
}

/// Noise and bias of both techniques in one cell of the film, relative to the light there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct IndirectErrors {
    /// Variance of one continued camera path.
    pub path_variance: f32,
    /// Variance of the photon estimate in the first pass, times its number of photon paths.
    pub photon_variance: f32,
    /// Mean squared bias of the photon estimate in the first pass.
    pub squared_bias: f32,
}

/// Errors of both techniques over the film, and the numbers of samples that decide the weights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct IndirectDivision {
    /// Number of columns of the grid. A cell has the same number of pixels in both directions.
    pub columns: u32,
    /// Errors of each cell, by rows from the top.
    pub cells: Vec<IndirectErrors>,
    /// Edge length of a cell \[pixels].
    pub cell_size: f32,
    /// Number of camera paths per pixel.
    pub samples: u32,
    /// Number of photon paths of the interreflection map.
    pub photons: u32,
    /// Variance that is worth the work of one continued camera path.
    pub path_price: f32,
    /// Number of passes in which photons take part.
    pub passes: u32,
}

/// Technique that finds indirect light at diffuse first receivers in one pass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum IndirectTechnique<'a> {
    /// Continued camera paths.
    #[default]
    Paths,
    /// Photon estimates.
    Photons,
    /// Both techniques without weights, for a pilot that compares them.
    Comparison,
    /// Both techniques with weights.
    Both {
        division: &'a IndirectDivision,
        /// Number of the pass, counted from 1.
        number: f32,
        /// Area of gather discs relative to the first pass.
        area: f32,
    },
}

impl IndirectTechnique<'_> {
    /// Returns the mean weight of photon estimates over the film.
    pub fn mean_photon_weight(&self) -> f64 {
        match self {
            Self::Paths => 0.0,
            Self::Photons | Self::Comparison => 1.0,
            Self::Both { division, number, area } => division.mean_photon_weight(*number, *area),
        }
    }

    /// Returns the weights at a film position \[pixels from the top left].
    #[inline]
    pub fn weights(&self, film: Vec2) -> IndirectWeights {
        match self {
            Self::Paths => IndirectWeights::default(),
            Self::Photons => IndirectWeights { photons: 1.0, continued: 0, samples: 1 },
            Self::Comparison => IndirectWeights::COMPARISON,
            Self::Both { division, number, area } => division.weights(film, *number, *area),
        }
    }
}

impl IndirectWeights {
    /// Both techniques with weight 1: their light counts twice.
    const COMPARISON: Self = Self { photons: 1.0, continued: u32::MAX, samples: u32::MAX };

    /// True if sample `index` of `count` continues at its first receiver.
    ///
    /// A pilot traces one sample. It stands for any of the samples, and `u` in \[0, 1) decides.
    #[inline]
    pub fn is_continued(&self, (index, count): (u32, u32), u: f32) -> bool {
        if count == 1 { u * (self.samples as f32) < self.continued as f32 } else { index < self.continued }
    }

    /// Returns the weight of each continued path of `count` paths of a pixel.
    #[inline]
    pub fn path_weight(&self, count: u32) -> f32 {
        if *self == Self::COMPARISON {
            return 1.0;
        }
        let count = if count == 1 { self.samples } else { count };
        (1.0 - self.photons) * count as f32 / self.continued.min(count).max(1) as f32
    }
}

impl IndirectErrors {
    /// Returns the number of continued paths and the weight of photons with least error.
    #[inline]
    fn balance(&self, division: &IndirectDivision, number: f32, area: f32) -> IndirectWeights {
        let samples = division.samples;
        let photons = self.photon_error(division.photons, number, area);
        let paths = self.path_variance;
        if photons <= 0.0 || paths <= 0.0 {
            // Nothing is known of one technique.
            return IndirectWeights::default();
        }
        // The error of both is 1/(1/photons + n/paths). Its derivative by n is −error²/paths.
        let wanted = (paths / division.path_price).sqrt() - paths / photons;
        let continued = wanted.clamp(0.0, samples as f32).round();
        let error = paths / continued.max(f32::MIN_POSITIVE);
        let weight = if continued == 0.0 { 1.0 } else { error / (error + photons) };
        IndirectWeights { photons: weight, continued: continued as u32, samples }
    }

    /// Returns the mean squared error of the photon estimate of a pass, in which bias counts
    /// `number` times.
    #[inline]
    fn photon_error(&self, photons: u32, number: f32, area: f32) -> f32 {
        self.photon_variance / (photons as f32 * area) + number * self.squared_bias * area * area
    }
}

impl IndirectDivision {
    #[inline]
    fn weights(&self, film: Vec2, number: f32, area: f32) -> IndirectWeights {
        self.errors_at(film).balance(self, number, area)
    }

    /// Interpolates the errors at a film position \[pixels from the top left].
    #[inline]
    fn errors_at(&self, film: Vec2) -> IndirectErrors {
        let rows = self.cells.len() as u32 / self.columns;
        let last = Vec2::new((self.columns - 1) as f32, (rows - 1) as f32);
        let place = (film / self.cell_size - 0.5).clamp(Vec2::ZERO, last);
        let (corner, part) = (place.floor(), place - place.floor());
        let cell = |x: f32, y: f32| &self.cells[(y.min(last.y) * self.columns as f32 + x.min(last.x)) as usize];
        let corners = [
            (cell(corner.x, corner.y), (1.0 - part.x) * (1.0 - part.y)),
            (cell(corner.x + 1.0, corner.y), part.x * (1.0 - part.y)),
            (cell(corner.x, corner.y + 1.0), (1.0 - part.x) * part.y),
            (cell(corner.x + 1.0, corner.y + 1.0), part.x * part.y),
        ];
        let mean = |value: fn(&IndirectErrors) -> f32| corners.iter().map(|(c, w)| value(c) * w).sum::<f32>();
        IndirectErrors {
            path_variance: mean(|c| c.path_variance),
            photon_variance: mean(|c| c.photon_variance),
            squared_bias: mean(|c| c.squared_bias),
        }
    }

    /// Returns the mean weight of photon estimates over all cells in a pass.
    fn mean_photon_weight(&self, number: f32, area: f32) -> f64 {
        let weights = self.cells.iter().map(|cell| f64::from(cell.balance(self, number, area).photons));
        weights.sum::<f64>() / self.cells.len().max(1) as f64
    }

    /// Returns, over all cells, the mean error of indirect light in a pass and the mean number of
    /// continued paths per pixel.
    pub fn mean_error_and_paths(&self, number: f32, area: f32) -> (f64, f64) {
        let mut sums = (0.0, 0.0);
        for cell in &self.cells {
            let weights = cell.balance(self, number, area);
            let error = if weights.photons > 0.0 {
                weights.photons * cell.photon_error(self.photons, number, area)
            } else {
                cell.path_variance / self.samples as f32
            };
            let continued = if weights.photons > 0.0 { weights.continued } else { self.samples };
            sums = (sums.0 + f64::from(error), sums.1 + f64::from(continued));
        }
        let cells = self.cells.len().max(1) as f64;
        (sums.0 / cells, sums.1 / cells)
    }
}

#[cfg(test)]
mod tests;
