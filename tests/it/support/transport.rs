//! Photon passes, density estimates and closed forms, for tests of light transport.

use super::{assert_mean, midpoint_integral};
use caustica::camera::{Camera, Filter, FilterKind};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::photon::{
    Bandwidth, Kernel, Photon, PhotonMap, PhotonSearchBuffers, PhotonSource, PhotonTracer, StoreMask, TracedPhotons,
};
use caustica::sampling::{Key, Purpose};
use caustica::scene::{Scene, SceneBuilder};
use caustica::shape::{Rectangle, Shape};
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Number of passes of most tests.
pub const PASSES: u32 = 16;

/// All kernels of density estimates.
pub const KERNELS: [Kernel; 3] = [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov];

/// Relative rounding error of each color channel of a stored grey photon.
///
/// Channels are stored in steps of 1/65535 of the channel sum. A grey channel is a third of this
/// sum, so half a step is 1.5/65535 of the channel.
pub const STORED_COLOR_ROUNDING: f64 = 1.5 / 65_535.0;

pub fn dvec3(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

pub fn grey(x: f64) -> Rgb {
    Rgb::splat(x as f32)
}

/// Returns a perspective camera at `eye` that looks at `at`, with `size` × `size` pixels.
///
/// `angle` is its full field of view \[degrees].
pub fn square_camera(eye: DVec3, at: DVec3, angle: f64, size: u32) -> Camera {
    let up = if (at - eye).normalize().y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    Camera::perspective(eye, at - eye, up, angle.to_radians(), size, size).unwrap()
}

/// Builds a scene for tests of photons alone. It has a camera with one pixel, which no test
/// renders.
pub fn photon_only_scene(builder: SceneBuilder) -> Scene {
    builder.build(square_camera(DVec3::ZERO, DVec3::Z, 40.0, 1)).unwrap()
}

/// Returns the faces of the box from `lo` to `hi`: floor, ceiling, left, right, back, front.
///
/// Their outer sides face inwards if `inwards` is true, otherwise outwards.
pub fn box_faces(lo: DVec3, hi: DVec3, inwards: bool) -> [Shape; 6] {
    let (x, y, z) = (DVec3::X * (hi.x - lo.x), DVec3::Y * (hi.y - lo.y), DVec3::Z * (hi.z - lo.z));
    let face = |corner, e0, e1| {
        let (e0, e1) = if inwards { (e0, e1) } else { (e1, e0) };
        Shape::Rectangle(Rectangle::new(corner, e0, e1))
    };
    [face(lo, z, x), face(lo + y, x, z), face(lo, y, z), face(lo + x, z, y), face(lo, x, y), face(lo + z, y, x)]
}

/// Returns one random key for each of `passes` independent passes.
pub fn pass_keys(passes: u32) -> impl Iterator<Item = Key> {
    (0..u64::from(passes)).map(|pass| Key::new(20_240_229).purpose_key(Purpose::Test).child_key(pass))
}

/// Traces `passes` independent passes of `paths` photon paths each, emitted in all directions.
pub fn trace_photon_passes(
    scene: &Scene,
    mask: StoreMask,
    max_bounces: u32,
    passes: u32,
    paths: u32,
) -> Vec<TracedPhotons> {
    let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
    trace_passes_from_source(scene, &source, mask, max_bounces, passes, paths)
}

/// Traces `passes` independent passes of `paths` photon paths each, emitted by `source`.
pub fn trace_passes_from_source(
    scene: &Scene,
    source: &PhotonSource<'_>,
    mask: StoreMask,
    max_bounces: u32,
    passes: u32,
    paths: u32,
) -> Vec<TracedPhotons> {
    let tracer = PhotonTracer { scene, source, mask, max_bounces };
    pass_keys(passes).map(|key| tracer.trace(key, paths, &|_| {})).collect()
}

/// Returns a photon's position in the coordinates of the scene description.
pub fn photon_position(scene: &Scene, photon: &Photon) -> DVec3 {
    photon.position.as_dvec3() + scene.origin()
}

/// Returns the flux \[W] of the photons at whose positions `inside` is true.
///
/// Positions are in the coordinates of the scene description.
pub fn flux_where(scene: &Scene, photons: &[Photon], inside: impl Fn(DVec3) -> bool) -> DVec3 {
    photons.iter().filter(|p| inside(photon_position(scene, p))).map(|p| p.attributes.flux().as_dvec3()).sum()
}

/// Estimates irradiance \[W/m²] at the point `p` with the normal `n`, from a photon map.
///
/// `p` is in the coordinates of the scene description.
pub fn estimated_irradiance(
    scene: &Scene,
    map: &PhotonMap,
    p: DVec3,
    n: DVec3,
    bandwidth: Bandwidth,
    kernel: Kernel,
) -> DVec3 {
    let p = (p - scene.origin()).as_vec3();
    let mut scratch = PhotonSearchBuffers::default();
    map.estimate_radiance(p, n.as_vec3(), bandwidth, kernel, &mut scratch, |_| Vec3::ONE).radiance.as_dvec3()
}

/// Returns the bandwidth of estimates with the fixed radius `radius`.
pub fn fixed_bandwidth(radius: f64) -> Bandwidth {
    Bandwidth { radius: radius as f32, k: 0 }
}

/// Returns settings with a fixed gather radius, `photons` unaimed paths, and
/// `caustic_photons` aimed paths.
pub fn fixed_radius_settings(photons: u32, caustic_photons: u32, radius: f64) -> Settings {
    Settings {
        unaimed_paths: photons,
        aimed_paths: caustic_photons,
        gather_k: Some(0),
        initial_gather_radius: Some(radius as f32),
        kernel: Kernel::Epanechnikov,
        ..camera_ray_settings(16, 1000)
    }
}

/// Returns default settings with a box filter, a fixed seed, `samples` rays per pixel and a bounce
/// limit.
pub fn camera_ray_settings(samples: u32, max_bounces: u32) -> Settings {
    let filter = Filter::new(FilterKind::Box);
    let camera_paths = CameraPathSettings {
        samples_per_pixel: Some(samples),
        max_bounces,
        seed: 5,
        filter,
        ..CameraPathSettings::default()
    };
    Settings { camera_paths, ..Settings::default() }
}

/// Renders with `sppm` and returns the mean radiance of the image for each pass.
pub fn mean_radiance_per_pass(scene: &Scene, settings: Settings, passes: u32) -> Vec<DVec3> {
    let method = Algorithm::Sppm.prepare(scene, settings);
    let mean = |image: Vec<Rgb>| image.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / image.len() as f64;
    (0..passes).map(|i| mean(method.render_pass(i, &SilentMonitor).image)).collect()
}

/// Returns the red channel of each value.
pub fn red_channels(values: &[DVec3]) -> Vec<f64> {
    values.iter().map(|v| v.x).collect()
}

/// Applies [`assert_mean`] to each channel, with a tolerance for the rounding of stored photons.
///
/// Red and green are stored to half a step of the channel sum; blue is the remainder.
#[track_caller]
pub fn assert_mean_rgb(what: &str, samples: &[DVec3], expected: DVec3, max_relative_error: f64) {
    let slack = expected.element_sum() * STORED_COLOR_ROUNDING * 2.0 / 3.0;
    for (c, name) in ["red", "green", "blue"].iter().enumerate() {
        let channel: Vec<f64> = samples.iter().map(|v| v[c]).collect();
        assert_mean(&format!("{what}, {name}"), &channel, expected[c], slack, max_relative_error);
    }
}

/// Point at which irradiance is estimated, with the kernel and its radius.
pub struct EstimatePoint<'a> {
    pub scene: &'a Scene,
    pub at: DVec3,
    pub normal: DVec3,
    pub radius: f64,
    pub kernel: Kernel,
}

