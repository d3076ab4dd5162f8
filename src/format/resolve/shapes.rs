//! Adds the shapes of the scene description to the scene.

use super::Resolver;
use super::meshes::add_mesh;
use super::placement::{
    NormalizedMesh, ObjectEmission, ObjectPlacement, add_instance, add_placed_shape, add_still_mesh,
    set_emission_texture, set_texcoords, set_texture_mapping_if_needed,
};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{CurveBasis, ProfileCurve, ShapeDescription, Span};
use crate::math::Motion;
use crate::shape::parametric::{SplineBasis, SplineError};
use crate::shape::{Cuboid, Disc, Frustum, Patch, Plane, Rectangle, Revolution, Shape, Sphere, TextureMappingKind};
use glam::{DVec2, DVec4};

/// Adds a shape of the description, with the texture mapping and emission of the current material.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn add_shape(
    r: &mut Resolver<'_>,
    shape: &ShapeDescription,
    span: Span,
    to_world: &Motion,
    object_emission: &ObjectEmission,
) -> Result<(), SceneError> {
    let emission = object_emission.radiance;
    let placement =
        ObjectPlacement { to_world, at_shutter_open: r.invertible_transform(to_world.at_time(0.0), span)?, span };
    match shape {
        ShapeDescription::Sphere { center, radius } => {
            add_placed_shape(r, &placement, Shape::Sphere(Sphere::new(*center, *radius)), emission)?;
            set_texture_mapping_if_needed(r, TextureMappingKind::Spherical { center: *center }, to_world);
        }
        ShapeDescription::Plane { normal, offset } => {
            if emission != Rgb::ZERO {
                let help = "use a Rectangle or a Disc, or give the plane a material without emission";
                return Err(r.error_at(span, "an infinite plane cannot emit light", help));
            }
            let point = *normal * (*offset / normal.length_squared());
            let plane = Plane::new(point, *normal);
            if to_world.is_constant() {
                r.builder.add_plane(plane.transformed(&placement.at_shutter_open), r.material, emission);
            } else {
                r.builder.add_moving_plane(plane, to_world.clone(), r.material, emission);
            }
            set_texture_mapping_if_needed(r, TextureMappingKind::plane_mapping(*normal), to_world);
        }
        ShapeDescription::Disc { center, normal, radius } => {
            add_placed_shape(r, &placement, Shape::Disc(Disc::circular_disc(*center, *normal, *radius)), emission)?;
            set_texture_mapping_if_needed(r, TextureMappingKind::disc_mapping(*center, *normal, *radius), to_world);
        }
        ShapeDescription::Rectangle { corner, edge0, edge1 } => {
            let rectangle = Rectangle::new(*corner, *edge0, *edge1);
            add_placed_shape(r, &placement, Shape::Rectangle(rectangle), emission)?;
            set_texture_mapping_if_needed(r, TextureMappingKind::rectangle_mapping(*corner, *edge0, *edge1), to_world);
        }
        ShapeDescription::Box { min, max } => {
            add_solid_shape(r, &placement, Cuboid::new(*min, *max).map(Shape::Cuboid), emission)?;
        }
        ShapeDescription::Cylinder { ends: [bottom, top], radius, is_capped } => {
            let cylinder = Frustum::cylinder(*bottom, *top, *radius, *is_capped);
            add_solid_shape(r, &placement, cylinder.map(Shape::Frustum), emission)?;
        }
        ShapeDescription::Cone { ends: [bottom, top], radii, is_capped } => {
            let cone = Frustum::new(*bottom, *top, *radii, *is_capped);
            add_solid_shape(r, &placement, cone.map(Shape::Frustum), emission)?;
        }
        ShapeDescription::Triangle { vertices, normals, uv } => {
            let normals = normals.as_ref().map(|n| n.as_slice());
            let uv = uv.as_deref().copied().unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y]);
            if to_world.is_constant() {
                add_still_mesh(r, &placement.at_shutter_open, vertices, normals, &[[0, 1, 2]], emission);
                set_texcoords(r, Some(&uv));
            } else {
                let mesh = NormalizedMesh::new(vertices, normals, Some(&uv), &[[0, 1, 2]]);
                add_instance(r, &placement, &mesh, emission)?;
            }
            set_texture_mapping_if_needed(r, TextureMappingKind::Uv, to_world);
        }
        ShapeDescription::Mesh { path, options } => {
            // Each part of a mesh gets its own emission texture.
            return add_mesh(r, &placement, path, *options, object_emission);
        }
        ShapeDescription::Revolution { profile } => {
            let surface =
                make_revolution(profile, r.memory.available_bytes()).map_err(|e| spline_error(r, span, &e))?;
            add_placed_shape(r, &placement, Shape::Revolution(surface), emission)?;
            set_texture_mapping_if_needed(r, TextureMappingKind::Uv, to_world);
        }
        ShapeDescription::Patches { degree, controls } => {
            return add_patches(r, &placement, *degree, controls, object_emission);
        }
        ShapeDescription::Nurbs { degree, count, knots, controls } => {
            let basis = |i: usize| match (degree[i] as usize, count[i] as usize) {
                (degree, count) if knots[i].is_empty() => SplineBasis::uniform_spline_basis(degree, count),
                (degree, count) => SplineBasis::new(degree, count, knots[i].clone()),
            };
            let surface = || Patch::with_memory_limit([&basis(0)?, &basis(1)?], controls, r.memory.available_bytes());
            let surface = surface().map_err(|e| spline_error(r, span, &e))?;
            add_placed_shape(r, &placement, Shape::Patch(surface), emission)?;
            set_texture_mapping_if_needed(r, TextureMappingKind::Uv, to_world);
        }
        // A curve has no surface.
        ShapeDescription::Curve(_) => return Ok(()),
    }
    set_emission_texture(r, object_emission);
    Ok(())
}

