//! Integrators with various settings, as variants of one enum.

use caustica::camera::{Filter, FilterKind};
use caustica::color::Rgb;
use caustica::integrate::{
    Algorithm, CameraPathSettings, DEFAULT_ALPHA, FinalGathering, IndirectPhotons, Integrator, LightTracing, Settings,
    SilentMonitor, VolumeEstimator,
};
use caustica::photon::Kernel;
use caustica::scene::Scene;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Path,
    Hybrid,
    Sppm,
    /// `Sppm` with the beam radiance estimate in media.
    SppmBeamRadiance,
    /// `Sppm` with a point estimate in media.
    SppmPoints,
    Ppm,
    /// `Pm` that reads the global map at the first receiver, without gather rays.
    PmDirect,
    /// `Pm` with final gathering along directions sampled from the BSDF.
    PmGathering,
    /// `Pm` with final gathering along directions guided by photons.
    PmGuided,
}

pub const ALL: [Method; 7] =
    [Method::Path, Method::Hybrid, Method::Sppm, Method::Ppm, Method::PmDirect, Method::PmGathering, Method::PmGuided];

/// Cost of a render: its passes, camera rays and photon paths.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of passes.
    pub passes: u32,
    /// Camera rays per pixel.
    pub samples: u32,
    /// Photon paths of the global map.
    pub photons: u32,
    /// Photon paths of the caustic map.
    pub caustic: u32,
    /// Gather radius of both maps in the first pass \[length].
    pub radius: f64,
}

/// Renders independent passes and returns their images.
///
/// Passes of `ppm` share their camera paths, so each gets its own seed.
pub fn passes(method: Method, scene: &Scene, effort: Effort) -> Vec<Vec<Rgb>> {
    if method == Method::Ppm {
        return (0..effort.passes).map(|i| image(method, prepare(method, scene, effort, i).as_ref(), i)).collect();
    }
    let prepared = prepare(method, scene, effort, 0);
    (0..effort.passes).map(|i| image(method, prepared.as_ref(), i)).collect()
}

fn image(method: Method, prepared: &dyn Integrator, i: u32) -> Vec<Rgb> {
    let pass = prepared.render_pass(i, &SilentMonitor);
    assert_eq!(pass.counters.rejected_samples, 0, "{method:?}");
    pass.image
}

fn prepare<'a>(method: Method, scene: &'a Scene, effort: Effort, i: u32) -> Box<dyn Integrator + 'a> {
    let camera_paths = CameraPathSettings {
        samples_per_pixel: Some(effort.samples),
        max_bounces: 1000,
        seed: 1000 + u64::from(i),
        filter: Filter::new(FilterKind::Box),
        ..CameraPathSettings::default()
    };
    let settings = Settings {
        camera_paths,
        allows_ray_photon_balance: false,
        unaimed_paths: effort.photons,
        aimed_paths: effort.caustic,
        gather_k: Some(0),
        initial_gather_radius: Some(effort.radius as f32),
        alpha: DEFAULT_ALPHA,
        kernel: Kernel::Epanechnikov,
        allows_prefix_rays: true,
        allows_environment_guiding: true,
        allows_scatter_point_guiding: true,
        light_tracing: LightTracing::Weighted,
        indirect_photons: IndirectPhotons::Weighted,
        volume_estimator: match method {
            Method::SppmBeamRadiance => VolumeEstimator::BeamRadiance,
            Method::SppmPoints => VolumeEstimator::Points,
            _ => VolumeEstimator::Beams,
        },
        final_gathering: match method {
            Method::PmGathering => FinalGathering::Bsdf,
            Method::PmGuided => FinalGathering::Importance,
            _ => FinalGathering::None,
        },
    };
    let algorithm = match method {
        Method::Path => Algorithm::Path,
        Method::Hybrid => Algorithm::Hybrid,
        Method::Sppm | Method::SppmBeamRadiance | Method::SppmPoints => Algorithm::Sppm,
        Method::Ppm => Algorithm::Ppm,
        Method::PmDirect | Method::PmGathering | Method::PmGuided => Algorithm::Pm,
    };
    algorithm.prepare(scene, settings)
}
