//! Files of the measurement: one mesh, and instances of a cube, in each format.

use caustica::format::mesh::{MeshFormat, TriangleMesh};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::{DVec2, DVec3};
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Number of quads along each side of the grid.
const QUADS: u32 = 708;

/// Names and paths of files that hold the same scene.
type Files = Vec<(&'static str, PathBuf)>;

/// Returns a wavy grid of 1,002,528 triangles.
fn grid() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let (mut normals, mut texcoords) = (Vec::new(), Vec::new());
    for j in 0..=QUADS {
        for i in 0..=QUADS {
            let uv = DVec2::new(f64::from(i), f64::from(j)) / f64::from(QUADS);
            let (x, y) = (20.0 * uv.x, 20.0 * uv.y);
            mesh.positions.push(DVec3::new(uv.x, uv.y, 0.02 * libm::sin(x) * libm::cos(y)));
            normals.push(
                DVec3::new(-0.4 * libm::cos(x) * libm::cos(y), 0.4 * libm::sin(x) * libm::sin(y), 1.0).normalize(),
            );
            texcoords.push(uv);
        }
    }
    for j in 0..QUADS {
        for i in 0..QUADS {
            let at = |i: u32, j: u32| j * (QUADS + 1) + i;
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (mesh.normals, mesh.texcoords) = (Some(normals), Some(texcoords));
    mesh
}

/// Returns a cube of 12 triangles.
fn cube() -> TriangleMesh {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    TriangleMesh { positions: (0..8).map(corner).collect(), triangles, ..TriangleMesh::default() }
}

/// Returns the bytes of single-precision numbers.
fn floats<const N: usize>(values: impl Iterator<Item = [f64; N]>) -> Vec<u8> {
    values.flat_map(|value| value.map(|x| (x as f32).to_le_bytes())).flatten().collect()
}

/// Returns the bytes of a mesh's vertex indices.
fn indices(mesh: &TriangleMesh) -> Vec<u8> {
    mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect()
}

/// Returns a binary glTF file of a mesh with one node, or with a node for each translation.
fn glb(mesh: &TriangleMesh, translations: &[DVec3]) -> Vec<u8> {
    let count = mesh.positions.len();
    let (low, high) = mesh
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let mut parts = vec![
        (34962, 5126, "VEC3", count, floats(mesh.positions.iter().map(DVec3::to_array))),
        (34963, 5125, "SCALAR", 3 * mesh.triangles.len(), indices(mesh)),
    ];
    let mut attributes = "\"POSITION\":0".to_owned();
    if let (Some(normals), Some(texcoords)) = (&mesh.normals, &mesh.texcoords) {
        parts.push((34962, 5126, "VEC3", count, floats(normals.iter().map(DVec3::to_array))));
        parts.push((34962, 5126, "VEC2", count, floats(texcoords.iter().map(DVec2::to_array))));
        attributes += ",\"NORMAL\":2,\"TEXCOORD_0\":3";
    }
    let (mut views, mut accessors, mut binary) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (target, component, kind, count, bytes)) in parts.into_iter().enumerate() {
        let bounds = match i {
            0 => format!(",\"min\":{:?},\"max\":{:?}", low.to_array(), high.to_array()),
            _ => String::new(),
        };
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},\"target\":{target}}}",
            binary.len(),
            bytes.len()
        ));
        accessors.push(format!(
            "{{\"bufferView\":{i},\"componentType\":{component},\"count\":{count},\"type\":\"{kind}\"{bounds}}}"
        ));
        binary.extend(bytes);
    }
    let node = |t: &DVec3| format!("{{\"mesh\":0,\"translation\":{:?}}}", t.to_array());
    let nodes: Vec<String> = translations.iter().map(node).collect();
    let roots: Vec<String> = (0..nodes.len()).map(|i| i.to_string()).collect();
    let mut json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{}]}}],\"nodes\":[{}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{{attributes}}},\"indices\":1}}]}}],\
         \"buffers\":[{{\"byteLength\":{}}}],\"bufferViews\":[{}],\"accessors\":[{}]}}",
        roots.join(","),
        nodes.join(","),
        binary.len(),
        views.join(","),
        accessors.join(",")
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut file = b"glTF".to_vec();
    for number in [2, 28 + json.len() + binary.len(), json.len()] {
        file.extend((number as u32).to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json.bytes());
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

/// Returns a mesh in Mitsuba's format `.serialized`, version 4.
fn serialized(mesh: &TriangleMesh) -> Result<Vec<u8>, Box<dyn Error>> {
    let (normals, texcoords) = (mesh.normals.as_deref().unwrap_or(&[]), mesh.texcoords.as_deref().unwrap_or(&[]));
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Single precision, with normals and texture coordinates; an empty name.
    encoder.write_all(&(0x1000_u32 | 1 | 2).to_le_bytes())?;
    encoder.write_all(&[0])?;
    for count in [mesh.positions.len(), mesh.triangles.len()] {
        encoder.write_all(&(count as u64).to_le_bytes())?;
    }
    encoder.write_all(&floats(mesh.positions.iter().map(DVec3::to_array)))?;
    encoder.write_all(&floats(normals.iter().map(DVec3::to_array)))?;
    encoder.write_all(&floats(texcoords.iter().map(DVec2::to_array)))?;
    encoder.write_all(&indices(mesh))?;
    let mut file = vec![0x1c, 0x04, 4, 0];
    file.extend(encoder.finish()?);
    // The list of meshes: the offset of the only one, and their number.
    file.extend(0_u64.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    Ok(file)
}

/// Writes the grid in each format.
pub fn write_meshes(folder: &Path) -> Result<Files, Box<dyn Error>> {
    let path = |name: &str| folder.join(name);
    let mesh = grid();
    mesh.write(&path("grid.ply"), MeshFormat::PlyBinary, &[])?;
    mesh.write(&path("grid.obj"), MeshFormat::Obj, &[])?;
    fs::write(path("grid.glb"), glb(&mesh, &[DVec3::ZERO]))?;
    fs::write(path("grid.serialized"), serialized(&mesh)?)?;
    fs::write(path("ply.pbrt"), "WorldBegin\nShape \"plymesh\" \"string filename\" \"grid.ply\"\n")?;
    for kind in ["ply", "serialized"] {
        let shape = format!("<shape type=\"{kind}\"><string name=\"filename\" value=\"grid.{kind}\"/></shape>");
        fs::write(path(&format!("{kind}.xml")), format!("<scene version=\"3.0.0\">{shape}</scene>"))?;
    }
    Ok(vec![
        ("OBJ", path("grid.obj")),
        ("PLY", path("grid.ply")),
        ("glTF", path("grid.glb")),
        ("pbrt with PLY", path("ply.pbrt")),
        ("Mitsuba with PLY", path("ply.xml")),
        ("Mitsuba with .serialized", path("serialized.xml")),
    ])
}

/// Writes `count` instances of a cube in each format that has instances.
pub fn write_instances(folder: &Path, count: u32) -> Result<Files, Box<dyn Error>> {
    let path = |extension: &str| folder.join(format!("instances{count}.{extension}"));
    let translations: Vec<DVec3> = (0..count)
        .map(|i| 2.0 * DVec3::new(f64::from(i % 100), f64::from(i / 100 % 100), f64::from(i / 10_000)))
        .collect();
    let cube = cube();
    cube.write(&folder.join("cube.ply"), MeshFormat::PlyBinary, &[])?;
    fs::write(path("glb"), glb(&cube, &translations))?;
    let mut text =
        "WorldBegin\nObjectBegin \"cube\"\nShape \"plymesh\" \"string filename\" \"cube.ply\"\nObjectEnd\n".to_owned();
    let mut xml = "<scene version=\"3.0.0\"><shape type=\"shapegroup\" id=\"cube\"><shape type=\"ply\">\
                   <string name=\"filename\" value=\"cube.ply\"/></shape></shape>"
        .to_owned();
    for DVec3 { x, y, z } in translations {
        writeln!(text, "AttributeBegin Translate {x} {y} {z} ObjectInstance \"cube\" AttributeEnd")?;
        writeln!(
            xml,
            "<shape type=\"instance\"><ref id=\"cube\"/><transform name=\"to_world\">\
             <translate x=\"{x}\" y=\"{y}\" z=\"{z}\"/></transform></shape>"
        )?;
    }
    fs::write(path("pbrt"), text)?;
    fs::write(path("xml"), xml + "</scene>")?;
    Ok(vec![("glTF, a node each", path("glb")), ("pbrt", path("pbrt")), ("Mitsuba", path("xml"))])
}
