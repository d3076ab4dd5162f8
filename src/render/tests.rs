//! Tests that merging films and error estimators gives those of a single render, bit for bit.

use super::error_estimate::{ErrorEstimate, ErrorEstimator};
use super::{Film, MergeError};
use crate::color::Rgb;
use crate::integrate::{MeanGatherDisc, NestedDifferences, PassResult, RadiusLaw};
use crate::photon::Kernel;
use crate::sampling::{Dimension, Key, Purpose};

const SIZE: (u32, u32) = (6, 5);
const PIXELS: u32 = SIZE.0 * SIZE.1;
const LAW: RadiusLaw = RadiusLaw { alpha: 0.7, kernel: Kernel::Epanechnikov };

type Render = (Film, ErrorEstimator);

fn uniform_random_number(key: Key) -> f64 {
    key.uniform_1d(Dimension::Film).into()
}

/// Returns pass `number` with random radiance from about `10^-decades` to `10^decades`, random
/// nested differences, and three pixels that are also rendered by unshared camera paths.
fn noisy_pass(number: u32, decades: f64) -> PassResult {
    let key = Key::new(8).purpose_key(Purpose::Test).child_key(number.into());
    let value = |key: Key| {
        let size = libm::pow(10.0, decades * (2.0 * uniform_random_number(key.child_key(0)) - 1.0));
        (size * (0.5 + uniform_random_number(key.child_key(1)))) as f32
    };
    let color = |pixel: u32, which: u64| {
        let key = key.child_key(pixel.into()).child_key(which);
        Rgb::from_array([0, 1, 2].map(|channel| value(key.child_key(channel))))
    };
    let nested = |pixel| NestedDifferences {
        differences: [color(pixel, 1) - color(pixel, 2), color(pixel, 3) - color(pixel, 4)],
        caustic_disc: Some(MeanGatherDisc { radius: 1.0, mean_count: 2.0 }),
        indirect_disc: None,
    };
    PassResult {
        image: (0..PIXELS).map(|pixel| color(pixel, 0)).collect(),
        nested: (0..PIXELS).map(nested).collect(),
        unshared_path_pixels: [3, 7, 20].map(|pixel| (pixel, color(pixel, 5))).to_vec(),
        ..PassResult::default()
    }
}

fn render_without_passes() -> Render {
    (Film::new(SIZE.0, SIZE.1), ErrorEstimator::new(Some(LAW)))
}

fn add_pass((film, estimator): &mut Render, number: u32, pass: &PassResult) {
    estimator.add(number, pass);
    film.add(&pass.image);
}

/// Deals `passes` at random to up to nine renders, each in random order, and merges the renders in
/// random order.
fn render_in_parts(passes: &[PassResult], seed: u64) -> Render {
    let key = Key::new(seed).purpose_key(Purpose::Test);
    let mut parts: Vec<Render> = (0..=seed % 9).map(|_| render_without_passes()).collect();
    let mut order: Vec<u32> = (0..passes.len() as u32).collect();
    let rank = |i: &u32| uniform_random_number(key.child_key(u64::from(*i)));
    order.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    for number in order {
        let part = uniform_random_number(key.child_key(1 << 32 | u64::from(number))) * parts.len() as f64;
        add_pass(&mut parts[part as usize], number, &passes[number as usize]);
    }
    while parts.len() > 1 {
        let (film, estimator) = parts.pop().unwrap();
        let at = uniform_random_number(key.child_key(2 << 32 | parts.len() as u64)) * parts.len() as f64;
        let (own, own_estimator) = &mut parts[at as usize];
        own.merge(&film).unwrap();
        own_estimator.merge(&estimator).unwrap();
    }
    parts.pop().unwrap()
}

/// Returns the bits of the picture and of its noise and bias maps, and the error estimate.
fn result_bits_and_error((film, estimator): &Render) -> (Vec<u64>, Vec<u32>, ErrorEstimate) {
    let means = film.pixel_means().flat_map(|mean| mean.to_array().map(f64::to_bits)).collect();
    let maps = estimator.error_maps(film);
    let maps = maps.noise.iter().chain(&maps.blur).flat_map(|value| value.to_array().map(f32::to_bits)).collect();
    (means, maps, estimator.estimate(film))
}

