//! Tests of fits and verdicts, on synthetic methods with known convergence.

use super::slopes::student_t_quantile_975;
use super::*;
use crate::image::Image;
use crate::integrate::{Algorithm, DEFAULT_ALPHA, squared_radius_ratio};
use crate::sampling::Key;
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult, Reference};
use glam::Vec3;
use rand::RngExt;

const SEEDS: usize = 8;
const PIXELS: usize = 64;

/// Makes results of a synthetic method. The error of each pixel in pass i has the mean 0.1 · `bias`
/// · s(i) and the variance 0.01/s(i).
///
/// s(i) is the squared gather radius of pass i, divided by that of the first pass. It shrinks with
/// the exponent `alpha`. `random_seed` selects the random numbers.
fn synthetic_method(algorithm: Algorithm, bias: f64, alpha: f64, passes: &[u32], random_seed: u64) -> MethodResult {
    let mut rng = Key::new(77).child_key(random_seed).rng();
    // Irwin–Hall: the sum of twelve uniform numbers, minus six, has mean 0 and variance 1.
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let radius_ratio = |i: u32| squared_radius_ratio(alpha, i);
    let (mut made, mut bias_sum) = (0, 0.0);
    let mut sums = vec![[0.0; PIXELS]; SEEDS];
    let checkpoints = passes.iter().map(|&n| {
        let variance: f64 = (made..n).map(|i| 1.0 / radius_ratio(i)).sum();
        bias_sum += (made..n).map(|i| bias * radius_ratio(i)).sum::<f64>();
        made = n;
        for sum in sums.iter_mut().flatten() {
            *sum += variance.sqrt() * normal();
        }
        let error = |sum: f64| 0.1 * (sum + bias_sum) / f64::from(n);
        let mean_of = |seed: &[f64; PIXELS], of: &dyn Fn(usize, f64) -> f64| {
            seed.iter().enumerate().map(|(i, s)| of(i, *s)).sum::<f64>() / PIXELS as f64
        };
        let means: Vec<f64> =
            (0..PIXELS).map(|p| sums.iter().map(|s| error(s[p])).sum::<f64>() / SEEDS as f64).collect();
        let squared_errors: Vec<f64> = sums.iter().map(|s| mean_of(s, &|_, x| error(x) * error(x))).collect();
        let squared_deviation = |i: usize, x: f64| (error(x) - means[i]) * (error(x) - means[i]);
        let squared_noises: Vec<f64> =
            sums.iter().map(|s| mean_of(s, &squared_deviation) * SEEDS as f64 / (SEEDS - 1) as f64).collect();
        let noise2 = squared_noises.iter().sum::<f64>() / SEEDS as f64;
        let bias2 = squared_errors.iter().sum::<f64>() / SEEDS as f64 - noise2;
        let seconds = 0.25 * f64::from(n);
        ConvergenceCheckpoint {
            passes: n,
            cpu_seconds: seconds,
            photon_paths: 1000.0 * f64::from(n),
            relative_squared_errors: squared_errors,
            squared_noises,
            squared_noise: noise2,
            squared_bias: bias2,
            ..ConvergenceCheckpoint::default()
        }
    });
    MethodResult {
        label: algorithm.name().into(),
        algorithm,
        render_command: "caustica render".into(),
        setup_seconds: 0.0,
        alpha,
        gather_radii: Some([0.1, 0.1]),
        checkpoints: checkpoints.collect(),
        first_seed_picture: Image::new(1, 1).unwrap(),
        relative_pixel_errors: vec![0.0],
        mean_difference: Image::new(1, 1).unwrap(),
    }
}

fn powers_of_two(count: u32) -> Vec<u32> {
    (0..count).map(|i| 1 << i).collect()
}

fn fitted_verdict(method: &MethodResult) -> ConvergenceVerdict {
    judge_convergence(method, fit_convergence(method).as_ref(), None)
}

