//! Parts of surfaces of revolution that are near each other.

use super::super::super::spline::SplineBasis;
use super::*;
use crate::math::Transform;
use crate::shape::bounded_shape::BoundedShape;
use glam::{DAffine3, DVec2, Vec2};

fn surface(basis: &SplineBasis, controls: &[[f64; 2]]) -> Revolution {
    let controls: Vec<DVec2> = controls.iter().map(|c| DVec2::from_array(*c)).collect();
    Revolution::new(basis, &controls).unwrap()
}

/// Where a liquid and its glass are within the margin, the interval of each is flagged; nearly
/// all other intervals are not.
#[test]
fn flags_cover_what_is_near_and_little_more() {
    let (basis, margin) = (SplineBasis::bezier_basis(4).unwrap(), 0.003);
    let wall = [[0.2, 0.0], [0.6, 0.1], [0.4, 0.9], [0.5, 1.6]];
    let liquid = [[0.0, 0.2], [0.8, 0.2], [0.8, 1.0], [0.0, 1.0]];
    let map = Transform::IDENTITY.translated(DVec3::new(3.0, -1.0, 0.5));
    let (wall, liquid) = (surface(&basis, &wall), surface(&basis, &liquid).translated(DVec3::Y * 0.01));
    let [wall, liquid] = [wall, liquid].map(|s| s.transformed(&map).unwrap());
    for (a, b) in [(&wall, &liquid), (&liquid, &wall)] {
        assert!(a.shares_axis(b));
        let flags = a.profile_intervals_near(b, margin);
        let points = |s: &Revolution| -> Vec<(f32, DVec3)> {
            (0..4000).map(|i| i as f32 / 4000.0).map(|u| (u, s.point_at_uv(Vec2::new(u, 0.3)))).collect()
        };
        let others = points(b);
        let mut near = vec![false; PROFILE_INTERVALS];
        for (u, p) in points(a) {
            near[Revolution::profile_interval(u)] |= others.iter().any(|(_, q)| p.distance(*q) < margin);
        }
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
        assert!(near.iter().zip(&flags).all(|(near, flag)| *flag || !*near));
        assert!(count(&near) > 0 && count(&flags) < PROFILE_INTERVALS / 16, "{} {}", count(&near), count(&flags));
    }
}

#[test]
fn surfaces_beside_or_across_each_other_do_not_share_an_axis() {
    let line = SplineBasis::bezier_basis(2).unwrap();
    let tube = surface(&line, &[[1.0, -1.0], [1.0, 1.0]]);
    let moved = |map: Transform| tube.transformed(&map).unwrap();
    assert!(tube.shares_axis(&moved(Transform::IDENTITY.translated(DVec3::Y * 0.3))));
    for other in [
        moved(Transform::IDENTITY.translated(DVec3::X * 1e-6)),
        moved(Transform::new(DAffine3::from_rotation_z(0.01)).unwrap()),
        moved(Transform::new(DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.01))).unwrap()),
    ] {
        assert!(!tube.shares_axis(&other));
        assert_eq!(tube.profile_intervals_near(&other, 1e-3), vec![true; PROFILE_INTERVALS]);
    }
}
