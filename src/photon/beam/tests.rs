use super::*;
use crate::math::warp;
use crate::sampling::{Dimension, Key, Purpose};
use std::f64::consts::PI;

fn test_key(i: u64) -> Key {
    Key::new(12).purpose_key(Purpose::Test).child_key(i)
}

/// Random point of the unit cube; `i` selects the random numbers.
fn random_point(i: u64) -> Vec3 {
    test_key(i).uniform_2d(Dimension::LightPosition).extend(test_key(i).uniform_1d(Dimension::Light))
}

fn random_direction(i: u64) -> Vec3 {
    warp::square_to_uniform_sphere(test_key(i).uniform_2d(Dimension::LightDirection))
}

fn unit_flux_beam(start: Vec3, direction: Vec3, length: f32) -> PhotonBeam {
    PhotonBeam::new(start, direction, length, Rgb::ONE, 0, 0).unwrap()
}

/// `n` random beams that start in a cube of edge `size` around `middle`.
///
/// Some are short, some long, and some parallel to an axis. The medium index of a beam is its index
/// in the list, so that tests can identify it.
fn random_beams(n: u64, size: f32, middle: Vec3) -> Vec<PhotonBeam> {
    let one = |i: u64| {
        let direction =
            if i.is_multiple_of(5) { [Vec3::X, -Vec3::Y, Vec3::Z][i as usize / 5 % 3] } else { random_direction(i) };
        let length = size * [0.003, 0.3, 2.0][i as usize % 3];
        PhotonBeam { medium: i as u32, ..unit_flux_beam(middle + (random_point(i) - 0.5) * size, direction, length) }
    };
    (0..n).map(one).collect()
}

fn random_rays(n: u64, size: f32, middle: Vec3) -> impl Iterator<Item = Ray> {
    (0..n).map(move |i| {
        let (i, axes) = (i + 1_000_000, [Vec3::X, Vec3::Y, -Vec3::Z]);
        let direction = if i.is_multiple_of(4) { axes[i as usize / 4 % 3] } else { random_direction(i) };
        let t_max = [f32::INFINITY, 2.0, 0.3][i as usize % 3] * size;
        Ray { origin: middle + (random_point(i) - 0.5) * size - direction * (0.5 * size), direction, t_max }
    })
}

fn visited_beams(map: &PhotonBeamMap, ray: &Ray) -> Vec<(u32, u32)> {
    let mut all = Vec::new();
    map.visit_near_ray(ray, |beam, crossing| all.push((beam.medium, crossing.weight.to_bits())));
    all
}

/// Map queries find the same intersections as a scan over all beams, bit by bit, also at scales
/// where rounding matters.
#[test]
fn queries_match_a_linear_scan() {
    for (size, middle) in [(1.0, Vec3::ZERO), (1e-12, Vec3::ZERO), (1e9, Vec3::ZERO), (1.0, Vec3::new(5e3, -7e3, 0.0))]
    {
        for part in [1e-4f32, 0.01, 0.3] {
            let (beams, radius) = (random_beams(3001, size, middle), part * size);
            let map = PhotonBeamMap::build(beams.clone(), radius);
            assert!((map.len(), map.radius()) == (3001, radius));
            let mut count = 0;
            for ray in random_rays(60, size, middle) {
                let mut all = visited_beams(&map, &ray);
                all.sort_unstable();
                let scan = |b: &PhotonBeam| {
                    BeamIntersection::new(&ray, b, radius.into()).map(|c| (b.medium, c.weight.to_bits()))
                };
                let expected: Vec<(u32, u32)> = beams.iter().filter_map(scan).collect();
                assert_eq!(all, expected, "{size} {radius}");
                count += all.len();
            }
            assert!(part < 0.01 || count > 100, "{count}");
        }
    }
}

/// A ray that passes near the boundary between two pieces of a beam visits the beam exactly once,
/// in spite of rounding.
#[test]
fn split_beams_are_visited_once() {
    let radius = 0.02;
    let beams = random_beams(900, 1.0, Vec3::splat(30.0));
    let map = PhotonBeamMap::build(beams.clone(), radius);
    let mut count = 0;
    for (i, piece) in (0..).zip(split_beams(&beams, optimal_beam_piece_length(&beams, radius))) {
        let beam = &beams[piece.beam as usize];
        let direction = random_direction(2_000_000 + i);
        let target = beam.point_at(piece.to.into()).as_vec3();
        let ray = Ray::new(target - direction * [0.1, 10.0, 300.0][i as usize % 3], direction);
        let expected = usize::from(BeamIntersection::new(&ray, beam, radius.into()).is_some());
        assert_eq!(visited_beams(&map, &ray).iter().filter(|f| f.0 == beam.medium).count(), expected);
        count += expected;
    }
    assert!(count > 1000, "{count}");
}

