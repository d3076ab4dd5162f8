//! Pilot (small simulation before the first pass) that divides indirect light between camera paths
//! and photon estimates.
//!
//! The pilot traces camera paths through each cell of a grid over the film. For each path, both
//! techniques find all indirect light that does not come from caustics: the continued path, and a
//! photon estimate at the path's first *receiver*, a surface or medium that stores photons. A
//! second trial uses independent random numbers. The differences between the two trials measure the
//! variance of each technique.
//!
//! The bias of a photon estimate is proportional to the area of its disc. So twice the difference
//! from an estimate with half the area measures the bias. Each trial measures it independently, and
//! the product of both values is an unbiased estimate of the squared bias.
//!
//! No pass uses photons or rays of the pilot, so the mean of the passes stays unbiased.

use super::balance;
use super::film_points::{FilmPoint, map_paths_through_film_points};
use super::indirect_division::{IndirectDivision, IndirectTechnique, RelativeIndirectErrors};
use super::map_builder::MapBuildOptions;
use super::pass::{PassResult, SilentMonitor};
use super::pass_renderer::PassRenderer;
use super::path_task::{LightByPart, PathTask};
use super::photon_maps::PhotonMaps;
use crate::color::{self, Rgb};
use crate::math::{positive_median, square_mean};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::stats::Counters;
use glam::Vec2;

/// Number of cells of the film grid along the longer side of the film. The indirect-light pilot
/// measures variance and bias in each cell.
const CELLS_ALONG_LONGER_SIDE: u32 = 24;

/// Number of camera paths through each cell of the film grid, in each of the indirect-light pilot's
/// two trials.
const CELL_POINTS: u32 = 16;

/// Smallest ratio of the photon paths of a pass to those of one trial: each of the indirect-light
/// pilot's two trials traces at most 1/8 of the paths of a pass.
const MIN_PASS_TO_TRIAL_PATH_RATIO: u32 = 8;

/// Largest number of photon paths in each of the indirect-light pilot's two trials.
const MAX_PHOTON_PATHS: u32 = 1 << 17;

/// Assumed number of passes of a render. The indirect-light pilot minimizes mean squared error
/// times work after this many passes.
const TYPICAL_PASS_COUNT: u32 = 4;

/// Largest number of passes in which photon estimates carry a part of the indirect light.
const MAX_PASSES_WITH_PHOTONS: u32 = 1 << 16;

/// Largest acceptable ratio of two costs: with photon estimates of indirect light, and with camera
/// paths alone. The cost is mean squared error times work. Above this ratio, passes use camera
/// paths alone.
const MAX_RELATIVE_COST: f64 = 0.8;

/// Candidate numbers of photon paths per pass, divided by the number in the settings. The
/// indirect-light pilot chooses the candidate with the least mean squared error times work.
const PHOTON_PATH_FRACTIONS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Stride through the film points when the indirect-light pilot measures work: it uses every eighth
/// point.
const WORK_STEP: usize = 8;

/// Number of iterations of the search for [`IndirectDivision::path_price`].
const SEARCH_STEPS: u32 = 12;

/// Estimated time to find one photon of the interreflection map for a density estimate and to add
/// its light, divided by the time to trace one photon ray.
const LOOKUP_PHOTON_WORK: f64 = 0.3;

/// Fraction of a cell's indirect light, as camera paths find it, that photon estimates may miss. If
/// they miss more, the cell has too few photons to measure the variance of the estimates. The pilot
/// then assumes a variance of at least [`ASSUMED_VARIANCE_IN_MEDIA`], or 1 without scattering
/// media.
const MAX_MISSED_FRACTION: f64 = 0.9;

/// Lower bound on the relative variance of photon estimates that miss more than
/// [`MAX_MISSED_FRACTION`] of a cell's indirect light, in scenes with scattering media. The
/// indirect-light pilot cannot measure this variance.
///
/// In thick media, photons near the camera may be rare, but each then carries much flux, so the
/// variance is large.
const ASSUMED_VARIANCE_IN_MEDIA: f64 = 1e4;

/// Factor from a difference of two density estimates to the bias: bias = 2 (E(A) − E(A/2)), where
/// E(A) is the estimate with disc area A. This holds because the bias is proportional to A.
const BIAS_FACTOR: f64 = 2.0;

