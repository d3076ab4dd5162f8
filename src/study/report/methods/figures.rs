//! Figures of the HTML page about a study of methods: plots, pictures and error maps. Each figure
//! has a shell command that repeats it.

use super::analysis::{MethodAnalysis, MethodStudyAnalysis};
use super::tables::{method_marker_svg, slopes_table_html};
use crate::image::{Image, RelativeErrorWeights};
use crate::integrate::Algorithm;
use crate::study::StudyError;
use crate::study::methods::fit::{ErrorComponent, mean_confidence_interval};
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult};
use crate::study::report::html::{escape_html, inline_png};
use crate::study::report::maps::{
    RAMP_END_ERROR_RATIO, color_scale_maximum, difference_map, error_color_ramp, error_map, largest_error_windows,
    relative_differences, signed_color_ramp,
};
use crate::study::report::picture::{auto_exposure_stops, encode_png, exposure_text};
use crate::study::report::svg::{LineStyle, LogLogPlot, PlotSeries, SlopeGuideLine, plot_svg};
use crate::study::report::text::{
    duration_text, error_percent_text, slope_text, square_root_percent_text, three_digit_text,
};
use glam::Vec3;
use std::fmt::Write;

/// Number of windows in which the page shows all pictures enlarged. They are the windows with the
/// largest errors.
const CROP_COUNT: usize = 2;

/// Factor by which the page enlarges the windows of pictures in which errors are largest.
const CROP_MAGNIFICATION: u32 = 4;

/// Returns an HTML figure with three parts: the HTML `content`, the text `caption`, and the shell
/// command `command`, which repeats the render or study that the figure shows.
fn figure_html(class: &str, label: &str, content: &str, caption: &str, command: &str) -> String {
    let label = if label.is_empty() { String::new() } else { format!(" data-label=\"{}\"", escape_html(label)) };
    format!(
        "<figure class=\"{class}\"{label}>{content}\n<figcaption>{}<code class=\"command\">{}</code></figcaption></figure>\n",
        escape_html(caption),
        escape_html(command)
    )
}

/// Returns an HTML figure of an error map. `words` describe the map to readers who cannot see it.
fn map_figure_html(map: &Image, words: &str, caption: &str, command: &str) -> Result<String, StudyError> {
    let shown = inline_png(&encode_png(map, 0.0)?, image_size(map), words);
    Ok(figure_html("map", "", &shown, caption, command))
}

fn image_size(image: &Image) -> (u32, u32) {
    (image.width(), image.height())
}

fn error_plot_points(method: &MethodResult, square: fn(&ConvergenceCheckpoint) -> f64) -> Vec<(f64, f64)> {
    method.checkpoints.iter().map(|c| (c.cpu_seconds, square(c).max(0.0).sqrt())).collect()
}

