//! Mesh instances, which share the triangles of one mesh under different affine maps.

use super::bounded_shape::BoundedShape;
use super::hit::round_t_if_in_range;
use super::mesh::Mesh;
use super::object_ray::ray_to_object_space;
use super::surface_point::{RELATIVE_TRIANGLE_HIT_ERROR, ShapeSample, SurfacePoint, position_error_bound};
use super::texture_mapping::TexCoord;
use crate::accel::{Bvh, PrimitiveIndex, ShapeHit};
use crate::math::{Ray, Transform, warp};
use crate::sampling::DiscreteDistribution;
use glam::{DVec3, Vec2, Vec3};
use std::sync::{Arc, OnceLock};

/// Mesh in object space with a bounding volume hierarchy. Several instances can share it.
pub struct MeshWithBvh {
    mesh: Mesh,
    bvh: Bvh,
    /// Distribution that selects a triangle in proportion to its area; built at its first use.
    triangle_distribution: OnceLock<Option<DiscreteDistribution>>,
}

impl std::fmt::Debug for MeshWithBvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeshWithBvh").field("triangles", &self.mesh.triangles.len()).finish_non_exhaustive()
    }
}

impl MeshWithBvh {
    /// Builds the bounding volume hierarchy of `mesh`. Hits are most accurate if the mesh is near
    /// the object-space origin.
    #[must_use]
    pub fn new(mesh: Mesh) -> Self {
        let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        Self { bvh: Bvh::build(&corners, &[]), mesh, triangle_distribution: OnceLock::new() }
    }

    /// Distribution that selects a triangle in proportion to its object-space area; `None` if the
    /// total area is 0.
    fn triangle_distribution(&self) -> Option<&DiscreteDistribution> {
        let make = || DiscreteDistribution::new((0..self.mesh.triangles.len()).map(|i| self.mesh.triangle_area(i)));
        self.triangle_distribution.get_or_init(make).as_ref()
    }
}

/// Triangle mesh under an affine map to world space.
///
/// Object-space ray directions are not normalised, so the ray parameter t of a point is the same in
/// object space and in world space. `shape_coords` of a [`ShapeHit`] is (i, 0), where i is an f32
/// whose bits are the triangle's index.
#[derive(Clone, Debug)]
pub struct MeshInstance {
    mesh: Arc<MeshWithBvh>,
    to_world: Transform,
    /// Ratio of world-space to object-space area: |det M|^⅔, where M is the linear part of the map.
    ///
    /// The ratio is exact for uniform scales and approximate for others.
    area_scale: f64,
}

impl MeshInstance {
    /// Instance of `mesh` under the object-to-world map `to_world`.
    #[must_use]
    pub fn new(mesh: Arc<MeshWithBvh>, to_world: Transform) -> Self {
        let edge = libm::cbrt(to_world.determinant().abs());
        Self { mesh, to_world, area_scale: edge * edge }
    }

    /// Number of triangles of the mesh.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.mesh.mesh.triangles.len()
    }

    /// Returns the ray in object space, with its origin moved forward to near the mesh. Also
    /// returns the ray parameter t of this origin on `ray`.
    ///
    /// The origin is moved to two bounding-sphere radii before the point of the ray that is nearest
    /// to the mesh's centre. A ray that starts beyond this place keeps its origin. Rounding errors
    /// in f32 are then proportional to the mesh's size, however far away the ray starts.
    #[inline]
    fn object_ray_near_mesh(&self, ray: &Ray) -> (Ray, f64) {
        let (o, d) = ray_to_object_space(ray, &self.to_world);
        let around = self.mesh.bvh.bounds().bounding_sphere();
        let length = d.length();
        let to = around.center.as_dvec3() - o;
        let start = ((to.dot(d) / length - 2.0 * f64::from(around.radius)) / length).max(0.0);
        let origin = (o + d * start).as_vec3();
        (Ray { origin, direction: d.as_vec3(), t_max: (f64::from(ray.t_max) - start) as f32 }, start)
    }

    /// World-space surface point of triangle `i` at the barycentric weights `b`.
    ///
    /// `b` holds the weights of the second and third corner.
    fn surface_at(&self, i: usize, b: Vec2) -> SurfacePoint {
        let own = self.mesh.mesh.surface_point(i, b);
        let p = self.to_world.transform_point(own.p.as_dvec3()).as_vec3();
        let normal = |n: Vec3| self.to_world.transform_normal(n.as_dvec3()).normalize_or_zero().as_vec3();
        let (ng, ns) = (normal(own.ng), normal(own.ns));
        // The error bound covers three roundings: of the point in object space, of the point in
        // world space, and of the next ray's origin in object space. Only errors along the normal
        // count, since a shift within the triangle's plane does no harm.
        let n = own.ng.as_dvec3();
        let rounded = n.abs().dot((own.position_error + own.p.abs() * f32::EPSILON).as_dvec3())
            / self.to_world.transform_normal(n).length();
        let reach = f64::from(p.abs().max_element()) + self.to_world.forward().translation.abs().max_element();
        let position_error = position_error_bound(p, reach) + Vec3::splat(rounded as f32);
        SurfacePoint { p, position_error, ng: if ng.dot(ns) < 0.0 { -ng } else { ng }, ns, shape_coords: b }
    }
}

