//! Principled materials have the bits of their component materials; clear coats agree with closed
//! forms.

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

/// A principled material gives the same bits as the equivalent metal, glass, coated base or mix.
#[test]
fn principled_equals_the_materials_it_is_made_of() {
    let color = "baseColor .9 .5 .2";
    let metal = "Conductor metal { reflectance .9 .5 .2  roughness .2 }";
    let coated = "CoatedDiffuse coated { reflectance .9 .5 .2  indexOfRefraction 1.4  roughness .2  nonlinear no }";
    let glass = "Dielectric glass { indexOfRefraction 1.4  roughness .2  tint .5 .6 .7  tintDistance 2 }";
    let common = "roughness .2  indexOfRefraction 1.4  tint .5 .6 .7  tintDistance 2";
    let bump = "bump checks  bumpHeight .05";
    let with_bump = |material: &str| material.replace(" }", &format!("  {bump} }}"));
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
        (
            format!("{color}  {common}  metallic .3  {bump}"),
            format!("{} {} Mix m {{ first coated  second metal  amount .3 }}", with_bump(coated), with_bump(metal)),
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

/// Mean of a picture of a flat `material` under a sky of radiance 1, seen 60° from the normal.
fn flat_surface_under_sky(material: &str) -> f64 {
    let scene = scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 5 8.660254  lookAt 0 0 0  angle .05  width 16  height 16 }}
        Lights {{ EnvironmentLight {{ radiance 1 1 1 }} }}
        Materials {{ Principled m {{ {material} }} }}
        Group {{ MaterialName m Rectangle {{ corner -1 0 -1  edge0 0 0 2  edge1 2 0 0 }} }}"
    ));
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(256), seed: 3, ..CameraPathSettings::default() };
    let picture = render_passes(&scene, Algorithm::Path, Settings { camera_paths, ..Settings::default() }, 1);
    picture.iter().map(|pixel| f64::from(pixel.element_sum())).sum::<f64>() / (3 * picture.len()) as f64
}

/// A smooth clear coat over black metal shows the sky with the Fresnel reflectance of index 1.5
/// times its coverage. White metal shows the whole sky, with or without coat.
#[test]
fn smooth_clear_coats_reflect_by_fresnels_equations() {
    let (cos_i, cos_t) = (0.5, (1.0f64 - 0.75 / 2.25).sqrt());
    let (s, p) = ((cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t), (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t));
    let fresnel = 0.5 * (s * s + p * p);
    for coverage in [1.0, 0.5] {
        let black = flat_surface_under_sky(&format!("baseColor 0 0 0  metallic 1  clearcoat {coverage}"));
        // Each sample sees the sky with the probability `expected`. The bound is five standard
        // errors.
        let expected = coverage * fresnel;
        let bound = 5.0 * (expected * (1.0 - expected) / f64::from(16 * 16 * 256)).sqrt();
        assert!((black - expected).abs() < bound, "{coverage}: {black}, not {expected}");
        let white = flat_surface_under_sky(&format!("baseColor 1 1 1  metallic 1  clearcoat {coverage}"));
        // White metal has the reflectance 0.9999. The rest of the tolerance covers rounding of 256
        // samples.
        assert!((white - 1.0).abs() < 1.5e-4, "{coverage}: {white}");
    }
}
