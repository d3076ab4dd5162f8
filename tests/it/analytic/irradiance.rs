//! Irradiance below every kind of light: by photons, with the exact bias of their kernel, and by
//! shadow rays.

use crate::support::*;
use caustica::photon::{Kernel, PhotonAttributes, PhotonMap, PhotonSearchBuffers, StoreMask};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Disc, Plane, Rectangle, Shape, Sphere};
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

const DIRECT: StoreMask = StoreMask::DIRECT;
const ALBEDO: f64 = 0.8;

/// A light above the plane y = 0.
struct Lamp {
    name: &'static str,
    add: fn(&mut SceneBuilder),
    /// Irradiance at (x, z).
    irradiance: fn(DVec2) -> f64,
}

const RADIANCE: f64 = 7.0;
const INTENSITY: f64 = 5.0;
const HEIGHT: f64 = 1.2;
const DISC: f64 = 0.5;
const BALL: f64 = 0.4;
const HALF: DVec2 = DVec2::new(0.4, 0.25);

fn add_emitter(b: &mut SceneBuilder, shape: Shape) {
    let black = b.add_material(Material::black());
    b.add_shape(shape, black, grey(RADIANCE));
}

/// Returns the irradiance at the point `p` of the floor by Lambert's formula: (L/2) Σ γᵢ Γᵢ·n over
/// the edges.
///
/// L is the rectangle's radiance, and n the normal of the floor. γᵢ is the angle of edge i seen
/// from the point, and Γᵢ the unit normal of the plane through edge and point.
fn rectangle_irradiance(p: DVec2) -> f64 {
    let corner = |x: f64, z: f64| dvec3(x * HALF.x - p.x, HEIGHT, z * HALF.y - p.y).normalize();
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let edges = (0..4).map(|i| (corners[i], corners[(i + 1) % 4]));
    let sum: f64 = edges.map(|(a, b)| libm::acos(a.dot(b)) * a.cross(b).normalize().y).sum();
    0.5 * RADIANCE * sum.abs()
}

const LAMPS: [Lamp; 6] = [
    Lamp {
        name: "point",
        add: |b| {
            let place = UnscaledDeltaLight::Point { position: dvec3(0.0, HEIGHT, 0.0) };
            b.add_delta_light(place, LightStrength::Physical(grey(INTENSITY)));
        },
        irradiance: |p| {
            let d2 = HEIGHT * HEIGHT + p.length_squared();
            INTENSITY * HEIGHT / (d2 * d2.sqrt())
        },
    },
    Lamp {
        name: "spot",
        add: |b| {
            let (position, axis) = (dvec3(0.0, HEIGHT, 0.0), -DVec3::Y);
            b.add_delta_light(
                UnscaledDeltaLight::Spot { position, axis, inner: 0.3, outer: 0.8 },
                LightStrength::Physical(grey(INTENSITY)),
            );
        },
        irradiance: |p| {
            let d2 = HEIGHT * HEIGHT + p.length_squared();
            let cos = HEIGHT / d2.sqrt();
            let x = ((cos - libm::cos(0.8)) / (libm::cos(0.3) - libm::cos(0.8))).clamp(0.0, 1.0);
            INTENSITY * x * x * (3.0 - 2.0 * x) * cos / d2
        },
    },
    Lamp {
        name: "disc",
        add: |b| add_emitter(b, Shape::Disc(Disc::circular_disc(dvec3(0.0, HEIGHT, 0.0), -DVec3::Y, DISC))),
        irradiance: |p| {
            let (h2, a2, r2) = (HEIGHT * HEIGHT, p.length_squared(), DISC * DISC);
            let s = h2 + a2 + r2;
            0.5 * PI * RADIANCE * (1.0 - (s - 2.0 * r2) / (s * s - 4.0 * r2 * a2).sqrt())
        },
    },
    Lamp {
        name: "ball",
        add: |b| add_emitter(b, Shape::Sphere(Sphere::new(dvec3(0.0, HEIGHT, 0.0), BALL))),
        irradiance: |p| {
            let d2 = HEIGHT * HEIGHT + p.length_squared();
            PI * RADIANCE * BALL * BALL / d2 * HEIGHT / d2.sqrt()
        },
    },
    Lamp {
        name: "rectangle",
        add: |b| {
            let corner = dvec3(-HALF.x, HEIGHT, -HALF.y);
            let (x, z) = (DVec3::X * 2.0 * HALF.x, DVec3::Z * 2.0 * HALF.y);
            add_emitter(b, Shape::Rectangle(Rectangle::new(corner, x, z)));
        },
        irradiance: rectangle_irradiance,
    },
    Lamp {
        name: "triangles",
        add: |b| {
            let black = b.add_material(Material::black());
            let corner = |x: f64, z: f64| dvec3(x * HALF.x, HEIGHT, z * HALF.y);
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            // The triangles have unequal areas, so that the test fails if triangles are not chosen
            // in proportion to area.
            let middle = corner(0.7, 0.2);
            let all = [corners[0], corners[1], corners[2], corners[3], middle];
            b.add_mesh(&all, &[], &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], black, grey(RADIANCE));
        },
        irradiance: rectangle_irradiance,
    },
];

fn floor_under_lamp(lamp: &Lamp) -> SceneBuilder {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(grey(ALBEDO)));
    b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), white, grey(0.0));
    (lamp.add)(&mut b);
    b
}

