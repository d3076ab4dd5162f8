//! Pilot (small simulation before the first pass) that balances camera rays against photon paths.
//! It traces few camera rays and few photons, and measures the noise and work of each.

use super::balance::{self, NoiseSource, RayPhotonBalance};
use super::film_points::{FILM_POINT_COUNT, FilmPoint, generate_film_points, map_paths_through_film_points};
use super::map_builder::MapBuildOptions;
use super::pass::{PassResult, PhotonReport, SilentMonitor};
use super::pass_renderer::PassRenderer;
use super::photon_maps::PhotonMaps;
use crate::color::{self, Rgb};
use crate::sampling::{Key, Purpose};
use crate::scene::Scene;
use crate::stats::Counters;

/// Ratio of the photon paths of a pass to the photon paths that the ray-photon-balance pilot
/// traces.
const PHOTON_PATH_DIVISOR: u32 = 16;

/// Largest work of the camera rays of a pass, in units of tracing one photon ray. If the balanced
/// number of camera rays would take more, the ray-photon-balance pilot chooses fewer, but at least
/// [`MIN_SAMPLES_PER_PIXEL`] per pixel.
///
/// Renders estimate their error from at least four passes. The bound lets large pictures of complex
/// scenes make several passes within the default time limit on few cores. It does not change the
/// number of photon paths: fewer photons in each pass would mean larger gather radii.
const MAX_CAMERA_WORK: f64 = 6e7;

/// Smallest number of camera rays per pixel to which [`MAX_CAMERA_WORK`], the bound on their work,
/// may lower their number.
const MIN_SAMPLES_PER_PIXEL: f64 = 2.0;

/// Radiance at each film point of the ray-photon-balance pilot, and counts of the rays and photons
/// of all camera paths through these points.
struct FilmPointEstimates {
    radiance: Vec<Rgb>,
    counters: Counters,
}

