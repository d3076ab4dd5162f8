//! Tests of photon map queries.

use super::*;
use crate::color::Rgb;
use crate::sampling::{Dimension, Key, Purpose};

fn photon_facing_z(position: Vec3, power: f32) -> Photon {
    Photon::new(position, Rgb::splat(power), Vec3::Z, Vec3::Z).unwrap()
}

fn random_photons(n: u64, place: impl Fn(Vec3) -> Vec3) -> Vec<Photon> {
    let draw = |i| {
        let key = Key::new(2).purpose_key(Purpose::Test).child_key(i);
        place(key.uniform_2d(Dimension::LightPosition).extend(key.uniform_1d(Dimension::Light)))
    };
    (0..n).map(|i| photon_facing_z(draw(i), 1.0)).collect()
}

fn count_photons_within(map: &PhotonMap, p: Vec3, r: f32) -> usize {
    let mut n = 0;
    map.visit_within_radius(p, r, |_, _| n += 1);
    n
}

#[test]
fn rotation_matrix_is_orthonormal() {
    let identity = ROTATION.transpose() * ROTATION;
    assert!(identity.abs_diff_eq(Mat3::IDENTITY, 3e-7), "{identity}");
    assert!((ROTATION.determinant() - 1.0).abs() < 3e-7);
}

#[test]
fn maps_of_zero_and_one_photon() {
    let empty = PhotonMap::build(Vec::new());
    assert!(empty.is_empty() && count_photons_within(&empty, Vec3::ZERO, 1e9) == 0);
    let one = PhotonMap::build(vec![photon_facing_z(Vec3::ONE, 1.0)]);
    assert_eq!(
        (one.len(), count_photons_within(&one, Vec3::ONE, 0.1), count_photons_within(&one, Vec3::ZERO, 0.1)),
        (1, 1, 0)
    );
}

/// Map queries find the same photons as a scan over all photons, except at distances that equal the
/// search radius up to rounding.
#[test]
fn queries_match_a_linear_scan() {
    let layouts: [fn(Vec3) -> Vec3; 4] =
        [|u| u, |u| Vec3::new(u.x, 0.25, u.y), |u| Vec3::new(u.x, 0.5, 0.5), |u| (u * 4.0).floor() * 0.25];
    for layout in layouts {
        let photons = random_photons(20_000, layout);
        let map = PhotonMap::build(photons.clone());
        let expected = photons.len();
        let kept = map.len();
        assert!(kept == expected || expected - kept > 1000, "only crowds are merged");
        for (i, r) in [(3usize, 0.05f32), (777, 0.2), (9999, 0.011)] {
            let p = photons[i].position;
            let mut power = 0.0;
            map.visit_within_radius(p, r, |data, _| power += data.flux().x);
            let scan = |r: f32| photons.iter().filter(|q| (q.position - p).length() <= r).count() as f32;
            assert!(power >= scan(r - 1e-5) * 0.9999 && power <= scan(r + 1e-5) * 1.0001, "{power} {}", scan(r));
        }
    }
}

#[test]
fn million_photons_on_one_wall_are_counted_right() {
    let map = PhotonMap::build(random_photons(1_000_000, |u| Vec3::new(u.x, 0.0, u.y)));
    assert_eq!(map.len(), 1_000_000);
    let n = count_photons_within(&map, Vec3::new(0.5, 0.0, 0.5), 0.1);
    let expected = 1e6 * std::f64::consts::PI * 0.01;
    assert!((n as f64 - expected).abs() < 5.0 * expected.sqrt(), "{n}");
}

#[test]
fn coincident_photons_merge_to_their_total_flux() {
    let mut photons = vec![photon_facing_z(Vec3::splat(0.3), 2.0); 100_000];
    photons.extend(random_photons(1000, |u| u));
    let map = PhotonMap::build(photons);
    assert_eq!(map.len(), 1001);
    let mut power = 0.0;
    map.visit_within_radius(Vec3::splat(0.3), 1e-4, |data, d2| {
        assert_eq!(d2, 0.0);
        power += data.flux().x;
    });
    assert!((power / 200_000.0 - 1.0).abs() < 1e-5);
}

/// Merging photons at one position keeps, for each wavelength, the flux that density estimates use.
#[test]
fn merged_photons_keep_wavelengths_and_shares() {
    let mut photons = Vec::new();
    for i in 0..900u32 {
        let photon = photon_facing_z(Vec3::splat(0.3), 1.0 + (i % 7) as f32);
        photons.push(photon.with_wavelength_code((i % 3) as u8).with_density_estimate_share((i % 5) as u8 * 3));
    }
    let used_flux = |photons: &mut dyn Iterator<Item = PhotonAttributes>| {
        let mut sums = [0.0; 3];
        photons.for_each(|p| sums[usize::from(p.wavelength_code())] += p.flux().x * p.density_estimate_share());
        sums
    };
    let before = used_flux(&mut photons.iter().map(|photon| photon.attributes));
    let map = PhotonMap::build(photons);
    assert_eq!(map.len(), 15);
    let mut merged = Vec::new();
    map.visit_within_radius(Vec3::splat(0.3), 1e-4, |photon, _| merged.push(*photon));
    for (before, after) in before.into_iter().zip(used_flux(&mut merged.into_iter())) {
        assert!((after / before - 1.0).abs() < 1e-4, "{before} {after}");
    }
}
