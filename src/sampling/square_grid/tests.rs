use super::*;
use crate::sampling::{Dimension, Key, Purpose, sobol_2d};

const SIDE: usize = 16;

/// Returns weights from 0 to 10⁴. They are 0 in one row, in one column and in a fifth of the other
/// cells.
fn grid_weights_with_zeros() -> Vec<f64> {
    let key = Key::new(3).purpose_key(Purpose::Test);
    let weight = |i: usize| {
        let (row, column) = (i / SIDE, i % SIDE);
        let u = f64::from(key.child_key(i as u64).uniform_1d(Dimension::Light));
        if row == 3 || column == 15 || u < 0.2 { 0.0 } else { u * u * u * if u > 0.95 { 1e4 } else { 1.0 } }
    };
    (0..SIDE * SIDE).map(weight).collect()
}

fn random_points_in_square(n: u64) -> impl Iterator<Item = Vec2> {
    let key = Key::new(9).purpose_key(Purpose::Test);
    (0..n).map(move |i| key.child_key(i).uniform_2d(Dimension::LightPosition))
}

/// A million samples pass a chi-square test over the quarters of all cells. The false-alarm rate of
/// the test is 10⁻⁴.
#[test]
fn grid_samples_follow_the_pdf() {
    let histogram = SquareGridDistribution::new(SIDE, &grid_weights_with_zeros()).unwrap();
    let n = 1_000_000;
    let fine = 2 * SIDE;
    let mut counts = vec![0.0; fine * fine];
    for u in random_points_in_square(n) {
        let (at, density) = histogram.sample(u);
        assert!(at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all());
        assert_eq!(density, histogram.pdf(at));
        counts[SquareGridDistribution::cell_index(fine, at)] += 1.0;
    }
    // Cells with fewer than ten expected points are pooled.
    let (mut chi2, mut nu, mut rest) = (0.0, -1.0, (0.0, 0.0));
    for (i, count) in counts.iter().enumerate() {
        let middle = (Vec2::new((i % fine) as f32, (i / fine) as f32) + 0.5) / fine as f32;
        let expected = f64::from(histogram.pdf(middle)) * n as f64 / (fine * fine) as f64;
        assert!(expected > 0.0 || *count == 0.0);
        if expected < 10.0 {
            rest = (rest.0 + expected, rest.1 + count);
        } else {
            chi2 += (count - expected) * (count - expected) / expected;
            nu += 1.0;
        }
    }
    if rest.0 > 0.0 {
        chi2 += (rest.1 - rest.0) * (rest.1 - rest.0) / rest.0;
        nu += 1.0;
    }
    // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance
    // 2/(9ν).
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    assert!(z.abs() < 3.9, "z = {z}, {nu} degrees of freedom");
}

/// The pdf of each cell is proportional to its weight, within rounding.
///
/// Each row of nonzero weight has a minimum probability of 64 · 2⁻²⁴, and so has each cell in its
/// row. The tolerance allows for this minimum.
#[test]
fn grid_pdf_is_proportional_to_weights() {
    let weights = grid_weights_with_zeros();
    let histogram = SquareGridDistribution::new(SIDE, &weights).unwrap();
    let total: f64 = weights.iter().sum();
    let mut integral = 0.0;
    for (i, w) in weights.iter().enumerate() {
        let middle = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
        let p = f64::from(histogram.pdf(middle)) / (SIDE * SIDE) as f64;
        assert_eq!(p > 0.0, *w > 0.0);
        let kept = 64.0 * (SIDE + 1) as f64 / PROBABILITY_STEPS;
        assert!((p - w / total).abs() <= 2.0 * kept, "{p} {}", w / total);
        integral += p;
    }
    assert!((integral - 1.0).abs() < 1e-5, "{integral}");
    let rare = SquareGridDistribution::new(2, &[1.0, 1e-30, 1.0, 1.0]).unwrap();
    assert!(rare.pdf(Vec2::new(0.75, 0.25)) > 0.0, "a weight above zero must keep some density");
}

/// Each row gets its expected share of 256 stratified points, up to one point at each end of the
/// row.
#[test]
fn grid_distribution_keeps_points_stratified() {
    let mut weights = vec![1.0; 16];
    weights[5] = 9.0;
    let histogram = SquareGridDistribution::new(4, &weights).unwrap();
    let key = Key::new(2).purpose_key(Purpose::Test);
    let mut rows = [0.0; 4];
    for i in 0..256 {
        let (at, _) = histogram.sample(sobol_2d(i, key, Dimension::LightDirection));
        rows[(at.y * 4.0) as usize] += 1.0 / 256.0;
    }
    // Rows have the probabilities 4/24, 12/24, 4/24 and 4/24. Stratification places at most one
    // point wrongly at each end of a row.
    for (row, expected) in rows.iter().zip([4.0, 12.0, 4.0, 4.0]) {
        assert!((row - expected / 24.0f64).abs() < 2.0 / 256.0, "{rows:?}");
    }
}

#[test]
fn extreme_random_numbers_give_points_in_the_square() {
    let histogram = SquareGridDistribution::new(SIDE, &grid_weights_with_zeros()).unwrap();
    for x in [0.0, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0] {
        for y in [0.0, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0] {
            let (at, density) = histogram.sample(Vec2::new(x, y));
            assert!(density > 0.0 && at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all(), "{at}");
        }
    }
    let even = SquareGridDistribution::new(1, &[5.0]).unwrap();
    assert_eq!(even.sample(Vec2::new(0.3, 0.7)), (Vec2::new(0.3, 0.7), 1.0));
}

#[test]
fn distributions_refuse_invalid_weights() {
    for bad in [vec![0.0; 4], vec![1.0; 3], vec![1.0, 1.0, 1.0, -1.0], vec![f64::NAN; 4], vec![f64::INFINITY; 4]] {
        assert!(SquareGridDistribution::new(2, &bad).is_none(), "{bad:?}");
    }
    assert!(SquareGridDistribution::new(0, &[]).is_none() && SquareGridDistribution::new(3, &[1.0; 9]).is_none());
}

#[test]
fn find_interval_agrees_with_binary_search() {
    let histogram = SquareGridDistribution::new(SIDE, &grid_weights_with_zeros()).unwrap();
    let (rows, columns) = histogram.first_candidates.split_at(SIDE);
    for row in 0..SIDE {
        let cdfs = [
            (histogram.row_cdf.as_slice(), rows),
            (histogram.cumulative_column_probabilities(row), &columns[row * SIDE..(row + 1) * SIDE]),
        ];
        for (bounds, candidates) in cdfs {
            let ends = bounds.iter().flat_map(|b| [*b, b.next_up(), b.next_down().max(0.0)]).filter(|u| *u < 1.0);
            for u in ends.chain(random_points_in_square(100).map(|u| u.x)) {
                let expected = bounds.partition_point(|b| *b <= u).clamp(1, SIDE) - 1;
                assert_eq!(find_interval(bounds, candidates, u).0, expected, "{u}");
            }
        }
    }
}
