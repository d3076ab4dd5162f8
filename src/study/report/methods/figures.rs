//! Figures of a page: plots, pictures and maps, each with its command.

use super::analysis::{Analysis, MethodAnalysis};
use super::tables::{key, root, slopes};
use crate::image::{Image, RelativeScale};
use crate::integrate::Algorithm;
use crate::study::StudyError;
use crate::study::methods::fit::{Quantity, mean_interval};
use crate::study::methods::{Checkpoint, MethodResult, MethodStudyResult};
use crate::study::report::html::{escape, picture};
use crate::study::report::maps::{
    LEAST, difference_map, error_map, largest_error_windows, ramp, relative_differences, scale_end, signed_ramp,
};
use crate::study::report::picture::{png, stops_text, visible_exposure};
use crate::study::report::svg::{Guide, Plot, Series, Stroke, plot};
use crate::study::report::text::{duration, error, figure, slope};
use glam::Vec3;
use std::fmt::Write;

/// Number of crops.
const CROPS: usize = 2;

/// Magnification of a crop.
const ENLARGED: u32 = 4;

/// HTML figure with caption and command.
fn figure_html(class: &str, label: &str, what: &str, caption: &str, command: &str) -> String {
    let label = if label.is_empty() { String::new() } else { format!(" data-label=\"{}\"", escape(label)) };
    format!(
        "<figure class=\"{class}\"{label}>{what}\n<figcaption>{}<code class=\"command\">{}</code></figcaption></figure>\n",
        escape(caption),
        escape(command)
    )
}

fn image_size(image: &Image) -> (u32, u32) {
    (image.width(), image.height())
}

fn points(method: &MethodResult, square: fn(&Checkpoint) -> f64) -> Vec<(f64, f64)> {
    method.checkpoints.iter().map(|c| (c.seconds, square(c).max(0.0).sqrt())).collect()
}

/// Plot of the errors of all methods over time.
pub(super) fn main_plot(found: &MethodStudyResult) -> String {
    let bars = |method: &MethodResult| {
        method
            .checkpoints
            .iter()
            .map(|c| mean_interval(&c.squares).map(|ends| ends.map(|e| e.max(0.0).sqrt())))
            .collect()
    };
    let one = |(style, method): (usize, &MethodResult)| Series {
        label: method.label.clone(),
        style,
        stroke: Stroke::Solid,
        points: points(method, Checkpoint::square),
        bars: bars(method),
    };
    let series: Vec<Series> = found.methods.iter().enumerate().map(one).collect();
    let all = || series.iter().flat_map(|s| s.points.iter()).filter(|p| p.0 > 0.0 && p.1 > 0.0);
    let first = all().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let most = all().map(|p| p.1).fold(0.0, f64::max);
    // The guides lie above the measured lines, to be distinct from them.
    let guide =
        |slope: f64, label: &str| Guide { label: label.into(), slope, through: (first, 1.6 * most), below: false };
    let ends: Vec<String> = found
        .methods
        .iter()
        .filter_map(|m| Some((m, m.checkpoints.last()?)))
        .map(|(m, last)| format!("{}: {} after {}", m.label, root(last.square()), duration(last.seconds)))
        .collect();
    let words = format!(
        "Log-log plot of relative error over processor time, one line per method. At the ends: {}.",
        ends.join("; ")
    );
    let guides = vec![guide(-0.5, "slope −1/2"), guide(-1.0 / 3.0, "slope −1/3")];
    let drawn = Plot { id: "errors", title: "Error over time", words: &words, size: (900.0, 480.0), series, guides };
    let Some(svg) = plot(&drawn) else { return "<p>No error is large enough to be measured.</p>\n".to_owned() };
    let caption = "Relative error over processor time without setup, with 95 % intervals. Grey: slopes of noise (−1/2) \
                   and of noise and bias with shrinking radii (−1/3).";
    figure_html("plot main", "", &svg, caption, &found.command)
}

