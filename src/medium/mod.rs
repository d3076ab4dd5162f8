//! Participating media: absorption, scattering and emission between surfaces.

mod cloud;
mod grid_density;
mod homogeneous;
mod majorant_iterator;
mod phase_function;
mod tracking;

pub use cloud::Cloud;
pub use grid_density::{GridDensity, GridDensityError};
pub use homogeneous::transmittance;
pub use phase_function::PhaseFunction;

use crate::color::Rgb;
use crate::math::Ray;
use glam::{DAffine3, DVec3, Vec3};
use rand::Rng;
use std::sync::Arc;

/// A participating medium: coefficients at density 1, and an optional grid of densities.
///
/// The coefficient at a point is the coefficient at density 1 times the density at the point.
/// Coefficients are finite and at least 0; scene import checks this.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Absorption coefficient σa at density 1 \[1/length].
    pub absorption: Rgb,
    /// Scattering coefficient σs at density 1 \[1/length].
    pub scattering: Rgb,
    /// Emitted radiance per length at density 1 \[W/(m² sr) per length].
    pub emission: Rgb,
    /// Distribution of directions after scattering.
    pub phase: PhaseFunction,
    /// Density by position; `None` for density 1 everywhere.
    density: Option<Arc<GridDensity>>,
}

/// Result of distance sampling along a ray in a medium: where the ray scatters, and the factor for
/// the path throughput.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceSample {
    /// Distance from the ray's origin to the scattering point \[length]; `None` if the ray passes
    /// through the medium without scattering.
    pub scattering_distance: Option<f32>,
    /// Factor by which the path throughput changes, up to the scattering point or, without
    /// scattering, up to the end of the ray.
    ///
    /// After scattering, the factor is σs·T divided by the pdf of the distance, where T is the
    /// transmittance. If the ray passes through, the factor is T divided by the probability of
    /// passing through. In a heterogeneous medium, the factor is an estimate, which Russian
    /// roulette may set to 0.
    ///
    /// In a medium that scatters, the factor is 0 in channels where the throughput is 0, because
    /// these channels are never sampled.
    pub weight: Rgb,
}

/// Estimated transmittance as a function of distance along a ray, by one run of ratio tracking.
///
/// Each value is unbiased, and exact in a homogeneous medium. Values at different distances are
/// correlated. Density estimates along a camera ray use one curve for all photons near the ray.
#[derive(Clone, Debug, Default)]
pub struct TransmittanceCurve {
    /// Extinction coefficient of a homogeneous medium \[1/length]; zero for a medium with a density
    /// grid.
    homogeneous_extinction: Rgb,
    /// Distances \[length] of the tentative collisions in a density grid, each with the
    /// transmittance just beyond it. Empty for a homogeneous medium.
    steps: Vec<(f32, Rgb)>,
}

impl TransmittanceCurve {
    /// Samples a new curve along the first `distance` \[length] of `ray`, which has a unit
    /// direction.
    ///
    /// The curve replaces the previous one in `self` and reuses its memory.
    pub fn sample(&mut self, medium: &Medium, ray: &Ray, distance: f32, rng: &mut impl Rng) {
        self.steps.clear();
        self.homogeneous_extinction = Rgb::ZERO;
        match &medium.density {
            None => self.homogeneous_extinction = medium.extinction(),
            Some(grid) => tracking::sample_transmittance_curve(medium, grid, ray, distance, rng, self),
        }
    }

    /// Transmittance from the ray's origin to distance `t` \[length]; exact in a homogeneous
    /// medium, else unbiased.
    ///
    /// `t` must not exceed the `distance` that was given to [`TransmittanceCurve::sample`].
    #[inline]
    #[must_use]
    pub fn transmittance_at(&self, t: f32) -> Rgb {
        if self.homogeneous_extinction != Rgb::ZERO {
            return homogeneous::transmittance(self.homogeneous_extinction, t);
        }
        match self.steps.partition_point(|(drop, _)| *drop <= t) {
            0 => Rgb::ONE,
            n => self.steps[n - 1].1,
        }
    }
}

impl Medium {
    /// Creates a homogeneous medium with density 1.
    #[must_use]
    pub fn homogeneous(absorption: Rgb, scattering: Rgb, emission: Rgb, phase: PhaseFunction) -> Self {
        Self { absorption, scattering, emission, phase, density: None }
    }

    /// Creates a heterogeneous medium. Its coefficients are the given ones times `density`.
    #[must_use]
    pub fn heterogeneous(
        absorption: Rgb,
        scattering: Rgb,
        emission: Rgb,
        phase: PhaseFunction,
        density: Arc<GridDensity>,
    ) -> Self {
        Self { absorption, scattering, emission, phase, density: Some(density) }
    }

    /// Extinction coefficient σt = σa + σs at density 1 \[1/length].
    #[inline]
    #[must_use]
    pub fn extinction(&self) -> Rgb {
        self.absorption + self.scattering
    }

    /// True if the medium has no density grid, so that its density is 1 everywhere.
    #[must_use]
    pub fn is_homogeneous(&self) -> bool {
        self.density.is_none()
    }