/// Applies [`assert_mean`] to the irradiance that is estimated at `probe` in each of `maps`.
///
/// `quadrature` is the relative error of `expected`. The tolerance also covers rounding: the
/// estimate adds blocks of 64 photons in single precision, with an error of at most 64·2⁻²⁴ of the
/// sum (Higham 2002, section 4.2). For photons of equal power, this error is systematic.
#[track_caller]
pub fn assert_estimates(
    what: &str,
    probe: &EstimatePoint<'_>,
    maps: &[PhotonMap],
    expected: f64,
    quadrature: f64,
    max_relative_error: f64,
) {
    let (p, n) = ((probe.at - probe.scene.origin()).as_vec3(), probe.normal.as_vec3());
    let one = |map: &PhotonMap| {
        map.estimate_radiance(
            p,
            n,
            fixed_bandwidth(probe.radius),
            probe.kernel,
            &mut PhotonSearchBuffers::default(),
            |_| Vec3::ONE,
        )
    };
    let estimates: Vec<_> = maps.iter().map(one).collect();
    let most = estimates.iter().map(|e| e.photon_count).max().unwrap_or(0);
    let slack = expected * (quadrature + 2.0 * STORED_COLOR_ROUNDING + f64::from(most.min(64)) / 16_777_216.0);
    let samples: Vec<f64> = estimates.iter().map(|e| f64::from(e.radiance.x)).collect();
    let what = format!("{what}, {:?} of {} at {:.3}", probe.kernel, probe.radius, probe.at);
    assert_mean(&what, &samples, expected, slack, max_relative_error);
}

