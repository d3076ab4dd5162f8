use super::*;
use crate::camera::{FilterKind, Lens};
use crate::color::Rgb;
use crate::scene::{Material, NoInterior, SceneBuilder};
use crate::shape::{Rectangle, Shape, Sphere};
use glam::{DVec3, Mat2};

/// Number of rows and columns of the test pictures.
const SIZE: u32 = 40;

/// Builds a scene with a mirror of the given shape and a lamp, seen by an orthographic camera that
/// looks along −z. The picture is `film` high \[length].
fn mirror_scene(mirror: Shape, lamp: Sphere, film: f64) -> Scene {
    let mut b = SceneBuilder::new();
    let silver = b.add_material(Material::mirror(Rgb::ONE));
    let black = b.add_material(Material::black());
    b.add_shape(mirror, silver, Rgb::ZERO);
    b.add_shape(Shape::Sphere(lamp), black, Rgb::splat(10.0));
    b.build(Camera::orthographic(DVec3::Z * 10.0, DVec3::NEG_Z, DVec3::Y, film, SIZE, SIZE).unwrap()).unwrap()
}

/// Returns the distinct lamp images of `scene`: film regions where camera rays meet a small lamp.
fn images_in(scene: &Scene) -> Vec<FoundLampImage> {
    let key = Key::new(1).purpose_key(Purpose::LampImages);
    ImageSearch { scene, effects: Effects::ALL, lamps: lamp_spheres(scene), key }.distinct_images::<NoInterior>()
}

/// If one of two lamps is a thousand times dimmer than the other, the search leaves it out, because
/// noise is proportional to the squared radiance. Two lamps of the same radiance are both found.
#[test]
fn lamps_of_negligible_noise_are_not_searched() {
    let images_of_two = |second_radiance: f32| {
        let mut b = SceneBuilder::new();
        let black = b.add_material(Material::black());
        for (x, radiance) in [(-0.3, 10.0), (0.3, second_radiance)] {
            let lamp = Sphere::new(DVec3::new(x, 0.0, -6.0), 0.004);
            b.add_shape(Shape::Sphere(lamp), black, Rgb::splat(radiance));
        }
        let camera = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 0.2, SIZE, SIZE).unwrap();
        let mut lights: Vec<u32> = images_in(&b.build(camera).unwrap()).into_iter().map(|image| image.light).collect();
        lights.sort_unstable();
        lights.dedup();
        lights
    };
    assert_eq!(images_of_two(10.0), [0, 1]);
    assert_eq!(images_of_two(0.01), [0]);
}

/// A mirror ball of radius 1 reflects parallel rays evenly: a far lamp of solid angle Ω has a lamp
/// image of area Ω/4. If the lamp lies 60° from the viewing axis, its lamp image lies at the
/// distance sin 30° from the axis.
#[test]
fn mirror_balls_have_images_of_known_size() {
    let film = 2.2;
    let pixel = film / f64::from(SIZE);
    let (distance, radius) = (1000.0, 5.0);
    let at = DVec3::new(3f64.sqrt(), 0.0, 1.0) * (0.5 * distance);
    let scene = mirror_scene(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), Sphere::new(at, radius), film);
    let found = images_in(&scene);
    assert!(!found.is_empty());
    let FoundLampImage { image, radiance, .. } = found[0];
    let expected = Vec2::new((0.5 * f64::from(SIZE) + 0.5 / pixel) as f32, 0.5 * SIZE as f32);
    // The lamp is not at infinity, which moves the lamp image by about 1/1000 of the ball's radius.
    assert!((image.center - expected).length() < 0.03, "{} not {expected}", image.center);
    let image_radius = 0.5 * radius / distance / pixel;
    let area = std::f64::consts::PI * image_radius * image_radius;
    assert!((f64::from(image.area()) / area - 1.0).abs() < 0.01, "{} not {area}", image.area());
    assert!((radiance - 10.0).abs() < 1e-4, "{radiance}");
}

