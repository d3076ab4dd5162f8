//! Rendered textures: closed forms for means, slopes and energy, and noise reduction by filtering.

use crate::support::scene_from_text_in;
use caustica::camera::{Filter, FilterKind};
use caustica::color::{self, Rgb};
use caustica::image;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::math::Ray;
use caustica::plan::EffectOverrides;
use caustica::scene::{Effect, Effects, Hit, RayCone, Scene, SurfaceInteraction};
use glam::{DVec2, DVec3, Vec3};

fn scene(text: &str) -> Scene {
    scene_from_text_in("", text)
}

fn picture(scene: &Scene, algorithm: Algorithm, samples: u32, passes: u32, effects: EffectOverrides) -> Vec<Vec<Rgb>> {
    let filter = Filter::new(FilterKind::Box);
    let camera_paths =
        CameraPathSettings { samples_per_pixel: Some(samples), filter, effects, ..CameraPathSettings::default() };
    let settings = Settings {
        camera_paths,
        allows_ray_photon_balance: false,
        unaimed_paths: 20_000,
        aimed_paths: 20_000,
        ..Settings::default()
    };
    let integrator = algorithm.prepare(scene, settings);
    (0..passes).map(|pass| integrator.render_pass(pass, &SilentMonitor).image).collect()
}

/// Returns the first hit of a ray, and the ray in the scene's coordinates.
///
/// `from` and `direction` are in the coordinates of the scene description. Panics if the ray hits
/// nothing.
fn hit(scene: &Scene, from: DVec3, direction: DVec3) -> (Hit, Ray) {
    let ray = Ray::new((from - scene.origin()).as_vec3(), direction.normalize().as_vec3());
    (scene.intersect(&ray).expect("the ray hits an object"), ray)
}

fn surface(scene: &Scene, from: DVec3, direction: DVec3) -> SurfaceInteraction<'_> {
    let (hit, ray) = hit(scene, from, direction);
    scene.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::ALL), || 0.5)
}

fn uv(scene: &Scene, from: [f64; 3], direction: [f64; 3]) -> DVec2 {
    let (hit, ray) = hit(scene, DVec3::from(from), DVec3::from(direction));
    let cone = RayCone::zero_width_cone(Effects::ALL);
    let surface = scene.surface_interaction(&ray, &hit, &cone, || 0.5);
    scene.texture_context(&hit, &surface.point, surface.wo, &cone).uv
}

const CAMERA: &str = "PerspectiveCamera { center 0 1 0  lookAt 0 .9 -5  angle 30  width 64  height 32 }";

