//! Bodies of relative index 1 change no bit of an image.

use crate::support::{assert_mean, render_passes, scene_from_text, test_key};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};

use caustica::scene::Scene;

/// Builds a room with a light, a diffuse wall, a mirror and a ball of glass, with `more` in its
/// middle.
fn room(more: &str) -> Scene {
    scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 1 3.4  direction 0 0 -1  up 0 1 0  angle 50  width 16  height 12 }}
        Background {{ color .1 .2 .3 }}
        Lights {{ RectangleLight {{ corner -.5 1.99 -.5  edge0 1 0 0  edge1 0 0 1  radiance 6 5 4 }} }}
        Materials {{
            Diffuse wall {{ reflectance .7 .6 .5 }}
            Mirror mirror {{ reflectance .9 .9 .9 }}
            Dielectric glass {{ indexOfRefraction 1.5  absorption .1 .2 .3 }}
            Dielectric air {{ indexOfRefraction 1 }}
            Dielectric rough {{ indexOfRefraction 1  roughness .4  priority 3 }}
        }}
        Group {{
            MaterialName wall Rectangle {{ corner -2 0 -2  edge0 0 0 4  edge1 4 0 0 }}
            Rectangle {{ corner -2 0 -2  edge0 4 0 0  edge1 0 2 0 }}
            MaterialName mirror Rectangle {{ corner -2 0 -2  edge0 0 2 0  edge1 0 0 4 }}
            MaterialName glass Sphere {{ center 1 .4 -.5  radius .4 }}
            {more}
        }}"
    ))
}

/// Scene texts with balls and meshes of index 1.
///
/// They are in front of the light, the wall and the mirror, around the camera, and apart from the
/// glass.
const BODIES: [&str; 4] = [
    "MaterialName air Sphere { center 0 1 0  radius .5 }",
    "MaterialName rough Transform { Translate -.9 .7 .2 UniformScale .4 TriangleMesh { obj_file coarse-ball.obj } }",
    "MaterialName air Sphere { center 0 1 3.4  radius .3 }",
    "MaterialName air Sphere { center 0 1 0  radius .5 }
     MaterialName rough Sphere { center 0 1.3 .3  radius .4 }
     MaterialName air Transform { Translate -.9 .7 .2 UniformScale .4 TriangleMesh { obj_file coarse-ball.obj } }",
];

#[test]
fn index_matched_bodies_change_no_bit() {
    let settings = || Settings {
        unaimed_paths: 2000,
        aimed_paths: 2000,
        initial_gather_radius: Some(0.1),
        allows_ray_photon_balance: false,
        camera_paths: CameraPathSettings { samples_per_pixel: Some(2), ..CameraPathSettings::default() },
        ..Settings::default()
    };
    let without = room("");
    for algorithm in Algorithm::ALL {
        let expected = render_passes(&without, algorithm, settings(), 2);
        assert!(expected.iter().any(|p| p.max_element() > 0.2), "{algorithm:?} sees nothing");
        for body in BODIES {
            let seen = render_passes(&room(body), algorithm, settings(), 2);
            assert!(seen == expected, "{algorithm:?} sees {body}");
        }
    }
}

#[test]
fn index_matched_bodies_change_no_photon() {
    let trace = |scene: &Scene| {
        let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
        let tracer = PhotonTracer { scene, source: &source, mask: StoreMask::ALL, max_bounces: 30 };
        let traced = tracer.trace(test_key(1), 1 << 13, &|_| {});
        (traced.deposits.surface_photons, traced.audit, traced.rays)
    };
    let expected = trace(&room(""));
    assert!(expected.0.len() > 5000);
    for body in BODIES {
        assert!(trace(&room(body)) == expected, "{body}");
    }
}

/// A body of index 1 is kept if it has an effect: a bubble in glass, or a boundary of fog.
#[test]
fn bubble_is_not_culled_as_index_matched() {
    let radiances = |more: &str| -> Vec<f64> {
        let scene = scene_from_text(&format!(
            "PerspectiveCamera {{ center 0 0 3  direction 0 0 -1  up 0 1 0  angle .1  width 1  height 1 }}
            Background {{ color 1 1 1 }}
            Materials {{
                Dielectric dark {{ indexOfRefraction 1.5  absorption 1 1 1 }}
                Dielectric air {{ indexOfRefraction 1  priority 1 }}
            }}
            Group {{ MaterialName dark Sphere {{ center 0 0 0  radius 1 }} {more} }}"
        ));
        let settings = Settings {
            camera_paths: CameraPathSettings { samples_per_pixel: Some(1024), ..CameraPathSettings::default() },
            ..Settings::default()
        };
        render_passes(&scene, Algorithm::Path, settings, 16).iter().map(|p| f64::from(p.x)).collect()
    };
    // `r` is the reflectance of an interface at normal incidence. The light on both sides has
    // radiance 1.
    let r: f64 = 0.04;
    // Returns the transmittance and reflectance of a wall with all inner reflections. Absorption
    // leaves the fraction `left` in one crossing.
    let wall = |left: f64| {
        let all = 1.0 / (1.0 - r * r * left * left);
        ((1.0 - r) * (1.0 - r) * left * all, r + (1.0 - r) * (1.0 - r) * r * left * left * all)
    };
    let (through, back) = wall(libm::exp(-2.0));
    // Light between two walls leaves through one of them.
    let (wall_through, wall_back) = wall(libm::exp(-0.2));
    let hollow = wall_back + wall_through * wall_through / (1.0 - wall_back);
    // Rays are up to .0037 off the axis, which shortens their paths by less than .0037².
    assert_mean("a ball", &radiances(""), through + back, 2e-5, 0.005);
    assert_mean("a bubble", &radiances("MaterialName air Sphere { center 0 0 0  radius .8 }"), hollow, 2e-5, 0.005);
}
