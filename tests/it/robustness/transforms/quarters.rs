//! Planes rotated by multiples of 90°.

use caustica::accel::ShapeHit;
use caustica::color::Rgb;
use caustica::format::description::TransformStep;
use caustica::format::{SourceText, parse, resolve};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use caustica::math::{Motion, Ray};
use caustica::shape::Plane;
use glam::{DMat3, DVec3, Vec3};
use std::path::Path;

/// Rotations by multiples of 90° map axes exactly to axes.
///
/// A motion by two quarter turns is also exact in its middle.
#[test]
fn quarter_turns_are_exact() {
    for quarters in -9i32..=9 {
        let angle = 90.0 * f64::from(quarters);
        let (x, z) = match quarters.rem_euclid(4) {
            0 => (DVec3::X, DVec3::Z),
            1 => (DVec3::NEG_Z, DVec3::X),
            2 => (DVec3::NEG_X, DVec3::NEG_Z),
            _ => (DVec3::Z, DVec3::NEG_X),
        };
        let expected = DMat3::from_cols(x, DVec3::Y, z);
        assert_eq!(TransformStep::RotateY(angle).matrix().matrix3, expected, "{angle}");
        assert_eq!(TransformStep::Rotate { axis: DVec3::Y * 3.0, angle }.matrix().matrix3, expected, "{angle}");
        let moving = Motion::default().preceded_by_factors([TransformStep::RotateY(2.0 * angle).motion_factor()]);
        assert_eq!(moving.at_time(0.5).matrix3, expected, "{angle}");
    }
}

/// Rays along a plane miss it, although rounding tilted the plane's normal off its axis.
///
/// A ray that leans towards the plane hits it.
#[test]
fn rays_along_a_plane_miss_it() {
    for lean in [-2.5e-16, -1.8e-16, 6e-17, 1.8e-16, 2.5e-16] {
        let plane = Plane::new(DVec3::X * 5.0, DVec3::new(1.0, lean, 0.0));
        for along in [Vec3::Y, Vec3::NEG_Y, Vec3::Y * 1e-6, Vec3::Y * 1e6] {
            let hit = plane.intersect(&Ray::new(Vec3::ZERO, along));
            assert!(hit.is_none(), "{lean} {along}: {hit:?}");
        }
    }
    let plane = Plane::new(DVec3::X * 5.0, DVec3::X);
    let ShapeHit { t, .. } = plane.intersect(&Ray::new(Vec3::ZERO, Vec3::new(1e-14, 1.0, 0.0))).unwrap();
    assert!((t / 5e14 - 1.0).abs() < 1e-6, "{t}");
}

/// All light of an overhead sun arrives between vertical walls, by shadow rays and by photons.
///
/// The walls are horizontal planes that transforms have rotated.
#[test]
fn overhead_sun_lights_between_rotated_walls() {
    let walls = "Plane { normal 0 1 0 offset -3 }";
    for turn in ["ZRotate 90", "ZRotate 270", "ZRotate -90", "XRotate 90", "XRotate 270", "ZRotate 45 ZRotate 45"] {
        let text = format!(
            "PerspectiveCamera {{ center 0 1 .1  lookAt 0 0 0  angle 10  width 4  height 4 }}
            Background {{ color 0 0 0 }}
            Lights {{ DirectionalLight {{ direction 0 -1 0  irradiance 3.1415927 3.1415927 3.1415927 }} }}
            Materials {{ Diffuse {{ reflectance 1 1 1 }} }}
            Group {{
                Plane {{ normal 0 1 0  offset 0 }}
                Sphere {{ center 2 .5 0  radius .5 }}
                Transform {{ {turn} {walls} }}
            }}"
        );
        let name = "walls.txt";
        let scene = resolve(&parse(name, &text).unwrap(), &SourceText::new(name, &text), Path::new("")).unwrap();
        let integrator = Algorithm::Whitted.prepare(&scene, Settings::default());
        let image = integrator.render_pass(0, &SilentMonitor).image;
        // White ground under irradiance π has radiance 1.
        let all = image.iter().all(|v| (*v - Rgb::ONE).abs().max_element() < 1e-5);
        assert!(all, "{turn}: {:?}", image[0]);
    }
}
