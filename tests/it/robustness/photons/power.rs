//! Light powers at the limits of single precision.

use super::{
    STORED_COLOR_ROUNDING, WITH_PHOTONS, add_invisible_slab, assert_finite, flat_camera, rectangle_around, rendered,
    settings,
};
use crate::support::{PATIENCE, mean_and_error, render_one_pass, test_key};
use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use caustica::medium::{Medium, PhaseFunction};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::render::RenderResult;
use caustica::render::error_estimate::{ErrorEstimate, ErrorMaps};
use caustica::scene::{Body, BuildError, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Shape, Sphere};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Builds a room with lights, a glass ball, a mirror and, if `fog` is true, fog.
///
/// The area light, the point light and the spotlight have `scale` W each.
fn room(scale: f32, fog: bool) -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::new(0.7, 0.6, 0.5)));
    let glass = b.add_material(Material::dielectric(1.5, Rgb::new(0.1, 0.2, 0.3)));
    let mirror = b.add_material(Material::mirror(Rgb::splat(0.9)));
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    for (center, e0, e1) in
        [(-DVec3::Y, z, x), (DVec3::Y, x, z), (-DVec3::Z, x, y), (-DVec3::X, y, z), (DVec3::X, z, y)]
    {
        b.add_shape(rectangle_around(center, e0, e1), white, Rgb::ZERO);
    }
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.4, -0.6, 0.1), 0.4)), glass, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(-0.5, -0.7, -0.3), 0.3)), mirror, Rgb::ZERO);
    b.add_shape(rectangle_around(DVec3::Y * 0.99, x * 0.2, z * 0.2), white, Rgb::new(0.5, 0.4, 0.3) * scale);
    let power = LightStrength::Power(Rgb::new(0.3, 0.2, 0.1) * scale);
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::new(-0.5, 0.5, 0.3) }, power);
    let spot =
        UnscaledDeltaLight::Spot { position: DVec3::new(0.5, 0.8, 0.5), axis: -DVec3::Y, inner: 0.3, outer: 0.5 };
    b.add_delta_light(spot, power);
    if fog {
        let milk = Medium::homogeneous(Rgb::splat(0.2), Rgb::splat(0.8), Rgb::ZERO, PhaseFunction::Isotropic);
        let milk = b.add_medium(milk);
        let clear = b.add_material(Material::smooth_boundary(Body::null_interface_with_medium(milk)));
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.1, -0.2), 0.4)), clear, Rgb::ZERO);
    }
    let camera = Camera::perspective(DVec3::Z * 3.4, -DVec3::Z, DVec3::Y, 0.8, 16, 16).unwrap();
    b.build(camera).unwrap()
}

/// Returns the error estimate and the error maps of a render.
fn estimates(rendered: &RenderResult) -> (ErrorEstimate, ErrorMaps) {
    let estimator = rendered.estimator.as_ref().unwrap();
    (estimator.estimate(&rendered.film), estimator.error_maps(&rendered.film))
}

/// Returns the sum over all passes of each pixel, from the mean over passes.
///
/// The number of passes is a power of two, so nothing rounds.
fn sums(rendered: &RenderResult) -> Vec<DVec3> {
    let passes = f64::from(rendered.film.passes());
    rendered.film.pixel_means().map(|mean| mean * passes).collect()
}

