//! Functions that read bytes with each of the program's readers.
//!
//! Each reader ends with a result or a typed error. Fuzz targets and the corpus replay share these
//! functions.

use caustica::format::description::{DensityDescription, SceneDescription};
use caustica::format::{
    ImportOptions, ImportedScene, SceneReadError, SourceText, gltf, grid, mesh, mitsuba, mtl, parse, parse_scene_bytes,
    pbrt, resolve, tungsten,
};
use caustica::image::{PixelMeaning, decode};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::light::EnvironmentLight;
use caustica::scene::Scene;
use caustica::stats::MemoryLimit;
use caustica::texture::{MipMap, WrapMode};
use glam::Vec3;
use std::path::Path;

/// Memory limit of images, meshes and grids \[bytes]. Without it, a small file could claim a huge
/// image.
const MEMORY_LIMIT_BYTES: Option<u64> = Some(1 << 28);

/// Largest resolution of a cloud that is built. Larger ones take too long.
const MAX_CLOUD_RESOLUTION: u32 = 24;

/// Path of a folder that does not exist.
const NOWHERE: &str = "/nowhere/at/all";

fn described(bytes: &[u8]) -> Option<SceneDescription> {
    match parse_scene_bytes("fuzz.txt", bytes) {
        Ok(description) => Some(description),
        Err(error) => {
            // Formatting the error also checks that its position lies within the text.
            assert!(
                !error.to_string().is_empty()
                    && !error.remedy().is_empty()
                    && error.offending_text().len() <= bytes.len() * 3
            );
            None
        }
    }
}

fn resolved(description: &SceneDescription, bytes: &[u8]) -> Option<Scene> {
    let cloud = |density: &DensityDescription| matches!(density, DensityDescription::Cloud { resolution, .. } if *resolution > MAX_CLOUD_RESOLUTION);
    if description.media.iter().any(|medium| cloud(&medium.density)) {
        return None;
    }
    let source = SourceText::new("fuzz.txt", &String::from_utf8_lossy(bytes));
    resolve(description, &source, Path::new(NOWHERE)).inspect_err(|e| assert!(!e.remedy().is_empty())).ok()
}

/// Checks that a parsed scene equals its printed text, parsed again. Then resolves it without
/// files.
pub fn scene(bytes: &[u8]) {
    let Some(description) = described(bytes) else { return };
    let printed = description.to_string();
    let again = parse("printed.txt", &printed).unwrap_or_else(|e| panic!("{e}\n{printed}"));
    assert!(again == description, "{printed}");
    resolved(&description, bytes);
}

/// Renders a scene in 2 × 2 pixels and checks that each pixel is finite.
///
/// The integrator is `path`, because pilots of others would take a second per scene.
pub fn render(bytes: &[u8]) {
    let Some(mut description) = described(bytes) else { return };
    (description.camera.value.width, description.camera.value.height) = (2, 2);
    let Some(scene) = resolved(&description, bytes) else { return };
    let camera_paths =
        CameraPathSettings { samples_per_pixel: Some(1), max_bounces: 6, ..CameraPathSettings::default() };
    let settings = Settings { camera_paths, allows_ray_photon_balance: false, ..Settings::default() };
    let pass = Algorithm::Path.prepare(&scene, settings).render_pass(0, &SilentMonitor);
    assert!(pass.image.iter().all(|pixel| pixel.is_finite()), "{:?}", pass.image);
}

/// Reads a mesh as OBJ.
pub fn obj(bytes: &[u8]) {
    loaded("fuzz.obj", bytes);
}

/// Reads a mesh as PLY.
pub fn ply(bytes: &[u8]) {
    loaded("fuzz.ply", bytes);
}

