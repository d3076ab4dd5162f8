//! How surfaces scatter light.
//!
//! Directions are unit vectors that point away from the surface: `wo` to where the walk came from, `wi` to where it goes.

mod adjoint;
mod dielectric;
mod fresnel;
mod phong;

pub use adjoint::{deposit_factor, shading_normal_factor};
pub use dielectric::Dielectric;
pub use fresnel::{Refraction, dielectric_reflectance, refract};
pub use phong::Phong;

use crate::color::Rgb;
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// What a walk carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// From the camera: radiance is squeezed by n² on entering a denser medium.
    Radiance,
    /// From a light: flux is not.
    Importance,
}

/// A scattered direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit direction in which the walk goes on.
    pub wi: Vec3,
    /// f · |cos| / pdf (for delta lobes, the lobe's weight over the probability of choosing it).
    pub weight: Rgb,
    /// What [`Bsdf::pdf`] gives for `wi` \[1/sr]; 0 for delta lobes.
    pub pdf: f32,
    /// Whether the lobe is a delta: no other direction could have been joined to `wo`.
    pub specular: bool,
    /// Whether the walk passed to the other side.
    pub transmitted: bool,
}

/// A scattering function at one point: small, copied, chosen once a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Absorbs everything.
    Black,
    /// Lambertian reflection on both sides with this reflectance.
    Diffuse(Rgb),
    /// Lambertian plus Phong lobe, on both sides.
    Phong(Phong),
    /// Perfect reflection with this reflectance.
    Mirror(Rgb),
    /// A smooth interface between two refractive indices.
    Dielectric(Dielectric),
}

impl Bsdf {
    /// Whether all lobes are deltas, so that neither light nor photons can be joined to a given direction.
    #[inline]
    #[must_use]
    pub fn is_specular(&self) -> bool {
        matches!(self, Self::Mirror(_) | Self::Dielectric(_))
    }

    /// Whether light passes to the other side.
    #[inline]
    #[must_use]
    pub fn transmits(&self) -> bool {
        matches!(self, Self::Dielectric(_))
    }

    /// Whether photons are stored: the lobes are broad enough for a density estimate to evaluate.
    #[inline]
    #[must_use]
    pub fn stores_photons(&self) -> bool {
        matches!(self, Self::Diffuse(_) | Self::Phong(_))
    }

    /// Whether light that comes from it is a caustic: deltas, and lobes too narrow to store photons. Every BSDF either
    /// stores photons, or casts caustics, or is black.
    #[inline]
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        matches!(self, Self::Mirror(_) | Self::Dielectric(_))
    }

    /// f(wo, wi) in 1/sr without the cosine; deltas are zero, and so are pairs of directions for which `ns` and `ng` disagree on
    /// whether they are on one side.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> Rgb {
        let _ = transport;
        if !reflects(wo, wi, ns, ng) {
            return Rgb::ZERO;
        }
        match self {
            Self::Diffuse(reflectance) => *reflectance * FRAC_1_PI,
            Self::Phong(phong) => phong.evaluate(wo, wi, ns),
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) => Rgb::ZERO,
        }
    }

    /// Density with which [`Bsdf::sample`] draws `wi` \[1/sr]: alike in both transports; deltas are zero.
    #[inline]
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        if !reflects(wo, wi, ns, ng) {
            return 0.0;
        }
        match self {
            Self::Diffuse(_) => warp::cosine_hemisphere_pdf(wi.dot(ns).abs()),
            Self::Phong(phong) => phong.pdf(wo, wi, ns),
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) => 0.0,
        }
    }

    /// Draws where the walk goes on; `None` where it is absorbed for certain.
    ///
    /// `ns` and `ng` are the shading and geometric normals in one half space; the result never contradicts `ng`: what is
    /// called reflected stays on the side of `wo`, what is called transmitted leaves it.
    #[inline]
    #[must_use]
    pub fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, u: Vec2, transport: Transport) -> Option<BsdfSample> {
        let facing = if wo.dot(ng) < 0.0 { -ns } else { ns };
        let sample = match self {
            Self::Black => return None,
            Self::Diffuse(reflectance) => {
                let local = warp::cosine_hemisphere(u);
                let wi = Frame::around(facing).to_world(local);
                let pdf = warp::cosine_hemisphere_pdf(local.z);
                BsdfSample { wi, weight: *reflectance, pdf, specular: false, transmitted: false }
            }
            Self::Phong(phong) => phong.sample(wo, facing, lobe, u)?,
            Self::Mirror(reflectance) => {
                let wi = dielectric::reflect_above(wo, facing, ng);
                BsdfSample { wi, weight: *reflectance, pdf: 0.0, specular: true, transmitted: false }
            }
            Self::Dielectric(dielectric) => dielectric.sample(wo, ns, ng, lobe, transport),
        };
        let crosses = (sample.wi.dot(ng) < 0.0) != (wo.dot(ng) < 0.0);
        (crosses == sample.transmitted).then_some(sample)
    }
}

/// Whether `wo` and `wi` are on one side, by both normals.
#[inline]
fn reflects(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> bool {
    wo.dot(ns) * wi.dot(ns) > 0.0 && wo.dot(ng) * wi.dot(ng) > 0.0
}

#[cfg(test)]
mod tests;
