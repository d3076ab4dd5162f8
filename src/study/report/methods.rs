//! What accuracy costs in time: a study of methods as a page, and as data.

mod analysis;
mod data;
mod figures;
mod tables;

pub use data::{csv, json, markdown};

use super::html::escape;
use super::text::{duration, error};
use crate::study::StudyError;
use crate::study::methods::MethodsFound;
use analysis::Analysis;
use std::fmt::Write;

const STYLE: &str = include_str!("methods/page.css");
const SCRIPT: &str = include_str!("methods/flip.js");

/// Least part of the threads' time at which times are worth telling.
const QUIET: f64 = 0.9;

/// Errors so many times that of the truth are free of it: 1/3² is a ninth of the square, 6 % of the root.
const CLEAR: f64 = 3.0;

/// The page, as HTML that is well-formed XML too. It holds its pictures, its style and a short script for turning from one picture to the next, and needs nothing
/// else; without scripts the pictures are below each other.
///
/// # Errors
/// [`StudyError`] where a picture cannot be encoded, or the pictures of the methods differ in size from the truth.
pub fn html(found: &MethodsFound) -> Result<String, StudyError> {
    let analysis = Analysis::of(found);
    let scene = escape(&found.scene);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>Accuracy and time: {scene}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>What accuracy costs in time: {scene}</h1>\n"
    );
    page += &about(found);
    for warning in warnings(found) {
        let _ = writeln!(page, "<p class=\"warning\" role=\"note\">{}</p>", escape(&warning));
    }
    if let Some((words, command)) = analysis.advice(found) {
        let _ = writeln!(
            page,
            "<section class=\"advice\"><h2>To render with</h2>\n<p>{}</p>\n{}</section>",
            escape(&words),
            block(&command)
        );
    }
    page += "<h2>Error against time</h2>\n";
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

/// What the words mean.
const READING: &str = "<h2>How to read this</h2>\n\
<p>Errors are relative: the root of the mean squared difference to the truth, each pixel in the light around it and in that of a typical \
pixel. Noise is what differs between seeds; bias is what all seeds have in common and the truth has not. Squares add up: error² = noise² + bias². \
Time is processor time of all threads, without preparation, mean over seeds.</p>\n\
<p>Slopes are those of straight lines in the plots, by least squares over the checkpoints that have at least a sixteenth of the last one&#39;s \
passes; the interval holds 95 %, by drawing seeds anew a thousand times. Theory is that of independent passes: noise falls as n<sup>−½</sup>, or where radii \
shrink as n<sup>−⅓</sup> in the end; bias stays where radii stay.</p>\n";

fn block(command: &str) -> String {
    format!("<pre tabindex=\"0\"><code>{}</code></pre>\n", escape(command))
}

fn about(found: &MethodsFound) -> String {
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
    list + "</dl>\n<p class=\"again\">The same again:</p>\n" + &block(&found.command)
}

/// What makes the figures doubtful.
fn warnings(found: &MethodsFound) -> Vec<String> {
    let mut warnings = Vec::new();
    if found.interrupted {
        warnings.push("The study was interrupted: the methods may have had less than their time.".to_owned());
    }
    if found.share < QUIET {
        warnings.push(format!(
            "Other programs were busy: the processor gave this one {:.0} % of its threads' time at worst. Times on the wall are too long, and processor \
             time may be too.",
            100.0 * found.share
        ));
    }
    if let Some(truth) = found.truth.error {
        let close = |m: &&crate::study::methods::MethodFound| {
            m.checkpoints.last().is_some_and(|c| c.square() < CLEAR * CLEAR * truth * truth)
        };
        let labels: Vec<&str> = found.methods.iter().filter(close).map(|m| m.label.as_str()).collect();
        if !labels.is_empty() {
            warnings.push(format!(
                "The truth itself has an error of about {}, and {} below {CLEAR} times that: its bias may be theirs. Longer references would tell.",
                error(truth),
                match labels.as_slice() {
                    [one] => format!("that of {one} is"),
                    many => format!("those of {} are", many.join(", ")),
                }
            ));
        }
    }
    warnings
}
