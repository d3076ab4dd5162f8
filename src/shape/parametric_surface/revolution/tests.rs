use super::super::spline::MIN_RELATIVE_KNOT_SPAN;
use super::*;
use glam::Vec3;

fn surface_of_revolution(basis: &SplineBasis, controls: &[[f64; 2]]) -> Revolution {
    let controls: Vec<DVec2> = controls.iter().map(|c| DVec2::from_array(*c)).collect();
    Revolution::new(basis, &controls).unwrap()
}

fn revolved_line_segment(controls: [[f64; 2]; 2]) -> Revolution {
    surface_of_revolution(&SplineBasis::bezier_basis(2).unwrap(), &controls)
}

/// Ray parameter of the nearest hit of a ray with origin `o` and direction `d`.
fn hit_parameter(s: &Revolution, o: Vec3, d: Vec3) -> Option<f32> {
    s.intersect(&Ray::new(o, d)).map(|hit| hit.t)
}

#[test]
fn profile_subdivision_respects_memory_and_precision() {
    let wave: Vec<DVec2> = (0..200).map(|i| DVec2::new(f64::from(1 + i % 2), f64::from(i / 3))).collect();
    let basis = SplineBasis::uniform_spline_basis(3, wave.len()).unwrap();
    let found = Revolution::with_memory_limit(&basis, &wave, Some(10_000)).unwrap_err();
    // The error reports the memory needed at the first leaf beyond the limit, not for the whole
    // surface.
    assert!(matches!(found, SplineError::MemoryLimitExceeded { needed: 10_001..11_000, free: 10_000 }), "{found}");
    assert!(Revolution::with_memory_limit(&basis, &wave, Some(10_000_000)).is_ok());
    let basis = SplineBasis::new(2, 5, vec![0.0, 0.0, 0.0, 0.5, 0.5 + MIN_RELATIVE_KNOT_SPAN, 1.0, 1.0, 1.0]).unwrap();
    let bent = surface_of_revolution(&basis, &[[1.0, 0.0], [2.0, 0.0], [2.0, 3.0], [1.0, 3.0], [1.0, 0.0]]);
    assert!(bent.profile.leaves.iter().all(|leaf| 2.0 * leaf.parameter_half_width >= MIN_RELATIVE_KNOT_SPAN));
}

#[test]
fn revolved_lines_are_cylinders_cones_and_discs() {
    let cylinder = revolved_line_segment([[1.0, -1.0], [1.0, 1.0]]);
    assert_eq!(hit_parameter(&cylinder, Vec3::new(0.0, 0.0, 3.0), -Vec3::Z), Some(2.0));
    assert_eq!(hit_parameter(&cylinder, Vec3::new(0.0, 0.5, 0.0), Vec3::X * 0.5), Some(2.0));
    assert_eq!(hit_parameter(&cylinder, Vec3::new(0.6, -3.0, 3.0), Vec3::new(0.0, 1.0, -1.0)), Some(2.2));
    assert_eq!(hit_parameter(&cylinder, Vec3::new(0.5, -3.0, 0.2), Vec3::Y), None);
    assert_eq!(hit_parameter(&cylinder, Vec3::new(1.0f32.next_up(), 0.0, 3.0), -Vec3::Z), None);
    assert!(hit_parameter(&cylinder, Vec3::new(1.0f32.next_down(), 0.0, 3.0), -Vec3::Z).is_some());
    let cone = revolved_line_segment([[0.0, 1.0], [-1.0, 0.0]]);
    assert_eq!(hit_parameter(&cone, Vec3::new(0.0, 3.0, 0.0), -Vec3::Y), Some(2.0));
    assert_eq!(hit_parameter(&cone, Vec3::new(0.25, 3.0, 0.0), -Vec3::Y), Some(2.25));
    assert_eq!(hit_parameter(&cone, Vec3::new(0.0, 0.5, 3.0), -Vec3::Z), Some(2.5));
    let disc = revolved_line_segment([[0.0, 0.5], [2.0, 0.5]]);
    assert_eq!(hit_parameter(&disc, Vec3::new(1.0, 3.5, 1.0), -Vec3::Y), Some(3.0));
    assert_eq!(hit_parameter(&disc, Vec3::new(0.0, 3.5, 0.0), -Vec3::Y), Some(3.0));
    assert_eq!(hit_parameter(&disc, Vec3::new(1.0, 0.5, 4.0), -Vec3::Z), None, "edge-on");
    assert_eq!(hit_parameter(&disc, Vec3::new(1.5, 3.5, 1.5), -Vec3::Y), None);
}
