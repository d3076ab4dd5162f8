//! Tests of distance samples, transmittance and emission against closed forms of the optical depth.
//!
//! τ = ∫ρ along the ray is the integral of the density ρ. Then the transmittance is T = exp(−σt τ).
//! The total scattering weight is σs(1 − T)/σt, and the emitted radiance is ε(1 − T)/σt.

use super::*;
use glam::DAffine3;

/// A medium whose channels differ: one scatters and absorbs, one only absorbs, and one has no
/// extinction.
fn medium_with_different_channels(density: Option<GridDensity>) -> Medium {
    let [a, s, e] = [Vec3::new(0.1, 0.5, 0.0), Vec3::new(1.3, 0.0, 0.0), Vec3::new(0.2, 3.0, 1.0)];
    medium_with_density(a, s, e, density)
}

/// A medium in which all channels scatter, blue the most.
fn bluish_medium(density: Option<GridDensity>) -> Medium {
    medium_with_density(Vec3::new(0.0, 0.3, 0.1), Vec3::new(0.05, 0.4, 2.0), Vec3::new(0.0, 0.0, 0.5), density)
}

fn medium_with_density(a: Vec3, s: Vec3, e: Vec3, density: Option<GridDensity>) -> Medium {
    match density {
        None => Medium::homogeneous(a, s, e, PhaseFunction::Isotropic),
        Some(field) => Medium::heterogeneous(a, s, e, PhaseFunction::Isotropic, Arc::new(field)),
    }
}

/// Compares distance samples, transmittance and emission along `ray`, up to `distance`, with closed
/// forms. `depth` is the integral of density as a function of distance.
fn assert_distance_samples_unbiased(medium: &Medium, ray: &Ray, distance: f32, depth: impl Fn(f64) -> f64, name: &str) {
    let sigma = medium.extinction().as_dvec3();
    let tau = depth(f64::from(distance));
    let transmittance = (-sigma * tau).to_array().map(libm::exp);
    let transmittance = DVec3::from_array(transmittance);
    // `gathered` is ∫ exp(−στ) dτ and `moment` is ∫ τ exp(−στ) dτ. At σ = 0, they are τ and τ²/2.
    let limit = |whole: DVec3, at_zero: f64| DVec3::select(sigma.cmpgt(DVec3::ZERO), whole, DVec3::splat(at_zero));
    let gathered = limit((1.0 - transmittance) / sigma, tau);
    let moment = limit((1.0 - transmittance * (1.0 + sigma * tau)) / (sigma * sigma), 0.5 * tau * tau);
    let mut random = test_rng(2);
    let n = if medium.is_homogeneous() { 200_000 } else { 100_000 };

    let mut light = [RunningMean::default(), RunningMean::default()];
    for _ in 0..n {
        light[0].add_sample(medium.transmittance(ray, distance, &mut random).as_dvec3());
        light[1].add_sample(medium.emitted_radiance(ray, distance, &mut random).as_dvec3());
    }
    light[0].assert_near_with_value_bound(transmittance, DVec3::ONE, &format!("{name}: transmittance"));
    light[1].assert_near(gathered * medium.emission.as_dvec3(), &format!("{name}: emission"));

    for throughput in [Vec3::ONE, Vec3::new(0.01, 0.3, 2.0)] {
        let mut means = [RunningMean::default(), RunningMean::default(), RunningMean::default()];
        let whole = throughput.element_sum();
        for _ in 0..n {
            let distance_sample = medium.distance_sample(ray, distance, throughput, &mut random);
            let w = distance_sample.weight.as_dvec3();
            // Roulette raises only small throughputs, and never above the throughput at the start.
            assert!(
                (throughput * distance_sample.weight).element_sum() <= whole * (1.0 + 1e-6),
                "{name}: {distance_sample:?}"
            );
            let t = distance_sample.scattering_distance.map_or(0.0, f64::from);
            let passed_through = f64::from(u8::from(distance_sample.scattering_distance.is_none()));
            assert!((0.0..=f64::from(distance)).contains(&t));
            means[0].add_sample(w * passed_through);
            means[1].add_sample(w * (1.0 - passed_through));
            means[2].add_sample(w * (1.0 - passed_through) * depth(t));
        }
        let scattering = medium.scattering.as_dvec3();
        // The channel mean of throughput · weight is at most that of the throughput. This bounds
        // each weight.
        let most = f64::from(whole) / throughput.as_dvec3();
        means[0].assert_near_with_value_bound(transmittance, most, &format!("{name}: through of {throughput}"));
        means[1].assert_near_with_value_bound(
            gathered * scattering,
            most,
            &format!("{name}: scattered of {throughput}"),
        );
        means[2].assert_near_with_value_bound(
            moment * scattering,
            most * tau,
            &format!("{name}: depth of scattering of {throughput}"),
        );
    }
}

#[test]
fn homogeneous_media_match_beer_lambert() {
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    for distance in [0.01, 1.5, 12.0] {
        assert_distance_samples_unbiased(&medium_with_different_channels(None), &ray, distance, |t| t, "homogeneous");
        assert_distance_samples_unbiased(&bluish_medium(None), &ray, distance, |t| t, "bluish");
    }
    let medium = bluish_medium(None);
    for distance in [0.0f32, 0.3, 7.0, 400.0] {
        let found = medium.transmittance(&ray, distance, &mut test_rng(3));
        for i in 0..3 {
            let truth = libm::exp(-f64::from(medium.extinction()[i]) * f64::from(distance)) as f32;
            assert!((found[i] - truth).abs() <= f32::EPSILON * truth, "{distance}");
        }
    }
}

