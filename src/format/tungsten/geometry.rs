//! Geometry of Tungsten's primitives: surfaces, their placement and their areas.

use super::context::ImportContext;
use super::medium_region::HalfSpace;
use super::meshes::TungstenMeshes;
use super::object::{ReadResult, TungstenObject};
use crate::format::description::{
    BoxDescription, CylinderDescription, DiscDescription, MeshDescription, MeshOptions, RectangleDescription,
    ShapeDescription, Span, Spanned, SphereDescription,
};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;

/// Geometry of a converted primitive.
pub(super) struct PrimitiveGeometry {
    pub surface: ShapeDescription,
    /// Transform from the surface's own space to world space.
    pub to_world: DAffine3,
    /// Lower and upper corner of the surface's bounds in its own space, before `to_world`.
    pub local_bounds: (DVec3, DVec3),
    /// Area of the surface in world space, from which Tungsten computes radiance.
    pub area: f64,
    /// Half-space behind the surface in world space; `None` for a surface that is not flat.
    pub half_space: Option<HalfSpace>,
}

/// Returns the geometry of an embedded mesh under the transform `to_world`.
pub(super) fn mesh_geometry(meshes: &TungstenMeshes, path: String, to_world: DAffine3) -> PrimitiveGeometry {
    let (local_bounds, area) = (meshes.bounds(&path), meshes.area(&path, &to_world));
    PrimitiveGeometry { surface: mesh_shape(path), to_world, local_bounds, area, half_space: None }
}

/// Returns the geometry of a primitive that is no mesh; `None` if its kind is not supported, and a
/// message tells the user.
///
/// `is_textured` is true if the material may have textures.
pub(super) fn primitive_geometry(
    context: &ImportContext<'_>,
    meshes: &mut TungstenMeshes,
    object: &TungstenObject<'_>,
    to_world: DAffine3,
    is_textured: bool,
) -> ReadResult<Option<PrimitiveGeometry>> {
    let matrix = to_world.matrix3;
    let scale = axis_lengths(&matrix);
    let half_cube = (DVec3::splat(-0.5), DVec3::splat(0.5));
    let unit_ball = (DVec3::NEG_ONE, DVec3::ONE);
    Ok(Some(match object.kind()? {
        "quad" => {
            // The normal of Tungsten's quad is +y. u grows along +x, and v along −z.
            let corner = DVec3::new(-0.5, 0.0, 0.5);
            let surface = RectangleDescription { corner, edge0: DVec3::X, edge1: DVec3::NEG_Z };
            let normal = matrix.x_axis.cross(-matrix.z_axis);
            PrimitiveGeometry {
                surface: ShapeDescription::Rectangle(surface),
                to_world,
                local_bounds: (DVec3::new(-0.5, 0.0, -0.5), DVec3::new(0.5, 0.0, 0.5)),
                area: normal.length(),
                half_space: half_space_behind(to_world, normal),
            }
        }
        "cube" => {
            let surface = if is_textured {
                mesh_shape(meshes.cube_path())
            } else {
                ShapeDescription::Box(BoxDescription { min: half_cube.0, max: half_cube.1 })
            };
            let area = 2.0 * (scale.x * scale.y + scale.y * scale.z + scale.z * scale.x);
            PrimitiveGeometry { surface, to_world, local_bounds: half_cube, area, half_space: None }
        }
        "sphere" => {
            let radius = scale.max_element();
            // A sphere of Tungsten stays round, with the largest scale.
            let Some(mut placed) = rigid(context, object, to_world, DVec3::splat(radius)) else { return Ok(None) };
            if is_textured {
                placed *= DAffine3::from_mat3(sphere_texture_frame());
            }
            let surface = SphereDescription { center: DVec3::ZERO, radius: 1.0 };
            PrimitiveGeometry {
                surface: ShapeDescription::Sphere(surface),
                to_world: placed,
                local_bounds: unit_ball,
                area: 4.0 * PI * radius * radius,
                half_space: None,
            }
        }
        "disk" => {
            if is_textured {
                context.add_note("textures lie flat on disks instead of by radius and angle", object);
            }
            if object.number("cone_angle")?.is_some_and(|angle| angle < 90.0) {
                context.add_note("disks shine to all sides instead of within their `cone_angle`", object);
            }
            let radius = scale.x.max(scale.z);
            let Some(placed) = rigid(context, object, to_world, DVec3::splat(radius)) else { return Ok(None) };
            let surface = DiscDescription { center: DVec3::ZERO, normal: DVec3::Y, radius: 1.0 };
            PrimitiveGeometry {
                surface: ShapeDescription::Disc(surface),
                to_world: placed,
                local_bounds: unit_ball,
                area: PI * radius * radius,
                half_space: half_space_behind(to_world, matrix.y_axis),
            }
        }
        "cylinder" => {
            if is_textured {
                context.add_note("textures lie on cylinders by our coordinates instead of Tungsten's", object);
            }
            let diameter = scale.x.max(scale.z);
            let lengths = DVec3::new(diameter, scale.y, diameter);
            let Some(placed) = rigid(context, object, to_world, lengths) else { return Ok(None) };
            let ends = [DVec3::new(0.0, -0.5, 0.0), DVec3::new(0.0, 0.5, 0.0)];
            let is_capped = object.boolean("capped", true)?;
            PrimitiveGeometry {
                surface: ShapeDescription::Cylinder(CylinderDescription { ends, radius: 0.5, is_capped }),
                to_world: placed,
                local_bounds: half_cube,
                // Tungsten counts the caps even if there are none.
                area: PI * diameter * (0.5 * diameter + scale.y),
                half_space: None,
            }
        }
        other => {
            context.add_whole_object_note(&format!("primitives of kind `{other}` are left out"), object);
            return Ok(None);
        }
    }))
}

/// Returns `to_world` with the lengths `lengths` of its axes. Returns `None` if an axis has no
/// length, and a message tells the user.
fn rigid(
    context: &ImportContext<'_>,
    object: &TungstenObject<'_>,
    to_world: DAffine3,
    lengths: DVec3,
) -> Option<DAffine3> {
    let factors = lengths / axis_lengths(&to_world.matrix3);
    if factors.is_finite() {
        return Some(to_world * DAffine3::from_scale(factors));
    }
    context.add_note("objects that are scaled to nothing are left out", object);
    None
}

/// Returns the lengths of the columns of a matrix.
fn axis_lengths(matrix: &DMat3) -> DVec3 {
    DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length())
}

/// Returns the half-space behind a flat surface through the origin of its space. `normal` is the
/// normal in world space, of any length.
fn half_space_behind(to_world: DAffine3, normal: DVec3) -> Option<HalfSpace> {
    let normal = normal.try_normalize()?;
    Some(HalfSpace { normal, offset: normal.dot(to_world.translation) })
}

/// Returns the frame of a sphere's texture coordinates: the transform to the sphere's own space
/// from the space in which Caustica computes these coordinates.
///
/// In Tungsten, u is ½ on +x and grows towards +y, and v is 0 on +z. In Caustica, u is ½ on +z and
/// grows towards +x, and v is 0 on −y. So the frame mirrors.
fn sphere_texture_frame() -> DMat3 {
    DMat3::from_cols(DVec3::Y, DVec3::NEG_Z, DVec3::X)
}

fn mesh_shape(path: String) -> ShapeDescription {
    ShapeDescription::Mesh(MeshDescription {
        path: Spanned::new(path, Span::default()),
        options: MeshOptions::default(),
    })
}
