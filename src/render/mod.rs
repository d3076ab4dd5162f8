//! Driving an integrator: passes, when to stop, the mean of what they gave.

mod film;
pub mod gauge;

pub use film::Film;

use crate::integrate::{Integrator, Monitor, PhotonReport, Seconds};
use crate::stats::Counters;
use gauge::{Confidence, ErrorEstimate, ErrorEstimator, Forecast, Needed};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// When a render ends; at least one pass is always made.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a> {
    /// Neither time nor error ends it before so many passes.
    pub at_least: u32,
    /// After so many passes.
    pub passes: Option<u32>,
    /// After the pass during which so much time has gone by.
    pub time: Option<Duration>,
    /// After the pass by which the error is low enough.
    pub target: Option<Target>,
    /// After the pass during which this becomes true.
    pub interrupted: &'a AtomicBool,
}

/// An error that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Relative error (see [`ErrorEstimate`]).
    pub error: f64,
    /// How sure it must be that the true error is no larger.
    pub confidence: Confidence,
}

impl Target {
    /// The interval whose upper end is above the true error with the target's confidence: half of what it leaves out lies below it.
    #[must_use]
    pub fn interval(self) -> Confidence {
        Confidence::new(2.0 * self.confidence.part() - 1.0).unwrap_or(Confidence::LEAST)
    }
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ended {
    /// All passes were made.
    Passes,
    /// Time was up.
    Time,
    /// The error is as low as was asked for.
    Target,
    /// The error cannot become as low, and nothing else was asked for.
    Floor,
    /// The user asked.
    Interrupted,
}

/// A finished render.
#[derive(Debug)]
pub struct Rendered {
    /// The sum of all passes.
    pub film: Film,
    /// What is known of its error; `None` where passes were not gauged.
    pub gauge: Option<ErrorEstimator>,
    /// Why it ended.
    pub ended: Ended,
    /// Work of all passes.
    pub counters: Counters,
    /// Time of all passes by stage.
    pub seconds: Seconds,
    /// Photons of the global map.
    pub global: PhotonReport,
    /// Photons of the caustic map.
    pub caustic: PhotonReport,
    /// Wall time.
    pub wall: Duration,
}

/// How a render stands after a pass.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Passes made.
    pub passes: u32,
    /// The error so far and how it goes on, where that was looked at after this pass.
    pub error: Option<(ErrorEstimate, Forecast)>,
}

/// The error is looked at when so many times as many passes are made as when it was looked at last: each look costs a part of a pass.
const LOOK_EVERY: f64 = 1.05;

/// Passes from which on it is believed that a target cannot be reached, and how far it must be from what is left.
const SURE: u32 = 16;
const CLEARLY: f64 = 0.8;

/// Renders passes 0, 1, 2 … of an image of `size` pixels until `stop`; the error is looked at too where passes are gauged. `after`
/// hears how things stand after each pass.
pub fn render(
    integrator: &dyn Integrator,
    size: (u32, u32),
    stop: &Stop<'_>,
    monitor: &dyn Monitor,
    mut after: impl FnMut(&Standing),
) -> Rendered {
    let start = Instant::now();
    let mut rendered = Rendered {
        film: Film::new(size.0, size.1),
        gauge: integrator.nests_estimates().then(|| ErrorEstimator::new(integrator.radius_law())),
        ended: Ended::Passes,
        counters: Counters::default(),
        seconds: Seconds::default(),
        global: PhotonReport::default(),
        caustic: PhotonReport::default(),
        wall: Duration::ZERO,
    };
    let mut look_at = 0.0;
    loop {
        let pass = integrator.pass(rendered.film.passes(), monitor);
        if let Some(gauge) = &mut rendered.gauge {
            gauge.add(&rendered.film, &pass);
        }
        rendered.film.add(&pass.image);
        rendered.counters += pass.counters;
        rendered.seconds += pass.seconds;
        rendered.global += pass.global;
        rendered.caustic += pass.caustic;
        let made = rendered.film.passes();
        let error = rendered.gauge.as_ref().filter(|_| f64::from(made) >= look_at).and_then(|gauge| {
            look_at = LOOK_EVERY * f64::from(made);
            let confidence = stop.target.map_or(Confidence::default(), Target::interval);
            let reading = gauge.read_with(&rendered.film, confidence);
            gauge.forecast(&reading).map(|forecast| (reading, forecast))
        });
        after(&Standing { passes: made, error });
        let ended = if stop.interrupted.load(Ordering::Relaxed) {
            Some(Ended::Interrupted)
        } else if stop.passes.is_some_and(|most| made >= most) || made == u32::MAX {
            Some(Ended::Passes)
        } else if made < stop.at_least {
            None
        } else if stop.time.is_some_and(|most| start.elapsed() >= most) {
            Some(Ended::Time)
        } else {
            error.and_then(|(reading, forecast)| stop.by_error(&reading, &forecast))
        };
        if let Some(ended) = ended {
            rendered.ended = ended;
            rendered.wall = start.elapsed();
            return rendered;
        }
    }
}

impl Stop<'_> {
    /// Whether an error ends a render.
    fn by_error(&self, reading: &ErrorEstimate, forecast: &Forecast) -> Option<Ended> {
        let target = self.target?;
        if reading.high <= target.error {
            return Some(Ended::Target);
        }
        let Needed::Never { floor } = forecast.passes_to(target.error) else { return None };
        let hopeless = reading.passes >= SURE && CLEARLY * floor > target.error;
        (hopeless && self.passes.is_none() && self.time.is_none()).then_some(Ended::Floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::integrate::{Pass, Silent};
    use crate::plan::{Effects, Plan};

    struct Counting;

    impl Integrator for Counting {
        fn pass(&self, pass: u32, _: &dyn Monitor) -> Pass {
            Pass { image: vec![Rgb::splat(pass as f32); 2], ..Pass::default() }
        }

        fn expected_work(&self, _: Effects) -> Counters {
            Counters::default()
        }

        fn plan(&self) -> &Plan {
            unreachable!("nothing asks for it here")
        }
    }

    #[test]
    fn the_image_is_the_mean_of_the_passes() {
        let stop =
            Stop { at_least: 1, passes: Some(4), time: None, target: None, interrupted: &AtomicBool::new(false) };
        let rendered = super::render(&Counting, (2, 1), &stop, &Silent, |_| {});
        assert_eq!((rendered.ended, rendered.film.passes()), (Ended::Passes, 4));
        assert_eq!(rendered.film.mean(), vec![Rgb::splat(1.5); 2]);
    }

    #[test]
    fn time_and_interrupts_end_after_a_whole_pass() {
        let interrupted = AtomicBool::new(false);
        let stop =
            Stop { at_least: 1, passes: None, time: Some(Duration::ZERO), target: None, interrupted: &interrupted };
        assert_eq!(super::render(&Counting, (2, 1), &stop, &Silent, |_| {}).ended, Ended::Time);
        let stop = Stop { at_least: 1, passes: None, time: None, target: None, interrupted: &interrupted };
        let mut made = 0;
        let rendered = super::render(&Counting, (2, 1), &stop, &Silent, |standing| {
            made = standing.passes;
            interrupted.store(made == 3, Ordering::Relaxed);
        });
        assert_eq!((rendered.ended, made, rendered.film.passes()), (Ended::Interrupted, 3, 3));
    }
}
