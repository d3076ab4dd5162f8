//! Boxes and parallelepipeds: cubes under affine maps.

use super::bounded_shape::BoundedShape;
use super::hit::{f64_ray_parameter, nearer_hit};
use super::object_ray::{ObjectRay, world_coordinate_bound};
use super::surface_point::{EDGE_MARGIN, ShapeSample, SurfacePoint};
use super::texture_mapping::{TexCoord, upright_texture_axes};
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};

/// Box or parallelepiped: the surface of the cube \[−1, 1]³ under an affine map.
///
/// Faces are numbered from 0 to 5. Axis a is 0 for x, 1 for y and 2 for z. In object space, face
/// 2·a lies at −1 on axis a, and face 2·a + 1 at 1. The number `shape_coords.y` of a [`ShapeHit`]
/// is the number of the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    to_world: Transform,
    /// World-space areas \[length²]: entry a is the area of a face perpendicular to the
    /// object-space axis a.
    face_areas: DVec3,
    /// Length of the world-space gradient of each object-space coordinate \[1/length].
    gradient_lengths: DVec3,
}

impl Cuboid {
    /// Axis-aligned box between the world-space corners `min` and `max`; `None` if it has no
    /// volume.
    #[must_use]
    pub fn new(min: DVec3, max: DVec3) -> Option<Self> {
        let (center, half) = (0.5 * min + 0.5 * max, 0.5 * max - 0.5 * min);
        let map = DAffine3 { matrix3: DMat3::from_diagonal(half), translation: center };
        Transform::new(map).ok().map(Self::from_transform)
    }

    /// Box or parallelepiped to which `to_world` maps the cube \[−1, 1]³.
    #[must_use]
    pub fn from_transform(to_world: Transform) -> Self {
        let [x, y, z] = half_edges(&to_world);
        let face_areas = 4.0 * DVec3::new(y.cross(z).length(), z.cross(x).length(), x.cross(y).length());
        let rows = to_world.inverse().matrix3.transpose();
        let max_gradients = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        Self { to_world, face_areas, gradient_lengths: max_gradients }
    }

    /// Returns the object-space point `p` projected to face number `face`, and moved away from the
    /// edges.
    ///
    /// [`EDGE_MARGIN`] explains why surface points keep away from edges.
    #[inline]
    fn project_to_face_interior(&self, p: DVec3, face: usize) -> DVec3 {
        let largest = self.to_world.transform_point(p).abs().max_element();
        let margin = (self.gradient_lengths * (EDGE_MARGIN * f64::from(f32::EPSILON) * largest)).min(DVec3::splat(0.5));
        let mut inside = p.clamp(margin - 1.0, 1.0 - margin);
        inside[face / 2] = face_sign(face);
        inside
    }

    /// World-space surface point at the object-space point `p` of face number `face`.
    #[inline]
    fn face_point(&self, p: DVec3, face: usize) -> SurfacePoint {
        let mut normal = DVec3::ZERO;
        normal[face / 2] = face_sign(face);
        let normal = self.to_world.transform_normal(normal).normalize();
        let point = SurfacePoint::from_f64(
            self.to_world.transform_point(p),
            normal,
            world_coordinate_bound(&self.to_world, 1.0),
        );
        SurfacePoint { shape_coords: Vec2::new(0.0, face as f32), ..point }
    }
}

/// Halves of the three edge vectors, in world space: the columns of the linear part of the map.
fn half_edges(to_world: &Transform) -> [DVec3; 3] {
    let m = to_world.forward().matrix3;
    [m.x_axis, m.y_axis, m.z_axis]
}

/// Object-space coordinate of face `face` along the face's axis: −1 or 1.
#[inline]
fn face_sign(face: usize) -> f64 {
    if face % 2 == 1 { 1.0 } else { -1.0 }
}

/// Number of the face that was hit; `uv` is `shape_coords` of the [`ShapeHit`].
#[inline]
fn face_of_hit(uv: Vec2) -> usize {
    (uv.y as usize).min(5)
}

impl BoundedShape for Cuboid {
    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let local = ObjectRay::new(ray, &self.to_world);
        let (mut near, mut near_face) = (f64::NEG_INFINITY, 0);
        let (mut far, mut far_face) = (f64::INFINITY, 0);
        for axis in 0..3 {
            let (o, d) = (local.base[axis], local.direction[axis]);
            if d == 0.0 {
                if o.abs() > 1.0 {
                    return None;
                }
                continue;
            }
            let positive = usize::from(d > 0.0);
            let exit_side = 1.0f64.copysign(d);
            let (enter, exit) = ((-exit_side - o) / d, (exit_side - o) / d);
            if enter > near {
                (near, near_face) = (enter, 2 * axis + 1 - positive);
            }
            if exit < far {
                (far, far_face) = (exit, 2 * axis + positive);
            }
        }
        if near > far {
            return None;
        }
        nearer_hit(ray, (local.ray_parameter(near), near_face as f32), (local.ray_parameter(far), far_face as f32))
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        let p = ObjectRay::new(ray, &self.to_world).at_ray_parameter(f64_ray_parameter(t, uv));
        let face = face_of_hit(uv);
        self.face_point(self.project_to_face_interior(p, face), face)
    }

    /// Texture coordinates that map each face to the unit square; a picture appears upright from
    /// outside.
    fn tex_coord(&self, p: Vec3, uv: Vec2) -> TexCoord {
        let face = face_of_hit(uv);
        let p = self.to_world.inverse().transform_point3(p.as_dvec3());
        let mut normal = DVec3::ZERO;
        normal[face / 2] = face_sign(face);
        let [u, v] = upright_texture_axes(normal);
        let world = |row: DVec3| self.to_world.transform_normal(0.5 * row);
        TexCoord { uv: DVec2::new(u.dot(p), v.dot(p)) * 0.5 + 0.5, grad_u: world(u), grad_v: world(v) }
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let [x, y, z] = half_edges(&self.to_world);
        let half = x.abs() + y.abs() + z.abs();
        let center = self.to_world.forward().translation;
        (center - half, center + half)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..*self }
    }

    fn transformed(&self, map: &Transform) -> Option<Self> {
        Transform::new(*map.forward() * *self.to_world.forward()).ok().map(Self::from_transform)
    }

    fn area(&self) -> f64 {
        2.0 * self.face_areas.element_sum()
    }

    /// Chooses a face with a probability proportional to its area, then a uniform point of the
    /// face.
    fn sample(&self, u: Vec2) -> ShapeSample {
        let mut rest = f64::from(u.x) * self.area();
        let mut face = 0;
        while face < 5 && rest >= self.face_areas[face / 2] {
            rest -= self.face_areas[face / 2];
            face += 1;
        }
        // Given the face, `rest` is uniform between 0 and the area of the face. It is used in place
        // of a further random number.
        let x = (rest / self.face_areas[face / 2]).min(1.0);
        let axis = face / 2;
        let mut p = DVec3::ZERO;
        p[axis] = face_sign(face);
        p[(axis + 1) % 3] = 2.0 * x - 1.0;
        p[(axis + 2) % 3] = 2.0 * f64::from(u.y) - 1.0;
        let point = self.face_point(p, face);
        ShapeSample { point, pdf: self.pdf(&point), shape_coords: point.shape_coords }
    }
}
