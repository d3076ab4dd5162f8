//! Reference scenes in the formats of pbrt and Mitsuba, against their versions in the scene
//! language.

use super::compare::{Grid, Renders, compare_renders};
use super::methods::{Effort, Method};
use crate::support::scene_from_file;

/// Size of the pictures \[pixels].
const SIZE: (u32, u32) = (64, 48);

const EFFORT: Effort = Effort { passes: 16, samples: 4, photons: 6_000, caustic: 10_000, radius: 0.05 };

/// Compares the scenes of pbrt and Mitsuba in `tests/data/import` with the scene texts in
/// `tests/scenes`.
///
/// All renders use the same random numbers. So equal scenes have equal noise, and the comparison is
/// more sensitive than its error bars suggest.
fn compare_forms(name: &str, method: Method, max_relative_errors: (f64, f64)) {
    let ours = Renders::new(method, &scene_from_file(&format!("tests/scenes/{name}.txt"), SIZE), EFFORT);
    for extension in ["pbrt", "xml"] {
        let scene = scene_from_file(&format!("tests/data/import/{name}.{extension}"), SIZE);
        let theirs = Renders::new(method, &scene, EFFORT);
        compare_renders(&format!("{name}.{extension}"), &theirs, &ours, &Grid::new(SIZE, 16), max_relative_errors);
    }
}

#[test]
#[ignore = "long: renders of imported scenes"]
fn imported_glass_and_mirror_match_ours() {
    compare_forms("cbox-caustic", Method::Hybrid, (0.15, 0.03));
}

#[test]
fn imported_rough_surfaces_match_ours() {
    compare_forms("rough", Method::Path, (0.1, 0.03));
}

#[test]
#[ignore = "long: renders of imported scenes"]
fn imported_fog_matches_ours() {
    compare_forms("fog", Method::Path, (0.1, 0.03));
}

#[test]
fn imported_lens_and_sky_match_ours() {
    compare_forms("lens", Method::Path, (0.1, 0.03));
}
