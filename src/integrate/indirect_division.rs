//! Division of indirect light between camera paths and photon estimates.
//!
//! Two techniques find the indirect light at the first *receiver* of a camera path: the first
//! surface or medium that stores photons. One technique continues the camera path there. The other
//! is a density estimate in the interreflection map, whose photons a receiver has already
//! reflected. Their weights sum to 1.
//!
//! Consider pass number i. Let v be the variance of the mean of the continued paths. Let u be the
//! variance of the photon estimate, and b its bias. The photon estimate gets the weight v/(v + u +
//! i·b²). The bias counts i times because all passes share it, while noise averages out. If the
//! area of gather discs has shrunk to the fraction A, u has grown as 1/A and b has fallen as A. So
//! camera paths take over after many passes, and the mean of the passes converges as fast as camera
//! paths alone.
//!
//! A pilot measures variances and bias in the cells of a grid over the film. Values between the
//! centers of cells are interpolated.
//!
//! Five fields hold the division while a camera path is traced, in order of time:
//!
//! | field | content | written at | read at |
//! | --- | --- | --- | --- |
//! | [`technique`] | technique of the pass | pass or pilot | start of a camera path |
//! | [`indirect`] | weights of both techniques | start of a camera path | first receiver |
//! | [`pending_weight`] | weight of the camera path | first receiver | next vertex |
//! | [`shares_indirect`] | if both techniques find light | first receiver | later vertices |
//! | [`indirect_by_paths`] and others | light by technique | all vertices | end of a path |
//!
//! Only the pilot in `indirect_pilot.rs` reads the fields of the last row.
//!
//! [`technique`]: super::camera_path::PathContext
//! [`indirect`]: super::camera_path
//! [`pending_weight`]: super::camera_path::PathState
//! [`shares_indirect`]: super::camera_path::PathState
//! [`indirect_by_paths`]: super::path_task::LightByPart::indirect_by_paths

use glam::Vec2;

/// Weights of camera paths and of photon estimates for the indirect light of one pixel in one pass.
///
/// Both find the indirect light at a path's first *receiver*: the first surface or medium that
/// stores photons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct IndirectWeights {
    /// Weight of the photon estimate in \[0, 1]. Camera paths have the rest, except in a pilot that
    /// compares both techniques. If the weight is 0, all camera paths continue beyond the first
    /// surface or medium that stores photons.
    pub photon_weight: f32,
    /// Number of the pixel's camera paths that continue beyond the first surface or medium that
    /// stores photons: the paths with the lowest sample indices. Meaningless if `photon_weight` is
    /// 0.
    pub continued_paths: u32,
    /// Mean number of camera paths per pixel in a pass. In a pilot (small simulation before the
    /// first pass), the single path of a pixel stands for this number of paths.
    pub samples_per_pixel: u32,
}

/// Relative variance and bias of the indirect light in one cell of a grid over the film, by camera
/// paths and by photon estimates.
///
/// Variances and squared biases are divided by L² + L̃²/100. L is the radiance of all light in the
/// cell, and L̃ is the median of L over all cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RelativeIndirectErrors {
    /// Relative variance of the indirect light that one camera path finds beyond its first receiver
    /// (surface or medium that stores photons).
    pub single_path_variance: f32,
    /// Relative variance that the photon estimate would have in the first pass with a single photon
    /// path. With n photon paths, the variance is 1/n of this value.
    pub single_photon_path_variance: f32,
    /// Relative mean squared bias of the photon estimate in the first pass.
    pub squared_bias: f32,
}

/// Measured errors of camera paths and of photon estimates for indirect light, in cells of a grid
/// over the film, with sample counts. These data determine the weights of both techniques at any
/// film point, in any pass.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct IndirectDivision {
    /// Number of columns of the film grid, which divides the film into square cells.
    pub columns: u32,
    /// Errors of camera paths and of photon estimates in each cell of the film grid, by rows from
    /// the top.
    pub cells: Vec<RelativeIndirectErrors>,
    /// Edge length of a cell of the film grid \[pixels].
    pub cell_size: f32,
    /// Mean number of camera paths per pixel in a pass.
    pub samples_per_pixel: u32,
    /// Number of photon paths per pass that lights emit in all directions. They fill the
    /// interreflection map, from which the photon estimates come.
    pub unaimed_paths: u32,
    /// Least gain for which one more camera path continues beyond its first receiver (surface or
    /// medium that stores photons). The gain is the decrease of the relative variance of indirect
    /// light.
    pub path_price: f32,
    /// Number of passes with photon estimates of indirect light. Later passes use camera paths
    /// alone.
    pub passes_with_photons: u32,
}