/// Light that one camera path finds in one of the pilot's two trials, averaged over RGB \[W/(m²
/// sr)]. Its indirect light is estimated twice: by the path, and by photons.
///
/// *Receiver*: a surface or medium that stores photons.
#[derive(Clone, Copy, Debug, Default)]
struct TrialPathLight {
    /// Direct light at the first receiver (surface or medium that stores photons).
    direct: f64,
    /// Emission that the path finds before its first receiver (surface or medium that stores
    /// photons), plus the photon estimates there of caustics and of the indirect light of caustics.
    /// The indirect-light pilot ignores the noise of this light, because other pilots reduce it.
    emission_and_caustics: f64,
    /// Indirect light that the camera path finds by continuing beyond its first receiver (surface
    /// or medium that stores photons).
    path_indirect: f64,
    /// Indirect light that the photon estimate finds at the first receiver (surface or medium that
    /// stores photons).
    photon_indirect: f64,
    /// Noisy estimate of the bias of `photon_indirect` \[W/(m² sr)].
    bias: f64,
}

/// Work of the parts of a pass, in units of tracing one photon ray, and the variance of its direct
/// light.
///
/// *Receiver*: a surface or medium that stores photons.
#[derive(Clone, Copy, Debug, Default)]
struct PassCost {
    /// Relative variance of the direct light that one camera path finds at its first receiver
    /// (surface or medium that stores photons).
    direct_variance: f64,
    /// Work of one camera path up to its first receiver (surface or medium that stores photons), in
    /// units of tracing one photon ray.
    prefix_work: f64,
    /// Work of one camera path beyond its first receiver (surface or medium that stores photons),
    /// in units of tracing one photon ray.
    continuation_work: f64,
    /// Work per pixel of tracing, storing and gathering the photons of a pass, in units of tracing
    /// one photon ray.
    photon_work: f64,
    /// Fixed work of one photon estimate, in units of tracing one photon ray. `photon_work` holds
    /// the further work for each photon that the estimate uses.
    lookup_work: f64,
}

/// Runs the indirect-light pilot. Divides indirect light between camera paths and photon estimates
/// such that mean squared error times work is least. Returns this division; `None` if camera paths
/// alone are about as good.
pub(super) fn divide_indirect_light(renderer: &PassRenderer<'_>) -> Option<IndirectDivision> {
    let unaimed_paths = renderer.map_builder.counts.unaimed;
    let mut pilot = renderer.with_one_sample();
    pilot.map_builder.compares_techniques = true;
    let divisor = unaimed_paths.div_ceil(MAX_PHOTON_PATHS).max(MIN_PASS_TO_TRIAL_PATH_RATIO);
    let (cell_size, grid) = film_grid(renderer.scene.camera().size());
    let points = |trial: u32| -> Vec<FilmPoint> {
        let key = pilot_key(&pilot).pilot_trial_key(trial).purpose_key(Purpose::CameraPaths);
        let cell_points = |cell: u32| {
            let corner = Vec2::new((cell % grid.0) as f32, (cell / grid.0) as f32) * cell_size;
            let key = key.film_point_key(0, cell);
            (0..CELL_POINTS).map(move |i| {
                let sampler = Sampler::new(key, i, CELL_POINTS);
                (corner + sampler.get_2d(Dimension::Film) * cell_size, Sampler::new(sampler.sample_key(), 0, 1))
            })
        };
        (0..grid.0 * grid.1).flat_map(cell_points).collect()
    };

    // Trace both trials.
    let (trial, other_trial) = (PilotTrial::new(&pilot, 0, divisor), PilotTrial::new(&pilot, 1, divisor));
    let (film_points, other_film_points) = (points(0), points(1));
    let (light, counters) = trial.trace_paths(&pilot, &film_points, IndirectTechnique::Comparison);
    let (other_light, _) = other_trial.trace_paths(&pilot, &other_film_points, IndirectTechnique::Comparison);
    let trial_photons = f64::from(unaimed_paths) / f64::from(divisor);
    let assumed_variance =
        if pilot.scene.media_in_use().iter().any(|medium| medium.scatters()) { ASSUMED_VARIANCE_IN_MEDIA } else { 1.0 };
    let (cells, direct_variance) = cell_errors(&light, &other_light, grid.0, trial_photons, assumed_variance)?;

    // Measure the work of each part of a pass.
    let work = trial.measure_work(&pilot, &film_points, &counters);
    let paths = light.len() as f64;
    let (width, height) = renderer.scene.camera().size();
    let pixels = f64::from(width) * f64::from(height);
    let cost = PassCost {
        direct_variance,
        prefix_work: work.prefix_work / paths,
        continuation_work: ((work.path_work - work.prefix_work) / paths).max(1.0),
        photon_work: f64::from(divisor) * (work.photon_work / pixels + work.gathering_work / paths),
        lookup_work: balance::LOOKUP_WORK,
    };
    let division = IndirectDivision {
        columns: grid.0,
        cells,
        cell_size,
        samples_per_pixel: renderer.samples_per_pixel,
        unaimed_paths,
        path_price: 0.0,
        passes_with_photons: MAX_PASSES_WITH_PHOTONS,
    };
    let path_fractions = if renderer.settings.allows_ray_photon_balance {
        &PHOTON_PATH_FRACTIONS[..]
    } else {
        &PHOTON_PATH_FRACTIONS[..1]
    };
    least_cost_division(&division, path_fractions, &cost, |pass| renderer.map_builder.relative_disc_area(pass))
}

