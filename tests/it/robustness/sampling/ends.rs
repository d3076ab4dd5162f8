//! Extreme random numbers, 0 and the largest below 1, in every function that maps them to positions
//! and directions.

use super::{ENDS, corners};
use crate::support::scene_from_text;
use caustica::camera::{Camera, Filter, FilterKind, Lens};
use caustica::color::Wavelength;
use caustica::light::{Light, PhotonAim};
use caustica::math::{BoundingSphere, warp};
use caustica::medium::PhaseFunction;
use caustica::scene::Scene;
use glam::{DVec3, Vec2, Vec3};

#[track_caller]
fn assert_unit_vector(v: Vec3, what: &dyn Fn() -> String) {
    assert!(v.is_finite() && (v.length() - 1.0).abs() < 3e-6, "{}: {v}", what());
}

/// Every warp gives unit vectors at extreme random numbers and parameters.
///
/// No pdf is 0 at a sample, unless the sample lies in the horizon.
#[test]
fn warps_are_valid_at_extreme_samples() {
    for u in corners() {
        let what = || format!("{u}");
        assert!(warp::square_to_uniform_disc(u).length() <= 1.0 + f32::EPSILON, "{u}");
        assert_unit_vector(warp::square_to_cosine_hemisphere(u), &what);
        assert_unit_vector(warp::square_to_uniform_sphere(u), &what);
        for narrow in [0.0, 1e-38, 1e-10, 1.0, 2.0] {
            let v = warp::square_to_uniform_cone(u, narrow);
            assert_unit_vector(v, &what);
            assert!(1.0 - v.z <= narrow + f32::EPSILON, "{u} {narrow}");
        }
        for n in [0.0, 1.0, 1e4, 1e9, 1e30] {
            let v = warp::square_to_power_cosine(u, n);
            assert_unit_vector(v, &what);
            assert!(v.z > 0.0 && !warp::power_cosine_pdf(v.z, n).is_nan(), "{u} {n}");
        }
        let b = warp::square_to_uniform_triangle(u);
        assert!(b.min_element() >= 0.0 && b.x + b.y <= 1.0, "{u} {b}");
    }
}

#[test]
fn other_samplers_are_valid_at_extreme_samples() {
    let near = 1.0 - f32::EPSILON / 2.0;
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::Rayleigh,
        PhaseFunction::HenyeyGreenstein(0.0),
        PhaseFunction::HenyeyGreenstein(near),
        PhaseFunction::HenyeyGreenstein(-near),
    ] {
        for u in corners() {
            for along in [Vec3::Z, -Vec3::Z, Vec3::new(0.6, 0.0, -0.8)] {
                let (next, pdf) = phase.sample(along, u);
                assert_unit_vector(next, &|| format!("{phase:?} {u}"));
                assert!(pdf > 0.0 && pdf.is_finite(), "{phase:?} {u}: {pdf}");
            }
        }
    }
    for u in ENDS {
        let w = Wavelength::sample(u);
        assert!((Wavelength::SHORTEST_NM..=Wavelength::LONGEST_NM).contains(&w.nanometres()) && w.pdf() > 0.0);
        assert!(w.weight().is_finite() && Wavelength::from_byte_code(w.byte_code()).is_some());
    }
    for (kind, radius) in [
        (FilterKind::Box, 0.5),
        (FilterKind::Tent, 1.0),
        (FilterKind::Gaussian, 1.5),
        (FilterKind::BlackmanHarris, 1.5),
        (FilterKind::Mitchell, 2.0),
    ] {
        for u in corners() {
            let s = Filter::new(kind).sample(u);
            assert!(s.offset.abs().max_element() <= radius && s.weight.is_finite(), "{kind:?} {u}: {s:?}");
        }
    }
    for blades in [0, 3, 5, 64] {
        let lens = Lens { radius: 0.5, focus_distance: 2.0, blades };
        let eye = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 8, 6).unwrap().with_lens(lens);
        for u in corners() {
            let ray = eye.generate_ray(Vec2::new(4.0, 3.0), Some(u));
            assert_unit_vector(ray.direction, &|| format!("{blades} {u}"));
            assert!(ray.origin.length() <= 0.5 * (1.0 + 1e-6), "{blades} {u}: {}", ray.origin);
        }
    }
    let all_around = Camera::panorama(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 8, 4).unwrap();
    for u in corners() {
        assert_unit_vector(all_around.generate_ray(u * Vec2::new(8.0, 4.0), None).direction, &|| format!("{u}"));
    }
}

