//! Caustica is a photon-mapping renderer that estimates the error of its pictures.
//!
//! This page lists the types that a user of the library starts from. The modules are hidden from
//! this documentation: they are public for the tests and benches of this package, and their
//! interfaces may change in any version.
//!
//! | task | start from |
//! | --- | --- |
//! | read a scene file | [`SceneFile`] |
//! | build a scene in code | [`SceneBuilder`], [`Material`], [`Shape`], [`Camera`] |
//! | choose an algorithm | [`Algorithm`], [`Settings`] |
//! | render with progress | [`render()`], [`RenderResult::without_passes`], [`ProgressMonitor`] |
//! | choose when a render ends | [`RenderLimits`], [`StopCriteria`] |
//! | read the estimated error | [`RenderResult`], [`ErrorEstimator`], [`ErrorEstimate`] |
//! | write a picture | [`Image`], [`write_image`], [`WriteOptions`] |
//!
//! Two features are on by default. `cli` builds the `caustica` program. `view` adds the live page,
//! and with it a web server. A library user can turn both off with `default-features = false`, and
//! then builds no argument parser, no progress bars and no web server.
//!
//! # A scene in code
//!
//! ```
//! use caustica::camera::Camera;
//! use caustica::integrate::{Algorithm, Settings, SilentMonitor};
//! use caustica::scene::{LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
//! use caustica::shape::{Plane, Shape, Sphere};
//! use glam::{DVec3, Vec3};
//!
//! let mut builder = SceneBuilder::new();
//! let white = builder.add_material(Material::diffuse(Vec3::splat(0.8)));
//! let glass = builder.add_material(Material::dielectric(1.5, Vec3::ZERO));
//! builder
//!     .add_plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Vec3::ZERO)
//!     .add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, 1.0, 0.0), 0.8)), glass, Vec3::ZERO)
//!     .add_delta_light(
//!         UnscaledDeltaLight::Point { position: DVec3::new(2.0, 4.0, 0.0) },
//!         LightStrength::Power(Vec3::splat(200.0)),
//!     );
//! let (center, direction) = (DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.0, -0.2, -1.0));
//! let camera = Camera::perspective(center, direction, DVec3::Y, 0.7, 32, 24)?;
//! let scene = builder.build(camera)?;
//! let settings = Settings { aimed_paths: 2000, ..Settings::default() };
//! let pass = Algorithm::Hybrid.prepare(&scene, settings).render_pass(0, &SilentMonitor);
//! assert_eq!(pass.image.len(), 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # From a render to a pass
//!
//! A *pass* is one estimate of the whole picture. [`render()`] calls
//! [`Integrator::render_pass`](integrate::Integrator::render_pass) until a stop criterion holds,
//! and averages the passes. `PathIntegrator` implements this method for all algorithms except
//! `raycast`. A pass traces its photons first, and then its camera paths.
//!
//! # The path of one photon
//!
//! 1. `PhotonMapBuilder::build` in [`integrate`] traces the photons of a pass, for example by
//!    `trace_aimed_photons`, and then builds the photon maps. `trace_photons` traces the photons of
//!    one map by [`PhotonTracer::trace_and_connect`](photon::PhotonTracer::trace_and_connect). This
//!    function emits photon paths in parallel by `PhotonSource::emit_photon_path`, and follows each
//!    of them by `PhotonTracer::follow_photon_path`.
//! 2. Photon path `i` has the random-number [`Key`](sampling::Key)
//!    `pass_key.photon_path_key(i)`. Every random decision is a deterministic function of a key and
//!    a [`Dimension`](sampling::Dimension), which names the decision.
//! 3. [`PhotonSource::emit_photon_path`](photon::PhotonSource::emit_photon_path) samples a light
//!    and a ray that leaves it. The sampling pdf follows the power of the lights, the solid angle
//!    of casters (mirrors, glass and clear coats), or the emission that a pilot found useful. The
//!    ray carries the flux Φ = Lₑ·cos θ/(pdf · number of paths).
//! 4. [`PathRay::next_vertex`](scene::PathRay::next_vertex) finds the next surface by
//!    `Geometry::intersect` and applies absorption. In a [`Medium`](medium::Medium), it may sample
//!    a scattering event before that surface.
//! 5. At a surface that stores photons, `Deposits::store_deposit` adds a
//!    [`Photon`](photon::Photon) to the [`Deposits`](photon::Deposits) of the pass.
//!    `LightTracer::splat_and_return_share` also sends caustic photons to the pixel that sees them.
//! 6. [`Bsdf::sample`](bsdf::Bsdf::sample) chooses the next direction. Russian roulette then may
//!    end the path. It survives with the ratio of its flux after and before the scattering.
//! 7. `PhotonIndexer::index_photons` calls [`PhotonMap::build`](photon::PhotonMap::build) for
//!    each photon map that the algorithm reads: the caustic map, the indirect map (Jensen's global
//!    map), and in `hybrid` the interreflection map.
//!
//! # The path of one camera ray
//!
//! 1. After the photons are traced, [`Integrator::render_pass`](integrate::Integrator::render_pass)
//!    calls `render_tiles`, which renders the tiles of the picture in parallel, pixel by pixel. For
//!    each sample of a pixel, `FilmSampling::generate_pixel_ray` chooses a film point by the
//!    reconstruction filter. [`Camera::generate_ray`] makes a ray through it.
//! 2. `camera_path::trace_camera_path` returns the radiance along this ray. It calls
//!    [`PathRay::next_vertex`](scene::PathRay::next_vertex) for each vertex of the path.
//!    `Geometry::intersect` finds the nearest surface by
//!    [`Bvh::closest_hit`](accel::Bvh::closest_hit). Its loop tests the eight boxes of a node by
//!    `Boxes8::intersect_boxes`, and the triangles of a leaf.
//! 3. At casters, for example glass and mirrors
//!    ([`Bsdf::casts_caustics`](bsdf::Bsdf::casts_caustics)), `scatter_at_caster` continues the
//!    path. Smooth glass splits the path while both branches carry enough light.
//! 4. At a surface that stores photons, `NextEventEstimator::estimate_direct_light` adds direct
//!    light, and `PhotonMaps::radiance` adds the estimates from the photon maps
//!    ([`PhotonMap::estimate_radiance`](photon::PhotonMap::estimate_radiance)). In
//!    [`Algorithm::Hybrid`], only a few paths of each pixel read the maps.
//! 5. `continue_path` samples the next direction and applies Russian roulette.
//!
//! In all photon algorithms except `pm`, gather radii shrink from pass to pass. So the mean of the
//! passes of `hybrid` and `sppm` converges to the true radiance. `ppm` keeps the error of its
//! camera paths, because all passes trace the same ones.
//!
//! # Where to add a light, BSDF, format or shape
//!
//! A new light: see the head of `light/mod.rs`. A new BSDF with its material: see the head of
//! `bsdf/mod.rs`. A new scene format: see `SceneImporter` in `format/import.rs`. A new shape: see
//! the head of `shape/mod.rs`.

