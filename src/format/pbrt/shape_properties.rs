//! Properties of shapes that area lights, media and textures need, such as the area of a shape, its
//! back side, and whether it encloses a volume.

use super::files::{PbrtSceneFiles, ReadResult};
use super::parameters::Parameters;
use crate::format::description::{
    CylinderDescription, DiscDescription, MeshDescription, MeshOptions, ShapeDescription, Span, Spanned,
    SphereDescription,
};
use crate::format::mesh::{SolidDefect, TriangleMesh};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Distance between the front of a two-sided area light and the added back side.
///
/// The distance is relative to the radius of a disc, or to the diagonal of a mesh's bounds.
const RELATIVE_BACK_DISTANCE: f64 = 1e-4;

/// Greatest relative difference between the areas of a mesh's triangles that count as equal, for
/// [`lamps_have_equal_areas`].
const AREA_TOLERANCE: f64 = 1e-3;

/// Bytes of memory for each vertex and each triangle of a copied mesh.
const MEMORY_PER_MESH_ELEMENT: u64 = 100;

/// True if the shape encloses no volume: it is a disc, an open cylinder or an open mesh.
pub(super) fn is_sheet(shape: &ShapeDescription, meshes: &BTreeMap<String, Arc<TriangleMesh>>) -> bool {
    if let ShapeDescription::Cylinder(CylinderDescription { is_capped, .. }) = shape {
        !is_capped
    } else if let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape {
        let mesh = meshes.get(&path.value);
        mesh.is_some_and(|mesh| matches!(mesh.solid_defect(), Some(SolidDefect::Open { .. })))
    } else {
        // The only other shapes of this importer are discs and spheres.
        matches!(shape, ShapeDescription::Disc(_))
    }
}

/// Returns a second shape that emits on the back of a disc or open mesh; `None` for other shapes.
///
/// The second shape faces backwards. It lies slightly behind the first one, because a ray hits only
/// one of two coincident surfaces. A mesh is added to `meshes` under a name that begins with
/// `name`. Closed shapes need no back side, because it is not visible. The inside of an open
/// cylinder stays dark.
pub(super) fn back_side_shape(
    shape: &ShapeDescription,
    name: &str,
    meshes: &mut BTreeMap<String, Arc<TriangleMesh>>,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<Option<ShapeDescription>> {
    Ok(if let ShapeDescription::Disc(DiscDescription { center, normal, radius }) = shape {
        let center = *center - normal.normalize() * (RELATIVE_BACK_DISTANCE * radius);
        Some(ShapeDescription::Disc(DiscDescription { center, normal: -*normal, radius: *radius }))
    } else if let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape
        && is_sheet(shape, meshes)
    {
        let Some(front) = meshes.get(&path.value) else { return Ok(None) };
        files.reserve_memory(MEMORY_PER_MESH_ELEMENT * (front.positions.len() + front.triangles.len()) as u64)?;
        let mut back = (**front).clone();
        let mut normals = vec![DVec3::ZERO; back.positions.len()];
        for triangle in &back.triangles {
            let [a, b, c] = triangle.map(|i| back.positions[i as usize]);
            triangle.iter().for_each(|i| normals[*i as usize] += (b - a).cross(c - a));
        }
        let distance = RELATIVE_BACK_DISTANCE * back.bounds_diagonal();
        for (position, normal) in back.positions.iter_mut().zip(normals) {
            *position -= normal.normalize_or_zero() * distance;
        }
        back.reverse_orientation();
        let path = format!("{name}-back");
        meshes.insert(path.clone(), Arc::new(back));
        let path = Spanned::new(path, Span::default());
        Some(ShapeDescription::Mesh(MeshDescription { path, options: MeshOptions::default() }))
    } else {
        None
    })
}

/// Returns the area of a shape after the transform `to_world` \[length²].
///
/// The area of meshes and discs is exact. The area of spheres and cylinders is exact only for
/// transforms that keep angles. For any other kind of shape, which the importer never makes, the
/// result is +∞.
pub(super) fn world_area(
    shape: &ShapeDescription,
    meshes: &BTreeMap<String, Arc<TriangleMesh>>,
    to_world: DAffine3,
) -> f64 {
    let squared_scale = libm::pow(to_world.matrix3.determinant().abs(), 2.0 / 3.0);
    if let ShapeDescription::Sphere(SphereDescription { radius, .. }) = shape {
        4.0 * PI * radius * radius * squared_scale
    } else if let ShapeDescription::Cylinder(CylinderDescription { ends, radius, .. }) = shape {
        2.0 * PI * radius * ends[0].distance(ends[1]) * squared_scale
    } else if let ShapeDescription::Disc(DiscDescription { normal, radius, .. }) = shape {
        let (x, y) = normal.normalize().any_orthonormal_pair();
        let map = |axis: DVec3| to_world.transform_vector3(axis);
        PI * radius * radius * map(x).cross(map(y)).length()
    } else if let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape {
        meshes.get(&path.value).map_or(0.0, |mesh| {
            let position = |i: u32| to_world.transform_point3(mesh.positions[i as usize]);
            let area = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(position);
                0.5 * (b - a).cross(c - a).length()
            };
            mesh.triangles.iter().map(area).sum()
        })
    } else {
        f64::INFINITY
    }
}

