//! Tests of media of pbrt: coefficients, grids and their boxes.

use crate::format::description::{DensityDescription, MediumCoefficients, MediumDescription, TransformStep};
use crate::format::import::ImportedScene;
use crate::format::pbrt::tests::{import_text, note_messages};
use glam::DVec3;

/// Returns absorption and scattering of the only medium.
fn absorption_and_scattering_of_scene(scene: &ImportedScene) -> (DVec3, DVec3) {
    let MediumCoefficients::AbsorptionScattering { absorption, scattering } = only_medium(scene).coefficients else {
        panic!()
    };
    (absorption, scattering)
}

fn only_medium(scene: &ImportedScene) -> &MediumDescription {
    &scene.description.media[0].value
}

#[test]
fn uniform_grids_keep_densities_and_their_box() {
    let scene = import_text(
        "Translate 0 0 3 MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer nz\" 2 \
         \"float density\" [0 1 2 3] \"rgb sigma_a\" [1 2 3] \"float scale\" 2 \"rgb Le\" [1 1 0] \"point3 p0\" \
         [-1 -1 -1] \"float Lescale\" [5 .5 1 1] Identity Camera \"perspective\" WorldBegin",
    );
    let DensityDescription::Grid { path, scale, extent } = &only_medium(&scene).density else { panic!() };
    let grid = &scene.assets.grids[&path.value];
    assert_eq!((grid.cell_counts, &grid.densities[..], *scale), ([2, 1, 2], &[0.0, 1.0, 2.0, 3.0][..], 1.0));
    assert_eq!(absorption_and_scattering_of_scene(&scene), (DVec3::new(2.0, 4.0, 6.0), DVec3::splat(2.0)));
    // Emission is σa · Le times the density-weighted mean of `Lescale`: (0.5 + 2 + 3) / 6.
    assert!(only_medium(&scene).emission.abs_diff_eq(DVec3::new(2.0, 4.0, 0.0) * 5.5 / 6.0, 1e-12));
    // The world is mirrored along z.
    let map = TransformStep::composed_matrix(&extent.steps);
    assert!(map.transform_point3(extent.min).abs_diff_eq(DVec3::new(-1.0, -1.0, -2.0), 1e-12));
    assert!(map.transform_point3(extent.max).abs_diff_eq(DVec3::new(1.0, 1.0, -4.0), 1e-12));
    assert!(note_messages(&scene).contains("emission of media that varies"));
}

#[test]
fn color_grids_keep_their_totals() {
    let scene = import_text(
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"integer ny\" 2 \"float g\" .5 \
         \"rgb sigma_a\" [1 1 1 2 2 2] \"rgb sigma_s\" [1 2 3 2 4 6] \"rgb Le\" [1 0 0 0 0 0] \"float Lescale\" 3 WorldBegin",
    );
    let DensityDescription::Grid { path, .. } = &only_medium(&scene).density else { panic!() };
    let densities = scene.assets.grids[&path.value].densities.clone();
    let (absorption, scattering) = absorption_and_scattering_of_scene(&scene);
    for (density, factor) in densities.iter().zip([1.0, 2.0]) {
        let density = f64::from(*density);
        assert!((absorption * density).abs_diff_eq(DVec3::splat(factor), 1e-6));
        assert!((scattering * density).abs_diff_eq(DVec3::new(1.0, 2.0, 3.0) * factor, 1e-6));
    }
    // Both cells together emit `Lescale` · Le · σa = 3 · 1 · 1.
    let total: f64 = densities.iter().map(|density| f64::from(*density)).sum();
    assert!((only_medium(&scene).emission * total).abs_diff_eq(DVec3::new(3.0, 0.0, 0.0), 1e-6));
    let plain = import_text(
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"integer ny\" 2 \
         \"rgb sigma_s\" [1 1 1 0 0 0] \"rgb sigma_a\" [1 1 1 0 0 0] WorldBegin",
    );
    assert!(note_messages(&scene).contains("colors of media") && !note_messages(&plain).contains("colors of media"));
}

#[test]
fn only_unequal_emission_of_color_grids_is_noted() {
    let has_note = |emission: &str| {
        let scene = import_text(&format!(
            "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"integer ny\" 2 \"rgb sigma_s\" [1 1 1 .3 .3 .3] \
             \"rgb sigma_a\" [1 1 1 .3 .3 .3] \"rgb Le\" [{emission}] WorldBegin"
        ));
        note_messages(&scene).contains("colors of media")
    };
    assert!(has_note("1 2 3 1 2 4") && !has_note("1 2 3 1 2 3"));
}

#[test]
fn homogeneous_media_emit_le_times_absorption() {
    let scene = import_text(
        "MakeNamedMedium \"m\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [0 0 0] \"rgb Le\" [1 1 1] \"float Lescale\" 2 WorldBegin",
    );
    assert_eq!(only_medium(&scene).emission, DVec3::new(2.0, 4.0, 6.0));
}
