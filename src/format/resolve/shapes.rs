//! Shapes of the description, in world space.

use super::Resolver;
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Shape as Described, Span};
use crate::math::Transform;
use crate::shape::{Disc, Ellipsoid, Plane, Rectangle, Shape, Sphere};
use glam::{DAffine3, DVec3, Vec3};

impl Resolver<'_> {
    pub(super) fn shape(
        &mut self,
        shape: &Described,
        span: Span,
        to_world: DAffine3,
        emission: Rgb,
        told: Option<Rgb>,
    ) -> Result<(), SceneError> {
        let map = self.transform(to_world, span)?;
        let material = self.material;
        match shape {
            Described::Sphere { center, radius } => {
                let sphere = place_sphere(&map, *center, *radius)
                    .ok_or_else(|| self.refuse(span, "this sphere is squeezed flat", "scale it less"))?;
                self.builder.shape(sphere, material, emission);
            }
            Described::Plane { normal, offset } => {
                if emission != Rgb::ZERO {
                    let help = "use a Rectangle or a Disc, or give the plane a material without emission";
                    return Err(self.refuse(span, "an infinite plane cannot emit light", help));
                }
                let on = *normal * (*offset / normal.length_squared());
                self.builder.plane(Plane::new(map.point(on), map.normal(*normal)), material, emission);
            }
            Described::Disc { center, normal, radius } => {
                let disc = Disc::around(*center, *normal, *radius).transformed(&map);
                self.builder.shape(Shape::Disc(disc), material, emission);
            }
            Described::Rectangle { corner, edge0, edge1 } => {
                let rectangle = Rectangle::new(*corner, *edge0, *edge1).transformed(&map);
                self.builder.shape(Shape::Rectangle(rectangle), material, emission);
            }
            Described::Triangle { vertices, normals } => {
                let normals = normals.as_ref().map(|n| n.as_slice());
                self.place_mesh(&map, vertices, normals, &[[0, 1, 2]], material, emission);
            }
            Described::Mesh { path, options } => self.mesh(&map, path, *options, told, emission)?,
            Described::Revolution { .. } => {
                let help = "tessellate it into an OBJ mesh and use TriangleMesh";
                return Err(self.refuse(span, "surfaces of revolution cannot be rendered yet", help));
            }
            Described::Curve(_) => {
                let help = "put it into a RevSurface as its profile, or leave it out";
                return Err(self.refuse(span, "a curve by itself has no surface", help));
            }
        }
        Ok(())
    }

    pub(super) fn refuse(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::at(self.source, span, message, "here", help)
    }

    pub(super) fn place_mesh(
        &mut self,
        map: &Transform,
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
        triangles: &[[u32; 3]],
        material: u32,
        emission: Rgb,
    ) {
        let positions: Vec<DVec3> = positions.iter().map(|p| map.point(*p)).collect();
        let unit = |n: &DVec3| map.normal(*n).normalize_or_zero().as_vec3();
        let normals: Vec<Vec3> = normals.unwrap_or_default().iter().map(unit).collect();
        // A mirror image turns the winding around; the outer side must stay outside.
        let turned = |[a, b, c]: [u32; 3]| if map.mirrors() { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> = triangles.iter().copied().map(turned).collect();
        self.builder.mesh(&positions, &normals, &triangles, material, emission);
    }
}

/// A sphere under an affine map; `None` where the map times the radius is singular.
fn place_sphere(map: &Transform, center: DVec3, radius: f64) -> Option<Shape> {
    if let Some(scale) = map.similarity() {
        return Some(Shape::Sphere(Sphere::new(map.point(center), radius * scale)));
    }
    let unit_to_object = DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, center);
    Some(Shape::Ellipsoid(Ellipsoid::new(Transform::new(*map.forward() * unit_to_object).ok()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_stay_spheres_under_similarities_only() {
        let twice = Transform::new(DAffine3::from_scale(DVec3::splat(-2.0))).unwrap();
        match place_sphere(&twice, DVec3::X, 0.5) {
            Some(Shape::Sphere(s)) => assert_eq!((s.center, s.radius), (DVec3::new(-2.0, 0.0, 0.0), 1.0)),
            other => panic!("{other:?}"),
        }
        let stretched = Transform::new(DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0))).unwrap();
        assert!(matches!(place_sphere(&stretched, DVec3::X, 0.5), Some(Shape::Ellipsoid(_))));
    }
}