/// Returns the random key of the indirect-light pilot.
fn pilot_key(pilot: &PassRenderer<'_>) -> Key {
    Key::new(pilot.settings.camera_paths.seed).purpose_key(Purpose::IndirectDivision)
}

/// Returns the edge length of a cell of the film grid \[pixels], and the grid's numbers of columns
/// and rows.
fn film_grid((width, height): (u32, u32)) -> (f32, (u32, u32)) {
    let size = (width.max(height) as f32 / CELLS_ALONG_LONGER_SIDE as f32).max(1.0);
    let cells = |pixels: u32| ((pixels as f32 / size).ceil() as u32).max(1);
    (size, (cells(width), cells(height)))
}

/// Work of the parts of one trial of the indirect-light pilot, in units of tracing one photon ray.
/// Each value is a sum over the whole trial.
struct TrialWork {
    /// Work of all camera paths of one pilot trial, in units of tracing one photon ray.
    path_work: f64,
    /// Work of all camera paths of one pilot trial up to their first receiver (surface or medium
    /// that stores photons), in units of tracing one photon ray.
    prefix_work: f64,
    /// Work of tracing and storing the photons of one pilot trial's interreflection map, from which
    /// the photon estimates come, in units of tracing one photon ray.
    photon_work: f64,
    /// Work of gathering the photons of one pilot trial's interreflection map, from which the
    /// photon estimates come, in units of tracing one photon ray.
    gathering_work: f64,
}

/// One of the indirect-light pilot's two independent trials. A trial has its own photon maps, and a
/// report on the photons in them.
struct PilotTrial<'a> {
    maps: PhotonMaps<'a>,
    report: PassResult,
}

impl<'a> PilotTrial<'a> {
    /// Builds the photon maps of trial number `trial`, 0 or 1, from 1/`divisor` of the photon paths
    /// of a pass.
    fn new(pilot: &PassRenderer<'a>, trial: u32, divisor: u32) -> Self {
        let key = pilot_key(pilot).pilot_trial_key(trial);
        let options = MapBuildOptions::for_pilot(key, divisor);
        let mut report = PassResult::default();
        let maps = pilot.map_builder.build(&options, &SilentMonitor, &mut report);
        Self { maps, report }
    }

    /// Traces camera paths through `points`, with `technique` for indirect light. Returns the light
    /// of each path, and the counters of all paths.
    fn trace_paths(
        &self,
        pilot: &PassRenderer<'_>,
        points: &[FilmPoint],
        technique: IndirectTechnique<'_>,
    ) -> (Vec<TrialPathLight>, Counters) {
        let repeats_in_nested_discs = matches!(technique, IndirectTechnique::Comparison);
        let paths = pilot.path_context(Some(&self.maps), 0).with_technique(technique);
        map_paths_through_film_points(&paths, points, repeats_in_nested_discs, TrialPathLight::from_path_sums)
    }

