//! Boundary bias: a density estimate near the edge of a lit region is the fraction of its disc that
//! lies inside.

use crate::support::*;
use caustica::photon::{Kernel, PhotonMap, StoreMask};
use caustica::scene::{LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const IRRADIANCE: f64 = 3.0;
const RADIUS: f64 = 0.2;

/// Returns the scene and the photon maps of the unit square under collimated light from above.
///
/// If `shade` is true, an occluder covers x < 0.5.
fn floor_photon_maps(shade: bool) -> (caustica::scene::Scene, Vec<PhotonMap>) {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(grey(0.8)));
    let black = b.add_material(Material::black());
    b.add_shape(Shape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::Z, DVec3::X)), white, grey(0.0));
    if shade {
        let corner = dvec3(-0.5, 0.3, -0.5);
        b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::Z * 2.0, DVec3::X)), black, grey(0.0));
    }
    b.add_delta_light(
        UnscaledDeltaLight::Directional { direction: -DVec3::Y },
        LightStrength::Physical(grey(IRRADIANCE)),
    );
    let scene = photon_only_scene(b);
    let passes = trace_photon_passes(&scene, StoreMask::ALL, 0, PASSES, 1 << 16);
    let maps = passes.into_iter().map(|t| PhotonMap::build(t.deposits.surface_photons)).collect();
    (scene, maps)
}

fn compare_with_kernel_mean(what: &str, shade: bool, x: f64, z: f64, kernel: Kernel, part: f64) {
    let (scene, maps) = floor_photon_maps(shade);
    let probe = EstimatePoint { scene: &scene, at: dvec3(x, 0.0, z), normal: DVec3::Y, radius: RADIUS, kernel };
    assert_estimates(what, &probe, &maps, IRRADIANCE * part, 0.0, 6e-3);
}

/// Returns the lit fraction of a disc whose center is inside a straight edge, at a distance of `t`
/// radii.
fn straight_edge_density(t: f64) -> f64 {
    (PI - libm::acos(t) + t * (1.0 - t * t).sqrt()) / PI
}

#[test]
fn disc_over_edge_has_closed_form_bias() {
    for t in [0.0, 0.3, 0.7, 1.0] {
        compare_with_kernel_mean("edge", false, t * RADIUS, 0.5, Kernel::Box, straight_edge_density(t));
    }
    compare_with_kernel_mean("shadow line", true, 0.5 + 0.3 * RADIUS, 0.5, Kernel::Box, straight_edge_density(0.3));
    compare_with_kernel_mean(
        "inside the shadow",
        true,
        0.5 - 0.3 * RADIUS,
        0.5,
        Kernel::Box,
        1.0 - straight_edge_density(0.3),
    );
}

/// An estimate with any kernel gives all light in the middle, half at an edge, and a quarter in a
/// corner, by symmetry.
#[test]
#[ignore = "long: statistics against a closed form"]
fn edges_and_corners_halve_and_quarter_estimates() {
    for kernel in KERNELS {
        compare_with_kernel_mean("middle", false, 0.5, 0.5, kernel, 1.0);
        compare_with_kernel_mean("edge", false, 0.5, 1.0, kernel, 0.5);
        compare_with_kernel_mean("corner", false, 0.0, 1.0, kernel, 0.25);
    }
}

/// Estimates with other kernels near an edge agree with quadrature over the disc.
///
/// The quadrature misplaces the jump at the edge by at most one cell: 1/400 of the radius in one of
/// 96 directions. That is far below the noise.
#[test]
fn kernels_over_edge_have_closed_form_bias() {
    for kernel in [Kernel::Cone, Kernel::Epanechnikov] {
        let part = kernel_weighted_mean(kernel, RADIUS, |d: DVec2| f64::from(u8::from(d.x > -0.4 * RADIUS)));
        compare_with_kernel_mean("edge", false, 0.4 * RADIUS, 0.5, kernel, part);
    }
}

/// An estimate includes only photons that landed on its own surface, on the same side.
///
/// No photon leaks through a sheet, down a step of more than a quarter of the radius, or around a
/// corner. All these photons lie within the disc's bounding ball.
#[test]
fn estimates_do_not_leak_between_surfaces() {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(grey(0.8)));
    let sheet = |y: f64| Shape::Rectangle(Rectangle::new(dvec3(0.0, y, 0.0), DVec3::Z, DVec3::X));
    b.add_shape(sheet(0.0), white, grey(0.0));
    b.add_shape(sheet(-0.06), white, grey(0.0));
    let wall = Rectangle::new(DVec3::ZERO, DVec3::Y, DVec3::Z);
    b.add_shape(Shape::Rectangle(wall), white, grey(0.0));
    b.add_delta_light(
        UnscaledDeltaLight::Directional { direction: -DVec3::Y },
        LightStrength::Physical(grey(IRRADIANCE)),
    );
    let scene = photon_only_scene(b);
    let photons = trace_photon_passes(&scene, StoreMask::ALL, 0, 1, 1 << 14).remove(0).deposits.surface_photons;
    let map = PhotonMap::build(photons);
    let at = |p, n| estimated_irradiance(&scene, &map, p, n, fixed_bandwidth(RADIUS), Kernel::Box).x;
    let middle = dvec3(0.5, 0.0, 0.5);
    assert!(at(middle, DVec3::Y) > 0.5 * IRRADIANCE);
    assert_eq!(at(middle, -DVec3::Y), 0.0, "through the sheet");
    assert_eq!(at(middle - DVec3::Y * 0.06, DVec3::Y), 0.0, "down the step");
    assert_eq!(at(dvec3(0.0, 0.02, 0.5), DVec3::X), 0.0, "around the corner");
}