/// Technique that finds the indirect light at the first *receiver* of each camera path of a pass:
/// the first surface or medium that stores photons. In `hybrid`, this light excludes the indirect
/// light of caustics, because photon estimates always carry that light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum IndirectTechnique<'a> {
    /// Camera paths find all indirect light that does not come from caustics: they continue beyond
    /// their first receiver, the surface or medium that stores photons.
    #[default]
    Paths,
    /// Photon density estimates at the first receiver (surface or medium that stores photons) find
    /// all indirect light, so camera paths end there.
    Photons,
    /// Camera paths and photon estimates, both with weight 1. A pilot (small simulation before the
    /// first pass) uses this to compare the two techniques.
    Comparison,
    /// Camera paths and photon estimates share the indirect light, with weights that sum to 1.
    Weighted {
        division: &'a IndirectDivision,
        /// Number of the pass, counted from 1.
        pass_count: f32,
        /// Area of gather discs in this pass, divided by the area in the first pass.
        relative_disc_area: f32,
    },
}

impl IndirectTechnique<'_> {
    /// Returns the weight in \[0, 1] of photon estimates for indirect light, as a mean over the
    /// film. Camera paths have the rest, except in a pilot that compares both techniques.
    pub fn mean_photon_weight(&self) -> f64 {
        match self {
            Self::Paths => 0.0,
            Self::Photons | Self::Comparison => 1.0,
            Self::Weighted { division, pass_count, relative_disc_area: area } => {
                division.mean_photon_weight(*pass_count, *area)
            }
        }
    }

    /// Returns the weights of camera paths and of photon estimates for the indirect light at a film
    /// position \[pixels from the top left].
    #[inline]
    pub fn technique_weights(&self, film_position: Vec2) -> IndirectWeights {
        match self {
            Self::Paths => IndirectWeights::default(),
            Self::Photons => IndirectWeights { photon_weight: 1.0, continued_paths: 0, samples_per_pixel: 1 },
            Self::Comparison => IndirectWeights::COMPARISON,
            Self::Weighted { division, pass_count, relative_disc_area: area } => {
                division.technique_weights(film_position, *pass_count, *area)
            }
        }
    }
}

impl IndirectWeights {
    /// Weight 1 both for camera paths and for photon estimates, so that indirect light counts
    /// twice. A pilot (small simulation before the first pass) uses it to compare the two.
    const COMPARISON: Self = Self { photon_weight: 1.0, continued_paths: u32::MAX, samples_per_pixel: u32::MAX };

    /// True if camera path number `index` of the `count` paths of a pixel continues beyond its
    /// first receiver (surface or medium that stores photons). The paths with an `index` below
    /// `continued_paths` continue.
    ///
    /// If `count` is 1, as in a pilot, the path instead continues with the probability
    /// `continued_paths`/`samples_per_pixel`, by the random number `u` in \[0, 1).
    #[inline]
    pub fn continues_at_receiver(&self, (index, count): (u32, u32), u: f32) -> bool {
        if count == 1 {
            u * (self.samples_per_pixel as f32) < self.continued_paths as f32
        } else {
            index < self.continued_paths
        }
    }

    /// Returns the factor on the indirect light of each camera path that continues beyond its first
    /// receiver (surface or medium that stores photons), if `count` paths of the pixel are traced.
    /// The factor is the weight of camera paths, times `count`, divided by the number of continued
    /// paths.
    ///
    /// If `count` is 1, as in a pilot, the single path stands for `samples_per_pixel` paths. In a
    /// pilot that compares both techniques, the factor is 1.
    #[inline]
    pub fn continued_path_factor(&self, count: u32) -> f32 {
        if *self == Self::COMPARISON {
            return 1.0;
        }
        let count = if count == 1 { self.samples_per_pixel } else { count };
        (1.0 - self.photon_weight) * count as f32 / self.continued_paths.min(count).max(1) as f32
    }
}

impl RelativeIndirectErrors {
    /// Returns the weights of camera paths and of photon estimates, and the number of continued
    /// camera paths. They minimize the error of indirect light plus
    /// [`IndirectDivision::path_price`] times the number of continued paths. The photon weight is 0
    /// if the pilot measured no error for one of the two techniques, because that technique found
    /// no light.
    ///
    /// `pass_count` is the number of passes up to this one. `area` is the area of gather discs in
    /// this pass, divided by the area in the first pass.
    #[inline]
    fn least_error_weights(&self, division: &IndirectDivision, pass_count: f32, area: f32) -> IndirectWeights {
        let samples = division.samples_per_pixel;
        let photons = self.photon_mean_squared_error(division.unaimed_paths, pass_count, area);
        let paths = self.single_path_variance;
        if photons <= 0.0 || paths <= 0.0 {
            // The pilot found no light by one of the techniques.
            return IndirectWeights::default();
        }
        // Let `photons` be the error of the photon estimate, and `paths` the error of one continued
        // path. With n continued paths, the combined error is 1/(1/photons + n/paths). Its
        // derivative by n is −error²/paths.
        let wanted = (paths / division.path_price).sqrt() - paths / photons;
        let continued = wanted.clamp(0.0, samples as f32).round();
        let error = paths / continued.max(f32::MIN_POSITIVE);
        let weight = if continued == 0.0 { 1.0 } else { error / (error + photons) };
        IndirectWeights { photon_weight: weight, continued_paths: continued as u32, samples_per_pixel: samples }
    }

