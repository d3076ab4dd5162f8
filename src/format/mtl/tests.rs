use super::*;
use crate::format::description::{
    DielectricAbsorption, DielectricDescription, EmissionDescription, MaterialKindDescription, MirrorDescription,
    PhongDescription,
};

fn decode_text(text: &str) -> Result<Vec<MtlMaterial>, MeshError> {
    decode(Path::new("folder/a.mtl"), text.as_bytes())
}

fn read_single_material(text: &str) -> MtlMaterial {
    let materials = decode_text(&format!("newmtl m\n{text}")).unwrap();
    assert_eq!(materials.len(), 1);
    materials[0].clone()
}

fn converted_material_kind(text: &str) -> MaterialKindDescription {
    read_single_material(text).to_description().unwrap().kind
}

#[test]
fn a_byte_order_mark_is_skipped() {
    assert_eq!(decode_text("\u{feff}newmtl a\nKd 1 0 0\n").unwrap(), decode_text("newmtl a\nKd 1 0 0\n").unwrap());
}

#[test]
fn every_supported_mtl_line_is_read() {
    let text = "Ka 1 1 1\n Kd .1 .2 .3 # red\nKs 0.5\nKe 1 2 3\r\nTf .9 .8 .7\nNs 20\nNi 1.5\nTr .25\nillum 2\n\
                map_Kd -s 2 2 -o .5 -clamp on pictures\\a b.png\nmap_bump x\nunknown 1\n";
    let v = DVec3::new;
    let expected = MtlMaterial {
        name: "m".to_owned(),
        diffuse: Some(v(0.1, 0.2, 0.3)),
        specular: Some(v(0.5, 0.5, 0.5)),
        emission: Some(v(1.0, 2.0, 3.0)),
        transmission_filter: Some(v(0.9, 0.8, 0.7)),
        shininess: Some(20.0),
        opacity: Some(0.75),
        refractive_index: Some(1.5),
        illumination_model: Some(2),
        diffuse_texture_path: Some(PathBuf::from("folder/pictures/a b.png")),
    };
    assert_eq!(read_single_material(text), expected);
    assert_eq!(read_single_material(""), MtlMaterial { name: "m".to_owned(), ..MtlMaterial::default() });
    let two = decode_text("# head\n\nnewmtl a b\nKd 1 1 1\nnewmtl c\nd 1\n").unwrap();
    assert_eq!((two[0].name.as_str(), two[1].name.as_str(), two[1].diffuse), ("a b", "c", None));
    // Some exporters write a negative exponent for no highlight.
    assert_eq!(read_single_material("Ns -1.96").shininess, Some(0.0));
    assert_eq!(read_single_material("d -halo .5").opacity, Some(0.5));
}

#[test]
fn invalid_lines_are_reported() {
    for (line, message) in [
        ("Kd 1 2", "`Kd` holds no RGB colour"),
        ("Kd", "`Kd` holds no RGB colour"),
        ("Kd xyz 1 1 1", "`Kd` holds no RGB colour"),
        ("Ks spectral a.rfl", "`Ks` holds no RGB colour"),
        ("Ke 1 nan 1", "`nan` of `Ke` is not a finite number"),
        ("Kd 1 -1 1", "`Kd` holds -1"),
        ("Tf 1 1e999 1", "is not a finite number"),
        ("Kd 1 1e39 1", "`Kd` holds 1e39"),
        ("Ke 1e300", "`Ke` holds 1e300"),
        ("Ns 1e39", "`Ns` holds 1e39"),
        ("Ns x", "`x` of `Ns`"),
        ("Ni", "`` of `Ni`"),
        ("d 1.5", "`d` is 1.5"),
        ("Tr -1", "`Tr` is -1"),
        ("illum 11", "`11` is no illumination model"),
        ("illum two", "`two` is no illumination model"),
        ("map_Kd", "`map_Kd` names no picture"),
        ("map_Kd -s 1 1 1", "`map_Kd` names no picture"),
        ("newmtl", "`newmtl` gives no name"),
    ] {
        let error = decode_text(&format!("newmtl m\n\n{line}\n")).unwrap_err().to_string();
        assert!(error.starts_with("folder/a.mtl:3: ") && error.contains(message), "{error}");
    }
    let early = decode_text("Kd 1 1 1\n").unwrap_err().to_string();
    assert!(early.contains("a.mtl:1: `Kd` stands before any `newmtl`"), "{early}");
}