/// Runs the ray-photon-balance pilot, a small simulation before the first pass. Returns the numbers
/// of camera rays and photon paths with which a pass has the least noise, at the same work as with
/// the numbers of `renderer`.
///
/// Returns `None` if passes trace no photons. The result depends only on the scene and the
/// settings.
pub(super) fn find_ray_photon_balance(renderer: &PassRenderer<'_>) -> Option<RayPhotonBalance> {
    if !renderer.map_builder.traces_photons() {
        return None;
    }
    let key = Key::new(renderer.settings.camera_paths.seed).purpose_key(Purpose::RayPhotonBalance);
    let counts = renderer.map_builder.counts;
    let build = |trial| {
        let mut out = PassResult::default();
        let options = MapBuildOptions {
            has_photon_limit: false,
            ..MapBuildOptions::for_pilot(key.pilot_trial_key(trial), PHOTON_PATH_DIVISOR)
        };
        (renderer.map_builder.build(&options, &SilentMonitor, &mut out), out)
    };
    let ((mut maps, pilot_result), (mut other_maps, _)) = (build(0), build(1));

    // Estimate the radiance at each point four times: once as reference, and once with each of the
    // three sources of noise replaced.
    let (points, other_points) =
        (generate_film_points(renderer.scene, key, 0), generate_film_points(renderer.scene, key, 1));
    let reference = estimate_at_points(renderer, Some(&maps), &points);
    let other_camera = estimate_at_points(renderer, Some(&maps), &other_points);
    std::mem::swap(&mut maps.caustic, &mut other_maps.caustic);
    // In `hybrid`, photon paths aimed at casters fill the caustic map and the indirect map, so both
    // are replaced.
    let aimed_fill_both_maps = renderer.map_builder.request.aimed.separates_after_caustic;
    if aimed_fill_both_maps {
        std::mem::swap(&mut maps.indirect, &mut other_maps.indirect);
    }
    let other_aimed = estimate_at_points(renderer, Some(&maps), &points);
    let has_unaimed = !aimed_fill_both_maps || other_maps.interreflection.is_some();
    let other_unaimed = has_unaimed.then(|| estimate_at_points(renderer, Some(&other_maps), &points));
    // Remove the interreflection map of `hybrid`, so that only photons of paths aimed at casters
    // are gathered: those of the caustic map and of the indirect map.
    maps.interreflection = None;
    let gathered_aimed = estimate_at_points(renderer, Some(&maps), &points).counters;

    // Measure the noise of each source, relative to the mean radiance.
    let mean: Vec<f64> = (0..points.len())
        .map(|i| {
            let values =
                [&reference, &other_camera, &other_aimed].map(|e| f64::from(color::channel_mean(e.radiance[i])));
            values.iter().sum::<f64>() / 3.0
        })
        .collect();
    let noise = |other: &FilmPointEstimates| balance::relative_variance(&reference.radiance, &other.radiance, &mean);

    // Measure the work of each source.
    let pixel_count = pixel_count(renderer.scene);
    let points = f64::from(FILM_POINT_COUNT);
    // Scale by the number of photon paths: density estimates of a pass gather more photons than
    // those of the pilot.
    let gathering =
        |counters: &Counters| balance::gathering_work(counters) / points * pixel_count * f64::from(PHOTON_PATH_DIVISOR);
    let gathered = gathering(&reference.counters);
    let gathered_unaimed =
        if other_maps.interreflection.is_some() { gathered - gathering(&gathered_aimed) } else { 0.0 };
    let paths = (pilot_result.unaimed.emitted_paths + pilot_result.aimed.emitted_paths) as f64;
    let rays = pilot_result.counters.photon_rays as f64;
    let photons = |noise: f64, report: &PhotonReport, count: u32, gathered: f64, gathered_paths: f64| {
        let emitted = report.emitted_paths as f64;
        let work = rays / paths
            + balance::photon_storage_work(report.stored_photons) / emitted.max(1.0)
            + gathered / (gathered_paths * f64::from(PHOTON_PATH_DIVISOR));
        NoiseSource { single_sample_variance: noise * emitted, work_per_sample: work, sample_count: f64::from(count) }
    };
    let tracing = balance::camera_path_work(&reference.counters) / points * pixel_count;
    let camera = NoiseSource {
        single_sample_variance: noise(&other_camera),
        work_per_sample: if renderer.policy.reads_photons_each_sample() { tracing + gathered } else { tracing },
        sample_count: f64::from(renderer.samples_per_pixel),
    };
    let unaimed_noise = other_unaimed.map_or(0.0, |other| noise(&other));
    let (unaimed, aimed) = if other_maps.interreflection.is_some() {
        let (aimed_paths, unaimed_paths) =
            (pilot_result.aimed.emitted_paths as f64, pilot_result.unaimed.emitted_paths as f64);
        (
            photons(unaimed_noise, &pilot_result.unaimed, counts.unaimed, gathered_unaimed, unaimed_paths),
            photons(noise(&other_aimed), &pilot_result.aimed, counts.aimed, gathered - gathered_unaimed, aimed_paths),
        )
    } else {
        (
            photons(unaimed_noise, &pilot_result.unaimed, counts.unaimed, gathered, paths),
            photons(noise(&other_aimed), &pilot_result.aimed, counts.aimed, gathered, paths),
        )
    };

    // Divide the work between the sources.
    let camera_work_per_sample = camera.work_per_sample;
    let [samples, unaimed, aimed] = balance::balance_sample_counts(&[camera, unaimed, aimed]);
    let samples = limit_samples(samples, camera_work_per_sample);
    let paths = |n: f64, emitted: u64| (emitted > 0).then(|| n.round().min(f64::from(u32::MAX)) as u32);
    Some(RayPhotonBalance {
        samples_per_pixel: samples.round().max(1.0) as u32,
        unaimed_paths: paths(unaimed, pilot_result.unaimed.emitted_paths),
        aimed_paths: paths(aimed, pilot_result.aimed.emitted_paths),
    })
}

/// Returns `samples`, the number of camera rays per pixel, lowered to the number that
/// [`MAX_CAMERA_WORK`] allows. `work_per_sample` is the work of one camera ray in every pixel, in
/// units of tracing one photon ray.
fn limit_samples(samples: f64, work_per_sample: f64) -> f64 {
    // `max` ignores NaN.
    samples.min((MAX_CAMERA_WORK / work_per_sample).floor().max(MIN_SAMPLES_PER_PIXEL))
}

