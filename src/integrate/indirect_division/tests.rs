use super::*;

const SAMPLES: u32 = 8;

fn division_of_cells(cells: Vec<RelativeIndirectErrors>, columns: u32) -> IndirectDivision {
    IndirectDivision {
        columns,
        cells,
        cell_size: 10.0,
        samples_per_pixel: SAMPLES,
        unaimed_paths: 1000,
        path_price: 1e-3,
        passes_with_photons: 1,
    }
}

fn indirect_errors(path_variance: f32, photon_variance: f32, squared_bias: f32) -> RelativeIndirectErrors {
    RelativeIndirectErrors {
        single_path_variance: path_variance,
        single_photon_path_variance: photon_variance,
        squared_bias,
    }
}

/// The total weight of continued camera paths plus the weight of the photon estimate is 1.
#[test]
fn weights_of_both_techniques_sum_to_one() {
    for path_variance in [0.001, 0.05, 1.0, 40.0] {
        for photon_variance in [0.01, 1.0, 50.0] {
            for squared_bias in [0.0, 0.001, 0.3] {
                let cell = indirect_errors(path_variance, photon_variance, squared_bias);
                for pass_count in [1.0, 30.0, 1000.0] {
                    let weights = division_of_cells(vec![cell], 1).technique_weights(Vec2::ZERO, pass_count, 0.5);
                    let paths =
                        weights.continued_path_factor(SAMPLES) * weights.continued_paths as f32 / SAMPLES as f32;
                    assert!((weights.photon_weight + paths - 1.0).abs() < 1e-6, "{cell:?} {weights:?}");
                    assert!((0.0..=1.0).contains(&weights.photon_weight) && weights.continued_paths <= SAMPLES);
                }
            }
        }
    }
}

/// The single camera path of a pilot stands for all paths of its pixel.
///
/// If n of the pixel's N paths would continue, the single path continues with probability n/N. It
/// then has the weight of one continued path among N.
#[test]
fn single_pilot_path_stands_for_all_samples() {
    let weights = IndirectWeights { photon_weight: 0.25, continued_paths: 3, samples_per_pixel: 12 };
    let continued = (0..1200).filter(|i| weights.continues_at_receiver((0, 1), *i as f32 / 1200.0)).count();
    assert_eq!(continued, 300);
    assert_eq!(weights.continued_path_factor(1), weights.continued_path_factor(12));
    assert_eq!((0..12).filter(|i| weights.continues_at_receiver((*i, 12), 0.0)).count(), 3);
}

#[test]
fn photon_weight_vanishes_after_many_passes() {
    let division = division_of_cells(vec![indirect_errors(0.4, 1.0, 0.001)], 1);
    // The law of gather radii: the area of a disc falls as n^(-1/3) with the number n of passes.
    let weights = |pass_count: f32| division.technique_weights(Vec2::ZERO, pass_count, 1.0 / libm::cbrtf(pass_count));
    let photons = [1.0, 64.0, 4096.0, 262_144.0, 1e9].map(|pass_count| weights(pass_count).photon_weight);
    assert!(photons.windows(2).all(|pair| pair[1] <= pair[0]), "{photons:?}");
    assert!(photons[0] > 0.9 && photons[4] < 0.05, "{photons:?}");
    assert_eq!((weights(1.0).continued_paths, weights(1e9).continued_paths), (0, SAMPLES));
}

/// If a pilot found no light by one technique in a cell, camera paths carry all of the indirect
/// light there that the two techniques share.
#[test]
fn cells_without_measured_errors_use_camera_paths() {
    for cell in [indirect_errors(0.0, 1.0, 0.0), indirect_errors(1.0, 0.0, 0.0)] {
        assert_eq!(
            division_of_cells(vec![cell], 1).technique_weights(Vec2::ZERO, 1.0, 1.0),
            IndirectWeights::default()
        );
    }
}

#[test]
fn errors_are_interpolated_between_cell_centers() {
    let cells = vec![
        indirect_errors(1.0, 2.0, 0.0),
        indirect_errors(3.0, 4.0, 8.0),
        indirect_errors(5.0, 6.0, 0.0),
        indirect_errors(7.0, 8.0, 8.0),
    ];
    let division = division_of_cells(cells, 2);
    assert_eq!(division.interpolated_errors(Vec2::new(5.0, 5.0)), indirect_errors(1.0, 2.0, 0.0));
    assert_eq!(division.interpolated_errors(Vec2::new(15.0, 15.0)), indirect_errors(7.0, 8.0, 8.0));
    assert_eq!(division.interpolated_errors(Vec2::new(10.0, 5.0)), indirect_errors(2.0, 3.0, 4.0));
    assert_eq!(division.interpolated_errors(Vec2::new(10.0, 10.0)), indirect_errors(4.0, 5.0, 4.0));
    assert_eq!(division.interpolated_errors(Vec2::new(-3.0, 40.0)), indirect_errors(5.0, 6.0, 0.0));
}
