//! Tests of photon maps alone, for various numbers and layouts of photons.

use super::{STORED_COLOR_ROUNDING, photon, random};
use caustica::color::Rgb;
use caustica::photon::{Bandwidth, Kernel, Photon, PhotonMap, PhotonSearchBuffers};
use glam::Vec3;
use rayon::prelude::*;
use std::time::{Duration, Instant};

const KERNELS: [Kernel; 3] = [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov];

fn estimate(map: &PhotonMap, p: Vec3, radius: f32, k: u32, kernel: Kernel) -> f64 {
    let nested = map.estimate_radiance_in_nested_discs(
        p,
        Vec3::Z,
        Bandwidth { radius, k },
        kernel,
        &mut PhotonSearchBuffers::default(),
        |_| Rgb::ONE,
    );
    let levels = nested.radiance;
    assert!(levels.iter().all(|l| l.is_finite()), "{levels:?}");
    f64::from(nested.full_disc.radiance.y)
}

/// A photon estimate includes only photons that arrived on the side of its normal.
///
/// All photons of this test arrived on one side of a wall. Estimates with the normal of this side
/// include all of them. With the opposite or a perpendicular normal, they include none. This holds
/// for a fixed radius and for the k nearest photons.
#[test]
fn photons_count_on_their_side_only() {
    let map = PhotonMap::build((0..10_000).map(|i| photon(random(i) * Vec3::new(1.0, 1.0, 0.0), 1.0)).collect());
    for kernel in KERNELS {
        for k in [0, 50] {
            let found = |normal| {
                let (at, bandwidth) = (Vec3::new(0.5, 0.5, 0.0), Bandwidth { radius: 0.2, k });
                map.estimate_radiance_in_nested_discs(
                    at,
                    normal,
                    bandwidth,
                    kernel,
                    &mut PhotonSearchBuffers::default(),
                    |_| Rgb::ONE,
                )
            };
            // The disc has 1250 photons, or the nearest 50. Any kernel gives at least half of their
            // density.
            assert!(found(Vec3::Z).full_disc.radiance.y > 5_000.0, "{kernel:?}, k = {k}");
            for other in [Vec3::NEG_Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
                let other = found(other);
                assert_eq!(
                    (other.full_disc.radiance, other.radiance.map(|l| l.y)),
                    (Rgb::ZERO, [0.0; 3]),
                    "{kernel:?}, k = {k}"
                );
            }
        }
    }
}

/// Returns the value of a kernel of radius `r` at distance `d`, by its definition.
fn kernel_at(kernel: Kernel, d: f64, r: f64) -> f64 {
    let t = d / r;
    let shape = match kernel {
        Kernel::Box => 1.0,
        Kernel::Cone => 3.0 * (1.0 - t),
        Kernel::Epanechnikov => 2.0 * (1.0 - t * t),
    };
    shape / (std::f64::consts::PI * r * r)
}

/// Estimates are right with fewer than k photons; an empty map gives 0.
///
/// The estimate is Σ Φ K over the largest disc, with flux Φ and kernel K. The tolerance covers
/// rounding of the stored color, of distances (10⁻⁶ of coordinates of .4, in a disc of .5), and of
/// a few operations.
#[test]
fn estimates_hold_with_fewer_than_k_photons() {
    let (radius, p) = (0.5f32, Vec3::new(0.1, 0.2, 0.3));
    for kernel in KERNELS {
        for k in [0, 1, 2, 50, u32::MAX / 4] {
            assert_eq!(estimate(&PhotonMap::build(Vec::new()), p, radius, k, kernel), 0.0);
        }
        for count in 1..5 {
            let offsets = [0.0f32, 0.1, 0.25, 0.4];
            let photons = offsets[..count].iter().map(|x| photon(p + Vec3::X * *x, 1.0 + 10.0 * x)).collect();
            let map = PhotonMap::build(photons);
            let flux = |x: f32| f64::from(1.0 + 10.0 * x) * kernel_at(kernel, x.into(), radius.into());
            let expected: f64 = offsets[..count].iter().map(|x| flux(*x)).sum();
            for k in [0, 5, 50, 10_000_000] {
                let found = estimate(&map, p, radius, k, kernel);
                assert!(
                    (found / expected - 1.0).abs() < STORED_COLOR_ROUNDING + 1e-5,
                    "{kernel:?}, {count} of {k}: {found} {expected}"
                );
            }
            assert_eq!(map.kth_photon_distance(p, Vec3::Z, count as u32 + 1, 1e6), None);
        }
    }
}

/// A million photons at a hundred adjacent single-precision positions are all found.
///
/// A few other photons make the map large. For a fixed radius, the estimate is Φ K(0). For the k
/// nearest photons, it is that of the smallest possible disc, whose radius is 10⁻⁵ of the distance
/// R from the origin. Distances between photons have an error of 6.2·10⁻⁷ R, which is .062 of this
/// radius (see `disc_radius_never_falls_below_position_rounding`). The cone kernel lowers the
/// estimate by up to this fraction.
#[test]
fn million_photons_at_adjacent_floats_are_found() {
    let n = 1_000_000u64;
    let begun = Instant::now();
    let place = |i: u64| {
        let step = |shift: u64| f32::from_bits(0.3f32.to_bits() + ((i >> shift) % 5) as u32);
        Vec3::new(step(0), step(3), step(6))
    };
    let mut photons: Vec<Photon> = (0..n).map(|i| photon(place(i * 7919), 1.1)).collect();
    photons.extend((0..100).map(|i| photon(random(i) * 1000.0 + 5.0, 1.0)));
    let map = PhotonMap::build(photons);
    for kernel in KERNELS {
        for k in [0, 1, 50, 1000] {
            let found = estimate(&map, place(0), 0.1, k, kernel);
            let (r, off) = if k == 0 { (0.1, 1e-5) } else { (1e-5 * f64::from(place(0).length()), 0.062) };
            let expected = 1.1 * n as f64 * kernel_at(kernel, 0.0, r);
            assert!(
                (found / expected - 1.0).abs() < STORED_COLOR_ROUNDING + off,
                "{kernel:?}, k = {k}: {found:e} {expected:e}"
            );
        }
    }
    // Takes a second on an idle machine. Searching each leaf for each photon would take n² = 10¹²
    // steps.
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
}

