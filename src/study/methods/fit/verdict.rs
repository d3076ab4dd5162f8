//! Judges whether the error of a method falls as theory predicts.

use super::slopes::{ConvergenceFit, SlopeEstimate, mean_confidence_interval, squared_bias_interval};
use super::theory::{ErrorComponent, SlopeRange, predicted_convergence_slopes};
use crate::integrate::Algorithm;
use crate::study::methods::MethodResult;
use crate::study::report::text::{error_percent_text, slope_text, three_digit_text};
use std::fmt;

/// Smallest ratio bias² / error² at which bias counts as dominant.
///
/// At this ratio, the error is 1/√0.8 = 1.12 times the bias.
pub const DOMINANT_SQUARED_BIAS_SHARE: f64 = 0.8;

/// Widest confidence interval of a slope that can confirm theory. With a wider interval, the
/// verdict is [`ConvergenceVerdict::Undecided`] even if the slope agrees with theory.
///
/// A slope of 0 means a constant error, and −½ is the slope of unbiased path tracing. The limit is
/// half of this difference, so that the interval can tell one from the other.
const MAX_DECIDED_INTERVAL_WIDTH: f64 = 0.25;

/// Verdict on how the error of a method falls with the number of passes.
#[derive(Clone, Debug, PartialEq)]
pub enum ConvergenceVerdict {
    /// The method has too few checkpoints (measurements after 1, 2, 4 … passes) for a fit.
    TooFewCheckpoints,
    /// The error is too small to be measured. It does not exceed the error of the reference, an
    /// estimate of its square is not positive, or the confidence interval of its square contains 0.
    ErrorTooSmall {
        /// Relative error of the reference; `None` if the reference is taken as exact.
        reference_error: Option<f64>,
    },
    /// The slope of the error has no confidence interval: the method was rendered with too few
    /// seeds, or the errors of the seeds vary too much.
    NoInterval {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
    },
    /// The slope of the error agrees with theory, but its confidence interval is so wide that it
    /// does not exclude other slopes.
    Undecided {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
        /// 95 % confidence interval of `slope`.
        interval: [f64; 2],
    },
    /// The error has stopped falling, because most of it is bias.
    Plateau {
        /// Relative bias at the last checkpoint. The error does not fall below this bias.
        floor: f64,
        /// Cause of the bias.
        cause: BiasCause,
    },
    /// The error falls as theory predicts. Theory also predicts a bias, but the measured bias is
    /// too small to be distinguished from noise.
    BiasHidden {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
        /// Upper bound of the relative bias, with 97.5 % confidence.
        max_bias: f64,
    },
    /// The error falls as theory predicts.
    Expected {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
        /// Relative bias at which the error will stop falling; `None` if the bias falls too, or is
        /// not significant.
        bias_floor: Option<f64>,
    },
    /// The error falls more slowly than theory predicts.
    Slower {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
        /// Range of slopes that theory predicts for the error.
        predicted_slopes: SlopeRange,
    },
    /// The error falls faster than theory predicts.
    Faster {
        /// Slope of the method's error over passes, in a log-log plot.
        slope: f64,
        /// Range of slopes that theory predicts for the error.
        predicted_slopes: SlopeRange,
    },
}

/// Cause of a bias that more passes do not reduce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BiasCause {
    /// Blur of photon density estimates. Holds two gather radii \[length]: of the indirect photon
    /// map, and of the caustic photon map.
    Radii([f32; 2]),
    /// The algorithm leaves out some light by design.
    OmittedLight,
    /// The cause of the bias is unknown: by theory, the algorithm has no such bias.
    Unknown,
}