/// At least 90 of 100 confidence intervals of 95 % contain the predicted slope.
///
/// With exact intervals, the chance of more than 10 misses is 1 %. The logarithm of a mean of
/// squares is biased by 1/(SEEDS · PIXELS), which is small compared with the interval.
#[test]
fn slope_intervals_cover_theory() {
    let passes = powers_of_two(9);
    let laws = [(Algorithm::Path, 0.0, 1.0), (Algorithm::Sppm, 2.0, DEFAULT_ALPHA), (Algorithm::Pm, 0.0, 1.0)];
    for (algorithm, bias, alpha) in laws {
        let mut covered = [0; 2];
        for random_seed in 0..100 {
            let method = synthetic_method(algorithm, bias, alpha, &passes, random_seed);
            let fit = fit_convergence(&method).unwrap();
            assert_eq!(fit.checkpoint_passes, [16, 32, 64, 128, 256]);
            for (covered, (slopes, quantity)) in
                covered.iter_mut().zip([(fit.error, ErrorComponent::Error), (fit.noise, ErrorComponent::Noise)])
            {
                let law = predicted_convergence_slopes(algorithm, quantity, &fit.checkpoint_passes, alpha).unwrap();
                let [low, high] = slopes.unwrap().by_passes.confidence_interval.unwrap();
                // Without bias, only noise remains. Its slope is the steepest of the predicted
                // range.
                let law = if bias == 0.0 { SlopeRange { flattest: law.steepest, ..law } } else { law };
                *covered += usize::from(low <= law.flattest && high >= law.steepest);
            }
        }
        assert!(covered.iter().all(|c| *c >= 90), "{algorithm:?} {covered:?}");
    }
}

#[test]
fn fitted_slopes_match_theory() {
    let passes = powers_of_two(9);
    let path = fit_convergence(&synthetic_method(Algorithm::Path, 0.0, 1.0, &passes, 1)).unwrap();
    let sppm = fit_convergence(&synthetic_method(Algorithm::Sppm, 4.0, DEFAULT_ALPHA, &passes, 2)).unwrap();
    let pm = fit_convergence(&synthetic_method(Algorithm::Pm, 4.0, 1.0, &passes, 3)).unwrap();
    // The logarithm of an estimated error has the standard deviation σ = 1/√(2 · SEEDS · PIXELS) =
    // 0.031. For five checkpoints at distances of log 2, a fitted slope then has the standard
    // deviation σ/√(10 log²2) = σ/2.19. The tolerance is four times this.
    let close = |slopes: Option<ConvergenceSlopes>, slope: f64| {
        let ConvergenceSlopes { by_time, by_passes } = slopes.unwrap();
        assert!(
            (by_passes.value - slope).abs() < 0.057 && (by_time.value - by_passes.value).abs() < 1e-9,
            "{by_passes:?} {slope}"
        );
    };
    close(path.error, -0.5);
    close(path.noise, -0.5);
    for (slopes, quantity) in
        [(sppm.error, ErrorComponent::Bias), (sppm.noise, ErrorComponent::Noise), (sppm.bias, ErrorComponent::Bias)]
    {
        close(
            slopes,
            predicted_convergence_slopes(Algorithm::Sppm, quantity, &sppm.checkpoint_passes, DEFAULT_ALPHA)
                .unwrap()
                .flattest,
        );
    }
    close(pm.bias, 0.0);
    close(pm.error, 0.0);
}

