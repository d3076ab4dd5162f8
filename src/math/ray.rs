//! Rays, and robust ray origins on surfaces.

use glam::Vec3;

/// Ray `origin + t · direction` with 0 < t < `t_max`.
///
/// The direction need not be a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin in world or object space \[length].
    pub origin: Vec3,
    /// Direction with any length above zero.
    pub direction: Vec3,
    /// Exclusive upper bound of the ray parameter t.
    pub t_max: f32,
}

impl Ray {
    /// Creates a ray with infinite `t_max`.
    #[inline]
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }

    /// Creates the ray from `origin` that reaches `target` at t = 1, its exclusive end.
    #[inline]
    #[must_use]
    pub fn between_points(origin: Vec3, target: Vec3) -> Self {
        Self { origin, direction: target - origin, t_max: 1.0 }
    }

    /// Point at the ray parameter `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Returns a point next to the surface point `p` from which a ray can leave in `direction` without
/// hitting the surface at `p` again.
///
/// `error` bounds the error of `p` along each axis, and `normal` is the unit geometric normal. The
/// exact surface point lies in the box of half-widths `error` around `p`. `p` is moved along the
/// normal until it is outside this box, and then rounded outward (Pharr, Jakob, Humphreys 2023,
/// section 6.8.6).
#[inline]
#[must_use]
pub fn offset_ray_origin(p: Vec3, error: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    let distance = normal.abs().dot(error);
    let offset = if direction.dot(normal) < 0.0 { -normal * distance } else { normal * distance };
    let moved = p + offset;
    let outward = |x: f32, o: f32| {
        if o > 0.0 {
            x.next_up()
        } else if o < 0.0 {
            x.next_down()
        } else {
            x
        }
    };
    Vec3::new(outward(moved.x, offset.x), outward(moved.y, offset.y), outward(moved.z, offset.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_ray_origins_lie_outside_the_error_box() {
        let (p, error) = (Vec3::new(1e4, -3.0, 0.5), Vec3::splat(1e-3));
        let normal = Vec3::new(0.6, 0.8, 0.0);
        for direction in [Vec3::X, -Vec3::X] {
            let o = offset_ray_origin(p, error, normal, direction);
            let side = direction.dot(normal).signum();
            for corner in 0..8u32 {
                let sign = |b: u32| if corner >> b & 1 == 1 { 1.0 } else { -1.0 };
                let q = p + error * Vec3::new(sign(0), sign(1), sign(2));
                let height = (o - q).as_dvec3().dot(normal.as_dvec3()) * f64::from(side);
                assert!(height >= -1e-9, "{height}");
            }
        }
    }
}