#[macro_use]
mod enum_list;

#[doc(hidden)]
pub mod accel;
#[doc(hidden)]
pub mod bsdf;
#[doc(hidden)]
pub mod camera;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod color;
#[doc(hidden)]
pub mod format;
#[doc(hidden)]
pub mod image;
#[doc(hidden)]
pub mod integrate;
#[doc(hidden)]
pub mod light;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod medium;
#[doc(hidden)]
pub mod photon;
#[doc(hidden)]
pub mod plan;
#[doc(hidden)]
pub mod render;
#[doc(hidden)]
pub mod sampling;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod shape;
#[doc(hidden)]
pub mod stats;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
pub mod texture;
#[cfg(feature = "view")]
#[doc(hidden)]
pub mod view;

/// # Example: a position, a view direction and a field of view
/// ```
/// use glam::DVec3;
/// // Vertical field of view of 0.7 radians, 320 × 240 pixels.
/// let camera = caustica::Camera::perspective(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.7, 320, 240)?;
/// assert_eq!(camera.size(), (320, 240));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use camera::Camera;

/// # Example: load a file
/// ```no_run
/// let file = caustica::SceneFile::read("scenes/gem.txt".as_ref())?;
/// let scene: caustica::Scene = file.resolve()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use format::SceneFile;

/// # Example: the error of a scene names its position in the file
/// ```
/// let error = caustica::format::parse("scene.txt", "Grop { }").unwrap_err();
/// println!("{error}");
/// ```
pub use format::SceneError;

/// # Example: a grey picture
/// ```
/// let grey = caustica::Image::from_pixels(2, 1, vec![glam::Vec3::splat(0.5); 2])?;
/// assert_eq!(grey.get(1, 0), Some(glam::Vec3::splat(0.5)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use image::Image;

