//! Adds the shapes of a description to the scene, in world space.

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

/// A mesh scaled and moved to a box around the origin.
pub(super) struct Instanced {
    mesh: Arc<IndexedMesh>,
    /// Map back to the original position and size.
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
        // Scaling by a power of two is exact.
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

// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn add_shape(
    r: &mut Resolver<'_>,
    shape: &Described,
    span: Span,
    to_world: &Motion,
    shine: &EmissionOverride,
) -> Result<(), SceneError> {
    let emission = shine.radiance;
    let map = r.transform(to_world.at(0.0), span)?;
    let material = r.material;
    match shape {
        Described::Sphere { center, radius } => {
            place(r, Shape::Sphere(Sphere::new(*center, *radius)), to_world, &map, span, emission)?;
            set_mapping(r, Form::Spherical { center: *center }, to_world);
        }
        Described::Plane { normal, offset } => {
            if emission != Rgb::ZERO {
                let help = "use a Rectangle or a Disc, or give the plane a material without emission";
                return Err(refuse(r, span, "an infinite plane cannot emit light", help));
            }
            let on = *normal * (*offset / normal.length_squared());
            let plane = Plane::new(on, *normal);
            if to_world.is_still() {
                r.builder.plane(plane.transformed(&map), material, emission);
            } else {
                r.builder.moving_plane(plane, to_world.clone(), material, emission);
            }
            set_mapping(r, Form::plane(*normal), to_world);
        }
        Described::Disc { center, normal, radius } => {
            place(r, Shape::Disc(Disc::around(*center, *normal, *radius)), to_world, &map, span, emission)?;
            set_mapping(r, Form::disc(*center, *normal, *radius), to_world);
        }
        Described::Rectangle { corner, edge0, edge1 } => {
            place(r, Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1)), to_world, &map, span, emission)?;
            set_mapping(r, Form::rectangle(*corner, *edge0, *edge1), to_world);
        }
        Described::Box { min, max } => {
            place_solid(r, Cuboid::new(*min, *max).map(Shape::Cuboid), to_world, &map, span, emission)?;
        }
        Described::Cylinder { ends: [bottom, top], radius, capped } => {
            let solid = Frustum::cylinder(*bottom, *top, *radius, *capped).map(Shape::Frustum);
            place_solid(r, solid, to_world, &map, span, emission)?;
        }
        Described::Cone { ends: [bottom, top], radii, capped } => {
            let solid = Frustum::new(*bottom, *top, *radii, *capped).map(Shape::Frustum);
            place_solid(r, solid, to_world, &map, span, emission)?;
        }
        Described::Triangle { vertices, normals, uv } => {
            let normals = normals.as_ref().map(|n| n.as_slice());
            let uv = uv.as_deref().copied().unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y]);
            if to_world.is_still() {
                place_mesh(r, &map, vertices, normals, &[[0, 1, 2]], emission);
                set_texcoords(r, Some(&uv));
            } else {
                let instance = Instanced::new(vertices, normals, Some(&uv), &[[0, 1, 2]]);
                place_instance(r, &instance, to_world, &map, span, emission)?;
            }
            set_mapping(r, Form::Uv, to_world);
        }
        Described::Mesh { path, options } => {
            super::meshes::add_mesh(r, &Placing { to_world, map: &map, span, shine }, path, *options)?;
        }
        Described::Revolution { profile } => {
            let surface = revolution(profile, r.memory.free()).map_err(|e| refuse_spline(r, span, &e))?;
            place(r, Shape::Revolution(surface), to_world, &map, span, emission)?;
            set_mapping(r, Form::Uv, to_world);
        }
        Described::Patches { degree, controls } => {
            let [u, v] = degree.map(|d| Basis::bezier(d as usize + 1));
            let bases = [&u.map_err(|e| refuse_spline(r, span, &e))?, &v.map_err(|e| refuse_spline(r, span, &e))?];
            // Queried once: it takes longer than many a patch.
            let mut free = r.memory.free();
            for net in controls.chunks(bases[0].controls() * bases[1].controls()) {
                let patch = Patch::within(bases, net, free).map_err(|e| refuse_spline(r, span, &e))?;
                free = free.map(|free| free.saturating_sub(patch.bytes()));
                place(r, Shape::Patch(patch), to_world, &map, span, emission)?;
                set_mapping(r, Form::Uv, to_world);
                set_emission_texture(r, shine);
            }
        }
        Described::Nurbs { degree, count, knots, controls } => {
            let basis = |i: usize| match (degree[i] as usize, count[i] as usize) {
                (degree, count) if knots[i].is_empty() => Basis::uniform(degree, count),
                (degree, count) => Basis::new(degree, count, knots[i].clone()),
            };
            let surface = || Patch::within([&basis(0)?, &basis(1)?], controls, r.memory.free());
            let surface = surface().map_err(|e| refuse_spline(r, span, &e))?;
            place(r, Shape::Patch(surface), to_world, &map, span, emission)?;
            set_mapping(r, Form::Uv, to_world);
        }
        // A curve has no surface.
        Described::Curve(_) => {}
    }
    // Shapes of several parts have set it for each part.
    if !matches!(shape, Described::Mesh { .. } | Described::Patches { .. } | Described::Curve(_)) {
        set_emission_texture(r, shine);
    }
    Ok(())
}

