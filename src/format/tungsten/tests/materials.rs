//! Tests of the conversion of BSDFs and textures.

use super::{assert_import_error, has_note, import_in_folder, import_scene, sphere_material};
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricDescription, DiffuseDescription,
    DiffuseTransmissionDescription, MaterialKindDescription, MetalDescription, MirrorDescription, MixDescription,
    PrincipledDescription, TextureKindDescription, TexturedValue, ThinDielectricDescription, WrapMode,
};
use crate::image::{Image, WriteOptions, write};
use glam::{DVec2, DVec3, Vec3};

/// Returns the kind of material that the BSDF `bsdf` becomes.
fn kind_of(bsdf: &str) -> MaterialKindDescription {
    sphere_material(bsdf).kind
}

/// True if a sphere with the BSDF `bsdf` causes a message that contains `part`.
fn is_noted(bsdf: &str, part: &str) -> bool {
    has_note(&import_scene(&format!("{{\"type\": \"sphere\", \"bsdf\": {bsdf}}}"), ""), part)
}

fn diffuse(reflectance: DVec3) -> MaterialKindDescription {
    MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: reflectance.into() })
}

#[test]
fn diffuse_black_and_mirror_surfaces_have_their_albedo() {
    let color = DVec3::new(0.1, 0.2, 0.3);
    assert_eq!(kind_of(r#"{"type": "lambert", "albedo": [0.1, 0.2, 0.3]}"#), diffuse(color));
    assert_eq!(kind_of(r#"{"type": "lambert", "albedo": {"type": "constant", "value": 7}}"#), diffuse(DVec3::ONE));
    assert_eq!(kind_of(r#"{"type": "null", "albedo": 1}"#), diffuse(DVec3::ZERO));
    let mirror = MaterialKindDescription::Mirror(MirrorDescription { reflectance: color.into() });
    assert_eq!(kind_of(r#"{"type": "mirror", "albedo": [0.1, 0.2, 0.3]}"#), mirror);
    let sheet = DiffuseTransmissionDescription {
        reflectance: DVec3::splat(0.375).into(),
        transmittance: DVec3::splat(0.125).into(),
    };
    let found = kind_of(r#"{"type": "diffuse_transmission", "albedo": 0.5, "transmittance": 0.25}"#);
    assert_eq!(found, MaterialKindDescription::DiffuseTransmission(sheet));
}

#[test]
fn metals_have_their_name_or_index() {
    let conductor = |bsdf: &str| match kind_of(bsdf) {
        MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, has_multiple_scattering }) => {
            assert!(!has_multiple_scattering);
            (metal, roughness)
        }
        other => panic!("{other:?}"),
    };
    let is_named =
        |metal: &MetalDescription, wanted: &str| matches!(metal, MetalDescription::Named(name) if name.value == wanted);
    let (metal, roughness) = conductor(r#"{"type": "conductor"}"#);
    assert!(is_named(&metal, "copper") && roughness == TexturedValue::Constant(0.0));
    let (metal, roughness) = conductor(r#"{"type": "rough_conductor", "material": "Au", "roughness": 0.3}"#);
    assert!(is_named(&metal, "gold") && roughness == TexturedValue::Constant(0.3));
    let (_, roughness) = conductor(r#"{"type": "rough_conductor", "distribution": "beckmann", "roughness": 0.5}"#);
    assert_eq!(roughness, TexturedValue::Constant(0.5 * std::f64::consts::LN_2.sqrt()));
    let (metal, _) = conductor(r#"{"type": "conductor", "eta": [1, 2, 3], "k": 4}"#);
    assert_eq!(metal, MetalDescription::Index { eta: DVec3::new(1.0, 2.0, 3.0), k: DVec3::splat(4.0) });
    assert!(is_noted(r#"{"type": "conductor", "material": "Xx"}"#, "the metal `Xx` is not known"));
    assert!(is_noted(r#"{"type": "conductor", "albedo": 0.5}"#, "the `albedo` of metals"));
}

#[test]
fn dielectrics_and_sheets_have_their_index() {
    let glass = kind_of(r#"{"type": "dielectric", "ior": 1.8}"#);
    let MaterialKindDescription::Dielectric(DielectricDescription { refraction, roughness, .. }) = glass else {
        panic!()
    };
    assert_eq!((refraction, roughness), (1.8.into(), TexturedValue::Constant(0.0)));
    let rough = kind_of(r#"{"type": "rough_dielectric", "roughness": 0.2}"#);
    let MaterialKindDescription::Dielectric(rough) = rough else { panic!() };
    assert_eq!(rough.roughness, TexturedValue::Constant(0.2));
    let sheet = kind_of(r#"{"type": "thinsheet", "ior": 1.4, "sigma_a": [1, 2, 0], "thickness": 0.25}"#);
    let MaterialKindDescription::Thin(ThinDielectricDescription { eta, transmittance }) = sheet else { panic!() };
    assert_eq!(eta, 1.4);
    let TexturedValue::Constant(transmittance) = transmittance else { panic!() };
    assert!((transmittance - DVec3::new(libm::exp(-0.5), libm::exp(-1.0), 1.0)).length() < 1e-15);
    // Without refraction, only the reflection of the surface is left.
    let MaterialKindDescription::CoatedDiffuse(shell) =
        kind_of(r#"{"type": "dielectric", "enable_refraction": false}"#)
    else {
        panic!()
    };
    assert_eq!((shell.reflectance, shell.eta), (DVec3::ZERO.into(), 1.5));
}

#[test]
fn plastic_is_a_diffuse_base_under_a_coat() {
    let plastic = |bsdf: &str| match kind_of(bsdf) {
        MaterialKindDescription::CoatedDiffuse(plastic) => plastic,
        other => panic!("{other:?}"),
    };
    let CoatedDiffuseDescription { reflectance, eta, roughness, is_nonlinear } =
        plastic(r#"{"type": "plastic", "albedo": 0.5, "ior": 1.6}"#);
    assert_eq!((reflectance, eta, is_nonlinear), (DVec3::splat(0.5).into(), 1.6, true));
    assert_eq!(roughness, TexturedValue::Constant(0.0));
    let rough = r#"{"type": "rough_plastic", "albedo": 0.5, "roughness": 0.3, "thickness": 2, "sigma_a": 0.5}"#;
    let found = plastic(rough);
    assert_eq!(found.roughness, TexturedValue::Constant(0.3));
    let TexturedValue::Constant(darkened) = found.reflectance else { panic!() };
    assert!((darkened - 0.5 * libm::exp(-2.0)).length() < 1e-15, "{darkened}");
    assert!(is_noted(rough, "coats absorb as along the normal"));
    let coated = plastic(r#"{"type": "smooth_coat", "ior": 1.4, "substrate": {"type": "lambert", "albedo": 0.25}}"#);
    assert_eq!((coated.reflectance, coated.eta), (DVec3::splat(0.25).into(), 1.4));
}

#[test]
fn coats_over_metal_become_clear_coats() {
    let coat = r#"{"type": "rough_coat", "ior": 1.3, "roughness": 0.05, "substrate": {"type": "rough_conductor",
        "material": "Al", "roughness": 0.1}}"#;
    let MaterialKindDescription::Principled(PrincipledDescription {
        base_color,
        metallic,
        roughness,
        clearcoat,
        clearcoat_roughness,
        ..
    }) = kind_of(coat)
    else {
        panic!()
    };
    let TexturedValue::Constant(color) = base_color else { panic!() };
    assert!(color.min_element() > 0.85, "{color}");
    assert_eq!([metallic, roughness], [1.0, 0.1].map(TexturedValue::Constant));
    let TexturedValue::Constant(coverage) = clearcoat else { panic!() };
    assert!((coverage - (0.3 / 2.3) * (0.3 / 2.3) / 0.04).abs() < 1e-12, "{coverage}");
    assert_eq!(clearcoat_roughness, 0.05);
    assert!(is_noted(coat, "clear coats of index 1.5"));
    let over_glass = r#"{"type": "smooth_coat", "substrate": {"type": "dielectric"}}"#;
    assert!(is_noted(over_glass, "are left out") && kind_of(over_glass).is_dielectric());
}

/// An absorbing coat darkens the mean of the texture below it.
#[test]
fn absorbing_coats_darken_textured_mirrors() {
    let coat = r#"{"type": "smooth_coat", "thickness": 1, "sigma_a": 0.5, "substrate": {"type": "mirror",
        "albedo": {"type": "checker", "on_color": 1, "off_color": 0.5}}}"#;
    let MaterialKindDescription::Principled(metal) = kind_of(coat) else { panic!() };
    let TexturedValue::Constant(color) = metal.base_color else { panic!("{:?}", metal.base_color) };
    assert!((color - 0.75 * libm::exp(-1.0)).length() < 1e-15, "{color}");
}

#[test]
fn mixes_state_the_share_of_their_second_material() {
    let mix = |bsdf: &str| match kind_of(bsdf) {
        MaterialKindDescription::Mix(MixDescription { second_probability, .. }) => second_probability,
        other => panic!("{other:?}"),
    };
    let parts = r#""bsdf0": {"type": "lambert"}, "bsdf1": {"type": "mirror"}"#;
    let scene = import_scene(
        &format!("{{\"type\": \"sphere\", \"bsdf\": {{\"type\": \"mixed\", \"ratio\": 0.25, {parts}}}}}"),
        "",
    );
    let [.., mixed] = &scene.description.materials[..] else { panic!() };
    let MaterialKindDescription::Mix(MixDescription { first, second, second_probability }) = &mixed.kind else {
        panic!("{mixed:?}")
    };
    let is_mirror = |name: &str| {
        let named = scene.description.materials.iter().find(|material| material.name.as_deref() == Some(name));
        matches!(named.unwrap().kind, MaterialKindDescription::Mirror(_))
    };
    // The ratio is the share of `bsdf0`, which is not the mirror.
    assert!(is_mirror(&first.value) && !is_mirror(&second.value));
    assert_eq!(*second_probability, TexturedValue::Constant(0.25));
    let masked = |alpha: &str| {
        format!("{{\"type\": \"transparency\", \"alpha\": {alpha}, \"base\": {{\"type\": \"lambert\"}}}}")
    };
    assert_eq!(mix(&masked("0.75")), TexturedValue::Constant(0.75));
    assert_eq!(kind_of(&masked("1")), diffuse(DVec3::ONE));
    let two = r#"{"type": "mixed", "ratio": 0.75, "bsdf0": {"type": "dielectric", "ior": 1.3},
        "bsdf1": {"type": "dielectric", "ior": 1.8}}"#;
    let MaterialKindDescription::Dielectric(larger) = kind_of(two) else { panic!() };
    assert!(larger.refraction == 1.3.into() && is_noted(two, "mixes of two dielectrics"));
}

#[test]
fn nested_bsdfs_end() {
    let circle = r#""bsdfs": [{"name": "a", "type": "transparency", "alpha": 0.5, "base": "a"}]"#;
    assert_import_error(r#"{"type": "sphere", "bsdf": "a"}"#, circle, "bsdfs[0] `a`: BSDFs are nested too deep");
    let mix = |i: usize| {
        format!("{{\"name\": \"b{i}\", \"type\": \"mixed\", \"bsdf0\": \"b{0}\", \"bsdf1\": \"b{0}\"}}", i + 1)
    };
    let chain: Vec<String> = (0..4).map(mix).chain(["{\"name\": \"b4\", \"type\": \"lambert\"}".into()]).collect();
    let scene = import_scene(r#"{"type": "sphere", "bsdf": "b0"}"#, &format!("\"bsdfs\": [{}]", chain.join(", ")));
    assert!(scene.description.materials.len() < 10, "{:?}", scene.description.materials);
    assert_import_error(r#"{"type": "sphere", "bsdf": {"type": "mixed"}}"#, "", "this BSDF has no `bsdf0`");
    assert_import_error(r#"{"type": "sphere", "bsdf": {"type": "smooth_coat"}}"#, "", "this coat has no base");
}

#[test]
fn unsupported_bsdfs_and_textures_are_noted() {
    for kind in ["hair", "lambertian_fiber", "rough_wire", "error", "what"] {
        assert!(is_noted(&format!("{{\"type\": \"{kind}\"}}"), &format!("BSDFs of kind `{kind}` become diffuse")));
    }
    assert!(is_noted(r#"{"type": "oren_nayar", "roughness": 0.5}"#, "`oren_nayar` becomes diffuse"));
    assert!(is_noted(r#"{"type": "phong"}"#, "`phong` becomes a Phong lobe"));
    assert!(is_noted(r#"{"type": "lambert", "bump": 1}"#, "bump maps are ignored"));
    let ies = r#"{"type": "lambert", "albedo": {"type": "ies"}}"#;
    assert!(is_noted(ies, "textures of kind `ies` become white") && kind_of(ies) == diffuse(DVec3::ONE));
    let strange = r#"{"type": "sphere", "bsdf": {"type": "rough_plastic", "distribution": "gauss"}}"#;
    assert_import_error(strange, "", "no microfacet distribution is called `gauss`");
    assert_import_error(
        r#"{"type": "sphere", "bsdf": {"type": "lambert", "albedo": true}}"#,
        "",
        "`albedo` is no color",
    );
    assert_import_error(r#"{"type": "sphere", "bsdf": {"type": "lambert", "albedo": "x.png"}}"#, "", "does not exist");
}

#[test]
fn checkerboards_begin_with_their_off_color() {
    let bsdf = r#"{"type": "lambert", "albedo": {"type": "checker", "on_color": 0.75, "off_color": [0, 0, 1],
        "res_u": 4, "res_v": 6}}"#;
    let scene = import_scene(&format!("{{\"type\": \"quad\", \"bsdf\": {bsdf}}}"), "");
    let TextureKindDescription::Checker { colors, uv_transform } = &scene.description.textures[0].value.kind else {
        panic!()
    };
    assert_eq!((*colors, uv_transform.scale), ([DVec3::Z, DVec3::splat(0.75)], DVec2::new(4.0, 6.0)));
}

#[test]
fn pictures_are_scaled_and_clamped() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_pixels(2, 1, vec![Vec3::splat(0.25), Vec3::splat(3.0)]).unwrap();
    write(&folder.path().join("a.exr"), &image, &WriteOptions::default()).unwrap();
    let texture = r#"{"type": "bitmap", "file": "a.exr", "clamp": true, "scale": 2, "interpolate": false}"#;
    let quad = format!("{{\"type\": \"quad\", \"bsdf\": {{\"type\": \"lambert\", \"albedo\": {texture}}}}}");
    let scene = import_in_folder(folder.path(), &quad, "");
    let TextureKindDescription::Image { path, wrap, .. } = &scene.description.textures[0].value.kind else { panic!() };
    assert_eq!(*wrap, WrapMode::Clamp);
    assert_eq!(scene.assets.pictures[&path.value].pixels(), [Vec3::splat(0.5), Vec3::ONE]);
    assert!(has_note(&scene, "textures are interpolated"));
}