    /// True if the medium has no effect on light: it neither absorbs, scatters nor emits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let nowhere = self.density.as_ref().is_some_and(|grid| grid.max_density() == 0.0);
        nowhere || (self.extinction() == Rgb::ZERO && self.emission == Rgb::ZERO)
    }

    /// True if the medium scatters in at least one color channel; false if its density is 0
    /// everywhere.
    #[must_use]
    pub fn scatters(&self) -> bool {
        self.scattering != Rgb::ZERO && !self.is_empty()
    }

    /// True if the medium emits in at least one color channel; false if its density is 0
    /// everywhere.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission != Rgb::ZERO && !self.is_empty()
    }

    /// Density at point `p` in scene coordinates; 1 in a homogeneous medium, 0 outside a density
    /// grid.
    #[must_use]
    pub fn density_at(&self, p: Vec3) -> f32 {
        self.density.as_ref().map_or(1.0, |grid| grid.density(p))
    }

    /// Transmittance along the first `distance` \[length] of `ray`, which has a unit direction.
    ///
    /// The value is exact in a homogeneous medium, else an unbiased estimate by ratio tracking
    /// (Novák, Selle, Jarosz 2014). The distance may be infinite.
    #[must_use]
    pub fn transmittance(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
        match &self.density {
            None => homogeneous::transmittance(self.extinction(), distance),
            Some(grid) => tracking::transmittance(self, grid, ray, distance, rng),
        }
    }

    /// Returns [`Medium::transmittance`] in f64, for products over many segments. In f32, a factor
    /// near 1 loses digits.
    #[must_use]
    pub fn transmittance_f64(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> DVec3 {
        match &self.density {
            None => homogeneous::transmittance_f64(self.extinction(), distance),
            Some(_) => self.transmittance(ray, distance, rng).as_dvec3(),
        }
    }

    /// Samples the distance of the first scattering within the first `distance` \[length] of `ray`,
    /// which has a unit direction.
    ///
    /// `throughput` is the throughput of the path at the start of the ray. The channel mean of
    /// `throughput` times the weight does not exceed that of `throughput`, except through Russian
    /// roulette. In a homogeneous gray medium, the weight is σs/σt after scattering, and 1 if the
    /// ray passes through.
    ///
    /// In a medium that does not scatter, the ray always passes through, and the weight is the
    /// [`transmittance`](Self::transmittance). The distance may be infinite.
    #[must_use]
    pub fn distance_sample(&self, ray: &Ray, distance: f32, throughput: Rgb, rng: &mut impl Rng) -> DistanceSample {
        if !self.scatters() {
            return DistanceSample { scattering_distance: None, weight: self.transmittance(ray, distance, rng) };
        }
        match &self.density {
            None => homogeneous::distance_sample(self, distance, throughput, rng),
            Some(grid) => tracking::distance_sample(self, grid, ray, distance, throughput, rng),
        }
    }

    /// Pdf \[1/length] with which [`distance_sample`](Self::distance_sample) samples scattering at
    /// distance `t` \[length]; 0 in a medium that does not scatter.
    ///
    /// Returns `None` in a heterogeneous medium that scatters, because the pdf of tracking is not
    /// known. `throughput` is the throughput of the path at the start of the ray.
    #[must_use]
    pub fn distance_pdf(&self, t: f32, throughput: Rgb) -> Option<f32> {
        if !self.scatters() {
            return Some(0.0);
        }
        self.is_homogeneous().then(|| homogeneous::distance_pdf(self.extinction(), t, throughput))
    }

    /// Radiance \[W/(m² sr)] that reaches the ray's origin from the medium's emission along the
    /// first `distance` \[length] of `ray`, which has a unit direction.
    ///
    /// The value is exact in a homogeneous medium, else an unbiased estimate. Over an infinite
    /// distance, a homogeneous medium gives infinite radiance in a channel that emits without
    /// extinction.
    #[must_use]
    pub fn emitted_radiance(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
        if !self.emits() {
            return Rgb::ZERO;
        }
        match &self.density {
            None => homogeneous::emitted_radiance(self, distance),
            Some(grid) => tracking::emitted_radiance(self, grid, ray, distance, rng),
        }
    }

    /// Returns a copy of the medium, whose density grid is translated by `by` \[scene coordinates].
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        let density = self.density.as_ref().map(|grid| Arc::new(grid.translated(by)));
        Self { density, ..self.clone() }
    }

    /// Returns a copy of the medium, whose density grid is transformed by `map`; `None` if a grid
    /// exists and the map is singular.
    ///
    /// Coefficients and density values stay the same, even if the map scales.
    #[must_use]
    pub fn with_transformed_grid(&self, map: DAffine3) -> Option<Self> {
        let Some(grid) = &self.density else { return Some(self.clone()) };
        Some(Self { density: Some(Arc::new(grid.transformed(map)?)), ..self.clone() })
    }
}

/// Returns the probabilities with which distance sampling chooses the RGB channels, proportional to
/// `throughput`. The probabilities are ⅓ each if the throughput is zero or its sum is infinite.
fn channel_probabilities(throughput: Rgb) -> DVec3 {
    // `max` turns NaN into 0.
    let part = throughput.to_array().map(|x| f64::from(x.max(0.0)));
    let part = DVec3::from_array(part);
    let sum = part.element_sum();
    if sum > 0.0 && sum.is_finite() { part / sum } else { DVec3::splat(1.0 / 3.0) }
}

/// Converts the RGB weight `w` of a distance sample to f32, with each channel at most `f32::MAX`.
/// The result is 0 in channels whose sampling probability is 0.
fn zero_unsampled_channels(w: DVec3, probabilities: DVec3) -> Rgb {
    let most = f64::from(f32::MAX);
    DVec3::select(probabilities.cmpgt(DVec3::ZERO), w.min(DVec3::splat(most)), DVec3::ZERO).as_vec3()
}

#[cfg(test)]
mod tests;
