//! HTML report of a study of methods; submodule `csv_json_markdown` has CSV, JSON and Markdown.

mod analysis;
mod csv_json_markdown;
mod figures;
mod tables;
mod warnings;

pub use csv_json_markdown::{csv_report, markdown_report, method_study_json};

use super::html::escape_html;
use super::text::{duration_text, error_percent_text};
use crate::study::StudyError;
use crate::study::methods::MethodStudyResult;
use analysis::MethodStudyAnalysis;
use std::fmt::Write;
use warnings::study_warnings;

const STYLE: &str = include_str!("methods/page.css");
const SCRIPT: &str = include_str!("methods/flip.js");

/// Returns the report of a study of methods as an HTML page, which is also well-formed XML.
///
/// The page contains its pictures, styles and a short script, and needs no other file. Without
/// scripts, the pictures are shown one below the other.
///
/// # Errors
/// [`StudyError`] if a picture cannot be encoded, or differs in size from the reference.
pub fn methods_html_page(result: &MethodStudyResult) -> Result<String, StudyError> {
    let analysis = MethodStudyAnalysis::new(result);
    let scene = escape_html(&result.scene_path);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>Error over time: {scene}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Error over time: {scene}</h1>\n"
    );
    page += &study_summary_html(result);
    for warning in study_warnings(result) {
        let _ = writeln!(page, "<p class=\"warning\" role=\"note\">{}</p>", escape_html(&warning));
    }
    if let Some((words, command)) = analysis.recommendation_text(result) {
        let _ = writeln!(
            page,
            "<section class=\"advice\"><h2>Recommendation</h2>\n<p>{}</p>\n{}</section>",
            escape_html(&words),
            command_block_html(&command)
        );
    }
    page += "<h2>Error over time</h2>\n";
    page += &figures::error_plot_html(result);
    page += "<h2>Verdicts</h2>\n";
    page += &tables::verdicts_table_html(result, &analysis);
    page += "<h2>Time to reach an error</h2>\n";
    page += &tables::times_table_html(result, &analysis);
    page += "<h2>Pictures</h2>\n";
    page += &figures::picture_switcher_html(result)?;
    page += &figures::error_crops_html(result)?;
    page += "<h2>Method by method</h2>\n";
    page += &figures::method_articles_html(result, &analysis)?;
    page += "<h2>All figures</h2>\n";
    page += &tables::checkpoint_tables_html(result);
    page += READING_GUIDE_HTML;
    let _ = write!(page, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    Ok(page)
}

/// Explanation of errors and slopes at the end of the page.
const READING_GUIDE_HTML: &str = "<h2>How to read this</h2>\n\
<p>Errors are relative: the root of the mean squared difference to the reference, divided by local radiance and that of a typical \
pixel. Noise differs between seeds; bias is common to all seeds. error² = noise² + bias². \
Time is processor time of all threads without setup, mean over seeds.</p>\n\
<p>Slopes are least-squares lines in the plots, over checkpoints with at least a sixteenth of the last one&#39;s \
passes. Intervals are 95 %, from a thousand resamplings of the seeds. In theory, noise of independent passes falls as n<sup>−½</sup>, \
with shrinking radii as n<sup>−⅓</sup> in the end; bias stays with fixed radii.</p>\n";

fn command_block_html(command: &str) -> String {
    format!("<pre tabindex=\"0\"><code>{}</code></pre>\n", escape_html(command))
}

fn study_summary_html(result: &MethodStudyResult) -> String {
    let own_error =
        result.reference.error.map_or(String::new(), |e| format!(", its own error about {}", error_percent_text(e)));
    let size = format!("{} × {} pixels", result.reference.picture.width(), result.reference.picture.height());
    let seeds = format!(
        "{} of each method, up to {} of processor time each",
        result.seeds,
        duration_text(result.max_cpu_seconds_per_seed)
    );
    let mut list = "<dl>\n".to_owned();
    for (term, text) in [
        ("Scene", format!("{}, {size}", result.scene_path)),
        ("Seeds", seeds),
        ("Reference", format!("{}{own_error}", result.reference.source)),
        ("Program", result.program.clone()),
        ("Machine", result.machine.clone()),
    ] {
        let _ = writeln!(list, "<dt>{term}</dt><dd>{}</dd>", escape_html(&text));
    }
    list + "</dl>\n<p class=\"again\">Command:</p>\n" + &command_block_html(&result.study_command)
}
