//! Bodies that share a face: a liquid in its glass.
//!
//! The faces coincide, are an ulp apart, or overlap.

use crate::support::{assert_mean, render_passes, scene_from_text, test_key};
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::light::EnvironmentLight;
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::scene::{Body, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Plane, Rectangle, Shape};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

const GLASS: f64 = 1.5;
const LIQUID: f64 = 1.33;

/// Half the width of rectangles and triangles \[length].
const WIDTH: f64 = 50.0;

/// Half angle of the beam \[rad].
const CONE: f64 = 0.01;

#[derive(Clone, Copy, Debug)]
enum Faces {
    Planes,
    Rectangles,
    Triangles,
}

/// Adds a horizontal face at height `y`, with its outer side up or down.
fn add_face(b: &mut SceneBuilder, faces: Faces, y: f64, up: bool, material: u32) {
    let (x, z, corner) = (DVec3::X * (2.0 * WIDTH), DVec3::Z * (2.0 * WIDTH), DVec3::new(-WIDTH, y, -WIDTH));
    let (e0, e1) = if up { (z, x) } else { (x, z) };
    match faces {
        Faces::Planes => {
            b.add_plane(Plane::new(DVec3::Y * y, if up { DVec3::Y } else { DVec3::NEG_Y }), material, Vec3::ZERO)
        }
        Faces::Rectangles => b.add_shape(Shape::Rectangle(Rectangle::new(corner, e0, e1)), material, Vec3::ZERO),
        Faces::Triangles => {
            let corners = [corner, corner + e0, corner + e0 + e1, corner + e1];
            b.add_mesh(&corners, &[], &[[0, 1, 2], [0, 2, 3]], material, Vec3::ZERO)
        }
    };
}

/// Contact of a liquid with its glass.
#[derive(Clone, Copy, Debug)]
enum Contact {
    /// The inner faces of the glass are at y = ±½. Those of the liquid are this far inside of them.
    Apart(f64),
    /// One block of glass that a liquid of higher priority overlaps.
    Priority,
}

/// Adds a layer of liquid between two glass walls. If `liquid_first` is true, the liquid's faces
/// are added before those of the glass.
fn add_layers(b: &mut SceneBuilder, faces: Faces, contact: Contact, liquid_first: bool) {
    let glass = b.add_material(Material::dielectric(GLASS as f32, Vec3::ZERO));
    let priority = u8::from(matches!(contact, Contact::Priority));
    let liquid = b.add_material(Material::smooth_boundary(Body { priority, ..Body::new(LIQUID as f32) }));
    let gap = if let Contact::Apart(gap) = contact { gap } else { 0.0 };
    let fill = |b: &mut SceneBuilder| {
        add_face(b, faces, 0.5 - gap, true, liquid);
        add_face(b, faces, gap - 0.5, false, liquid);
    };
    if liquid_first {
        fill(b);
    }
    add_face(b, faces, 1.0, true, glass);
    add_face(b, faces, -1.0, false, glass);
    if let Contact::Apart(_) = contact {
        add_face(b, faces, 0.5, false, glass);
        add_face(b, faces, -0.5, true, glass);
    }
    if !liquid_first {
        fill(b);
    }
}

/// Returns the reflectance between the indices `a` and `b`, for light whose angle in air has the
/// sine `s`.
fn reflectance(a: f64, b: f64, s: f64) -> f64 {
    let [ca, cb] = [a, b].map(|n| (1.0 - s * s / (n * n)).sqrt());
    let (rs, rp) = ((a * ca - b * cb) / (a * ca + b * cb), (b * ca - a * cb) / (b * ca + a * cb));
    0.5 * (rs * rs + rp * rp)
}

/// Returns the transmittance of parallel interfaces between `indices`, with all inner reflections:
/// 1/(1 + Σ R/(1−R)).
///
/// Proof: one more interface of reflectance R turns T into T(1−R)/(1 − R·R'), where R' = 1 − T. The
/// reciprocal of this is 1/T + 1/(1−R) − 1.
fn stack_transmittance(indices: &[f64], s: f64) -> f64 {
    let r = indices.windows(2).map(|n| reflectance(n[0], n[1], s));
    1.0 / (1.0 + r.map(|r| r / (1.0 - r)).sum::<f64>())
}

/// Returns the mean of [`stack_transmittance`] over the beam around `angle`, from 32 rings of 32
/// directions each.
fn mean_stack_transmittance(indices: &[f64], angle: f64) -> f64 {
    let ring = |i: u32| {
        // Rings of equal solid angle.
        let tilt = CONE * ((f64::from(i) + 0.5) / 32.0).sqrt();
        let around = |j: u32| {
            let phi = TAU * (f64::from(j) + 0.5) / 32.0;
            let cos = libm::cos(angle) * libm::cos(tilt) + libm::sin(angle) * libm::sin(tilt) * libm::cos(phi);
            stack_transmittance(indices, (1.0 - cos * cos).sqrt())
        };
        (0..32).map(around).sum::<f64>() / 32.0
    };
    (0..32).map(ring).sum::<f64>() / 32.0
}