fn small_plot(i: usize, method: &MethodResult, judged: &MethodAnalysis) -> Option<String> {
    let line = |label: &str, stroke, square: fn(&Checkpoint) -> f64| Series {
        label: label.into(),
        style: i,
        stroke,
        points: points(method, square),
        bars: Vec::new(),
    };
    let series = vec![
        line("error", Stroke::Solid, Checkpoint::square),
        line("noise", Stroke::Dashed, |c| c.noise2),
        line("bias", Stroke::Dotted, |c| c.bias2),
    ];
    let last = method.checkpoints.last()?;
    let guide = |quantity: Quantity, name: &str, square: f64| {
        let law = judged.law(method, quantity)?;
        // The guide lies below its line, which would hide it.
        let through = (last.seconds, 0.8 * square.max(0.0).sqrt());
        Some(Guide { label: format!("{name} {}", slope(law.flattest)), slope: law.flattest, through, below: true })
    };
    let noise = guide(Quantity::Noise, "noise", last.noise2);
    // If noise hides the bias, there is no guide.
    let bias = guide(Quantity::Bias, "bias", last.bias2).filter(|_| last.bias2 > 0.1 * last.square());
    let title = format!("Error, noise and bias of {}", method.label);
    let words = format!(
        "Logarithmic. At the end after {}: error {}, noise {}, bias {}. {}.",
        duration(last.seconds),
        root(last.square()),
        root(last.noise2),
        root(last.bias2),
        judged.verdict
    );
    let id = format!("falls-{i}");
    let guides = noise.into_iter().chain(bias).collect();
    plot(&Plot { id: &id, title: &title, words: &words, size: (520.0, 340.0), series, guides })
}

/// The truth and all pictures, to be flipped in place.
pub(super) fn flip(found: &MethodStudyResult) -> Result<String, StudyError> {
    let exposed = visible_exposure(&found.truth.picture).unwrap_or(0.0);
    let mut flip = "<div id=\"pictures\">\n<div id=\"flip-buttons\" role=\"group\" aria-label=\"Picture\" hidden=\"hidden\"></div>\n<div id=\"flip\">\n".to_owned();
    let mut add = |label: &str, image: &Image, caption: &str, command: &str| -> Result<(), StudyError> {
        let shown = picture(&png(image, exposed)?, image_size(image), label);
        flip +=
            &figure_html("picture", label, &shown, &format!("{caption}; exposure {}.", stops_text(exposed)), command);
        Ok(())
    };
    add("truth", &found.truth.picture, &format!("The truth: {}", found.truth.source), &found.command)?;
    for method in &found.methods {
        let last = method.checkpoints.last();
        let summary = last.map_or(String::new(), |c| {
            format!(", {} passes, {}: error {}", c.passes, duration(c.seconds), root(c.square()))
        });
        add(&method.label, &method.picture, &format!("{}{summary}", method.label), &method.command)?;
    }
    Ok(
        flip + "</div>\n<p>Arrow keys turn to the next; <code>#show=</code> and a label after the page&#39;s address open it at one.</p>\n</div>\n"
    )
}

/// Enlarged crops where errors are largest.
pub(super) fn crops(found: &MethodStudyResult) -> Result<String, StudyError> {
    let mut crops = String::new();
    for window in largest_error_windows(&found.methods, CROPS) {
        let truth = window.of(&found.truth.picture)?;
        let exposed = visible_exposure(&truth).unwrap_or(0.0);
        let place = format!(
            "columns {} to {}, rows {} to {}",
            window.x,
            window.x + window.width - 1,
            window.y,
            window.y + window.height - 1
        );
        if crops.is_empty() {
            let _ = writeln!(
                crops,
                "<h2>Where errors are largest</h2>\n<p>Windows with the largest squared errors, each method relative to its mean, enlarged {ENLARGED} times.</p>"
            );
        }
        let _ =
            writeln!(crops, "<h3>In {place}</h3>\n<p>Exposure {}.</p>\n<div class=\"pictures\">", stops_text(exposed));
        let size = (window.width * ENLARGED, window.height * ENLARGED);
        let mut add = |label: &str, image: &Image, command: &str| -> Result<(), StudyError> {
            let shown = picture(&png(image, exposed)?, size, &format!("{label}, {place}"));
            crops += &figure_html("crop", "", &shown, label, command);
            Ok(())
        };
        add("truth", &truth, &found.command)?;
        for method in &found.methods {
            add(&method.label, &window.of(&method.picture)?, &method.command)?;
        }
        crops += "</div>\n";
    }
    Ok(crops)
}

