//! What a slope means, in words.

use super::{Fit, Law, Quantity, Slope, bias_spread, spread, theory};
use crate::integrate::Algorithm;
use crate::study::methods::MethodFound;
use crate::study::report::text::{error, figure, slope as digits};
use std::fmt;

/// Part of the squared error that bias must explain to be its cause: the error is then within 12 % of the bias, whatever the noise does.
pub const BIAS_SHARE: f64 = 0.8;

/// What a method's error does.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// No line can be held against another.
    TooFew,
    /// It cannot be told from none.
    Untold {
        /// Relative error of the truth, where it is known.
        truth: Option<f64>,
    },
    /// Seeds are too few, or too far apart, for an interval.
    Wide {
        /// The slope against passes.
        slope: f64,
    },
    /// Bias is what is left, and it stays.
    Plateau {
        /// Relative error that no time lessens.
        floor: f64,
        /// Why.
        cause: Cause,
    },
    /// It falls as noise does; a bias that theory knows of is too small to be seen.
    Hidden {
        /// The slope against passes.
        slope: f64,
        /// The bias is below, with a chance of 97.5 %.
        most: f64,
    },
    /// As theory says.
    Expected {
        /// The slope against passes.
        slope: f64,
        /// A bias that stays, where it is seen already.
        ahead: Option<f64>,
    },
    /// It falls more slowly than theory says.
    Slower {
        /// The slope against passes.
        slope: f64,
        /// Theory.
        law: Law,
    },
    /// It falls faster than theory says.
    Faster {
        /// The slope against passes.
        slope: f64,
        /// Theory.
        law: Law,
    },
}

/// Why an error stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// Light is blurred over these radii, of the global and of the caustic map.
    Radii([f32; 2]),
    /// The algorithm does not simulate all light.
    LeavesOut,
    /// Theory knows of none.
    Unknown,
}

/// The verdict on a method, held against a truth whose relative error is `truth`.
///
/// Noise of references does not count in squared errors, but their own bias does, and all that bounds it is their error: an error below that is no
/// finding.
#[must_use]
pub fn verdict(method: &MethodFound, fit: Option<&Fit>, truth: Option<f64>) -> Verdict {
    let (Some(fit), Some(last)) = (fit, method.checkpoints.last()) else { return Verdict::TooFew };
    let least = truth.unwrap_or(0.0);
    let nothing = spread(&last.squares).is_some_and(|[low, _]| low <= 0.0) || last.square() <= least * least;
    let (Some(slopes), false) = (fit.error, nothing) else { return Verdict::Untold { truth } };
    let Slope { value: slope, interval } = slopes.by_passes;
    let Some([low, high]) = interval else { return Verdict::Wide { slope } };
    let law = |quantity| theory(method.algorithm, quantity, &fit.passes, method.alpha);
    let (Some(noise), Some(total)) = (law(Quantity::Noise), law(Quantity::Error)) else {
        return Verdict::Wide { slope };
    };
    let bias = law(Quantity::Bias);
    // A bias that stays is no law by which an error falls.
    let falling = bias.filter(|b| b.flattest < 0.0).map_or(noise.flattest, |b| b.flattest.max(noise.flattest));
    if low > falling && last.bias2 >= BIAS_SHARE * last.square() {
        return Verdict::Plateau { floor: last.bias2.sqrt(), cause: cause(method) };
    }
    if low > total.flattest {
        return Verdict::Slower { slope, law: total };
    }
    if high < total.steepest {
        return Verdict::Faster { slope, law: total };
    }
    let seen = bias_spread(last);
    match seen {
        Some([low, most]) if low <= 0.0 && bias.is_some() => Verdict::Hidden { slope, most: most.max(0.0).sqrt() },
        _ => {
            let stays = bias.is_some_and(|b| b.flattest >= 0.0) && seen.is_some_and(|[low, _]| low > 0.0);
            Verdict::Expected { slope, ahead: stays.then(|| last.bias2.max(0.0).sqrt()) }
        }
    }
}

fn cause(method: &MethodFound) -> Cause {
    match (method.algorithm, method.radii) {
        (Algorithm::Distributed | Algorithm::Whitted | Algorithm::Raycast, _) => Cause::LeavesOut,
        (Algorithm::Path, _) | (_, None) => Cause::Unknown,
        (_, Some(radii)) => Cause::Radii(radii),
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let as_theory = "falls as theory says";
        match self {
            Self::TooFew => write!(f, "too few checkpoints: give it more time"),
            Self::Untold { truth: Some(truth) } => {
                write!(f, "below what the references can tell: they are good to {}", error(*truth))
            }
            Self::Untold { truth: None } => write!(f, "below what these seeds can tell from none"),
            Self::Wide { slope } => write!(f, "slope {}; too few seeds to say how surely", digits(*slope)),
            Self::Plateau { floor, cause } => write!(f, "plateau: bias floor of {}{cause}", error(*floor)),
            Self::Hidden { slope, most } => {
                let (most, slope) = (error(*most), digits(*slope));
                write!(f, "{as_theory}; noise hides the bias, which is below {most} (slope {slope})")
            }
            Self::Expected { slope, ahead: None } => write!(f, "{as_theory} (slope {})", digits(*slope)),
            Self::Expected { slope, ahead: Some(floor) } => {
                write!(f, "{as_theory}, towards a bias floor of {} (slope {})", error(*floor), digits(*slope))
            }
            Self::Slower { slope, law } => {
                write!(f, "falls more slowly than theory says: slope {}, not {law}", digits(*slope))
            }
            Self::Faster { slope, law } => {
                write!(f, "falls faster than theory says: slope {}, not {law}", digits(*slope))
            }
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Radii(radii) => match radii.map(f64::from) {
                [global, caustic] if caustic > 0.0 && global > 0.0 && caustic != global => {
                    write!(f, " at r = {}, caustics at r = {}", figure(global), figure(caustic))
                }
                [global, caustic] => write!(f, " at r = {}", figure(global.max(caustic))),
            },
            Self::LeavesOut => write!(f, ", light that it does not simulate"),
            Self::Unknown => write!(f, ", of which theory knows nothing: does the truth show the same scene?"),
        }
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match [self.steepest, self.flattest].map(digits) {
            [a, b] if a == b => f.write_str(&a),
            [a, b] => write!(f, "{a} … {b}"),
        }
    }
}