    /// Returns the relative mean squared error of the photon estimate in the last of `pass_count`
    /// passes.
    ///
    /// `photon_paths` is the number of photon paths per pass that lights emit in all directions.
    /// `area` is the area of gather discs in the last pass, divided by the area in the first pass.
    /// The squared bias counts `pass_count` times, because the mean of all passes has less variance
    /// but the same bias.
    #[inline]
    fn photon_mean_squared_error(&self, photon_paths: u32, pass_count: f32, area: f32) -> f32 {
        self.single_photon_path_variance / (photon_paths as f32 * area) + pass_count * self.squared_bias * area * area
    }
}

impl IndirectDivision {
    /// Returns the weights of camera paths and of photon estimates at a film position \[pixels from
    /// the top left] in the last of `pass_count` passes. `area` is the area of the gather discs of
    /// this pass, divided by the area in the first pass.
    #[inline]
    fn technique_weights(&self, film_position: Vec2, pass_count: f32, area: f32) -> IndirectWeights {
        self.interpolated_errors(film_position).least_error_weights(self, pass_count, area)
    }

    /// Returns the errors of camera paths and of photon estimates for indirect light at a film
    /// position \[pixels from the top left], interpolated between cells of the film grid.
    #[inline]
    fn interpolated_errors(&self, film_position: Vec2) -> RelativeIndirectErrors {
        let rows = self.cells.len() as u32 / self.columns;
        let last = Vec2::new((self.columns - 1) as f32, (rows - 1) as f32);
        let place = (film_position / self.cell_size - 0.5).clamp(Vec2::ZERO, last);
        let (corner, part) = (place.floor(), place - place.floor());
        let cell = |x: f32, y: f32| &self.cells[(y.min(last.y) * self.columns as f32 + x.min(last.x)) as usize];
        let corners = [
            (cell(corner.x, corner.y), (1.0 - part.x) * (1.0 - part.y)),
            (cell(corner.x + 1.0, corner.y), part.x * (1.0 - part.y)),
            (cell(corner.x, corner.y + 1.0), (1.0 - part.x) * part.y),
            (cell(corner.x + 1.0, corner.y + 1.0), part.x * part.y),
        ];
        let mean = |value: fn(&RelativeIndirectErrors) -> f32| corners.iter().map(|(c, w)| value(c) * w).sum::<f32>();
        RelativeIndirectErrors {
            single_path_variance: mean(|c| c.single_path_variance),
            single_photon_path_variance: mean(|c| c.single_photon_path_variance),
            squared_bias: mean(|c| c.squared_bias),
        }
    }

    /// Returns the weight in \[0, 1] of photon estimates in the last of `pass_count` passes, as a
    /// mean over all cells of the film grid. `area` is the area of the gather discs of this pass,
    /// divided by the area in the first pass.
    fn mean_photon_weight(&self, pass_count: f32, area: f32) -> f64 {
        let weights =
            self.cells.iter().map(|cell| f64::from(cell.least_error_weights(self, pass_count, area).photon_weight));
        weights.sum::<f64>() / self.cells.len().max(1) as f64
    }

    /// Returns two means over all cells of the film grid: the relative squared error of indirect
    /// light in a pass, and the number of continued camera paths per pixel.
    ///
    /// `pass_count` is the number of passes up to this one. `area` is the area of gather discs in
    /// this pass, divided by the area in the first pass. The squared bias counts `pass_count`
    /// times, because the mean of all passes has less variance but the same bias.
    pub fn mean_error_and_paths(&self, pass_count: f32, area: f32) -> (f64, f64) {
        let mut sums = (0.0, 0.0);
        for cell in &self.cells {
            let weights = cell.least_error_weights(self, pass_count, area);
            let error = if weights.photon_weight > 0.0 {
                weights.photon_weight * cell.photon_mean_squared_error(self.unaimed_paths, pass_count, area)
            } else {
                cell.single_path_variance / self.samples_per_pixel as f32
            };
            let continued = if weights.photon_weight > 0.0 { weights.continued_paths } else { self.samples_per_pixel };
            sums = (sums.0 + f64::from(error), sums.1 + f64::from(continued));
        }
        let cells = self.cells.len().max(1) as f64;
        (sums.0 / cells, sums.1 / cells)
    }
}

#[cfg(test)]
mod tests;