#[test]
fn mtl_materials_become_scene_materials() {
    let phong = |kd: f64, ks: f64, shininess| {
        MaterialKindDescription::Phong(PhongDescription {
            diffuse: DVec3::splat(kd).into(),
            specular: DVec3::splat(ks).into(),
            shininess,
            texture: None,
        })
    };
    let glass = |index: f64| {
        let attenuation = DielectricAbsorption::None;
        MaterialKindDescription::Dielectric(DielectricDescription {
            refraction: index.into(),
            absorption: attenuation,
            roughness: 0.0.into(),
            has_multiple_scattering: true,
            priority: 0,
        })
    };
    assert_eq!(converted_material_kind(""), phong(1.0, 0.0, 0.0));
    assert_eq!(converted_material_kind("Kd .5 .5 .5\nKs .25\nNs 10\nillum 2"), phong(0.5, 0.25, 10.0));
    assert_eq!(converted_material_kind("Kd .5 .5 .5\nKs .25\nNs 10"), phong(0.5, 0.25, 10.0));
    assert_eq!(converted_material_kind("Kd .5 .5 .5\nKs .25\nNs 10\nillum 1"), phong(0.5, 0.0, 10.0));
    for model in [4, 6, 7, 9] {
        assert_eq!(converted_material_kind(&format!("Kd .5\nNi 1.33\nd 1\nillum {model}")), glass(1.33));
    }
    assert_eq!(converted_material_kind("Kd .5\nd .1"), glass(1.5));
    assert_eq!(converted_material_kind("Kd .5\nTr .9\nNi 1.7\nTf 1 1 1"), glass(1.7));
    let color = DVec3::new(0.9, 1.0, 0.5);
    match converted_material_kind("d 0\nTf .9 1 .5") {
        MaterialKindDescription::Dielectric(DielectricDescription { absorption: attenuation, .. }) => {
            assert_eq!(attenuation, DielectricAbsorption::Tint { color, distance: 1.0 });
        }
        other => panic!("{other:?}"),
    }
    for model in [3, 5, 8] {
        let mirror = converted_material_kind(&format!("Kd 0\nKs .9 .8 2\nillum {model}"));
        assert_eq!(
            mirror,
            MaterialKindDescription::Mirror(MirrorDescription { reflectance: DVec3::new(0.9, 0.8, 1.0).into() })
        );
    }
    assert_eq!(converted_material_kind("Kd .1\nKs .9\nillum 3"), phong(0.1, 0.9, 0.0));
    let whole = std::path::absolute("folder/a.png").unwrap();
    let lamp = read_single_material("Kd 0\nKe 3 2 1\nmap_Kd a.png").to_description().unwrap();
    assert_eq!(lamp.emission, Some(EmissionDescription::Constant(DVec3::new(3.0, 2.0, 1.0))));
    assert!(
        matches!(lamp.kind, MaterialKindDescription::Phong(PhongDescription { texture: Some(path), .. }) if Path::new(&path.value) == whole)
    );
    assert_eq!(read_single_material("Ke 0 0 0").to_description().unwrap().emission, None);
    let (message, _) = read_single_material("d 0\nNi 0").to_description().unwrap_err();
    assert!(message.contains("`m`") && message.contains("`Ni` is 0"), "{message}");
    // The index of an opaque material is not used.
    assert_eq!(converted_material_kind("Ni 0"), phong(1.0, 0.0, 0.0));
}

#[test]
fn materials_write_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.mtl");
    let full = MtlMaterial {
        diffuse_texture_path: Some(folder.path().join("pictures/a b.png")),
        ..read_single_material(
            "Kd .1 .2 .3\nKs .5\nKe 1e-9 1e20 3\nTf .9 .8 .7\nNs 20.123456789012345\nNi 1.5\nd .1\nillum 2",
        )
    };
    let elsewhere = MtlMaterial {
        name: "n".to_owned(),
        diffuse_texture_path: Some(PathBuf::from("/else/c.png")),
        ..Default::default()
    };
    write(&path, &[full.clone(), elsewhere.clone()]).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().contains("map_Kd pictures/a b.png\n"));
    assert_eq!(load_mtl_files(&folder.path().join("x.obj"), &["out.mtl".to_owned()], None).unwrap(), [full, elsewhere]);
}

#[test]
fn material_libraries_are_found_beside_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("x.obj");
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("a b.mtl", "newmtl m\nKd .1\nnewmtl n\n");
    let libraries =
        |names: &[&str]| load_mtl_files(&mesh, &names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>(), None);
    assert_eq!(libraries(&["a b.mtl"]).unwrap().len(), 2);
    let error = libraries(&["b.mtl"]).unwrap_err().to_string();
    assert!(error.contains("b.mtl") && error.contains("put it beside the mesh"), "{error}");
    put("b.mtl", "newmtl m\nKd .2\n");
    put("c.mtl", "newmtl o\n");
    // Two files on one line; the last definition of a name counts.
    let all = libraries(&["a b.mtl", "b.mtl c.mtl"]).unwrap();
    assert_eq!(all.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["n", "m", "o"]);
    assert_eq!(all[1].diffuse, Some(DVec3::splat(0.2)));
}

proptest::proptest! {
    #[test]
    fn random_text_never_panics_the_reader(
        words in proptest::collection::vec("newmtl|K[dse]|Tf|N[si]|d|Tr|illum|map_Kd|-s|-o|\n|\\\\|-?[0-9.]{1,4}|.{0,3}", 0..60),
    ) {
        for material in decode_text(&words.join(" ")).unwrap_or_default() {
            let _ = material.to_description();
        }
    }
}
