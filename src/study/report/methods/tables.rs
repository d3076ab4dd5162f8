//! Tables of the HTML page about a study of methods.

use super::analysis::{MethodStudyAnalysis, TARGET_ERRORS, slope_interval_text, slope_range_text, time_to_error_text};
use crate::study::methods::MethodStudyResult;
use crate::study::methods::fit::{ConvergenceSlopes, ErrorComponent, TimeToError};
use crate::study::report::html::{escape_html, number_cells_html};
use crate::study::report::svg::{marker_svg, series_color};
use crate::study::report::text::{
    count_text, duration_text, error_percent_text, square_root_percent_text, three_digit_text,
};
use std::fmt::Write;

/// Returns inline SVG of a method's plot marker in its colour. `style` is the index of the method.
pub(super) fn method_marker_svg(style: usize) -> String {
    let colour = series_color(style);
    format!(
        "<svg class=\"key\" aria-hidden=\"true\" viewBox=\"-7 -7 14 14\" width=\"14\" height=\"14\" fill=\"{colour}\">{}</svg> ",
        marker_svg(style, 0.0, 0.0)
    )
}

/// Returns the start of an HTML table with its head row. The first `left` columns are aligned left.
fn table_head_html(columns: &[&str], left: usize) -> String {
    let mut table =
        "<div class=\"scroll\" role=\"region\" aria-label=\"table\" tabindex=\"0\"><table>\n<thead><tr>".to_owned();
    for (i, column) in columns.iter().enumerate() {
        let class = if i < left { "" } else { " class=\"n\"" };
        let _ = write!(table, "<th scope=\"col\"{class}>{}</th>", escape_html(column));
    }
    table + "</tr></thead>\n<tbody>\n"
}

const TABLE_END: &str = "</tbody>\n</table></div>\n";

pub(super) fn verdicts_table_html(result: &MethodStudyResult, analysis: &MethodStudyAnalysis) -> String {
    let mut table = table_head_html(&["method", "verdict", "error at the end", "noise", "bias", "slope", "theory"], 2);
    for (i, (method, judged)) in result.methods.iter().zip(&analysis.methods).enumerate() {
        let _ = write!(
            table,
            "<tr><th scope=\"row\">{}<a href=\"#method-{i}\">{}</a></th>",
            method_marker_svg(i),
            escape_html(&method.label)
        );
        let _ = write!(table, "<td class=\"words\">{}</td>", escape_html(&judged.verdict.to_string()));
        for cell in judged.verdict_cells(method) {
            let _ = write!(table, "<td class=\"n\">{}</td>", escape_html(&cell));
        }
        table += "</tr>\n";
    }
    let note = "<p>Slopes of the error over passes, log-log, with 95 % intervals.</p>\n";
    table + TABLE_END + note
}

pub(super) fn times_table_html(result: &MethodStudyResult, analysis: &MethodStudyAnalysis) -> String {
    let heads: Vec<String> = TARGET_ERRORS.iter().map(|e| format!("{:.0} %", 100.0 * e)).collect();
    let columns: Vec<&str> = ["method", "setup"]
        .into_iter()
        .chain(heads.iter().map(String::as_str))
        .chain(["a tenth of the last error"])
        .collect();
    let mut table = table_head_html(&columns, 1);
    for (i, (method, judged)) in result.methods.iter().zip(&analysis.methods).enumerate() {
        let _ = write!(table, "<tr><th scope=\"row\">{}{}</th>", method_marker_svg(i), escape_html(&method.label));
        let _ = write!(table, "<td class=\"n\">{}</td>", duration_text(method.setup_seconds));
        for reach in judged.times_to_target_errors.iter().chain([&judged.time_to_tenth_error]) {
            let (time, work) = time_to_error_text(reach, method.algorithm.traces_photons());
            let class = if matches!(reach, TimeToError::Predicted { .. }) { "n predicted" } else { "n" };
            let _ = write!(table, "<td class=\"{class}\">{}", escape_html(&time));
            work.iter().for_each(|line| table += &format!("<small>{}</small>", escape_html(line)));
            table += "</td>";
        }
        table += "</tr>\n";
    }
    let note = "<p>Times are interpolated between checkpoints. Times with ≈ are extrapolated by the slope, with those of both ends of \
                its interval. Setup is extra.</p>\n";
    let front: Vec<String> = analysis
        .pareto
        .iter()
        .map(|m| (&result.methods[m.method_index], m.checkpoint_index))
        .map(|(method, at)| {
            let c = &method.checkpoints[at];
            format!(
                "{} after {} ({})",
                error_percent_text(c.mean_relative_squared_error().sqrt()),
                duration_text(c.cpu_seconds),
                method.label
            )
        })
        .collect();
    let front = if front.is_empty() {
        String::new()
    } else {
        format!("<p>Least error over time: {}.</p>\n", escape_html(&front.join("; ")))
    };
    table + TABLE_END + note + &front
}

pub(super) fn checkpoint_tables_html(result: &MethodStudyResult) -> String {
    let mut all = String::new();
    for (i, method) in result.methods.iter().enumerate() {
        let _ = writeln!(
            all,
            "<details><summary>{}{}: every checkpoint</summary>",
            method_marker_svg(i),
            escape_html(&method.label)
        );
        all += &table_head_html(
            &[
                "passes",
                "processor time",
                "wall",
                "rays",
                "photons",
                "error",
                "noise",
                "bias",
                "estimated error",
                "RMSE, W/(m² sr)",
                "FLIP",
            ],
            1,
        );
        for c in &method.checkpoints {
            let cells = [
                duration_text(c.cpu_seconds),
                duration_text(c.wall_seconds),
                count_text(c.rays),
                count_text(c.photon_paths),
                square_root_percent_text(c.mean_relative_squared_error()),
                square_root_percent_text(c.squared_noise),
                square_root_percent_text(c.squared_bias),
                c.mean_square_of_estimated_error().map_or("–".to_owned(), square_root_percent_text),
                three_digit_text(c.rmse),
                three_digit_text(c.flip),
            ];
            let _ = write!(all, "<tr><th scope=\"row\">{}</th>", c.passes);
            all += &number_cells_html(&cells);
            all += "</tr>\n";
        }
        all += TABLE_END;
        all += "</details>\n";
    }
    all
}

/// Returns an HTML table with the slopes of one method, measured and predicted.
pub(super) fn slopes_table_html(
    method: &crate::study::methods::MethodResult,
    judged: &super::analysis::MethodAnalysis,
) -> String {
    let Some(fit) = &judged.fit else { return String::new() };
    let mut table = table_head_html(&["", "over passes", "over time", "theory"], 1);
    for (name, slopes, quantity) in [
        ("error", fit.error, ErrorComponent::Error),
        ("noise", fit.noise, ErrorComponent::Noise),
        ("bias", fit.bias, ErrorComponent::Bias),
    ] {
        let by_time = slopes.map(|s| ConvergenceSlopes { by_passes: s.by_time, ..s });
        let _ = writeln!(
            table,
            "<tr><th scope=\"row\">{name}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            slope_interval_text(slopes),
            slope_interval_text(by_time),
            slope_range_text(judged.predicted_convergence_slopes(method, quantity))
        );
    }
    table + TABLE_END
}
