use super::super::spline::MIN_RELATIVE_KNOT_SPAN;
use super::*;

/// An eighth of the unit sphere as a rational patch of degrees 2 and 2, with a pole on the y axis.
pub(in crate::shape::parametric_surface) fn sphere_octant_patch() -> Patch {
    let arc = [(1.0, 0.0, 1.0), (1.0, 1.0, std::f64::consts::FRAC_1_SQRT_2), (0.0, 1.0, 1.0)];
    let mut controls = Vec::new();
    for (r, h, w) in arc {
        for (c, s, v) in arc {
            controls.push(DVec4::new(r * c, h, r * s, w * v));
        }
    }
    let basis = SplineBasis::bezier_basis(3).unwrap();
    Patch::new([&basis, &basis], &controls).unwrap()
}

/// The construction of a patch fails at the first leaf that exceeds the memory limit.
#[test]
fn leaf_memory_is_checked_before_allocation() {
    let basis = SplineBasis::bezier_basis(6).unwrap();
    let at = |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
    let controls: Vec<DVec4> = (0..36).map(|i| DVec4::new(at(3 * i), at(3 * i + 1), at(3 * i + 2), 1.0)).collect();
    let bytes = Patch::new([&basis, &basis], &controls).unwrap().memory_bytes();
    assert!(bytes > 500_000, "{bytes}");
    assert!(Patch::with_memory_limit([&basis, &basis], &controls, Some(bytes)).is_ok());
    match Patch::with_memory_limit([&basis, &basis], &controls, Some(bytes / 2)) {
        // The error reports the memory needed at the first leaf beyond the limit, not for the whole
        // surface.
        Err(SplineError::MemoryLimitExceeded { needed, free }) => assert!(free == bytes / 2 && needed < free + 10_000),
        other => panic!("{other:?}"),
    }
}

/// Leaves of a sharply bent patch are at least [`MIN_RELATIVE_KNOT_SPAN`] wide, the narrowest
/// accepted knot span.
#[test]
fn leaves_are_wider_than_float_spacing() {
    let basis = SplineBasis::new(2, 5, vec![0.0, 0.0, 0.0, 0.5, 0.5 + MIN_RELATIVE_KNOT_SPAN, 1.0, 1.0, 1.0]).unwrap();
    let line = SplineBasis::bezier_basis(2).unwrap();
    let profile = [[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [3.0, 3.0], [4.0, 0.0]];
    let controls: Vec<DVec4> =
        profile.iter().flat_map(|[x, y]| [0.0, 1.0].map(|z| DVec4::new(*x, *y, z, 1.0))).collect();
    let patch = Patch::new([&basis, &line], &controls).unwrap();
    assert!(patch.subdivided.leaves.iter().all(|leaf| 2.0 * leaf.parameter_half_widths.x >= MIN_RELATIVE_KNOT_SPAN));
    for i in 0..4000 {
        let x = (i as f32 + 0.5) * 0.001;
        let ray = Ray::new(Vec3::new(x, 5.0, 0.5), Vec3::NEG_Y);
        let ShapeHit { t, shape_coords: uv } = patch.intersect(&ray).unwrap();
        let found = patch.surface_point(&ray, t, uv).p;
        assert!((found - Vec3::new(x, 5.0 - t, 0.5)).length() < 1e-5, "{x} {found}");
    }
}

#[test]
fn rational_quarter_circles_make_a_sphere() {
    let patch = sphere_octant_patch();
    assert!((patch.area() / (std::f64::consts::FRAC_PI_2) - 1.0).abs() < 1e-9, "{}", patch.area());
    for d in [Vec3::ONE, Vec3::new(0.1, 0.7, 0.4), Vec3::new(1e-3, 1.0, 1e-3), Vec3::new(0.5, 0.01, 0.02), Vec3::Y] {
        let d = d.normalize();
        let ray = Ray::new(d * 3.0, -d);
        let ShapeHit { t, shape_coords: uv } = patch.intersect(&ray).unwrap();
        assert!((t - 2.0).abs() < 1e-6, "{d} {t}");
        let p = patch.surface_point(&ray, t, uv);
        assert!((p.p - d).length() < 1e-6 && p.ng.dot(d).abs() > 1.0 - 1e-6, "{d} {p:?}");
    }
}