/// Sets the emission texture of the object that was added last, if it has one.
fn set_emission_texture(r: &mut Resolver<'_>, shine: &EmissionOverride) {
    if let Some((texture, scale)) = shine.glow {
        r.builder.emission_texture(texture, scale);
    }
}

/// Adds a box, cylinder or cone, whose faces have texture coordinates of their own.
fn place_solid(
    r: &mut Resolver<'_>,
    solid: Option<Shape>,
    to_world: &Motion,
    map: &Transform,
    span: Span,
    emission: Rgb,
) -> Result<(), SceneError> {
    let solid = solid.ok_or_else(|| refuse(r, span, "this shape has no extent", "make it larger"))?;
    place(r, solid, to_world, map, span, emission)?;
    set_mapping(r, Form::Uv, to_world);
    Ok(())
}

/// Adds a shape under the motion `to_world`, which equals `map` when the shutter opens.
fn place(
    r: &mut Resolver<'_>,
    shape: Shape,
    to_world: &Motion,
    map: &Transform,
    span: Span,
    emission: Rgb,
) -> Result<(), SceneError> {
    let placed =
        shape.transformed(map).ok_or_else(|| refuse(r, span, "this shape is squeezed flat", "scale it less"))?;
    if to_world.is_still() {
        r.builder.shape(placed, r.material, emission);
    } else {
        r.builder.moving_shape(shape, to_world.clone(), r.material, emission);
    }
    Ok(())
}

/// True if the material in force has a texture.
fn is_textured(r: &Resolver<'_>) -> bool {
    r.texture_needs.get(r.material as usize).is_some_and(|needs| needs.textured)
}

/// Sets the texture mapping of the object that was added last, if its material has textures.
pub(super) fn set_mapping(r: &mut Resolver<'_>, form: Form, to_world: &Motion) {
    if is_textured(r) {
        r.builder.mapping(form, to_world);
    }
}

/// Sets the texture coordinates of the mesh that was added last, if its material has textures.
pub(super) fn set_texcoords(r: &mut Resolver<'_>, texcoords: Option<&[DVec2]>) {
    if let Some(texcoords) = texcoords.filter(|_| is_textured(r)) {
        r.builder.texcoords(texcoords);
    }
}

pub(super) fn refuse(r: &Resolver<'_>, span: Span, message: &str, help: &str) -> SceneError {
    SceneError::at(r.source, span, message, "here", help)
}

fn refuse_spline(r: &Resolver<'_>, span: Span, error: &SplineError) -> SceneError {
    if matches!(error, SplineError::Memory { .. }) {
        let help = "bend surfaces less, or let the scene have more memory (--memory)";
        return refuse(r, span, &error.to_string(), help).exhausting();
    }
    let help = match error {
        SplineError::Degree(_) => "join curves of lower degree, or use a B-spline",
        SplineError::TooLarge => "choose units in which coordinates are below 1e100",
        SplineError::Narrow(_) => "give that knot and the next the same value, or part them further",
        SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
        _ => "give control points and knots that fit",
    };
    refuse(r, span, &error.to_string(), help)
}

/// Adds a mesh that is shared or moves.
pub(super) fn place_instance(
    r: &mut Resolver<'_>,
    instanced: &Instanced,
    to_world: &Motion,
    map: &Transform,
    span: Span,
    emission: Rgb,
) -> Result<(), SceneError> {
    if emission != Rgb::ZERO {
        let even = |time| Transform::new(to_world.at(time)).is_ok_and(|map| map.similarity().is_some());
        if ![0.0, 0.3, 0.7, 1.0].into_iter().all(even) {
            let help = "stretch it alike in all directions, or let a shape of another kind emit";
            return Err(refuse(r, span, "a moving mesh that is stretched unevenly cannot emit light", help));
        }
    }
    let own = r.transform(instanced.place, span)?;
    let shape = Shape::Instance(Instance::new(Arc::clone(&instanced.mesh), own));
    place(r, shape, to_world, map, span, emission)
}

pub(super) fn place_mesh(
    r: &mut Resolver<'_>,
    map: &Transform,
    positions: &[DVec3],
    normals: Option<&[DVec3]>,
    triangles: &[[u32; 3]],
    emission: Rgb,
) {
    let positions: Vec<DVec3> = positions.iter().map(|p| map.point(*p)).collect();
    let unit = |n: &DVec3| map.normal(*n).normalize_or_zero().as_vec3();
    let normals: Vec<Vec3> = normals.unwrap_or_default().iter().map(unit).collect();
    // A mirroring map reverses the winding; the outer side must stay outside.
    let turned = |[a, b, c]: [u32; 3]| if map.mirrors() { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<[u32; 3]> = triangles.iter().copied().map(turned).collect();
    r.builder.mesh(&positions, &normals, &triangles, r.material, emission);
}

fn revolution(profile: &Curve, free: Option<u64>) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => Basis::bezier(profile.controls.len()),
        CurveBasis::Bspline => Basis::uniform(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::within(&basis, &controls, free)
}