#[test]
fn verdicts_name_the_cause_of_bias() {
    let passes = powers_of_two(9);
    let verdict_of =
        |algorithm, bias, alpha, passes: &[u32]| fitted_verdict(&synthetic_method(algorithm, bias, alpha, passes, 5));
    assert!(matches!(
        verdict_of(Algorithm::Path, 0.0, 1.0, &passes),
        ConvergenceVerdict::Expected { bias_floor: None, .. }
    ));
    assert!(matches!(
        verdict_of(Algorithm::Sppm, 3.0, DEFAULT_ALPHA, &passes),
        ConvergenceVerdict::Expected { bias_floor: None, .. }
    ));
    // A method that `synthetic_method` makes for the argument 3 has the relative bias 0.1 · 3.
    let plateau = verdict_of(Algorithm::Pm, 3.0, 1.0, &passes);
    assert!(
        matches!(plateau, ConvergenceVerdict::Plateau { floor, cause: BiasCause::Radii(_) } if (floor - 0.3).abs() < 0.01),
        "{plateau:?}"
    );
    let words = plateau.to_string();
    assert!(words.starts_with("plateau: bias of ") && words.ends_with(" % stays at r = 0.100"), "{words}");
    assert!(matches!(
        verdict_of(Algorithm::Path, 3.0, 1.0, &passes),
        ConvergenceVerdict::Plateau { cause: BiasCause::Unknown, .. }
    ));
    assert!(matches!(
        verdict_of(Algorithm::Whitted, 3.0, 1.0, &passes),
        ConvergenceVerdict::Plateau { cause: BiasCause::OmittedLight, .. }
    ));
    // The bias is a tenth of the noise at the last checkpoint.
    assert!(
        matches!(verdict_of(Algorithm::Pm, 0.001, 1.0, &passes), ConvergenceVerdict::BiasHidden { max_bias, .. } if max_bias < 0.005)
    );
    // The bias is as large as the noise at the last checkpoint.
    assert!(matches!(
        verdict_of(Algorithm::Pm, 1.0 / 16.0, 1.0, &passes),
        ConvergenceVerdict::Expected { bias_floor: Some(_), .. }
    ));
    assert!(matches!(verdict_of(Algorithm::Path, 0.0, DEFAULT_ALPHA, &passes), ConvergenceVerdict::Slower { .. }));
    assert!(matches!(
        verdict_of(Algorithm::Ppm, 0.0, 1.0, &passes),
        ConvergenceVerdict::Expected { .. } | ConvergenceVerdict::Faster { .. } | ConvergenceVerdict::BiasHidden { .. }
    ));
    assert_eq!(verdict_of(Algorithm::Path, 0.0, 1.0, &powers_of_two(2)), ConvergenceVerdict::TooFewCheckpoints);
}

#[test]
fn errors_below_the_reference_error_are_not_judged() {
    let method = synthetic_method(Algorithm::Path, 0.0, 1.0, &powers_of_two(9), 6);
    let fit = fit_convergence(&method);
    // The error at the last checkpoint, after 256 passes, is 0.1/√256.
    assert!(matches!(
        judge_convergence(&method, fit.as_ref(), Some(0.01)),
        ConvergenceVerdict::ErrorTooSmall { reference_error: Some(_) }
    ));
    assert!(matches!(judge_convergence(&method, fit.as_ref(), Some(0.005)), ConvergenceVerdict::Expected { .. }));
    let mut below = method.clone();
    below.checkpoints.last_mut().unwrap().relative_squared_errors = vec![-1e-9; SEEDS];
    assert!(matches!(fitted_verdict(&below), ConvergenceVerdict::ErrorTooSmall { reference_error: None }));
    let mut alone = method;
    alone.checkpoints.iter_mut().for_each(|c| (c.relative_squared_errors.truncate(1), c.squared_noises.clear()).1);
    assert!(matches!(fitted_verdict(&alone), ConvergenceVerdict::NoInterval { .. }));
}

/// Makes results of a synthetic method without noise: after n passes and n/4 seconds, its error is
/// 0.1/√n.
fn method_without_noise() -> MethodResult {
    let mut method = synthetic_method(Algorithm::Path, 0.0, 1.0, &powers_of_two(9), 7);
    for c in &mut method.checkpoints {
        c.relative_squared_errors = vec![0.01 / f64::from(c.passes); SEEDS];
        (c.squared_noises, c.squared_noise, c.squared_bias) =
            (c.relative_squared_errors.clone(), c.mean_relative_squared_error(), 0.0);
    }
    method
}

