//! Gallery scenes, rendered by every integrator that can simulate them.

use super::compare::{Grid, Renders, compare_renders};
use super::methods::{Effort, Method};
use crate::support::scene_from_file;

/// Compares `methods` with `Hybrid` in the scene `name` of the gallery.
///
/// `radius` is the gather radius of the first pass, in the scene's units. `Path` is in `methods`
/// only for scenes with large lights.
fn check_methods_agree(name: &str, radius: f64, methods: &[Method]) {
    // Light through a goblet makes fireflies, so more pixels are needed for the same accuracy.
    let size = if name == "goblet" { (80, 60) } else { (64, 48) };
    let scene = scene_from_file(&format!("scenes/{name}.txt"), size);
    let grid = Grid::new(size, size.0 as usize / 8);
    // Bright streaks narrower than a pixel dominate the noise here.
    let samples = if name == "projector" { 10 } else { 2 };
    let effort = Effort { passes: 12, samples, photons: 20_000, caustic: 20_000, radius };
    let hybrid = Renders::new(Method::Hybrid, &scene, effort);
    for method in methods {
        let samples = if *method == Method::Path { 8 * samples } else { samples };
        let renders = Renders::new(*method, &scene, Effort { samples, ..effort });
        compare_renders(name, &renders, &hybrid, &grid, (0.2, 0.04));
    }
}

const PHOTONS: [Method; 3] = [Method::Sppm, Method::PmDirect, Method::PmGathering];

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_glass_ball() {
    check_methods_agree(
        "glass-ball",
        0.04,
        &[Method::Path, Method::Sppm, Method::Ppm, Method::PmDirect, Method::PmGathering],
    );
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_matte() {
    check_methods_agree(
        "matte",
        0.06,
        &[Method::Path, Method::Sppm, Method::Ppm, Method::PmDirect, Method::PmGathering],
    );
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_many_lights() {
    check_methods_agree("many-lights", 0.05, &PHOTONS);
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_goblet() {
    check_methods_agree("goblet", 0.06, &PHOTONS);
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_projector() {
    check_methods_agree("projector", 0.06, &PHOTONS);
}

#[test]
#[ignore = "long: many samples by several integrators"]
fn integrators_agree_on_ball_lens() {
    check_methods_agree("ball-lens", 0.06, &PHOTONS);
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_gem() {
    check_methods_agree("gem", 0.08, &PHOTONS);
}

#[test]
fn integrators_agree_on_ring() {
    check_methods_agree("ring", 0.06, &PHOTONS);
}

#[test]
#[ignore = "long: t-tests between integrators"]
fn integrators_agree_on_pool() {
    check_methods_agree("pool", 0.04, &PHOTONS);
}
