//! Tests of textures of pbrt: encodings, alpha channels and nested textures.

use crate::format::import::{ImportOptions, ImportedScene};
use crate::format::pbrt::decode;
use crate::format::pbrt::tests::{import_text, note_messages};
use crate::image::srgb_decode;

/// Imports `text`, which refers to the picture `a.png` with one row of RGBA pixels.
fn import_with_png(pixels: &[[u8; 4]], text: &str) -> ImportedScene {
    let folder = tempfile::tempdir().unwrap();
    let image = ::image::RgbaImage::from_raw(pixels.len() as u32, 1, pixels.concat()).unwrap();
    image.save(folder.path().join("a.png")).unwrap();
    decode(&folder.path().join("a.pbrt"), text.as_bytes(), &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the first channel of all pixels of an `imagemap` of type `kind` with `parameters`.
fn image_map_values(pixels: &[[u8; 4]], kind: &str, parameters: &str) -> Vec<f32> {
    let scene = import_with_png(
        pixels,
        &format!(
            "WorldBegin Texture \"t\" \"{kind}\" \"imagemap\" \"string filename\" \"a.png\" {parameters} \
             Material \"diffuse\" \"texture {}\" \"t\" Shape \"sphere\"",
            if kind == "float" { "displacement" } else { "reflectance" }
        ),
    );
    let picture = scene.assets.pictures.into_values().next().unwrap();
    picture.pixels().iter().map(|pixel| pixel.x).collect()
}

/// Asserts that values are equal up to rounding.
fn assert_near(values: &[f32], expected: &[f64]) {
    assert_eq!(values.len(), expected.len());
    let is_near = |(value, expected): (&f32, &f64)| (f64::from(*value) - expected).abs() < 1e-6;
    assert!(values.iter().zip(expected).all(is_near), "{values:?} {expected:?}");
}

#[test]
fn number_textures_of_png_files_are_srgb_by_default() {
    let pixels = [[0, 0, 0, 255], [51, 51, 51, 255]];
    for kind in ["float", "spectrum"] {
        for (parameters, expected) in [
            ("", srgb_decode(0.2)),
            ("\"string encoding\" \"sRGB\"", srgb_decode(0.2)),
            ("\"string encoding\" \"linear\"", 0.2),
            ("\"string encoding\" \"gamma 2\"", 0.04),
            ("\"bool gamma\" false", 0.2),
            ("\"bool gamma\" true", srgb_decode(0.2)),
        ] {
            assert_near(&image_map_values(&pixels, kind, parameters), &[0.0, expected]);
        }
    }
}

#[test]
fn inverted_pictures_are_scaled_before_inversion() {
    let pixels = [[0, 0, 0, 255], [51, 51, 51, 255], [255, 255, 255, 255]];
    let parameters = "\"string encoding\" \"linear\" \"float scale\" 2 \"bool invert\" true";
    assert_near(&image_map_values(&pixels, "float", parameters), &[1.0, 0.6, 0.0]);
}

#[test]
fn number_textures_use_the_alpha_of_transparent_pictures() {
    let pixels = [[0, 0, 0, 255], [255, 255, 255, 51]];
    assert_near(&image_map_values(&pixels, "float", "\"string encoding\" \"linear\""), &[1.0, 0.2]);
    assert_near(&image_map_values(&pixels, "spectrum", ""), &[0.0, 1.0]);
}

#[test]
fn approximated_checkerboards_and_mixes_have_notes() {
    let scene = import_text(
        "WorldBegin Texture \"c\" \"spectrum\" \"checkerboard\" Texture \"d\" \"spectrum\" \"checkerboard\" \
         \"texture tex1\" \"c\" Texture \"m\" \"spectrum\" \"directionmix\" \"rgb tex1\" [1 0 0] Shape \"sphere\"",
    );
    let notes = note_messages(&scene);
    assert!(notes.contains("inside a checkerboard") && notes.contains("mixes by direction"), "{notes}");
    assert!(!note_messages(&import_text("Texture \"c\" \"spectrum\" \"checkerboard\"")).contains("checkerboard"));
}