/// Builds a scene with one light of each kind.
fn scene_of_all_lights() -> Scene {
    scene_from_text(
        "PerspectiveCamera { center 0 0 9  direction 0 0 -1  up 0 1 0  angle 40  width 1  height 1 }
        Lights {
            PointLight { position 1 0 0  power 1 1 1 }
            SpotLight { position 0 2 0  direction 0 -1 0  angle 30  penumbra 5  power 1 1 1 }
            DirectionalLight { direction 0 -1 1  irradiance 1 1 1 }
            SphereLight { center 2 2 2  radius .5  radiance 1 1 1 }
            DiscLight { center -1 1 0  normal 0 1 1  radius .5  radiance 1 1 1 }
            RectangleLight { corner 0 3 0  edge0 1 0 0  edge1 0 0 1  radiance 1 1 1 }
            EnvironmentLight { radiance 1 1 1 }
        }
        Materials { Diffuse lamp { reflectance 0 0 0  emission 1 2 3 } }
        Group { MaterialName lamp
            Transform { Translate -3 0 0 Scale 1 .2 .5 Sphere { center 0 0 0  radius 1 } }
            Transform { Translate 3 0 0 TriangleMesh { obj_file coarse-ball.obj } }
            RevSurface { profile BezierCurve { controls [ 0 -1 0 ] [ 1 -1 0 ] [ 1 1 0 ] [ 0 1 0 ] } }
            BezierPatch { degreeU 1  degreeV 1  controls [ 0 -3 0 ] [ 1 -3 0 ] [ 0 -3 1 ] [ 1 -4 1 ] }
        }",
    )
}

/// Every light can be sampled from near, far, inside and on its surface, and emits in all
/// directions and towards targets.
///
/// One target contains the light. Flux, radiance and pdfs are finite, and no pdf is 0.
#[test]
fn lights_are_valid_at_extreme_samples() {
    let scene = scene_of_all_lights();
    assert_eq!(scene.lights().len(), 11);
    let ball = |center: Vec3, radius: f32| BoundingSphere { center, radius };
    for light in scene.lights() {
        let place = light.center_or_surface_point().unwrap_or(Vec3::ZERO);
        let start = light.representative_point().unwrap_or(place);
        let points = [
            Vec3::ZERO,
            place,
            start,
            place + Vec3::X * 1e-6,
            place + Vec3::Y * 1e7,
            Vec3::splat(1e12),
            Vec3::new(0.3, -5.0, 7.0),
        ];
        for (p, u) in points.into_iter().flat_map(|p| corners().map(move |u| (p, u))) {
            let Some(s) = light.sample_li(p, u) else { continue };
            assert_unit_vector(s.wi, &|| format!("{light:?} from {p}, {u}"));
            assert!(s.weight.is_finite() && s.weight.min_element() >= 0.0, "{light:?} from {p}, {u}: {s:?}");
            assert!(s.pdf.is_none_or(|pdf| pdf > 0.0 && !pdf.is_nan()), "{light:?} from {p}, {u}: {s:?}");
        }
        let all_sides = [
            vec![ball(place, 3.0)],
            vec![ball(place, 3.0), ball(Vec3::splat(5.0), 1e-3)],
            vec![
                ball(Vec3::new(0.0, -9.0, 0.0), 1.0),
                ball(Vec3::new(0.0, -9.0, 0.5), 1.0),
                ball(Vec3::splat(1e9), 1e-9),
            ],
        ];
        for balls in all_sides {
            let aim = PhotonAim::new(balls);
            for (position, direction) in corners().flat_map(|p| corners().map(move |d| (p, d))) {
                let emissions: [Option<caustica::light::EmissionSample>; 2] = [
                    light.sample_le(scene.photon_domain(), position, direction),
                    light.sample_le_towards(&aim, scene.photon_domain(), position, direction),
                ];
                for e in emissions.into_iter().flatten() {
                    let what = || format!("{light:?} at {position}, {direction}: {e:?}");
                    assert_unit_vector(e.ray.direction, &what);
                    assert!(
                        e.weight.is_finite() && e.weight.min_element() >= 0.0 && e.ray.origin.is_finite(),
                        "{}",
                        what()
                    );
                }
            }
        }
    }
}

/// Emission towards a ball that encloses the light follows the cosine, and no direction is in the
/// horizon.
#[test]
fn aimed_emission_has_pdf_at_horizon() {
    let aim = PhotonAim::new([BoundingSphere { center: Vec3::ZERO, radius: 1.0 }]);
    for u in corners() {
        for n in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
            if let Some((w, pdf)) = aim.sample_direction(Vec3::X * 0.1, Some(n), u) {
                assert_unit_vector(w, &|| format!("{u}"));
                assert!(pdf > 0.0 && (1.0 / pdf).is_finite(), "{u}: {pdf}");
            }
        }
    }
    assert!(matches!(scene_of_all_lights().lights()[0], Light::Point { .. }));
}
