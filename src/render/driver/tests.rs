use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::integrate::{Algorithm, PassResult, PassStage, Settings, SilentMonitor};
use crate::plan::Plan;
use crate::scene::{Effects, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use crate::shape::{Plane, Shape, Sphere};
use glam::DVec3;
use std::sync::atomic::{AtomicU32, AtomicU64};

/// Test integrator: all pixels of pass number i have radiance i.
struct PassNumberIntegrator;

impl Integrator for PassNumberIntegrator {
    fn render_pass(&self, pass: u32, _: &dyn ProgressMonitor) -> PassResult {
        PassResult { image: vec![Rgb::splat(pass as f32); 2], ..PassResult::default() }
    }

    fn expected_work(&self, _: Effects) -> Counters {
        Counters::default()
    }

    fn plan(&self) -> &Plan {
        unreachable!("the render loop does not use the plan")
    }
}

fn stop_criteria(passes: Option<u32>, time: Option<Duration>, interrupted: &AtomicBool) -> StopCriteria<'_> {
    StopCriteria { max_passes: passes, time_limit: time, ..StopCriteria::unlimited(interrupted) }
}

#[test]
fn the_image_is_the_mean_of_the_passes() {
    let interrupted = AtomicBool::new(false);
    let rendered = render(
        RenderResult::without_passes(&PassNumberIntegrator, (2, 1)),
        0..u32::MAX,
        &PassNumberIntegrator,
        &stop_criteria(Some(4), None, &interrupted),
        &SilentMonitor,
        |_| {},
    );
    assert_eq!((rendered.end_reason, rendered.film.passes()), (EndReason::Passes, 4));
    assert_eq!(rendered.film.mean_picture(), vec![Rgb::splat(1.5); 2]);
}

/// Monitor that cancels the second pass as soon as `stage` of that pass reports progress.
struct CancellingMonitor {
    stage: PassStage,
    /// Number of passes that have begun `stage`.
    passes: AtomicU32,
    /// True between the start of `stage` and that of the next stage.
    is_in_stage: AtomicBool,
    /// Number of units that `stage` reported in the second pass.
    units: AtomicU64,
}

impl ProgressMonitor for CancellingMonitor {
    fn begin_stage(&self, stage: PassStage, _: u64) {
        self.is_in_stage.store(stage == self.stage, Ordering::Relaxed);
        if stage == self.stage {
            self.passes.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn report_progress(&self, units: u64) {
        if self.is_in_stage.load(Ordering::Relaxed) && self.passes.load(Ordering::Relaxed) == 2 {
            self.units.fetch_add(units, Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.units.load(Ordering::Relaxed) > 0
    }
}

/// Returns a white ball on a white floor below a lamp, with a picture of 64 × 64 pixels.
fn lit_ball() -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Rgb::splat(0.8)));
    let (lamp, strength) = (UnscaledDeltaLight::Point { position: 2.0 * DVec3::Y }, LightStrength::Power(Rgb::ONE));
    let ball = Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.5, 0.0), 0.5));
    builder.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Rgb::ZERO).add_shape(ball, white, Rgb::ZERO);
    builder.add_delta_light(lamp, strength);
    let camera = Camera::perspective(DVec3::new(0.0, 2.0, 4.0), DVec3::new(0.0, -0.5, -1.0), DVec3::Y, 0.7, 64, 64);
    builder.build(camera.unwrap()).unwrap()
}

