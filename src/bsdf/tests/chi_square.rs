//! Pearson's chi-square test of samplers against their pdfs, on a grid that resolves the lobes.

use super::*;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Number of rings of a [`PolarDirectionGrid`], from its pole to the opposite pole.
const RINGS: usize = 40;

/// Number of sectors of each ring of a [`PolarDirectionGrid`].
const SECTORS: usize = 16;

/// Number of integration points along each side of a grid cell.
///
/// The error of the midpoint rule is below the noise of a sample count, even in cells that are
/// partly below the horizon.
const POINTS: usize = 24;

const SAMPLES: u64 = 100_000;

/// A grid over the sphere of directions: rings around a pole, which are divided into sectors.
///
/// Rings are about `width` radians wide near the pole, and wider far from it.
struct PolarDirectionGrid {
    frame: [DVec3; 3],
    width: f64,
}

impl PolarDirectionGrid {
    fn new(pole: Vec3, width: f64) -> Self {
        let n = pole.as_dvec3().normalize();
        let s = n.any_orthonormal_vector();
        Self { frame: [s, n.cross(s), n], width }
    }

    /// Index of the cell that contains the direction `v`.
    fn cell_of_direction(&self, v: Vec3) -> usize {
        let v = v.as_dvec3();
        let [x, y, z] = self.frame.map(|axis| axis.dot(v));
        let theta = libm::atan2(libm::hypot(x, y), z);
        let ring = theta * (PI + self.width) / (PI * (theta + self.width)) * RINGS as f64;
        let sector = (libm::atan2(y, x) / TAU + 0.5) * SECTORS as f64;
        (ring as usize).min(RINGS - 1) * SECTORS + (sector as usize).min(SECTORS - 1)
    }

    /// Integrates `density` over the solid angle of each cell by the midpoint rule.
    fn integrate_over_cells(&self, density: impl Fn(Vec3) -> f32) -> Vec<f64> {
        let mut cells = vec![0.0; RINGS * SECTORS];
        let (rings, sectors) = (RINGS * POINTS, SECTORS * POINTS);
        let turns: Vec<_> =
            (0..sectors).map(|j| libm::sincos(TAU * ((j as f64 + 0.5) / sectors as f64 - 0.5))).collect();
        for i in 0..rings {
            let x = (i as f64 + 0.5) / rings as f64;
            let rest = PI + self.width - PI * x;
            let theta = x * PI * self.width / rest;
            let slope = PI * self.width * (PI + self.width) / (rest * rest);
            let (sin, cos) = libm::sincos(theta);
            let area = sin * slope * TAU / (rings * sectors) as f64;
            for (j, (sin_phi, cos_phi)) in turns.iter().enumerate() {
                let [s, t, n] = self.frame;
                let v = s * (sin * cos_phi) + t * (sin * sin_phi) + n * cos;
                cells[i / POINTS * SECTORS + j / POINTS] += f64::from(density(v.as_vec3())) * area;
            }
        }
        cells
    }
}

/// A BSDF with a direction `wo` and normals, and the grids on which its samples are counted.
struct ChiSquareCase {
    bsdf: Bsdf,
    /// Refractive index of the far side, relative to the side of `wo`.
    ///
    /// The index determines the direction of specular refraction, which is the pole of the second
    /// grid.
    eta: f32,
    /// Width of the rings of both grids near their poles \[radians].
    width: f64,
    wo: Vec3,
    ns: Vec3,
    ng: Vec3,
}