/// # Example: write a PNG with a filmic tone curve
/// ```
/// use caustica::image::{ToneCurve, ToneMap};
/// let folder = tempfile::tempdir()?;
/// let tone = ToneMap { curve: ToneCurve::Filmic, exposure_stops: 1.0 };
/// let options = caustica::WriteOptions { tone, ..Default::default() };
/// let (path, image) = (folder.path().join("a.png"), caustica::Image::new(2, 2)?);
/// let report = caustica::write_image(&path, &image, &options)?;
/// assert_eq!(report.too_bright, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use image::{WriteOptions, write as write_image};

/// # Example: every algorithm by its name on the command line
/// ```
/// let names = caustica::Algorithm::ALL.map(|algorithm| algorithm.name());
/// assert_eq!(names[0], "hybrid");
/// ```
pub use integrate::Algorithm;

/// # Example: print the start of each stage
/// ```
/// use caustica::integrate::PassStage;
/// struct StagePrinter;
/// impl caustica::ProgressMonitor for StagePrinter {
///     fn begin_stage(&self, stage: PassStage, total: u64) {
///         println!("{stage:?}: {total} units");
///     }
///     fn report_progress(&self, _: u64) {}
/// }
/// ```
pub use integrate::ProgressMonitor;

/// # Example: fewer photons than by default
/// ```
/// use caustica::Settings;
/// let settings = Settings { unaimed_paths: 10_000, aimed_paths: 5_000, ..Default::default() };
/// ```
pub use integrate::Settings;

/// # Example: render two passes and read the estimated error
/// ```
/// use caustica::{
///     Algorithm, Camera, Image, Material, RenderResult, SceneBuilder, Settings, Shape,
///     StopCriteria,
/// };
/// use caustica::integrate::SilentMonitor;
/// use glam::{DVec3, Vec3};
/// use std::sync::atomic::AtomicBool;
///
/// let mut builder = SceneBuilder::new();
/// let lamp = builder.add_material(Material::diffuse(Vec3::ZERO));
/// let ball = caustica::shape::Sphere::new(DVec3::new(0.0, 0.0, -3.0), 1.0);
/// builder.add_shape(Shape::Sphere(ball), lamp, Vec3::ONE);
/// let scene = builder.build(Camera::perspective(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.7, 16, 12)?)?;
///
/// let interrupted = AtomicBool::new(false);
/// let stop = StopCriteria { max_passes: Some(2), ..StopCriteria::unlimited(&interrupted) };
/// let integrator = Algorithm::Path.prepare(&scene, Settings::default());
/// let integrator = integrator.as_ref();
/// let start = RenderResult::without_passes(integrator, (16, 12));
/// let numbers = 0..u32::MAX;
/// let rendered =
///     caustica::render(start, numbers, integrator, &stop, &SilentMonitor, |progress| {
///         println!("{} passes", progress.passes);
///     });
/// let picture = Image::from_pixels(16, 12, rendered.film.mean_picture())?;
/// assert_eq!(rendered.film.passes(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use render::{RenderResult, StopCriteria, render};

/// # Example: a preview, which ends at an estimated error of 10 % or after five minutes
/// ```
/// use caustica::{
///     Algorithm, Camera, Material, RenderLimits, RenderResult, SceneBuilder, Settings, Shape,
/// };
/// use caustica::integrate::SilentMonitor;
/// use caustica::render::EndReason;
/// use glam::{DVec3, Vec3};
/// use std::sync::atomic::AtomicBool;
///
/// let mut builder = SceneBuilder::new();
/// let lamp = builder.add_material(Material::diffuse(Vec3::ZERO));
/// let ball = caustica::shape::Sphere::new(DVec3::new(0.0, 0.0, -3.0), 1.0);
/// builder.add_shape(Shape::Sphere(ball), lamp, Vec3::ONE);
/// let scene = builder.build(Camera::perspective(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.7, 16, 12)?)?;
///
/// let mut settings = Settings::default();
/// settings.camera_paths.estimate_error = true;
/// let integrator = Algorithm::Path.prepare(&scene, settings);
/// let interrupted = AtomicBool::new(false);
/// let limits = RenderLimits { preview: true, ..RenderLimits::default() };
/// let stop = limits.stop_criteria(Algorithm::Path, integrator.as_ref(), &interrupted);
/// let integrator = integrator.as_ref();
/// let start = RenderResult::without_passes(integrator, (16, 12));
/// let numbers = 0..u32::MAX;
/// let rendered =
///     caustica::render(start, numbers, integrator, &stop, &SilentMonitor, |_| {});
/// assert_eq!(rendered.end_reason, EndReason::Target);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub use render::RenderLimits;

pub use render::error_estimate::{ErrorEstimate, ErrorEstimator};
pub use scene::{Material, Scene, SceneBuilder};
pub use shape::Shape;