#[test]
fn a_cancelled_pass_stops_early_and_is_dropped() {
    const PHOTONS: u32 = 1 << 20;
    let (scene, interrupted) = (lit_ball(), AtomicBool::new(false));
    let settings = Settings { unaimed_paths: PHOTONS, ..Settings::default() };
    let integrator = Algorithm::Sppm.prepare(&scene, settings);
    let first = render(
        RenderResult::without_passes(integrator.as_ref(), (64, 64)),
        0..u32::MAX,
        integrator.as_ref(),
        &stop_criteria(Some(1), None, &interrupted),
        &SilentMonitor,
        |_| {},
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for (stage, all) in [(PassStage::Photons, u64::from(PHOTONS)), (PassStage::Camera, 64 * 64)] {
        let (passes, is_in_stage, units) = (AtomicU32::new(0), AtomicBool::new(false), AtomicU64::new(0));
        let monitor = CancellingMonitor { stage, passes, is_in_stage, units };
        let stop = stop_criteria(Some(3), None, &interrupted);
        let rendered = pool.install(|| {
            render(
                RenderResult::without_passes(integrator.as_ref(), (64, 64)),
                0..u32::MAX,
                integrator.as_ref(),
                &stop,
                &monitor,
                |_| {},
            )
        });
        assert_eq!((rendered.end_reason, rendered.film.passes()), (EndReason::Interrupted, 1), "{stage:?}");
        assert!(rendered.film == first.film, "{stage:?}");
        // Each of the two threads may finish the chunk or tile that it has begun.
        assert!(monitor.units.into_inner() < all / 2, "{stage:?}");
    }
}

/// Each call of `render` makes one pass, even if loading and pilots alone take longer than the time
/// limit.
#[test]
fn continued_renders_make_a_pass_after_slow_pilots() {
    let interrupted = AtomicBool::new(false);
    let slow_pilots = StopCriteria {
        time_before_passes: Duration::from_secs(2),
        ..stop_criteria(None, Some(Duration::from_secs(1)), &interrupted)
    };
    let mut rendered = RenderResult::without_passes(&PassNumberIntegrator, (2, 1));
    for passes in 1..=3 {
        rendered = render(rendered, 0..u32::MAX, &PassNumberIntegrator, &slow_pilots, &SilentMonitor, |_| {});
        assert_eq!((rendered.film.passes(), rendered.end_reason), (passes, EndReason::Time));
    }
}

/// A render with a time limit of 10 s ends after the pass whose end is nearest to it. Loading and
/// pilots take 4 s of this time.
#[test]
fn a_timed_render_ends_at_the_nearest_pass() {
    let interrupted = AtomicBool::new(false);
    let limit = Some(Duration::from_secs(10));
    let timed = StopCriteria { time_before_passes: Duration::from_secs(4), ..stop_criteria(None, limit, &interrupted) };
    let end = |passes: u32, pass_seconds: u64| {
        let total = Duration::from_secs(u64::from(passes) * pass_seconds);
        timed.end_reason(passes, None, PassTimes::new(total, passes))
    };
    // Passes end after 6, 8, 10 and 12 s.
    let ends = [None, None, Some(EndReason::Time), Some(EndReason::Time)];
    assert_eq!([1, 2, 3, 4].map(|passes| end(passes, 2)), ends);
    // Passes end after 7 and 10 s.
    assert_eq!([1, 2].map(|passes| end(passes, 3)), [None, Some(EndReason::Time)]);
    // The first pass ends after 9 s, the second after 14 s.
    assert_eq!(end(1, 5), Some(EndReason::Time));
}

#[test]
fn time_and_interrupts_end_after_a_whole_pass() {
    let interrupted = AtomicBool::new(false);
    let timed = stop_criteria(None, Some(Duration::ZERO), &interrupted);
    assert_eq!(
        render(
            RenderResult::without_passes(&PassNumberIntegrator, (2, 1)),
            0..u32::MAX,
            &PassNumberIntegrator,
            &timed,
            &SilentMonitor,
            |_| {}
        )
        .end_reason,
        EndReason::Time
    );
    let mut passes = 0;
    let rendered = render(
        RenderResult::without_passes(&PassNumberIntegrator, (2, 1)),
        0..u32::MAX,
        &PassNumberIntegrator,
        &stop_criteria(None, None, &interrupted),
        &SilentMonitor,
        |after| {
            passes = after.passes;
            interrupted.store(passes == 3, Ordering::Relaxed);
        },
    );
    assert_eq!((rendered.end_reason, passes, rendered.film.passes()), (EndReason::Interrupted, 3, 3));
}
