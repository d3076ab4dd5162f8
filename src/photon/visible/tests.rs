//! Tests of the importance of photons, which visible points define.

use super::*;
use crate::sampling::{Dimension, Key, Purpose, sobol_2d};

/// Map of 4096 visible points of weight 3 on the unit square of the floor, seen from above.
fn visible_floor_map(radius: f32) -> VisiblePointMap {
    let key = Key::new(4).purpose_key(Purpose::Test);
    let point = |i| {
        let u = sobol_2d(i, key, Dimension::Film);
        VisiblePoint { position: Vec3::new(u.x, 0.0, u.y), position_error: Vec3::ZERO, normal: Vec3::Y, weight: 3.0 }
    };
    VisiblePointMap::new((0..4096).map(point), radius)
}

#[test]
fn importance_is_squared_weight_per_visible_area() {
    let visible = visible_floor_map(0.05);
    let at = |x: f32, y: f32, normal: Vec3| {
        visible.squared_photon_importance(Vec3::new(x, y, 0.5), normal, &mut PhotonSearchBuffers::default())
    };
    // An estimate from 16 neighbours has the relative standard deviation 1/√16. The mean of 64
    // estimates has 1/32. The tolerance is five standard errors.
    let mean = (0..64).map(|i| at(0.2 + 0.01 * i as f32, 0.0, Vec3::Y)).sum::<f32>() / 64.0;
    assert!((mean / (9.0 * 4096.0) - 1.0).abs() < 5.0 / 32.0, "{mean}");
    assert_eq!(at(0.5, 0.0, Vec3::NEG_Y), 0.0);
    assert_eq!(at(0.5, 0.1, Vec3::Y), 0.0);
    assert_eq!(at(1.1, 0.0, Vec3::Y), 0.0);
    assert!(at(1.01, 0.0, Vec3::Y) > 0.0, "photons count beyond the last point");
}

#[test]
fn radius_grows_to_cover_sparse_points() {
    let visible = visible_floor_map(1e-6);
    for i in 0..64 {
        let p = Vec3::new(0.2 + 0.01 * i as f32, 0.0, 0.5);
        assert!(visible.squared_photon_importance(p, Vec3::Y, &mut PhotonSearchBuffers::default()) > 0.0);
    }
}

#[test]
fn invalid_points_have_no_importance() {
    let lost = VisiblePoint { position: Vec3::NAN, position_error: Vec3::ZERO, normal: Vec3::Y, weight: 1.0 };
    let dark = VisiblePoint { position: Vec3::ZERO, position_error: Vec3::ZERO, normal: Vec3::Y, weight: 0.0 };
    let visible = VisiblePointMap::new([lost, dark], 1.0);
    assert_eq!(visible.squared_photon_importance(Vec3::ZERO, Vec3::Y, &mut PhotonSearchBuffers::default()), 0.0);
}
