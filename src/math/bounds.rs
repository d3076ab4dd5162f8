//! Bounding volumes: axis-aligned boxes and spheres.

use glam::Vec3;

/// Axis-aligned box. It is empty if `min` exceeds `max` along any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Corner with the smallest coordinates.
    pub min: Vec3,
    /// Corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The empty box. The union of the empty box and another box is the other box.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Smallest box that contains `points`; empty if there are none.
    #[must_use]
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Smallest box that contains the boxes `self` and `other`.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if the box contains no point.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// True if the boxes share a point.
    #[inline]
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Edge lengths of the box along x, y and z; zero for an empty box.
    #[inline]
    #[must_use]
    pub fn extent(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Center of the box; the origin for an empty box.
    #[inline]
    #[must_use]
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min * 0.5 + self.max * 0.5 }
    }

    /// The box expanded by `margin` on every side.
    #[inline]
    #[must_use]
    pub fn expanded(self, margin: f32) -> Self {
        Self { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }

    /// The eight corners of the box.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 0 { lo } else { hi };
            Vec3::new(pick(0, self.min.x, self.max.x), pick(1, self.min.y, self.max.y), pick(2, self.min.z, self.max.z))
        })
    }

    /// Smallest sphere that contains the box. The sphere passes through the eight corners of the
    /// box.
    ///
    /// An empty box gives a sphere of radius 0.
    #[must_use]
    pub fn bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere { center: self.center(), radius: 0.5 * self.extent().length() }
    }
}

/// Sphere that contains an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Center of the sphere.
    pub center: Vec3,
    /// Radius of the sphere \[length], at least zero.
    pub radius: f32,
}

impl BoundingSphere {
    /// Smallest sphere that contains the spheres `self` and `other`, up to rounding.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let d = other.center - self.center;
        let distance = d.length();
        if distance + other.radius <= self.radius {
            self
        } else if distance + self.radius <= other.radius {
            other
        } else {
            let radius = 0.5 * (distance + self.radius + other.radius);
            Self { center: self.center + d * ((radius - self.radius) / distance), radius }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_box_is_neutral_in_unions() {
        let b = Bounds::from_points([Vec3::ONE, Vec3::NEG_ONE]);
        assert_eq!(b.union(Bounds::EMPTY), b);
        assert!(Bounds::EMPTY.is_empty() && !b.is_empty());
        assert_eq!(Bounds::EMPTY.extent(), Vec3::ZERO);
    }

    #[test]
    fn bounding_spheres_contain_boxes_and_spheres() {
        let b = Bounds::from_points([Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.5, 9.0)]);
        let s = b.bounding_sphere();
        assert!(b.corners().iter().all(|c| (*c - s.center).length() <= s.radius * (1.0 + 1e-6)));
        let other = BoundingSphere { center: Vec3::new(20.0, 0.0, 0.0), radius: 2.0 };
        let u = s.union(other);
        for ball in [s, other] {
            assert!((ball.center - u.center).length() + ball.radius <= u.radius * (1.0 + 1e-6));
        }
        assert_eq!(u.union(s), u);
    }
}
