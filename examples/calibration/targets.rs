//! Table of renders that end by an error target.

use super::trace::{Trace, groups};

/// Greatest number of passes of each column.
const COLUMNS: [u32; 4] = [5, 8, 40, u32::MAX];

/// Prints how many renders have reached the error target by which they end, by number of passes.
///
/// A target above the first estimate of a render says little about its end and is left out.
pub fn print(traces: &[Trace]) {
    println!("| scene | method | 4 to 5 passes | 6 to 8 | 9 to 40 | more |");
    println!("|{}", " --- |".repeat(6));
    let text = |counts: &[(u32, u32); COLUMNS.len()]| counts.map(|(held, of)| format!("{held}/{of}")).join(" | ");
    let mut all = [(0, 0); COLUMNS.len()];
    for group in groups(traces) {
        let mut counts = [(0, 0); COLUMNS.len()];
        for trace in group {
            for reached in trace.reached_targets() {
                let (end, error) = (reached.end, reached.target.error);
                let Some(column) = COLUMNS.iter().position(|most| end.estimate.passes <= *most) else { continue };
                if end.upper_end < 0.85 * error {
                    continue;
                }
                let held = u32::from(end.error.is_some_and(|true_error| true_error <= error));
                for counts in [&mut counts, &mut all] {
                    counts[column] = (counts[column].0 + held, counts[column].1 + 1);
                }
            }
        }
        println!("| {} | {} | {} |", group[0].scene, group[0].algorithm.name(), text(&counts));
    }
    println!("| all | | {} |\n", text(&all));
}
