//! How many passes an error takes.

use super::specks::Specks;
use super::{ErrorEstimate, ErrorEstimator};
use crate::integrate::shrink;

/// Nobody waits for more passes.
const MOST_PASSES: u32 = 10_000_000;

/// Up to so many passes are looked at one by one, beyond by leaps of a part of those so far.
const EXACTLY: u32 = 1024;
const LEAP: u32 = 128;

/// What an error takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Needed {
    /// So many passes in all.
    Passes(u32),
    /// No number of passes: what they leave is larger.
    Never {
        /// The relative error that is left.
        floor: f64,
    },
    /// More than ten million passes.
    TooMany,
}

/// How the error goes on from here.
///
/// A part of the noise falls as 1/n, that of estimates as Σ 1/aᵢ over n², where aᵢ is what is left of the area of discs in pass i; how much
/// of the noise they make is told by how noisy D₀ is. Blur goes as the mean of aᵢ to the power by which it was seen to go. Specks, which
/// count for one pixel each until they have faded, go by a law of their own.
#[derive(Clone, Copy, Debug)]
pub struct Forecast {
    alpha: f64,
    /// Relative variance of a pass that does not depend on discs, without specks.
    even: f64,
    /// The same of estimates in the first pass.
    gathered: f64,
    /// Blur of the first pass.
    blur: f64,
    /// Blur goes as area to this power.
    power: f64,
    frozen: f64,
    specks: Specks,
    /// Passes by which the specks were seen.
    seen: f64,
}

impl ErrorEstimator {
    /// How the error goes on after what was read; `None` while too few passes tell.
    #[must_use]
    pub fn forecast(&self, reading: &ErrorEstimate) -> Option<Forecast> {
        let law = self.law.map(|law| (law.alpha, law.kernel.step_noise()));
        reading.error.is_finite().then(|| Forecast::new(reading, law))
    }
}

impl Forecast {
    fn new(reading: &ErrorEstimate, law: Option<(f64, f32)>) -> Self {
        let n = f64::from(reading.passes);
        let specks = reading.specks;
        let variance = (reading.variance - n * specks.now()).max(0.0);
        let Some((alpha, step_noise)) = law else {
            let frozen = reading.frozen;
            return Self { alpha: 1.0, even: variance, gathered: 0.0, blur: 0.0, power: 1.0, frozen, specks, seen: n };
        };
        let power = (-libm::log2(reading.ratio)).max(0.0);
        let mut sums = Sums::new(alpha, power);
        (0..reading.passes).for_each(|_| sums.advance());
        let gathered = (reading.step_variance / f64::from(step_noise)).min(variance);
        Self {
            alpha,
            even: variance - gathered,
            gathered: gathered * n / sums.inverse,
            blur: reading.blur * n / sums.blur,
            power,
            frozen: reading.frozen,
            specks,
            seen: n,
        }
    }

    /// The relative error after `passes` passes, at least one, as noise and bias.
    #[cfg(test)]
    fn after(&self, passes: u32) -> (f64, f64) {
        let mut sums = Sums::new(self.alpha, self.power);
        (0..passes).for_each(|_| sums.advance());
        self.at(&sums)
    }

    fn at(&self, sums: &Sums) -> (f64, f64) {
        let n = f64::from(sums.passes);
        let noise2 = (self.even * n + self.gathered * sums.inverse) / (n * n) + self.specks.after(n / self.seen);
        let blur = self.blur * sums.blur / n;
        (noise2.sqrt(), (blur * blur + self.frozen * self.frozen).sqrt())
    }

    /// Passes until the error is at most `target`: the least number up to a thousand, less than a hundredth too many beyond.
    #[must_use]
    pub fn passes_to(&self, target: f64) -> Needed {
        let floor = if self.alpha < 1.0 { self.frozen } else { self.blur.hypot(self.frozen) };
        if floor >= target {
            return Needed::Never { floor };
        }
        let mut sums = Sums::new(self.alpha, self.power);
        while sums.passes < MOST_PASSES {
            if sums.passes < EXACTLY {
                sums.advance()
            } else {
                sums.leap()
            }
            let (noise, bias) = self.at(&sums);
            if noise.hypot(bias) <= target {
                return Needed::Passes(sums.passes);
            }
        }
        Needed::TooMany
    }
}

/// Sums over passes.
struct Sums {
    alpha: f64,
    power: f64,
    passes: u32,
    /// What is left of the area of discs in the next pass.
    area: f64,
    /// Σ 1/area.
    inverse: f64,
    /// Σ area^power.
    blur: f64,
}

impl Sums {
    fn new(alpha: f64, power: f64) -> Self {
        Self { alpha, power, passes: 0, area: shrink(alpha, 0), inverse: 0.0, blur: 0.0 }
    }

