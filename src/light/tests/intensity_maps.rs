//! Tests of projectors and goniometric lights, whose intensity is a picture or a map.

use super::environment::random_sky_picture;
use super::*;
use crate::image::Image;
use crate::light::point::PositionalLight;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

const POSITION: Vec3 = Vec3::new(0.3, 3.0, 0.1);

/// A projector that points downwards, with the top of its picture towards −z. The picture has 4 × 3
/// pixels and a black corner.
pub fn test_projector_light() -> ProjectorLight {
    let pixels = (0..12).map(|i| Rgb::new(i as f32, 0.5 * i as f32, 1.0) * if i == 0 { 0.0 } else { 0.3 });
    let picture = Image::from_pixels(4, 3, pixels.collect()).unwrap();
    let slide = ProjectedPicture::new(picture, 1.2).unwrap().unwrap();
    ProjectorLight::new(POSITION, DVec3::NEG_Y, DVec3::NEG_Z, Arc::new(slide), Rgb::splat(2.0))
}

/// A goniometric light with the map of [`random_sky_picture`], whose lit part and bright sun are
/// turned downwards.
pub fn test_goniometric_light() -> GoniometricLight {
    let map = EquirectangularMap::new(random_sky_picture(), Rgb::ONE).unwrap();
    GoniometricLight::new(POSITION, DVec3::X, DVec3::new(0.2, -1.0, 0.1), Arc::new(map), Rgb::splat(2.0))
}

fn white_picture(width: u32, height: u32) -> Image {
    Image::from_pixels(width, height, vec![Rgb::ONE; (width * height) as usize]).unwrap()
}

/// A projector with a white square of 90° emits the flux of one of the six faces of a cube around
/// the pinhole.
#[test]
fn projector_power_is_exact_on_a_cube_face() {
    for size in [1, 2, 7] {
        let slide = Arc::new(ProjectedPicture::new(white_picture(size, size), FRAC_PI_2).unwrap().unwrap());
        let light = ProjectorLight::new(Vec3::ZERO, DVec3::Z, DVec3::Y, slide, Rgb::splat(3.0));
        let power = f64::from(Light::Projector(light).power(BoundingSphere { center: Vec3::ZERO, radius: 1.0 }).x);
        assert!((power / (2.0 * PI) - 1.0).abs() < 1e-6, "{power}");
    }
}

/// Pixel (0, 0) is at the top left of the picture as it appears on a screen.
#[test]
fn projected_picture_is_upright() {
    let light = test_projector_light();
    let half = libm::tanf(0.6);
    for i in 0..12 {
        let (x, y) = (i % 4, i / 4);
        // Seen along −y with −z up, the right side of the picture is +x.
        let right = (2.0 * (x as f32 + 0.5) / 4.0 - 1.0) * half * 4.0 / 3.0;
        let up = (1.0 - 2.0 * (y as f32 + 0.5) / 3.0) * half;
        let w = Vec3::new(right, -1.0, -up).normalize();
        let expected = if i == 0 { 0.0 } else { 0.6 * i as f32 };
        assert!((light.intensity(w).x - expected).abs() < 1e-6, "{x} {y}");
    }
    assert_eq!(light.intensity(Vec3::Y), Rgb::ZERO);
    assert_eq!(light.intensity(Vec3::new(2.0, -1.0, 0.0).normalize()), Rgb::ZERO);
}

#[test]
fn profile_power_matches_closed_forms() {
    let power = |profile: &[(f64, f64)]| {
        let map = Arc::new(map_from_intensity_profile(profile).unwrap());
        let light = GoniometricLight::new(Vec3::ZERO, DVec3::X, DVec3::NEG_Y, map, Rgb::ONE);
        f64::from(Light::Goniometric(light).power(BoundingSphere { center: Vec3::ZERO, radius: 1.0 }).x)
    };
    // The profiles are isotropic; linear from the axis to the opposite direction; and one
    // hemisphere, with an edge that is a quarter of a degree wide.
    for (profile, expected, tolerance) in [
        (&[(0.0, 1.0), (180.0, 1.0)][..], 4.0 * PI, 1e-5),
        (&[(0.0, 1.0), (180.0, 0.0)], 2.0 * PI, 1e-5),
        (&[(0.0, 1.0), (90.0, 1.0)], 2.0 * PI, 3e-3),
    ] {
        let power = power(profile);
        assert!((power / expected - 1.0).abs() < tolerance, "{power} {expected}");
    }
}

#[test]
fn profiles_are_symmetric_about_their_axis() {
    let map = Arc::new(map_from_intensity_profile(&[(0.0, 4.0), (60.0, 1.0), (90.0, 0.0)]).unwrap());
    let light = GoniometricLight::new(Vec3::ZERO, DVec3::X, DVec3::NEG_Y, map, Rgb::ONE);
    for (degrees, expected) in [(0.0f32, 4.0), (30.0, 2.5), (60.0, 1.0), (75.0, 0.5), (120.0, 0.0)] {
        for turn in [0.0f32, 1.0, 4.0] {
            let (s, c) = libm::sincosf(degrees.to_radians());
            let w = Vec3::new(s * libm::cosf(turn), -c, s * libm::sinf(turn));
            assert!((light.intensity(w).x - expected).abs() < 0.01, "{degrees} {turn}");
        }
    }
}

#[test]
fn invalid_pictures_and_profiles_are_errors() {
    let bad = Image::from_pixels(1, 1, vec![Rgb::NAN]).unwrap();
    assert!(matches!(ProjectedPicture::new(bad, 1.0), Err(EmissionPictureError::InvalidPixel { .. })));
    assert!(ProjectedPicture::new(Image::from_pixels(1, 1, vec![Rgb::ZERO]).unwrap(), 1.0).unwrap().is_none());
    assert!(matches!(
        map_from_intensity_profile(&[(0.0, -1.0), (180.0, -1.0)]),
        Err(EmissionPictureError::InvalidPixel { .. })
    ));
}