#[test]
fn pass_order_and_merging_change_no_bit() {
    for (decades, count) in [(0.5, 40), (6.0, 23), (30.0, 40), (1.0, 5)] {
        let passes: Vec<PassResult> = (0..count).map(|number| noisy_pass(number, decades)).collect();
        let mut whole = render_without_passes();
        (0..count).zip(&passes).for_each(|(number, pass)| add_pass(&mut whole, number, pass));
        let expected = result_bits_and_error(&whole);
        assert!(expected.2.error > 0.0 && expected.2.low < expected.2.high, "{:?}", expected.2);
        let forecast = format!("{:?}", whole.1.forecast(&expected.2));
        for seed in 0..40 {
            let merged = render_in_parts(&passes, seed);
            assert_eq!(merged.0, whole.0, "{decades} decades, seed {seed}");
            assert_eq!(result_bits_and_error(&merged), expected, "{decades} decades, seed {seed}");
            assert_eq!(format!("{:?}", merged.1.forecast(&expected.2)), forecast);
        }
    }
}

/// A pixel whose passes have infinite radiance of both signs becomes NaN. Pixels with finite passes
/// stay finite.
#[test]
fn infinities_and_nan_survive_merging() {
    let mut passes: Vec<PassResult> = (0..9).map(|number| noisy_pass(number, 1.0)).collect();
    passes[2].image[4].x = f32::INFINITY;
    passes[7].image[4].x = f32::NEG_INFINITY;
    passes[3].image[9].y = f32::NAN;
    passes[5].image[0].z = f32::INFINITY;
    let mut whole = render_without_passes();
    (0..9).zip(&passes).for_each(|(number, pass)| add_pass(&mut whole, number, pass));
    let mean = whole.0.mean_picture();
    assert!(mean[4].x.is_nan() && mean[9].y.is_nan() && mean[0].z == f32::INFINITY);
    assert_eq!(mean.iter().flat_map(|pixel| pixel.to_array()).filter(|value| !value.is_finite()).count(), 3);
    for seed in 0..40 {
        let merged = render_in_parts(&passes, seed);
        assert_eq!(merged.0, whole.0, "seed {seed}");
        assert_eq!(result_bits_and_error(&merged).1, result_bits_and_error(&whole).1);
        assert_eq!(format!("{:?}", merged.1.estimate(&merged.0)), format!("{:?}", whole.1.estimate(&whole.0)));
    }
}

#[test]
fn films_of_different_pictures_are_not_merged() {
    let mut film = Film::new(6, 5);
    assert_eq!(film.merge(&Film::new(5, 6)), Err(MergeError::SizeMismatch { own: (6, 5), other: (5, 6) }));
    let mut many = Film::new(1, 1);
    many.add(&[Rgb::ONE]);
    // Doubling 31 times gives 2³¹ passes. Once more is one pass too many.
    for _ in 0..31 {
        let same = many.clone();
        many.merge(&same).unwrap();
    }
    let same = many.clone();
    assert_eq!(many.merge(&same), Err(MergeError::TooManyPasses { own: 1 << 31, other: 1 << 31 }));
    assert_eq!((many.passes(), many.mean_picture()), (1 << 31, vec![Rgb::ONE]));
    let mut estimator = ErrorEstimator::new(Some(LAW));
    assert_eq!(estimator.merge(&ErrorEstimator::new(None)), Err(MergeError::EstimatorMismatch));
    estimator.add(0, &noisy_pass(0, 1.0));
    let mut other = ErrorEstimator::new(Some(LAW));
    other.add(1, &PassResult { nested: Vec::new(), ..noisy_pass(1, 1.0) });
    assert_eq!(estimator.merge(&other), Err(MergeError::EstimatorMismatch));
}
