//! Verdicts: what a slope means.

use super::slopes::{ConvergenceFit, SlopeEstimate, mean_confidence_interval, squared_bias_interval};
use super::theory::{ErrorComponent, SlopeRange, predicted_slopes};
use crate::integrate::Algorithm;
use crate::study::methods::MethodResult;
use crate::study::report::text::{error_percent_text, slope_text, three_digit_text};
use std::fmt;

/// Fraction of the squared error above which bias is its cause; the error is then within 12 % of
/// the bias.
pub const BIAS_DOMINATED_SHARE: f64 = 0.8;

/// Behaviour of a method's error.
#[derive(Clone, Debug, PartialEq)]
pub enum ConvergenceVerdict {
    /// Too few checkpoints for a fit.
    TooFew,
    /// The error is below what the references or seeds can resolve.
    TooSmall {
        /// Relative error of the truth; `None` if unknown.
        truth: Option<f64>,
    },
    /// Seeds are too few or too scattered for an interval.
    Wide {
        /// Slope over passes.
        slope: f64,
    },
    /// Only bias is left, and it stays.
    Plateau {
        /// Relative error that remains.
        floor: f64,
        /// Cause of the bias.
        cause: BiasCause,
    },
    /// The error falls as noise does; an expected bias is too small to be seen.
    Hidden {
        /// Slope over passes.
        slope: f64,
        /// Upper bound of the bias at 97.5 % confidence.
        most: f64,
    },
    /// The slope agrees with theory.
    Expected {
        /// Slope over passes.
        slope: f64,
        /// Bias that stays, if it is visible already.
        ahead: Option<f64>,
    },
    /// The error falls more slowly than theory says.
    Slower {
        /// Slope over passes.
        slope: f64,
        /// Range of slopes by theory.
        law: SlopeRange,
    },
    /// The error falls faster than theory says.
    Faster {
        /// Slope over passes.
        slope: f64,
        /// Range of slopes by theory.
        law: SlopeRange,
    },
}

/// Cause of an error that stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BiasCause {
    /// Photon estimates blur light over these radii, of the global and of the caustic map.
    Radii([f32; 2]),
    /// The algorithm leaves out light by design.
    LeavesOut,
    /// Theory has no cause.
    Unknown,
}

/// Verdict on a method, given the relative error `truth` of the reference.
///
/// The noise of references cancels, but their bias does not. Errors below that of the truth are
/// therefore not judged.
#[must_use]
pub fn judge_convergence(
    method: &MethodResult,
    fit: Option<&ConvergenceFit>,
    truth: Option<f64>,
) -> ConvergenceVerdict {
    let (Some(fit), Some(last)) = (fit, method.checkpoints.last()) else { return ConvergenceVerdict::TooFew };
    let least = truth.unwrap_or(0.0);
    let nothing = mean_confidence_interval(&last.squares).is_some_and(|[low, _]| low <= 0.0)
        || last.mean_squared_error() <= least * least;
    let (Some(slopes), false) = (fit.error, nothing) else { return ConvergenceVerdict::TooSmall { truth } };
    let SlopeEstimate { value: slope, interval } = slopes.by_passes;
    let Some([low, high]) = interval else { return ConvergenceVerdict::Wide { slope } };
    let law = |quantity| predicted_slopes(method.algorithm, quantity, &fit.passes, method.alpha);
    let (Some(noise), Some(total)) = (law(ErrorComponent::Noise), law(ErrorComponent::Error)) else {
        return ConvergenceVerdict::Wide { slope };
    };
    let bias = law(ErrorComponent::Bias);
    // A constant bias is no convergence.
    let falling = bias.filter(|b| b.flattest < 0.0).map_or(noise.flattest, |b| b.flattest.max(noise.flattest));
    if low > falling && last.bias2 >= BIAS_DOMINATED_SHARE * last.mean_squared_error() {
        return ConvergenceVerdict::Plateau { floor: last.bias2.sqrt(), cause: bias_cause(method) };
    }
    if low > total.flattest {
        return ConvergenceVerdict::Slower { slope, law: total };
    }
    if high < total.steepest {
        return ConvergenceVerdict::Faster { slope, law: total };
    }
    let seen = squared_bias_interval(last);
    match seen {
        Some([low, most]) if low <= 0.0 && bias.is_some() => {
            ConvergenceVerdict::Hidden { slope, most: most.max(0.0).sqrt() }
        }
        _ => {
            let stays = bias.is_some_and(|b| b.flattest >= 0.0) && seen.is_some_and(|[low, _]| low > 0.0);
            ConvergenceVerdict::Expected { slope, ahead: stays.then(|| last.bias2.max(0.0).sqrt()) }
        }
    }
}

fn bias_cause(method: &MethodResult) -> BiasCause {
    match (method.algorithm, method.radii) {
        (Algorithm::Distributed | Algorithm::Whitted | Algorithm::Raycast, _) => BiasCause::LeavesOut,
        (Algorithm::Path, _) | (_, None) => BiasCause::Unknown,
        (_, Some(radii)) => BiasCause::Radii(radii),
    }
}

impl fmt::Display for ConvergenceVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let as_theory = "falls as theory says";
        match self {
            Self::TooFew => write!(f, "too few checkpoints: give it more time"),
            Self::TooSmall { truth: Some(truth) } => {
                write!(f, "below the error of the references, {}", error_percent_text(*truth))
            }
            Self::TooSmall { truth: None } => write!(f, "too small to measure with these seeds"),
            Self::Wide { slope } => write!(f, "slope {}; too few seeds for an interval", slope_text(*slope)),
            Self::Plateau { floor, cause } => write!(f, "plateau: bias of {} stays{cause}", error_percent_text(*floor)),
            Self::Hidden { slope, most } => {
                let (most, slope) = (error_percent_text(*most), slope_text(*slope));
                write!(f, "{as_theory}; bias is hidden by noise, below {most} (slope {slope})")
            }
            Self::Expected { slope, ahead: None } => write!(f, "{as_theory} (slope {})", slope_text(*slope)),
            Self::Expected { slope, ahead: Some(floor) } => {
                write!(
                    f,
                    "{as_theory}, towards a bias of {} (slope {})",
                    error_percent_text(*floor),
                    slope_text(*slope)
                )
            }
            Self::Slower { slope, law } => {
                write!(f, "falls more slowly than theory says: slope {}, not {law}", slope_text(*slope))
            }
            Self::Faster { slope, law } => {
                write!(f, "falls faster than theory says: slope {}, not {law}", slope_text(*slope))
            }
        }
    }
}

impl fmt::Display for BiasCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Radii(radii) => match radii.map(f64::from) {
                [global, caustic] if caustic > 0.0 && global > 0.0 && caustic != global => {
                    write!(f, " at r = {}, caustics at r = {}", three_digit_text(global), three_digit_text(caustic))
                }
                [global, caustic] => write!(f, " at r = {}", three_digit_text(global.max(caustic))),
            },
            Self::LeavesOut => write!(f, ", from light that the algorithm leaves out"),
            Self::Unknown => write!(f, ", unknown to theory: does the truth show the same scene?"),
        }
    }
}

impl fmt::Display for SlopeRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match [self.steepest, self.flattest].map(slope_text) {
            [a, b] if a == b => f.write_str(&a),
            [a, b] => write!(f, "{a} … {b}"),
        }
    }
}