#[test]
fn shapes_have_documented_uv_coordinates() {
    let of = |shape: &str| {
        scene(&format!(
            "{CAMERA} Textures {{ Checker t {{ }} }} Materials {{ Diffuse {{ reflectance t }} }} Group {{ MaterialIndex 0 {shape} }}"
        ))
    };
    let down = [0.0, -1.0, 0.0];
    let close = |found: DVec2, u: f64, v: f64| assert!((found - DVec2::new(u, v)).length() < 1e-5, "{found}");
    let ground = of("Rectangle { corner -5 0 5  edge0 10 0 0  edge1 0 0 -10 }");
    close(uv(&ground, [1.0, 3.0, -2.0], down), 0.6, 0.7);
    // Texture coordinates move with transforms, mirrors included.
    let carried =
        of("Transform { Translate 1 0 0  Scale -2 1 1  Rectangle { corner -1 0 1  edge0 2 0 0  edge1 0 0 -2 } }");
    close(uv(&carried, [2.0, 3.0, 0.5], down), 0.25, 0.25);
    close(uv(&of("Plane { normal 0 1 0  offset 0 }"), [1.5, 3.0, 2.0], down), 1.5, -2.0);
    close(uv(&of("Disc { center 1 0 0  normal 0 1 0  radius 2 }"), [2.0, 3.0, 1.0], down), 0.75, 0.25);
    close(uv(&of("Sphere { center 0 0 0  radius 2 }"), [0.0, 0.0, 9.0], [0.0, 0.0, -1.0]), 0.5, 0.5);
    let turned = of("Transform { YRotate 90  Sphere { center 0 0 0  radius 2 } }");
    close(uv(&turned, [9.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), 0.5, 0.5);
    let ellipsoid = of("Transform { Scale 1 3 1  Sphere { center 0 0 0  radius 1 } }");
    close(uv(&ellipsoid, [9.0, 3.0 * 0.5f64.sqrt(), 0.0], [-1.0, 0.0, 0.0]), 0.75, 0.75);
    let triangle = "Triangle { vertex0 0 0 0  vertex1 0 0 2  vertex2 2 0 0";
    close(uv(&of(&format!("{triangle} }}")), [0.5, 1.0, 1.0], down), 0.5, 0.25);
    close(uv(&of(&format!("{triangle}  uv0 1 1  uv1 3 1  uv2 1 5 }}")), [0.5, 1.0, 1.0], down), 2.0, 2.0);
}

/// A checkerboard near the horizon is filtered to its mean.
///
/// A wide strip of it has half of each colour, and so has its image.
#[test]
fn far_checkerboard_is_filtered_to_its_mean() {
    let tiles = |color0: &str, color1: &str| {
        scene(&format!(
            "{CAMERA} Background {{ color 0 0 0 }} Lights {{ DirectionalLight {{ direction 0 -1 0  irradiance 3.1415926 3.1415926 3.1415926 }} }}
             Textures {{ Checker t {{ color0 {color0}  color1 {color1}  scale 2.3 2.3 }} }}
             Materials {{ Diffuse {{ reflectance t }} }} Group {{ MaterialIndex 0  Plane {{ normal 0 1 0  offset 0 }} }}"
        ))
    };
    let passes = picture(&tiles(".1 .1 .1", ".8 .8 .8"), Algorithm::Whitted, 1, 16, EffectOverrides::NO_OVERRIDES);
    // The horizon is at row 14.8, and a pixel is .0168 high at distance 1. Rows 16 and 17 show the
    // floor at distances from 50 to 19. A surface of reflectance r under irradiance π has radiance
    // r.
    let strip = |image: &[Rgb]| -> Vec<f64> {
        image[16 * 64..18 * 64].iter().map(|c| f64::from(color::channel_mean(*c))).collect()
    };
    let values: Vec<Vec<f64>> = passes.iter().map(|p| strip(p)).collect();
    let all: Vec<f64> = values.concat();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let of_passes: Vec<f64> = values.iter().map(|v| v.iter().sum::<f64>() / 128.0).collect();
    let spread = of_passes.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / 15.0 / 16.0;
    // The nearest line of the strip is 20 units or 46 tiles long. Half a tile too many of one
    // colour shifts the mean by ½ · .7/46. Student's t over 16 passes exceeds 7.5 once in a
    // million.
    assert!((mean - 0.45).abs() < 0.5 * 0.7 / 46.0 + 7.5 * spread.sqrt(), "{mean}");
    let variance = |i: usize| {
        let of: Vec<f64> = values.iter().map(|v| v[i]).collect();
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        of.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (of.len() - 1) as f64
    };
    let sparkle = (0..128).map(variance).sum::<f64>() / 128.0;
    // Unfiltered, each sample is .1 or .8 by chance, which is a variance of .35² if a pixel covers
    // many tiles. A footprint of half a pixel covers 9.5 tiles along the view in row 17, and more
    // in row 16. The mean of an alternating pattern over them has an error of at most one tile.
    eprintln!("variance between passes {sparkle:.5}, unfiltered .1225");
    assert!(sparkle < 0.1225 / (9.5 * 9.5), "{sparkle}");
}

/// A linear bump map tilts the normal of a plane by its slope.
///
/// A surface of height s·u with u = x/w has the slope s/w along x. So its normal is the normalized
/// vector (−s/w, 1), with components along x and along the height.
#[test]
fn linear_bump_map_tilts_the_plane() {
    let folder = tempfile::tempdir().unwrap();
    // Heights rise by 1/64 per pixel.
    let pixels = (0..64 * 4).map(|i| Vec3::splat((i % 64) as f32 / 64.0)).collect();
    let ramp = image::Image::from_pixels(64, 4, pixels).unwrap();
    let path = folder.path().join("ramp.exr");
    image::write(&path, &ramp, &Default::default()).unwrap();
    for (height, width) in [(0.5, 2.0), (-1.5, 3.0)] {
        let scene = scene(&format!(
            "{CAMERA} Textures {{ Image ramp {{ file \"{}\"  encoding linear  wrap clamp }} }}
             Materials {{ Diffuse {{ reflectance 1 1 1  bump ramp  bumpHeight {height} }} }}
             Group {{ MaterialIndex 0  Rectangle {{ corner 0 0 0  edge0 {width} 0 0  edge1 0 0 -{width} }} }}",
            path.display()
        ));
        let found = surface(&scene, DVec3::new(0.4 * width, 3.0, -0.3 * width), DVec3::NEG_Y).point;
        let expected = DVec3::new(-height / width, 1.0, 0.0).normalize();
        assert_eq!(found.ng, Vec3::Y);
        // The tolerance covers heights and their differences in f32.
        assert!((found.ns.as_dvec3() - expected).length() < 1e-4, "{} {expected}", found.ns);
    }
}

#[test]
fn mapped_normals_follow_uv_and_stay_outside() {
    let with = |color: &str, edges: &str| {
        let text = format!(
            "{CAMERA} Textures {{ Checker t {{ color0 {color}  color1 {color} }} }}
             Materials {{ Diffuse {{ reflectance 1 1 1  normalMap t }} }}
             Group {{ MaterialIndex 0  Rectangle {{ corner -1 0 1  {edges} }} }}"
        );
        surface(&scene(&text), DVec3::new(0.1, 3.0, 0.1), DVec3::NEG_Y).point.ns
    };
    let straight = "edge0 2 0 0  edge1 0 0 -2";
    let close = |a: Vec3, b: [f32; 3]| assert!((a - Vec3::from(b).normalize()).length() < 1e-5, "{a} {b:?}");
    close(with(".5 .5 1", straight), [0.0, 1.0, 0.0]);
    // Red tilts the normal along u, which is x. Green tilts it along v, which is −z.
    close(with(".8 .5 .9", straight), [0.6, 0.8, 0.0]);
    close(with(".5 .8 .9", straight), [0.0, 0.8, -0.6]);
    // A normal that would point below the surface is limited to a grazing one.
    let inside = with(".9 .5 .1", straight);
    assert!(inside.y > 0.0 && inside.y < 0.1 && inside.x > 0.9, "{inside}");
}

/// Bump maps create no energy: in a furnace of radiance 1, no surface is brighter than 1.
///
/// The tolerance is five standard errors of the mean over passes.
#[test]
fn bump_maps_create_no_energy() {
    for relief in ["bump lumps  bumpHeight .3", "normalMap wild"] {
        for material in [
            "Diffuse { reflectance 1 1 1",
            "Phong { diffuseColor .5 .5 .5  specularColor 5 5 5  shininess 20",
            "Mirror { ",
        ] {
            let scene = scene(&format!(
                "PerspectiveCamera {{ center 0 0 4  lookAt 0 0 0  angle 30  width 24  height 24 }}
                 Lights {{ EnvironmentLight {{ radiance 1 1 1 }} }}
                 Textures {{ Noise lumps {{ frequency 4 }}  Checker wild {{ color0 .9 .1 .6  color1 .2 .9 .5  scale 20 20 }} }}
                 Materials {{ {material}  {relief} }} }}
                 Group {{ MaterialIndex 0  Sphere {{ center 0 0 0  radius 1 }} }}"
            ));
            for algorithm in [Algorithm::Path, Algorithm::Hybrid] {
                let passes: Vec<f64> = picture(&scene, algorithm, 4, 8, EffectOverrides::NO_OVERRIDES)
                    .iter()
                    .map(|image| {
                        image.iter().map(|c| f64::from(color::channel_mean(*c))).sum::<f64>() / image.len() as f64
                    })
                    .collect();
                let mean = passes.iter().sum::<f64>() / 8.0;
                let variance = passes.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 7.0 / 8.0;
                assert!(mean < 1.0 + 5.0 * variance.sqrt() + 1e-5, "{relief}, {material}: {mean}");
                assert!(mean > 0.4, "{relief}, {material}: {mean}");
            }
        }
    }
}

