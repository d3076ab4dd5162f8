//! Analysis that all reports of a study of methods share.

use crate::study::methods::fit::{
    Effort, Fit, Law, ParetoPoint, Quantity, Recommendation, Slopes, TimeToError, Verdict, fit, pareto, predicted_law,
    recommend, time_to_error, time_to_tenth, verdict,
};
use crate::study::methods::{MethodResult, MethodStudyResult};
use crate::study::report::text::{self, amount, duration, error};

/// Relative errors whose time is reported.
pub(super) const ERRORS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// Fits, verdicts and times to reach errors.
pub(super) struct Analysis {
    pub(super) methods: Vec<MethodAnalysis>,
    pub(super) pareto: Vec<ParetoPoint>,
    pub(super) recommendation: Option<Recommendation>,
}

/// Analysis of one method.
pub(super) struct MethodAnalysis {
    pub(super) fit: Option<Fit>,
    pub(super) verdict: Verdict,
    /// Times to reach [`ERRORS`].
    pub(super) reaches: [TimeToError; 4],
    pub(super) tenth: TimeToError,
}

impl Analysis {
    pub(super) fn of(found: &MethodStudyResult) -> Self {
        let fits: Vec<Option<Fit>> = found.methods.iter().map(fit).collect();
        let recommendation = recommend(found, &fits);
        let judge = |(method, fit): (&MethodResult, Option<Fit>)| {
            let verdict = verdict(method, fit.as_ref(), found.truth.error);
            let reaches = ERRORS.map(|e| time_to_error(method, fit.as_ref(), &verdict, e));
            MethodAnalysis { tenth: time_to_tenth(method, fit.as_ref(), &verdict), reaches, verdict, fit }
        };
        let methods = found.methods.iter().zip(fits).map(judge).collect();
        Self { methods, pareto: pareto(&found.methods), recommendation }
    }

    /// Recommendation in words, and its command.
    pub(super) fn advice(&self, found: &MethodStudyResult) -> Option<(String, String)> {
        let Recommendation { method, error: expected, alike } = self.recommendation.as_ref()?;
        let (best, judged) = (&found.methods[*method], &self.methods[*method]);
        let more = match judged.tenth {
            TimeToError::Predicted { effort, .. } => {
                format!(" A tenth of its last error would take about {}.", duration(effort.seconds))
            }
            TimeToError::Never { floor } => {
                format!(" It never reaches a tenth of its last error: bias stays at {}.", error(floor))
            }
            _ => String::new(),
        };
        let others: Vec<&str> = alike.iter().map(|i| found.methods[*i].label.as_str()).collect();
        let alike =
            if others.is_empty() { String::new() } else { format!(" Within 10 % of it: {}.", others.join(", ")) };
        let words = format!(
            "{} has the least error after {} of processor time: an error of {} is expected.{alike}{more}",
            best.label,
            duration(found.budget),
            error(*expected),
        );
        Some((words, best.command.clone()))
    }
}

impl MethodAnalysis {
    /// Slope by theory over the fitted passes.
    pub(super) fn law(&self, method: &MethodResult, quantity: Quantity) -> Option<Law> {
        predicted_law(method.algorithm, quantity, &self.fit.as_ref()?.passes, method.alpha)
    }
}

/// Slope over passes with its interval: `−0.49 (−0.52 … −0.46)`.
pub(super) fn slope(slopes: Option<Slopes>) -> String {
    let Some(Slopes { by_passes, .. }) = slopes else { return "–".to_owned() };
    let interval = by_passes
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} … {})", text::slope(low), text::slope(high)));
    format!("{}{interval}", text::slope(by_passes.value))
}

/// Slopes by theory: `−0.50`, `−0.50 … 0.00`.
pub(super) fn law_text(law: Option<Law>) -> String {
    law.map_or("none".to_owned(), |law| law.to_string())
}

/// Time to reach an error, and the other work.
pub(super) fn reach_text(reach: &TimeToError, has_photons: bool) -> (String, Vec<String>) {
    let work = |effort: &Effort| {
        let passes = Some(format!("{} passes", amount(effort.passes.max(1.0))));
        passes.into_iter().chain(has_photons.then(|| format!("{} photons", amount(effort.photons))))
    };
    match reach {
        TimeToError::Within(effort) => (format!("< {}", duration(effort.seconds)), work(effort).collect()),
        TimeToError::Measured(effort) => (duration(effort.seconds), work(effort).collect()),
        TimeToError::Predicted { effort, seconds } => {
            let range = seconds.map(|[low, high]| format!("{} to {}", duration(low), duration(high)));
            (format!("≈ {}", duration(effort.seconds)), range.into_iter().chain(work(effort)).collect())
        }
        TimeToError::Never { floor } => ("never: plateau".to_owned(), vec![format!("bias stays at {}", error(*floor))]),
        TimeToError::Unknown => ("–".to_owned(), Vec::new()),
    }
}