/// Legend: a colour bar with labels.
fn legend(id: &str, ramp: impl Fn(f64) -> Vec3, ticks: &[(f64, String)]) -> String {
    const STOPS: u32 = 24;
    let mut svg = format!(
        "<svg class=\"legend\" role=\"img\" aria-labelledby=\"{id}-title\" viewBox=\"0 0 360 40\" width=\"360\" height=\"40\">\
        <title id=\"{id}-title\">Scale of colours</title><linearGradient id=\"{id}\">"
    );
    for i in 0..=STOPS {
        let part = f64::from(i) / f64::from(STOPS);
        let [r, g, b] = ramp(part).to_array().map(|c| (255.0 * srgb_encoded(c)) as u8);
        let _ = write!(svg, "<stop offset=\"{part:.4}\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>");
    }
    let _ = write!(
        svg,
        "</linearGradient><rect x=\"30\" y=\"4\" width=\"300\" height=\"14\" fill=\"url(#{id})\" stroke=\"#8888\"/>"
    );
    for (part, text) in ticks {
        let _ = write!(
            svg,
            "<text class=\"tick\" text-anchor=\"middle\" x=\"{:.1}\" y=\"34\">{}</text>",
            30.0 + 300.0 * part,
            escape(text)
        );
    }
    svg + "</svg>\n"
}

/// sRGB bytes of linear light (IEC 61966-2-1).
fn srgb_encoded(linear: f32) -> f32 {
    let signal = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 };
    signal + 0.5 / 255.0
}

/// One article per method: slopes, and maps on shared scales.
pub(super) fn articles(found: &MethodStudyResult, analysis: &Analysis) -> Result<String, StudyError> {
    let weights = RelativeScale::from_image(&found.truth.picture);
    let differences: Vec<Vec<f64>> =
        found.methods.iter().map(|m| relative_differences(&m.difference, &weights)).collect();
    let most_error = scale_end(found.methods.iter().flat_map(|m| m.error.iter().map(|e| f64::from(*e))));
    let most_difference = scale_end(differences.iter().flatten().map(|d| d.abs()));
    let mut all = "<p>All methods share the scales of their maps. Error by decades; dark is small:</p>\n".to_owned();
    if let Some(most) = most_error {
        let ticks = [LEAST, LEAST.sqrt(), 1.0].map(|part| error(part * most));
        all += &legend("ramp-errors", ramp, &[0.0, 0.5, 1.0].into_iter().zip(ticks).collect::<Vec<_>>());
    }
    if let Some(most) = most_difference {
        all += "<p>Mean difference to the truth: blue is too dark, orange is too bright, black is equal:</p>\n";
        let ticks = [format!("−{}", error(most)), "0".to_owned(), format!("+{}", error(most))];
        all += &legend(
            "ramp-differences",
            |t| signed_ramp(2.0 * t - 1.0),
            &[0.0, 0.5, 1.0].into_iter().zip(ticks).collect::<Vec<_>>(),
        );
    }
    for (i, ((method, judged), difference)) in found.methods.iter().zip(&analysis.methods).zip(&differences).enumerate()
    {
        let label = escape(&method.label);
        let _ = writeln!(
            all,
            "<article id=\"method-{i}\">\n<h3>{}{label}</h3>\n<p>{}.{}</p>",
            key(i),
            escape(&judged.verdict.to_string()),
            escape(&radii(method))
        );
        all += &slopes(method, judged);
        all += "<div class=\"pictures\">\n";
        if let Some(svg) = small_plot(i, method, judged) {
            let caption =
                "Error, noise (dashed) and bias (dotted) over processor time. Grey: slopes by theory, moved down.";
            all += &figure_html("plot", "", &svg, caption, &found.command);
        }
        if let Some(most) = most_error {
            let map = error_map(method, most)?;
            let shown =
                picture(&png(&map, 0.0)?, image_size(&map), &format!("map of the relative error of {}", method.label));
            all += &figure_html(
                "map",
                "",
                &shown,
                &format!(
                    "Relative error of each pixel, mean over seeds, from {} to {}.",
                    error(LEAST * most),
                    error(most)
                ),
                &method.command,
            );
        }
        if let Some(most) = most_difference {
            let map = difference_map(method, difference, most)?;
            let shown = picture(
                &png(&map, 0.0)?,
                image_size(&map),
                &format!("map of the relative difference of {} to the truth", method.label),
            );
            all += &figure_html(
                "map",
                "",
                &shown,
                &format!("Relative difference to the truth, mean over seeds, up to ±{}.", error(most)),
                &method.command,
            );
        }
        all += "</div>\n</article>\n";
    }
    Ok(all)
}

fn radii(method: &MethodResult) -> String {
    let Some([global, caustic]) = method.radii.map(|radii| radii.map(f64::from)) else { return String::new() };
    let law = if method.algorithm == Algorithm::Pm || method.alpha >= 1.0 {
        "fixed".to_owned()
    } else {
        format!("shrinking with α = {}", figure(method.alpha))
    };
    format!(
        " Largest radii of the first pass: {} of the global map, {} of the caustic map; {law}.",
        figure(global),
        figure(caustic)
    )
}