/// Returns the number of lamps (separate area lights) that pbrt makes of an emitting shape of type
/// `kind`: one for each triangle or bilinear patch of a mesh, and 1 for other shapes.
pub(super) fn lamp_count(
    (kind, parameters): (&str, &Parameters),
    shape: &ShapeDescription,
    meshes: &BTreeMap<String, Arc<TriangleMesh>>,
) -> usize {
    match (kind, shape) {
        ("bilinearmesh", _) => (parameters.numbers("indices").len() / 4).max(1),
        ("trianglemesh" | "plymesh" | "loopsubdiv", ShapeDescription::Mesh(mesh)) => {
            meshes.get(&mesh.path.value).map_or(1, |mesh| mesh.triangles.len().max(1))
        }
        _ => 1,
    }
}

/// True if all lamps that pbrt makes of a shape of type `kind` have equal areas after the transform
/// `to_world`. A lamp is a separate area light: each triangle of a mesh is one.
///
/// The result is false for any mesh of bilinear patches, and true for shapes that are no mesh.
pub(super) fn lamps_have_equal_areas(
    kind: &str,
    shape: &ShapeDescription,
    meshes: &BTreeMap<String, Arc<TriangleMesh>>,
    to_world: DAffine3,
) -> bool {
    let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape else { return true };
    let Some(mesh) = meshes.get(&path.value).filter(|_| kind != "bilinearmesh") else { return false };
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| to_world.transform_point3(mesh.positions[i as usize]));
        (b - a).cross(c - a).length()
    };
    let bounds = |(least, most): (f64, f64), area: f64| (least.min(area), most.max(area));
    let (least, most) = mesh.triangles.iter().map(area).fold((f64::INFINITY, 0.0), bounds);
    most - least <= AREA_TOLERANCE * most
}

/// True if the texture coordinates of the shape are those of pbrt: the shape is a mesh that stores
/// them. All other shapes have Caustica's.
pub(super) fn has_texcoords_of_pbrt(shape: &ShapeDescription, meshes: &BTreeMap<String, Arc<TriangleMesh>>) -> bool {
    let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape else { return false };
    meshes.get(&path.value).is_some_and(|mesh| mesh.texcoords.is_some())
}

/// Returns the rotation of a sphere that turns Caustica's texture coordinates into pbrt's.
///
/// pbrt has u = 0 at +x, u = ¼ at +y, and v = 0 at −z. Caustica has u = 0 at −z, u = ¼ at −x, and
/// v = 0 at −y.
pub(super) fn textured_sphere_rotation() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_cols(DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y).transpose())
}