    fn advance(&mut self) {
        self.inverse += 1.0 / self.area;
        self.blur += if self.power == 1.0 { self.area } else { libm::pow(self.area, self.power) };
        self.passes += 1;
        let i = f64::from(self.passes);
        self.area *= (i + self.alpha) / (i + 1.0);
    }

    /// Some passes at once, by the area in their middle: areas go as n^(α − 1) where n is large.
    fn leap(&mut self) {
        let (n, count) = (f64::from(self.passes), self.passes / LEAP);
        let at = |i: f64| self.area * libm::pow(i / n, self.alpha - 1.0);
        let middle = at(n + 0.5 * f64::from(count));
        self.area = at(n + f64::from(count));
        self.inverse += f64::from(count) / middle;
        self.blur += f64::from(count) * libm::pow(middle, self.power);
        self.passes += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(passes: u32, variance: f64, step_variance: f64, blur: f64, ratio: f64) -> ErrorEstimate {
        ErrorEstimate { passes, variance, step_variance, blur, ratio, ..ErrorEstimate::default() }
    }

    /// A tenth of the pixels hold a speck of sixteen times what counts: as passes are added, more find one, and the first to find one
    /// lose it from four times the passes on.
    #[test]
    fn specks_spread_before_they_fade() {
        let mut specks = Specks::default();
        (0..10).for_each(|_| specks.add(16.0, 0.01));
        let forecast = Forecast::new(&ErrorEstimate { specks, ..reading(8, 8.0 * 0.1, 0.0, 0.0, 0.5) }, None);
        let noise2 = |n: u32| libm::pow(forecast.after(n).0, 2.0);
        for (n, expected) in [(8, 0.1), (16, 0.2), (32, 0.4), (64, 0.2), (8 * 160, 0.01)] {
            // Sizes are kept to the half of an octave.
            assert!(libm::log2(noise2(n) / expected).abs() < 0.5 + 1e-9, "{n}: {} {expected}", noise2(n));
        }
    }

    /// 4 passes of variance .04: .1 now, .01 after 400.
    #[test]
    fn noise_alone_falls_as_the_root_of_passes() {
        let forecast = Forecast::new(&reading(4, 0.04, 0.0, 0.0, 0.5), None);
        assert!((forecast.after(4).0 - 0.1).abs() < 1e-12);
        assert_eq!(forecast.passes_to(0.01), Needed::Passes(400));
        assert_eq!(forecast.passes_to(1e-9), Needed::TooMany);
    }

    #[test]
    fn fixed_radii_leave_a_floor() {
        let forecast = Forecast::new(&reading(10, 0.04, 0.01, 0.02, 0.5), Some((1.0, 0.5)));
        assert_eq!(forecast.passes_to(0.02), Needed::Never { floor: 0.02 });
        let Needed::Passes(n) = forecast.passes_to(0.025) else { panic!("it can be reached") };
        // .04/n = .025² − .02².
        assert_eq!(n, 178);
    }

    /// Where estimates make all noise, the exact law of Knaus and Zwicker holds: both parts go as n^(−1/3) in the long run.
    #[test]
    fn shrinking_radii_follow_their_law() {
        let alpha = 2.0 / 3.0;
        let forecast = Forecast::new(&reading(8, 0.04, 0.02, 0.02, 0.5), Some((alpha, 0.5)));
        let mean = |n: u32, power: f64| (0..n).map(|i| libm::pow(shrink(alpha, i), power)).sum::<f64>() / f64::from(n);
        let (noise, bias) = forecast.after(64);
        let expected = 0.04 / 8.0 * (mean(64, -1.0) / 64.0) / (mean(8, -1.0) / 8.0);
        assert!((noise * noise / expected - 1.0).abs() < 1e-9, "{noise}");
        assert!((bias / (0.02 * mean(64, 1.0) / mean(8, 1.0)) - 1.0).abs() < 1e-9, "{bias}");
        let slope = |f: fn((f64, f64)) -> f64| libm::log10(f(forecast.after(1_000_000)) / f(forecast.after(100_000)));
        assert!((slope(|e| e.0) + 1.0 / 3.0).abs() < 1e-3 && (slope(|e| e.1) + 1.0 / 3.0).abs() < 1e-3);
        let Needed::Passes(n) = forecast.passes_to(0.01) else { panic!("it can be reached") };
        let error = |n| forecast.after(n).0.hypot(forecast.after(n).1);
        let fewer = if n < EXACTLY { n - 1 } else { n - n / LEAP - 1 };
        assert!(error(n) <= 0.01 && error(fewer) > 0.01, "{n}");
        let Needed::Passes(n) = forecast.passes_to(0.001) else { panic!("it can be reached") };
        // Leaps are as good as single steps to a thousandth.
        assert!(n > 100_000 && (error(n) / 0.001 - 1.0).abs() < 0.005, "{n} {}", error(n));
    }
}
