//! Shading normals let no light through the back of a surface.

use crate::support::{render_passes, scene_from_text, test_key};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::math::{Ray, warp};
use caustica::photon::{Photon, PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::Dimension;
use caustica::scene::{Effects, RayCone, Scene};

/// Returns scene text of every opaque material. `relief` perturbs their normals.
fn materials(relief: &str) -> String {
    format!(
        "Textures {{ Noise lumps {{ frequency 9  octaves 3 }}  Checker down {{ color0 1 .5 0  color1 1 .5 0 }}  Checker aside {{ color0 1 .5 .5  color1 1 .5 .5 }} }}
        Materials {{
            Diffuse matt {{ reflectance 1 1 1  {relief} }}
            Phong gloss {{ diffuseColor .3 .3 .3  specularColor 9 9 9  shininess 30  {relief} }}
            Mirror mirror {{ reflectance 1 1 1  {relief} }}
            Conductor metal {{ metal silver  roughness .1  {relief} }}
            Conductor rough {{ metal silver  roughness .8  {relief} }}
        }}"
    )
}

const KINDS: [&str; 5] = ["matt", "gloss", "mirror", "metal", "rough"];

fn settings() -> Settings {
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(2), ..CameraPathSettings::default() };
    Settings {
        unaimed_paths: 2000,
        aimed_paths: 2000,
        initial_gather_radius: Some(0.2),
        allows_ray_photon_balance: false,
        camera_paths,
        ..Settings::default()
    }
}

/// Checks that every pixel of `inside` is 0 in all integrators with shadows.
fn assert_dark(inside: &Scene, what: &str) {
    for algorithm in Algorithm::ALL.into_iter().filter(|a| *a != Algorithm::Raycast) {
        let image = render_passes(inside, algorithm, settings(), 2);
        let lit: Vec<_> = image.iter().enumerate().filter(|(_, p)| p.max_element() != 0.0).collect();
        assert!(lit.is_empty(), "{what}: {algorithm:?} lets light in at {lit:?}");
    }
}

/// A closed ball of flat faces with smooth shading normals is black inside, under a sky and a
/// light.
#[test]
#[ignore = "long: many samples of a hard case"]
fn coarse_ball_is_dark_inside() {
    for kind in KINDS {
        for relief in ["", "bump lumps  bumpHeight .5"] {
            let ball = |center: &str| {
                scene_from_text(&format!(
                    "PerspectiveCamera {{ center {center}  direction 0 0 -1  up 0 1 0  angle 90  width 12  height 12 }}
                    Lights {{
                        EnvironmentLight {{ radiance 1 1 1 }}
                        PointLight {{ position 2 2 2  power 99 99 99 }}
                        SphereLight {{ center -2 1 2  radius .5  power 99 99 99 }}
                    }}
                    {}
                    Group {{ MaterialName {kind} TriangleMesh {{ obj_file coarse-ball.obj }} }}",
                    materials(relief)
                ))
            };
            let inside = ball("0 0 .5");
            assert_dark(&inside, &format!("{kind} {relief}"));
            let lit = render_passes(&ball("0 0 3"), Algorithm::Path, settings(), 1);
            assert!(lit.iter().all(|p| p.max_element() > 0.0), "{kind} is lit from outside");
            let source = PhotonSource::emitting_in_all_directions(&inside).unwrap();
            let tracer = PhotonTracer { scene: &inside, source: &source, mask: StoreMask::ALL, max_bounces: 20 };
            let traced = tracer.trace(test_key(70), 1 << 14, &|_| {});
            // A photon stores the side of the surface on which it landed. The normal of that side
            // points away from the ball's center.
            let outwards = |p: &Photon| p.attributes.normal().dot(p.position + inside.origin().as_vec3()) > 0.0;
            assert!(traced.deposits.surface_photons.iter().all(outwards), "{kind}: photons inside");
        }
    }
}

/// A wall with a steep bump map leaks no light: everything behind it is black.
///
/// Unlimited, the map would tilt normals below the horizon. The renderer limits the tilt.
#[test]
#[ignore = "long: many samples of a hard case"]
fn bumps_below_horizon_leak_no_light() {
    for relief in ["bump lumps  bumpHeight 1000", "bump lumps  bumpHeight -1e9", "normalMap down", "normalMap aside"] {
        for kind in KINDS {
            let walls = scene_from_text(&format!(
                "PerspectiveCamera {{ center 0 0 2  direction 0 0 -1  up 0 1 0  angle 60  width 12  height 12 }}
                Background {{ color 0 0 0 }}
                Lights {{ PointLight {{ position 0 0 -2  power 99 99 99 }}
                    DiscLight {{ center 1 0 -2  normal -.3 0 1  radius .5  power 99 99 99 }} }}
                {}
                Group {{ MaterialName {kind} Rectangle {{ corner -20 -20 0  edge0 40 0 0  edge1 0 40 0 }} }}",
                materials(relief)
            ));
            assert_dark(&walls, &format!("{kind} {relief}"));
            let mut least = 1.0f32;
            for i in 0..2000u64 {
                let direction =
                    warp::square_to_uniform_sphere(test_key(71).child_key(i).uniform_2d(Dimension::LightDirection));
                let ray = Ray::new(-direction * 2.0, direction);
                let Some(hit) = walls.intersect(&ray) else { continue };
                let point =
                    walls.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::ALL), || 0.5).point;
                assert!((point.ns.length() - 1.0).abs() < 1e-6);
                least = least.min(point.ns.dot(point.ng));
            }
            // Normals tilt at most to a cosine of 0.05, which is 87.1°. The steepest of these maps
            // reach this limit.
            assert!((0.0499..0.2).contains(&least), "{kind} {relief}: {least}");
        }
    }
}