/// Returns an HTML figure that plots the errors of all methods over processor time.
pub(super) fn error_plot_html(result: &MethodStudyResult) -> String {
    let bars = |method: &MethodResult| {
        method
            .checkpoints
            .iter()
            .map(|c| mean_confidence_interval(&c.relative_squared_errors).map(|ends| ends.map(|e| e.max(0.0).sqrt())))
            .collect()
    };
    let series_of = |(style, method): (usize, &MethodResult)| PlotSeries {
        label: method.label.clone(),
        series_index: style,
        stroke: LineStyle::Solid,
        points: error_plot_points(method, ConvergenceCheckpoint::mean_relative_squared_error),
        confidence_intervals: bars(method),
    };
    let series: Vec<PlotSeries> = result.methods.iter().enumerate().map(series_of).collect();
    let all = || series.iter().flat_map(|s| s.points.iter()).filter(|p| p.0 > 0.0 && p.1 > 0.0);
    let first = all().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let most = all().map(|p| p.1).fold(0.0, f64::max);
    // The guide lines, which show the slopes −1/2 and −1/3, start above all measured points.
    let guide = |slope: f64, label: &str| SlopeGuideLine {
        label: label.into(),
        slope,
        through: (first, 1.6 * most),
        label_below: false,
    };
    let ends: Vec<String> = result
        .methods
        .iter()
        .filter_map(|m| Some((m, m.checkpoints.last()?)))
        .map(|(m, last)| {
            format!(
                "{}: {} after {}",
                m.label,
                square_root_percent_text(last.mean_relative_squared_error()),
                duration_text(last.cpu_seconds)
            )
        })
        .collect();
    let words = format!(
        "Log-log plot of relative error over processor time, one line per method. At the ends: {}.",
        ends.join("; ")
    );
    let guides = vec![guide(-0.5, "slope −1/2"), guide(-1.0 / 3.0, "slope −1/3")];
    let drawn =
        LogLogPlot { id: "errors", title: "Error over time", alt_text: &words, size: (900.0, 480.0), series, guides };
    let Some(svg) = plot_svg(&drawn) else { return "<p>No error is large enough to be measured.</p>\n".to_owned() };
    let caption = "Relative error over processor time without setup, with 95 % intervals. Grey: slopes of noise (−1/2) \
                   and of noise and bias with shrinking radii (−1/3).";
    figure_html("plot main", "", &svg, caption, &result.study_command)
}

fn method_plot_svg(i: usize, method: &MethodResult, judged: &MethodAnalysis) -> Option<String> {
    let line = |label: &str, stroke, square: fn(&ConvergenceCheckpoint) -> f64| PlotSeries {
        label: label.into(),
        series_index: i,
        stroke,
        points: error_plot_points(method, square),
        confidence_intervals: Vec::new(),
    };
    let series = vec![
        line("error", LineStyle::Solid, ConvergenceCheckpoint::mean_relative_squared_error),
        line("noise", LineStyle::Dashed, |c| c.squared_noise),
        line("bias", LineStyle::Dotted, |c| c.squared_bias),
    ];
    let last = method.checkpoints.last()?;
    let guide = |quantity: ErrorComponent, name: &str, square: f64| {
        let law = judged.predicted_convergence_slopes(method, quantity)?;
        // Draw the guide line below the measured line, which would hide a guide line at the same
        // height.
        let through = (last.cpu_seconds, 0.8 * square.max(0.0).sqrt());
        Some(SlopeGuideLine {
            label: format!("{name} {}", slope_text(law.flattest)),
            slope: law.flattest,
            through,
            label_below: true,
        })
    };
    let noise = guide(ErrorComponent::Noise, "noise", last.squared_noise);
    // A bias that is small compared with the error is hidden by noise, so it gets no guide line.
    let bias = guide(ErrorComponent::Bias, "bias", last.squared_bias)
        .filter(|_| last.squared_bias > 0.1 * last.mean_relative_squared_error());
    let title = format!("Error, noise and bias of {}", method.label);
    let words = format!(
        "Logarithmic. At the end after {}: error {}, noise {}, bias {}. {}.",
        duration_text(last.cpu_seconds),
        square_root_percent_text(last.mean_relative_squared_error()),
        square_root_percent_text(last.squared_noise),
        square_root_percent_text(last.squared_bias),
        judged.verdict
    );
    let id = format!("falls-{i}");
    let guides = noise.into_iter().chain(bias).collect();
    plot_svg(&LogLogPlot { id: &id, title: &title, alt_text: &words, size: (520.0, 340.0), series, guides })
}

