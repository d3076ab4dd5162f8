//! Conclusions from a study of methods, which all its report formats share.

use crate::study::methods::fit::{
    ConvergenceFit, ConvergenceSlopes, ConvergenceVerdict, ErrorComponent, MAX_EXTRAPOLATION_FACTOR,
    MethodRecommendation, ParetoPoint, RenderEffort, SlopeRange, TimeToError, fit_convergence, judge_convergence,
    pareto_front, predicted_convergence_slopes, recommend_method, time_to_error, time_to_tenth_of_error,
};
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult};
use crate::study::report::text::{self, count_text, duration_text, error_percent_text, square_root_percent_text};

/// Target errors (relative): reports state how long each method takes to reach them.
pub(super) const TARGET_ERRORS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// Conclusions from a study: the convergence of each method, the Pareto front and a recommendation.
pub(super) struct MethodStudyAnalysis {
    pub(super) methods: Vec<MethodAnalysis>,
    pub(super) pareto: Vec<ParetoPoint>,
    pub(super) recommendation: Option<MethodRecommendation>,
}

/// Conclusions about one rendering method: slopes, verdict and times to reach errors.
pub(super) struct MethodAnalysis {
    pub(super) fit: Option<ConvergenceFit>,
    pub(super) verdict: ConvergenceVerdict,
    /// Time and work until the method reaches each of the relative errors [`TARGET_ERRORS`].
    pub(super) times_to_target_errors: [TimeToError; 4],
    /// Time and work until the method's error is 1/10 of its error at the last checkpoint.
    pub(super) time_to_tenth_error: TimeToError,
}

impl MethodStudyAnalysis {
    pub(super) fn new(result: &MethodStudyResult) -> Self {
        let fits: Vec<Option<ConvergenceFit>> = result.methods.iter().map(fit_convergence).collect();
        let recommendation = recommend_method(result, &fits);
        let judge = |(method, fit): (&MethodResult, Option<ConvergenceFit>)| {
            let verdict = judge_convergence(method, fit.as_ref(), result.reference.error);
            let reaches = TARGET_ERRORS.map(|e| time_to_error(method, fit.as_ref(), &verdict, e));
            MethodAnalysis {
                time_to_tenth_error: time_to_tenth_of_error(method, fit.as_ref(), &verdict),
                times_to_target_errors: reaches,
                verdict,
                fit,
            }
        };
        let methods = result.methods.iter().zip(fits).map(judge).collect();
        Self { methods, pareto: pareto_front(&result.methods), recommendation }
    }

    /// Returns a text that recommends the best method, and the shell command that renders with the
    /// method; `None` without a recommendation.
    pub(super) fn recommendation_text(&self, result: &MethodStudyResult) -> Option<(String, String)> {
        let MethodRecommendation { method_index: method, expected_error: expected, similar_method_indices: alike } =
            self.recommendation.as_ref()?;
        let (best, judged) = (&result.methods[*method], &self.methods[*method]);
        let more = match judged.time_to_tenth_error {
            TimeToError::Predicted { effort, .. } => {
                format!(" A tenth of its last error would take about {}.", duration_text(effort.cpu_seconds))
            }
            TimeToError::Never { floor } => {
                format!(" It never reaches a tenth of its last error: bias stays at {}.", error_percent_text(floor))
            }
            _ => String::new(),
        };
        let others: Vec<&str> = alike.iter().map(|i| result.methods[*i].label.as_str()).collect();
        let alike =
            if others.is_empty() { String::new() } else { format!(" Within 10 % of it: {}.", others.join(", ")) };
        let words = format!(
            "{} has the least error after {} of processor time: an error of {} is expected.{alike}{more}",
            best.label,
            duration_text(result.max_cpu_seconds_per_seed),
            error_percent_text(*expected),
        );
        Some((words, best.render_command.clone()))
    }
}

impl MethodAnalysis {
    /// Returns the range of slopes over passes that theory predicts for `quantity`, in the range of
    /// passes of the fit; `None` if nothing could be fitted, or if the quantity is zero.
    pub(super) fn predicted_convergence_slopes(
        &self,
        method: &MethodResult,
        quantity: ErrorComponent,
    ) -> Option<SlopeRange> {
        predicted_convergence_slopes(method.algorithm, quantity, &self.fit.as_ref()?.checkpoint_passes, method.alpha)
    }

    /// Returns five cells of a table of verdicts: error, noise and bias at the last checkpoint, the
    /// slope of the error over passes, and the slope that theory predicts.
    pub(super) fn verdict_cells(&self, method: &MethodResult) -> [String; 5] {
        let last = method.checkpoints.last();
        let at_end = |square: fn(&ConvergenceCheckpoint) -> f64| {
            last.map_or("–".to_owned(), |c| square_root_percent_text(square(c)))
        };
        let fit = self.fit.as_ref();
        [
            at_end(ConvergenceCheckpoint::mean_relative_squared_error),
            at_end(|c| c.squared_noise),
            at_end(|c| c.squared_bias),
            slope_interval_text(fit.and_then(|f| f.error)),
            fit.map_or("–".to_owned(), |_| {
                slope_range_text(self.predicted_convergence_slopes(method, ErrorComponent::Error))
            }),
        ]
    }
}

/// Returns the text of a slope over passes with its confidence interval, such as
/// `−0.49 (−0.52 … −0.46)`.
pub(super) fn slope_interval_text(slopes: Option<ConvergenceSlopes>) -> String {
    let Some(ConvergenceSlopes { by_passes, .. }) = slopes else { return "–".to_owned() };
    let interval = by_passes
        .confidence_interval
        .map_or(String::new(), |[low, high]| format!(" ({} … {})", text::slope_text(low), text::slope_text(high)));
    format!("{}{interval}", text::slope_text(by_passes.value))
}

/// Returns the text of a range of predicted slopes, such as `−0.50` or `−0.50 … 0.00`.
pub(super) fn slope_range_text(law: Option<SlopeRange>) -> String {
    law.map_or("none".to_owned(), |law| law.to_string())
}

/// Returns texts on the effort after which a method's error has fallen to a given value: the
/// processor time, and a list of further texts. The list holds the confidence interval of the time,
/// the number of passes, and the number of photon paths.
///
/// `has_photons` is true if the method traces photons. If the error never falls to that value, the
/// list holds the reason instead.
pub(super) fn time_to_error_text(reach: &TimeToError, has_photons: bool) -> (String, Vec<String>) {
    let work = |effort: &RenderEffort| {
        let passes = Some(format!("{} passes", count_text(effort.passes.max(1.0))));
        passes.into_iter().chain(has_photons.then(|| format!("{} photons", count_text(effort.photon_paths))))
    };
    match reach {
        TimeToError::Within(effort) => (format!("< {}", duration_text(effort.cpu_seconds)), work(effort).collect()),
        TimeToError::Measured(effort) => (duration_text(effort.cpu_seconds), work(effort).collect()),
        TimeToError::Predicted { effort, cpu_seconds_interval: seconds } => {
            let range = seconds.map(|[low, high]| {
                let is_open = high >= MAX_EXTRAPOLATION_FACTOR * effort.cpu_seconds;
                let high = if is_open { "unknown".to_owned() } else { duration_text(high) };
                format!("{} to {high}", duration_text(low))
            });
            (format!("≈ {}", duration_text(effort.cpu_seconds)), range.into_iter().chain(work(effort)).collect())
        }
        TimeToError::Never { floor } => {
            ("never: plateau".to_owned(), vec![format!("bias stays at {}", error_percent_text(*floor))])
        }
        TimeToError::Unknown => ("–".to_owned(), Vec::new()),
    }
}