#[test]
fn times_to_error_follow_the_slope() {
    let method = method_without_noise();
    let fit = fit_convergence(&method);
    let verdict = judge_convergence(&method, fit.as_ref(), None);
    let time_to = |error| time_to_error(&method, fit.as_ref(), &verdict, error);
    assert!(matches!(time_to(0.2), TimeToError::Within(effort) if effort.passes == 1.0));
    let TimeToError::Measured(effort) = time_to(0.05 / 3.0) else { panic!() };
    assert!(
        (effort.passes - 36.0).abs() < 1e-9
            && (effort.cpu_seconds - 9.0).abs() < 1e-9
            && (effort.photon_paths - 36e3).abs() < 1e-6
    );
    let TimeToError::Predicted { effort, cpu_seconds_interval: Some([low, high]) } = time_to(0.1 / 64.0) else {
        panic!()
    };
    assert!((effort.passes - 4096.0).abs() < 1e-6 && (low - 1024.0).abs() < 1e-6 && (high - 1024.0).abs() < 1e-6);
    let TimeToError::Predicted { effort, .. } = time_to_tenth_of_error(&method, fit.as_ref(), &verdict) else {
        panic!()
    };
    assert!((effort.cpu_seconds - 6400.0).abs() < 1e-6);
    for (seconds, passes) in [(0.25, 1.0), (3.0, 12.0), (640.0, 2560.0)] {
        let error = error_after_cpu_seconds(&method, fit.as_ref(), seconds).unwrap();
        assert!((error - 0.1 / f64::sqrt(passes)).abs() < 1e-12, "{error}");
    }
    assert_eq!(error_after_cpu_seconds(&method, fit.as_ref(), 0.1), None);
}

#[test]
fn plateaus_never_reach_smaller_errors() {
    let method = synthetic_method(Algorithm::Pm, 3.0, 1.0, &powers_of_two(9), 8);
    let fit = fit_convergence(&method);
    let verdict = judge_convergence(&method, fit.as_ref(), None);
    assert!(
        matches!(time_to_error(&method, fit.as_ref(), &verdict, 0.1), TimeToError::Never { floor } if (floor - 0.3).abs() < 0.01)
    );
    assert!(matches!(time_to_tenth_of_error(&method, fit.as_ref(), &verdict), TimeToError::Never { .. }));
}

/// Only the noise of a method with constant bias falls, so the predicted time follows from the
/// noise alone.
///
/// The bias is 0.1, and the noise is 0.1 after 256 passes. For an error of 0.12, the squared noise
/// must fall from 0.01 to 0.12² − 0.1² = 0.0044. It does so after 256 · 0.01/0.0044 passes.
#[test]
fn only_noise_falls_above_constant_bias() {
    let mut method = method_without_noise();
    for c in &mut method.checkpoints {
        let noise2 = 0.01 * 256.0 / f64::from(c.passes);
        c.relative_squared_errors = vec![0.01 + noise2; SEEDS];
        (c.squared_noises, c.squared_noise, c.squared_bias) = (vec![noise2; SEEDS], noise2, 0.01);
    }
    let fit = fit_convergence(&method);
    let verdict = ConvergenceVerdict::Expected { slope: -0.3, bias_floor: Some(0.1) };
    let TimeToError::Predicted { effort, .. } = time_to_error(&method, fit.as_ref(), &verdict, 0.12) else { panic!() };
    assert!((effort.passes / (256.0 * 0.01 / 0.0044) - 1.0).abs() < 1e-6, "{effort:?}");
    assert_eq!(time_to_error(&method, fit.as_ref(), &verdict, 0.1), TimeToError::Never { floor: 0.1 });
}