fn floor_photon_maps(scene: &Scene) -> Vec<PhotonMap> {
    trace_photon_passes(scene, DIRECT, 0, PASSES, 1 << 17)
        .into_iter()
        .map(|t| PhotonMap::build(t.deposits.surface_photons))
        .collect()
}

/// The expected value of a density estimate is the kernel's weighted mean of irradiance, at any
/// radius and position.
#[test]
#[ignore = "long: statistics against a closed form"]
fn estimates_have_exact_kernel_bias() {
    for lamp in &LAMPS {
        let scene = photon_only_scene(floor_under_lamp(lamp));
        let maps = floor_photon_maps(&scene);
        for (at, radius) in [(DVec2::ZERO, 0.6), (DVec2::ZERO, 0.15), (DVec2::new(0.5, 0.3), 0.3)] {
            for kernel in KERNELS {
                let expected = kernel_weighted_mean(kernel, radius, |d| (lamp.irradiance)(at + d));
                let probe =
                    EstimatePoint { scene: &scene, at: dvec3(at.x, 0.0, at.y), normal: DVec3::Y, radius, kernel };
                assert_estimates(lamp.name, &probe, &maps, expected, 1e-5, 0.018);
            }
        }
    }
}

/// An estimate with the box kernel below a point light has a closed form.
///
/// It is 2I/r²·(1 − h/√(h² + r²)) for radius r and height h. The radius is so large that the
/// estimate is far from the true irradiance.
#[test]
fn wide_box_kernel_has_closed_form_bias() {
    let scene = photon_only_scene(floor_under_lamp(&LAMPS[0]));
    let maps = floor_photon_maps(&scene);
    for radius in [0.1, 0.4, 1.6] {
        let expected = 2.0 * INTENSITY / (radius * radius) * (1.0 - HEIGHT / libm::hypot(HEIGHT, radius));
        let probe = EstimatePoint { scene: &scene, at: DVec3::ZERO, normal: DVec3::Y, radius, kernel: Kernel::Box };
        assert_estimates("below a point", &probe, &maps, expected, 0.0, 8e-3);
    }
}

/// Photons store their incident direction.
///
/// So the cosine-weighted flux in a disc below a point light is πIh²(1/h² − 1/(h² + r²)), for
/// radius r and height h.
#[test]
fn photons_store_their_incident_direction() {
    let scene = photon_only_scene(floor_under_lamp(&LAMPS[0]));
    let radius = 0.8;
    let expected = INTENSITY * HEIGHT * HEIGHT * (1.0 / (HEIGHT * HEIGHT) - 1.0 / (HEIGHT * HEIGHT + radius * radius))
        / (radius * radius);
    let origin = (-scene.origin()).as_vec3();
    let one = |map: &PhotonMap| {
        let brdf = |flux: &PhotonAttributes| Vec3::splat(flux.incident_direction().y);
        let mut scratch = PhotonSearchBuffers::default();
        f64::from(
            map.estimate_radiance(origin, Vec3::Y, fixed_bandwidth(radius), Kernel::Box, &mut scratch, brdf).radiance.x,
        )
    };
    let samples: Vec<f64> = floor_photon_maps(&scene).iter().map(one).collect();
    // Directions are stored to 10⁻⁴ rad. The sum of 11,000 photons has a relative rounding error of
    // at most 11,000 · 2⁻²⁴ = 7·10⁻⁴.
    assert_mean("cosine-weighted flux", &samples, expected, expected * (8e-4 + 2.0 * STORED_COLOR_ROUNDING), 4e-3);
}

/// Shadow rays give the radiance L = ρE/π of a floor with albedo ρ and irradiance E.
///
/// The view is 0.02 wide. Irradiance is linear over the view, up to a second difference below
/// (0.02/h)² of the irradiance.
#[test]
fn direct_light_matches_irradiance_of_each_light() {
    for lamp in &LAMPS {
        for at in [DVec2::ZERO, DVec2::new(0.5, 0.3)] {
            let target = dvec3(at.x, 0.0, at.y);
            let eye = target + dvec3(2.0, 1.0, 0.3);
            let scene = floor_under_lamp(lamp).build(square_camera(eye, target, 0.2, 16)).unwrap();
            let samples = red_channels(&mean_radiance_per_pass(&scene, fixed_radius_settings(0, 0, 0.1), PASSES));
            let expected = ALBEDO / PI * (lamp.irradiance)(at);
            assert_mean(&format!("{} seen at {at}", lamp.name), &samples, expected, expected * 3e-4, 2e-3);
        }
    }
}

/// The photons in a disc below a point light carry the flux 2πI(1 − h/√(h² + r²)), for radius r and
/// height h.
///
/// All photons together carry the whole flux of the light.
#[test]
fn disc_flux_below_point_light_matches_solid_angle() {
    let scene = photon_only_scene(floor_under_lamp(&LAMPS[0]));
    let passes = trace_photon_passes(&scene, DIRECT, 0, PASSES, 1 << 16);
    for radius in [0.3, 1.0, 5.0] {
        let inside = |p: DVec3| p.x * p.x + p.z * p.z < radius * radius;
        let samples: Vec<f64> =
            passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, inside).x).collect();
        let expected = TAU * INTENSITY * (1.0 - HEIGHT / libm::hypot(HEIGHT, radius));
        assert_mean(&format!("flux within {radius}"), &samples, expected, expected * 2.0 * STORED_COLOR_ROUNDING, 3e-3);
    }
}
