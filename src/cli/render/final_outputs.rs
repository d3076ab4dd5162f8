//! Outputs that are written after a render has ended.

use super::summary::print_render_summary;
use crate::cli::diagnostics::{black_picture_note, no_photon_stored_note};
use crate::cli::film::LockedFilmFile;
use crate::cli::outputs::OutputFailures;
use crate::cli::pictures::{default_tone_curve, write_pictures};
use crate::cli::progress::{ProgressDisplay, print_message, warn_of_rejected_samples};
use crate::cli::report::{RenderReport, RenderSetup};
use crate::cli::value_parsers::count_with_noun;
use crate::cli::{CommandFailure, Exit, RenderArguments};
use crate::image::{self, Image, WriteOptions};
use crate::integrate::SurfaceAovs;
use crate::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
use crate::render::{EndReason, RenderLimits, RenderResult, StopCriteria, picture_layers, surface_layers};
use glam::Vec3;

/// Outputs that are written after a render has ended: picture, layers, film and statistics.
pub(super) struct RenderOutputs<'a> {
    pub arguments: &'a RenderArguments,
    pub rendered: &'a RenderResult,
    /// Albedo, normal and other surface AOVs for `--aov`; `None` without this flag, or if the user
    /// cancelled their computation.
    pub aovs: Option<SurfaceAovs>,
    /// Film file of the render; `None` without `--film`.
    pub film_file: Option<&'a LockedFilmFile<'a>>,
}

impl RenderOutputs<'_> {
    /// Writes all outputs and prints a summary. If an output cannot be written, the others still
    /// are.
    ///
    /// `limits` are the limits of the command line, and `stop` the stop criteria made from them.
    /// `lights_are_black` is true if the scene has lights, but none has any power.
    pub fn write(
        &self,
        progress: &ProgressDisplay,
        setup: RenderSetup,
        limits: &RenderLimits,
        stop: &StopCriteria<'_>,
        lights_are_black: bool,
    ) -> Result<Exit, CommandFailure> {
        let Self { arguments, rendered, film_file: film, .. } = *self;
        let (width, height) = rendered.film.size();
        let picture =
            Image::from_pixels(width, height, rendered.film.mean_picture()).map_err(CommandFailure::output_error)?;
        let mut failures = OutputFailures::default();
        self.write_pictures(progress, &picture, &mut failures);
        if let (Some(path), Some(film)) = (&arguments.film, film)
            && failures.ok_or_collect_error(film.save(rendered)).is_some()
        {
            progress.print_line(&format!("wrote {}", path.display()));
        }
        warn_of_rejected_samples(&rendered.counters);
        if picture.pixels().iter().all(|p| *p == Vec3::ZERO) {
            progress.print_line(black_picture_note(setup.lights, lights_are_black));
        }
        no_photon_stored_note(rendered).iter().for_each(|line| progress.print_line(line));
        let report = RenderReport::new(setup, limits, stop, rendered);
        print_render_summary(limits, stop, progress, &report, rendered);
        if let Some(path) = &arguments.stats {
            let json = serde_json::to_vec_pretty(&report).map_err(CommandFailure::output_error)?;
            failures.ok_or_collect_error(image::replace_file(path, &json));
        }
        failures.into_result(if rendered.end_reason == EndReason::Interrupted {
            Exit::Interrupted
        } else {
            Exit::Success
        })
    }

    /// Writes the files of `-o` and `--aov`. Collects errors in `failures`.
    fn write_pictures(&self, progress: &ProgressDisplay, picture: &Image, failures: &mut OutputFailures) {
        let Self { arguments, rendered, ref aovs, .. } = *self;
        let options = write_options(arguments);
        write_pictures(arguments.output.iter(), picture, &options, progress, failures);
        let Some(path) = &arguments.aov else { return };
        let passes = rendered.film.passes();
        if passes < MIN_ERROR_ESTIMATE_PASSES && rendered.estimator.is_some() {
            let passes = count_with_noun(passes as usize, "pass gives", "passes give");
            print_message(&format!("warning: {passes} no error estimate: {} has no maps of it", path.display()));
        }
        let mut layers = picture_layers(rendered);
        layers.extend(aovs.iter().flat_map(surface_layers));
        let written = image::write_layers(path, rendered.film.size(), &layers, &options.metadata);
        if let Some(non_finite) = failures.ok_or_collect_error(written) {
            progress.print_line(&format!("wrote {}", path.display()));
            if non_finite > 0 {
                let values = count_with_noun(non_finite, "value", "values");
                let path = path.display();
                print_message(&format!("warning: {values} of {path} exceed single precision: the scene is too bright"));
            }
        }
    }
}

/// Returns the options with which the files of `-o` and `--aov` are written.
pub(super) fn write_options(arguments: &RenderArguments) -> WriteOptions {
    arguments.pictures.write_options(default_tone_curve(arguments.method.integrator))
}
