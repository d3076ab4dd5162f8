//! Table of estimated and true errors.

use super::trace::{Trace, TracePoint, groups, last_estimate_up_to};

/// Numbers of passes of the table's rows. A row shows the last estimate up to its number.
const PASSES: [u32; 6] = [4, 8, 16, 32, 64, 128];

/// Prints estimated over true error, and how many 90 % intervals contain the true error.
pub fn print(traces: &[Trace]) {
    println!("| scene | method | passes | true error | noise | bias | estimated / true | intervals that hold |");
    println!("|{}", " --- |".repeat(8));
    let (mut held_of_all, mut all, mut rows, mut good_rows) = (0, 0, 0, 0);
    for group in groups(traces) {
        for passes in PASSES.map(last_estimate_up_to) {
            let points: Vec<&TracePoint> = group
                .iter()
                .filter_map(|trace| trace.points.iter().find(|point| point.estimate.passes == passes))
                .collect();
            if points.is_empty() {
                continue;
            }
            let n = points.len() as f64;
            let mean = |of: &dyn Fn(&TracePoint) -> f64| points.iter().map(|point| of(point)).sum::<f64>() / n;
            let error = |point: &TracePoint| point.error.unwrap_or(f64::NAN);
            let ratio = |point: &TracePoint| point.estimate.error / error(point);
            let holds = |point: &&&TracePoint| (point.estimate.low..=point.estimate.high).contains(&error(point));
            let held = points.iter().filter(holds).count();
            (held_of_all, all, rows) = (held_of_all + held, all + points.len(), rows + 1);
            good_rows += usize::from((0.8..=1.25).contains(&mean(&ratio)));
            println!(
                "| {} | {} | {passes} | {:.2} % | {:.2} % | {:.2} % | {:.2} ({:.2} to {:.2}) | {held}/{} |",
                group[0].scene,
                group[0].algorithm.name(),
                100.0 * mean(&error),
                100.0 * mean(&|point| point.estimate.noise),
                100.0 * mean(&|point| point.estimate.bias),
                mean(&ratio),
                points.iter().map(|point| ratio(point)).fold(f64::INFINITY, f64::min),
                points.iter().map(|point| ratio(point)).fold(0.0, f64::max),
                points.len(),
            );
        }
    }
    println!(
        "\n{held_of_all} of {all} intervals hold. The mean ratio is in .8 to 1.25 in {good_rows} of {rows} rows.\n"
    );
}
