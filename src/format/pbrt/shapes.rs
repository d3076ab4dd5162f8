//! Converts the shapes of a pbrt scene, some of them to meshes.

use super::content::PbrtSceneContent;
use super::files::{PbrtSceneFiles, ReadResult};
use super::parameters::Parameters;
use super::quadrics::quadric_mesh;
use super::subdivision::loop_subdivided_to_limit;
use crate::format::description::{
    CylinderDescription, DiscDescription, MeshDescription, MeshOptions, ShapeDescription, Span, Spanned,
    SphereDescription,
};
use crate::format::mesh::{TriangleMesh, decode};
use glam::{DVec2, DVec3};
use std::path::Path;
use std::sync::Arc;

/// Estimated memory per vertex and per triangle corner of a mesh \[bytes].
const MEMORY_PER_CORNER: u64 = 100;

/// Greatest number of Loop subdivision levels.
const MAX_SUBDIVISION_LEVELS: f64 = 10.0;

/// Upper bound of the vertices plus triangle corners of a quadric's mesh.
const MAX_QUADRIC_CORNERS: u64 = 16_000;

/// Number of segments along each side of a bilinear patch that is not a parallelogram.
const PATCH_SEGMENTS: u32 = 16;

/// Converts a `Shape` directive to a shape in object space.
///
/// Returns `None` for curves and for meshes without triangles; a message tells the user.
///
/// `kind` is the shape's type in pbrt. A mesh is embedded under the path `name`. If `is_reversed`
/// is true, the shape is turned inside out. If `needs_texcoords` is true, the result is a mesh with
/// pbrt's texture coordinates. But a whole sphere that is not reversed stays a sphere, because the
/// caller can rotate it to these coordinates.
pub(super) fn read_shape(
    (kind, name): (&str, &str),
    parameters: &Parameters,
    (is_reversed, needs_texcoords): (bool, bool),
    content: &mut PbrtSceneContent,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<Option<ShapeDescription>> {
    let place = &parameters.place;
    let radius = |parameters: &Parameters| {
        let radius = parameters.number_or("radius", 1.0);
        let help = "give a `radius` above 0";
        if radius > 0.0 { Ok(radius) } else { Err(place.error("the radius is not above 0", help)) }
    };
    let notes = &mut content.notes;
    let is_cut = is_partial_quadric(kind, parameters);
    let mesh = match kind {
        "sphere" if !(is_cut || is_reversed) => {
            return Ok(Some(ShapeDescription::Sphere(SphereDescription {
                center: DVec3::ZERO,
                radius: radius(parameters)?,
            })));
        }
        "disk" if !(is_cut || needs_texcoords) => {
            let center = DVec3::Z * parameters.number_or("height", 0.0);
            let normal = if is_reversed { DVec3::NEG_Z } else { DVec3::Z };
            return Ok(Some(ShapeDescription::Disc(DiscDescription { center, normal, radius: radius(parameters)? })));
        }
        "cylinder" if !(is_cut || is_reversed || needs_texcoords) => {
            let ends = [parameters.number_or("zmin", -1.0), parameters.number_or("zmax", 1.0)];
            if ends[0] == ends[1] {
                return Err(place.error("the cylinder has no height", "give different `zmin` and `zmax`"));
            }
            let ends = ends.map(|z| DVec3::Z * z);
            return Ok(Some(ShapeDescription::Cylinder(CylinderDescription {
                ends,
                radius: radius(parameters)?,
                is_capped: false,
            })));
        }
        "sphere" | "disk" | "cylinder" | "cone" | "paraboloid" | "hyperboloid" => {
            let message = if needs_texcoords && !is_cut && matches!(kind, "disk" | "cylinder") {
                "disks and cylinders with textures are meshes of facets"
            } else {
                "parts of spheres, cylinders and disks, and other quadrics, are meshes of facets"
            };
            notes.add_unsupported(message, place.position_text());
            files.reserve_memory(MAX_QUADRIC_CORNERS * MEMORY_PER_CORNER)?;
            quadric_mesh(kind, parameters)?.unwrap_or_default()
        }
        "trianglemesh" => triangle_mesh(parameters, files)?,
        "bilinearmesh" => bilinear_mesh(parameters, files)?,
        "loopsubdiv" => {
            let levels = parameters.number("levels").or(parameters.number("nlevels")).unwrap_or(3.0);
            if !(0.0..=MAX_SUBDIVISION_LEVELS).contains(&levels) {
                return Err(place.error("the subdivision has no level from 0 to 10", "correct `levels`"));
            }
            let base = triangle_mesh(parameters, files)?;
            let corners = 3 * base.triangles.len() as u64 + base.positions.len() as u64;
            // Each level has four times as many triangles. The factor 6 includes tables of edges.
            files.reserve_memory((6 * MEMORY_PER_CORNER * corners).saturating_mul(1 << (2 * levels as u64)))?;
            loop_subdivided_to_limit(base.positions, base.triangles, levels as u32)
        }
        "plymesh" => {
            let file = parameters.text("filename").unwrap_or_default();
            let path = files.resolve_path(place, file)?;
            let bytes = files.read_file(&path)?;
            let bytes = if bytes.starts_with(&[0x1f, 0x8b]) { files.gunzipped(&bytes, place)? } else { bytes };
            // The file extension selects the reader, so remove `.gz` from `.ply.gz`.
            let named = Path::new(file.strip_suffix(".gz").unwrap_or(file));
            let loaded = decode(named, bytes, files.monitor, files.free_memory());
            let mesh = loaded.map_err(|e| place.error(e, "export the mesh again, or check it: `caustica mesh`"))?.mesh;
            files.reserve_memory(MEMORY_PER_CORNER * (mesh.positions.len() + 3 * mesh.triangles.len()) as u64)?;
            if parameters.find("displacement").is_some() {
                notes.add_unsupported("displacement of meshes is ignored", place.position_text());
            }
            TriangleMesh { materials: Vec::new(), triangle_materials: Vec::new(), ..mesh }
        }
        "curve" => {
            notes.add_unsupported("curves are left out", place.position_text());
            return Ok(None);
        }
        _ => {
            let message = format!("the shape `{kind}` is not supported");
            return Err(place.error(message, "use sphere, disk, cylinder or a mesh"));
        }
    };
    let mut mesh = mesh;
    if needs_texcoords && mesh.texcoords.is_none() {
        files.reserve_memory(MEMORY_PER_CORNER * 3 * mesh.triangles.len() as u64)?;
        give_default_texcoords(&mut mesh);
    }
    if kind == "trianglemesh" {
        orient_along_normals(&mut mesh);
    }
    if is_reversed {
        mesh.reverse_orientation();
    }
    mesh.merge_equal_vertices();
    if mesh.triangles.is_empty() {
        notes.add_unsupported("meshes without triangles are left out", place.position_text());
        return Ok(None);
    }
    content.meshes.insert(name.to_owned(), Arc::new(mesh));
    let path = Spanned::new(name.to_owned(), Span::default());
    Ok(Some(ShapeDescription::Mesh(MeshDescription { path, options: MeshOptions::default() })))
}

/// True if the parameters cut a part out of a sphere, cylinder or disk, for example by `phimax`.
fn is_partial_quadric(kind: &str, parameters: &Parameters) -> bool {
    let radius = parameters.number_or("radius", 1.0);
    let [low, high] = ["zmin", "zmax"].map(|name| parameters.number(name));
    let is_cut_sphere = kind == "sphere" && (low.is_some_and(|z| z > -radius) || high.is_some_and(|z| z < radius));
    let is_ring = kind == "disk" && parameters.number_or("innerradius", 0.0) > 0.0;
    parameters.number_or("phimax", 360.0) < 360.0 || is_cut_sphere || is_ring
}

/// Returns the parameter `indices` of a mesh with `count` vertices. Fails if an index is not a
/// whole number below `count`.
fn vertex_indices(parameters: &Parameters, count: usize, files: &PbrtSceneFiles<'_>) -> ReadResult<Vec<u32>> {
    let numbers = parameters.numbers("indices");
    files.reserve_memory(MEMORY_PER_CORNER * numbers.len() as u64)?;
    let index = |number: &f64| {
        if *number >= 0.0 && *number < count as f64 && number.fract() == 0.0 {
            return Ok(*number as u32);
        }
        let message = format!("the index {number} is no vertex: there are {count}");
        Err(parameters.place.error(message, "correct `indices`"))
    };
    numbers.iter().map(index).collect()
}

/// Reads the vertices of a mesh shape: positions, normals and texture coordinates. The returned
/// mesh has no triangles yet.
fn mesh_without_triangles(parameters: &Parameters, files: &PbrtSceneFiles<'_>) -> ReadResult<TriangleMesh> {
    let place = &parameters.place;
    let positions = parameters.points("P")?;
    files.reserve_memory(MEMORY_PER_CORNER * positions.len() as u64)?;
    if positions.is_empty() || positions.len() > u32::MAX as usize / 2 {
        return Err(place.error("the mesh has no vertices", "give positions: `\"point3 P\" [ … ]`"));
    }
    let wrong = |name: &str, count: usize| {
        let message = format!("`{name}` has {count} elements for {} vertices", positions.len());
        place.error(message, "give as many as vertices")
    };
    let normals = parameters.points("N")?;
    if !normals.is_empty() && normals.len() != positions.len() {
        return Err(wrong("N", normals.len()));
    }
    let normals = (!normals.is_empty()).then(|| normals.iter().map(|n| n.normalize_or_zero()).collect());
    let uv = parameters.find_any(&["uv", "st"]).map_or(&[][..], |parameter| &parameter.numbers);
    if !uv.is_empty() && uv.len() != 2 * positions.len() {
        return Err(wrong("uv", uv.len() / 2));
    }
    let texcoords = (!uv.is_empty()).then(|| uv.as_chunks::<2>().0.iter().map(|p| DVec2::from_array(*p)).collect());
    Ok(TriangleMesh { positions, normals, texcoords, ..TriangleMesh::default() })
}

/// Reads the mesh of a `trianglemesh`, or the control mesh of a `loopsubdiv` shape.
fn triangle_mesh(parameters: &Parameters, files: &PbrtSceneFiles<'_>) -> ReadResult<TriangleMesh> {
    let mut mesh = mesh_without_triangles(parameters, files)?;
    let mut corners = vertex_indices(parameters, mesh.positions.len(), files)?;
    if corners.is_empty() && mesh.positions.len() == 3 {
        corners = vec![0, 1, 2];
    }
    if corners.is_empty() || !corners.len().is_multiple_of(3) {
        let message = format!("the mesh has {} indices, which is no multiple of 3", corners.len());
        return Err(parameters.place.error(message, "give three `indices` for each triangle"));
    }
    mesh.triangles = corners.as_chunks().0.to_vec();
    Ok(mesh)
}

/// Gives each triangle pbrt's default texture coordinates: (0, 0), (1, 0) and (1, 1).
///
/// Afterwards, triangles share no vertices.
fn give_default_texcoords(mesh: &mut TriangleMesh) {
    let corners: Vec<usize> = mesh.triangles.iter().flatten().map(|i| *i as usize).collect();
    mesh.positions = corners.iter().map(|i| mesh.positions[*i]).collect();
    mesh.normals = mesh.normals.as_ref().map(|normals| corners.iter().map(|i| normals[*i]).collect());
    mesh.texcoords = Some([DVec2::ZERO, DVec2::X, DVec2::ONE].repeat(mesh.triangles.len()));
    for (i, triangle) in mesh.triangles.iter_mut().enumerate() {
        *triangle = [0, 1, 2].map(|k| 3 * i as u32 + k);
    }
}

/// Flips each triangle whose winding opposes its vertex normals. In pbrt, vertex normals decide
/// which side of a face is its front.
fn orient_along_normals(mesh: &mut TriangleMesh) {
    let TriangleMesh { positions, triangles, normals: Some(normals), .. } = mesh else { return };
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        let normal: DVec3 = triangle.iter().map(|i| normals[*i as usize]).sum();
        if (b - a).cross(c - a).dot(normal) < 0.0 {
            triangle.swap(1, 2);
        }
    }
}

