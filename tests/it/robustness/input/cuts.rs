//! Files of every kind, truncated at every position.

use super::{project_path, readers};
use caustica::format::{grid, mesh, mtl, parse_scene_bytes};
use caustica::image::{BitDepth, Image, OutputFormat, PixelMeaning, ToneCurve, ToneMap, WriteOptions, decode, encode};
use glam::Vec3;
use std::fs;
use std::path::Path;

const PLY: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// Returns a tetrahedron as a PLY file in the given encoding.
fn ply(encoding: &str) -> Vec<u8> {
    let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3u32]];
    let mut file = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    let big = encoding == "binary_big_endian";
    if encoding == "ascii" {
        corners.iter().for_each(|[x, y, z]| file.extend(format!("{x} {y} {z}\n").bytes()));
        faces.iter().for_each(|[a, b, c]| file.extend(format!("3 {a} {b} {c}\n").bytes()));
        file.pop();
    } else {
        let order = |bytes: [u8; 4]| if big { [bytes[3], bytes[2], bytes[1], bytes[0]] } else { bytes };
        file.extend(corners.iter().flatten().flat_map(|x| order(x.to_le_bytes())));
        for face in faces {
            file.push(3);
            file.extend(face.iter().flat_map(|i| order(i.to_le_bytes())));
        }
    }
    file
}

/// Files that state their length are refused if they are cut at any position.
#[test]
fn truncated_sized_files_are_refused() {
    for encoding in PLY {
        let whole = ply(encoding);
        assert_eq!(mesh::decode(Path::new("a.ply"), whole.clone(), &(), None).unwrap().mesh.triangles.len(), 4);
        for cut in 0..whole.len() {
            let error = mesh::decode(Path::new("a.ply"), whole[..cut].to_vec(), &(), None).err();
            assert!(error.is_some_and(|e| e.to_string().starts_with("a.ply")), "{encoding} cut at {cut}");
        }
    }
    let mut whole = b"caustica-grid 1\nsize 3 2 2\ntype f32\n\n".to_vec();
    whole.extend((0..12u8).flat_map(|i| f32::from(i).to_le_bytes()));
    let read = |bytes: &[u8]| grid::decode(Path::new("a.grid"), bytes.len() as u64, bytes, None);
    assert_eq!(read(&whole).unwrap().densities.len(), 12);
    (0..whole.len()).for_each(|cut| assert!(read(&whole[..cut]).is_err(), "cut at {cut}"));
}

/// Scenes that are cut before the brace that closes their group are refused.
#[test]
fn truncated_scenes_are_refused() {
    for name in ["scenes/glass-ball.txt", "scenes/smoke.txt", "scenes/textures.txt", "tests/scenes/lens.txt"] {
        let whole = fs::read(project_path(name)).unwrap();
        let whole = whole.trim_ascii_end();
        assert!(parse_scene_bytes(name, whole).is_ok() && whole.ends_with(b"}"), "{name}");
        for cut in 0..whole.len() {
            let error = parse_scene_bytes(name, &whole[..cut]).expect_err("a part is no scene");
            assert!(error.to_string().starts_with(name) && !error.remedy().is_empty(), "{name} cut at {cut}: {error}");
        }
    }
}

/// Line-based formats such as OBJ state no length. A truncated file is read, or refused with the
/// number of the broken line.
#[test]
fn truncated_line_lists_are_read_to_their_end() {
    let obj = fs::read(project_path("tests/scenes/coarse-ball.obj")).unwrap();
    let start = obj.len().saturating_sub(1500);
    let whole = mesh::decode(Path::new("a.obj"), obj.clone(), &(), None).unwrap().mesh.triangles.len();
    let mut most = 0;
    for cut in (0..1500).chain(start..obj.len()) {
        match mesh::decode(Path::new("a.obj"), obj[..cut.min(obj.len())].to_vec(), &(), None) {
            Ok(loaded) => most = most.max(loaded.mesh.triangles.len()),
            Err(error) => assert!(error.to_string().contains("a.obj"), "{error}"),
        }
    }
    assert!(most > 0 && most <= whole, "{most} of {whole}");
    let mtl = "newmtl red\nKd .8 .1 .1\nKs 0 0 0\nNs 30\nNi 1.5\nillum 2\nTf .1 .2 .3\nmap_Kd a b.png\nnewmtl glass\nillum 4\nd .5\n";
    for cut in 0..=mtl.len() {
        match mtl::decode(Path::new("a.mtl"), &mtl.as_bytes()[..cut]) {
            Ok(materials) => assert!(materials.len() <= 2),
            Err(error) => assert!(error.to_string().starts_with("a.mtl"), "{error}"),
        }
    }
}

/// An image is read even without the bytes after its last pixel; any shorter file is refused.
#[test]
fn truncated_images_are_refused() {
    let pixels: Vec<Vec3> = (0..63).map(|i| Vec3::new(i as f32 / 63.0, 0.5, (i * i % 7) as f32 / 7.0)).collect();
    let image = Image::from_pixels(9, 7, pixels).unwrap();
    let tone = ToneMap { curve: ToneCurve::Srgb, exposure_stops: 0.0 };
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n".to_vec();
    hdr.extend([128, 64, 32, 129].repeat(4));
    let written = |format, depth| {
        encode(format, &image, &WriteOptions { tone, bit_depth: depth, ..WriteOptions::default() }).unwrap().0
    };
    // A PNG ends with a chunk of twelve bytes. The last data chunk ends with a checksum of four
    // bytes.
    for (file, beyond) in [
        (written(OutputFormat::Png, BitDepth::Eight), 16),
        (written(OutputFormat::Png, BitDepth::Sixteen), 16),
        (written(OutputFormat::Exr, BitDepth::Eight), 0),
        (hdr, 0),
    ] {
        let read = |bytes: &[u8]| decode(Path::new("a.picture"), bytes, PixelMeaning::Color, None);
        assert!(read(&file).is_ok());
        for cut in 0..file.len() - beyond {
            let error = read(&file[..cut]).expect_err("a part is no picture");
            assert!(error.to_string().contains("a.picture"), "cut at {cut}: {error}");
        }
        (file.len() - beyond..file.len()).for_each(|cut| readers::picture(&file[..cut]));
    }
}
