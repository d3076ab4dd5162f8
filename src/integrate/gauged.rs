//! What a pass tells of the error of its estimates.

use crate::color::Rgb;
use crate::photon::LEVELS;
use glam::DVec3;
use serde::Serialize;

/// The discs of the estimates of a pixel from one map, in the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Discs {
    /// Radius \[length].
    pub radius: f32,
    /// Photons.
    pub photons: f32,
}

/// What a pass tells of a pixel.
///
/// The bias of an estimate goes with its disc. What the photons of a pass tell at finer discs, beside what they tell at their own, shows how
/// much: the differences are free of bias themselves, and of all noise that the discs share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauged {
    /// The pixel less the same with discs of half the area, and that less the same with a quarter \[W/(m² sr)].
    pub steps: [Rgb; LEVELS - 1],
    /// Discs in the caustic map; `None` where no estimate was made.
    pub caustic: Option<Discs>,
    /// Discs in the other map.
    pub global: Option<Discs>,
}

/// Sums over estimates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DiscSum {
    radius: f32,
    photons: f32,
    count: u32,
}

impl DiscSum {
    pub fn add(&mut self, radius: f32, photons: u32) {
        self.radius += radius;
        self.photons += photons as f32;
        self.count += 1;
    }

    fn mean(self) -> Option<Discs> {
        let n = self.count as f32;
        (self.count > 0).then(|| Discs { radius: self.radius / n, photons: self.photons / n })
    }
}

/// What is gathered of one camera ray, and then of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// Of the ray.
    ray: [Rgb; LEVELS - 1],
    /// Of the pixel's rays, weighted by the filter.
    pixel: [DVec3; LEVELS - 1],
    pub caustic: DiscSum,
    pub global: DiscSum,
}

impl Tally {
    /// Notes what an estimate that reaches the pixel by `throughput` tells at each level.
    #[inline]
    pub fn note(&mut self, throughput: Rgb, radiance: [Rgb; LEVELS]) {
        for (sum, pair) in self.ray.iter_mut().zip(radiance.windows(2)) {
            *sum += throughput * (pair[0] - pair[1]);
        }
    }

    /// A ray ends; where it is left out of the picture, `weight` is `None`.
    #[inline]
    pub fn end_ray(&mut self, weight: Option<f32>) {
        if let Some(weight) = weight.filter(|_| self.ray.iter().all(|step| step.is_finite())) {
            for (sum, step) in self.pixel.iter_mut().zip(self.ray) {
                *sum += step.as_dvec3() * f64::from(weight);
            }
        }
        self.ray = [Rgb::ZERO; LEVELS - 1];
    }

    /// What is known of a pixel of so many rays; the next one begins.
    pub fn end_pixel(&mut self, rays: u32) -> Gauged {
        let steps = self.pixel.map(|sum| (sum / f64::from(rays)).as_vec3());
        let gauged = Gauged { steps, caustic: self.caustic.mean(), global: self.global.mean() };
        *self = Self::default();
        gauged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_the_mean_of_its_rays_and_what_is_left_out_does_not_count() {
        let mut tally = Tally::default();
        let levels = |a: f32, b: f32, c: f32| [a, b, c].map(Rgb::splat);
        tally.note(Rgb::splat(0.5), levels(4.0, 2.0, 1.0));
        tally.note(Rgb::ONE, levels(1.0, 1.0, 2.0));
        tally.caustic.add(0.5, 10);
        tally.caustic.add(1.5, 20);
        tally.end_ray(Some(1.0));
        tally.note(Rgb::ONE, levels(100.0, 0.0, 0.0));
        tally.end_ray(None);
        tally.note(Rgb::ONE, levels(f32::INFINITY, 0.0, 0.0));
        tally.end_ray(Some(1.0));
        let gauged = tally.end_pixel(2);
        assert_eq!(gauged.steps, [Rgb::splat(0.5), Rgb::splat(-0.25)]);
        assert_eq!((gauged.caustic, gauged.global), (Some(Discs { radius: 1.0, photons: 15.0 }), None));
        assert_eq!(tally.end_pixel(1), Gauged::default());
    }
}