/// The distance between the closest points equals the minimum of the distance between any points of
/// the two lines.
#[test]
fn intersection_is_the_closest_approach() {
    let mut count = 0;
    for (i, ray) in (0..20_000).zip(random_rays(20_000, 1.0, Vec3::ZERO)) {
        let beam = unit_flux_beam(random_point(i) - 0.5, random_direction(i), 1.0);
        let (d, b, w) =
            (ray.direction.as_dvec3(), beam.direction.as_dvec3(), (beam.start.as_dvec3() - ray.origin.as_dvec3()));
        let (dd, bb, db, dw, bw) = (d.dot(d), b.dot(b), d.dot(b), d.dot(w), b.dot(w));
        let det = dd * bb - db * db;
        let (t, s) = ((bb * dw - db * bw) / det, (db * dw - dd * bw) / det);
        let distance = (w + b * s - d * t).length();
        let x = distance / 0.2;
        let inside = t > 0.0 && t < f64::from(ray.t_max) && s > 0.0 && s < 1.0 && x < 1.0;
        let crossing = BeamIntersection::new(&ray, &beam, 0.2);
        assert_eq!(crossing.is_some(), inside, "{t} {s} {x}");
        if let Some(c) = crossing {
            count += 1;
            let weight = 0.75 / 0.2 * (1.0 - x * x) / det.sqrt();
            // The f64 arithmetic loses the factor 1/sin² of precision. Results are then rounded to
            // f32.
            let error = 1e-7 + 1e-15 / det;
            assert!((f64::from(c.t) - t).abs() < error * (1.0 + t) && (f64::from(c.s) - s).abs() < error * (1.0 + s));
            assert!(
                (f64::from(c.weight) - weight).abs() <= error * (weight + 4.0) && (f64::from(c.cos) - db).abs() < 1e-7
            );
        }
    }
    assert!(count > 500, "{count}");
}

/// The integral of [`BeamIntersection::weight`] over the distance between two lines at angle θ is
/// 1/sin θ (midpoint rule).
#[test]
fn beam_kernel_has_unit_integral() {
    let (n, radius, sine) = (2000, 0.3, 0.6);
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_max: 10.0 };
    let mut sum = 0.0;
    for i in 0..n {
        let height = radius * ((2 * i + 1) as f32 / n as f32 - 1.0);
        let beam = unit_flux_beam(Vec3::new(1.0, -1.0, height), Vec3::new(0.8, sine, 0.0), 9.0);
        let crossing = BeamIntersection::new(&ray, &beam, radius.into()).unwrap();
        sum += crossing.weight * sine * 2.0 * radius / n as f32;
        assert!((crossing.cos - 0.8).abs() < 1e-6 && (crossing.s * sine - 1.0).abs() < 1e-6);
    }
    // The midpoint rule errs by n⁻², the sum of n terms by at most γ(n).
    assert!((sum - 1.0).abs() < rounding_error_bound(n), "{sum}");
}

#[test]
fn beam_and_ray_ends_are_respected() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_max: 2.0 };
    let meets = |x: f32, from: f32, to: f32| {
        let map = PhotonBeamMap::build(vec![unit_flux_beam(Vec3::new(x, from, 0.01), Vec3::Y, to - from)], 0.1);
        let all = visited_beams(&map, &ray).len();
        assert!(all <= 1);
        all == 1
    };
    assert!(meets(1.0, -1.0, 1.0) && meets(1.0, -1e-3, 7.0) && meets(1.0, -7.0, 1e-3));
    assert!(!meets(1.0, 1e-3, 1.0) && !meets(1.0, -1.0, -1e-3));
    assert!(meets(1e-3, -1.0, 1.0) && meets(1.999, -1.0, 1.0));
    assert!(!meets(-1e-3, -1.0, 1.0) && !meets(2.001, -1.0, 1.0));
}

/// Lines that are parallel up to rounding have no intersection; all other lines have one with
/// finite weight.
#[test]
fn nearly_parallel_lines_have_finite_weight() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_max: 10.0 };
    let at = |sine: f32| {
        BeamIntersection::new(&ray, &unit_flux_beam(Vec3::new(0.0, -sine, 0.01), Vec3::new(1.0, sine, 0.0), 10.0), 0.1)
    };
    assert!(at(0.0).is_none() && at(3e-7).is_none());
    for sine in [1e-6, 1e-3] {
        let c = at(sine).unwrap();
        assert!((c.t - 1.0).abs() < 1e-6 && (c.weight * sine / (7.5 * 0.99) - 1.0).abs() < 1e-6, "{c:?}");
    }
}

