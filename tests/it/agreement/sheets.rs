//! Sheets that transmit light diffusely, lit from both sides: closed forms for all integrators.

use super::compare::{Estimate, Grid, Renders, compare};
use super::methods::{ALL, Effort};
use crate::support::{box_faces, dvec3, square_camera};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Shape, Sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const REFLECTANCE: DVec3 = DVec3::new(0.5, 0.2, 0.1);
const TRANSMITTANCE: DVec3 = DVec3::new(0.3, 0.7, 0.4);
const FLOOR: DVec3 = DVec3::new(0.8, 0.5, 0.3);
/// Radiance of the floor's emission.
const EMITTED: DVec3 = DVec3::new(1.0, 2.0, 0.5);
/// Irradiance of the upper side of the sheet.
const SUN: DVec3 = DVec3::new(2.0, 1.0, 3.0);
const HEIGHT: f64 = 0.7;
const SIZE: (u32, u32) = (12, 12);
const EFFORT: Effort = Effort { passes: 8, samples: 4, photons: 6000, caustic: 6000, radius: 0.12 };

/// Builds a sheet over an emissive floor, between four perfect mirrors, with sunlight from above.
///
/// The mirrors make sheet and floor infinite. The camera at `eye` sees the middle of the sheet.
fn sheet_scene(eye: DVec3) -> Scene {
    let mut b = SceneBuilder::new();
    let floor = b.add_material(Material::diffuse(FLOOR.as_vec3()));
    let sheet = b.add_material(Material::diffuse_transmission(REFLECTANCE.as_vec3(), TRANSMITTANCE.as_vec3()));
    let mirror = b.add_material(Material::mirror(Vec3::ONE));
    for (i, face) in box_faces(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, HEIGHT, 1.0), true).into_iter().enumerate() {
        let (material, emission) = match i {
            0 => (floor, EMITTED.as_vec3()),
            1 => (sheet, Vec3::ZERO),
            _ => (mirror, Vec3::ZERO),
        };
        b.add_shape(face, material, emission);
    }
    let light = UnscaledDeltaLight::Directional { direction: DVec3::NEG_Y };
    b.add_delta_light(light, LightStrength::Physical(SUN.as_vec3()));
    let distance = (eye.y - HEIGHT).abs();
    let angle = 2.0 * libm::atan(0.5 / distance) * 180.0 / PI;
    b.build(square_camera(eye, dvec3(0.0, HEIGHT, 0.0), angle, SIZE.0)).unwrap()
}

/// The irradiance of the sheet from below is a geometric series.
///
/// Let r and t be the reflectance and transmittance of the sheet, ρ the reflectance of the floor, L
/// its emission and S the sunlight. The floor receives rE + tS, and the sheet E = πL + ρ(rE + tS).
/// So E = (πL + ρtS)/(1 − ρr). The sheet has the radiance (rS + tE)/π above, and (rE + tS)/π below.
#[test]
fn sheets_show_light_from_both_sides() {
    let (r, t) = (REFLECTANCE, TRANSMITTANCE);
    let below = (PI * EMITTED + FLOOR * t * SUN) / (1.0 - FLOOR * r);
    for (name, eye, radiance) in [
        ("above", dvec3(0.0, 1.5, 0.0), (r * SUN + t * below) / PI),
        ("below", dvec3(0.0, 0.1, 0.0), (r * below + t * SUN) / PI),
    ] {
        let scene = sheet_scene(eye);
        let expected =
            Estimate { mean: vec![radiance], variance: vec![DVec3::ZERO], bias: vec![DVec3::ZERO], dof: f64::INFINITY };
        for method in ALL {
            let ours = Renders::new(method, &scene, EFFORT).over(&Grid::new(SIZE, 12));
            compare(&format!("sheet from {name}, {method:?}"), &ours, &expected, 0.03);
        }
    }
}

/// Center of the lampshade, and the power of the lamp in it.
const SHADE_CENTER: DVec3 = DVec3::new(0.2, 0.1, -0.3);
const LAMP_POWER: DVec3 = DVec3::new(20.0, 30.0, 10.0);

/// A ball of diffuse transmission with a lamp in its center has the same radiance everywhere.
///
/// The inside of a Lambertian ball spreads reflected light evenly. So the irradiance E of the
/// inside is that of the lamp, Φ/(4πR²), plus rE. The outside has the radiance tE/π.
#[test]
fn lampshades_have_a_closed_form() {
    let mut b = SceneBuilder::new();
    let shade = b.add_material(Material::diffuse_transmission(REFLECTANCE.as_vec3(), TRANSMITTANCE.as_vec3()));
    b.add_shape(Shape::Sphere(Sphere::new(SHADE_CENTER, 1.0)), shade, Vec3::ZERO);
    let lamp = UnscaledDeltaLight::Point { position: SHADE_CENTER };
    b.add_delta_light(lamp, LightStrength::Power(LAMP_POWER.as_vec3()));
    let eye = SHADE_CENTER + dvec3(1.0, 2.0, 3.0);
    let scene = b.build(square_camera(eye, SHADE_CENTER, 20.0, SIZE.0)).unwrap();
    let irradiance = LAMP_POWER / (4.0 * PI) / (1.0 - REFLECTANCE);
    let expected = Estimate {
        mean: vec![TRANSMITTANCE * irradiance / PI],
        variance: vec![DVec3::ZERO],
        bias: vec![DVec3::ZERO],
        dof: f64::INFINITY,
    };
    for method in ALL {
        let ours = Renders::new(method, &scene, EFFORT).over(&Grid::new(SIZE, 12));
        compare(&format!("lampshade, {method:?}"), &ours, &expected, 0.03);
    }
}