/// Function from points of the unit cube to positions of photons.
type Layout = fn(Vec3) -> Vec3;

/// Photons in a plane, on a line or at a few points give the estimates of a linear scan.
///
/// The result must lie between linear scans with radii that are 10⁻⁶ of the coordinates smaller and
/// larger.
#[test]
fn coplanar_and_collinear_photons_are_found() {
    let layouts: [(&str, Layout); 5] = [
        ("x = 0", |u| Vec3::new(0.0, u.x, u.y)),
        ("y = −7", |u| Vec3::new(u.x, -7.0, u.y)),
        ("z = 10⁴", |u| Vec3::new(u.x, u.y, 1e4)),
        ("a line", |u| Vec3::new(0.25, u.x, 0.5)),
        ("a hundred points", |u| (u * 4.6).floor() * 0.25),
    ];
    layouts.par_iter().for_each(|(name, layout)| {
        let photons: Vec<Photon> = (0..200_000).map(|i| photon(layout(random(i)), 1.0)).collect();
        let map = PhotonMap::build(photons.clone());
        for i in 0..20 {
            let (p, r) = (photons[i * 9973].position, [0.01f32, 0.1, 0.3][i % 3]);
            let margin = 3e-7 * (p.abs().max_element() + 1.0);
            let mut power = 0.0;
            map.visit_within_radius(p, r, |data, _| power += f64::from(data.flux().y));
            let scan = |r: f32| photons.iter().filter(|q| (q.position - p).length() <= r).count() as f64;
            let (low, high) = (scan(r - margin), scan(r + margin));
            assert!(
                power >= low * (1.0 - STORED_COLOR_ROUNDING) && power <= high * (1.0 + STORED_COLOR_ROUNDING),
                "{name}: {low} {power} {high}"
            );
        }
    });
}

/// A map of ten million photons, in a cube and on a wall, finds the same numbers of photons as a
/// linear scan.
#[test]
#[ignore = "long: ten million photons"]
fn ten_million_photons_are_estimated_correctly() {
    let n = 10_000_000u64;
    let place = |i: u64| if i.is_multiple_of(2) { random(i) } else { random(i) * Vec3::new(1.0, 1.0, 0.0) };
    let photons: Vec<Photon> = (0..n).into_par_iter().map(|i| photon(place(i), 1.0)).collect();
    let kept: Vec<Vec3> = photons.iter().map(|p| p.position).collect();
    let map = PhotonMap::build(photons);
    assert_eq!(map.len() as u64, n);
    (0..8u64).for_each(|i| {
        let (p, r) = (kept[(i * 1_234_567) as usize], 0.02f32);
        let mut found = 0;
        map.visit_within_radius(p, r, |_, _| found += 1);
        let scan = |r: f32| kept.par_iter().filter(|q| (**q - p).length() <= r).count();
        // Distances round by 10⁻⁶ for rotated coordinates up to 1.
        let (low, high) = (scan(r - 1e-6), scan(r + 1e-6));
        assert!(found >= low && found <= high, "{low} {found} {high}");
        assert!(estimate(&map, p, r, 50, Kernel::Epanechnikov) > 0.0);
    });
}

/// Estimates from the nearest 50 photons have no bias at densities of 10³ and 10¹².
///
/// One square is 1 wide and has a thousand photons, the other is 10⁻³ wide and has a million. The
/// relative variance is (k + c − 2)/(k − 2) − 1, with the noise factor c = 4/3 of Epanechnikov's
/// kernel: .0278. In the sparse square, the discs around 36 points have the radius √(50/(10³π)) =
/// .126 and overlap. So their mean is as uncertain as that of 4 independent points. The tolerance
/// is five sigma.
#[test]
fn densities_nine_orders_apart_are_estimated() {
    let sparse = (0..1000).map(|i| photon(Vec3::new(1.0, 0.0, 0.0) + random(i) * Vec3::new(1.0, 1.0, 0.0), 1.0));
    let dense = |i| photon((random(i) - 0.5) * Vec3::new(1e-3, 1e-3, 0.0), 1.0);
    let map = PhotonMap::build(sparse.chain((1000..1_001_000).map(dense)).collect());
    let mean = |at: &dyn Fn(f32, f32) -> Vec3, radius: f32| {
        let places = (0..36).map(|i| at((i % 6) as f32 / 5.0, (i / 6) as f32 / 5.0));
        let estimates = places.map(|p| estimate(&map, p, radius, 50, Kernel::Epanechnikov));
        estimates.sum::<f64>() / 36.0
    };
    let sigma = 0.0278f64.sqrt();
    let sparse = mean(&|x, y| Vec3::new(1.3 + 0.4 * x, 0.3 + 0.4 * y, 0.0), 0.3) / 1e3;
    assert!((sparse - 1.0).abs() < 5.0 * sigma / 2.0, "{sparse}");
    let dense = mean(&|x, y| Vec3::new(x - 0.5, y - 0.5, 0.0) * 8e-4, 0.3) / 1e12;
    assert!((dense - 1.0).abs() < 5.0 * sigma / 6.0, "{dense}");
}
