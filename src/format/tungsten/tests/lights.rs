//! Tests of the conversion of skies, suns and points.

use super::{has_note, import_in_folder, import_scene, is_near};
use crate::format::description::{
    DirectionalLightDescription, DirectionalLightStrength, EnvironmentRadiance, LightDescription,
    PointLightDescription, PointLightStrength,
};
use crate::format::import::ImportedScene;
use crate::image::{Image, WriteOptions, write};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn only_light(scene: &ImportedScene) -> &LightDescription {
    let [light] = &scene.description.lights[..] else { panic!("{:?}", scene.description.lights) };
    &light.value
}

#[test]
fn points_have_their_intensity_or_power() {
    let light = |emission: &str| {
        let scene = import_scene(
            &format!("{{\"type\": \"point\", \"transform\": {{\"position\": [1, 2, 3]}}, {emission}}}"),
            "",
        );
        only_light(&scene).clone()
    };
    let point = |intensity: DVec3| {
        let (position, strength) = (DVec3::new(1.0, 2.0, 3.0), PointLightStrength::Intensity(intensity));
        LightDescription::Point(PointLightDescription { position, strength })
    };
    assert_eq!(light("\"emission\": [4, 5, 6]"), point(DVec3::new(4.0, 5.0, 6.0)));
    assert_eq!(light("\"power\": 8"), point(DVec3::splat(8.0 * (1.0 / (4.0 * PI)))));
}

#[test]
fn caps_of_the_sky_become_directional_lights() {
    let scene = import_scene(
        r#"{"type": "infinite_sphere_cap", "cap_angle": 30, "emission": 2, "transform": {"rotation": [0, 0, 90]}}"#,
        "",
    );
    let LightDescription::Directional(DirectionalLightDescription { direction, strength }) = only_light(&scene) else {
        panic!()
    };
    // The cap lies about the direction −x, so its light travels along +x.
    assert!(is_near(*direction, DVec3::X), "{direction}");
    let DirectionalLightStrength::Irradiance(irradiance) = *strength else { panic!() };
    assert!(is_near(irradiance, DVec3::splat(0.5 * PI)), "{irradiance}");
    assert!(has_note(&scene, "caps of the sky become directional lights"));
}

#[test]
fn only_the_first_sky_counts() {
    let scene = import_scene(r#"{"type": "infinite_sphere", "emission": 3}, {"type": "skydome"}"#, "");
    let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::splat(3.0)));
    assert_eq!(*only_light(&scene), sky);
    assert!(has_note(&scene, "skies after the first one are left out"));
    let dome = import_scene(r#"{"type": "skydome", "turbidity": 3}"#, "");
    assert!(
        has_note(&dome, "skydomes become a white sky") && dome.notes.iter().all(|n| !n.message.contains("turbidity"))
    );
    let dark = import_scene(r#"{"type": "infinite_sphere", "emission": 0}"#, "");
    assert!(has_note(&dark, "the file has no light"));
}

/// Returns the rotation of the environment map of a sky with the given rotation about y.
fn map_rotation(degrees: f64) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_pixels(2, 1, vec![Vec3::X, Vec3::Y]).unwrap();
    write(&folder.path().join("a.exr"), &image, &WriteOptions::default()).unwrap();
    let sky = format!(
        "{{\"type\": \"infinite_sphere\", \"emission\": \"a.exr\", \"transform\": {{\"rotation\": [0, {degrees}, 0], \"scale\": 7}}}}"
    );
    let scene = import_in_folder(folder.path(), &sky, "");
    let LightDescription::Environment(EnvironmentRadiance::Picture { scale, rotate, path }) = only_light(&scene) else {
        panic!()
    };
    assert_eq!((*scale, scene.assets.pictures.len()), (1.0, 1));
    assert!(scene.assets.pictures.contains_key(&path.value));
    *rotate
}

/// The left edge of Tungsten's pictures shows −x. That of Caustica's shows +z, before the rotation.
#[test]
fn maps_show_negative_x_at_their_left_edge() {
    let left_edge = |rotate: f64| DVec3::new(libm::sin(rotate.to_radians()), 0.0, libm::cos(rotate.to_radians()));
    assert!(is_near(left_edge(map_rotation(0.0)), DVec3::NEG_X), "{}", map_rotation(0.0));
    // A rotation by 90 degrees takes −x to −z, because it is left-handed.
    assert!(is_near(left_edge(map_rotation(90.0)), DVec3::NEG_Z), "{}", map_rotation(90.0));
}
