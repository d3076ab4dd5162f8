use super::super::spline::NARROWEST;
use super::*;
use glam::Vec3;

fn surface(basis: &Basis, controls: &[[f64; 2]]) -> Revolution {
    let controls: Vec<DVec2> = controls.iter().map(|c| DVec2::from_array(*c)).collect();
    Revolution::new(basis, &controls).unwrap()
}

fn line(controls: [[f64; 2]; 2]) -> Revolution {
    surface(&Basis::bezier(2).unwrap(), &controls)
}

fn hit(s: &Revolution, o: Vec3, d: Vec3) -> Option<f32> {
    s.intersect(&Ray::new(o, d)).map(|c| c.0)
}

#[test]
fn profile_subdivision_respects_memory_and_precision() {
    let wave: Vec<DVec2> = (0..200).map(|i| DVec2::new(f64::from(1 + i % 2), f64::from(i / 3))).collect();
    let basis = Basis::uniform(3, wave.len()).unwrap();
    let found = Revolution::within(&basis, &wave, Some(10_000)).unwrap_err();
    // It stops at the first leaf beyond the limit.
    assert!(matches!(found, SplineError::Memory { needed: 10_001..11_000, free: 10_000 }), "{found}");
    assert!(Revolution::within(&basis, &wave, Some(10_000_000)).is_ok());
    let basis = Basis::new(2, 5, vec![0.0, 0.0, 0.0, 0.5, 0.5 + NARROWEST, 1.0, 1.0, 1.0]).unwrap();
    let bent = surface(&basis, &[[1.0, 0.0], [2.0, 0.0], [2.0, 3.0], [1.0, 3.0], [1.0, 0.0]]);
    assert!(bent.profile.leaves.iter().all(|leaf| 2.0 * leaf.place[1] >= NARROWEST));
}

#[test]
fn revolved_lines_are_cylinders_cones_and_discs() {
    let cylinder = line([[1.0, -1.0], [1.0, 1.0]]);
    assert_eq!(hit(&cylinder, Vec3::new(0.0, 0.0, 3.0), -Vec3::Z), Some(2.0));
    assert_eq!(hit(&cylinder, Vec3::new(0.0, 0.5, 0.0), Vec3::X * 0.5), Some(2.0));
    assert_eq!(hit(&cylinder, Vec3::new(0.6, -3.0, 3.0), Vec3::new(0.0, 1.0, -1.0)), Some(2.2));
    assert_eq!(hit(&cylinder, Vec3::new(0.5, -3.0, 0.2), Vec3::Y), None);
    assert_eq!(hit(&cylinder, Vec3::new(1.0f32.next_up(), 0.0, 3.0), -Vec3::Z), None);
    assert!(hit(&cylinder, Vec3::new(1.0f32.next_down(), 0.0, 3.0), -Vec3::Z).is_some());
    let cone = line([[0.0, 1.0], [-1.0, 0.0]]);
    assert_eq!(hit(&cone, Vec3::new(0.0, 3.0, 0.0), -Vec3::Y), Some(2.0));
    assert_eq!(hit(&cone, Vec3::new(0.25, 3.0, 0.0), -Vec3::Y), Some(2.25));
    assert_eq!(hit(&cone, Vec3::new(0.0, 0.5, 3.0), -Vec3::Z), Some(2.5));
    let disc = line([[0.0, 0.5], [2.0, 0.5]]);
    assert_eq!(hit(&disc, Vec3::new(1.0, 3.5, 1.0), -Vec3::Y), Some(3.0));
    assert_eq!(hit(&disc, Vec3::new(0.0, 3.5, 0.0), -Vec3::Y), Some(3.0));
    assert_eq!(hit(&disc, Vec3::new(1.0, 0.5, 4.0), -Vec3::Z), None, "edge-on");
    assert_eq!(hit(&disc, Vec3::new(1.5, 3.5, 1.5), -Vec3::Y), None);
}