/// If the effect of textures is off, each texture becomes its mean and surfaces are smooth.
///
/// Scenes with these means and without bump maps give the same images.
#[test]
fn disabled_textures_become_their_mean() {
    let with = |reflectance: &str, relief: &str, emission: &str| {
        scene(&format!(
            "{CAMERA} Lights {{ PointLight {{ position 0 4 -4  power 300 300 300 }} }}
             Textures {{ Checker tiles {{ color0 .2 .4 .2  color1 .6 .4 .4 }}  Noise lumps {{ frequency 3 }} }}
             Materials {{ Diffuse {{ reflectance {reflectance}  {relief} }}  Diffuse {{ reflectance 0 0 0  {emission} }} }}
             Group {{ MaterialIndex 0  Plane {{ normal 0 1 0  offset 0 }}
                      MaterialIndex 1  Rectangle {{ corner -1 0 -6  edge0 2 0 0  edge1 0 2 0 }} }}"
        ))
    };
    let dressed = with("tiles", "bump lumps bumpHeight .1", "emission tiles  emissionScale 2");
    let plain = with(".4 .4 .3", "", "emission .8 .8 .6");
    let off = EffectOverrides::NO_OVERRIDES.with_forced_off(Effect::Textures).with_forced_off(Effect::Bump);
    for algorithm in [Algorithm::Whitted, Algorithm::Path, Algorithm::Raycast] {
        let [a, b] = [&dressed, &plain].map(|scene| picture(scene, algorithm, 2, 1, off));
        for (x, y) in a[0].iter().zip(&b[0]) {
            assert!((*x - *y).abs().max_element() <= 1e-5 * y.max_element(), "{}: {x} {y}", algorithm.name());
        }
        assert_ne!(picture(&dressed, algorithm, 2, 1, EffectOverrides::NO_OVERRIDES), a, "{}", algorithm.name());
    }
}

