//! Settings of the rendering algorithms: camera paths, photons and final gathering.

use super::radius_law::DEFAULT_ALPHA;
use super::volume_estimate::VolumeEstimator;
use crate::camera::{CropWindow, Filter, FilterKind};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;

/// Settings of camera paths. [`Algorithm::Raycast`](super::Algorithm::Raycast) reads only the
/// number of samples, the seed, the filter, the crop window and the effects. Other algorithms read
/// all fields, unless a field says otherwise.
#[derive(Clone, Debug)]
pub struct CameraPathSettings {
    /// Number of camera rays per pixel and pass. `None` takes the default of the algorithm, and
    /// lets a pilot change it (see [`Settings::allows_ray_photon_balance`]).
    pub samples_per_pixel: Option<u32>,
    /// Largest number of bounces of a camera or photon path.
    pub max_bounces: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Reconstruction filter of pixels.
    pub filter: Filter,
    /// True if a pilot (small simulation before the first pass) gives noisier pixels more camera
    /// rays. [`Algorithm::Ppm`](super::Algorithm::Ppm) ignores this setting.
    pub adaptive: bool,
    /// True if passes return the data from which the error of the picture is estimated. Photon
    /// estimates are then repeated in smaller discs, for example.
    ///
    /// A render can end at an estimated error only if this is true.
    pub estimate_error: bool,
    /// True if passes divide the light of each pixel into direct, indirect and caustic light.
    ///
    /// [`Algorithm::Raycast`](super::Algorithm::Raycast) ignores this setting.
    pub groups_light: bool,
    /// Window of pixels that passes render; `None` for the whole picture. The pixels of the window
    /// are bit-identical to the same pixels of the whole picture.
    pub crop: Option<CropWindow>,
    /// Upper bound on the light that one camera path finds, except its photon estimates \[W/(m²
    /// sr)]; `None` for no bound. Light with a larger RGB channel is scaled down. This suppresses
    /// fireflies, but biases the picture.
    pub clamp: Option<f32>,
    /// Effects of light that are forced on or off. The plan decides about all other effects.
    pub effects: EffectOverrides,
}

impl Default for CameraPathSettings {
    fn default() -> Self {
        Self {
            samples_per_pixel: None,
            max_bounces: 100,
            seed: 0,
            filter: Filter::new(FilterKind::default()),
            adaptive: false,
            estimate_error: false,
            groups_light: false,
            crop: None,
            clamp: None,
            effects: EffectOverrides::NO_OVERRIDES,
        }
    }
}

impl CameraPathSettings {
    /// Returns the window of pixels to render, in a picture of `size` (width, height) pixels.
    ///
    /// A `crop` window that does not fit into the picture counts as the whole picture.
    #[must_use]
    pub fn window(&self, size: (u32, u32)) -> CropWindow {
        self.crop.filter(|window| window.fits_into(size)).unwrap_or(CropWindow::of_whole_picture(size))
    }
}

