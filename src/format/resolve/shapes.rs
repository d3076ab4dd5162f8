//! Shapes of the description, in world space.

use super::Resolver;
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Curve, CurveBasis, Shape as Described, Span};
use crate::math::Transform;
use crate::shape::parametric::{Basis, SplineError};
use crate::shape::{Disc, Ellipsoid, Patch, Plane, Rectangle, Revolution, Shape, Sphere};
use glam::{DAffine3, DVec2, DVec3, Vec3};

impl Resolver<'_> {
    pub(super) fn shape(
        &mut self,
        shape: &Described,
        span: Span,
        to_world: DAffine3,
        emission: Rgb,
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
                self.place_mesh(&map, vertices, normals, &[[0, 1, 2]], emission);
            }
            Described::Mesh { path } => {
                let mesh = self.mesh(path)?;
                self.place_mesh(&map, &mesh.positions, mesh.normals.as_deref(), &mesh.triangles, emission);
            }
            Described::Revolution { profile } => {
                let surface = revolution(profile, map).map_err(|e| self.refuse_spline(span, &e))?;
                self.builder.shape(Shape::Revolution(surface), material, emission);
            }
            Described::Patches { degree, controls } => {
                let [u, v] = degree.map(|d| Basis::bezier(d as usize + 1));
                let bases =
                    [&u.map_err(|e| self.refuse_spline(span, &e))?, &v.map_err(|e| self.refuse_spline(span, &e))?];
                for net in controls.chunks(bases[0].controls() * bases[1].controls()) {
                    let patch = Patch::new(bases, net, &map).map_err(|e| self.refuse_spline(span, &e))?;
                    self.builder.shape(Shape::Patch(patch), material, emission);
                }
            }
            Described::Nurbs { degree, count, knots, controls } => {
                let basis = |i: usize| match (degree[i] as usize, count[i] as usize) {
                    (degree, count) if knots[i].is_empty() => Basis::uniform(degree, count),
                    (degree, count) => Basis::new(degree, count, knots[i].clone()),
                };
                let surface = || Patch::new([&basis(0)?, &basis(1)?], controls, &map);
                let surface = surface().map_err(|e| self.refuse_spline(span, &e))?;
                self.builder.shape(Shape::Patch(surface), material, emission);
            }
            // It has no surface, so nothing of it is seen.
            Described::Curve(_) => {}
        }
        Ok(())
    }

    pub(super) fn refuse(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::at(self.source, span, message, "here", help)
    }

    fn refuse_spline(&self, span: Span, error: &SplineError) -> SceneError {
        let help = match error {
            SplineError::Degree(_) => "join curves of lower degree, or use a B-spline",
            SplineError::TooLarge => "choose units in which coordinates are below 1e100",
            SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
            _ => "give control points and knots that fit",
        };
        self.refuse(span, &error.to_string(), help)
    }

    fn place_mesh(
        &mut self,
        map: &Transform,
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
        triangles: &[[u32; 3]],
        emission: Rgb,
    ) {
        let positions: Vec<DVec3> = positions.iter().map(|p| map.point(*p)).collect();
        let unit = |n: &DVec3| map.normal(*n).normalize_or_zero().as_vec3();
        let normals: Vec<Vec3> = normals.unwrap_or_default().iter().map(unit).collect();
        // A mirror image turns the winding around; the outer side must stay outside.
        let turned = |[a, b, c]: [u32; 3]| if map.mirrors() { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> = triangles.iter().copied().map(turned).collect();
        self.builder.mesh(&positions, &normals, &triangles, self.material, emission);
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

fn revolution(profile: &Curve, map: Transform) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => Basis::bezier(profile.controls.len()),
        CurveBasis::Bspline => Basis::uniform(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::new(&basis, &controls, map)
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
