//! Scenes with difficult caustics. Their lights are so large that path tracing also finds the light
//! by chance, for comparison.
//!
//! One scene is lit only through glass. One shows a caustic through water and in a mirror. One has
//! caustics of rough surfaces.

use super::compare::{Grid, Renders, compare_renders};
use super::methods::{Effort, Method};
use crate::support::scene_from_file;

const SIZE: (u32, u32) = (64, 48);

fn check_methods_agree(name: &str) {
    let scene = scene_from_file(&format!("tests/scenes/{name}.txt"), SIZE);
    let grid = Grid::new(SIZE, 8);
    let effort = Effort { passes: 10, samples: 4, photons: 20_000, caustic: 60_000, radius: 0.03 };
    let path = Renders::new(Method::Path, &scene, Effort { samples: 36, ..effort });
    for method in [Method::Hybrid, Method::Sppm, Method::PmDirect, Method::PmGathering] {
        let renders = Renders::new(method, &scene, effort);
        compare_renders(name, &renders, &path, &grid, (0.1, 0.015));
    }
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn light_in_bulb_reaches_the_room() {
    check_methods_agree("bulb");
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn caustics_appear_through_water_and_mirrors() {
    check_methods_agree("caustic-seen");
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn rough_surfaces_cast_caustics() {
    check_methods_agree("frosted");
}
