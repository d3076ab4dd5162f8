//! Truth 29: near the edge of what is lit, a disc estimates the part of it that lies inside.

use crate::support::*;
use caustica::photon::{Kernel, PhotonMap, StoreMask};
use caustica::scene::{LightStrength, Material, SceneBuilder, SourceKind};
use caustica::shape::{Rectangle, Shape};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const IRRADIANCE: f64 = 3.0;
const RADIUS: f64 = 0.2;

/// Maps of a square 0 < x, z < 1 under parallel light from above; a `shade` covers x < 0.5 from a height above.
fn maps(shade: bool) -> (caustica::scene::Scene, Vec<PhotonMap>) {
    let mut b = SceneBuilder::new();
    let white = b.material(Material::diffuse(grey(0.8)));
    let black = b.material(Material::black());
    b.shape(Shape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::Z, DVec3::X)), white, grey(0.0));
    if shade {
        let corner = vec3(-0.5, 0.3, -0.5);
        b.shape(Shape::Rectangle(Rectangle::new(corner, DVec3::Z * 2.0, DVec3::X)), black, grey(0.0));
    }
    b.source(SourceKind::Directional { direction: -DVec3::Y }, LightStrength::Physical(grey(IRRADIANCE)));
    let scene = unseen(b);
    let passes = trace(&scene, StoreMask::ALL, 0, PASSES, 1 << 16);
    let maps = passes.into_iter().map(|t| PhotonMap::build(t.photons)).collect();
    (scene, maps)
}

fn compare(what: &str, shade: bool, x: f64, z: f64, kernel: Kernel, part: f64) {
    let (scene, maps) = maps(shade);
    let probe = Probe { scene: &scene, at: vec3(x, 0.0, z), normal: DVec3::Y, radius: RADIUS, kernel };
    agree_estimates(what, &probe, &maps, IRRADIANCE * part, 0.0, 6e-3);
}

/// The share of a disc at `t` radii from a straight edge.
fn straight(t: f64) -> f64 {
    (PI - libm::acos(t) + t * (1.0 - t * t).sqrt()) / PI
}

#[test]
fn disc_over_edge_has_closed_form_bias() {
    for t in [0.0, 0.3, 0.7, 1.0] {
        compare("edge", false, t * RADIUS, 0.5, Kernel::Box, straight(t));
    }
    compare("shadow line", true, 0.5 + 0.3 * RADIUS, 0.5, Kernel::Box, straight(0.3));
    compare("inside the shadow", true, 0.5 - 0.3 * RADIUS, 0.5, Kernel::Box, 1.0 - straight(0.3));
}

/// By symmetry, for every kernel: all in the middle, half at an edge, a quarter in a corner.
#[test]
fn edges_and_corners_halve_and_quarter_estimates() {
    for kernel in KERNELS {
        compare("middle", false, 0.5, 0.5, kernel, 1.0);
        compare("edge", false, 0.5, 1.0, kernel, 0.5);
        compare("corner", false, 0.0, 1.0, kernel, 0.25);
    }
}

/// Other kernels near an edge by quadrature over the disc; the jump costs at most a cell, 1/400 of the radius of one in 96 of
/// the turns, far below the noise.
#[test]
fn kernels_over_edge_have_closed_form_bias() {
    for kernel in [Kernel::Cone, Kernel::Epanechnikov] {
        let part = blurred(kernel, RADIUS, |d: DVec2| f64::from(u8::from(d.x > -0.4 * RADIUS)));
        compare("edge", false, 0.4 * RADIUS, 0.5, kernel, part);
    }
}

/// Photons count on their own side of their own surface: nothing leaks through a sheet, down a step of more than a quarter of
/// the radius, or around a corner, though all photons lie within the disc's ball.
#[test]
fn estimates_do_not_leak_between_surfaces() {
    let mut b = SceneBuilder::new();
    let white = b.material(Material::diffuse(grey(0.8)));
    let sheet = |y: f64| Shape::Rectangle(Rectangle::new(vec3(0.0, y, 0.0), DVec3::Z, DVec3::X));
    b.shape(sheet(0.0), white, grey(0.0));
    b.shape(sheet(-0.06), white, grey(0.0));
    let wall = Rectangle::new(DVec3::ZERO, DVec3::Y, DVec3::Z);
    b.shape(Shape::Rectangle(wall), white, grey(0.0));
    b.source(SourceKind::Directional { direction: -DVec3::Y }, LightStrength::Physical(grey(IRRADIANCE)));
    let scene = unseen(b);
    let photons = trace(&scene, StoreMask::ALL, 0, 1, 1 << 14).remove(0).photons;
    let map = PhotonMap::build(photons);
    let at = |p, n| irradiance(&scene, &map, p, n, fixed(RADIUS), Kernel::Box).x;
    let middle = vec3(0.5, 0.0, 0.5);
    assert!(at(middle, DVec3::Y) > 0.5 * IRRADIANCE);
    assert_eq!(at(middle, -DVec3::Y), 0.0, "through the sheet");
    assert_eq!(at(middle - DVec3::Y * 0.06, DVec3::Y), 0.0, "down the step");
    assert_eq!(at(vec3(0.0, 0.02, 0.5), DVec3::X), 0.0, "around the corner");
}