/// A mix with a texture as amount selects one of two materials by position. Where the texture is 0
/// or 1, the choice is not random.
#[test]
fn masks_select_material_by_position() {
    let scene = scene(&format!(
        "{CAMERA} Textures {{ Checker t {{ }} }}
         Materials {{ Diffuse a {{ reflectance .1 .1 .1 }}  Mirror b {{ }}  Mix {{ first a  second b  amount t }} }}
         Group {{ MaterialIndex 2  Plane {{ normal 0 1 0  offset 0 }} }}"
    ));
    for (x, mirror) in [(0.5, false), (1.5, true), (2.5, false), (-0.5, true)] {
        let found = surface(&scene, DVec3::new(x, 2.0, -0.5), DVec3::NEG_Y);
        assert_eq!(found.bsdf.is_specular(), mirror, "{x}");
    }
}

/// A moving object carries its texture.
///
/// At each time, its texture coordinates equal those of an object at rest with the same transform.
#[test]
fn textures_move_with_their_object() {
    let of = |maps: &str, object: &str| {
        scene(&format!(
            "{CAMERA} Textures {{ Checker t {{ }}  Checker lit {{ scale 8 8 }} }}
             Materials {{ Diffuse {{ reflectance t  emission lit }} }} Group {{ MaterialIndex 0  Plane {{ normal 0 1 0  offset -90  emission 0 0 0 }} {maps} {object} }} }}"
        ))
    };
    for object in [
        "Sphere { center 0 0 0  radius 1 }",
        "Transform { Scale 1 .4 .7  Sphere { center 0 0 0  radius 1 } }",
        "Disc { center 0 0 0  normal 0 0 1  radius 1 }",
        "Rectangle { corner -1 -1 0  edge0 2 0 0  edge1 0 2 0 }",
        "Triangle { vertex0 -1 -1 0  vertex1 1 -1 0  vertex2 -1 1 0  uv0 0 0  uv1 3 0  uv2 0 2 }",
    ] {
        let moving = of("Moving { Translate 2 0 0  ZRotate 60", object);
        for time in [0.0, 0.4, 1.0] {
            let still = of(&format!("Transform {{ Translate {} 0 0  ZRotate {}", 2.0 * time, 60.0 * time), object);
            let placed = moving.at_time(time);
            let from = [2.0 * time - 0.1, -0.13, 9.0];
            let [a, b] = [&still, &placed].map(|scene| {
                let found = surface(scene, DVec3::from(from), DVec3::NEG_Z);
                (uv(scene, from, [0.0, 0.0, -1.0]), found.bsdf, found.emission)
            });
            // The tolerance is the rounding of positions below 10 to f32.
            assert!((a.0 - b.0).length() < 1e-5 && (a.1, a.2) == (b.1, b.2), "{object} at {time}: {a:?} {b:?}");
        }
    }
}
