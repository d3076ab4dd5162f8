//! Comparison of images by tiles, with standard errors.

use super::methods::{Effort, Method, passes};
use crate::support::{STORED_COLOR_ROUNDING, student_t_tail};
use caustica::color::Rgb;
use caustica::scene::Scene;
use glam::DVec3;

/// False-alarm rate of one [`compare`], for all its tiles and channels together.
pub const RATE: f64 = 1e-5;

/// Partition of an image into square tiles.
pub struct Grid {
    pub width: usize,
    pub height: usize,
    /// Edge of a tile in pixels. Tiles at the right and lower edges may be smaller.
    pub edge: usize,
    /// True for each pixel that counts; empty if all pixels count.
    pub kept: Vec<bool>,
}

impl Grid {
    pub fn new((width, height): (u32, u32), edge: usize) -> Self {
        Self { width: width as usize, height: height as usize, edge, kept: Vec::new() }
    }

    /// Returns a grid with the whole image as one tile.
    pub fn single_window(&self) -> Self {
        Self { edge: self.width.max(self.height), kept: self.kept.clone(), ..*self }
    }

    /// Returns a grid with the given columns and rows as one tile.
    pub fn window(&self, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> Self {
        let at = |i: usize| (i % self.width, i / self.width);
        let kept = (0..self.width * self.height).map(|i| columns.contains(&at(i).0) && rows.contains(&at(i).1));
        Self { kept: kept.collect(), ..self.single_window() }
    }

    fn columns(&self) -> usize {
        self.width.div_ceil(self.edge)
    }

    /// Returns the sum and number of the kept pixels of each tile.
    pub fn window_sums(&self, pixels: impl Iterator<Item = DVec3>) -> Vec<(DVec3, f64)> {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.columns() * self.height.div_ceil(self.edge)];
        for (i, value) in pixels.enumerate().filter(|(i, _)| self.kept.is_empty() || self.kept[*i]) {
            let sum = &mut sums[i / self.width / self.edge * self.columns() + i % self.width / self.edge];
            *sum = (sum.0 + value, sum.1 + 1.0);
        }
        sums
    }

    fn window_means(&self, image: &[Rgb]) -> Vec<DVec3> {
        self.window_sums(image.iter().map(|v| v.as_dvec3())).iter().map(|(sum, n)| sum / n.max(1.0)).collect()
    }

    /// Returns the mean over each tile and its neighbours.
    fn around(&self, tiles: &[DVec3]) -> Vec<DVec3> {
        let (columns, rows) = (self.columns(), self.height.div_ceil(self.edge));
        let one = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            let near =
                (y.max(1) - 1..rows.min(y + 2)).flat_map(|v| (x.max(1) - 1..columns.min(x + 2)).map(move |u| (u, v)));
            let (sum, n) = near.fold((DVec3::ZERO, 0.0), |(s, n), (u, v)| (s + tiles[v * columns + u], n + 1.0));
            sum / n
        };
        (0..tiles.len()).map(one).collect()
    }
}

/// Means of the tiles of an image, with their uncertainty, by channel.
pub struct Estimate {
    pub mean: Vec<DVec3>,
    /// Variance of each tile's mean.
    pub variance: Vec<DVec3>,
    /// Allowed systematic error of each tile's mean.
    pub bias: Vec<DVec3>,
    /// Degrees of freedom of `variance`.
    pub dof: f64,
}

/// Images of independent passes of one integrator.
pub struct Renders {
    pub name: String,
    narrow: Vec<Vec<Rgb>>,
    /// Images of passes at twice the gather radius; empty for an unbiased integrator.
    wide: Vec<Vec<Rgb>>,
}

impl Renders {
    /// Renders `effort.passes` passes at the gather radius, and half as many at twice the radius.
    ///
    /// Photon density estimates of radius r have a bias proportional to r² in smooth light, and to
    /// r at edges. Doubling r adds three times the bias in the first case, and once the bias in the
    /// second. [`Estimate::bias`] is the whole difference between both radii, an upper bound in
    /// both cases.
    pub fn new(method: Method, scene: &Scene, effort: Effort) -> Self {
        let twice = Effort { passes: effort.passes.div_ceil(2), radius: 2.0 * effort.radius, ..effort };
        let wide = if method == Method::Path { Vec::new() } else { passes(method, scene, twice) };
        Self { name: format!("{method:?}"), narrow: passes(method, scene, effort), wide }
    }

    /// Returns images of independent passes without a bias.
    pub fn of_images(name: &str, images: Vec<Vec<Rgb>>) -> Self {
        Self { name: name.to_owned(), narrow: images, wide: Vec::new() }
    }

