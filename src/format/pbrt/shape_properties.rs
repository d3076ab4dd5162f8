//! Properties of shapes that area lights and media need: area, back side, and whether a shape is a
//! sheet without inside.

use super::files::{PbrtSceneFiles, ReadResult};
use crate::format::description::{
    CylinderDescription, DiscDescription, MeshDescription, MeshOptions, ShapeDescription, Span, Spanned,
    SphereDescription,
};
use crate::format::mesh::{SolidDefect, TriangleMesh};
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Distance between the front of a two-sided area light and the added back.
///
/// It is relative to the radius of a disc, or to the diagonal of a mesh's bounds.
const RELATIVE_BACK_DISTANCE: f64 = 1e-4;

/// Bytes of memory for each vertex and each triangle of a copied mesh.
const MEMORY_PER_MESH_ELEMENT: u64 = 100;

/// True if the shape has no inside: it is a disc, a tube or an open mesh.
pub(super) fn is_sheet(shape: &ShapeDescription, meshes: &BTreeMap<String, Arc<TriangleMesh>>) -> bool {
    if let ShapeDescription::Cylinder(CylinderDescription { is_capped, .. }) = shape {
        !is_capped
    } else if let ShapeDescription::Mesh(MeshDescription { path, .. }) = shape {
        let mesh = meshes.get(&path.value);
        mesh.is_some_and(|mesh| matches!(mesh.solid_defect(), Some(SolidDefect::Open { .. })))
    } else {
        // The importer makes no shapes besides these, discs and spheres.
        matches!(shape, ShapeDescription::Disc(_))
    }
}

/// Returns a second shape that emits on the back of a disc or open mesh; `None` for other shapes.
///
/// The second shape faces backwards. It lies behind the sheet by a fraction of the sheet's size,
/// because two coincident surfaces would be one hit. Its mesh, if any, is added under a name that
/// begins with `name`. The back of a closed shape is not visible. The back of a tube stays dark.
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

/// Returns the area of a shape under `to_world` \[length²].
///
/// It is exact for meshes and discs. For spheres and tubes, it is exact if the transform keeps
/// angles. The area of any other shape is infinite; the importer makes none.
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