/// Returns HTML of the reference and all pictures. A script shows one of them at a time, all in the
/// same place, for comparison by flipping.
pub(super) fn picture_switcher_html(result: &MethodStudyResult) -> Result<String, StudyError> {
    let exposure_stops = auto_exposure_stops(&result.reference.picture).unwrap_or(0.0);
    let mut html = "<div id=\"pictures\">\n<div id=\"flip-buttons\" role=\"group\" aria-label=\"Picture\" hidden=\"hidden\"></div>\n<div id=\"flip\">\n".to_owned();
    let mut add = |label: &str, image: &Image, caption: &str, command: &str| -> Result<(), StudyError> {
        let shown = inline_png(&encode_png(image, exposure_stops)?, image_size(image), label);
        html += &figure_html(
            "picture",
            label,
            &shown,
            &format!("{caption}; exposure {}.", exposure_text(exposure_stops)),
            command,
        );
        Ok(())
    };
    add(
        "reference",
        &result.reference.picture,
        &format!("The reference: {}", result.reference.source),
        &result.study_command,
    )?;
    for method in &result.methods {
        let last = method.checkpoints.last();
        let summary = last.map_or(String::new(), |c| {
            format!(
                ", {} passes, {}: error {}",
                c.passes,
                duration_text(c.cpu_seconds),
                square_root_percent_text(c.mean_relative_squared_error())
            )
        });
        add(&method.label, &method.first_seed_picture, &format!("{}{summary}", method.label), &method.render_command)?;
    }
    Ok(
        html + "</div>\n<p>Arrow keys turn to the next; <code>#show=</code> and a label after the page&#39;s address open it at one.</p>\n</div>\n"
    )
}

/// Returns HTML that shows the reference and all methods' pictures enlarged, in the windows where
/// errors are largest.
pub(super) fn error_crops_html(result: &MethodStudyResult) -> Result<String, StudyError> {
    let mut crops = String::new();
    for window in largest_error_windows(&result.methods, CROP_COUNT) {
        let reference = window.crop_image(&result.reference.picture)?;
        let exposure_stops = auto_exposure_stops(&reference).unwrap_or(0.0);
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
                "<h2>Where errors are largest</h2>\n<p>Windows with the largest squared errors, each method relative to its mean, enlarged {CROP_MAGNIFICATION} times.</p>"
            );
        }
        let _ = writeln!(
            crops,
            "<h3>In {place}</h3>\n<p>Exposure {}.</p>\n<div class=\"pictures\">",
            exposure_text(exposure_stops)
        );
        let size = (window.width * CROP_MAGNIFICATION, window.height * CROP_MAGNIFICATION);
        let mut add = |label: &str, image: &Image, command: &str| -> Result<(), StudyError> {
            let shown = inline_png(&encode_png(image, exposure_stops)?, size, &format!("{label}, {place}"));
            crops += &figure_html("crop", "", &shown, label, command);
            Ok(())
        };
        add("reference", &reference, &result.study_command)?;
        for method in &result.methods {
            add(&method.label, &window.crop_image(&method.first_seed_picture)?, &method.render_command)?;
        }
        crops += "</div>\n";
    }
    Ok(crops)
}

/// Returns the SVG of a colour bar with ticks. The function `ramp` gives the linear RGB colour at
/// each position on the bar, from 0 to 1.
///
/// `ticks` are the positions on the bar with their labels.
fn color_legend_svg(id: &str, ramp: impl Fn(f64) -> Vec3, ticks: &[(f64, String)]) -> String {
    const GRADIENT_STOPS: u32 = 24;
    let mut svg = format!(
        "<svg class=\"legend\" role=\"img\" aria-labelledby=\"{id}-title\" viewBox=\"0 0 360 40\" width=\"360\" height=\"40\">\
        <title id=\"{id}-title\">Scale of colours</title><linearGradient id=\"{id}\">"
    );
    for i in 0..=GRADIENT_STOPS {
        let part = f64::from(i) / f64::from(GRADIENT_STOPS);
        let [r, g, b] = ramp(part).to_array().map(|c| (255.0 * srgb_signal_for_truncation(c)) as u8);
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
            escape_html(text)
        );
    }
    svg + "</svg>\n"
}

/// Returns the sRGB signal of a linear value (IEC 61966-2-1), plus half an 8-bit step. Truncation
/// to 8 bits then rounds to nearest.
fn srgb_signal_for_truncation(linear: f32) -> f32 {
    let signal = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 };
    signal + 0.5 / 255.0
}

