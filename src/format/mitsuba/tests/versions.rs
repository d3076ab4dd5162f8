//! Tests of defaults that depend on the version of the file.

use super::decode;
use crate::format::description::{
    ConductorDescription, DensityDescription, MaterialKindDescription, MetalDescription, MirrorDescription,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::format::transform_step::TransformStep;
use glam::DVec3;
use std::path::Path;

fn import_version(version: &str, folder: &Path, content: &str) -> ImportedScene {
    let text = format!("<scene version=\"{version}\">{content}</scene>");
    let result = decode(&folder.join("a.xml"), text.as_bytes(), &ImportOptions::default());
    result.unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn conductors_without_a_metal_are_copper_in_old_files() {
    let conductor = "<shape type=\"sphere\"><bsdf type=\"conductor\"/></shape>";
    let kind = |version: &str| {
        let scene = import_version(version, Path::new("/nowhere"), conductor);
        scene.description.materials[0].kind.clone()
    };
    let MaterialKindDescription::Conductor(ConductorDescription { metal: MetalDescription::Named(name), .. }) =
        kind("0.5.0")
    else {
        panic!()
    };
    assert_eq!(&*name.value, "copper");
    let mirror = MaterialKindDescription::Mirror(MirrorDescription { reflectance: DVec3::ONE.into() });
    assert_eq!([kind("2.0.0"), kind("3.0.0")], [mirror.clone(), mirror]);
}

#[test]
fn values_of_old_volumes_lie_on_the_sides_of_their_box() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = b"VOL\x03".to_vec();
    [1_u32, 3, 2, 1, 1].iter().for_each(|n| file.extend(n.to_le_bytes()));
    [-1.0_f32, 0.0, 0.0, 3.0, 2.0, 1.0].iter().for_each(|x| file.extend(x.to_le_bytes()));
    [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().for_each(|x| file.extend(x.to_le_bytes()));
    std::fs::write(folder.path().join("a.vol"), file).unwrap();
    let corners = |version: &str| {
        let scene = import_version(
            version,
            folder.path(),
            r#"<shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous">
              <volume name="density" type="gridvolume"><string name="filename" value="a.vol"/></volume>
              </medium></shape>"#,
        );
        let DensityDescription::Grid { extent, .. } = &scene.description.media[0].value.density else { panic!() };
        let to_world = TransformStep::composed_matrix(&extent.steps);
        [extent.min, extent.max].map(|corner| to_world.transform_point3(corner))
    };
    // The samples are 2 apart along x and along y; the only one along z fills the box.
    assert_eq!(corners("0.6.0"), [DVec3::new(-2.0, -1.0, 0.0), DVec3::new(4.0, 3.0, 1.0)]);
    assert_eq!(corners("3.0.0"), [DVec3::ZERO, DVec3::ONE]);
}
