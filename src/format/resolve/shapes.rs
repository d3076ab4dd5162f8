//! Shapes of the description, in world space.

use super::Resolver;
use super::meshes::{EmissionOverride, Placing};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Curve, CurveBasis, Shape as Described, Span};
use crate::math::{Motion, Transform};
use crate::shape::parametric::{Basis, SplineError};
use crate::shape::{
    Cuboid, Disc, Form, Frustum, IndexedMesh, Instance, Mesh, Patch, Plane, Rectangle, Revolution, Shape, Sphere,
};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use std::sync::Arc;

/// A mesh around its own middle, in its own size.
pub(super) struct Instanced {
    mesh: Arc<IndexedMesh>,
    /// To where the mesh was.
    place: DAffine3,
}

impl Instanced {
    pub(super) fn new(
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
        texcoords: Option<&[DVec2]>,
        triangles: &[[u32; 3]],
    ) -> Self {
        let fold = |f: fn(DVec3, DVec3) -> DVec3| positions.iter().copied().reduce(f).unwrap_or(DVec3::ZERO);
        let (min, max) = (fold(DVec3::min), fold(DVec3::max));
        let middle = 0.5 * min + 0.5 * max;
        let extent = (max - min).max_element();
        // A power of two changes no digit.
        let size = if extent > 0.0 { libm::exp2(libm::log2(extent).floor()) } else { 1.0 };
        let place = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(size)), translation: middle };
        let mesh = Mesh {
            positions: positions.iter().map(|p| ((*p - middle) / size).as_vec3()).collect(),
            normals: normals.unwrap_or_default().iter().map(|n| n.normalize_or_zero().as_vec3()).collect(),
            texcoords: texcoords.unwrap_or_default().iter().map(|t| t.as_vec2()).collect(),
            triangles: triangles.to_vec(),
        };
        Self { mesh: Arc::new(IndexedMesh::new(mesh)), place }
    }
}

