use super::*;
use crate::math::warp;
use crate::sampling::{Dimension, Key, Purpose};
use std::f64::consts::PI;

fn test_key(i: u64) -> Key {
    Key::new(13).purpose_key(Purpose::Test).child_key(i)
}

/// Random point of the unit cube; `i` selects the random numbers.
fn random_point(i: u64) -> Vec3 {
    test_key(i).uniform_2d(Dimension::LightPosition).extend(test_key(i).uniform_1d(Dimension::Light))
}

fn random_direction(i: u64) -> Vec3 {
    warp::square_to_uniform_sphere(test_key(i).uniform_2d(Dimension::LightDirection))
}

/// `n` random volume photons, photon i at position `at(i)`. The medium index of each photon is its
/// index in the list, so that tests can identify it.
fn random_photons(n: u64, at: impl Fn(u64) -> Vec3) -> Vec<VolumePhoton> {
    (0..n).map(|i| VolumePhoton::new(at(i), Rgb::ONE, random_direction(i), i as u32, 0).unwrap()).collect()
}

#[test]
fn volume_photon_packing_is_precise() {
    assert_eq!(size_of::<VolumePhoton>(), 32);
    let flux = Rgb::new(3.0, 1.0, 0.5);
    let p = VolumePhoton::new(Vec3::ONE, flux, -Vec3::Y, 7, 3).unwrap();
    assert!((p.flux() - flux).abs().max_element() < 4.5 * 1.6e-5 && (p.direction() + Vec3::Y).length() < 1e-4);
    assert_eq!((p.position, p.medium, p.wavelength_code), (Vec3::ONE, 7, 3));
    for flux in [Rgb::ZERO, Rgb::NAN, Rgb::INFINITY, Rgb::new(-1.0, 2.0, 0.0)] {
        assert!(VolumePhoton::new(Vec3::ONE, flux, Vec3::Z, 0, 0).is_none());
    }
    assert!(VolumePhoton::new(Vec3::NAN, Rgb::ONE, Vec3::Z, 0, 0).is_none());
}

/// Map queries find the same photons as a scan in f64. Around points, photons at the radius may
/// differ by rounding.
#[test]
fn queries_match_a_linear_scan() {
    for (size, middle) in [(1.0, Vec3::ZERO), (1e-9, Vec3::ZERO), (1e12, Vec3::ZERO), (1.0, Vec3::new(5e3, 0.0, -7e3))]
    {
        for part in [0.01, 0.2] {
            // An odd number of photons leaves lanes of a packet unused.
            let photons = random_photons(5003, |i| middle + (random_point(i) - 0.5) * size);
            let radius = part * size;
            let map = VolumePhotonMap::build(photons.clone(), radius);
            assert!((map.len(), map.radius()) == (5003, radius));
            let mut count = 0;
            for i in 1_000_000..1_000_100u64 {
                let direction = if i.is_multiple_of(4) {
                    [Vec3::X, Vec3::Y, -Vec3::Z][i as usize / 4 % 3]
                } else {
                    random_direction(i)
                };
                let target = middle + (random_point(i) - 0.5) * size;
                let t_max = [f32::INFINITY, 100.2, 100.0][i as usize % 3] * size;
                let ray = Ray { origin: target - direction * (size * 100.0), direction, t_max };
                assert_ray_query_matches_scan(&map, &photons, &ray);
                count += assert_point_query_matches_scan(&map, &photons, target);
            }
            assert!(count > 0);
        }
    }
}

fn assert_ray_query_matches_scan(map: &VolumePhotonMap, photons: &[VolumePhoton], ray: &Ray) {
    let (r, d) = (f64::from(map.radius()), ray.direction.as_dvec3());
    let mut expected = Vec::new();
    for p in photons {
        let to = p.position.as_dvec3() - ray.origin.as_dvec3();
        let t = to.dot(d) / d.dot(d);
        let x2 = to.cross(d).length_squared() / (d.dot(d) * r * r);
        // At the edge of the kernel, rounding decides if a photon is found, but the weight is
        // almost zero there.
        if x2 < 1.0 - 1e-9 && t > 0.0 && t < f64::from(ray.t_max) {
            expected.push((p.medium, t, 3.0 / (PI * r * r) * (1.0 - x2) * (1.0 - x2)));
        }
    }
    let mut found = Vec::new();
    map.visit_near_ray(ray, |p, t, cos, weight, _| {
        assert_eq!(cos, ray.direction.dot(p.direction()));
        if f64::from(weight) * r * r > 1e-17 {
            found.push((p.medium, f64::from(t), f64::from(weight)));
        }
    });
    found.sort_by_key(|f| f.0);
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(&expected) {
        assert!(
            f.0 == e.0 && (f.1 - e.1).abs() <= 1e-7 * e.1 && (f.2 - e.2).abs() <= 1e-7 * e.2 + 1e-9 / (r * r),
            "{f:?} {e:?}"
        );
    }
}

