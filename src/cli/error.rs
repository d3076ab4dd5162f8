//! Errors of pictures in words.

use crate::render::error_estimate::{ErrorEstimate, Forecast, PassesNeeded};
use crate::study::text::percent;

/// What helps where an error cannot become as low as is asked for.
pub(super) const REMEDY: &str = "what is left is bias of this method: choose a smaller --radius, or --integrator sppm or hybrid, whose radii shrink";

/// An error is asked of what cannot tell it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} asks for an error, which one pass of ray casting does not tell")]
#[diagnostic(help("leave it out, or choose another --integrator"))]
pub(super) struct NoError {
    pub flag: &'static str,
}

/// An error and what it is made of: `2.1 % (noise 1.9 %, bias 0.8 %)`.
pub(super) fn parts(reading: &ErrorEstimate) -> String {
    format!("{} (noise {}, bias {})", percent(reading.error), percent(reading.noise), percent(reading.bias))
}

/// When the error will be down to `aim`, which is called `named`, at so many seconds a pass; nothing where there is no error.
pub(super) fn outlook(reading: &ErrorEstimate, forecast: &Forecast, (named, aim): (f64, f64), a_pass: f64) -> String {
    if reading.error == 0.0 {
        return String::new();
    }
    let aimed = format!("; {}", percent(named));
    match forecast.passes_to(aim) {
        PassesNeeded::Passes(n) => {
            let more = n.saturating_sub(reading.passes);
            format!("{aimed} in about {}", seconds(f64::from(more) * a_pass))
        }
        PassesNeeded::Never { floor } => format!("{aimed} never: {} is bias that stays", percent(floor)),
        PassesNeeded::TooMany => format!("{aimed} in more than {}", seconds(1e7 * a_pass)),
    }
}

/// A time with two digits or so: `0.8 s`, `42 s`, `3 min 20 s`, `5 h 10 min`, `12 d`.
pub(super) fn seconds(t: f64) -> String {
    if t < 9.95 {
        return format!("{t:.1} s");
    }
    let whole = t.round().min(1e15) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..172_800 => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
        _ => format!("{} d", whole / 86_400),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_unit_that_fits() {
        let told = [0.0, 9.94, 9.96, 59.6, 200.0, 18_600.0, 1e6, f64::INFINITY].map(seconds);
        let days = told[7].clone();
        assert_eq!(told[..7], ["0.0 s", "9.9 s", "10 s", "1 min 0 s", "3 min 20 s", "5 h 10 min", "11 d"]);
        assert!(days.ends_with(" d"), "{days}");
    }
}