/// Returns the value of a kernel at the distance `d` from its center.
///
/// The integral of the kernel over the disc of radius `r` is 1.
pub fn kernel_at(kernel: Kernel, d: f64, r: f64) -> f64 {
    let t = d / r;
    if t > 1.0 {
        return 0.0;
    }
    let shape = match kernel {
        Kernel::Box => 1.0,
        Kernel::Cone => 3.0 * (1.0 - t),
        Kernel::Epanechnikov => 2.0 * (1.0 - t * t),
    };
    shape / (PI * r * r)
}

/// Returns the noise factor of a kernel: its variance relative to the box kernel.
///
/// It is π∫K² for the kernel K with radius 1.
pub fn kernel_noise_factor(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Box => 1.0,
        Kernel::Cone => 1.5,
        Kernel::Epanechnikov => 4.0 / 3.0,
    }
}

/// Returns the expected value of a density estimate with radius `r`, including its bias.
///
/// `density` returns the photon density at an offset from the disc's center.
pub fn kernel_weighted_mean(kernel: Kernel, r: f64, density: impl Fn(DVec2) -> f64) -> f64 {
    const TURNS: u32 = 96;
    let ring = |d: f64| {
        let around = |i: u32| density(DVec2::from_angle(TAU * (f64::from(i) + 0.5) / f64::from(TURNS)) * d);
        (0..TURNS).map(around).sum::<f64>() / f64::from(TURNS)
    };
    midpoint_integral(0.0, r, 400, |d| TAU * d * kernel_at(kernel, d, r) * ring(d))
}

/// Returns the Fresnel reflectance of a dielectric of relative index `n`, for unpolarised light.
pub fn fresnel_reflectance(cos_i: f64, n: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (n * n);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    let p = (n * cos_i - cos_t) / (n * cos_i + cos_t);
    0.5 * (s * s + p * p)
}

/// Returns the reflectance of a dielectric of relative index `n` for uniform incident radiance: ∫ R
/// 2cosθ dcosθ.
pub fn hemispherical_reflectance(n: f64) -> f64 {
    midpoint_integral(0.0, 1.0, 200_000, |c| 2.0 * c * fresnel_reflectance(c, n))
}

/// Returns `n` evenly spread unit vectors (Fibonacci lattice).
pub fn fibonacci_directions(n: u32) -> Vec<DVec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    let at = |i: u32| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
        (DVec2::from_angle(golden * f64::from(i)) * (1.0 - z * z).sqrt()).extend(z)
    };
    (0..n).map(at).collect()
}
