//! Chi-square test of sampled directions against a pdf.

use super::test_key;
use crate::math::Frame;
use crate::sampling::Dimension;
use glam::{Vec2, Vec3};

/// P-value of Pearson's chi-square test of `counts` against `expected`. There is one degree of
/// freedom fewer than cells.
///
/// Cells with fewer than ten expected samples are pooled, because the chi-square distribution does
/// not hold for them.
pub fn chi_square_p_value(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut chi2, mut cells, mut pool) = (0.0, 0, (0.0, 0.0));
    let mut add = |count: f64, mean: f64| {
        chi2 += (count - mean) * (count - mean) / mean;
        cells += 1;
    };
    for (count, mean) in counts.iter().zip(expected) {
        if *mean < 10.0 {
            pool = (pool.0 + count, pool.1 + mean);
        } else {
            add(*count, *mean);
        }
    }
    if pool.1 >= 10.0 {
        add(pool.0, pool.1);
    } else {
        // The pool is too small for a chi-square term. Its count must stay within five standard
        // deviations plus 5.
        assert!(pool.0 <= pool.1 + 5.0 * pool.1.sqrt() + 5.0, "{} draws where {} were expected", pool.0, pool.1);
    }
    // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance 2/(9ν).
    let nu = f64::from(cells - 1);
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    0.5 * libm::erfc(z / std::f64::consts::SQRT_2)
}

/// Significance level for each of `tests` tests, such that their total false alarm rate is 1 %
/// (Šidák).
pub fn sidak_significance_level(tests: usize) -> f64 {
    1.0 - libm::pow(0.99, 1.0 / tests as f64)
}

/// Grid of cells of equal solid angle that divide a cone of directions.
pub struct DirectionCells {
    frame: Frame,
    one_minus_cos: f64,
}

const RINGS: usize = 16;
const SECTORS: usize = 24;
/// Number of steps of the midpoint rule along each side of a cell.
const STEPS: usize = 32;
/// Number of finer steps that divide each side of a step of the midpoint rule where the pdf changes
/// within the step.
///
/// The edge of a light may run parallel to the grid. The integral over a cell then has an error of
/// at most 1/(2 · 32 · 16) = 0.1 %. In a cell of 5000 samples this is 5 samples, 1/14 of the
/// standard deviation.
const REFINEMENT: usize = 16;
/// Upper bound of the error of a pdf's integral over the cone. An edge of the light may pass
/// through half of the cells, each with an error of 0.1 %.
pub const INTEGRAL_ERROR: f64 = 5e-4;
const DRAWS: u64 = 300_000;

impl DirectionCells {
    /// Divides the cone around `axis` with half angle `half_angle` \[radians] into cells.
    pub fn new(axis: Vec3, half_angle: f64) -> Self {
        Self { frame: Frame::from_normal(axis.normalize()), one_minus_cos: 1.0 - libm::cos(half_angle) }
    }

    fn cell_of_direction(&self, w: Vec3) -> Option<usize> {
        let v = self.frame.to_local(w);
        // 1 − cos = sin²/(1 + cos) keeps its digits in narrow cones.
        let drop = if v.z > 0.0 { v.truncate().length_squared() / (1.0 + v.z) } else { 1.0 - v.z };
        let ring = f64::from(drop) / self.one_minus_cos * RINGS as f64;
        let sector = (libm::atan2(f64::from(v.y), f64::from(v.x)) / std::f64::consts::TAU + 0.5) * SECTORS as f64;
        (ring < RINGS as f64).then(|| ring as usize * SECTORS + (sector as usize).min(SECTORS - 1))
    }

    /// Unit direction at the angle θ from the axis and the angle φ around it.
    ///
    /// `ring` in \[0, 1] is 1 − cos θ, relative to its value at the rim of the cone. `sector` in
    /// \[0, 1] is φ, relative to a full turn.
    fn direction(&self, ring: f64, sector: f64) -> Vec3 {
        let drop = self.one_minus_cos * ring;
        let (sin, cos) = libm::sincos((sector - 0.5) * std::f64::consts::TAU);
        let r = (drop * (2.0 - drop)).max(0.0).sqrt();
        self.frame.to_world(Vec3::new((r * cos) as f32, (r * sin) as f32, (1.0 - drop) as f32))
    }