/// Renders with lights of 2^±100 W are finite and agree with those at 1 W.
///
/// At 2⁹³ W, about 10²⁸ W, images and error maps are exactly 2⁹³ times those at 1 W. Relative error
/// estimates are equal, because 93 is a multiple of 31: the sums of the film have bins of 31 bits,
/// so all numbers move by whole bins. At 2¹⁰⁰ W, sums round differently, by 2⁻³¹ of the largest
/// square in a pixel. Variances are above a thousandth of this square. So error maps differ by a
/// relative error below 2⁻²⁰.
///
/// At 2⁻¹⁰⁰ W, about 10⁻³⁰ W, numbers below 2⁻¹²⁶ are subnormal and lose digits, with an error of
/// at most 2⁻¹⁵⁰. A density estimate adds fewer than 2¹⁴ products of two such numbers with a kernel
/// of at most 2/(π r²), where r is at least .01. The total error is 2·2¹⁴·2⁻¹⁵⁰·2¹³ = 2⁻¹²², which
/// is 2⁻²² relative to the power. Relative to the power, pixels are about 2⁻⁵, so their relative
/// error is 2⁻¹⁷. Their noise is a tenth of them, so an error estimate has a relative error of
/// 2·10·2⁻¹⁷.
#[test]
#[ignore = "long: many samples of a hard case"]
fn powers_at_float_limits_render_finitely() {
    let algorithms = WITH_PHOTONS.into_iter().chain([Algorithm::Path]);
    let jobs: Vec<(Algorithm, bool)> = algorithms.flat_map(|a| [(a, false), (a, true)]).collect();
    jobs.par_iter().for_each(|(algorithm, fog)| {
        let settings = Settings { allows_ray_photon_balance: !fog, ..settings(4096, 2) };
        let render = |scale: f32| rendered(&room(scale, *fog), *algorithm, settings.clone(), 4);
        let one = render(1.0);
        assert_finite("1 W", &one);
        let ((estimate, maps), pixels) = (estimates(&one), sums(&one));
        for exponent in [93, 100, -100] {
            let scale = libm::ldexp(1.0, exponent);
            let what = format!("{}, 2^{exponent} W, fog: {fog}", algorithm.name());
            let other = render(scale as f32);
            assert_finite(&what, &other);
            let (other_estimate, other_maps) = estimates(&other);
            let off = |a: DVec3, b: DVec3| (a - b / scale).abs().max_element();
            let off = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| off(*a, *b)).fold(0.0, f64::max);
            let wide = |v: &[Rgb]| v.iter().map(|v| v.as_dvec3()).collect::<Vec<_>>();
            let pixels = off(&pixels, &sums(&other));
            let noise = off(&wide(&maps.noise), &wide(&other_maps.noise));
            let bias = off(&wide(&maps.blur), &wide(&other_maps.blur));
            let ratio = other_estimate.error / estimate.error - 1.0;
            if exponent == 93 {
                assert_eq!((pixels, noise, bias), (0.0, 0.0, 0.0), "{what}");
                assert_eq!(estimate, other_estimate, "{what}");
            } else if exponent > 0 {
                let largest = |v: &[Rgb]| v.iter().map(|v| f64::from(v.max_element())).fold(0.0, f64::max);
                let [most_noise, most_bias] = [&maps.noise, &maps.blur].map(|map| libm::ldexp(largest(map), -20));
                assert!(pixels == 0.0 && noise < most_noise && bias <= most_bias, "{what}: {pixels} {noise} {bias}");
                assert!(ratio.abs() < libm::ldexp(1.0, -20), "{what}: {ratio}");
            } else {
                // Pixels are sums of four passes. The error of a standard error is at most the
                // error of a pass.
                let most = libm::ldexp(1.0, -22);
                assert!(pixels < 4.0 * most && noise < most && bias < 40.0 * most, "{what}: {pixels} {noise} {bias}");
                assert!(ratio.abs() < 20.0 * libm::ldexp(1.0, -17), "{what}: {ratio}");
            }
        }
    });
}