/// Returns HTML articles, one per method: verdict, slopes, plot, and error maps on common scales.
pub(super) fn method_articles_html(
    result: &MethodStudyResult,
    analysis: &MethodStudyAnalysis,
) -> Result<String, StudyError> {
    let weights = RelativeErrorWeights::from_image(&result.reference.picture);
    let differences: Vec<Vec<f64>> =
        result.methods.iter().map(|m| relative_differences(&m.mean_difference, &weights)).collect();
    let most_error =
        color_scale_maximum(result.methods.iter().flat_map(|m| m.relative_pixel_errors.iter().map(|e| f64::from(*e))));
    let most_difference = color_scale_maximum(differences.iter().flatten().map(|d| d.abs()));
    let mut all = "<p>All methods share the scales of their maps. Error by decades; dark is small:</p>\n".to_owned();
    if let Some(most) = most_error {
        let ticks =
            [RAMP_END_ERROR_RATIO, RAMP_END_ERROR_RATIO.sqrt(), 1.0].map(|part| error_percent_text(part * most));
        all += &color_legend_svg(
            "ramp-errors",
            error_color_ramp,
            &[0.0, 0.5, 1.0].into_iter().zip(ticks).collect::<Vec<_>>(),
        );
    }
    if let Some(most) = most_difference {
        all += "<p>Mean difference to the reference: blue is too dark, orange is too bright, black is equal:</p>\n";
        let ticks =
            [format!("−{}", error_percent_text(most)), "0".to_owned(), format!("+{}", error_percent_text(most))];
        all += &color_legend_svg(
            "ramp-differences",
            |t| signed_color_ramp(2.0 * t - 1.0),
            &[0.0, 0.5, 1.0].into_iter().zip(ticks).collect::<Vec<_>>(),
        );
    }
    for (i, ((method, judged), difference)) in
        result.methods.iter().zip(&analysis.methods).zip(&differences).enumerate()
    {
        let label = escape_html(&method.label);
        let _ = writeln!(
            all,
            "<article id=\"method-{i}\">\n<h3>{}{label}</h3>\n<p>{}.{}</p>",
            method_marker_svg(i),
            escape_html(&judged.verdict.to_string()),
            escape_html(&gather_radii_text(method))
        );
        all += &slopes_table_html(method, judged);
        all += "<div class=\"pictures\">\n";
        if let Some(svg) = method_plot_svg(i, method, judged) {
            let caption =
                "Error, noise (dashed) and bias (dotted) over processor time. Grey: slopes by theory, moved down.";
            all += &figure_html("plot", "", &svg, caption, &result.study_command);
        }
        if let Some(most) = most_error {
            let map = error_map(method, most)?;
            let words = format!("map of the relative error of {}", method.label);
            let caption = format!(
                "Relative error of each pixel, mean over seeds, from {} to {}.",
                error_percent_text(RAMP_END_ERROR_RATIO * most),
                error_percent_text(most)
            );
            all += &map_figure_html(&map, &words, &caption, &method.render_command)?;
        }
        if let Some(most) = most_difference {
            let map = difference_map(method, difference, most)?;
            let words = format!("map of the relative difference of {} to the reference", method.label);
            let caption =
                format!("Relative difference to the reference, mean over seeds, up to ±{}.", error_percent_text(most));
            all += &map_figure_html(&map, &words, &caption, &method.render_command)?;
        }
        all += "</div>\n</article>\n";
    }
    Ok(all)
}

fn gather_radii_text(method: &MethodResult) -> String {
    let Some([indirect, caustic]) = method.gather_radii.map(|radii| radii.map(f64::from)) else { return String::new() };
    let law = if method.algorithm == Algorithm::Pm || method.alpha >= 1.0 {
        "fixed".to_owned()
    } else {
        format!("shrinking with α = {}", three_digit_text(method.alpha))
    };
    format!(
        " Largest radii of the first pass: {} of the indirect map, {} of the caustic map; {law}.",
        three_digit_text(indirect),
        three_digit_text(caustic)
    )
}