    /// Returns the work of the camera paths through `points`, and the work of the photons of the
    /// interreflection map, from which the photon estimates come.
    ///
    /// `both` holds the counters of a run in which both camera paths and photon estimates found the
    /// indirect light ([`IndirectTechnique::Comparison`]).
    fn measure_work(&self, pilot: &PassRenderer<'_>, points: &[FilmPoint], both: &Counters) -> TrialWork {
        let some_points: Vec<FilmPoint> = points.iter().step_by(WORK_STEP).copied().collect();
        let (_, paths_only) = self.trace_paths(pilot, &some_points, IndirectTechnique::Paths);
        let (_, prefixes) = self.trace_paths(pilot, &some_points, IndirectTechnique::Photons);
        let scale = points.len() as f64 / some_points.len().max(1) as f64;
        let PassResult { aimed, unaimed, counters, .. } = &self.report;
        let rays_per_path = counters.photon_rays as f64 / (unaimed.emitted_paths + aimed.emitted_paths).max(1) as f64;
        TrialWork {
            path_work: balance::camera_path_work(both),
            prefix_work: scale * balance::camera_path_work(&prefixes),
            photon_work: rays_per_path * unaimed.emitted_paths as f64
                + balance::photon_storage_work(unaimed.stored_photons),
            gathering_work: LOOKUP_PHOTON_WORK
                * (both.gathered_photons as f64 - scale * paths_only.gathered_photons as f64).max(0.0),
        }
    }
}

impl TrialPathLight {
    /// Splits the `radiance` of a camera path into the parts of [`TrialPathLight`]. Takes the parts
    /// that `task` has recorded along the path, and resets these records.
    fn from_path_sums(radiance: Rgb, task: &mut PathTask) -> Self {
        let LightByPart {
            up_to_receiver,
            photon_estimates,
            indirect_by_paths,
            indirect_by_photons,
            indirect_nested_difference,
        } = std::mem::take(&mut task.records.light);
        let parts = [radiance, up_to_receiver, photon_estimates, indirect_by_paths, indirect_by_photons];
        let [total, up_to_receiver, all_photons, paths, photons] = parts.map(|v| f64::from(color::channel_mean(v)));
        let step = f64::from(color::channel_mean(indirect_nested_difference));
        Self {
            direct: total - up_to_receiver - all_photons - paths,
            emission_and_caustics: up_to_receiver + all_photons - photons,
            path_indirect: paths,
            photon_indirect: photons,
            bias: BIAS_FACTOR * step,
        }
    }
}

/// Returns the relative errors of camera paths and of photon estimates in each cell, and the mean
/// relative variance of the direct light of a camera path; `None` if all is black.
///
/// Variances and squared biases are divided by L² + L̃²/100. L is the light of the cell, and L̃ is
/// the median of L over all cells. The mean variance of direct light leaves out the noisiest 5 % of
/// the cells.
///
/// `first_trial` and `second_trial` hold the light of the paths of both trials. `paths` is the
/// number of photon paths of a trial. `assumed_variance` is a lower bound on the variance of photon
/// estimates in cells where they miss more than 90 % of the indirect light that camera paths find.
/// It is relative to the square of that light. If they miss more than half of it, the bound is 1.
fn cell_errors(
    first_trial: &[TrialPathLight],
    second_trial: &[TrialPathLight],
    columns: u32,
    paths: f64,
    assumed_variance: f64,
) -> Option<(Vec<RelativeIndirectErrors>, f64)> {
    let size = CELL_POINTS as usize;
    let light = |p: &TrialPathLight| p.direct + p.emission_and_caustics + 0.5 * (p.path_indirect + p.photon_indirect);
    let cells: Vec<(&[TrialPathLight], &[TrialPathLight])> =
        first_trial.chunks(size).zip(second_trial.chunks(size)).collect();
    let cell_light: Vec<f64> =
        cells.iter().map(|(a, b)| a.iter().chain(*b).map(light).sum::<f64>() / (2 * size) as f64).collect();
    let median = positive_median(cell_light.iter().copied())?;
    // Compute six values for each cell, relative to its light or to the square of its light. They
    // are the variances of direct light, of paths and of photons, the squared bias, and the mean
    // light that each technique finds.
    let raw: Vec<[f64; 6]> = cells
        .iter()
        .zip(&cell_light)
        .map(|((a, b), light)| {
            let scale = 1.0 / (light * light + 0.01 * median * median) / size as f64;
            let mut sums = [0.0; 6];
            for (a, b) in a.iter().zip(*b) {
                let half = |a: f64, b: f64| 0.5 * (a - b) * (a - b);
                sums[0] += half(a.direct, b.direct) * scale;
                sums[1] += half(a.path_indirect, b.path_indirect) * scale;
                sums[2] += half(a.photon_indirect, b.photon_indirect) * scale;
                sums[3] += a.bias * b.bias * scale;
                sums[4] += 0.5 * (a.path_indirect + b.path_indirect) * (scale / size as f64).sqrt();
                sums[5] += 0.5 * (a.photon_indirect + b.photon_indirect) * (scale / size as f64).sqrt();
            }
            sums
        })
        .collect();
    let grid = (columns as usize, cells.len() / columns as usize);
    // Average over neighbouring cells to reduce noise.
    let smoothed = |i: usize, value: usize| square_mean(|i| raw[i][value], i, 1, grid);
    let errors = |i: usize| {
        let (by_paths, by_photons) = (smoothed(i, 4), smoothed(i, 5));
        // Bound the variance of the photon estimate from below if the pilot has too few photons to
        // measure it.
        let missed = (by_paths - by_photons).max(0.0);
        let relative_variance = if missed > MAX_MISSED_FRACTION * by_paths {
            assumed_variance
        } else if missed > 0.5 * by_paths {
            1.0
        } else {
            0.0
        };
        let least_variance = relative_variance * by_paths * by_paths;
        RelativeIndirectErrors {
            single_path_variance: smoothed(i, 1) as f32,
            single_photon_path_variance: (smoothed(i, 2).max(least_variance) * paths) as f32,
            squared_bias: smoothed(i, 3).max(0.0) as f32,
        }
    };
    let mut direct: Vec<f64> = raw.iter().map(|sums| sums[0]).collect();
    // Leave out the noisiest 5 % of the cells, because rare bright light in one cell says nothing
    // about the others.
    direct.sort_by(f64::total_cmp);
    let kept = direct.len() - direct.len() / 20;
    let direct = direct[..kept].iter().sum::<f64>() / kept as f64;
    Some(((0..cells.len()).map(errors).collect(), direct))
}

