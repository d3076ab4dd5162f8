//! Integrator of synthetic passes, for tests of the render loop.

use crate::color::Rgb;
use crate::integrate::{Integrator, NestedDifferences, PassResult, ProgressMonitor, RadiusLaw};
use crate::photon::Kernel;
use crate::plan::Plan;
use crate::sampling::{Dimension, Key, Purpose};
use crate::scene::Effects;
use crate::stats::Counters;

/// Width and height of the passes of [`NoisyIntegrator`] \[pixels].
pub(super) const SIZE: (u32, u32) = (40, 40);

/// Integrator whose passes have radiance 1 plus noise and a constant bias.
pub(super) struct NoisyIntegrator {
    /// Standard deviation of each channel of a pixel.
    pub sigma: f32,
    /// Constant error of each channel. Error estimates treat this error like the blur of density
    /// estimates with fixed gather radii in smooth light.
    pub bias: f32,
    /// True if the render estimates its error: value of [`Integrator::estimates_error`].
    pub estimates_error: bool,
}

impl Integrator for NoisyIntegrator {
    fn render_pass(&self, pass: u32, _: &dyn ProgressMonitor) -> PassResult {
        let key = Key::new(7).purpose_key(Purpose::Test).child_key(u64::from(pass));
        let noise = |pixel: u32| {
            let uniform = key.child_key(u64::from(pixel)).uniform_1d(Dimension::Film);
            Rgb::splat(self.sigma * (uniform - 0.5) * 12f32.sqrt())
        };
        let pixels = SIZE.0 * SIZE.1;
        let differences = [0.5, 0.25].map(|part| Rgb::splat(part * self.bias));
        let nested = NestedDifferences { differences, ..NestedDifferences::default() };
        PassResult {
            image: (0..pixels).map(|pixel| Rgb::splat(1.0 + self.bias) + noise(pixel)).collect(),
            nested: vec![nested; pixels as usize],
            ..PassResult::default()
        }
    }

    fn expected_work(&self, _: Effects) -> Counters {
        Counters::default()
    }

    fn plan(&self) -> &Plan {
        unreachable!("the render loop does not use the plan")
    }

    fn radius_law(&self) -> Option<RadiusLaw> {
        Some(RadiusLaw { alpha: 1.0, kernel: Kernel::Epanechnikov })
    }

    fn estimates_error(&self) -> bool {
        self.estimates_error
    }
}
