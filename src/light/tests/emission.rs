//! Tests of photon emission, in all directions and aimed at spheres.

use super::chi_square::{DirectionCells, INTEGRAL_ERROR, sidak_significance_level};
use super::environment::random_sky_light;
use super::intensity_maps::{test_goniometric_light, test_projector_light};
use super::*;
use glam::Vec2;

fn lights_of_all_kinds() -> Vec<Light> {
    vec![
        Light::Point(PointLight { position: Vec3::new(0.3, 3.0, 0.1), intensity: Rgb::splat(2.0) }),
        Light::Spot(SpotLight {
            position: Vec3::new(0.3, 3.0, 0.1),
            axis: Vec3::NEG_Y,
            inner_one_minus_cos: 0.05,
            outer_one_minus_cos: 0.2,
            peak_intensity: Rgb::splat(2.0),
        }),
        Light::Projector(test_projector_light()),
        Light::Goniometric(test_goniometric_light()),
        Light::Directional(DirectionalLight {
            direction: Vec3::new(0.1, -1.0, 0.2).normalize(),
            irradiance: Rgb::splat(2.0),
        }),
        area_light(Shape::Disc(Disc::new(point_on_y_axis(2.0), DVec3::X, DVec3::Z)), 2.0),
        area_light(Shape::Sphere(SphereShape::new(point_on_y_axis(2.0), 0.5)), 2.0),
        Light::Environment(random_sky_light(0.7).into()),
    ]
}

/// Index of the light's variant in the enum [`Light`].
///
/// A new variant does not compile here, which reminds its author to add it to
/// [`lights_of_all_kinds`].
fn index_of_light_variant(light: &Light) -> usize {
    match light {
        Light::Point(_) => 0,
        Light::Spot(_) => 1,
        Light::Projector(_) => 2,
        Light::Goniometric(_) => 3,
        Light::Directional(_) => 4,
        Light::Area(_) => 5,
        Light::Environment(_) => 6,
    }
}

#[test]
fn every_light_variant_is_tested() {
    let mut is_tested = [false; 7];
    lights_of_all_kinds().iter().for_each(|light| is_tested[index_of_light_variant(light)] = true);
    assert_eq!(is_tested, [true; 7]);
}

const DOMAIN: BoundingSphere = BoundingSphere { center: Vec3::new(0.1, 0.2, 0.0), radius: 4.0 };

fn ray_hits_sphere(ball: &BoundingSphere, e: &EmissionSample) -> bool {
    let to = ball.center - e.ray.origin;
    to.dot(e.ray.direction) > 0.0 && to.cross(e.ray.direction).length() < ball.radius
}

#[test]
fn mean_emitted_flux_equals_power() {
    for light in lights_of_all_kinds() {
        let emitted = estimate_mean_and_variance(200_000, |k| {
            let (a, b) = (k.uniform_2d(Dimension::LightPosition), k.uniform_2d(Dimension::LightDirection));
            light.sample_le(DOMAIN, a, b).map_or(0.0, |e| f64::from(e.weight.x))
        });
        assert_within_five_sigma(emitted, f64::from(light.power(DOMAIN).x));
    }
}

/// Emission aimed at spheres carries the same flux to each sphere as emission in all directions,
/// even where spheres overlap.
#[test]
fn aimed_emission_is_unbiased() {
    let balls = [
        BoundingSphere { center: Vec3::new(0.5, 0.0, 0.0), radius: 0.4 },
        BoundingSphere { center: Vec3::new(0.8, 0.2, 0.0), radius: 0.3 },
        BoundingSphere { center: Vec3::new(-1.5, 0.0, 0.5), radius: 0.2 },
    ];
    let aim = PhotonAim::new(balls);
    for light in lights_of_all_kinds() {
        for ball in &balls {
            let moments = |emit: &dyn Fn(Vec2, Vec2) -> Option<EmissionSample>| {
                estimate_mean_and_variance(300_000, |k| {
                    let (a, b) = (k.uniform_2d(Dimension::LightPosition), k.uniform_2d(Dimension::LightDirection));
                    emit(a, b).filter(|e| ray_hits_sphere(ball, e)).map_or(0.0, |e| f64::from(e.weight.x))
                })
            };
            let (plain, aimed) = (
                moments(&|a, b| light.sample_le(DOMAIN, a, b)),
                moments(&|a, b| light.sample_le_towards(&aim, DOMAIN, a, b)),
            );
            let sigma = (plain.1 + aimed.1).sqrt();
            assert!((plain.0 - aimed.0).abs() < 5.0 * sigma, "{light:?} {ball:?}: {plain:?} {aimed:?}");
            assert!(aimed.1 < plain.1, "aiming must pay: {light:?}");
        }
    }
}

