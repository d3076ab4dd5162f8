//! Counts that exceed the file size, and files larger than memory, are refused without allocating
//! memory for them.
//!
//! The program runs with 2 GB of address space, so it crashes if it allocates more. Reading a tenth
//! of these files would take longer than the ten seconds that a refusal may take.

use super::{InputSandbox, scene};
use caustica::format::{grid, mesh, parse};
use caustica::image::{PixelMeaning, decode};
use std::path::Path;
use std::time::{Duration, Instant};

/// Time limit of a refusal. The start of the program and the header of a file take milliseconds, or
/// some hundred on a busy machine.
const AT_ONCE: Duration = Duration::from_secs(10);

fn mesh_scene(file: &str) -> String {
    scene(&format!("Group {{ TriangleMesh {{ obj_file \"{file}\" }} }}"))
}

/// Counts in a scene's text are compared with the length of the text that follows. Memory is not
/// reserved for them.
#[test]
fn absurd_scene_counts_are_refused() {
    let start = Instant::now();
    let list = |block: &str, count: &str| match block {
        "Group" => scene(&format!("Group {{ {count} 4294967295 Sphere {{ center 0 0 0 radius 1 }} }}")),
        _ => scene(&format!("{block} {{ {count} 4294967295 }} Group {{ }}")),
    };
    for (block, count) in [
        ("Group", "numObjects"),
        ("Lights", "numLights"),
        ("Materials", "numMaterials"),
        ("Textures", "numTextures"),
        ("Media", "numMedia"),
    ] {
        let error = parse("a.txt", &list(block, count)).expect_err(block);
        assert!(error.to_string().contains("4294967295") && !error.remedy().is_empty(), "{block}: {error}");
    }
    for (surface, counts) in [
        ("NurbsSurface", "countU 4294967295 countV 4294967295 degreeU 3 degreeV 3"),
        ("NurbsSurface", "countU 65536 countV 65536 degreeU 3 degreeV 3"),
    ] {
        let text = scene(&format!("Group {{ {surface} {{ {counts} controls 0 0 0 }} }}"));
        let error = parse("a.txt", &text).expect_err(surface);
        assert!(!error.remedy().is_empty(), "{error}");
    }
    for size in ["width 4294967295", "height 65537", "width 1e9", "width 0"] {
        let text = format!("EnvironmentCamera {{ center 0 0 0 direction 0 0 1 {size} }} Group {{ }}");
        let error = parse("a.txt", &text).expect_err(size);
        assert!(!error.remedy().is_empty(), "{error}");
    }
    assert!(start.elapsed() < AT_ONCE);
}

/// Counts in headers of meshes, grids and images are compared with the length of their files.
#[test]
fn absurd_header_counts_are_refused() {
    let start = Instant::now();
    for encoding in ["ascii", "binary_little_endian"] {
        for (vertices, faces) in
            [("4294967295", "1"), ("3", "4294967295"), ("18446744073709551615", "18446744073709551615")]
        {
            let text = format!(
                "ply\nformat {encoding} 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
                 element face {faces}\nproperty list uint uint vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n"
            );
            let error = mesh::decode(Path::new("a.ply"), text.into(), &(), None).unwrap_err().to_string();
            assert!(error.contains("count is wrong"), "{error}");
        }
    }
    for size in ["1024 1024 1024", "4294967295 1 1", "4294967295 4294967295 4294967295"] {
        let text = format!("caustica-grid 1\nsize {size}\ntype text\n\n0 1 2\n");
        assert!(grid::decode(Path::new("a.grid"), text.len() as u64, text.as_bytes(), None).is_err(), "{size}");
    }
    for size in ["-Y 16384 +X 16384", "-Y 4294967295 +X 4294967295", "-Y 999999999999 +X 1"] {
        let text = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n\u{2}\u{2}");
        assert!(decode(Path::new("a.hdr"), text.as_bytes(), PixelMeaning::Color, None).is_err(), "{size}");
    }
    assert!(start.elapsed() < AT_ONCE);
}

/// Returns a valid PNG of 16384 × 16384 equal pixels of one bit.
///
/// It has about 33 kB, and takes 13 GB as a texture.
fn bomb() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 16_384, 16_384);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![0; 16_384 * 16_384 / 8]).unwrap();
    writer.finish().unwrap();
    file
}