/// Chooses the number of photon paths, the number of passes with photon estimates, and
/// [`IndirectDivision::path_price`], such that mean squared error times work is least. Returns a
/// copy of `division` with these values; `None` if camera paths alone are about as good.
///
/// `path_fractions` are the candidate numbers of photon paths, divided by the number in `division`.
/// `area` is a function from the number of a pass, counted from 0, to the area of gather discs in
/// that pass, divided by the area in the first pass.
fn least_cost_division(
    division: &IndirectDivision,
    path_fractions: &[f64],
    cost: &PassCost,
    area: impl Fn(u32) -> f64,
) -> Option<IndirectDivision> {
    let n = f64::from(division.samples_per_pixel);
    let cells = division.cells.len().max(1) as f64;
    let path_variance = division.cells.iter().map(|c| f64::from(c.single_path_variance)).sum::<f64>() / cells;
    let paths_only_cost = (cost.direct_variance + path_variance) * (cost.prefix_work + cost.continuation_work);
    let error_and_work = |division: &IndirectDivision, part: f64, pass_count: u32| {
        let (error, paths) = division.mean_error_and_paths(pass_count as f32, area(pass_count - 1) as f32);
        let work = n * cost.prefix_work + paths * cost.continuation_work + part * cost.photon_work + cost.lookup_work;
        (cost.direct_variance / n + error, work)
    };
    let with_best_price = |part: f64| {
        let unaimed_paths = (f64::from(division.unaimed_paths) * part).max(1.0) as u32;
        let mut division =
            IndirectDivision { unaimed_paths, path_price: (path_variance / (n * n)) as f32, ..division.clone() };
        for _ in 0..SEARCH_STEPS {
            let (error, work) = error_and_work(&division, part, TYPICAL_PASS_COUNT);
            division.path_price = (error / work * cost.continuation_work) as f32;
        }
        (division, part)
    };
    let product = |(division, part): &(IndirectDivision, f64), pass_count: u32| {
        let (error, work) = error_and_work(division, *part, pass_count);
        error * work
    };
    let best = path_fractions
        .iter()
        .map(|part| with_best_price(*part))
        .min_by(|a, b| product(a, TYPICAL_PASS_COUNT).total_cmp(&product(b, TYPICAL_PASS_COUNT)))?;
    let pays = |pass_count: u32| product(&best, pass_count) < MAX_RELATIVE_COST * paths_only_cost;
    if !pays(1) {
        return None;
    }
    // Bisect for the last pass in which photons pay: the product of error and work grows from pass
    // to pass.
    let (mut passes, mut limit) = (1, MAX_PASSES_WITH_PHOTONS);
    while passes + 1 < limit {
        let middle = passes + (limit - passes) / 2;
        if pays(middle) { passes = middle } else { limit = middle }
    }
    Some(IndirectDivision { passes_with_photons: passes, ..best.0 })
}

#[cfg(test)]
mod tests;
