//! Integrators against Mitsuba 3 references, by tiles, with the standard errors of both.

use super::compare::{Estimate, Grid, Renders, compare};
use super::methods::{Effort, Method};
use crate::support::{reference_image, scene_from_file};
use glam::{DVec3, Vec3};

/// Relative rounding error of a reference pixel, stored as a 16-bit float.
const ROUNDING: f64 = 1.0 / 4096.0;

/// A reference image with its standard error by pixel.
struct Reference {
    size: (u32, u32),
    mean: Vec<DVec3>,
    /// Squared standard error of each pixel's mean.
    variance: Vec<DVec3>,
    /// False for fireflies of the reference: pixels whose standard error is above half their value.
    kept: Vec<bool>,
}

impl Reference {
    fn read(name: &str) -> Self {
        let (mean, error) = (reference_image(&format!("{name}.exr")), reference_image(&format!("{name}-stderr.exr")));
        let calm = |(v, e): (&Vec3, &Vec3)| e.element_sum() <= 0.5 * v.element_sum();
        let kept: Vec<bool> = mean.pixels().iter().zip(error.pixels()).map(calm).collect();
        let fireflies = kept.iter().filter(|k| !**k).count();
        eprintln!("{name}: {fireflies} of {} pixels are fireflies of the reference", kept.len());
        assert!(fireflies * 100 < kept.len());
        Self {
            size: (mean.width(), mean.height()),
            mean: mean.pixels().iter().map(|v| v.as_dvec3()).collect(),
            variance: error.pixels().iter().map(|e| e.as_dvec3() * e.as_dvec3()).collect(),
            kept,
        }
    }

    fn over(&self, grid: &Grid) -> Estimate {
        let mean = grid.window_sums(self.mean.iter().copied()).iter().map(|(s, n)| s / n.max(1.0)).collect::<Vec<_>>();
        let variance =
            grid.window_sums(self.variance.iter().copied()).iter().map(|(s, n)| s / (n * n).max(1.0)).collect();
        Estimate { bias: mean.iter().map(|m| *m * ROUNDING).collect(), mean, variance, dof: f64::INFINITY }
    }
}

/// Compares each method with the reference `name`: by tiles, over windows, and over the whole
/// image.
///
/// Tiles have 4 × 4 pixels, or 16 × 16 where caustic paths are rare. `max_relative_errors`
/// limits the noise of these three comparisons, as in [`compare`].
fn compare_all(
    name: &str,
    methods: &[(Method, Effort)],
    windows: &[(&str, [usize; 4])],
    max_relative_errors: [f64; 3],
) {
    let reference = Reference::read(name);
    let scene = scene_from_file(&format!("tests/scenes/{name}.txt"), reference.size);
    for (method, effort) in methods {
        let rare = name == "cbox-caustic" && *method == Method::Path;
        let grid = Grid { kept: reference.kept.clone(), ..Grid::new(reference.size, if rare { 16 } else { 4 }) };
        let renders = Renders::new(*method, &scene, *effort);
        let against = |what: &str, grid: &Grid, max_relative_error: f64| {
            compare(
                &format!("{name}, {what}, {method:?}"),
                &renders.over(grid),
                &reference.over(grid),
                max_relative_error,
            );
        };
        against("tiles", &grid, max_relative_errors[0]);
        for (what, [left, right, top, bottom]) in windows {
            against(what, &grid.window(*left..*right, *top..*bottom), max_relative_errors[1]);
        }
        against("whole", &grid.single_window(), max_relative_errors[2]);
    }
}

const BIASED: Effort = Effort { passes: 24, samples: 1, photons: 12_000, caustic: 30_000, radius: 0.025 };

/// Cost of path tracing in scenes with caustics, which it finds only if a path hits the light by
/// chance.
///
/// Where caustics of smooth glass light other walls, one sample in thousands hits the light. A tile
/// of 4 × 4 pixels would have about two hits, too few for its mean and error. So tiles there are 16
/// times as large, with dozens of hits each.
const CHANCE_CAUSTICS: Effort = Effort { passes: 24, samples: 8, ..BIASED };

