use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// Solid angle \[sr] of a triangle seen from the origin.
///
/// Source: van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle".
fn triangle_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
    2.0 * atan2(a.dot(b.cross(c)).abs(), denominator)
}

/// Solid angle \[sr], seen from the origin, of the rectangle at z = −`z` with x and y in the given
/// ranges.
fn range_solid_angle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> f64 {
    let [a, b, c, d] = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec3::new(x, y, -z));
    triangle_solid_angle([a, b, c]) + triangle_solid_angle([a, c, d])
}

/// The sampled point divides the rectangle in the ratios of `u`, measured by solid angle. This
/// holds from views in front of the rectangle to views a millionth of its size above its plane.
#[test]
fn samples_are_uniform_in_solid_angle_at_grazing_views() {
    let mut checked = 0;
    for i in 0..4000 {
        let key = Key::new(7).purpose_key(Purpose::Test).child_key(i);
        let random = |j: u64| f64::from(key.child_key(j).uniform_2d(Dimension::LightPosition).x);
        let z = libm::exp10(-6.0 * random(0)) as f32;
        let (corner, size) = (DVec2::new(random(1), random(2)) * 3.0 - 2.0, DVec2::new(random(3), random(4)) * 2.0);
        let rectangle = Rectangle::new(corner.extend(0.0), DVec3::Y * size.y, DVec3::X * size.x);
        let u = key.child_key(5).uniform_2d(Dimension::LightPosition);
        let from = Vec3::new(0.0, 0.0, -z);
        let Some(view) = rectangle.rectangle_view(from) else { continue };
        checked += 1;

        // The first edge of the rectangle is parallel to the y axis here.
        let (first, second) = view.sample(u);
        let (along_first, along_second, z) =
            ([corner.y, corner.y + size.y], [corner.x, corner.x + size.x], f64::from(z));
        let whole = range_solid_angle(along_first, along_second, z);
        assert!((view.solid_angle / whole - 1.0).abs() < 1e-8, "{z} {view:?}");
        let part = range_solid_angle([along_first[0], first], along_second, z);
        assert!((part / whole - f64::from(u.x)).abs() < 1e-8, "{z} {u}: {}", part / whole);
        // `u.y` is a fraction of the solid angle of a thin strip through the point: the part below
        // the point.
        let strip = [first - 1e-5 * z.min(size.y), first + 1e-5 * z.min(size.y)];
        let below = range_solid_angle(strip, [along_second[0], second], z);
        let ratio = below / range_solid_angle(strip, along_second, z);
        assert!((ratio - f64::from(u.y)).abs() < 1e-4, "{z} {u}: {ratio}");
    }
    assert!(checked > 1000, "{checked}");
}
