//! Report of a study of methods, as a page and as data.

mod analysis;
mod data;
mod figures;
mod tables;
mod warnings;

pub use data::{csv, json, markdown};

use super::html::escape;
use super::text::{duration, error};
use crate::study::StudyError;
use crate::study::methods::MethodStudyResult;
use analysis::Analysis;
use std::fmt::Write;
use warnings::warnings;

const STYLE: &str = include_str!("methods/page.css");
const SCRIPT: &str = include_str!("methods/flip.js");

/// HTML page, also well-formed XML. It contains its pictures, style and a short script, and needs
/// no other file. Without scripts the pictures stand below each other.
///
/// # Errors
/// [`StudyError`] if a picture cannot be encoded, or differs in size from the truth.
pub fn html(found: &MethodStudyResult) -> Result<String, StudyError> {
    let analysis = Analysis::of(found);
    let scene = escape(&found.scene);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>Error over time: {scene}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Error over time: {scene}</h1>\n"
    );
    page += &about(found);
    for warning in warnings(found) {
        let _ = writeln!(page, "<p class=\"warning\" role=\"note\">{}</p>", escape(&warning));
    }
    if let Some((words, command)) = analysis.advice(found) {
        let _ = writeln!(
            page,
            "<section class=\"advice\"><h2>Recommendation</h2>\n<p>{}</p>\n{}</section>",
            escape(&words),
            block(&command)
        );
    }
    page += "<h2>Error over time</h2>\n";
    page += &figures::main_plot(found);
    page += "<h2>Verdicts</h2>\n";
    page += &tables::verdicts(found, &analysis);
    page += "<h2>Time to reach an error</h2>\n";
    page += &tables::reaches(found, &analysis);
    page += "<h2>Pictures</h2>\n";
    page += &figures::flip(found)?;
    page += &figures::crops(found)?;
    page += "<h2>Method by method</h2>\n";
    page += &figures::articles(found, &analysis)?;
    page += "<h2>All figures</h2>\n";
    page += &tables::checkpoints(found);
    page += READING;
    let _ = write!(page, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    Ok(page)
}

/// Explanation of the terms.
const READING: &str = "<h2>How to read this</h2>\n\
<p>Errors are relative: the root of the mean squared difference to the truth, divided by local radiance and that of a typical \
pixel. Noise differs between seeds; bias is common to all seeds. error² = noise² + bias². \
Time is processor time of all threads without setup, mean over seeds.</p>\n\
<p>Slopes are least-squares lines in the plots, over checkpoints with at least a sixteenth of the last one&#39;s \
passes. Intervals are 95 %, from a thousand resamplings of the seeds. In theory, noise of independent passes falls as n<sup>−½</sup>, \
with shrinking radii as n<sup>−⅓</sup> in the end; bias stays with fixed radii.</p>\n";

fn block(command: &str) -> String {
    format!("<pre tabindex=\"0\"><code>{}</code></pre>\n", escape(command))
}

fn about(found: &MethodStudyResult) -> String {
    let truth = found.truth.error.map_or(String::new(), |e| format!(", its own error about {}", error(e)));
    let size = format!("{} × {} pixels", found.truth.picture.width(), found.truth.picture.height());
    let seeds = format!("{} of each method, up to {} of processor time each", found.seeds, duration(found.budget));
    let mut list = "<dl>\n".to_owned();
    for (term, text) in [
        ("Scene", format!("{}, {size}", found.scene)),
        ("Seeds", seeds),
        ("Truth", format!("{}{truth}", found.truth.source)),
        ("Program", found.program.clone()),
        ("Machine", found.machine.clone()),
    ] {
        let _ = writeln!(list, "<dt>{term}</dt><dd>{}</dd>", escape(&text));
    }
    list + "</dl>\n<p class=\"again\">Command:</p>\n" + &block(&found.command)
}
