//! Accepted input stays within the memory limit.

use super::{InputSandbox, scene};
use serde_json::Value;

/// Memory limit \[bytes]: a tenth of a gigabyte, so that an input that just fits is read quickly.
const LIMIT: u64 = 100_000_000;

/// Renders under the limit and returns the peak memory of the process \[bytes]; `None` if the limit
/// refused it.
fn peak_memory(sandbox: &InputSandbox, more: &[&str]) -> Option<u64> {
    let limit = LIMIT.to_string();
    let mut arguments =
        vec!["render", "a.txt", "-o", "a.png", "--stats", "a.json", "-q", "--threads", "2", "--memory", &limit];
    arguments.extend(more);
    let ended = sandbox.run(&arguments);
    let message = String::from_utf8_lossy(&ended.stderr);
    if ended.status.code() == Some(2) {
        assert!(message.contains("--memory"), "{message}");
        return None;
    }
    assert!(ended.status.success(), "{message}");
    let stats: Value = serde_json::from_slice(&std::fs::read(sandbox.path("a.json")).unwrap()).unwrap();
    stats["peak_memory_bytes"].as_u64()
}

/// Checks the peak memory of inputs of growing size.
///
/// The first ones fit and stay within the limit, and the last ones are refused.
#[track_caller]
fn assert_within_limit(peaks: &[Option<u64>]) {
    let fit = peaks.iter().take_while(|peak| peak.is_some()).count();
    assert!(fit > 0 && fit < peaks.len() && peaks[fit..].iter().all(Option::is_none), "{peaks:?}");
    assert!(peaks.iter().flatten().all(|peak| *peak <= LIMIT), "{peaks:?}");
    // The limit must accept inputs that take a third of it.
    assert!(peaks[fit - 1].is_some_and(|peak| peak > LIMIT / 3), "{peaks:?}");
}

#[test]
fn accepted_images_stay_within_memory_limit() {
    let sandbox = InputSandbox::new();
    sandbox.put(
        "a.txt",
        scene(
            "Materials { Diffuse { reflectance .5 .5 .5 } } Group { MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }",
        ),
    );
    let sizes = ["420x420", "525x525"];
    let flags = [
        "--integrator",
        "hybrid",
        "--photons",
        "2k",
        "--caustic-photons",
        "2k",
        "--spp",
        "1",
        "--passes",
        "5",
        "--size",
    ];
    assert_within_limit(&sizes.map(|size| peak_memory(&sandbox, &[&flags[..], &[size]].concat())));
}

/// Returns the PLY or OBJ file of a wavy mesh of n × n squares, each cut into two triangles.
fn wave_mesh(n: u32, ply: bool) -> Vec<u8> {
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y)));
    let places: Vec<[f32; 3]> = points
        .map(|(x, y)| {
            let height = libm::sinf(x as f32 * 0.1) * 0.1;
            [x as f32 / n as f32 - 0.5, height, y as f32 / n as f32 - 0.5]
        })
        .collect();
    let faces = (0..n * n).flat_map(|i| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    });
    if !ply {
        let mut text = String::new();
        places.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
        faces.for_each(|[a, b, c]| text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        return text.into();
    }
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        places.len(),
        2 * n * n
    )
    .into_bytes();
    file.extend(places.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for face in faces {
        file.push(3);
        file.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    file
}

#[test]
fn accepted_meshes_stay_within_memory_limit() {
    let sandbox = InputSandbox::new();
    sandbox.put(
        "a.txt",
        scene("Materials { Diffuse { reflectance .5 .5 .5 } } Group { MaterialIndex 0 TriangleMesh { file a.mesh } }"),
    );
    for ply in [true, false] {
        let peaks = [270, 320].map(|n| {
            sandbox.put("a.mesh", wave_mesh(n, ply));
            peak_memory(&sandbox, &["--integrator", "raycast"])
        });
        assert_within_limit(&peaks);
    }
}

/// Patches that are subdivided to the finest level stay within the memory limit.
///
/// They are so crumpled that a small file takes much memory.
#[test]
fn accepted_patches_stay_within_memory_limit() {
    let sandbox = InputSandbox::new();
    let peaks = [2, 3].map(|n| {
        let number = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
        let points: String = (0..36 * n)
            .map(|i| format!("[ {} {} {} ] ", number(3 * i), number(3 * i + 1), number(3 * i + 2)))
            .collect();
        sandbox.put("a.txt", scene(&format!("Group {{ BezierPatch {{ degreeU 5 degreeV 5 controls {points} }} }}")));
        peak_memory(&sandbox, &["--integrator", "raycast"])
    });
    assert_within_limit(&peaks);
}

#[test]
fn accepted_textures_and_environments_stay_within_memory_limit() {
    let sandbox = InputSandbox::new();
    let noise = |i: u32| glam::Vec3::splat((i.wrapping_mul(2_654_435_761) >> 8) as f32 / 16_777_216.0);
    // The first picture is noise, which does not compress: its file is in memory while it is read.
    // The second one is refused for its size alone, so its content does not matter.
    for (format, fits) in [(caustica::image::OutputFormat::Png, 1290), (caustica::image::OutputFormat::Exr, 1100)] {
        let files = [(fits, 1.0), (1400_u32, 0.0)].map(|(n, strength)| {
            let pixels = (0..n * n).map(|i| noise(i) * strength).collect();
            let image = caustica::image::Image::from_pixels(n, n, pixels).unwrap();
            caustica::image::encode(format, &image, &caustica::image::WriteOptions::default()).unwrap().0
        });
        for more in [
            "Textures { Image a { file a.picture } } Materials { Diffuse { reflectance a } } Group { MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }",
            "Lights { EnvironmentLight { file a.picture } } Group { }",
        ] {
            sandbox.put("a.txt", scene(more));
            let peaks = files.each_ref().map(|file| {
                sandbox.put("a.picture", file);
                peak_memory(&sandbox, &["--integrator", "raycast"])
            });
            assert_within_limit(&peaks);
        }
    }
}
