//! Area lights that may lie in several dielectric bodies.

use super::cull_air_boundaries::may_bound_body;
use crate::math::Bounds;
use crate::scene::Scene;
use crate::scene::geometry::Geometry;
use crate::shape::{Plane, Shape};
use glam::Vec3;

/// Fraction of a sphere's radius. A point surely lies inside the sphere if its distance from the
/// center is below this fraction of the radius; the margin covers rounding errors.
const INNER_RADIUS: f32 = 0.9999;

/// Returns a flag for each light: true if it is a surface that may lie partly inside a dielectric
/// body.
///
/// This is the case if the light's box meets the boundary of a body: a plane, a sphere, the box of
/// a triangle, or the box of another shape. The object of the light itself does not count, because
/// light starts on the outer side of this object.
pub(super) fn find_lights_across_boundaries(scene: &Scene) -> Vec<bool> {
    let geometry = &scene.geometry;
    let mut flags = vec![false; scene.lights.len()];
    let bounded_objects = || 0..geometry.shapes.len() + geometry.mesh_ranges.len();
    let boxes_of = |is_wanted: &dyn Fn(usize) -> bool| -> Vec<(usize, Bounds)> {
        bounded_objects().filter(|i| is_wanted(*i)).map(|i| (i, object_bounds(geometry, i))).collect()
    };
    let lamps = boxes_of(&|i| geometry.objects[i].light.is_some());
    if lamps.is_empty() {
        return flags;
    }
    let boundaries = boxes_of(&|i| may_bound_body(&scene.materials, geometry.objects[i].material));
    let planes = geometry.planes.iter().zip(geometry.plane_object_attributes());
    let planes: Vec<&Plane> = planes
        .filter(|(_, attributes)| may_bound_body(&scene.materials, attributes.material))
        .map(|(plane, _)| plane)
        .collect();
    for (lamp, extent) in &lamps {
        if let Some(light) = geometry.objects[*lamp].light {
            let crosses = |(other, bounds): &(usize, Bounds)| {
                other != lamp && extent.overlaps(bounds) && object_may_meet_box(geometry, *other, extent)
            };
            flags[light as usize] =
                boundaries.iter().any(crosses) || planes.iter().any(|plane| plane_meets_box(plane, extent));
        }
    }
    flags
}

/// Returns the box around the shape or mesh with index `object`.
fn object_bounds(geometry: &Geometry, object: usize) -> Bounds {
    match object.checked_sub(geometry.shapes.len()) {
        None => Shape::bounds(&geometry.shapes[object as u32]),
        Some(mesh) => Bounds::from_points(
            geometry.mesh_ranges[mesh].clone().flat_map(|triangle| geometry.mesh.corners(triangle as usize)),
        ),
    }
}

/// True if the surface of the shape or mesh with index `object` may meet the box `bounds`.
///
/// `bounds` is the box of an area light, and overlaps the object's box. The result is false if
/// `bounds` surely lies inside a sphere, or if it overlaps the box of no triangle of a mesh. The
/// surface then cannot separate two points of the light.
fn object_may_meet_box(geometry: &Geometry, object: usize, bounds: &Bounds) -> bool {
    if let Some(mesh) = object.checked_sub(geometry.shapes.len()) {
        let mut triangles = geometry.mesh_ranges[mesh].clone();
        return triangles.any(|i| Bounds::from_points(geometry.mesh.corners(i as usize)).overlaps(bounds));
    }
    let shape = &geometry.shapes[object as u32];
    let ball = shape.bounding_sphere();
    let is_inside = |p: &Vec3| p.distance(ball.center) < INNER_RADIUS * ball.radius;
    !matches!(shape, Shape::Sphere(_)) || !bounds.corners().iter().all(is_inside)
}

/// True if `plane` meets the box `bounds`, which must not be empty.
fn plane_meets_box(plane: &Plane, bounds: &Bounds) -> bool {
    let (point, normal) = plane.point_and_normal();
    normal.dot(bounds.center() - point).abs() <= 0.5 * normal.abs().dot(bounds.extent())
}