impl BoundedShape for MeshInstance {
    fn transformed(&self, map: &Transform) -> Option<Self> {
        let to_world = Transform::new(*map.forward() * *self.to_world.forward()).ok()?;
        Some(Self::new(Arc::clone(&self.mesh), to_world))
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (near, start) = self.object_ray_near_mesh(ray);
        let hit = self.mesh.bvh.closest_hit(&near, |_, _| None)?;
        let t = round_t_if_in_range(ray, start + f64::from(hit.t))?;
        match hit.primitive {
            PrimitiveIndex::Triangle(i) => Some(ShapeHit { t, shape_coords: Vec2::new(f32::from_bits(i), 0.0) }),
            PrimitiveIndex::Other(_) => None,
        }
    }

    #[inline]
    fn occludes(&self, ray: &Ray) -> bool {
        self.mesh.bvh.occluded(&self.object_ray_near_mesh(ray).0, |_, _| false)
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, _t: f32, uv: Vec2) -> SurfacePoint {
        let (o, d) = ray_to_object_space(ray, &self.to_world);
        let i = uv.x.to_bits() as usize;
        let [a, b, c] = self.mesh.mesh.corners(i).map(|v| v.as_dvec3());
        // The f32 test of the bounding volume hierarchy selected the triangle. The intersection
        // with the triangle's plane is computed again in f64.
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let q = (o - a).cross(e1);
        let determinant = e1.dot(p);
        let weights = glam::DVec2::new((o - a).dot(p), d.dot(q)) / determinant;
        self.surface_at(i, clamp_to_triangle(weights))
    }

    fn tex_coord(&self, p: Vec3, uv: Vec2) -> TexCoord {
        let i = uv.x.to_bits() as usize;
        let p = self.to_world.inverse().transform_point3(p.as_dvec3());
        let [a, b, c] = self.mesh.mesh.corners(i).map(|v| v.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let cross = e1.cross(e2);
        let weights = glam::DVec2::new(e2.cross(cross).dot(p - a), cross.cross(e1).dot(p - a)) / cross.length_squared();
        let own = self.mesh.mesh.tex_coord(i, clamp_to_triangle(weights));
        TexCoord {
            grad_u: self.to_world.transform_normal(own.grad_u),
            grad_v: self.to_world.transform_normal(own.grad_v),
            ..own
        }
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let corners = self.mesh.bvh.bounds().corners().map(|c| self.to_world.transform_point(c.as_dvec3()));
        let fold = |f: fn(DVec3, DVec3) -> DVec3| corners.iter().copied().reduce(f).unwrap_or(DVec3::ZERO);
        (fold(DVec3::min), fold(DVec3::max))
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..self.clone() }
    }

    fn area(&self) -> f64 {
        self.mesh.triangle_distribution().map_or(0.0, |choice| choice.weight_sum() * self.area_scale)
    }

    fn sample(&self, u: Vec2) -> ShapeSample {
        let (i, b) = match self.mesh.triangle_distribution() {
            Some(choice) => {
                let (i, _) = choice.sample(u.x);
                // Given the triangle, the position of u.x in the triangle's interval is uniform. It
                // is used in place of a second random number.
                (i, warp::square_to_uniform_triangle(Vec2::new(choice.remapped_sample(u.x, i), u.y)))
            }
            None => (0, Vec2::ZERO),
        };
        let uv = Vec2::new(f32::from_bits(i as u32), 0.0);
        ShapeSample { point: self.surface_at(i, b), pdf: (1.0 / self.area()) as f32, shape_coords: uv }
    }

    #[inline]
    fn relative_hit_error(&self) -> f32 {
        RELATIVE_TRIANGLE_HIT_ERROR
    }
}

/// Clamps barycentric weights of the second and third corner to the triangle.
///
/// Weights that are not finite become 0, which is the first corner.
fn clamp_to_triangle(weights: glam::DVec2) -> Vec2 {
    let w = if weights.is_finite() { weights.max(glam::DVec2::ZERO) } else { glam::DVec2::ZERO };
    let sum = w.x + w.y;
    (if sum > 1.0 { w / sum } else { w }).as_vec2()
}
