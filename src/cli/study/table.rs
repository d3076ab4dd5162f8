//! The figures of a study of methods, as a table and as JSON.

use crate::study::methods::{Checkpoint, MethodFound, MethodsFound};
use crate::study::text::percent;
use serde::Serialize;
use std::fmt::Write as _;

/// A table for each method: a row a checkpoint.
pub(super) fn table(found: &MethodsFound) -> String {
    let mut text = format!("truth: {}", found.truth.source);
    if let Some(error) = found.truth.error {
        let _ = write!(text, "\ntruth: its own noise is {}", percent(error));
    }
    let _ = writeln!(text, "\n{} seeds each; seconds are of processor time, a seed; - is hidden by noise", found.seeds);
    for method in &found.methods {
        let _ = writeln!(text, "\n{}: prepared in {:.2} s", method.label, method.setup);
        let _ = writeln!(
            text,
            "  {:>8} {:>10} {:>9} {:>9} {:>9} {:>7}",
            "passes", "seconds", "error", "noise", "bias", "rate"
        );
        for (i, checkpoint) in method.checkpoints.iter().enumerate() {
            let before = i.checked_sub(1).map(|before| &method.checkpoints[before]);
            let rate = before.and_then(|before| rate(before, checkpoint));
            let _ = writeln!(
                text,
                "  {:>8} {:>10.3} {:>9} {:>9} {:>9} {:>7}",
                checkpoint.passes,
                checkpoint.seconds,
                root(checkpoint.square()),
                root(checkpoint.noise2),
                root(checkpoint.bias2),
                rate.map_or(String::new(), |rate| format!("{rate:.2}")),
            );
        }
        let _ = writeln!(text, "  {}", method.command);
    }
    text
}

/// The root of a squared error, unless noise hides it.
pub(super) fn root(square: f64) -> String {
    if square > 0.0 { percent(square.sqrt()) } else { "-".to_owned() }
}

/// The power of time by which the error went from one checkpoint to the next.
fn rate(before: &Checkpoint, after: &Checkpoint) -> Option<f64> {
    let error = 0.5 * libm::log(after.square() / before.square());
    let rate = error / libm::log(after.seconds / before.seconds);
    rate.is_finite().then_some(rate)
}

#[derive(Debug, Serialize)]
struct Report<'f> {
    schema: u32,
    version: &'static str,
    scene: &'f str,
    command: &'f str,
    machine: &'f str,
    width: u32,
    height: u32,
    seeds: u32,
    budget: f64,
    share: f64,
    interrupted: bool,
    truth: TruthReport<'f>,
    methods: Vec<Row<'f>>,
}

#[derive(Debug, Serialize)]
struct TruthReport<'f> {
    source: &'f str,
    error: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Row<'f> {
    label: &'f str,
    integrator: &'static str,
    command: &'f str,
    setup: f64,
    /// Of the global and of the caustic map.
    radii: Option<[f32; 2]>,
    checkpoints: &'f [Checkpoint],
}

/// All figures.
pub(super) fn json(found: &MethodsFound) -> serde_json::Result<String> {
    let rows = found.methods.iter().map(|method| {
        let MethodFound { label, algorithm, command, setup, radii, checkpoints, .. } = method;
        Row { label, integrator: algorithm.name(), command, setup: *setup, radii: *radii, checkpoints }
    });
    serde_json::to_string_pretty(&Report {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        scene: &found.scene,
        command: &found.command,
        machine: &found.machine,
        width: found.truth.picture.width(),
        height: found.truth.picture.height(),
        seeds: found.seeds,
        budget: found.budget,
        share: found.share,
        interrupted: found.interrupted,
        truth: TruthReport { source: &found.truth.source, error: found.truth.error },
        methods: rows.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_powers_of_time() {
        let at = |seconds, square| Checkpoint { seconds, squares: vec![square; 2], ..Checkpoint::default() };
        // Half the error for four times the time.
        assert!((rate(&at(1.0, 0.04), &at(4.0, 0.01)).unwrap() + 0.5).abs() < 1e-12);
        assert_eq!((rate(&at(1.0, 0.04), &at(1.0, 0.01)), rate(&at(1.0, 0.04), &at(4.0, -0.01))), (None, None));
        assert_eq!((root(0.0009), root(-0.1)), ("3.0 %".to_owned(), "-".to_owned()));
    }
}