    pub fn over(&self, grid: &Grid) -> Estimate {
        let narrow = tiles(grid, &self.narrow);
        let (mean, mut variance) = statistics(grid, &narrow);
        let mut bias = vec![DVec3::ZERO; mean.len()];
        if !self.wide.is_empty() {
            // Passes at both radii share their random numbers, so their difference has little
            // noise.
            let wider = |(w, n): (Vec<DVec3>, &Vec<DVec3>)| w.iter().zip(n).map(|(w, n)| w - n).collect();
            let differences: Vec<Vec<DVec3>> = tiles(grid, &self.wide).into_iter().zip(&narrow).map(wider).collect();
            let (difference, noise) = statistics(grid, &differences);
            bias = difference.iter().map(|d| d.abs()).collect();
            variance.iter_mut().zip(noise).for_each(|(v, n)| *v += n);
        }
        Estimate { mean, variance, bias, dof: self.narrow.len() as f64 - 1.0 }
    }
}

fn tiles(grid: &Grid, images: &[Vec<Rgb>]) -> Vec<Vec<DVec3>> {
    images.iter().map(|image| grid.window_means(image)).collect()
}

/// Returns the mean of each tile over the passes, and the variance of this mean.
///
/// The variance is measured between passes. If paths find light only rarely, a tile without such a
/// path would report variance 0. So the variance of a tile is at least the mean variance of the
/// tiles around it. This is valid because noise varies smoothly over an image.
fn statistics(grid: &Grid, tiles: &[Vec<DVec3>]) -> (Vec<DVec3>, Vec<DVec3>) {
    let n = tiles.len() as f64;
    let count = tiles[0].len();
    let mean: Vec<DVec3> = (0..count).map(|i| tiles.iter().map(|t| t[i]).sum::<DVec3>() / n).collect();
    let square = |v: DVec3| v * v;
    let spread = |i: usize| tiles.iter().map(|t| square(t[i] - mean[i])).sum::<DVec3>() / (n * (n - 1.0));
    let own: Vec<DVec3> = (0..count).map(spread).collect();
    let around = grid.around(&own);
    let variance = own.iter().zip(around).map(|(own, around)| own.max(around)).collect();
    (mean, variance)
}

/// Fails if two estimates of one image differ by more than their biases and noise explain.
///
/// The false-alarm rate is [`RATE`] over all tiles and channels. Also fails if noise and bias of
/// the mean tile exceed `max_relative_error` times its mean, because such noise could hide an
/// error.
#[track_caller]
pub fn compare(what: &str, ours: &Estimate, theirs: &Estimate, max_relative_error: f64) {
    let dof = ours.dof.min(theirs.dof);
    let (mut worst, mut place, mut beyond) = (0.0f64, String::new(), 0);
    let (mut total_error, mut total_mean) = (0.0, 0.0);
    for i in 0..ours.mean.len() {
        for c in 0..3 {
            let (a, b) = (ours.mean[i][c], theirs.mean[i][c]);
            let sigma = (ours.variance[i][c] + theirs.variance[i][c]).sqrt();
            // The colors of stored photons are rounded.
            let allowed =
                ours.bias[i][c] + theirs.bias[i][c] + STORED_COLOR_ROUNDING * theirs.mean[i].element_sum() + 1e-12;
            let excess = ((a - b).abs() - allowed).max(0.0);
            let t = if excess == 0.0 { 0.0 } else { excess / sigma };
            beyond += u32::from((a - b).abs() > 2.0 * sigma);
            (total_error, total_mean) = (total_error + sigma + allowed, total_mean + b.abs());
            if t > worst {
                (worst, place) =
                    (t, format!("tile {i}, channel {c}: {a:.5e} against {b:.5e} ± {sigma:.1e} and {allowed:.1e}"));
            }
        }
    }
    let tests = 3.0 * ours.mean.len() as f64;
    let p = (student_t_tail(worst, dof) * tests).min(1.0);
    let sum = |e: &Estimate| e.mean.iter().map(|m| m.element_sum()).sum::<f64>();
    let line = format!(
        "{what}: {tests} numbers, ratio of sums {:.4}, {:.1} % beyond 2σ, error bar {:.2} %, worst t {worst:.1}, p of all {p:.1e}: {place}",
        sum(ours) / sum(theirs),
        100.0 * f64::from(beyond) / tests,
        100.0 * total_error / total_mean
    );
    eprintln!("{line}");
    assert!(p >= RATE, "{line}");
    assert!(total_error <= max_relative_error * total_mean, "too blunt: {line}");
}

/// Applies [`compare`] by tiles, with the limit `tiles` on noise, and to the whole image, with the
/// limit `whole`.
///
/// The comparison of whole images reveals smaller differences.
#[track_caller]
pub fn compare_renders(what: &str, ours: &Renders, theirs: &Renders, grid: &Grid, (tiles, whole): (f64, f64)) {
    let what = format!("{what}, {} against {}", ours.name, theirs.name);
    compare(&what, &ours.over(grid), &theirs.over(grid), tiles);
    let all = grid.single_window();
    compare(&format!("{what}, whole"), &ours.over(&all), &theirs.over(&all), whole);
}
