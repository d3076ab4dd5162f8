//! What all reports of a study of methods tell of it.

use crate::study::methods::fit::{
    Fit, Law, Milestone, Price, Quantity, Reach, Recommendation, Slopes, Verdict, fit, pareto, reach, recommend, tenth,
    theory, verdict,
};
use crate::study::methods::{MethodFound, MethodsFound};
use crate::study::report::text::{self, amount, duration, error};

/// Relative errors whose time is told.
pub(super) const ERRORS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// Fits, verdicts and prices.
pub(super) struct Analysis {
    pub(super) methods: Vec<Judged>,
    pub(super) pareto: Vec<Milestone>,
    pub(super) recommendation: Option<Recommendation>,
}

/// Those of a method.
pub(super) struct Judged {
    pub(super) fit: Option<Fit>,
    pub(super) verdict: Verdict,
    /// Of [`ERRORS`].
    pub(super) reaches: [Reach; 4],
    pub(super) tenth: Reach,
}

impl Analysis {
    pub(super) fn of(found: &MethodsFound) -> Self {
        let fits: Vec<Option<Fit>> = found.methods.iter().map(fit).collect();
        let recommendation = recommend(found, &fits);
        let judge = |(method, fit): (&MethodFound, Option<Fit>)| {
            let verdict = verdict(method, fit.as_ref(), found.truth.error);
            let reaches = ERRORS.map(|e| reach(method, fit.as_ref(), &verdict, e));
            Judged { tenth: tenth(method, fit.as_ref(), &verdict), reaches, verdict, fit }
        };
        let methods = found.methods.iter().zip(fits).map(judge).collect();
        Self { methods, pareto: pareto(&found.methods), recommendation }
    }

    /// What to render with, in words, and its command.
    pub(super) fn advice(&self, found: &MethodsFound) -> Option<(String, String)> {
        let Recommendation { method, error: expected, alike } = self.recommendation.as_ref()?;
        let (best, judged) = (&found.methods[*method], &self.methods[*method]);
        let more = match judged.tenth {
            Reach::Predicted { price, .. } => {
                format!(" A tenth of its last error would take about {}.", duration(price.seconds))
            }
            Reach::Never { floor } => {
                format!(" A tenth of its last error is never reached: its bias stays at {}.", error(floor))
            }
            _ => String::new(),
        };
        let others: Vec<&str> = alike.iter().map(|i| found.methods[*i].label.as_str()).collect();
        let alike =
            if others.is_empty() { String::new() } else { format!(" As good within 10 %: {}.", others.join(", ")) };
        let words = format!(
            "{} has the least error after {} of processor time: an error of {} is expected.{alike}{more}",
            best.label,
            duration(found.budget),
            error(*expected),
        );
        Some((words, best.command.clone()))
    }
}

impl Judged {
    /// Theory's slope of a quantity over the fitted passes.
    pub(super) fn law(&self, method: &MethodFound, quantity: Quantity) -> Option<Law> {
        theory(method.algorithm, quantity, &self.fit.as_ref()?.passes, method.alpha)
    }
}

/// A slope against passes with its interval: `−0.49 (−0.52 … −0.46)`.
pub(super) fn slope(slopes: Option<Slopes>) -> String {
    let Some(Slopes { by_passes, .. }) = slopes else { return "–".to_owned() };
    let interval = by_passes
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} … {})", text::slope(low), text::slope(high)));
    format!("{}{interval}", text::slope(by_passes.value))
}

/// Theory's slopes: `−0.50`, `−0.50 … 0.00`.
pub(super) fn law_text(law: Option<Law>) -> String {
    law.map_or("none".to_owned(), |law| law.to_string())
}

/// How an error is reached: in time, and what else it takes.
pub(super) fn reach_text(reach: &Reach, has_photons: bool) -> (String, Vec<String>) {
    let work = |price: &Price| {
        let passes = Some(format!("{} passes", amount(price.passes.max(1.0))));
        passes.into_iter().chain(has_photons.then(|| format!("{} photons", amount(price.photons))))
    };
    match reach {
        Reach::Within(price) => (format!("< {}", duration(price.seconds)), work(price).collect()),
        Reach::Measured(price) => (duration(price.seconds), work(price).collect()),
        Reach::Predicted { price, seconds } => {
            let range = seconds.map(|[low, high]| format!("{} to {}", duration(low), duration(high)));
            (format!("≈ {}", duration(price.seconds)), range.into_iter().chain(work(price)).collect())
        }
        Reach::Never { floor } => ("never: plateau".to_owned(), vec![format!("bias stays at {}", error(*floor))]),
        Reach::Unknown => ("–".to_owned(), Vec::new()),
    }
}
