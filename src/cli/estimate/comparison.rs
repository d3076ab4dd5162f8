//! Comparison of algorithms by the time that they take to reach an error.

use super::report::{CostEstimate, CostEstimateReport};
use crate::cli::forecast_text::duration_text;
use crate::integrate::Algorithm;
use crate::study::text::percent_text;
use serde::Serialize;
use std::fmt::Write as _;

/// Usage error: `--compare` names an algorithm that leaves out some light by design. The estimated
/// error of the algorithm does not contain the missing light, so a comparison would mislead.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--compare cannot compare {name}, which leaves light out by design")]
#[diagnostic(help("choose among hybrid, path, sppm, ppm and pm"))]
pub(super) struct AlgorithmOmitsLightError {
    name: &'static str,
}

/// Returns an error if one of `algorithms` leaves out some light by design. The estimated error of
/// such an algorithm does not contain the missing light.
pub(super) fn check_comparable(algorithms: &[Algorithm]) -> Result<(), AlgorithmOmitsLightError> {
    let is_complete = |algorithm: Algorithm| match algorithm {
        Algorithm::Hybrid | Algorithm::Path | Algorithm::Sppm | Algorithm::Ppm | Algorithm::Pm => true,
        Algorithm::Distributed | Algorithm::Whitted | Algorithm::Raycast => false,
    };
    match algorithms.iter().find(|algorithm| !is_complete(**algorithm)) {
        Some(algorithm) => Err(AlgorithmOmitsLightError { name: algorithm.name() }),
        None => Ok(()),
    }
}

/// Cost reports of the algorithm of `--integrator` and of the algorithms of `--compare`.
#[derive(Debug, Serialize)]
pub(super) struct CostComparison {
    #[serde(flatten)]
    report: CostEstimateReport,
    /// Reports of the algorithms of `--compare`.
    compared: Vec<CostEstimateReport>,
}

impl CostComparison {
    /// Creates a comparison that holds only `report`, the report of the algorithm of
    /// `--integrator`.
    pub(super) fn new(report: CostEstimateReport) -> Self {
        Self { report, compared: Vec::new() }
    }

    /// True if the comparison has no report of the cost of `algorithm`.
    pub(super) fn has_no_report_of(&self, algorithm: Algorithm) -> bool {
        self.reports().all(|report| report.integrator != algorithm.name())
    }

    pub(super) fn add_report(&mut self, report: CostEstimateReport) {
        self.compared.push(report);
    }

    fn reports(&self) -> impl Iterator<Item = &CostEstimateReport> {
        std::iter::once(&self.report).chain(&self.compared)
    }

    /// Returns one table of costs per algorithm. If there are several algorithms, a last table
    /// compares their times.
    pub(super) fn text(&self) -> String {
        let mut text: String = self.reports().map(CostEstimateReport::text_table).collect();
        if self.compared.is_empty() {
            return text;
        }
        let misses_caustics = self.reports().any(|report| report.may_miss_caustics);
        let brackets =
            if misses_caustics { "; times in brackets leave out caustics that the pilot missed" } else { "" };
        let _ = write!(text, "time by method; the least of each row has a star{brackets}\n  {:>7}", "error");
        self.reports().for_each(|report| _ = write!(text, " {:>16}", report.integrator));
        text.push('\n');
        for row in 0..self.report.estimates.len() {
            let costs: Vec<(&CostEstimate, bool)> =
                self.reports().map(|report| (&report.estimates[row], report.may_miss_caustics)).collect();
            // An algorithm that may miss caustics gets no star: its estimated error leaves out the
            // caustics that it misses.
            let known = costs.iter().filter(|(_, misses_caustics)| !misses_caustics);
            let least = known.filter_map(|(cost, _)| cost.seconds).fold(f64::INFINITY, f64::min);
            let _ = write!(text, "  {:>7}", percent_text(costs[0].0.target_error));
            for (cost, misses_caustics) in costs {
                let cell = match (cost.seconds, cost.bias_floor) {
                    (Some(seconds), _) if misses_caustics => format!("({})", duration_text(seconds)),
                    (Some(seconds), _) if seconds == least => format!("{} *", duration_text(seconds)),
                    (Some(seconds), _) => duration_text(seconds),
                    (None, Some(_)) => "never".to_owned(),
                    (None, None) => "cannot tell".to_owned(),
                };
                let _ = write!(text, " {cell:>16}");
            }
            text.push('\n');
        }
        text
    }
}