fn camera() -> Camera {
    Camera::perspective(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 0.5, 1, 1).unwrap()
}

/// Builds the layers between a black ceiling and a floor that stores photons. The light arrives at
/// `angle`.
fn lit_layers_scene(faces: Faces, contact: Contact, liquid_first: bool, angle: f64) -> Scene {
    let mut b = SceneBuilder::new();
    add_layers(&mut b, faces, contact, liquid_first);
    let black = b.add_material(Material::black());
    let floor = b.add_material(Material::diffuse(Vec3::ZERO));
    // The floor is as far from the center as the ceiling, so that the scene's center stays at 0.
    add_face(&mut b, Faces::Rectangles, 2.0, false, black);
    add_face(&mut b, Faces::Rectangles, -2.0, true, floor);
    let axis = DVec3::new(libm::sin(angle), -libm::cos(angle), 0.0);
    let source = UnscaledDeltaLight::Spot { position: DVec3::Y * 1.5 - DVec3::X * 3.0, axis, inner: CONE, outer: CONE };
    b.add_delta_light(source, LightStrength::Power(Vec3::ONE));
    b.build(camera()).unwrap()
}

/// Returns the fraction of the flux that reaches the floor, in independent passes.
fn transmitted_fractions(scene: &Scene) -> Vec<f64> {
    let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
    let tracer = PhotonTracer { scene, source: &source, mask: StoreMask::CAUSTIC, max_bounces: 1000 };
    let part = |i| {
        let traced = tracer.trace(test_key(40).child_key(i), 1 << 11, &|_| {});
        traced.audit.stopped[0] / traced.audit.emitted[0]
    };
    (0..16).map(part).collect()
}

/// Faces of glass and liquid that coincide, or are an ulp apart on either side, act as one
/// interface.
///
/// This holds for any order of hits. It also holds if a liquid of higher priority overlaps the
/// glass. A gap of .01 acts as a film of air.
#[test]
#[ignore = "long: many samples of a hard case"]
fn liquid_touches_its_glass() {
    let wet = [1.0, GLASS, LIQUID, GLASS, 1.0];
    let film = [1.0, GLASS, 1.0, LIQUID, 1.0, GLASS, 1.0];
    let ulp = f64::from(f32::EPSILON) * 0.5;
    let cases = [
        (Contact::Apart(0.0), &wet[..]),
        (Contact::Apart(ulp), &wet),
        (Contact::Apart(-ulp), &wet),
        (Contact::Apart(-0.01), &wet),
        (Contact::Priority, &wet),
        (Contact::Apart(0.01), &film),
    ];
    // At 80°, a film of air reflects half of the light that glass and liquid alone transmit.
    assert!(stack_transmittance(&wet, libm::sin(1.4)) > 1.4 * stack_transmittance(&film, libm::sin(1.4)));
    let all: Vec<_> = cases
        .into_iter()
        .flat_map(|case| [Faces::Planes, Faces::Rectangles, Faces::Triangles].map(|faces| (case, faces)))
        .flat_map(|(case, faces)| [false, true].map(|first| (case, faces, first)))
        .flat_map(|(case, faces, first)| [0.2, 1.4].map(|angle| (case, faces, first, angle)))
        .collect();
    all.par_iter().for_each(|((contact, indices), faces, first, angle)| {
        let what = format!("{contact:?}, {faces:?}, liquid first: {first}, at {angle}");
        // The quadrature, and indices in f32, are accurate to 10⁻⁵.
        assert_mean(
            &what,
            &transmitted_fractions(&lit_layers_scene(*faces, *contact, *first, *angle)),
            mean_stack_transmittance(indices, *angle),
            1e-5,
            0.02,
        );
    });
}

/// Two blocks of the same glass act as one block if they share a face.
///
/// This also holds if they overlap and one face of each coincides.
#[test]
fn touching_blocks_of_one_glass_merge() {
    let blocks = [[(1.0, 0.0), (0.0, -1.0)], [(1.0, -1.0), (1.0, 0.0)], [(1.0, -1.0), (0.0, -1.0)]];
    let all = [Faces::Planes, Faces::Rectangles, Faces::Triangles].into_iter().flat_map(|f| blocks.map(|b| (f, b)));
    for (faces, blocks) in all {
        let mut b = SceneBuilder::new();
        let glass = b.add_material(Material::dielectric(GLASS as f32, Vec3::ZERO));
        for (top, bottom) in blocks {
            add_face(&mut b, faces, top, true, glass);
            add_face(&mut b, faces, bottom, false, glass);
        }
        let black = b.add_material(Material::black());
        let floor = b.add_material(Material::diffuse(Vec3::ZERO));
        add_face(&mut b, Faces::Rectangles, 2.0, false, black);
        add_face(&mut b, Faces::Rectangles, -2.0, true, floor);
        let axis = DVec3::new(libm::sin(1.4), -libm::cos(1.4), 0.0);
        let source =
            UnscaledDeltaLight::Spot { position: DVec3::Y * 1.5 - DVec3::X * 3.0, axis, inner: CONE, outer: CONE };
        b.add_delta_light(source, LightStrength::Power(Vec3::ONE));
        let expected = mean_stack_transmittance(&[1.0, GLASS, 1.0], 1.4);
        assert_mean(
            &format!("{blocks:?}, {faces:?}"),
            &transmitted_fractions(&b.build(camera()).unwrap()),
            expected,
            1e-5,
            0.02,
        );
    }
}

