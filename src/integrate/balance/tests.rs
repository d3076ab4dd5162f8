use super::*;

fn noise_source(variance: f64, work: f64, count: f64) -> NoiseSource {
    NoiseSource { single_sample_variance: variance, work_per_sample: work, sample_count: count }
}

fn variance_and_work(sources: &[NoiseSource; 3], numbers: &[f64; 3]) -> (f64, f64) {
    let noise = sources
        .iter()
        .zip(numbers)
        .filter(|(p, _)| p.single_sample_variance > 0.0)
        .map(|(p, n)| p.single_sample_variance / n)
        .sum();
    (
        noise,
        sources
            .iter()
            .zip(numbers)
            .filter(|(p, _)| p.single_sample_variance > 0.0)
            .map(|(p, n)| p.work_per_sample * n)
            .sum(),
    )
}

/// For two sources of noise with equal work per sample, the best sample counts are proportional to
/// the standard deviations.
#[test]
fn sample_counts_follow_standard_deviation() {
    let sources = [noise_source(4.0, 1.0, 10.0), noise_source(1.0, 1.0, 10.0), noise_source(0.0, 5.0, 7.0)];
    let [a, b, c] = balance_sample_counts(&sources);
    assert!((a - 40.0 / 3.0).abs() < 1e-9 && (b - 20.0 / 3.0).abs() < 1e-9 && c == 7.0, "{a} {b} {c}");
}

/// No small shift of work from one source of noise to another lowers the variance, if both sample
/// counts stay within their bounds.
#[test]
fn balance_has_the_least_noise() {
    for sources in [
        [noise_source(1.0, 3.0, 8.0), noise_source(50.0, 0.01, 1000.0), noise_source(3.0, 0.02, 500.0)],
        [noise_source(1e-6, 3.0, 8.0), noise_source(50.0, 0.01, 1000.0), noise_source(3000.0, 0.02, 500.0)],
    ] {
        let best = balance_sample_counts(&sources);
        let (noise, work) = variance_and_work(&sources, &best);
        let (before, given) = variance_and_work(&sources, &sources.map(|p| p.sample_count));
        assert!(noise <= before && (work / given - 1.0).abs() < 1e-9);
        for (i, j) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
            let mut other = best;
            let moved = 1e-3 * sources[i].work_per_sample * best[i];
            other[i] -= moved / sources[i].work_per_sample;
            other[j] += moved / sources[j].work_per_sample;
            let within = |k: usize| {
                (sources[k].sample_count / MAX_CHANGE..=sources[k].sample_count * MAX_CHANGE).contains(&other[k])
            };
            assert!(!within(i) || !within(j) || variance_and_work(&sources, &other).0 >= noise, "{i} to {j}");
        }
    }
}

#[test]
fn noiseless_sources_keep_their_sample_counts() {
    let two = [noise_source(4.0, 1.0, 10.0), noise_source(1.0, 2.0, 10.0), NoiseSource::default()];
    let [a, b, _] = balance_sample_counts(&two);
    let three = [two[0], two[1], noise_source(0.0, 9.0, 1000.0)];
    assert_eq!(balance_sample_counts(&three), [a, b, 1000.0]);
    assert_eq!(balance_sample_counts(&[NoiseSource::default(); 3]), [0.0; 3]);
}