fn chi_square_test_cases() -> Vec<ChiSquareCase> {
    let n = Vec3::new(0.3, -0.5, 0.6).normalize();
    let frame = Frame::from_normal(n);
    let mut cases = Vec::new();
    let rgb = Vec3::new(0.7, 0.2, 0.5);
    let mut materials = vec![
        (Bsdf::Diffuse(rgb), 1.0, 1.0),
        (Bsdf::Phong(Phong::new(rgb, Vec3::ONE, 20.0)), 1.0, 0.5),
        (Bsdf::Phong(Phong::new(Vec3::ONE, Vec3::ONE, 0.0)), 1.0, 1.0),
    ];
    materials.extend(diffuse_sheets().into_iter().map(|bsdf| (bsdf, 1.0, 1.0)));
    materials.extend(clear_coated_bsdfs().into_iter().step_by(2).map(|(bsdf, width)| (bsdf, 1.0, width)));
    materials.extend(coated_bsdfs().into_iter().map(|bsdf| (bsdf, 1.0, 1.0)));
    materials.extend(coats().into_iter().skip(1).zip([2e-3, 0.4]).map(|(bsdf, width)| (bsdf, 1.0, width)));
    let (eta, k) = metal_refractive_index("gold").unwrap();
    for alpha in [MIN_ROUGH_ALPHA * 1.001, 0.05, 0.2, 1.0] {
        let width = 2.0 * f64::from(alpha);
        materials.push((Bsdf::Conductor(Conductor::new(eta, k, alpha, Single)), 1.0, width));
        materials.extend([1.5, 1.0 / 1.5].map(|eta| (Bsdf::dielectric(eta, alpha, Single), eta, width)));
    }
    for alpha in [0.05, 0.2, 1.0] {
        let width = 2.0 * f64::from(alpha);
        materials.push((Bsdf::Conductor(Conductor::new(eta, k, alpha, Multiple)), 1.0, width));
        materials.extend([1.5, 1.0 / 1.5].map(|eta| (Bsdf::dielectric(eta, alpha, Multiple), eta, width)));
    }
    // The formulas also hold for these lobes, which are narrower than any that scenes can have.
    materials.push((Bsdf::RoughDielectric(RoughDielectric::new(1.5, 1e-4, Single)), 1.5, 2e-4));
    materials.push((Bsdf::RoughDielectric(RoughDielectric::new(1.0 / 1.5, 1e-4, Single)), 1.0 / 1.5, 2e-4));
    materials.push((Bsdf::Conductor(Conductor::new_without_smooth_limit(eta, k, 1e-4)), 1.0, 2e-4));
    for (bsdf, eta, width) in materials {
        for degrees in [0.0f32, 45.0, 85.0] {
            for side in [1.0f32, -1.0] {
                let (sin, cos) = libm::sincosf(degrees.to_radians());
                let wo = frame.to_world(Vec3::new(sin * 0.6, sin * 0.8, cos * side)).normalize();
                let eta = if side > 0.0 { eta } else { 1.0 / eta };
                cases.push(ChiSquareCase { bsdf, eta, width, wo, ns: n, ng: n });
                if degrees == 45.0 {
                    let bent = (n + frame.s * 0.4).normalize();
                    cases.push(ChiSquareCase { bsdf, eta, width, wo, ns: bent, ng: n });
                }
            }
        }
    }
    cases
}

/// Returns two grids. Their poles are the directions of specular reflection and of specular
/// refraction.
fn grids_around_specular_directions(case: &ChiSquareCase) -> [PolarDirectionGrid; 2] {
    let n = face_forward(case.ns, case.wo);
    let cos = case.wo.dot(n);
    let bent = refract(case.wo, n, case.eta);
    let grazing = (n * cos - case.wo).normalize_or(-n);
    let (through, width) = if bent.reflectance < 1.0 { (bent.transmitted, case.width) } else { (grazing, 0.5) };
    [PolarDirectionGrid::new(n * (2.0 * cos) - case.wo, case.width), PolarDirectionGrid::new(through, width)]
}

