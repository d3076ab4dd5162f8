//! Camera walks through media.

use super::{Branch, EyePass, Last, Next};
use crate::color::{self, Rgb};
use crate::integrate::direct::Scattering;
use crate::integrate::method::{History, Method, Passage};
use crate::integrate::tiles::Worker;
use crate::medium::PhaseFunction;
use crate::sampling::Dimension;
use crate::scene::{Interior, MediumSegment, PathEvent};
use glam::DVec3;
use rand::rngs::SmallRng;

/// Tells the numbers of ways from those of shadow rays.
const WAY: u64 = 1 << 63;

impl<M: Method> EyePass<'_, M> {
    /// Goes to where a walk ends or is scattered, by what phase function, and adds what the media on the way send back.
    pub(super) fn advance_in_media<I: Interior>(
        &self,
        branch: &mut Branch<I>,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> (PathEvent<'_>, PhaseFunction) {
        let mut rng = branch.draw.key().with(WAY | u64::from(self.pass)).rng();
        let mut walk = branch.walk;
        let mut phase = PhaseFunction::Isotropic;
        let mut passed = DVec3::ONE;
        let step = walk.next_vertex(self.scene, branch.draw.key(), |stretch| {
            phase = stretch.medium.phase;
            self.through(branch, stretch, &mut passed, &mut rng, worker, radiance)
        });
        branch.walk = walk;
        branch.throughput *= passed.as_vec3();
        (step, phase)
    }

    /// Adds what a stretch of a medium sends back, and takes the walk through it or to where it is scattered. `passed` is what the walk's
    /// throughput is multiplied by for the stretches before.
    fn through<I: Interior>(
        &self,
        branch: &Branch<I>,
        stretch: &MediumSegment<'_, I>,
        passed: &mut DVec3,
        rng: &mut SmallRng,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> Option<f32> {
        let MediumSegment { medium, ray, .. } = stretch;
        let here = branch.throughput * passed.as_vec3() * stretch.left;
        if medium.emits() {
            *radiance += here * medium.emitted(ray, ray.t_max, rng);
        }
        if !medium.scatters() {
            *passed *= medium.transmittance_f64(ray, ray.t_max, rng);
            return None;
        }
        let history = History { casters: branch.history.casters + u32::from(stretch.crossed), ..branch.history };
        let mut to_do = self.method.in_medium(history);
        to_do.onward &= branch.bounce < self.settings.max_bounces;
        let distance_sample = medium.distance_sample(ray, ray.t_max, here, rng);
        let mut found = Rgb::ZERO;
        if to_do.direct {
            let shadow_draw = branch.draw.with(u64::from(self.pass) << 32);
            let onward = to_do.onward;
            let scattering = Scattering {
                stretch,
                throughput: here,
                distance_sample: &distance_sample,
                history,
                onward,
                shadow_draw,
            };
            found += self.direct.scattered(&scattering, worker);
        }
        found += self.method.volume(&Passage { stretch, history, throughput: here, draw: branch.draw }, rng, worker);
        *radiance += here * found;
        if to_do.onward {
            *passed *= distance_sample.weight.as_dvec3();
            return distance_sample.scattered;
        }
        *passed *= medium.transmittance_f64(ray, ray.t_max, rng);
        None
    }

    /// Goes on from where a walk was scattered in a medium.
    pub(super) fn scatter<I: Interior>(&self, branch: &mut Branch<I>, phase: PhaseFunction) -> Option<Next<I>> {
        let mut next = *branch;
        let (direction, pdf) = phase.sample(next.walk.ray.direction, branch.draw.get_2d(Dimension::Phase));
        next.walk.turn(direction);
        next.last = Some(Last { p: next.walk.ray.origin, horizon: None, history: branch.history, pdf });
        next.history = History { receivers: branch.history.receivers + 1, casters: 0 };
        next.bounce += 1;
        next.draw = branch.draw.with(u64::from(branch.bounce) << 1);
        let strength = color::mean(next.throughput);
        let survival = (strength / super::CERTAIN).min(1.0);
        if survival.is_nan() || branch.draw.get_1d(Dimension::Roulette) >= survival {
            return None;
        }
        next.throughput /= survival;
        *branch = next;
        Some(Next::One)
    }
}
