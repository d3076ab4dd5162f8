//! Driving an integrator: passes, when to stop, the mean of what they gave.

mod film;
pub mod gauge;

pub use film::Film;

use crate::integrate::{Integrator, Monitor, PhotonReport, Seconds};
use crate::stats::Counters;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// When a render ends; at least one pass is always made.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a> {
    /// After so many passes.
    pub passes: Option<u32>,
    /// After the pass during which so much time has gone by.
    pub time: Option<Duration>,
    /// After the pass during which this becomes true.
    pub interrupted: &'a AtomicBool,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ended {
    /// All passes were made.
    Passes,
    /// Time was up.
    Time,
    /// The user asked.
    Interrupted,
}

/// A finished render.
#[derive(Debug)]
pub struct Rendered {
    /// The sum of all passes.
    pub film: Film,
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

/// Renders passes 0, 1, 2 … of an image of `size` pixels until `stop`. `after` hears the number of passes made after each.
pub fn render(
    integrator: &dyn Integrator,
    size: (u32, u32),
    stop: &Stop<'_>,
    monitor: &dyn Monitor,
    mut after: impl FnMut(u32),
) -> Rendered {
    let start = Instant::now();
    let mut rendered = Rendered {
        film: Film::new(size.0, size.1),
        ended: Ended::Passes,
        counters: Counters::default(),
        seconds: Seconds::default(),
        global: PhotonReport::default(),
        caustic: PhotonReport::default(),
        wall: Duration::ZERO,
    };
    loop {
        let pass = integrator.pass(rendered.film.passes(), monitor);
        rendered.film.add(&pass.image);
        rendered.counters += pass.counters;
        rendered.seconds += pass.seconds;
        rendered.global += pass.global;
        rendered.caustic += pass.caustic;
        let made = rendered.film.passes();
        after(made);
        let ended = if stop.interrupted.load(Ordering::Relaxed) {
            Some(Ended::Interrupted)
        } else if stop.passes.is_some_and(|most| made >= most) || made == u32::MAX {
            Some(Ended::Passes)
        } else if stop.time.is_some_and(|most| start.elapsed() >= most) {
            Some(Ended::Time)
        } else {
            None
        };
        if let Some(ended) = ended {
            rendered.ended = ended;
            rendered.wall = start.elapsed();
            return rendered;
        }
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
        let stop = Stop { passes: Some(4), time: None, interrupted: &AtomicBool::new(false) };
        let rendered = super::render(&Counting, (2, 1), &stop, &Silent, |_| {});
        assert_eq!((rendered.ended, rendered.film.passes()), (Ended::Passes, 4));
        assert_eq!(rendered.film.mean(), vec![Rgb::splat(1.5); 2]);
    }

    #[test]
    fn time_and_interrupts_end_after_a_whole_pass() {
        let interrupted = AtomicBool::new(false);
        let stop = Stop { passes: None, time: Some(Duration::ZERO), interrupted: &interrupted };
        assert_eq!(super::render(&Counting, (2, 1), &stop, &Silent, |_| {}).ended, Ended::Time);
        let stop = Stop { passes: None, time: None, interrupted: &interrupted };
        let mut made = 0;
        let rendered = super::render(&Counting, (2, 1), &stop, &Silent, |n| {
            made = n;
            interrupted.store(n == 3, Ordering::Relaxed);
        });
        assert_eq!((rendered.ended, made, rendered.film.passes()), (Ended::Interrupted, 3, 3));
    }
}
