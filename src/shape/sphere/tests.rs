use super::*;
use crate::sampling::{Dimension, Key, Purpose};

#[test]
fn rays_hit_spheres_at_known_distances() {
    let s = Sphere::new(DVec3::ZERO, 1.0);
    let hit = |o: Vec3, d: Vec3| s.intersect(&Ray::new(o, d)).map(|hit| hit.t);
    assert_eq!(hit(Vec3::new(0.0, 0.0, 3.0), -Vec3::Z), Some(2.0));
    assert_eq!(hit(Vec3::ZERO, Vec3::X * 0.5), Some(2.0));
    assert_eq!(hit(Vec3::new(0.0, 1.0, 3.0), -Vec3::Z), Some(3.0));
    assert_eq!(hit(Vec3::new(0.0, 1.0f32.next_up(), 3.0), -Vec3::Z), None);
    assert_eq!(hit(Vec3::new(0.0, 0.0, -3.0), -Vec3::Z), None);
}

#[test]
fn rays_that_end_before_the_sphere_miss() {
    let s = Sphere::new(DVec3::ZERO, 1.0);
    let mut ray = Ray::new(Vec3::new(0.0, 0.0, 3.0), -Vec3::Z);
    ray.t_max = 1.5;
    assert!(s.intersect(&ray).is_none(), "the far root must not stand in for a near one beyond the end");
}

/// A point sampled by solid angle is the first hit of the ray towards it.
///
/// The mean cosine between the sampled directions and the cone's axis is that of a uniform cone.
#[test]
fn sampled_visible_points_are_first_hits() {
    let s = Sphere::new(DVec3::new(0.5, 1.0, -2.0), 0.6);
    for (from, n) in [(Vec3::new(3.0, 0.0, 1.0), 20_000u64), (Vec3::new(0.5, 1.61, -2.0), 20_000)] {
        let axis = (s.center.as_vec3() - from).normalize();
        let mut sum = 0.0f64;
        for i in 0..n {
            let u = Key::new(9).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::LightPosition);
            let SolidAngleSampleResult::Sampled(SolidAngleSample { point, .. }) = s.sample_solid_angle(from, u) else {
                panic!("the sphere is visible")
            };
            let w = (point.p - from).normalize();
            sum += f64::from(w.dot(axis));
            if let Some(ShapeHit { t, .. }) = s.intersect(&Ray::new(from, w)) {
                let reached = (point.p - from).length();
                assert!((t - reached).abs() < 2e-3 * reached.max(0.05), "{t} {reached}");
            }
        }
        let d2 = (s.center - from.as_dvec3()).length_squared();
        let cos_max = (1.0 - s.radius * s.radius / d2).sqrt();
        let sigma = (1.0 - cos_max) / (12.0 * n as f64).sqrt();
        assert!((sum / n as f64 - 0.5 * (1.0 + cos_max)).abs() < 5.0 * sigma + 1e-6);
    }
    let inside = s.sample_solid_angle(s.center.as_vec3(), Vec2::splat(0.5));
    assert!(matches!(inside, SolidAngleSampleResult::Invisible));
}