/// Cost of integrators whose camera paths find most of the light.
const MOSTLY_CAMERA_PATHS: Effort = Effort { samples: 3, ..BIASED };

/// Five integrators match the reference of a room with caustics.
///
/// `analytic::reference` compares `Sppm` in the same room, by finer tiles.
#[test]
#[ignore = "long: five integrators against Mitsuba 3"]
fn integrators_match_caustic_reference() {
    let methods = [
        (Method::Path, CHANCE_CAUSTICS),
        (Method::Hybrid, MOSTLY_CAMERA_PATHS),
        (Method::Ppm, BIASED),
        (Method::PmDirect, BIASED),
        (Method::PmGathering, BIASED),
    ];
    compare_all("cbox-caustic", &methods, &[("caustic", [88, 95, 105, 110])], [0.15, 0.05, 0.01]);
}

#[test]
#[ignore = "long: six integrators against Mitsuba 3"]
fn integrators_match_rough_reference() {
    let methods = [
        (Method::Path, CHANCE_CAUSTICS),
        (Method::Hybrid, MOSTLY_CAMERA_PATHS),
        (Method::Sppm, BIASED),
        (Method::Ppm, BIASED),
        (Method::PmDirect, BIASED),
        (Method::PmGathering, BIASED),
    ];
    compare_all(
        "rough",
        &methods,
        &[("frosted ball", [55, 70, 42, 58]), ("metal ball", [32, 46, 42, 55])],
        [0.15, 0.05, 0.01],
    );
}

/// Integrators match the reference of a room with depth of field, which only camera rays see.
///
/// `Ppm` is left out: it repeats its camera rays in all passes, so its image does not converge. The
/// windows show the ball before the plane of focus, the mirror in it, and the ball behind it.
/// Guided emission sends few photons to the small far ball, so a pass has many photons.
#[test]
#[ignore = "long: five integrators against Mitsuba 3"]
fn integrators_match_lens_reference() {
    let methods = [
        (Method::Path, MOSTLY_CAMERA_PATHS),
        (Method::Hybrid, MOSTLY_CAMERA_PATHS),
        (Method::Sppm, MOSTLY_CAMERA_PATHS),
        (Method::PmDirect, MOSTLY_CAMERA_PATHS),
        (Method::PmGathering, MOSTLY_CAMERA_PATHS),
    ]
    .map(|(method, effort)| (method, Effort { photons: 100_000, ..effort }));
    compare_all(
        "lens",
        &methods,
        &[("near ball", [20, 40, 40, 62]), ("mirror", [40, 60, 28, 50]), ("far ball", [62, 76, 26, 40])],
        [0.15, 0.05, 0.01],
    );
}

/// Integrators match the reference of a room that is filled with fog.
///
/// The windows show the ball, the air below the light, and the back wall. The beam radiance
/// estimate and point estimates find few photons in the fog. They use wider discs, and their noise
/// may be larger.
#[test]
#[ignore = "long: seven integrators against Mitsuba 3"]
fn integrators_match_fog_reference() {
    let methods = [
        (Method::Path, CHANCE_CAUSTICS),
        (Method::Hybrid, MOSTLY_CAMERA_PATHS),
        (Method::Sppm, BIASED),
        (Method::PmDirect, BIASED),
        (Method::PmGathering, BIASED),
    ]
    .map(|(method, effort)| (method, Effort { passes: 12, ..effort }));
    let windows = [("ball", [50, 72, 32, 56]), ("air", [40, 60, 8, 20]), ("back", [35, 50, 25, 40])];
    compare_all("fog", &methods, &windows, [0.15, 0.05, 0.01]);
    let wide = Effort { radius: 0.1, ..BIASED };
    compare_all("fog", &[(Method::SppmBeamRadiance, wide), (Method::SppmPoints, wide)], &[], [0.6, 0.1, 0.05]);
}
