//! Table of forecasts and real ends.

use super::trace::{Trace, groups, last_estimate_up_to};
use caustica::render::error_estimate::{PassRange, StopForecast};

/// Numbers of passes of the forecasts. A forecast is made at the last estimate up to its number.
const PILOTS: [u32; 3] = [8, 16, 32];

/// A render that made this many times the passes of the forecast, or more, is compared with it.
const LEAST_EXTRAPOLATION: f64 = 1.3;

/// Counts of comparisons of forecasts with real ends.
#[derive(Clone, Copy, Debug, Default)]
struct Score {
    cases: f64,
    /// Median of the forecast within a factor of 1.5 of the real number of passes.
    near: f64,
    /// Range of the forecast contains the real number of passes.
    held: f64,
    /// Forecasts without a median.
    silent: f64,
    /// Pairs of forecasts after n and about 2n passes.
    pairs: f64,
    /// Pairs of medians that differ by less than a factor of 2, or that both lie in one range.
    steady: f64,
}

impl Score {
    fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.near += other.near;
        self.held += other.held;
        self.silent += other.silent;
        self.pairs += other.pairs;
        self.steady += other.steady;
    }

    fn text(&self) -> String {
        let percent = |part: f64, of: f64| if of > 0.0 { format!("{:.0} %", 100.0 * part / of) } else { "–".into() };
        format!(
            "{} | {} | {} | {} | {}",
            self.cases,
            percent(self.near, self.cases),
            percent(self.held, self.cases),
            percent(self.silent, self.cases),
            percent(self.steady, self.pairs)
        )
    }
}

/// Prints how well forecasts agree with the passes after which renders end.
pub fn print(traces: &[Trace]) {
    println!("| scene | method | passes | cases | within 1.5 | in the range | cannot tell | steady |");
    println!("|{}", " --- |".repeat(8));
    let pilots = PILOTS.map(last_estimate_up_to);
    let mut totals = [Score::default(); PILOTS.len()];
    for group in groups(traces) {
        let scores = pilots.map(|pilot| score_of_pilot(group, pilot));
        for ((score, pilot), total) in scores.iter().zip(pilots).zip(&mut totals) {
            total.add(score);
            println!("| {} | {} | {pilot} | {} |", group[0].scene, group[0].algorithm.name(), score.text());
        }
    }
    for (score, pilot) in totals.iter().zip(pilots) {
        println!("| all | | {pilot} | {} |", score.text());
    }
}

/// Compares the forecasts after `pilot` passes with the ends of the same renders.
fn score_of_pilot(traces: &[Trace], pilot: u32) -> Score {
    let mut score = Score::default();
    for trace in traces {
        let forecast_after = |passes: f64| {
            let near = |p: &&super::trace::TracePoint| (f64::from(p.estimate.passes) / passes - 1.0).abs() < 0.06;
            trace.points.iter().find(near).and_then(|point| point.forecast)
        };
        let Some(forecast) = forecast_after(f64::from(pilot)) else { continue };
        let later = forecast_after(2.0 * f64::from(pilot));
        for reached in trace.reached_targets() {
            let passes = reached.end.estimate.passes;
            if f64::from(passes) < LEAST_EXTRAPOLATION * f64::from(pilot) {
                continue;
            }
            let (error, confidence) = (reached.target.error, reached.target.interval_confidence());
            score.cases += 1.0;
            let StopForecast::Passes(range) = forecast.stop_forecast(error, confidence) else {
                score.silent += 1.0;
                continue;
            };
            let factor = f64::from(range.median) / f64::from(passes);
            score.near += f64::from((1.0 / 1.5..=1.5).contains(&factor));
            score.held += f64::from(contains(range, passes));
            if let Some(StopForecast::Passes(other)) = later.map(|later| later.stop_forecast(error, confidence)) {
                let factor = f64::from(range.median) / f64::from(other.median);
                score.pairs += 1.0;
                let covered = contains(range, other.median) || contains(other, range.median);
                score.steady += f64::from(covered || (0.5..=2.0).contains(&factor));
            }
        }
    }
    score
}

fn contains(range: PassRange, passes: u32) -> bool {
    range.low <= passes && range.high.is_none_or(|high| passes <= high)
}
