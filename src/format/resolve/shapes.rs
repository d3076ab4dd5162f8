//! Adds the shapes of a description to the scene, in world space.

use super::Resolver;
use super::placement::{
    EmissionOverride, Instanced, Placing, place, place_instance, place_mesh, set_emission_texture, set_mapping,
    set_texcoords,
};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{CurveBasis, ProfileCurve, ShapeDescription, Span};
use crate::math::{Motion, Transform};
use crate::shape::parametric::{SplineBasis, SplineError};
use crate::shape::{Cuboid, Disc, Frustum, MappingKind, Patch, Plane, Rectangle, Revolution, Shape, Sphere};
use glam::DVec2;

// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn add_shape(
    r: &mut Resolver<'_>,
    shape: &ShapeDescription,
    span: Span,
    to_world: &Motion,
    emission_override: &EmissionOverride,
) -> Result<(), SceneError> {
    let emission = emission_override.radiance;
    let map = r.transform(to_world.at_time(0.0), span)?;
    let material = r.material;
    match shape {
        ShapeDescription::Sphere { center, radius } => {
            place(r, Shape::Sphere(Sphere::new(*center, *radius)), to_world, &map, span, emission)?;
            set_mapping(r, MappingKind::Spherical { center: *center }, to_world);
        }
        ShapeDescription::Plane { normal, offset } => {
            if emission != Rgb::ZERO {
                let help = "use a Rectangle or a Disc, or give the plane a material without emission";
                return Err(r.refuse(span, "an infinite plane cannot emit light", help));
            }
            let on = *normal * (*offset / normal.length_squared());
            let plane = Plane::new(on, *normal);
            if to_world.is_constant() {
                r.builder.plane(plane.transformed(&map), material, emission);
            } else {
                r.builder.moving_plane(plane, to_world.clone(), material, emission);
            }
            set_mapping(r, MappingKind::for_plane(*normal), to_world);
        }
        ShapeDescription::Disc { center, normal, radius } => {
            place(r, Shape::Disc(Disc::with_normal(*center, *normal, *radius)), to_world, &map, span, emission)?;
            set_mapping(r, MappingKind::for_disc(*center, *normal, *radius), to_world);
        }
        ShapeDescription::Rectangle { corner, edge0, edge1 } => {
            place(r, Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1)), to_world, &map, span, emission)?;
            set_mapping(r, MappingKind::for_rectangle(*corner, *edge0, *edge1), to_world);
        }
        ShapeDescription::Box { min, max } => {
            place_solid(r, Cuboid::new(*min, *max).map(Shape::Cuboid), to_world, &map, span, emission)?;
        }
        ShapeDescription::Cylinder { ends: [bottom, top], radius, is_capped } => {
            let solid = Frustum::cylinder(*bottom, *top, *radius, *is_capped).map(Shape::Frustum);
            place_solid(r, solid, to_world, &map, span, emission)?;
        }
        ShapeDescription::Cone { ends: [bottom, top], radii, is_capped } => {
            let solid = Frustum::new(*bottom, *top, *radii, *is_capped).map(Shape::Frustum);
            place_solid(r, solid, to_world, &map, span, emission)?;
        }
        ShapeDescription::Triangle { vertices, normals, uv } => {
            let normals = normals.as_ref().map(|n| n.as_slice());
            let uv = uv.as_deref().copied().unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y]);
            if to_world.is_constant() {
                place_mesh(r, &map, vertices, normals, &[[0, 1, 2]], emission);
                set_texcoords(r, Some(&uv));
            } else {
                let instance = Instanced::new(vertices, normals, Some(&uv), &[[0, 1, 2]]);
                place_instance(r, &instance, to_world, &map, span, emission)?;
            }
            set_mapping(r, MappingKind::Uv, to_world);
        }
        ShapeDescription::Mesh { path, options } => {
            super::meshes::add_mesh(
                r,
                &Placing { to_world, map: &map, span, emission: emission_override },
                path,
                *options,
            )?;
        }
        ShapeDescription::Revolution { profile } => {
            let surface = revolution(profile, r.memory.available_bytes()).map_err(|e| refuse_spline(r, span, &e))?;
            place(r, Shape::Revolution(surface), to_world, &map, span, emission)?;
            set_mapping(r, MappingKind::Uv, to_world);
        }
        ShapeDescription::Patches { degree, controls } => {
            let [u, v] = degree.map(|d| SplineBasis::bezier(d as usize + 1));
            let bases = [&u.map_err(|e| refuse_spline(r, span, &e))?, &v.map_err(|e| refuse_spline(r, span, &e))?];
            // Queried once: it takes longer than many a patch.
            let mut free = r.memory.available_bytes();
            for net in controls.chunks(bases[0].control_count() * bases[1].control_count()) {
                let patch = Patch::with_memory_limit(bases, net, free).map_err(|e| refuse_spline(r, span, &e))?;
                free = free.map(|free| free.saturating_sub(patch.memory_bytes()));
                place(r, Shape::Patch(patch), to_world, &map, span, emission)?;
                set_mapping(r, MappingKind::Uv, to_world);
                set_emission_texture(r, emission_override);
            }
        }
        ShapeDescription::Nurbs { degree, count, knots, controls } => {
            let basis = |i: usize| match (degree[i] as usize, count[i] as usize) {
                (degree, count) if knots[i].is_empty() => SplineBasis::uniform_knots(degree, count),
                (degree, count) => SplineBasis::new(degree, count, knots[i].clone()),
            };
            let surface = || Patch::with_memory_limit([&basis(0)?, &basis(1)?], controls, r.memory.available_bytes());
            let surface = surface().map_err(|e| refuse_spline(r, span, &e))?;
            place(r, Shape::Patch(surface), to_world, &map, span, emission)?;
            set_mapping(r, MappingKind::Uv, to_world);
        }
        // A curve has no surface.
        ShapeDescription::Curve(_) => {}
    }
    // Shapes of several parts have set it for each part.
    if !matches!(shape, ShapeDescription::Mesh { .. } | ShapeDescription::Patches { .. } | ShapeDescription::Curve(_)) {
        set_emission_texture(r, emission_override);
    }
    Ok(())
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
    let solid = solid.ok_or_else(|| r.refuse(span, "this shape has no extent", "make it larger"))?;
    place(r, solid, to_world, map, span, emission)?;
    set_mapping(r, MappingKind::Uv, to_world);
    Ok(())
}

fn refuse_spline(r: &Resolver<'_>, span: Span, error: &SplineError) -> SceneError {
    if matches!(error, SplineError::Memory { .. }) {
        let help = "bend surfaces less, or let the scene have more memory (--memory)";
        return r.refuse(span, &error.to_string(), help).marked_out_of_memory();
    }
    let help = match error {
        SplineError::Degree(_) => "join curves of lower degree, or use a B-spline",
        SplineError::TooLarge => "choose units in which coordinates are below 1e100",
        SplineError::Narrow(_) => "give that knot and the next the same value, or part them further",
        SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
        _ => "give control points and knots that fit",
    };
    r.refuse(span, &error.to_string(), help)
}

fn revolution(profile: &ProfileCurve, free: Option<u64>) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => SplineBasis::bezier(profile.controls.len()),
        CurveBasis::Bspline => SplineBasis::uniform_knots(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::with_memory_limit(&basis, &controls, free)
}