/// Predicted times are at most a thousand times the measured time.
///
/// At a slope of −0.5, a thousandth of the error would take 10⁶ times as long. If the slope's
/// confidence interval contains 0, the upper end of the time is a thousand times the prediction.
#[test]
fn predicted_times_are_limited_to_a_thousandfold() {
    let method = method_without_noise();
    let mut fit = fit_convergence(&method).unwrap();
    let verdict = judge_convergence(&method, Some(&fit), None);
    assert_eq!(time_to_error(&method, Some(&fit), &verdict, 0.1 / 16e3), TimeToError::Unknown);
    fit.error.as_mut().unwrap().by_time.confidence_interval = Some([-0.6, 0.1]);
    let TimeToError::Predicted { effort, cpu_seconds_interval: Some([low, high]) } =
        time_to_error(&method, Some(&fit), &verdict, 0.1 / 64.0)
    else {
        panic!()
    };
    assert!((high / (1000.0 * effort.cpu_seconds) - 1.0).abs() < 1e-9 && low < effort.cpu_seconds, "{low} {high}");
}

/// If the confidence interval of a slope is too wide, there is no verdict.
///
/// The squared errors of the seeds vary by factors from 1/18 to 18 before the last checkpoint,
/// so many slopes agree with them.
#[test]
fn wide_intervals_give_no_verdict() {
    let mut method = method_without_noise();
    for (i, c) in method.checkpoints.iter_mut().enumerate() {
        let square = 0.01 / f64::from(c.passes);
        let spread = if i == 8 { 0.3 } else { 1.2 };
        let factor = |seed: usize| libm::exp2(spread * (((seed * 5 + i * 3) % 8) as f64 - 3.5));
        c.relative_squared_errors = (0..SEEDS).map(|seed| square * factor(seed)).collect();
        (c.squared_noises, c.squared_noise) = (c.relative_squared_errors.clone(), c.mean_relative_squared_error());
    }
    let verdict = fitted_verdict(&method);
    let ConvergenceVerdict::Undecided { slope, interval: [low, high] } = verdict else { panic!("{verdict:?}") };
    assert!(high - low > 0.25 && (low..=high).contains(&slope), "{verdict}");
    assert!(verdict.to_string().starts_with("cannot tell: slope "), "{verdict}");
}

/// The Pareto front holds the method with the least error at each time, and the recommendation the
/// one with the least error after the time budget.
///
/// A pass of the second method takes twice as long as one of the first. The error of the second
/// method begins at a third of the first method's error, and does not fall.
#[test]
fn pareto_front_and_recommendation_have_least_error() {
    let mut early = method_without_noise();
    early.checkpoints.iter_mut().for_each(|c| (c.cpu_seconds *= 2.0, c.relative_squared_errors.fill(0.001)).1);
    let picture = Image::from_pixels(1, 1, vec![Vec3::ONE]).unwrap();
    let mut found = MethodStudyResult {
        scene_path: "a.txt".into(),
        study_command: "caustica study a.txt".into(),
        program: "caustica".into(),
        machine: "test".into(),
        seeds: 8,
        max_cpu_seconds_per_seed: 64.0,
        thread_time_share: 1.0,
        reference: Reference { source: "closed form".into(), error: None, picture },
        methods: vec![method_without_noise(), early],
        interrupted: false,
    };
    let points: Vec<(usize, usize)> =
        pareto_front(&found.methods).iter().map(|m| (m.method_index, m.checkpoint_index)).collect();
    assert_eq!(points, [(0, 0), (1, 0), (0, 4), (0, 5), (0, 6), (0, 7), (0, 8)]);
    let recommended = |found: &MethodStudyResult| {
        let fits: Vec<_> = found.methods.iter().map(fit_convergence).collect();
        recommend_method(found, &fits).unwrap()
    };
    let late = recommended(&found);
    assert!(
        late.method_index == 0
            && (late.expected_error - 0.1 / 16.0).abs() < 1e-12
            && late.similar_method_indices.is_empty()
    );
    found.max_cpu_seconds_per_seed = 1.0;
    assert_eq!(recommended(&found).method_index, 1);
}

#[test]
fn students_t_matches_tables() {
    for (degrees, t) in [(1, 12.7062), (7, 2.3646), (11, 2.2010), (30, 2.0423), (1000, 1.9623)] {
        assert!((student_t_quantile_975(degrees) - t).abs() < 1e-3, "{degrees}");
    }
}