#[test]
fn distance_weights_match_their_pdf() {
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    let (medium, throughput) = (bluish_medium(None), Vec3::new(0.01, 0.3, 2.0));
    let mut random = test_rng(4);
    for _ in 0..1000 {
        let distance_sample = medium.distance_sample(&ray, f32::INFINITY, throughput, &mut random);
        let t = distance_sample.scattering_distance.expect("every channel has extinction");
        let transmittance = medium.transmittance(&ray, t, &mut random);
        let expected = medium.scattering * transmittance / medium.distance_pdf(t, throughput).unwrap();
        // A rounding error of 1 ulp in t changes the transmittance by σt·t ulps, at most 2.1 · 30.
        assert!(
            (distance_sample.weight - expected).abs().max_element() <= 1e-5 * expected.max_element(),
            "{distance_sample:?} {expected}"
        );
    }
    // The midpoint rule covers 20 mean free paths of the red channel. The rest of the integral is
    // below 10⁻⁸.
    let (n, end) = (400_000, 400.0);
    let sum: f64 =
        (0..n).map(|i| f64::from(medium.distance_pdf((i as f32 + 0.5) * (end / n as f32), throughput).unwrap())).sum();
    assert!((sum * f64::from(end) / f64::from(n) - 1.0).abs() < 1e-5, "{sum}");
    assert!(bluish_medium(Some(constant_density_grid(1.0))).distance_pdf(1.0, throughput).is_none());
}

/// A grid of constant density in a rotated and sheared box.
fn constant_density_grid(density: f32) -> GridDensity {
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.8);
    let place =
        turn * DAffine3::from_scale(DVec3::new(4.0, 30.0, 20.0)) * DAffine3::from_translation(DVec3::splat(-0.5));
    GridDensity::new([21, 3, 9], vec![density; 21 * 3 * 9], place).unwrap()
}

#[test]
fn constant_grid_equals_homogeneous_slab() {
    let field = constant_density_grid(1.7);
    let axis = field.unit_cube_to_scene().matrix3.x_axis.normalize().as_vec3();
    // Up to rounding, the slab extends from distance 1 to distance 5 along the ray.
    let ray = Ray::new(axis * -3.0, axis);
    let depth = |t: f64| 1.7f32 as f64 * (t - 1.0).clamp(0.0, 4.0);
    for distance in [0.5, 2.0, 30.0] {
        assert_distance_samples_unbiased(
            &medium_with_different_channels(Some(field.clone())),
            &ray,
            distance,
            depth,
            "slab",
        );
    }
    assert_distance_samples_unbiased(&bluish_medium(Some(field)), &ray, 30.0, depth, "bluish slab");
}

/// Estimates in a medium of linear density match closed forms of the optical depth.
///
/// The density is x/2 from x = 0 to x = 4, on 20 cells. It is constant in the outer halves of the
/// first and last cell. Rays run along x and obliquely.
#[test]
fn linear_density_matches_its_optical_depth() {
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(4.0, 100.0, 100.0),
        glam::DQuat::IDENTITY,
        DVec3::new(0.0, -50.0, -50.0),
    );
    let field = GridDensity::from_fn([20, 9, 1], place, |p| (2.0 * p.x) as f32).unwrap();
    let (low, high) = (0.1, 3.9);
    let across = |x: f64| {
        let x = x.clamp(0.0, 4.0);
        let m = x.clamp(low, high);
        0.25 * (m * m - low * low) + 0.5 * (low * x.min(low) + high * (x - high).max(0.0))
    };
    for (direction, name) in
        [(Vec3::X, "ramp"), (Vec3::new(0.6, 0.8, 0.0), "aslant"), (Vec3::new(-0.6, 0.0, 0.8), "back")]
    {
        let dx = f64::from(direction.x);
        let start = if dx > 0.0 { -1.0 } else { 3.5 };
        let ray = Ray::new(Vec3::new(start, 0.3, 0.2), direction);
        let depth = |t: f64| (across(f64::from(start) + dx * t) - across(f64::from(start))) / dx;
        assert_distance_samples_unbiased(&bluish_medium(Some(field.clone())), &ray, 3.0, depth, name);
        assert_distance_samples_unbiased(&medium_with_different_channels(Some(field.clone())), &ray, 30.0, depth, name);
    }
}

/// Compares estimates in a cloud with closed forms of the optical depth. A midpoint rule of 40,000
/// steps integrates this depth with a relative error below 10⁻⁶.
#[test]
fn clouds_match_their_optical_depth() {
    let cloud = Cloud { octaves: 4, frequency: 3.0, cover: 0.8, softness: 0.3, seed: 5 };
    let place = DAffine3::from_scale(DVec3::splat(6.0));
    let field = GridDensity::from_fn([40, 33, 27], place, |p| 3.0 * cloud.density_function(0.0)(p)).unwrap();
    let ray = Ray::new(Vec3::new(-1.0, 1.5, 2.0), Vec3::new(6.0, 2.1, 1.3).normalize());
    let (n, distance) = (40_000usize, 8.0f32);
    let step = f64::from(distance) / n as f64;
    let mut table = vec![0.0];
    for i in 0..n {
        let t = (i as f64 + 0.5) * step;
        table.push(table[i] + step * f64::from(field.density(ray.at(t as f32))));
    }
    assert!(table[n] > 0.5, "{}", table[n]);
    let depth = |t: f64| {
        let i = ((t / step) as usize).min(n - 1);
        table[i] + (table[i + 1] - table[i]) * (t / step - i as f64)
    };
    assert_distance_samples_unbiased(&bluish_medium(Some(field.clone())), &ray, distance, depth, "cloud");
    assert_distance_samples_unbiased(&medium_with_different_channels(Some(field)), &ray, distance, depth, "cloud");
}