/// Judges how the error of a method falls with the number of passes.
///
/// `fit` holds the fitted slopes of `method`. `reference_error` is the relative error of the
/// reference; `None` if the reference is taken as exact.
///
/// The noise of the two references does not affect the measured error, but a bias that both
/// references share does. So an error below `reference_error` gets the verdict
/// [`ConvergenceVerdict::ErrorTooSmall`].
#[must_use]
pub fn judge_convergence(
    method: &MethodResult,
    fit: Option<&ConvergenceFit>,
    reference_error: Option<f64>,
) -> ConvergenceVerdict {
    let (Some(fit), Some(last)) = (fit, method.checkpoints.last()) else {
        return ConvergenceVerdict::TooFewCheckpoints;
    };
    let least = reference_error.unwrap_or(0.0);
    let is_too_small = mean_confidence_interval(&last.relative_squared_errors).is_some_and(|[low, _]| low <= 0.0)
        || last.mean_relative_squared_error() <= least * least;
    let (Some(slopes), false) = (fit.error, is_too_small) else {
        return ConvergenceVerdict::ErrorTooSmall { reference_error };
    };
    let SlopeEstimate { value: slope, confidence_interval: interval } = slopes.by_passes;
    let Some([low, high]) = interval else { return ConvergenceVerdict::NoInterval { slope } };
    let predicted_slopes_of =
        |quantity| predicted_convergence_slopes(method.algorithm, quantity, &fit.checkpoint_passes, method.alpha);
    let (Some(noise), Some(total)) =
        (predicted_slopes_of(ErrorComponent::Noise), predicted_slopes_of(ErrorComponent::Error))
    else {
        return ConvergenceVerdict::NoInterval { slope };
    };
    let bias = predicted_slopes_of(ErrorComponent::Bias);
    // Flattest slope that theory predicts for the noise and for the bias. A constant or zero bias
    // does not count.
    let flattest_falling_slope =
        bias.filter(|b| b.flattest < 0.0).map_or(noise.flattest, |b| b.flattest.max(noise.flattest));
    if low > flattest_falling_slope
        && last.squared_bias >= DOMINANT_SQUARED_BIAS_SHARE * last.mean_relative_squared_error()
    {
        return ConvergenceVerdict::Plateau { floor: last.squared_bias.sqrt(), cause: bias_cause(method) };
    }
    if low > total.flattest {
        return ConvergenceVerdict::Slower { slope, predicted_slopes: total };
    }
    if high < total.steepest {
        return ConvergenceVerdict::Faster { slope, predicted_slopes: total };
    }
    if high - low > MAX_DECIDED_INTERVAL_WIDTH {
        return ConvergenceVerdict::Undecided { slope, interval: [low, high] };
    }
    let bias_interval = squared_bias_interval(last);
    match bias_interval {
        Some([low, most]) if low <= 0.0 && bias.is_some() => {
            ConvergenceVerdict::BiasHidden { slope, max_bias: most.max(0.0).sqrt() }
        }
        _ => {
            let bias_is_constant =
                bias.is_some_and(|b| b.flattest >= 0.0) && bias_interval.is_some_and(|[low, _]| low > 0.0);
            ConvergenceVerdict::Expected {
                slope,
                bias_floor: bias_is_constant.then(|| last.squared_bias.max(0.0).sqrt()),
            }
        }
    }
}

fn bias_cause(method: &MethodResult) -> BiasCause {
    match (method.algorithm, method.gather_radii) {
        (Algorithm::Distributed | Algorithm::Whitted | Algorithm::Raycast, _) => BiasCause::OmittedLight,
        (Algorithm::Path, _) | (_, None) => BiasCause::Unknown,
        (_, Some(radii)) => BiasCause::Radii(radii),
    }
}

impl fmt::Display for ConvergenceVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let as_theory = "falls as theory says";
        match self {
            Self::TooFewCheckpoints => write!(f, "too few checkpoints: give it more time"),
            Self::ErrorTooSmall { reference_error: Some(error) } => {
                write!(f, "below the error of the references, {}", error_percent_text(*error))
            }
            Self::ErrorTooSmall { reference_error: None } => write!(f, "too small to measure with these seeds"),
            Self::NoInterval { slope } => write!(f, "slope {}; too few seeds for an interval", slope_text(*slope)),
            Self::Undecided { slope, interval } => {
                let [low, high] = interval.map(slope_text);
                write!(f, "cannot tell: slope {}, between {low} and {high}; more seeds tell more", slope_text(*slope))
            }
            Self::Plateau { floor, cause } => write!(f, "plateau: bias of {} stays{cause}", error_percent_text(*floor)),
            Self::BiasHidden { slope, max_bias: most } => {
                let (most, slope) = (error_percent_text(*most), slope_text(*slope));
                write!(f, "{as_theory}; bias is hidden by noise, below {most} (slope {slope})")
            }
            Self::Expected { slope, bias_floor: None } => write!(f, "{as_theory} (slope {})", slope_text(*slope)),
            Self::Expected { slope, bias_floor: Some(floor) } => {
                write!(
                    f,
                    "{as_theory}, towards a bias of {} (slope {})",
                    error_percent_text(*floor),
                    slope_text(*slope)
                )
            }
            Self::Slower { slope, predicted_slopes: law } => {
                write!(f, "falls more slowly than theory says: slope {}, not {law}", slope_text(*slope))
            }
            Self::Faster { slope, predicted_slopes: law } => {
                write!(f, "falls faster than theory says: slope {}, not {law}", slope_text(*slope))
            }
        }
    }
}

impl fmt::Display for BiasCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Radii(radii) => match radii.map(f64::from) {
                [indirect, caustic] if caustic > 0.0 && indirect > 0.0 && caustic != indirect => {
                    write!(f, " at r = {}, caustics at r = {}", three_digit_text(indirect), three_digit_text(caustic))
                }
                [indirect, caustic] => write!(f, " at r = {}", three_digit_text(indirect.max(caustic))),
            },
            Self::OmittedLight => write!(f, ", from light that the algorithm leaves out"),
            Self::Unknown => write!(f, ", unknown to theory: does the reference show the same scene?"),
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