fn loaded(name: &str, bytes: &[u8]) {
    match mesh::decode(Path::new(name), bytes.to_vec(), &(), MEMORY_LIMIT_BYTES) {
        Ok(mut loaded) => {
            let vertices = loaded.mesh.positions.len();
            assert!(loaded.mesh.triangles.iter().flatten().all(|v| (*v as usize) < vertices));
            assert!(loaded.mesh.positions.iter().all(|p| p.is_finite()));
            assert!(loaded.repeated_vertex_count() <= loaded.file_vertex_count);
            assert_eq!(
                loaded.mesh.split_by_material().iter().map(|(_, part)| part.triangles.len()).sum::<usize>(),
                loaded.mesh.triangles.len()
            );
            assert!(loaded.mesh.mesh_report().components <= loaded.mesh.triangles.len());
            loaded.mesh.repair(&mesh::MeshRepairOptions {
                weld_tolerance: Some(1e-9),
                removes_duplicates: true,
                removes_degenerates: true,
                orients_outward: true,
            });
            loaded.mesh.compute_missing_smooth_normals(30.0);
        }
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
}

/// Reads materials as MTL.
pub fn mtl(bytes: &[u8]) {
    match mtl::decode(Path::new("fuzz.mtl"), bytes) {
        Ok(materials) => materials.iter().for_each(|material| drop(material.to_description())),
        Err(error) => assert!(error.to_string().contains("fuzz.mtl"), "{error}"),
    }
}

/// Reads a density grid.
pub fn grid(bytes: &[u8]) {
    match grid::decode(Path::new("fuzz.grid"), bytes.len() as u64, bytes, MEMORY_LIMIT_BYTES) {
        Ok(grid) => assert!(grid.densities.iter().all(|v| v.is_finite() && *v >= 0.0)),
        Err(error) => assert!(error.to_string().contains("fuzz.grid"), "{error}"),
    }
}

/// Reads a glTF file and checks the imported scene.
pub fn gltf(bytes: &[u8]) {
    check_imported(gltf::decode(&Path::new(NOWHERE).join("fuzz.gltf"), bytes, &import_options()));
}

/// Reads a Mitsuba file and checks the imported scene.
pub fn mitsuba(bytes: &[u8]) {
    check_imported(mitsuba::decode(&Path::new(NOWHERE).join("fuzz.xml"), bytes, &import_options()));
}

/// Reads a pbrt scene and checks the imported scene.
pub fn pbrt(bytes: &[u8]) {
    let options = ImportOptions { memory_limit: MemoryLimit::ProcessBytes(1 << 28), ..ImportOptions::default() };
    check_imported(pbrt::decode(&Path::new(NOWHERE).join("fuzz.pbrt"), bytes, &options));
}

/// Reads a Tungsten scene and checks the imported scene. Reads the bytes as a `.wo3` mesh, too.
pub fn tungsten(bytes: &[u8]) {
    check_imported(tungsten::decode(&Path::new(NOWHERE).join("fuzz.json"), bytes, &import_options()));
    match tungsten::decode_wo3(bytes, MEMORY_LIMIT_BYTES) {
        Ok(mesh) => assert!(mesh.triangles.iter().flatten().all(|v| (*v as usize) < mesh.positions.len())),
        Err(defect) => assert!(!defect.is_empty()),
    }
}

fn import_options() -> ImportOptions {
    ImportOptions { memory_limit: MemoryLimit::ProcessBytes(1 << 31), ..ImportOptions::default() }
}

/// Checks that an imported description equals its printed text, parsed again, and that its meshes
/// are valid.
fn check_imported(imported: Result<ImportedScene, SceneReadError>) {
    match imported {
        Ok(scene) => {
            let printed = scene.description.to_string();
            let again = parse("printed.txt", &printed).unwrap_or_else(|e| panic!("{e}\n{printed}"));
            assert!(again == scene.description, "{printed}");
            for mesh in scene.assets.meshes.values() {
                assert!(mesh.triangles.iter().flatten().all(|v| (*v as usize) < mesh.positions.len()));
                assert!(mesh.positions.iter().all(|p| p.is_finite()));
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Reads an image as PNG, OpenEXR or Radiance HDR, and builds a texture and an environment light
/// from it.
pub fn picture(bytes: &[u8]) {
    for meaning in [PixelMeaning::Color, PixelMeaning::NonColor] {
        match decode(Path::new("fuzz.picture"), bytes, meaning, MEMORY_LIMIT_BYTES) {
            Ok((image, _)) => {
                // Textures and lights are built only from small images: large ones take long and
                // reveal no more errors.
                if image.pixels().len() <= 1 << 16 {
                    let _ = MipMap::new(&image, WrapMode::Repeat);
                    let _ = EnvironmentLight::new(image, 0.3, Vec3::ONE);
                }
            }
            Err(error) => assert!(error.to_string().contains("fuzz.picture"), "{error}"),
        }
    }
}
