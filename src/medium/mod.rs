//! Participating media: what absorbs, scatters and emits light between surfaces.

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
use glam::{DVec3, Vec3};
use rand::Rng;
use std::sync::Arc;

/// A medium: coefficients at density 1, and where it is dense.
///
/// Coefficients are finite and at least 0; whoever describes a scene checks that.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Absorption σa \[1/length at density 1].
    pub absorption: Rgb,
    /// Scattering σs \[1/length at density 1].
    pub scattering: Rgb,
    /// Radiance gained along a way \[W/(m² sr) per length at density 1].
    pub emission: Rgb,
    /// Which way light goes on.
    pub phase: PhaseFunction,
    /// `None` is density 1 everywhere.
    density: Option<Arc<GridDensity>>,
}

/// How light came through a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceSample {
    /// Distance at which it scattered; `None` where it got through.
    pub scattered: Option<f32>,
    /// What its throughput is multiplied by: σs·T over the density of scattering there, or T over the probability of getting
    /// through. Zero in channels without throughput.
    pub weight: Rgb,
}

/// What is left of light all along a way: an unbiased estimate at every distance, alike for all.
#[derive(Clone, Debug, Default)]
pub struct TransmittanceCurve {
    extinction: Rgb,
    /// Distances at which it drops, with what is left from there on.
    steps: Vec<(f32, Rgb)>,
}

impl TransmittanceCurve {
    /// Learns of the first `distance` of `ray`, whose direction is a unit vector. Memory is kept.
    pub fn sample(&mut self, medium: &Medium, ray: &Ray, distance: f32, rng: &mut impl Rng) {
        self.steps.clear();
        self.extinction = Rgb::ZERO;
        match &medium.density {
            None => self.extinction = medium.extinction(),
            Some(field) => tracking::fade(medium, field, ray, distance, rng, self),
        }
    }

    /// The part of light that is left after `t`: exact where the medium is homogeneous.
    #[inline]
    #[must_use]
    pub fn left(&self, t: f32) -> Rgb {
        if self.extinction != Rgb::ZERO {
            return homogeneous::transmittance(self.extinction, t);
        }
        match self.steps.partition_point(|(drop, _)| *drop <= t) {
            0 => Rgb::ONE,
            n => self.steps[n - 1].1,
        }
    }
}

impl Medium {
    /// A medium of density 1 everywhere.
    #[must_use]
    pub fn homogeneous(absorption: Rgb, scattering: Rgb, emission: Rgb, phase: PhaseFunction) -> Self {
        Self { absorption, scattering, emission, phase, density: None }
    }

    /// A medium as dense as `density` says.
    #[must_use]
    pub fn varied(
        absorption: Rgb,
        scattering: Rgb,
        emission: Rgb,
        phase: PhaseFunction,
        density: Arc<GridDensity>,
    ) -> Self {
        Self { absorption, scattering, emission, phase, density: Some(density) }
    }

    /// Extinction σt = σa + σs \[1/length at density 1].
    #[inline]
    #[must_use]
    pub fn extinction(&self) -> Rgb {
        self.absorption + self.scattering
    }

    /// Whether it is the same everywhere.
    #[must_use]
    pub fn is_homogeneous(&self) -> bool {
        self.density.is_none()
    }

    /// Whether it does nothing to light.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let nowhere = self.density.as_ref().is_some_and(|field| field.maximum() == 0.0);
        nowhere || (self.extinction() == Rgb::ZERO && self.emission == Rgb::ZERO)
    }

    /// Whether light changes direction in it.
    #[must_use]
    pub fn scatters(&self) -> bool {
        self.scattering != Rgb::ZERO && !self.is_empty()
    }

    /// Whether it gives off light.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission != Rgb::ZERO && !self.is_empty()
    }

    /// The density at a point.
    #[must_use]
    pub fn density_at(&self, p: Vec3) -> f32 {
        self.density.as_ref().map_or(1.0, |field| field.density(p))
    }

    /// The part of light that is left after `distance` along `ray`, whose direction is a unit vector.
    ///
    /// Exact where the medium is homogeneous, else an unbiased estimate by ratio tracking (Novák, Selle, Jarosz 2014). The
    /// distance may be infinite.
    #[must_use]
    pub fn transmittance(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
        match &self.density {
            None => homogeneous::transmittance(self.extinction(), distance),
            Some(field) => tracking::transmittance(self, field, ray, distance, rng),
        }
    }

    /// The same in double precision, for products over many ways: of a way that takes next to nothing, single precision knows little.
    #[must_use]
    pub fn transmittance_f64(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> DVec3 {
        match &self.density {
            None => homogeneous::transmittance_f64(self.extinction(), distance),
            Some(_) => self.transmittance(ray, distance, rng).as_dvec3(),
        }
    }

    /// Where light of `throughput` scatters first within `distance` along `ray`, whose direction is a unit vector.
    ///
    /// The mean of `throughput` times the weight is never above that of `throughput`. In a homogeneous grey medium the weight is
    /// σs/σt where it scatters and 1 where it gets through. A medium that does not scatter is always got through, with its
    /// [`transmittance`](Self::transmittance) as weight. The distance may be infinite.
    #[must_use]
    pub fn distance_sample(&self, ray: &Ray, distance: f32, throughput: Rgb, rng: &mut impl Rng) -> DistanceSample {
        if !self.scatters() {
            return DistanceSample { scattered: None, weight: self.transmittance(ray, distance, rng) };
        }
        match &self.density {
            None => homogeneous::distance_sample(self, distance, throughput, rng),
            Some(field) => tracking::distance_sample(self, field, ray, distance, throughput, rng),
        }
    }

    /// The density \[1/length] with which [`distance_sample`](Self::distance_sample) scatters at `t`, in a homogeneous medium.
    #[must_use]
    pub fn distance_pdf(&self, t: f32, throughput: Rgb) -> Option<f32> {
        if !self.scatters() {
            return Some(0.0);
        }
        self.is_homogeneous().then(|| homogeneous::distance_pdf(self.extinction(), t, throughput))
    }

    /// The radiance that the medium itself sends to the ray's origin from up to `distance` along its unit direction.
    ///
    /// Exact where the medium is homogeneous, else an unbiased estimate. A homogeneous medium that emits in a channel without
    /// extinction sends infinitely much from an infinite distance.
    #[must_use]
    pub fn emitted(&self, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
        if !self.emits() {
            return Rgb::ZERO;
        }
        match &self.density {
            None => homogeneous::emitted(self, distance),
            Some(field) => tracking::emitted(self, field, ray, distance, rng),
        }
    }

    /// The same medium moved by `by`.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        let density = self.density.as_ref().map(|field| Arc::new(field.translated(by)));
        Self { density, ..self.clone() }
    }
}

/// The part of each channel in the throughput, 1 in sum; all alike where there is none.
fn shares(throughput: Rgb) -> DVec3 {
    // `max` takes 0 over a NaN.
    let part = throughput.to_array().map(|x| f64::from(x.max(0.0)));
    let part = DVec3::from_array(part);
    let sum = part.element_sum();
    if sum > 0.0 && sum.is_finite() { part / sum } else { DVec3::splat(1.0 / 3.0) }
}

/// A weight in f32; channels without a share have none.
fn weight(w: DVec3, shares: DVec3) -> Rgb {
    let most = f64::from(f32::MAX);
    DVec3::select(shares.cmpgt(DVec3::ZERO), w.min(DVec3::splat(most)), DVec3::ZERO).as_vec3()
}

#[cfg(test)]
mod tests;