/// Adds a box, cylinder or cone. Fails if `solid` is `None`, which stands for a solid without
/// volume.
fn add_solid_shape(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    solid: Option<Shape>,
    emission: Rgb,
) -> Result<(), SceneError> {
    let no_extent = || r.error_at(placement.span, "this shape has no extent", "make it larger");
    add_placed_shape(r, placement, solid.ok_or_else(no_extent)?, emission)?;
    set_texture_mapping_if_needed(r, TextureMappingKind::Uv, placement.to_world);
    Ok(())
}

/// Adds a list of Bézier patches of equal degrees: one shape per patch.
fn add_patches(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    degree: [u32; 2],
    controls: &[DVec4],
    object_emission: &ObjectEmission,
) -> Result<(), SceneError> {
    let span = placement.span;
    let [u, v] = degree.map(|d| SplineBasis::bezier_basis(d as usize + 1));
    let bases = [&u.map_err(|e| spline_error(r, span, &e))?, &v.map_err(|e| spline_error(r, span, &e))?];
    // Queried once, because a query takes longer than building a small patch.
    let mut free = r.memory.available_bytes();
    for net in controls.chunks(bases[0].control_count() * bases[1].control_count()) {
        let patch = Patch::with_memory_limit(bases, net, free).map_err(|e| spline_error(r, span, &e))?;
        free = free.map(|free| free.saturating_sub(patch.memory_bytes()));
        add_placed_shape(r, placement, Shape::Patch(patch), object_emission.radiance)?;
        set_texture_mapping_if_needed(r, TextureMappingKind::Uv, placement.to_world);
        set_emission_texture(r, object_emission);
    }
    Ok(())
}

/// Converts the error of an invalid curve or surface to a scene error with a remedy.
fn spline_error(r: &Resolver<'_>, span: Span, error: &SplineError) -> SceneError {
    if matches!(error, SplineError::Memory { .. }) {
        let help = "bend surfaces less, or let the scene have more memory (--memory)";
        return r.error_at(span, &error.to_string(), help).marked_out_of_memory();
    }
    let help = match error {
        SplineError::Degree(_) => "join curves of lower degree, or use a B-spline",
        SplineError::TooLarge => "choose units in which coordinates are below 1e100",
        SplineError::Narrow(_) => "give that knot and the next the same value, or part them further",
        SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
        _ => "give control points and knots that fit",
    };
    r.error_at(span, &error.to_string(), help)
}

/// Returns the surface of revolution of a profile curve. Fails if it takes more than `free` bytes.
fn make_revolution(profile: &ProfileCurve, free: Option<u64>) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => SplineBasis::bezier_basis(profile.controls.len()),
        CurveBasis::Bspline => SplineBasis::uniform_spline_basis(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::with_memory_limit(&basis, &controls, free)
}