fn assert_point_query_matches_scan(map: &VolumePhotonMap, photons: &[VolumePhoton], place: Vec3) -> usize {
    let r = f64::from(map.radius());
    let x2 = |p: &VolumePhoton| (p.position.as_dvec3() - place.as_dvec3()).length_squared() / (r * r);
    let mut found = Vec::new();
    map.visit_near_point(place, |p, weight, _| {
        let expected = 15.0 / (8.0 * PI * r * r * r) * (1.0 - x2(p));
        assert!((f64::from(weight) - expected).abs() * r * r * r < 1e-6, "{weight} {expected}");
        found.push(p.medium);
    });
    found.sort_unstable();
    assert!(found.windows(2).all(|w| w[0] < w[1]));
    let within = |x: f64| photons.iter().filter(move |p| x2(p) < x).map(|p| p.medium);
    assert!(within(1.0 - 1e-5).all(|m| found.binary_search(&m).is_ok()));
    assert!(found.len() <= within(1.0 + 1e-5).count());
    found.len()
}

#[test]
fn empty_and_coincident_volume_maps_work() {
    let ray = Ray::new(Vec3::NEG_Z, Vec3::Z);
    let count = |map: &VolumePhotonMap| {
        let (mut line, mut ball) = (0, 0);
        map.visit_near_ray(&ray, |_, _, _, _, _| line += 1);
        map.visit_near_point(Vec3::ZERO, |_, _, _| ball += 1);
        (line, ball)
    };
    assert!(VolumePhotonMap::build(Vec::new(), 1.0).is_empty());
    assert_eq!(count(&VolumePhotonMap::build(Vec::new(), 1.0)), (0, 0));
    assert_eq!(count(&VolumePhotonMap::build(random_photons(50_000, |_| Vec3::ZERO), 0.1)), (50_000, 50_000));
    for radius in [0.0, -1.0, f32::NAN] {
        assert_eq!(count(&VolumePhotonMap::build(random_photons(10, |_| Vec3::ZERO), radius)), (0, 0), "{radius}");
    }
}

#[test]
fn volume_photon_map_is_thread_independent() {
    let ray = Ray::new(Vec3::new(0.1, 0.2, -1.0), Vec3::new(0.36, 0.48, 0.8));
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let map = pool.install(|| VolumePhotonMap::build(random_photons(20_000, |i| random_point(i % 6000)), 0.1));
        let mut all = Vec::new();
        map.visit_near_ray(&ray, |p, _, _, _, _| all.push(p.medium));
        all
    };
    assert!(with(1).len() > 100);
    assert_eq!(with(1), with(3));
}

/// Asserts that the mean of `values` is within four standard errors of `truth`, and that the
/// relative standard error is below `precision`.
fn assert_mean(values: &[f64], truth: f64, precision: f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let error = (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n * (n - 1.0))).sqrt();
    assert!(error < precision * truth, "{error} is too large beside {truth}");
    assert!((mean - truth).abs() < 4.0 * error, "{mean} is not {truth}, give or take {error}");
}

/// The radiance along a ray that crosses parallel light agrees with the closed form of single
/// scattering.
///
/// Photons are stored at their scattering points. The kernel blurs them, which gives the relative
/// bias r²σt²/16 in two dimensions and r²σt²/14 in three. Both are below 3.1·10⁻⁴ here.
#[test]
fn collimated_beam_radiance_is_exact() {
    let (extinction, scattering, depth, across) = (1.3f64, 0.9f64, 0.7f64, 1.6f64);
    let (irradiance, radius) = (2.0, 0.05);
    let ray = Ray { origin: Vec3::new(0.0, 0.0, depth as f32), direction: Vec3::X, t_max: across as f32 };
    let (mut lines, mut balls) = (Vec::new(), Vec::new());
    for run in 0..24u64 {
        let n = 100_000u64;
        let (wide, high) = (across as f32 + 0.2, 0.11);
        // Transmittances at distances 0.1 before and 0.1 beyond the ray. Only photons between them
        // can count.
        let (before, beyond) = (libm::exp(-extinction * (depth - 0.1)), libm::exp(-extinction * (depth + 0.1)));
        let power = (irradiance * f64::from(wide * high) * (before - beyond) / n as f64) as f32;
        let one = |i: u64| {
            let u = random_point(run * n + i);
            let fall = -libm::log(before - f64::from(u.z) * (before - beyond)) / extinction;
            let at = Vec3::new(u.x * wide - 0.1, (u.y - 0.5) * high, fall as f32);
            VolumePhoton::new(at, Rgb::splat(power), Vec3::Z, 0, 0).unwrap()
        };
        let map = VolumePhotonMap::build((0..n).map(one).collect(), radius);
        let part = |p: &VolumePhoton, t: f64, weight: f32| {
            let scattered = f64::from(p.flux().x) * scattering / extinction / (4.0 * PI);
            scattered * libm::exp(-extinction * t) * f64::from(weight)
        };
        let mut line = 0.0;
        map.visit_near_ray(&ray, |p, t, cos, weight, _| {
            assert!(cos.abs() < 1e-4);
            line += part(p, f64::from(t), weight);
        });
        lines.push(line);
        // The midpoint rule takes steps of a fifth of the radius, because the kernel is smooth.
        let (steps, mut ball) = (160u32, 0.0);
        let step = across / f64::from(steps);
        for k in 0..steps {
            let t = (f64::from(k) + 0.5) * step;
            map.visit_near_point(ray.at(t as f32), |p, weight, _| ball += part(p, t, weight) * step);
        }
        balls.push(ball);
    }
    let truth =
        scattering / (4.0 * PI) * irradiance * libm::exp(-extinction * depth) * (1.0 - libm::exp(-extinction * across))
            / extinction;
    assert_mean(&lines, truth, 0.005);
    assert_mean(&balls, truth, 0.005);
}
