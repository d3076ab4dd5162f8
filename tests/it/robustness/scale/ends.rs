//! Scenes beyond the range of single precision.

use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::scene::{BuildError, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Plane, Shape, Sphere};
use glam::DVec3;

fn balls(places: &[(DVec3, f64)], plane: bool) -> Result<Scene, BuildError> {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::ONE));
    for (center, radius) in places {
        b.add_shape(Shape::Sphere(Sphere::new(*center, *radius)), white, Rgb::ZERO);
    }
    if plane {
        b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Rgb::ZERO);
    }
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ONE }, LightStrength::Physical(Rgb::ONE));
    b.build(Camera::perspective(DVec3::Z * 5.0, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 4).unwrap())
}

/// Too small shapes are refused with a remedy, and shapes above a size of 2⁻³⁹ are not.
///
/// At this size s, the square of the rounding error s·2⁻²⁴ is still a normal single-precision
/// number.
#[test]
fn too_small_shapes_are_refused() {
    let least = libm::exp2(-39.0);
    for (radius, refused) in
        [(1e-300, true), (1e-46, true), (1e-20, true), (0.99 * least, true), (1.01 * least, false), (1.0, false)]
    {
        for plane in [false, true] {
            let built = balls(&[(DVec3::ZERO, radius)], plane);
            let words = built.err().map(|error| error.to_string());
            assert_eq!(words.is_some(), refused, "{radius}: {words:?}");
            assert!(words.is_none_or(|words| words.contains("larger unit")), "{radius}");
        }
    }
    assert!(balls(&[], true).is_ok() && balls(&[], false).is_ok(), "what has no size is not small");
}

/// Positions near the limit of double precision are refused.
///
/// Their squares overflow, and their differences are NaN.
#[test]
fn positions_near_double_limit_are_refused() {
    // The boxes are unbounded, so their center is not a number.
    let boundless = [(DVec3::splat(1e308), 1e308), (DVec3::splat(-1e308), 1e308)];
    assert_eq!(balls(&boundless, false).err(), Some(BuildError::ExtentTooLarge(f64::INFINITY)));
    for far in [1e13, 1e155, 1e200, 1e308, f64::MAX] {
        for center in [DVec3::X * far, DVec3::splat(far), DVec3::new(-far, far, 0.0)] {
            for places in [&[(center, 1.0), (DVec3::ZERO, 1.0)][..], &[(center, 1.0), (-center, 1.0)]] {
                let refused = balls(places, false).err();
                assert!(matches!(refused, Some(BuildError::ExtentTooLarge(_))), "{places:?}: {refused:?}");
            }
        }
        let refused = balls(&[(DVec3::ZERO, far)], false).err();
        assert!(matches!(refused, Some(BuildError::ExtentTooLarge(_))), "{far}: {refused:?}");
    }
}