/// Returns probabilities in this order: that a sample falls in each cell of the reflection grid,
/// that it falls in each cell of the transmission grid, and that the path is absorbed.
fn expected_cell_probabilities(case: &ChiSquareCase, grids: &[PolarDirectionGrid; 2]) -> Vec<f64> {
    let mut cells = Vec::new();
    for (grid, side) in grids.iter().zip([1.0f32, -1.0]) {
        let side = side * case.wo.dot(case.ng);
        cells.extend(grid.integrate_over_cells(|wi| {
            if wi.dot(case.ng) * side > 0.0 { case.bsdf.pdf(case.wo, wi, case.ns, case.ng) } else { 0.0 }
        }));
    }
    let rest = 1.0 - cells.iter().sum::<f64>();
    cells.push(rest);
    cells
}

/// P-value of Pearson's chi-square test of `counts` against `expected` (Wilson–Hilferty
/// approximation). Cells with fewer than 5 expected samples are pooled.
fn chi_square_p_value(counts: &[u32], expected: &[f64]) -> f64 {
    let mut cells: Vec<(f64, f64)> = expected.iter().copied().zip(counts.iter().map(|c| f64::from(*c))).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut pool, mut chi2, mut used) = ((0.0, 0.0), 0.0, 0u32);
    for (e, o) in cells {
        pool = (pool.0 + e, pool.1 + o);
        if pool.0 >= 5.0 {
            chi2 += (pool.1 - pool.0) * (pool.1 - pool.0) / pool.0;
            used += 1;
            pool = (0.0, 0.0);
        }
    }
    let nu = f64::from(used - 1);
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    0.5 * libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Sampled directions are distributed by the pdf. The fraction of absorbed samples is 1 minus the
/// integral of the pdf.
#[test]
fn bsdf_samplers_match_their_pdfs() {
    let cases = chi_square_test_cases();
    // Bonferroni's correction for many tests: one false alarm in 400 runs of the whole list.
    let least = 0.0025 / cases.len() as f64;
    for (index, case) in cases.iter().enumerate() {
        let grids = grids_around_specular_directions(case);
        let expected = expected_cell_probabilities(case, &grids);
        let lost = *expected.last().unwrap();
        let name = format!("{:?} from {} by {}", case.bsdf, case.wo, case.ns);
        // The error of the midpoint rule is at most half the standard error of a count of all
        // samples.
        assert!(lost > -0.5 / (SAMPLES as f64).sqrt(), "{name} integrates to {}", 1.0 - lost);
        let mut counts = vec![0u32; expected.len()];
        let key = Key::new(17).purpose_key(Purpose::Test).child_key(index as u64);
        for i in 0..SAMPLES {
            let key = key.child_key(i);
            let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
            let sample = case.bsdf.sample(case.wo, case.ns, case.ng, lobe, u, TransportMode::Radiance);
            let cell = sample.map_or(expected.len() - 1, |s| {
                let side = usize::from(s.is_transmitted);
                side * RINGS * SECTORS + grids[side].cell_of_direction(s.wi)
            });
            counts[cell] += 1;
        }
        let scaled: Vec<f64> = expected.iter().map(|p| p.max(0.0) * SAMPLES as f64).collect();
        let p = chi_square_p_value(&counts, &scaled);
        assert!(p > least, "{name}: p = {p:e}");
    }
}

/// The pdf of a narrow lobe integrates to 1, because no microfacet scatters to the wrong side.
///
/// At α = 10⁻³ and 45°, the lobe's distance to the horizon is hundreds of its widths.
#[test]
fn pdfs_of_narrow_lobes_integrate_to_one() {
    let narrow = |c: &&ChiSquareCase| c.width < 0.01 && c.ns == c.ng && c.wo.dot(c.ns).abs() > 0.5;
    let mut seen = 0;
    for case in chi_square_test_cases().iter().filter(narrow) {
        let total = 1.0 - expected_cell_probabilities(case, &grids_around_specular_directions(case)).last().unwrap();
        assert!((total - 1.0).abs() < 1e-3, "{:?} from {}: {total}", case.bsdf, case.wo);
        seen += 1;
    }
    assert!(seen >= 12);
}