/// Returns a triangle mesh of the bilinear patches of a `bilinearmesh`.
///
/// A parallelogram becomes two triangles. Any other patch is divided into [`PATCH_SEGMENTS`]² quads
/// of two triangles each.
fn bilinear_mesh(parameters: &Parameters, files: &PbrtSceneFiles<'_>) -> ReadResult<TriangleMesh> {
    let base = mesh_without_triangles(parameters, files)?;
    let mut corners = vertex_indices(parameters, base.positions.len(), files)?;
    if corners.is_empty() && base.positions.len() == 4 {
        corners = vec![0, 1, 2, 3];
    }
    if corners.is_empty() || !corners.len().is_multiple_of(4) {
        let message = format!("the mesh has {} indices, which is no multiple of 4", corners.len());
        return Err(parameters.place.error(message, "give four `indices` for each patch"));
    }
    let patches = corners.as_chunks::<4>().0;
    let mut mesh = TriangleMesh::default();
    let (mut normals, mut texcoords) = (Vec::new(), Vec::new());
    for patch in patches {
        let p = patch.map(|i| base.positions[i as usize]);
        let n = base.normals.as_ref().map(|normals| patch.map(|i| normals[i as usize]));
        let uv = base.texcoords.as_ref().map(|uv| patch.map(|i| uv[i as usize]));
        let uv = uv.unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]);
        let twist = p[0] + p[3] - p[1] - p[2];
        let size = (p[3] - p[0]).length() + (p[2] - p[1]).length();
        // A parallelogram needs no segments.
        let segments = if twist.length() < 1e-9 * size { 1 } else { PATCH_SEGMENTS };
        files.reserve_memory(MEMORY_PER_CORNER * 6 * u64::from(segments * segments))?;
        let first = mesh.positions.len() as u32;
        for j in 0..=segments {
            for i in 0..=segments {
                let (u, v) = (f64::from(i) / f64::from(segments), f64::from(j) / f64::from(segments));
                let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                mesh.positions.push((0..4).map(|k| weights[k] * p[k]).sum());
                let (du, dv) = ((p[1] - p[0]).lerp(p[3] - p[2], v), (p[2] - p[0]).lerp(p[3] - p[1], u));
                let given = n.map(|n| (0..4).map(|k| weights[k] * n[k]).sum::<DVec3>());
                normals.push(given.unwrap_or(du.cross(dv)).normalize_or_zero());
                texcoords.push((0..4).map(|k| weights[k] * uv[k]).sum());
            }
        }
        for j in 0..segments {
            for i in 0..segments {
                let vertex = |i: u32, j: u32| first + j * (segments + 1) + i;
                mesh.triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)]);
                mesh.triangles.push([vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
            }
        }
    }
    (mesh.normals, mesh.texcoords) = (Some(normals), Some(texcoords));
    orient_along_normals(&mut mesh);
    Ok(mesh)
}

#[cfg(test)]
mod tests;