/// Settings of all algorithms.
///
/// Algorithms without photons read only `camera_paths`, `allows_environment_guiding` and
/// `allows_scatter_point_guiding`.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Settings that all algorithms use.
    pub camera_paths: CameraPathSettings,
    /// Number of photon paths per pass that lights emit in all directions (*unaimed* paths).
    ///
    /// These paths fill the interreflection map of `hybrid` (indirect light that does not come from
    /// caustics), and the indirect map of `sppm`, `ppm` and `pm`.
    pub unaimed_paths: u32,
    /// Number of photon paths per pass that are aimed at casters, such as glass or mirrors.
    ///
    /// These paths fill the caustic map. In `hybrid`, they also fill the indirect map, with the
    /// light that other surfaces and media scatter after a caustic.
    pub aimed_paths: u32,
    /// True if a pilot (small simulation before the first pass) may trade camera rays for photon
    /// paths, to get less noise for the same work.
    ///
    /// `unaimed_paths`, `aimed_paths` and the camera rays per pixel are then starting values. If
    /// [`CameraPathSettings::samples_per_pixel`] is set, only one value may change: the pilot that
    /// divides indirect light may reduce `unaimed_paths` of `hybrid`. `ppm` ignores this setting.
    pub allows_ray_photon_balance: bool,
    /// Largest number of photons of a density estimate on a surface in the first pass; 0 for no
    /// limit.
    ///
    /// `None` stands for [`DEFAULT_CAUSTIC_K`](super::DEFAULT_CAUSTIC_K) in the caustic map, and
    /// for no limit in other maps. If a pilot changes `aimed_paths`, the default limit of the
    /// caustic map changes in proportion.
    ///
    /// The farthest photon only sets the radius, so a limit of 1 acts like 2. If a limit above 0 is
    /// set, pilots choose gather radii that hold about that many photons.
    pub gather_k: Option<u32>,
    /// Largest gather radius of density estimates in the first pass, on surfaces and in media
    /// \[length]. `None` lets pilots (small simulations before the first pass) choose a radius for
    /// each photon map.
    pub initial_gather_radius: Option<f32>,
    /// Exponent α in (0, 1] of shrinking gather radii: the squared radius falls as n^(α−1) with the
    /// number of passes n, so 1 keeps radii fixed. [`Algorithm::Pm`](super::Algorithm::Pm) ignores
    /// this setting and keeps radii fixed.
    pub alpha: f64,
    /// Kernel of photon density estimates.
    pub kernel: Kernel,
    /// True if [`Algorithm::Hybrid`](super::Algorithm::Hybrid) may trace prefix rays: extra camera
    /// paths that end at the first surface or medium that stores photons. A pilot finds how many
    /// each pixel needs.
    pub allows_prefix_rays: bool,
    /// True if a pilot may guide shadow rays to the environment light. The pilot learns the
    /// directions from which this light reaches each part of the scene.
    pub allows_environment_guiding: bool,
    /// True if a pilot may guide next-event estimation in homogeneous media. The pilot learns from
    /// which points of a medium shadow rays find light, and how many shadow rays to send.
    pub allows_scatter_point_guiding: bool,
    /// Division of directly visible caustics between photon estimates and light tracing, in
    /// [`Algorithm::Hybrid`](super::Algorithm::Hybrid).
    pub light_tracing: LightTracing,
    /// Division of indirect light between camera paths and photon estimates, in
    /// [`Algorithm::Hybrid`](super::Algorithm::Hybrid).
    pub indirect_photons: IndirectPhotons,
    /// Density estimator for photons in media.
    pub volume_estimator: VolumeEstimator,
    /// Surface at which [`Algorithm::Pm`](super::Algorithm::Pm) reads the indirect map.
    pub final_gathering: FinalGathering,
}

/// Surface at which [`Algorithm::Pm`](super::Algorithm::Pm) reads the indirect map: the visible
/// surface, or the end of a final-gathering ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalGathering {
    /// `pm` reads the indirect map at the surface that the camera sees, without final gathering
    /// (direct visualization of the map).
    None,
    /// `pm` reads the indirect map at the end of a gather ray, whose direction is sampled from the
    /// BSDF.
    #[default]
    Bsdf,
    /// `pm` reads the indirect map at the end of a gather ray, whose direction is sampled from the
    /// BSDF or from the directions of nearby photons, with equal probability.
    Importance,
}

/// Division of indirect light between camera paths and photon estimates, at a camera path's first
/// receiver (surface or medium that stores photons).
///
/// The indirect light of caustics is not divided: in
/// [`Algorithm::Hybrid`](super::Algorithm::Hybrid), photon estimates always carry it. If media emit
/// light, camera paths carry all other indirect light, because photons never start in media.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IndirectPhotons {
    /// Camera paths carry all of the indirect light that does not come from caustics.
    Off,
    /// Camera paths and photon estimates each carry a part of the indirect light that does not come
    /// from caustics. A pilot (small simulation before the first pass) finds these parts.
    #[default]
    Weighted,
    /// Photon estimates carry all indirect light, except in scenes with media that emit light.
    Full,
}

/// Division of directly visible caustics between photon estimates and light tracing. Light tracing
/// connects photons to the camera, as splats on the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightTracing {
    /// Photon estimates carry all light of directly visible caustics.
    Off,
    /// Photon estimates and light tracing each carry a part of the light at each pixel. A pilot
    /// (small simulation before the first pass) finds these parts.
    #[default]
    Weighted,
    /// Light tracing carries all light of directly visible caustics.
    Full,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            camera_paths: CameraPathSettings::default(),
            unaimed_paths: 500_000,
            aimed_paths: 250_000,
            allows_ray_photon_balance: true,
            gather_k: None,
            initial_gather_radius: None,
            alpha: DEFAULT_ALPHA,
            kernel: Kernel::default(),
            allows_prefix_rays: true,
            allows_environment_guiding: true,
            allows_scatter_point_guiding: true,
            light_tracing: LightTracing::default(),
            indirect_photons: IndirectPhotons::default(),
            volume_estimator: VolumeEstimator::default(),
            final_gathering: FinalGathering::default(),
        }
    }
}
