//! Summary lines about a scene before its render, and about the render at its end.

use crate::cli::diagnostics::all_lights_are_black;
use crate::cli::forecast_text;
use crate::cli::progress::{ProgressDisplay, print_message};
use crate::cli::report::{EstimatedErrorReport, RenderReport};
use crate::cli::value_parsers::count_with_noun;
use crate::render::{EndReason, RenderLimits, RenderResult, StopCriteria};
use crate::scene::Scene;
use crate::study::text::percent_text;

/// Prints the name of the scene and its numbers of triangles, shapes and lights. Prints a note if
/// the scene has no objects, or no light with any power.
pub(super) fn print_scene_summary(name: &str, scene: &Scene, progress: &ProgressDisplay) {
    let (triangles, shapes, lights) = (scene.triangle_count(), scene.analytic_shape_count(), scene.lights().len());
    progress.print_line(&format!(
        "{name}: {}, {}, {}",
        count_with_noun(triangles, "triangle", "triangles"),
        count_with_noun(shapes, "shape", "shapes"),
        count_with_noun(lights, "light", "lights")
    ));
    if triangles + shapes == 0 {
        progress.print_line("note: the scene has no objects: the picture shows only the background");
    } else if lights == 0 {
        progress.print_line("note: the scene has no lights: all objects are black");
    } else if all_lights_are_black(scene) {
        progress.print_line("note: no light of the scene has any power: all objects are black");
    }
}

/// Prints the number and time of the passes, and the rates of rays and photon paths. Also prints
/// why the render ended, the estimated error, and the fraction of light that clamping removed.
pub(super) fn print_render_summary(
    limits: &RenderLimits,
    stop: &StopCriteria<'_>,
    progress: &ProgressDisplay,
    report: &RenderReport,
    rendered: &RenderResult,
) {
    let n = rendered.film.passes();
    let why = match rendered.end_reason {
        EndReason::Passes => String::new(),
        EndReason::Time => format!("; time was up: --passes {n} repeats this picture bit for bit"),
        EndReason::Target => format!("; the error is low enough: --passes {n} repeats this picture bit for bit"),
        EndReason::BiasFloor => "; more passes cannot reach the error".to_owned(),
        EndReason::Interrupted => format!("; interrupted: --passes {n} repeats this picture"),
    };
    progress.print_line(&format!(
        "{} in {:.1} s, {:.2} M rays/s, {:.2} M photon paths/s{why}",
        count_with_noun(report.passes as usize, "pass", "passes"),
        report.seconds.render,
        report.rates.rays_per_second * 1e-6,
        report.rates.photon_paths_per_second * 1e-6,
    ));
    if let Some(fraction) = report.clamped_fraction {
        progress.print_line(&format!("clamping removed {} of the light", percent_text(fraction)));
    }
    if let Some(EstimatedErrorReport { estimate, interval_confidence: confidence, .. }) = &report.error {
        let interval = format!("{} to {}", percent_text(estimate.low), percent_text(estimate.high));
        let confidence = percent_text(confidence.probability());
        progress.print_line(&format!(
            "estimated error {}; {interval} with {confidence} confidence",
            forecast_text::error_text(estimate)
        ));
    }
    if limits.are_default() {
        default_end_line(stop, rendered.end_reason).iter().for_each(|line| progress.print_line(line));
    }
    let remaining_bias = report.error.as_ref().and_then(|error| error.largest_remaining_bias);
    if let (EndReason::BiasFloor, Some(part)) = (rendered.end_reason, remaining_bias) {
        print_message(&format!("warning: the rest is bias; {}", forecast_text::bias_remedy(part)));
    }
}

/// Returns a line that says which default limit ended a render: error, time or bias. Returns `None`
/// if the user or a limit of passes ended the render. Also returns `None` if `stop` has no error
/// target or no time limit.
fn default_end_line(stop: &StopCriteria<'_>, end_reason: EndReason) -> Option<String> {
    let (target, time) = (stop.target?, stop.time_limit?);
    let error = percent_text(target.error);
    let confidence = percent_text(target.confidence.probability());
    let time = forecast_text::duration_text(time.as_secs_f64());
    match end_reason {
        EndReason::Target => Some(format!(
            "ended by error: at most {error} with {confidence} confidence. --target-error sets another error"
        )),
        EndReason::Time => Some(format!(
            "ended by time: the limit of {time} came before the error fell to {error}. --time sets another time"
        )),
        EndReason::BiasFloor => Some(format!("ended by bias: more passes cannot lower the error to {error}")),
        EndReason::Passes | EndReason::Interrupted => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::ErrorTarget;
    use crate::render::error_estimate::Confidence;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;

    #[test]
    fn default_end_line_names_the_limit() {
        let interrupted = AtomicBool::new(false);
        let target = Some(ErrorTarget { error: 0.03, confidence: Confidence::default() });
        let stop = StopCriteria {
            target,
            time_limit: Some(Duration::from_secs(300)),
            ..StopCriteria::unlimited(&interrupted)
        };
        let line = |ended| default_end_line(&stop, ended);
        let begins = |ended, text: &str| line(ended).is_some_and(|line| line.starts_with(text));
        assert!(begins(EndReason::Target, "ended by error: at most 3.0 %"));
        assert!(begins(EndReason::Time, "ended by time: the limit of 5 min 0 s came before the error fell to 3.0 %"));
        assert!(begins(EndReason::BiasFloor, "ended by bias: "));
        assert_eq!(line(EndReason::Passes).or(line(EndReason::Interrupted)), None);
    }
}