    /// Integrals of the pdf `density` \[1/sr] over all cells.
    fn integrate_over_cells(&self, density: &dyn Fn(Vec3) -> f64) -> Vec<f64> {
        let (rings, sectors) = ((RINGS * STEPS) as f64, (SECTORS * STEPS) as f64);
        let at = |i: f64, j: f64| density(self.direction(i / rings, j / sectors));
        let solid_angle = std::f64::consts::TAU * self.one_minus_cos / (rings * sectors);
        let mut cells = vec![0.0; RINGS * SECTORS];
        for ring in 0..RINGS * STEPS {
            for sector in 0..SECTORS * STEPS {
                let (i, j) = (ring as f64, sector as f64);
                let middle = at(i + 0.5, j + 0.5);
                let corners = [(i, j), (i + 1.0, j), (i, j + 1.0), (i + 1.0, j + 1.0)];
                let alike = |other: f64| (other - middle).abs() <= 0.05 * other.max(middle);
                let mean = if corners.iter().all(|(i, j)| alike(at(*i, *j))) {
                    middle
                } else {
                    let fine = |k: usize| (k as f64 + 0.5) / REFINEMENT as f64;
                    let all =
                        (0..REFINEMENT * REFINEMENT).map(|k| at(i + fine(k / REFINEMENT), j + fine(k % REFINEMENT)));
                    all.sum::<f64>() / (REFINEMENT * REFINEMENT) as f64
                };
                cells[ring / STEPS * SECTORS + sector / STEPS] += mean * solid_angle;
            }
        }
        cells
    }

    /// Samples directions by `draw`, and compares their counts per cell with the pdf `density` by a
    /// chi-square test.
    ///
    /// All directions outside of the cone, and draws that return `None`, form one more cell.
    /// Returns the p-value and the integral of `density` over the cone.
    pub fn test_samples_against_pdf(
        &self,
        draw: &dyn Fn(Vec2) -> Option<Vec3>,
        density: &dyn Fn(Vec3) -> f64,
    ) -> (f64, f64) {
        let cells = self.integrate_over_cells(density);
        let total = cells.iter().sum::<f64>();
        // If the pdf integrates to 1 within the integration error, no samples are expected outside
        // the cone.
        let all = if (total - 1.0).abs() < INTEGRAL_ERROR { total } else { 1.0 };
        let mut expected: Vec<f64> = cells.iter().map(|c| c / all * DRAWS as f64).collect();
        expected.push(((1.0 - total / all) * DRAWS as f64).max(0.0));
        let mut counts = vec![0.0; expected.len()];
        for i in 0..DRAWS {
            let w = draw(test_key(i).uniform_2d(Dimension::LightPosition));
            counts[w.and_then(|w| self.cell_of_direction(w)).unwrap_or(RINGS * SECTORS)] += 1.0;
        }
        (chi_square_p_value(&counts, &expected), total)
    }
}

#[test]
fn chi_square_detects_a_wrong_pdf() {
    let cells = DirectionCells::new(Vec3::Y, std::f64::consts::PI);
    let draw = |u| Some(crate::math::warp::square_to_uniform_sphere(u));
    let uniform = 0.25 / std::f64::consts::PI;
    let (p, total) = cells.test_samples_against_pdf(&draw, &|_| uniform);
    assert!(p > sidak_significance_level(1) && (total - 1.0).abs() < 1e-9, "{p} {total}");
    // The tested pdf is 5 % larger in the upper hemisphere than in the lower one. This adds 300,000
    // · 0.025² = 190 to chi-square, whose standard deviation is √(2 · 384) = 28.
    let (p, _) = cells.test_samples_against_pdf(&draw, &|w| uniform * if w.y > 0.0 { 1.025 } else { 0.975 });
    assert!(p < sidak_significance_level(1), "{p}");
}