/// Rays of a camera in the liquid start in the liquid.
///
/// Under a sky of radiance 1, their radiance is then n² of the liquid, through any layers.
#[test]
#[ignore = "long: many samples of a hard case"]
fn camera_in_liquid_starts_in_liquid() {
    for faces in [Faces::Planes, Faces::Rectangles, Faces::Triangles] {
        for (contact, first) in [(Contact::Apart(0.0), false), (Contact::Apart(0.0), true), (Contact::Priority, false)]
        {
            let mut b = SceneBuilder::new();
            add_layers(&mut b, faces, contact, first);
            b.set_environment(EnvironmentLight::with_constant_radiance(Vec3::ONE).unwrap());
            // A field of view of 40° is within Snell's window, so all light leaves in the end.
            let up = Camera::perspective(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.7, 8, 8).unwrap();
            let scene = b.build(up).unwrap();
            let camera_paths =
                CameraPathSettings { samples_per_pixel: Some(4), max_bounces: 1000, ..CameraPathSettings::default() };
            let samples: Vec<f64> = (0..16)
                .map(|seed| {
                    let camera_paths = CameraPathSettings { seed, ..camera_paths.clone() };
                    let image =
                        render_passes(&scene, Algorithm::Path, Settings { camera_paths, ..Settings::default() }, 1);
                    image.iter().map(|p| f64::from(p.x)).sum::<f64>() / 64.0
                })
                .collect();
            // The tolerance covers rounding of squared indices and reflectances in f32, over some
            // ten interfaces.
            assert_mean(
                &format!("{contact:?}, {faces:?}, {first}"),
                &samples,
                LIQUID * LIQUID,
                20.0 * 6e-8 * 1.8,
                0.01,
            );
        }
    }
}

/// A vessel of revolution about the y axis holds its liquid.
///
/// The inner side of the vessel is the outer side of the liquid, reversed. The vessel transmits the
/// same light as a reference whose liquid reaches into the wall.
#[test]
fn round_vessel_holds_its_liquid() {
    let curve = |r: f64, backwards: bool| {
        let mut points = [(0.0, -r), (r, -r), (r, 0.0), (r, r), (0.0, r)];
        if backwards {
            points.reverse();
        }
        let points: String = points.iter().map(|(x, y)| format!("[ {x} {y} 0 ] ")).collect();
        format!("RevSurface {{ profile BezierCurve {{ controls {points} }} }}")
    };
    let transmitted = |priority: u32, objects: &str| {
        let scene = scene_from_text(&format!(
            "PerspectiveCamera {{ center 0 9 0  direction 0 -1 0  up 0 0 1  angle 9  width 1  height 1 }}
            Lights {{ SpotLight {{ position 0 3 .3  direction 0 -1 0  angle 20  power 1 1 1 }} }}
            Materials {{
                Dielectric glass {{ indexOfRefraction {GLASS} }}
                Dielectric liquid {{ indexOfRefraction {LIQUID}  absorption 1 1 1  priority {priority} }}
                Diffuse floor {{ reflectance 0 0 0 }}
            }}
            Group {{ {objects} MaterialName floor Rectangle {{ corner -9 -2 -9  edge0 0 0 18  edge1 18 0 0 }} }}"
        ));
        super::shared::transmitted_fractions(&scene)
    };
    let (outer, inner, liquid) = (curve(1.0, false), curve(0.8, true), curve(0.8, false));
    let whole = transmitted(1, &format!("MaterialName glass {outer} MaterialName liquid {liquid}"));
    let (mean, error) = crate::support::mean_and_error(&whole);
    for shared in [
        format!("MaterialName glass {outer} {inner} MaterialName liquid {liquid}"),
        format!("MaterialName liquid {liquid} MaterialName glass {inner} {outer}"),
    ] {
        // Both means are random. Five standard errors of the reference are added, which gives one
        // false alarm in a million.
        assert_mean(&shared, &transmitted(0, &shared), mean, 5.0 * error, 0.03);
    }
}
