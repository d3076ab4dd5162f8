//! Tables of an HTML page.

use super::analysis::{Analysis, ERRORS, law_text, reach_text, slope};
use crate::study::methods::fit::{Quantity, Slopes, TimeToError};
use crate::study::methods::{Checkpoint, MethodStudyResult};
use crate::study::report::html::escape;
use crate::study::report::svg::{colour, marker};
use crate::study::report::text::{amount, duration, error, figure};
use std::fmt::Write;

/// Marker of a method in its colour.
pub(super) fn key(style: usize) -> String {
    let colour = colour(style);
    format!(
        "<svg class=\"key\" aria-hidden=\"true\" viewBox=\"-7 -7 14 14\" width=\"14\" height=\"14\" fill=\"{colour}\">{}</svg> ",
        marker(style, 0.0, 0.0)
    )
}

/// Head of a table; the first `left` columns hold words.
fn head(columns: &[&str], left: usize) -> String {
    let mut table =
        "<div class=\"scroll\" role=\"region\" aria-label=\"table\" tabindex=\"0\"><table>\n<thead><tr>".to_owned();
    for (i, column) in columns.iter().enumerate() {
        let class = if i < left { "" } else { " class=\"n\"" };
        let _ = write!(table, "<th scope=\"col\"{class}>{}</th>", escape(column));
    }
    table + "</tr></thead>\n<tbody>\n"
}

const END: &str = "</tbody>\n</table></div>\n";

/// Square root as a percentage; `≈ 0` if `square` is not positive.
pub(super) fn root(square: f64) -> String {
    if square > 0.0 { error(square.sqrt()) } else { "≈ 0".to_owned() }
}

pub(super) fn verdicts(found: &MethodStudyResult, analysis: &Analysis) -> String {
    let mut table = head(&["method", "verdict", "error at the end", "noise", "bias", "slope", "theory"], 2);
    for (i, (method, judged)) in found.methods.iter().zip(&analysis.methods).enumerate() {
        let _ =
            write!(table, "<tr><th scope=\"row\">{}<a href=\"#method-{i}\">{}</a></th>", key(i), escape(&method.label));
        let _ = write!(table, "<td class=\"words\">{}</td>", escape(&judged.verdict.to_string()));
        let last = method.checkpoints.last();
        let of = |square: fn(&Checkpoint) -> f64| last.map_or("–".to_owned(), |c| root(square(c)));
        let fit = judged.fit.as_ref();
        for cell in [
            of(Checkpoint::square),
            of(|c| c.noise2),
            of(|c| c.bias2),
            slope(fit.and_then(|f| f.error)),
            fit.map_or("–".to_owned(), |_| law_text(judged.law(method, Quantity::Error))),
        ] {
            let _ = write!(table, "<td class=\"n\">{}</td>", escape(&cell));
        }
        table += "</tr>\n";
    }
    let note = "<p>Slopes of the error over passes, log-log, with 95 % intervals.</p>\n";
    table + END + note
}

pub(super) fn reaches(found: &MethodStudyResult, analysis: &Analysis) -> String {
    let heads: Vec<String> = ERRORS.iter().map(|e| format!("{:.0} %", 100.0 * e)).collect();
    let columns: Vec<&str> = ["method", "setup"]
        .into_iter()
        .chain(heads.iter().map(String::as_str))
        .chain(["a tenth of the last error"])
        .collect();
    let mut table = head(&columns, 1);
    for (i, (method, judged)) in found.methods.iter().zip(&analysis.methods).enumerate() {
        let _ = write!(table, "<tr><th scope=\"row\">{}{}</th>", key(i), escape(&method.label));
        let _ = write!(table, "<td class=\"n\">{}</td>", duration(method.setup));
        for reach in judged.reaches.iter().chain([&judged.tenth]) {
            let (time, work) = reach_text(reach, method.algorithm.has_photons());
            let class = if matches!(reach, TimeToError::Predicted { .. }) { "n predicted" } else { "n" };
            let _ = write!(table, "<td class=\"{class}\">{}", escape(&time));
            work.iter().for_each(|line| table += &format!("<small>{}</small>", escape(line)));
            table += "</td>";
        }
        table += "</tr>\n";
    }
    let note = "<p>Times are interpolated between checkpoints. Times with ≈ are extrapolated by the slope, with those of both ends of \
                its interval. Setup is extra.</p>\n";
    let front: Vec<String> = analysis
        .pareto
        .iter()
        .map(|m| (&found.methods[m.method], m.checkpoint))
        .map(|(method, at)| {
            let c = &method.checkpoints[at];
            format!("{} after {} ({})", error(c.square().sqrt()), duration(c.seconds), method.label)
        })
        .collect();
    let front = if front.is_empty() {
        String::new()
    } else {
        format!("<p>Least error over time: {}.</p>\n", escape(&front.join("; ")))
    };
    table + END + note + &front
}

pub(super) fn checkpoints(found: &MethodStudyResult) -> String {
    let mut all = String::new();
    for (i, method) in found.methods.iter().enumerate() {
        let _ = writeln!(all, "<details><summary>{}{}: every checkpoint</summary>", key(i), escape(&method.label));
        all += &head(
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
            let estimated = c.estimated.iter().sum::<f64>() / c.estimated.len() as f64;
            let cells = [
                duration(c.seconds),
                duration(c.wall),
                amount(c.rays),
                amount(c.photons),
                root(c.square()),
                root(c.noise2),
                root(c.bias2),
                if c.estimated.is_empty() { "–".to_owned() } else { root(estimated) },
                figure(c.rmse),
                figure(c.flip),
            ];
            let _ = write!(all, "<tr><th scope=\"row\">{}</th>", c.passes);
            cells.iter().for_each(|cell| all += &format!("<td class=\"n\">{}</td>", escape(cell)));
            all += "</tr>\n";
        }
        all += END;
        all += "</details>\n";
    }
    all
}

/// Slopes of one method beside theory.
pub(super) fn slopes(method: &crate::study::methods::MethodResult, judged: &super::analysis::MethodAnalysis) -> String {
    let Some(fit) = &judged.fit else { return String::new() };
    let mut table = head(&["", "over passes", "over time", "theory"], 1);
    for (name, slopes, quantity) in [
        ("error", fit.error, Quantity::Error),
        ("noise", fit.noise, Quantity::Noise),
        ("bias", fit.bias, Quantity::Bias),
    ] {
        let by_time = slopes.map(|s| Slopes { by_passes: s.by_time, ..s });
        let _ = writeln!(
            table,
            "<tr><th scope=\"row\">{name}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            slope(slopes),
            slope(by_time),
            law_text(judged.law(method, quantity))
        );
    }
    table + END
}