/// At a flat mirror, only the pixels that the lamp image overlaps get lamp images.
#[test]
fn flat_mirrors_have_images_in_few_pixels() {
    let pixel = 0.01;
    let mirror = Rectangle::new(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0);
    let lamp = Sphere::new(DVec3::new(0.0231, 0.0117, 18.0), 0.3 * pixel);
    let scene = mirror_scene(Shape::Rectangle(mirror), lamp, f64::from(SIZE) * pixel);
    let found = images_in(&scene);
    assert_eq!(found.len(), 1, "{found:?}");
    let center = Vec2::new(20.0 + 2.31, 20.0 - 1.17);
    assert!((found[0].image.center - center).length() < 0.02, "{}", found[0].image.center);
    let in_pixels = images_by_pixel(&found, scene.camera(), &Filter::new(FilterKind::Box), 0.0);
    let pixels: Vec<u32> = in_pixels.iter().map(|image| image.pixel).collect();
    // The lamp image reaches from column 22.01 to 22.61 and from row 18.53 to 19.13.
    assert_eq!(pixels, [18 * SIZE + 22, 19 * SIZE + 22]);
    let light: f64 = in_pixels.iter().map(|image| image.pixel_radiance).sum();
    let expected = 10.0 * std::f64::consts::PI * 0.09;
    assert!((light / expected - 1.0).abs() < 0.02, "{light} not {expected}");
}

/// A lamp behind an opaque ball has no lamp image (film region where camera rays meet the lamp).
#[test]
fn hidden_lamps_have_no_image() {
    let mirror = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0));
    let at = DVec3::new(3f64.sqrt(), 0.0, 1.0) * 500.0;
    let mut b = SceneBuilder::new();
    let silver = b.add_material(Material::mirror(Rgb::ONE));
    let black = b.add_material(Material::black());
    b.add_shape(mirror, silver, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(at, 5.0)), black, Rgb::splat(10.0));
    b.add_shape(Shape::Sphere(Sphere::new(at * 0.5, 20.0)), black, Rgb::ZERO);
    let camera = Camera::orthographic(DVec3::Z * 10.0, DVec3::NEG_Z, DVec3::Y, 2.2, SIZE, SIZE).unwrap();
    assert!(images_in(&b.build(camera).unwrap()).is_empty());
}

/// The lamp image of a lamp out of focus moves by l·(1/f − 1/d)/w on the film if the lens position
/// moves by l.
///
/// The camera focuses at distance f, the lamp is at distance d, and a pixel has the width w at
/// distance 1.
#[test]
fn images_move_with_the_lens_position() {
    let (distance, focus, radius) = (6.0, 2.0, 0.004);
    let mut b = SceneBuilder::new();
    let black = b.add_material(Material::black());
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.21, 0.13, -distance), radius)), black, Rgb::splat(10.0));
    let angle = 0.2f64;
    let pinhole = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, angle, SIZE, SIZE).unwrap();
    let scene = b.build(pinhole.with_lens(Lens { radius: 0.01, focus_distance: focus, blades: 0 })).unwrap();
    let found = images_in(&scene);
    assert!(!found.is_empty());
    let width = 2.0 * libm::tan(0.5 * angle) / f64::from(SIZE);
    let expected = ((1.0 / focus - 1.0 / distance) / width) as f32;
    let center = Vec2::new((20.0 + 0.21 / distance / width) as f32, (20.0 - 0.13 / distance / width) as f32);
    for FoundLampImage { image, .. } in found {
        let shift = image.shift_per_lens_position;
        let error = shift - Mat2::from_diagonal(Vec2::new(expected, -expected));
        assert!(error.to_cols_array().iter().all(|e| e.abs() < 0.01 * expected), "{shift}, not {expected}");
        assert!((image.center - center).length() < 0.02, "{}, not {center}", image.center);
        let image_radius = radius / distance / width;
        let area = std::f64::consts::PI * image_radius * image_radius;
        assert!((f64::from(image.area()) / area - 1.0).abs() < 0.01, "{}, not {area}", image.area());
    }
}
