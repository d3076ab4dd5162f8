//! Camera paths through chosen points of the film, for pilots.

use super::camera_path::{PathContext, PathState, radiance};
use super::worker::PathWorker;
use crate::color::Rgb;
use crate::plan::Effect;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Interior, for_interior};
use glam::Vec2;
use rayon::prelude::*;

/// Number of film points per parallel task.
const CHUNK: usize = 64;

/// A film position \[pixels from the top left], with the sampler of its camera path.
pub(super) type FilmPoint = (Vec2, Sampler);

/// Traces camera paths through `points` of the film.
///
/// Returns the radiance at each point \[W/(m² sr)], and the workers with their ray counts and
/// visible points.
pub(super) fn trace_camera_paths_through(paths: &PathContext<'_>, points: &[FilmPoint]) -> (Vec<Rgb>, Vec<PathWorker>) {
    for_interior!(paths.policy.effects, <I> trace_camera_paths_with_interior::<I>(paths, points))
}

fn trace_camera_paths_with_interior<I: Interior>(
    paths: &PathContext<'_>,
    points: &[FilmPoint],
) -> (Vec<Rgb>, Vec<PathWorker>) {
    let has_lens = paths.policy.effects.has(Effect::Lens);
    let chunks = points.par_chunks(CHUNK).map(|chunk| {
        let (mut worker, mut stack) = (PathWorker::default(), Vec::<PathState<I>>::new());
        let values = chunk.iter().map(|(film, sampler)| {
            worker.counters.camera_rays += 1;
            let lens = has_lens.then(|| sampler.get_2d(Dimension::Lens));
            radiance(paths, &paths.scene.camera().generate_ray(*film, lens), *sampler, &mut worker, &mut stack)
        });
        (values.collect::<Vec<Rgb>>(), worker)
    });
    let (radiance, workers): (Vec<Vec<Rgb>>, Vec<PathWorker>) = chunks.collect::<Vec<_>>().into_iter().unzip();
    (radiance.concat(), workers)
}
