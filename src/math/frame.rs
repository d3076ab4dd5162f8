//! Right-handed orthonormal frames (s, t, n).

use glam::Vec3;

/// Right-handed orthonormal frame (s, t, n).
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First axis, a unit vector perpendicular to `n`.
    pub s: Vec3,
    /// Second axis, a unit vector perpendicular to `s` and `n`.
    pub t: Vec3,
    /// Third axis, a unit vector; usually a surface normal.
    pub n: Vec3,
}

impl Frame {
    /// Creates a frame with the unit vector `n` as third axis (Duff et al. 2017, JCGT 6(1)).
    #[inline]
    #[must_use]
    pub fn from_normal(n: Vec3) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// Transforms the vector `v` from world space to the coordinates (s, t, n) of the frame.
    #[inline]
    #[must_use]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Transforms the vector `v` from the coordinates (s, t, n) of the frame to world space.
    #[inline]
    #[must_use]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_at_the_poles_too() {
        let directions = [
            Vec3::Z,
            Vec3::NEG_Z,
            Vec3::X,
            Vec3::new(1e-8, -1e-8, -1.0).normalize(),
            Vec3::new(0.3, -0.5, 0.2).normalize(),
        ];
        for n in directions {
            let f = Frame::from_normal(n);
            for (a, b) in [(f.s, f.t), (f.t, f.n), (f.n, f.s)] {
                assert!(a.dot(b).abs() < 1e-6 && (a.length() - 1.0).abs() < 1e-6, "{n}");
            }
            assert!((f.s.cross(f.t) - f.n).length() < 1e-6);
            let v = Vec3::new(0.1, 0.7, -0.4);
            assert!((f.to_world(f.to_local(v)) - v).length() < 1e-6);
        }
    }
}
