//! Camera paths through chosen points of the film, for pilots (small simulations before a render).

use super::camera_path::{PathContext, PathState, trace_camera_path};
use super::camera_ray::CameraRay;
use super::path_task::PathTask;
use super::prefix_rays::PrefixWeights;
use crate::color::Rgb;
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effect, Scene, with_interior_type};
use crate::stats::Counters;
use glam::Vec2;
use rayon::prelude::*;

/// Number of film points that [`generate_film_points`] spreads over the picture.
pub(super) const FILM_POINT_COUNT: u32 = 1024;

/// Number of film points per parallel task.
const CHUNK: usize = 64;

/// A film position \[pixels from the top left], with the sampler of its camera path.
pub(super) type FilmPoint = (Vec2, Sampler);

/// Returns 1024 film points that are spread evenly over the picture of `scene`, each with the
/// sampler of its camera path.
///
/// Points with the same index in two different `set`s lie at independent positions of the same
/// pixel. So the difference of their radiances shows the noise of camera paths.
pub(super) fn generate_film_points(scene: &Scene, key: Key, set: u32) -> Vec<FilmPoint> {
    let (width, height) = scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let key = key.purpose_key(Purpose::CameraPaths);
    let point = |i| {
        let pixel = (Sampler::new(key, i, FILM_POINT_COUNT).get_2d(Dimension::Film) * size).floor();
        let sampler = Sampler::new(key.film_point_key(set, i), 0, 1);
        (pixel + sampler.get_2d(Dimension::Film), sampler)
    };
    (0..FILM_POINT_COUNT).map(point).collect()
}

/// Traces a camera path through each of `points`.
///
/// Returns the radiance at each point \[W/(m² sr)], and the parallel tasks that traced the paths.
/// The tasks hold the ray counts, and the records that paths make for pilots, such as visible
/// points.
pub(super) fn trace_paths_through_film_points(
    paths: &PathContext<'_>,
    points: &[FilmPoint],
) -> (Vec<Rgb>, Vec<PathTask>) {
    trace_paths_by_chunks(paths, points, false, &|radiance, _| radiance)
}

/// Traces a camera path through each of `points`, and calls `result` with the path's radiance
/// \[W/(m² sr)] and the task that traced the path.
///
/// Returns the values of `result`, and the ray counts of all paths. If `repeats_in_nested_discs` is
/// true, each photon estimate is repeated in smaller discs with the same center, to measure its
/// bias.
pub(super) fn map_paths_through_film_points<T: Send>(
    paths: &PathContext<'_>,
    points: &[FilmPoint],
    repeats_in_nested_discs: bool,
    result: impl Fn(Rgb, &mut PathTask) -> T + Sync,
) -> (Vec<T>, Counters) {
    let (results, tasks) = trace_paths_by_chunks(paths, points, repeats_in_nested_discs, &result);
    let mut counters = Counters::default();
    tasks.iter().for_each(|task| counters += task.counters);
    (results, counters)
}

/// Traces a camera path through each of `points`. Each parallel task traces at most 64 of them.
///
/// Returns the value of `result` for each path, and the final state of each task, with its ray
/// counts and records for pilots. If `repeats_in_nested_discs` is true, each photon estimate is
/// repeated in smaller discs with the same center.
fn trace_paths_by_chunks<T: Send>(
    paths: &PathContext<'_>,
    points: &[FilmPoint],
    repeats_in_nested_discs: bool,
    result: &(impl Fn(Rgb, &mut PathTask) -> T + Sync),
) -> (Vec<T>, Vec<PathTask>) {
    let has_lens = paths.policy.effects.has(Effect::Lens);
    with_interior_type!(paths.policy.effects, <I> {
        let chunks = points.par_chunks(CHUNK).map(|chunk| {
            let mut task = PathTask::new(repeats_in_nested_discs, false);
            let mut stack = Vec::<PathState<I>>::new();
            let values = chunk.iter().map(|(film, sampler)| {
                task.counters.camera_rays += 1;
                let lens = has_lens.then(|| sampler.get_2d(Dimension::Lens));
                let ray = paths.scene.camera().generate_ray(*film, lens);
                let camera_ray = CameraRay {
                    ray,
                    sampler: *sampler,
                    weight_lookup_position: *film,
                    shutter_slice: 0,
                    prefix_weights: PrefixWeights::default(),
                };
                let radiance = trace_camera_path(paths, &camera_ray, &mut task, &mut stack);
                result(radiance, &mut task)
            });
            (values.collect::<Vec<T>>(), task)
        });
        let (results, tasks): (Vec<Vec<T>>, Vec<PathTask>) = chunks.collect::<Vec<_>>().into_iter().unzip();
        (results.into_iter().flatten().collect(), tasks)
    })
}
