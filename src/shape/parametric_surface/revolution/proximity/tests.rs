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

/// Asserts that all profile intervals of `a` within `margin` of `b` are flagged, and that fewer
/// than 1/16 of all intervals are flagged. Points at two opposite azimuths stand for the circles
/// around the axis.
#[track_caller]
fn assert_flags(a: &Revolution, b: &Revolution, margin: f64) {
    let points = |s: &Revolution| -> Vec<(f32, DVec3)> {
        let parameters = (0..1200).map(|i| i as f32 / 1200.0);
        parameters.flat_map(|u| [0.3, 0.8].map(|turns| (u, s.point_at_uv(Vec2::new(u, turns))))).collect()
    };
    let (flags, others) = (a.near_profile_interval_flags(b, margin), points(b));
    let mut near = vec![false; PROFILE_INTERVALS];
    for (u, p) in points(a) {
        near[Revolution::profile_interval_index(u)] |=
            others.iter().any(|(_, q)| p.distance_squared(*q) < margin * margin);
    }
    let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
    assert!(near.iter().zip(&flags).all(|(near, flag)| *flag || !*near));
    assert!(count(&near) > 0 && count(&flags) < PROFILE_INTERVALS / 16, "{} {}", count(&near), count(&flags));
}

/// The flags of a glass wall and a liquid cover the profile intervals near the other surface. The
/// second liquid's profile lies on the other side of the axis, and the third crosses the axis. The
/// maps shift, tilt, stretch and mirror both surfaces.
#[test]
fn flags_cover_what_is_near_and_little_more() {
    let basis = SplineBasis::bezier_basis(4).unwrap();
    let wall = surface(&basis, &[[0.2, 0.0], [0.6, 0.1], [0.4, 0.9], [0.5, 1.6]]);
    let liquids = [
        [[0.0, 0.2], [0.8, 0.2], [0.8, 1.0], [0.0, 1.0]],
        [[0.0, 0.2], [-0.8, 0.2], [-0.8, 1.0], [0.0, 1.0]],
        [[-0.3, 0.2], [0.9, 0.2], [0.9, 1.0], [0.0, 1.0]],
    ];
    let maps = [
        DAffine3::from_translation(DVec3::new(3.0, -1.0, 0.5)),
        DAffine3::from_rotation_z(0.7),
        DAffine3::from_scale(DVec3::new(1.5, 1.0, 1.5)),
        DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)),
    ];
    for liquid in liquids {
        let liquid = surface(&basis, &liquid).translated(DVec3::Y * 0.01);
        for map in maps {
            let map = Transform::new(map).unwrap();
            let [wall, liquid] = [&wall, &liquid].map(|s| s.transformed(&map).unwrap());
            assert!(wall.shares_axis(&liquid) && liquid.shares_axis(&wall));
            assert_flags(&wall, &liquid, 0.003);
            assert_flags(&liquid, &wall, 0.003);
        }
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
        // A tube with an elliptic cross-section (axes 1 : 2) that is tiny compared with the height.
        moved(Transform::new(DAffine3::from_scale(DVec3::new(1e-5, 1.0, 2e-5))).unwrap()),
    ] {
        assert!(!tube.shares_axis(&other));
        assert_eq!(tube.near_profile_interval_flags(&other, 1e-3), vec![true; PROFILE_INTERVALS]);
    }
}