impl Resolver<'_> {
    // Kept out of the functions that call each other for what nests: their stack is to stay small.
    #[inline(never)]
    pub(super) fn shape(
        &mut self,
        shape: &Described,
        span: Span,
        to_world: &Motion,
        shine: &EmissionOverride,
    ) -> Result<(), SceneError> {
        let emission = shine.radiance;
        let map = self.transform(to_world.at(0.0), span)?;
        let material = self.material;
        match shape {
            Described::Sphere { center, radius } => {
                self.place(Shape::Sphere(Sphere::new(*center, *radius)), to_world, &map, span, emission)?;
                self.lay(Form::Spherical { center: *center }, to_world);
            }
            Described::Plane { normal, offset } => {
                if emission != Rgb::ZERO {
                    let help = "use a Rectangle or a Disc, or give the plane a material without emission";
                    return Err(self.refuse(span, "an infinite plane cannot emit light", help));
                }
                let on = *normal * (*offset / normal.length_squared());
                let plane = Plane::new(on, *normal);
                if to_world.is_still() {
                    self.builder.plane(plane.transformed(&map), material, emission);
                } else {
                    self.builder.moving_plane(plane, to_world.clone(), material, emission);
                }
                self.lay(Form::plane(*normal), to_world);
            }
            Described::Disc { center, normal, radius } => {
                self.place(Shape::Disc(Disc::around(*center, *normal, *radius)), to_world, &map, span, emission)?;
                self.lay(Form::disc(*center, *normal, *radius), to_world);
            }
            Described::Rectangle { corner, edge0, edge1 } => {
                self.place(Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1)), to_world, &map, span, emission)?;
                self.lay(Form::rectangle(*corner, *edge0, *edge1), to_world);
            }
            Described::Box { min, max } => {
                self.place_solid(Cuboid::new(*min, *max).map(Shape::Cuboid), to_world, &map, span, emission)?;
            }
            Described::Cylinder { ends: [bottom, top], radius, capped } => {
                let solid = Frustum::cylinder(*bottom, *top, *radius, *capped).map(Shape::Frustum);
                self.place_solid(solid, to_world, &map, span, emission)?;
            }
            Described::Cone { ends: [bottom, top], radii, capped } => {
                let solid = Frustum::new(*bottom, *top, *radii, *capped).map(Shape::Frustum);
                self.place_solid(solid, to_world, &map, span, emission)?;
            }
            Described::Triangle { vertices, normals, uv } => {
                let normals = normals.as_ref().map(|n| n.as_slice());
                let uv = uv.as_deref().copied().unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y]);
                if to_world.is_still() {
                    self.place_mesh(&map, vertices, normals, &[[0, 1, 2]], emission);
                    self.lay_corners(Some(&uv));
                } else {
                    let instance = Instanced::new(vertices, normals, Some(&uv), &[[0, 1, 2]]);
                    self.place_instance(&instance, to_world, &map, span, emission)?;
                }
                self.lay(Form::Uv, to_world);
            }
            Described::Mesh { path, options } => {
                self.mesh(&Placing { to_world, map: &map, span, shine }, path, *options)?;
            }
            Described::Revolution { profile } => {
                let surface = revolution(profile, self.memory.free()).map_err(|e| self.refuse_spline(span, &e))?;
                self.place(Shape::Revolution(surface), to_world, &map, span, emission)?;
                self.lay(Form::Uv, to_world);
            }
            Described::Patches { degree, controls } => {
                let [u, v] = degree.map(|d| Basis::bezier(d as usize + 1));
                let bases =
                    [&u.map_err(|e| self.refuse_spline(span, &e))?, &v.map_err(|e| self.refuse_spline(span, &e))?];
                // Asked for once: that takes longer than many a patch.
                let mut free = self.memory.free();
                for net in controls.chunks(bases[0].controls() * bases[1].controls()) {
                    let patch = Patch::within(bases, net, free).map_err(|e| self.refuse_spline(span, &e))?;
                    free = free.map(|free| free.saturating_sub(patch.bytes()));
                    self.place(Shape::Patch(patch), to_world, &map, span, emission)?;
                    self.lay(Form::Uv, to_world);
                    self.glow(shine);
                }
            }
            Described::Nurbs { degree, count, knots, controls } => {
                let basis = |i: usize| match (degree[i] as usize, count[i] as usize) {
                    (degree, count) if knots[i].is_empty() => Basis::uniform(degree, count),
                    (degree, count) => Basis::new(degree, count, knots[i].clone()),
                };
                let surface = || Patch::within([&basis(0)?, &basis(1)?], controls, self.memory.free());
                let surface = surface().map_err(|e| self.refuse_spline(span, &e))?;
                self.place(Shape::Patch(surface), to_world, &map, span, emission)?;
                self.lay(Form::Uv, to_world);
            }
            // It has no surface, so nothing of it is seen.
            Described::Curve(_) => {}
        }
        // Of several parts each has been told.
        if !matches!(shape, Described::Mesh { .. } | Described::Patches { .. } | Described::Curve(_)) {
            self.glow(shine);
        }
        Ok(())
    }

    /// Lets the object that was added last emit by a texture, if it does.
    fn glow(&mut self, shine: &EmissionOverride) {
        if let Some((texture, scale)) = shine.glow {
            self.builder.glow(texture, scale);
        }
    }

    /// Adds a box, cylinder or cone, whose faces have texture coordinates of their own.
    fn place_solid(
        &mut self,
        solid: Option<Shape>,
        to_world: &Motion,
        map: &Transform,
        span: Span,
        emission: Rgb,
    ) -> Result<(), SceneError> {
        let solid = solid.ok_or_else(|| self.refuse(span, "this shape has no extent", "make it larger"))?;
        self.place(solid, to_world, map, span, emission)?;
        self.lay(Form::Uv, to_world);
        Ok(())
    }

    /// Adds a shape under `to_world`, which is `map` when the shutter opens.
    fn place(
        &mut self,
        shape: Shape,
        to_world: &Motion,
        map: &Transform,
        span: Span,
        emission: Rgb,
    ) -> Result<(), SceneError> {
        let placed =
            shape.transformed(map).ok_or_else(|| self.refuse(span, "this shape is squeezed flat", "scale it less"))?;
        if to_world.is_still() {
            self.builder.shape(placed, self.material, emission);
        } else {
            self.builder.moving_shape(shape, to_world.clone(), self.material, emission);
        }
        Ok(())
    }

    /// Whether the material in force follows a texture.
    fn is_textured(&self) -> bool {
        self.worn.get(self.material as usize).is_some_and(|worn| worn.textured)
    }

    /// Lays texture coordinates on the object that was added last, if it wears textures.
    pub(super) fn lay(&mut self, form: Form, to_world: &Motion) {
        if self.is_textured() {
            self.builder.chart(form, to_world);
        }
    }

    /// Gives the corners of the mesh that was added last their texture coordinates, if it wears textures.
    pub(super) fn lay_corners(&mut self, texcoords: Option<&[DVec2]>) {
        if let Some(texcoords) = texcoords.filter(|_| self.is_textured()) {
            self.builder.texcoords(texcoords);
        }
    }

    pub(super) fn refuse(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::at(self.source, span, message, "here", help)
    }

    fn refuse_spline(&self, span: Span, error: &SplineError) -> SceneError {
        if matches!(error, SplineError::Memory { .. }) {
            let help = "bend surfaces less, or let the scene have more memory (--memory)";
            return self.refuse(span, &error.to_string(), help).exhausting();
        }
        let help = match error {
            SplineError::Degree(_) => "join curves of lower degree, or use a B-spline",
            SplineError::TooLarge => "choose units in which coordinates are below 1e100",
            SplineError::Narrow(_) => "give that knot and the next the same value, or part them further",
            SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
            _ => "give control points and knots that fit",
        };
        self.refuse(span, &error.to_string(), help)
    }

    /// Adds a mesh that is shared, or that moves.
    pub(super) fn place_instance(
        &mut self,
        instanced: &Instanced,
        to_world: &Motion,
        map: &Transform,
        span: Span,
        emission: Rgb,
    ) -> Result<(), SceneError> {
        if emission != Rgb::ZERO {
            let even = |time| Transform::new(to_world.at(time)).is_ok_and(|map| map.similarity().is_some());
            if ![0.0, 0.3, 0.7, 1.0].into_iter().all(even) {
                let help = "stretch it alike in all directions, or let a shape of another kind shine";
                return Err(self.refuse(span, "a moving mesh that is stretched unevenly cannot emit light", help));
            }
        }
        let own = self.transform(instanced.place, span)?;
        let shape = Shape::Instance(Instance::new(Arc::clone(&instanced.mesh), own));
        self.place(shape, to_world, map, span, emission)
    }

    pub(super) fn place_mesh(
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

fn revolution(profile: &Curve, free: Option<u64>) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => Basis::bezier(profile.controls.len()),
        CurveBasis::Bspline => Basis::uniform(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::within(&basis, &controls, free)
}