#[test]
fn a_light_inside_an_aim_sphere_emits_in_all_directions() {
    let aim = PhotonAim::new([BoundingSphere { center: Vec3::ZERO, radius: 1.0 }]);
    let light = Light::Point(PointLight { position: Vec3::new(0.2, 0.0, 0.0), intensity: Rgb::ONE });
    let flux = estimate_mean_and_variance(1000, |k| {
        let u = k.uniform_2d(Dimension::LightDirection);
        light.sample_le_towards(&aim, DOMAIN, u, u).map_or(0.0, |e| f64::from(e.weight.x))
    });
    assert_within_five_sigma(flux, 4.0 * std::f64::consts::PI);
}

#[test]
fn merged_aim_spheres_lose_no_flux() {
    let balls: Vec<BoundingSphere> = (0..500)
        .map(|i| {
            let center = warp::square_to_uniform_sphere(test_key(i).uniform_2d(Dimension::LightTarget)) * 3.0;
            BoundingSphere { center, radius: 0.05 }
        })
        .collect();
    let aim = PhotonAim::new(balls.iter().copied());
    let light = Light::Point(PointLight { position: Vec3::new(0.0, 10.0, 0.0), intensity: Rgb::ONE });
    let count = |emit: &dyn Fn(Vec2) -> Option<EmissionSample>| {
        estimate_mean_and_variance(100_000, |k| {
            let e = emit(k.uniform_2d(Dimension::LightDirection));
            e.map_or(0.0, |e| f64::from(e.weight.x) * balls.iter().filter(|b| ray_hits_sphere(b, &e)).count() as f64)
        })
    };
    let zero = Vec2::ZERO;
    let (plain, aimed) =
        (count(&|u| light.sample_le(DOMAIN, zero, u)), count(&|u| light.sample_le_towards(&aim, DOMAIN, zero, u)));
    assert!((plain.0 - aimed.0).abs() < 5.0 * (plain.1 + aimed.1).sqrt());
}

/// Pdf of emitted directions \[1/sr], averaged over the positions on the light.
fn emission_direction_pdf(light: &Light, w: Vec3) -> f64 {
    let uniform = 0.25 / std::f64::consts::PI;
    match light {
        Light::Point(_) => uniform,
        Light::Spot(spot) => {
            f64::from(u8::from(1.0 - w.dot(spot.axis) < spot.outer_one_minus_cos)) * 2.0 * uniform
                / f64::from(spot.outer_one_minus_cos)
        }
        Light::Projector(projector) => f64::from(projector.pdf(w)),
        Light::Goniometric(light) => f64::from(light.pdf(w)),
        Light::Directional(_) => 0.0,
        Light::Area(AreaLight { surface: LightSurface::Shape(Shape::Disc(_)), .. }) => {
            f64::from((-w.y).max(0.0)) * 4.0 * uniform
        }
        Light::Area(_) => uniform,
        Light::Environment(environment) => f64::from(environment.pdf(-w)),
    }
}

#[test]
fn emitted_directions_follow_their_pdf() {
    let lights: Vec<Light> =
        lights_of_all_kinds().into_iter().filter(|light| !matches!(light, Light::Directional(_))).collect();
    for light in &lights {
        // On a sphere, the direction also depends on the position, which is sampled by a hash of u.
        let position = |u: Vec2| test_key(u64::from(u.x.to_bits()) << 32 | u64::from(u.y.to_bits()));
        let draw = |u: Vec2| light.sample_le(DOMAIN, position(u).uniform_2d(Dimension::LightTarget), u);
        let cells = DirectionCells::new(Vec3::NEG_Y, std::f64::consts::PI);
        let (chance, total) = cells
            .test_samples_against_pdf(&|u| draw(u).map(|e| e.ray.direction), &|w| emission_direction_pdf(light, w));
        assert!(chance > sidak_significance_level(lights.len()), "{light:?}: {chance}");
        assert!((total - 1.0).abs() < INTEGRAL_ERROR, "{light:?}: {total}");
    }
}