/// Files above the memory limit are refused unread, with exit code 2. The message names the limit
/// and a remedy.
#[test]
fn files_above_memory_limit_are_refused_unread() {
    let sandbox = InputSandbox::new();
    let file = bomb();
    assert!(file.len() < 1 << 18, "{}", file.len());
    sandbox.put("bomb.png", file);
    sandbox.put_long("long.png", b"\x89PNG", 9_000_000_000);
    sandbox.put_long("long.obj", "v 0 0 0\n", 9_000_000_000);
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 9000000\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    // This file is read quickly, but its content takes more than a gigabyte.
    sandbox.put_long("wide.ply", header, 108_000_000 + 13 + header.len() as u64);
    sandbox.put_long("long.ply", header, 9_000_000_000);
    let header = "caustica-grid 1\nsize 1024 1024 1024\ntype f32\n\n";
    sandbox.put_long("long.grid", header, (4 << 30) + header.len() as u64);
    let textured = |picture: &str| {
        scene(&format!(
            "Textures {{ Image a {{ file \"{picture}\" }} }} Materials {{ Diffuse {{ reflectance a }} }} \
             Group {{ MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
        ))
    };
    let filled = |density: &str| {
        scene(&format!(
            "Media {{ Medium fog {{ absorption 1 1 1 {density} }} }} Materials {{ Clear {{ medium fog }} }} \
             Group {{ MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
        ))
    };
    sandbox.put("bomb.txt", textured("bomb.png"));
    sandbox.put("picture.txt", textured("long.png"));
    sandbox.put("sky.txt", scene("Lights { EnvironmentLight { file \"bomb.png\" } } Group { }"));
    for name in ["long.obj", "long.ply", "wide.ply"] {
        sandbox.put(&name.replace('.', "-"), mesh_scene(name));
    }
    sandbox.put("grid.txt", filled("grid \"long.grid\" min 0 0 0 max 1 1 1"));
    sandbox.put_long("long.txt", scene("Group { }"), 9_000_000_000);
    let room = ["larger", "--memory"];
    for (name, words) in [
        ("bomb.txt", ["bomb.png", "12.9 GB"]),
        ("picture.txt", ["long.png", "9.0 GB"]),
        ("sky.txt", ["bomb.png", "12.9 GB"]),
        ("long-obj", ["long.obj", "9.0 GB"]),
        ("long-ply", ["long.ply", "9.0 GB"]),
        ("wide-ply", ["wide.ply", "1.4 GB"]),
        ("grid.txt", ["long.grid", "8.6 GB"]),
        ("long.txt", ["long.txt", "288.0 GB"]),
    ] {
        let start = Instant::now();
        sandbox.refused(&["render", name, "-o", "a.png", "--memory", "1G"], 2, &[words[0], words[1], room[1]]);
        assert!(start.elapsed() < AT_ONCE, "{name}");
        assert!(!sandbox.path("a.png").exists());
    }
    // Other commands have the same limit.
    sandbox.refused(&["plan", "bomb.txt", "--memory", "1G"], 2, &["bomb.png", "--memory"]);
    sandbox.refused(&["price", "bomb.txt", "--memory", "1G"], 2, &["bomb.png", "--memory"]);
    sandbox.refused(&["study", "bomb.txt", "--effects", "--memory", "1G"], 2, &["bomb.png", "--memory"]);
    sandbox.refused(&["mesh", "long.obj", "--memory", "1G"], 2, &["long.obj", "--memory"]);
    sandbox.refused(&["mesh", "wide.ply", "--memory", "1G"], 2, &["wide.ply", "--memory"]);
    // Large images, many photons, and invalid amounts of memory are refused. In the scene, light
    // goes back and forth between two planes. Each path stores about one photon that was scattered
    // before.
    let planes = "Plane { normal 0 1 0 offset -1 } Plane { normal 0 -1 0 offset -4 }";
    let plain_scene =
        format!("Materials {{ Diffuse {{ reflectance .5 .5 .5 }} }} Group {{ MaterialIndex 0 {planes} }}");
    sandbox.put("plain.txt", scene(&plain_scene));
    let plain = |more: &str| {
        let mut words = vec!["render", "plain.txt", "-o", "a.png"];
        words.extend(more.split(' '));
        words.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    for (more, words) in [
        ("--memory 1G --size 16000x16000", vec!["a picture of 16000 × 16000", "--size", "--memory"]),
        ("--memory 50M --integrator sppm --photons 4M", vec!["photons", "--passes", "--memory"]),
        ("--memory 1", vec!["0 bytes are free", "--memory"]),
        ("--memory lots", vec!["`lots` is not an amount of memory", "4G"]),
    ] {
        let words: Vec<&str> = words.into_iter().collect();
        let arguments = plain(more);
        sandbox.refused(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), 2, &words);
    }
}

/// Memory for the photons of an estimate depends on the number of existing photons, not on the
/// requested number.
///
/// A single photon gives no estimate, because it only determines the radius of the disc.
#[test]
fn gather_count_is_capped_by_photon_count() {
    let sandbox = InputSandbox::new();
    let planes = "Plane { normal 0 1 0 offset -1 } Plane { normal 0 -1 0 offset -4 }";
    sandbox.put(
        "a.txt",
        scene(&format!("Materials {{ Diffuse {{ reflectance .5 .5 .5 }} }} Group {{ MaterialIndex 0 {planes} }}")),
    );
    let line = |k| {
        ["render", "a.txt", "-o", "a.png", "--integrator", "sppm", "--photons", "2k", "--passes", "4", "--gather-k", k]
    };
    let ended = sandbox.run(&line("4000M"));
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    sandbox.refused(&line("1"), 2, &["--gather-k", "write at least 2, or 0"]);
}