#[test]
fn invalid_beams_are_rejected() {
    let new = |start, direction, length, flux| PhotonBeam::new(start, direction, length, flux, 0, 0).is_some();
    assert!(new(Vec3::ZERO, Vec3::Z, 1.0, Rgb::X));
    for flux in [Rgb::ZERO, Rgb::NAN, Rgb::INFINITY, Rgb::new(-1.0, 2.0, 0.0)] {
        assert!(!new(Vec3::ZERO, Vec3::Z, 1.0, flux));
    }
    for length in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(!new(Vec3::ZERO, Vec3::Z, length, Rgb::ONE));
    }
    for vector in [Vec3::NAN, Vec3::INFINITY] {
        assert!(!new(vector, Vec3::Z, 1.0, Rgb::ONE) && !new(Vec3::ZERO, vector, 1.0, Rgb::ONE));
    }
    assert!(!new(Vec3::ZERO, Vec3::ZERO, 1.0, Rgb::ONE));
    let bad = PhotonBeam { length: f32::NAN, ..unit_flux_beam(Vec3::ZERO, Vec3::X, 1.0) };
    let ray = Ray::new(Vec3::NEG_Y, Vec3::Y);
    for radius in [0.0, -1.0, f32::NAN] {
        assert!(visited_beams(&PhotonBeamMap::build(random_beams(100, 1.0, Vec3::ZERO), radius), &ray).is_empty());
    }
    let map = PhotonBeamMap::build(vec![bad], 1.0);
    assert!(map.is_empty() && visited_beams(&map, &ray).is_empty());
}

#[test]
fn beam_map_is_small_and_thread_independent() {
    for radius in [1e-9, 0.01, 10.0] {
        let beams = random_beams(5000, 1.0, Vec3::ZERO);
        let pieces = split_beams(&beams, optimal_beam_piece_length(&beams, radius)).len();
        assert!(pieces as f64 <= MAX_MEAN_BEAM_PIECES * 5000.0 && pieces >= 5000, "{pieces}");
    }
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let map = pool.install(|| PhotonBeamMap::build(random_beams(5000, 1.0, Vec3::ZERO), 0.01));
        random_rays(30, 1.0, Vec3::ZERO).map(|ray| visited_beams(&map, &ray)).collect::<Vec<_>>()
    };
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

/// The beam estimate of the radiance along a ray that crosses parallel light equals the closed
/// form.
///
/// The beams are uniform across the kernel, so the kernel adds no bias.
#[test]
fn collimated_beam_radiance_is_exact() {
    let (extinction, scattering, depth, across) = (1.3f64, 0.9f64, 0.7f64, 1.6f64);
    let irradiance = 2.0;
    let ray = Ray { origin: Vec3::new(0.0, 0.0, depth as f32), direction: Vec3::X, t_max: across as f32 };
    let run = |run: u64| {
        let n = 20_000u64;
        // Across the ray, the beams fill a width of 1, more than the kernel. Along the ray, they
        // extend ½ beyond each end.
        let flux = (irradiance * (across + 1.0) / n as f64) as f32;
        let one = |i: u64| {
            let u = test_key(run * n + i).uniform_2d(Dimension::LightPosition);
            let start = Vec3::new(u.x * (across as f32 + 1.0) - 0.5, u.y - 0.5, 0.0);
            PhotonBeam::new(start, Vec3::Z, 3.0, Rgb::splat(flux), 0, 0).unwrap()
        };
        let map = PhotonBeamMap::build((0..n).map(one).collect(), 0.1);
        let mut sum = 0.0;
        map.visit_near_ray(&ray, |beam, c| {
            let transmittance = libm::exp(-extinction * (f64::from(c.t) + f64::from(c.s)));
            sum += f64::from(beam.flux.x) * scattering / (4.0 * PI) * transmittance * f64::from(c.weight);
        });
        sum
    };
    let truth =
        scattering / (4.0 * PI) * irradiance * libm::exp(-extinction * depth) * (1.0 - libm::exp(-extinction * across))
            / extinction;
    assert_mean(&(0..16).map(run).collect::<Vec<_>>(), truth, 0.01);
}

/// In a ball filled with uniform random chords, the beam estimate gives the mean fluence Σ beam
/// length · flux/volume.
#[test]
fn isotropic_chords_give_mean_fluence() {
    let ray = Ray { origin: Vec3::new(-0.5, 0.1, 0.2), direction: Vec3::new(0.8, -0.36, 0.48), t_max: 1.1 };
    let (mut sums, mut lengths) = (Vec::new(), 0.0);
    let (runs, n) = (16, 100_000);
    for run in 0..runs {
        let one = |i: u64| {
            let direction = random_direction(run * n + i);
            let (a, b) = direction.any_orthonormal_pair();
            let p = warp::square_to_uniform_disc(test_key(run * n + i).uniform_2d(Dimension::LightPosition));
            let half = (1.0 - p.length_squared()).max(0.0).sqrt();
            PhotonBeam::new(a * p.x + b * p.y - direction * half, direction, 2.0 * half, Rgb::ONE, 0, 0)
        };
        let beams: Vec<PhotonBeam> = (0..n).filter_map(one).collect();
        lengths += beams.iter().map(|b| f64::from(b.length)).sum::<f64>() / runs as f64;
        let mut sum = 0.0;
        PhotonBeamMap::build(beams, 0.05).visit_near_ray(&ray, |_, c| sum += f64::from(c.weight));
        sums.push(sum);
    }
    // Chords of a ball of radius 1 have the mean length 4/3 and the standard deviation √2/3.
    assert!((lengths / n as f64 - 4.0 / 3.0).abs() < 5.0 * 0.4715 / ((runs * n) as f64).sqrt());
    assert_mean(&sums, lengths / (4.0 * PI / 3.0) * 1.1, 0.01);
}