/// Estimates the ray and photon counts of a pass by tracing few camera rays and few photons.
pub(super) fn estimate_pass_counters(renderer: &PassRenderer<'_>) -> Counters {
    let key = Key::new(renderer.settings.camera_paths.seed).purpose_key(Purpose::RayPhotonBalance);
    let mut out = PassResult::default();
    let options = MapBuildOptions { connects_to_camera: true, ..MapBuildOptions::for_pilot(key, PHOTON_PATH_DIVISOR) };
    let maps = renderer.map_builder.build(&options, &SilentMonitor, &mut out);
    let counters = estimate_at_points(renderer, Some(&maps), &generate_film_points(renderer.scene, key, 0)).counters;
    let Counters { continuation_rays, shadow_rays, density_estimates: gathers, gathered_photons, .. } = counters;
    let scaled = |n: u64, factor: f64| (n as f64 * factor).round() as u64;
    let pixel_count = pixel_count(renderer.scene);
    let samples = f64::from(renderer.samples_per_pixel) * pixel_count / f64::from(FILM_POINT_COUNT);
    let estimates =
        if renderer.policy.reads_photons_each_sample() { samples } else { pixel_count / f64::from(FILM_POINT_COUNT) };
    let photons = f64::from(PHOTON_PATH_DIVISOR);
    Counters {
        camera_rays: u64::from(renderer.samples_per_pixel) * pixel_count as u64,
        continuation_rays: scaled(continuation_rays, samples),
        shadow_rays: scaled(shadow_rays, samples),
        photon_rays: scaled(out.counters.photon_rays, photons),
        density_estimates: scaled(gathers, estimates),
        gathered_photons: scaled(gathered_photons, estimates * photons),
        rejected_samples: 0,
        rejected_photons: 0,
    }
}

fn estimate_at_points(
    renderer: &PassRenderer<'_>,
    maps: Option<&PhotonMaps<'_>>,
    points: &[FilmPoint],
) -> FilmPointEstimates {
    let paths = renderer.path_context(maps, 0);
    let (radiance, counters) = map_paths_through_film_points(&paths, points, false, |radiance, _| radiance);
    FilmPointEstimates { radiance, counters }
}

fn pixel_count(scene: &Scene) -> f64 {
    let (width, height) = scene.camera().size();
    f64::from(width) * f64::from(height)
}

#[cfg(test)]
mod tests {
    use crate::integrate::test_scenes::glass_ball_above_plane;
    use crate::integrate::{Algorithm, IndirectPhotons, Settings};
    use glam::DVec3;

    /// The ray-photon balance (camera rays and photon paths per pass) does not depend on
    /// `Settings::unaimed_paths` if `hybrid` traces no unaimed paths, photon paths that start in
    /// all directions.
    ///
    /// `hybrid` traces none if `indirect_photons` is off.
    #[test]
    fn untraced_photons_do_not_change_the_balance() {
        let scene = glass_ball_above_plane(DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.0, -0.2, -1.0));
        let balance = |photons| {
            let indirect_photons = IndirectPhotons::Off;
            let settings =
                Settings { unaimed_paths: photons, aimed_paths: 20_000, indirect_photons, ..Settings::default() };
            Algorithm::Hybrid.prepare(&scene, settings).ray_photon_balance().unwrap()
        };
        let found = balance(1);
        assert_eq!((found, found.unaimed_paths), (balance(4_000_000), None));
        assert!((5000..=80_000).contains(&found.aimed_paths.unwrap()), "{found:?}");
    }

    #[test]
    fn expensive_camera_rays_lower_their_number() {
        use super::limit_samples;
        assert_eq!([1e5, 1e7, 2.3e7, 1e9, 0.0].map(|work| limit_samples(8.4, work)), [8.4, 6.0, 2.0, 2.0, 8.4]);
        assert_eq!((limit_samples(1.0, 1e9), limit_samples(8.0, f64::NAN)), (1.0, 2.0));
    }
}
