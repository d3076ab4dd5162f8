//! Principled materials against the materials of which they are made: pictures of equal bits.

use crate::support::{render_passes, scene_from_text};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};

/// Renders a ball of the material `m`, which the scene text `materials` defines, on a floor.
fn ball_picture(algorithm: Algorithm, materials: &str) -> Vec<Rgb> {
    let scene = scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 1.2 4  direction 0 -.15 -1  up 0 1 0  angle 30  width 16  height 16 }}
        Background {{ color .2 .3 .4 }}
        Lights {{ RectangleLight {{ corner -1 3 -1  edge0 1 0 0  edge1 0 0 1  radiance 9 8 7 }} }}
        Textures {{ Checker checks {{ color0 .2 .2 .2  color1 .7 .7 .7  scale 6 3 }} }}
        Materials {{ Diffuse floor {{ reflectance .5 .5 .5 }} {materials} }}
        Group {{ MaterialName m Sphere {{ center 0 .7 0  radius .7 }}
            MaterialName floor Rectangle {{ corner -3 0 -3  edge0 0 0 6  edge1 6 0 0 }} }}"
    ));
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(4), seed: 3, ..CameraPathSettings::default() };
    let settings = Settings { camera_paths, unaimed_paths: 2000, aimed_paths: 2000, ..Settings::default() };
    render_passes(&scene, algorithm, settings, 1)
}

/// A principled material gives the same bits as the metal, glass, coated base or mix that it stands
/// for.
#[test]
fn principled_equals_the_materials_it_is_made_of() {
    let color = "baseColor .9 .5 .2";
    let metal = "Conductor metal { reflectance .9 .5 .2  roughness .2 }";
    let coated = "CoatedDiffuse coated { reflectance .9 .5 .2  indexOfRefraction 1.4  roughness .2  nonlinear no }";
    let glass = "Dielectric glass { indexOfRefraction 1.4  roughness .2  tint .5 .6 .7  tintDistance 2 }";
    let common = "roughness .2  indexOfRefraction 1.4  tint .5 .6 .7  tintDistance 2";
    let named_m = |material: &str, name: &str| material.replacen(&format!(" {name} "), " m ", 1);
    for (principled, parts) in [
        (format!("{color}  {common}  metallic 1"), named_m(metal, "metal")),
        (format!("{color}  {common}  metallic 1  clearcoat 0"), named_m(metal, "metal")),
        (format!("{color}  {common}"), named_m(coated, "coated")),
        (format!("{color}  {common}  transmission 1"), named_m(glass, "glass")),
        (
            format!("{color}  {common}  metallic checks"),
            format!("{coated} {metal} Mix m {{ first coated  second metal  amount checks }}"),
        ),
        (
            format!("{color}  {common}  metallic .3  transmission .6"),
            format!(
                "{coated} {metal} {glass} Mix inner {{ first coated  second glass  amount .6 }}
                Mix m {{ first inner  second metal  amount .3 }}"
            ),
        ),
    ] {
        for algorithm in [Algorithm::Path, Algorithm::Hybrid] {
            let ours = ball_picture(algorithm, &format!("Principled m {{ {principled} }}"));
            let expected = ball_picture(algorithm, &parts);
            assert!(ours.iter().any(|pixel| *pixel != ours[0]), "{principled}: an empty picture");
            assert!(ours == expected, "{principled} differs from {parts} by {algorithm:?}");
        }
    }
}

/// A clear coat over metal changes the picture, and adds light at most.
#[test]
fn clear_coats_change_the_picture() {
    let metal = "baseColor .05 .05 .05  metallic 1  roughness .3";
    let mean = |coat: &str| {
        let picture = ball_picture(Algorithm::Path, &format!("Principled m {{ {metal} {coat} }}"));
        picture.iter().map(|pixel| pixel.element_sum()).sum::<f32>() / (3 * picture.len()) as f32
    };
    let (bare, coated) = (mean(""), mean("clearcoat 1  clearcoatRoughness .05"));
    assert!(coated > 1.005 * bare, "{bare} {coated}");
}
