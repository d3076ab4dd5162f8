use super::*;
use std::f64::consts::TAU;

const COST: PassCost =
    PassCost { direct_variance: 0.01, prefix_work: 4.0, continuation_work: 16.0, photon_work: 20.0, lookup_work: 20.0 };

fn division(path_variance: f32, photon_variance: f32, squared_bias: f32) -> IndirectDivision {
    let cell = RelativeIndirectErrors {
        single_path_variance: path_variance,
        single_photon_path_variance: photon_variance * 1e5,
        squared_bias,
    };
    IndirectDivision {
        columns: 2,
        cells: vec![cell; 4],
        cell_size: 10.0,
        samples_per_pixel: 8,
        unaimed_paths: 100_000,
        path_price: 0.0,
        passes_with_photons: MAX_PASSES_WITH_PHOTONS,
    }
}

fn area(pass: u32) -> f64 {
    libm::pow(f64::from(pass) + 1.0, -1.0 / 3.0)
}

#[test]
fn photon_estimates_are_used_only_if_cheaper() {
    let precise = least_cost_division(&division(0.4, 0.002, 1e-4), &PHOTON_PATH_FRACTIONS, &COST, area).unwrap();
    assert!(precise.passes_with_photons > 100, "{}", precise.passes_with_photons);
    let biased = least_cost_division(&division(0.4, 0.002, 2e-3), &PHOTON_PATH_FRACTIONS, &COST, area).unwrap();
    assert!(biased.passes_with_photons < precise.passes_with_photons, "{}", biased.passes_with_photons);
    assert_eq!(least_cost_division(&division(0.4, 2.0, 1e-4), &PHOTON_PATH_FRACTIONS, &COST, area), None);
    assert_eq!(least_cost_division(&division(0.4, 0.002, 3.0), &PHOTON_PATH_FRACTIONS, &COST, area), None);
    // Photons must not cost more than the camera paths that they save.
    assert_eq!(
        least_cost_division(
            &division(0.4, 0.002, 1e-4),
            &PHOTON_PATH_FRACTIONS,
            &PassCost { photon_work: 1e4, ..COST },
            area
        ),
        None
    );
    assert_eq!(least_cost_division(&division(0.0, 0.0, 0.0), &PHOTON_PATH_FRACTIONS, &COST, area), None);
}

#[test]
fn precise_photon_estimates_need_fewer_photons() {
    let photons = |variance| {
        least_cost_division(&division(0.4, variance, 0.0), &PHOTON_PATH_FRACTIONS, &COST, area).unwrap().unaimed_paths
    };
    assert!(photons(1e-6) < photons(5e-3), "{} {}", photons(1e-6), photons(5e-3));
}

/// From trials with normally distributed noise of known variance and a constant bias, the pilot
/// recovers variance and bias. With 400 cells of 16 paths, the standard errors are 2 % of the
/// variances and 6 % of the squared bias.
#[test]
fn trials_measure_variances_and_bias() {
    let (columns, cells) = (20, 400);
    let normal = |key: Key, i: u64| {
        let u = key.child_key(i).uniform_2d(Dimension::Film);
        (-2.0 * libm::log(1.0 - f64::from(u.x))).sqrt() * libm::cos(TAU * f64::from(u.y))
    };
    let trial = |seed: u64| -> Vec<TrialPathLight> {
        let keys = [0, 1, 2, 3].map(|i| Key::new(seed).child_key(i));
        let point = |i: u64| TrialPathLight {
            direct: 1.0 + 0.2 * normal(keys[0], i),
            emission_and_caustics: 0.0,
            path_indirect: 1.0 + 0.5 * normal(keys[1], i),
            photon_indirect: 1.0 + 0.1 * normal(keys[2], i),
            bias: 0.05 + 0.05 * normal(keys[3], i),
        };
        (0..u64::from(cells * CELL_POINTS)).map(point).collect()
    };
    let (errors, direct) = cell_errors(&trial(1), &trial(2), columns, 1000.0, 1.0).unwrap();
    let mean = |value: fn(&RelativeIndirectErrors) -> f32| {
        errors.iter().map(|cell| f64::from(value(cell))).sum::<f64>() / f64::from(cells)
    };
    // The light of a cell is 2. Its square, plus 1 % of the squared median light, is 4.04.
    let scale = 1.0 / 4.04;
    let near = |name: &str, found: f64, expected: f64, tolerance: f64| {
        assert!((found / (expected * scale) - 1.0).abs() < tolerance, "{name}: {found} for {}", expected * scale);
    };
    near("paths", mean(|cell| cell.single_path_variance), 0.25, 0.1);
    near("photons", mean(|cell| cell.single_photon_path_variance) / 1000.0, 0.01, 0.1);
    near("bias", mean(|cell| cell.squared_bias), 0.0025, 0.3);
    // The noisiest 5 % of the cells are left out.
    near("direct light", direct, 0.04, 0.15);
}
