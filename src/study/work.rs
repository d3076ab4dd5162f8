//! Expected work of a render: numbers of rays and photons of a pass. Unlike times, these numbers do
//! not depend on the machine.

use crate::integrate::Integrator;
use crate::scene::{Effect, Effects};

/// Numbers of rays and gathered photons: the work of a pass, or the work that an effect adds to a
/// pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkCounts {
    /// Number of rays of all kinds, such as camera rays and shadow rays.
    pub rays: i64,
    /// Number of gathered photons, summed over all density estimates.
    pub gathered_photons: i64,
}

/// Expected work of the first pass of a render, in total and for each effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedWork {
    /// Work of the first pass with all effects of the plan.
    pub total: WorkCounts,
    /// Work that each simulated effect adds to the first pass. Effects are in the order of
    /// [`Effect::ALL`].
    pub effects: Vec<(Effect, WorkCounts)>,
}

impl ExpectedWork {
    /// Returns the work that `effect` adds to a pass; `None` if the plan does not simulate the
    /// effect.
    #[must_use]
    pub fn work_of_effect(&self, effect: Effect) -> Option<WorkCounts> {
        self.effects.iter().find(|(e, _)| *e == effect).map(|(_, work)| *work)
    }
}

/// Returns the expected work of the first pass, without the work of pilots (small simulations
/// before the first pass).
///
/// The estimate comes from camera paths through about a thousand points of the film. For ray
/// casting, the number of rays is exact.
#[must_use]
pub fn expected_work(integrator: &dyn Integrator) -> ExpectedWork {
    let effects = integrator.plan().simulated_effects();
    let counts_with = |effects: Effects| {
        let counters = integrator.expected_work(effects);
        [counters.total_rays(), counters.gathered_photons].map(|n| i64::try_from(n).unwrap_or(i64::MAX))
    };
    let [rays, gathered_photons] = counts_with(effects);
    let adds = |effect: Effect| {
        let [rays_without, photons_without] = counts_with(effects.without_effect(effect));
        (effect, WorkCounts { rays: rays - rays_without, gathered_photons: gathered_photons - photons_without })
    };
    ExpectedWork { total: WorkCounts { rays, gathered_photons }, effects: effects.iter().map(adds).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Algorithm, Settings, SilentMonitor};
    use crate::study::tests::{diffuse_sphere_on_floor, glass_sphere_on_floor};

    /// Camera rays are counted exactly: one per pixel and sample.
    #[test]
    fn expected_camera_rays_are_exact() {
        let mut settings = Settings::default();
        settings.camera_paths.samples_per_pixel = Some(100);
        let scene = diffuse_sphere_on_floor(640, 480);
        let work = expected_work(Algorithm::Raycast.prepare(&scene, settings).as_ref());
        assert_eq!(
            work,
            ExpectedWork { total: WorkCounts { rays: 640 * 480 * 100, gathered_photons: 0 }, effects: vec![] }
        );
    }

    /// Expected work agrees with the counters of a whole pass. The estimate from a thousand film
    /// points has an error of a few percent. The numbers of gathered photons are less exact,
    /// because they vary most in caustics.
    #[test]
    fn expected_work_matches_a_pass() {
        let settings = Settings {
            unaimed_paths: 100_000,
            aimed_paths: 100_000,
            allows_ray_photon_balance: false,
            initial_gather_radius: Some(0.5),
            ..Settings::default()
        };
        let scene = glass_sphere_on_floor(128, 96);
        for algorithm in [Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Pm] {
            let integrator = algorithm.prepare(&scene, settings.clone());
            let counters = integrator.render_pass(0, &SilentMonitor).counters;
            let work = expected_work(integrator.as_ref());
            let close = |a: i64, b: u64, within: f64| {
                assert!((a as f64 / b as f64 - 1.0).abs() < within, "{algorithm:?} {a} {b}");
            };
            close(work.total.rays, counters.total_rays(), 0.1);
            close(work.total.gathered_photons, counters.gathered_photons, 0.25);
            assert!(work.work_of_effect(Effect::Caustics).unwrap().gathered_photons > 0);
            assert_eq!(work.work_of_effect(Effect::Environment), None);
        }
    }
}