/// A floor lit by a point light of 10⁻³⁰, 1 or 10³⁰ W has the radiance of the closed form.
///
/// The light is at height 1, behind an invisible slab. The radiance is ρ/π times the mean of
/// I/(1 + x²)^{3/2} over a square .2 wide: 1 − 3/2·.2²/6 up to 10⁻⁴. The kernel of radius r = .05
/// changes it by the fraction (r²/12)·6. There are sixteen passes; Student's t with 15 degrees of
/// freedom exceeds 7 once in 10⁵ times.
#[test]
#[ignore = "long: many samples of a hard case"]
fn point_light_flux_matches_closed_form() {
    for power in [1e-30, 1.0, 1e30] {
        let mut b = SceneBuilder::new();
        let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
        b.add_shape(rectangle_around(DVec3::ZERO, DVec3::Z * 4.0, DVec3::X * 4.0), white, Rgb::ZERO);
        add_invisible_slab(&mut b, 40.0);
        let point = UnscaledDeltaLight::Point { position: DVec3::Y };
        b.add_delta_light(point, LightStrength::Power(Rgb::splat(power as f32)));
        let scene = b.build(flat_camera(DVec3::Y * 0.2, -DVec3::Y, 0.2, 8)).unwrap();
        let settings = Settings { initial_gather_radius: Some(0.05), gather_k: Some(0), ..settings(20_000, 4) };
        let method = Algorithm::Sppm.prepare(&scene, settings);
        let mean = |i| render_one_pass(&*method, i).iter().map(|v| f64::from(v.y)).sum::<f64>() / 64.0 / power;
        let (mean, error) = mean_and_error(&(0..16).map(mean).collect::<Vec<f64>>());
        let expected = 0.5 / PI / (4.0 * PI) * (1.0 - 0.01);
        let slack = expected * (0.05 * 0.05 / 2.0 + 1e-4 + STORED_COLOR_ROUNDING);
        assert!((mean - expected).abs() < 7.0 * error + slack, "{power:e} W: {mean} ± {error}, {expected}");
        assert!(error < 0.015 * expected, "{error}");
    }
}

/// Photons beyond the range of single precision are counted and reported instead of stored.
///
/// The scene has two lights of 10³⁸ W per channel. With one photon path, the sum of the color
/// channels of its flux overflows. With 16 paths, all photons are stored. A light beyond the range
/// is refused.
#[test]
fn photons_beyond_float_range_are_reported() {
    let scene = |powers: &[f32]| {
        let mut b = SceneBuilder::new();
        let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), white, Rgb::ZERO);
        for power in powers {
            b.add_delta_light(
                UnscaledDeltaLight::Point { position: DVec3::ZERO },
                LightStrength::Power(Rgb::splat(*power)),
            );
        }
        b.build(flat_camera(DVec3::Y * -0.2, -DVec3::Y, 0.2, 4))
    };
    assert_eq!(scene(&[1e38, 2e38]).err(), Some(BuildError::TooBright(1)));
    let scene = scene(&[1e38, 1e38]).unwrap();
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::DIRECT, max_bounces: 0 };
    let rejected = |paths| {
        let traced = tracer.trace(test_key(9), paths, &|_| {});
        (traced.deposits.len(), traced.deposits.rejected_deposits)
    };
    assert_eq!((rejected(1), rejected(16)), ((0, 1), (16, 0)));
    // `Pm` with gather rays needs photon maps that hold direct light.
    let pass = Algorithm::Pm
        .prepare(&scene, Settings { initial_gather_radius: Some(0.05), ..settings(1, 1) })
        .render_pass(0, &SilentMonitor);
    assert_eq!(pass.counters.rejected_photons, 1);

    let folder = tempfile::tempdir().unwrap();
    let text = "OrthographicCamera { center 0 -.2 0 direction 0 -1 0 up 0 0 1 width 4 height 4 size .2 }
        Background { color 0 0 0 }
        Lights { PointLight { position 0 0 0 power 1e38 1e38 1e38 } PointLight { position 0 0 0 power 1e38 1e38 1e38 } }
        Materials { Diffuse white { reflectance .5 .5 .5 } }
        Group { MaterialName white Sphere { center 0 0 0 radius 1 } }";
    std::fs::write(folder.path().join("a.txt"), text).unwrap();
    let run = |paths: &str| {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        command.current_dir(folder.path()).timeout(PATIENCE);
        command.args(["render", "a.txt", "-o", "a.exr", "--integrator", "pm", "--passes", "2", "--radius", ".05"]);
        let output = command.args(["--photons", paths, "--caustic-photons", paths]).output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    let warning = "photons were not finite and were left out";
    let (few, many) = (run("1"), run("1k"));
    assert!(few.contains(warning) && !many.contains(warning), "{few}\n{many}");
}
