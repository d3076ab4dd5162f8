use super::*;

/// One or more materials of every kind. The coated ones have roughnesses on both sides of the limit
/// up to which a coat has a BSDF of its own, apart from its base.
fn materials_of_all_kinds() -> Vec<Material> {
    let gray = Rgb::splat(0.5);
    let mut materials = vec![
        Material::black(),
        Material::diffuse(gray),
        Material::diffuse_transmission(gray, gray),
        Material::phong(gray, gray, 10.0),
        Material::mirror(gray),
        Material::conductor(gray, gray, 0.1),
        Material::thin_dielectric(1.5, gray),
        Material::dielectric(1.5, Rgb::ZERO),
        Material::mix(0, 1, 0.5),
    ];
    materials.push(Material::conductor(gray, gray, 0.1).with_clear_coat(1.0, 0.1));
    materials.extend([0.0, 0.1, 0.3, 0.31, 1.0].map(|alpha| Material::coated_diffuse(gray, 1.5, alpha, true)));
    materials
}

/// Index of the variant in the enum [`MaterialKind`].
///
/// Another variant does not compile here until it is added to the match, which reminds its author
/// of [`materials_of_all_kinds`].
fn index_of_kind(kind: &MaterialKind) -> usize {
    match kind {
        MaterialKind::Black => 0,
        MaterialKind::Diffuse { .. } => 1,
        MaterialKind::Phong { .. } => 2,
        MaterialKind::Mirror { .. } => 3,
        MaterialKind::Conductor { .. } => 4,
        MaterialKind::ThinDielectric { .. } => 5,
        MaterialKind::Dielectric { .. } => 6,
        MaterialKind::CoatedDiffuse { .. } => 7,
        MaterialKind::Mix { .. } => 8,
        MaterialKind::DiffuseTransmission { .. } => 9,
    }
}

#[test]
fn every_kind_of_material_is_tested() {
    let mut is_tested = [false; 10];
    materials_of_all_kinds().iter().for_each(|material| is_tested[index_of_kind(material.kind())] = true);
    assert_eq!(is_tested, [true; 10]);
}

/// A coat with a BSDF of its own needs a random number at each hit, which selects coat or base.
/// This number is drawn only on materials whose `chooses_bsdf_randomly` is true; hits on other
/// materials always select the base.
#[test]
fn materials_with_separate_coats_choose_bsdfs_randomly() {
    let mut coats = 0;
    for material in materials_of_all_kinds() {
        let mut has_separate_coat = false;
        material.visit_bsdf_variants(&[], |bsdf| has_separate_coat |= bsdf.coat_if_separate().is_some());
        coats += u32::from(has_separate_coat);
        assert!(material.chooses_bsdf_randomly() || !has_separate_coat, "{:?}", material.kind());
    }
    assert_eq!(coats, 4);
}

#[test]
fn only_some_materials_can_be_clear_coated() {
    let gray = Rgb::splat(0.5);
    for material in [Material::mirror(gray), Material::dielectric(1.5, Rgb::ZERO), Material::mix(0, 1, 0.5)] {
        assert_eq!(material.with_clear_coat(1.0, 0.1), material);
    }
    let metal = Material::conductor(gray, gray, 0.1);
    assert_ne!(metal.with_clear_coat(1.0, 0.1), metal);
}

/// A mix has neither microfacets nor a body. Methods that replace these parameters leave it
/// unchanged, with its flag `may_store_photons`.
#[test]
fn replacing_absent_parameters_leaves_mixes_unchanged() {
    let mix = Material::mix(0, 1, 0.5).with_mix_photon_storage(&[Material::diffuse(Rgb::ONE), Material::black()]);
    assert!(mix.may_store_photons());
    assert_eq!(mix.with_single_microfacet_scattering(), mix);
    assert_eq!(mix.with_body(Body::new(1.5)), mix);
}
