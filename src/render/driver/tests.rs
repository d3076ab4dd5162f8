use super::*;
use crate::color::Rgb;
use crate::integrate::{Pass, SilentMonitor};
use crate::plan::{Effects, Plan};

/// Test integrator: all pixels of its pass number i have radiance i.
struct PassNumberIntegrator;

impl Integrator for PassNumberIntegrator {
    fn render_pass(&self, pass: u32, _: &dyn ProgressMonitor) -> Pass {
        Pass { image: vec![Rgb::splat(pass as f32); 2], ..Pass::default() }
    }

    fn expected_work(&self, _: Effects) -> Counters {
        Counters::default()
    }

    fn plan(&self) -> &Plan {
        unreachable!("the render loop does not use the plan")
    }
}

fn stop_criteria(passes: Option<u32>, time: Option<Duration>, interrupted: &AtomicBool) -> StopCriteria<'_> {
    StopCriteria { passes, time, ..StopCriteria::unlimited(interrupted) }
}

#[test]
fn the_image_is_the_mean_of_the_passes() {
    let interrupted = AtomicBool::new(false);
    let rendered =
        render(&PassNumberIntegrator, (2, 1), &stop_criteria(Some(4), None, &interrupted), &SilentMonitor, |_| {});
    assert_eq!((rendered.ended, rendered.film.passes()), (EndReason::Passes, 4));
    assert_eq!(rendered.film.mean(), vec![Rgb::splat(1.5); 2]);
}

#[test]
fn time_and_interrupts_end_after_a_whole_pass() {
    let interrupted = AtomicBool::new(false);
    let timed = stop_criteria(None, Some(Duration::ZERO), &interrupted);
    assert_eq!(render(&PassNumberIntegrator, (2, 1), &timed, &SilentMonitor, |_| {}).ended, EndReason::Time);
    let mut passes = 0;
    let rendered =
        render(&PassNumberIntegrator, (2, 1), &stop_criteria(None, None, &interrupted), &SilentMonitor, |after| {
            passes = after.passes;
            interrupted.store(passes == 3, Ordering::Relaxed);
        });
    assert_eq!((rendered.ended, passes, rendered.film.passes()), (EndReason::Interrupted, 3, 3));
}
