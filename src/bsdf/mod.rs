//! How surfaces scatter light.
//!
//! Directions are unit vectors that point away from the surface: `wo` to where the walk came from, `wi` to where it goes.

mod adjoint;
mod conductor;
mod dielectric;
mod fresnel;
mod metals;
mod microfacet;
mod phong;
mod rough_dielectric;
mod thin;

pub use adjoint::{deposit_factor, shading_normal_factor};
pub use conductor::Conductor;
pub use dielectric::{Dielectric, Split};
pub use fresnel::{Refraction, conductor_reflectance, dielectric_reflectance, refract};
pub use metals::{METALS, metal};
pub use phong::Phong;
pub use rough_dielectric::RoughDielectric;
pub use thin::{Thin, ThinSplit};

use crate::color::Rgb;
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Roughness α below which a surface is taken as smooth: its lobe is narrower than pixels and lights resolve.
pub const SMOOTH_ALPHA: f32 = 1e-3;

/// Roughness α of a conductor above which its lobe is broad enough to estimate from stored photons.
pub const STORED_ALPHA: f32 = 0.3;

/// Width of a lobe of refraction \[rad] below which it cannot be told from a delta: ten roundings of a unit vector in f32.
const NARROW: f32 = 1e-6;

/// What a cone around a walk widens by at a matt surface, as a tangent.
pub(crate) const DIFFUSE_BLUR: f32 = 0.2;

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
    /// Whether a smooth surface was taken as it is, by its geometric normal alone, because the shading normal would have sent light to
    /// the wrong side.
    pub flat: bool,
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
    /// A metal, polished or rough.
    Conductor(Conductor),
    /// A rough interface between two refractive indices.
    RoughDielectric(RoughDielectric),
    /// A thin sheet.
    Thin(Thin),
}

impl Bsdf {
    /// The interface of index `eta` inside over outside and roughness α in \[0, 1]: smooth below [`SMOOTH_ALPHA`], and where
    /// an index near 1 bends so little that roughness does not show; an index of 1 lets light straight through.
    #[must_use]
    pub fn dielectric(eta: f32, alpha: f32) -> Self {
        if alpha < SMOOTH_ALPHA || alpha * (eta - 1.0).abs() < NARROW {
            Self::Dielectric(Dielectric { eta })
        } else {
            Self::RoughDielectric(RoughDielectric::new(eta, alpha))
        }
    }

    /// Phong's model; Lambertian reflection where `specular` is zero. Scaled to conserve energy.
    #[must_use]
    pub fn phong(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        if specular == Rgb::ZERO {
            Self::Diffuse(diffuse / diffuse.max_element().max(1.0))
        } else {
            Self::Phong(Phong::new(diffuse, specular, shininess))
        }
    }

    /// Whether all lobes are deltas, so that neither light nor photons can be joined to a given direction.
    #[inline]
    #[must_use]
    pub fn is_specular(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_) => true,
            Self::Conductor(conductor) => conductor.is_smooth(),
            Self::Black | Self::Diffuse(_) | Self::Phong(_) | Self::RoughDielectric(_) => false,
        }
    }

    /// Whether light passes to the other side.
    #[inline]
    #[must_use]
    pub fn transmits(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::RoughDielectric(_) | Self::Thin(_))
    }

    /// Whether photons are stored, to be gathered by a density estimate that evaluates the BSDF for each.
    ///
    /// The estimate averages over the photons of a disc whatever their direction, so its noise grows as the lobe of the
    /// viewer narrows: matt surfaces and Phong lobes store, conductors rougher than [`STORED_ALPHA`] too. Under that, few
    /// photons would fall into the lobe, and following the lobe itself finds what is seen in it. Nothing is stored on glass, rough
    /// or not: half of what it sends on comes from the other side, and what lies behind it is to be looked at, not blurred.
    #[inline]
    #[must_use]
    pub fn stores_photons(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::Phong(_) => true,
            Self::Conductor(conductor) => conductor.alpha() > STORED_ALPHA,
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::RoughDielectric(_) | Self::Thin(_) => false,
        }
    }

    /// Whether light that comes from it is a caustic: deltas, and lobes that store no photons. Every BSDF either stores
    /// photons, or casts caustics, or is black.
    ///
    /// What stores no photons is where walks from the camera go on, and what they reach must not have been counted; so light
    /// that it scatters belongs to the map of those paths, however broad the lobe. Light cannot be joined to a point behind
    /// glass by a straight line, so glass casts at any roughness.
    #[inline]
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        !self.stores_photons() && *self != Self::Black
    }

    /// By how much a cone around a walk widens here, as a tangent: about a fifth of the lobe, since many walks share what one lobe sees;
    /// 0 for deltas.
    #[inline]
    #[must_use]
    pub fn blur(&self) -> f32 {
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_) => 0.0,
            Self::Diffuse(_) | Self::Phong(_) => DIFFUSE_BLUR,
            Self::Conductor(conductor) => conductor.alpha() * DIFFUSE_BLUR,
            Self::RoughDielectric(glass) => glass.alpha() * DIFFUSE_BLUR,
        }
    }

    /// f(wo, wi) in 1/sr without the cosine; deltas are zero, and so are pairs of directions for which `ns` and `ng` disagree on
    /// whether they are on one side.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> Rgb {
        match (self, crosses(wo, wi, ns, ng)) {
            (Self::Diffuse(reflectance), Some(false)) => *reflectance * FRAC_1_PI,
            (Self::Phong(phong), Some(false)) => phong.evaluate(wo, wi, ns),
            (Self::Conductor(conductor), Some(false)) => conductor.evaluate(wo, wi, ns),
            (Self::RoughDielectric(glass), Some(_)) => glass.evaluate(wo, wi, facing(ns, wo), ng, transport),
            _ => Rgb::ZERO,
        }
    }

    /// Density with which [`Bsdf::sample`] draws `wi` \[1/sr]: alike in both transports; deltas are zero.
    #[inline]
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        match (self, crosses(wo, wi, ns, ng)) {
            (Self::Diffuse(_), Some(false)) => warp::cosine_hemisphere_pdf(wi.dot(ns).abs()),
            (Self::Phong(phong), Some(false)) => phong.pdf(wo, wi, ns),
            (Self::Conductor(conductor), Some(false)) => conductor.pdf(wo, wi, ns),
            (Self::RoughDielectric(glass), Some(_)) => glass.pdf(wo, wi, facing(ns, wo), ng),
            _ => 0.0,
        }
    }

    /// Draws where the walk goes on; `None` where it is absorbed for certain.
    ///
    /// `ns` and `ng` are the shading and geometric normals in one half space; the result never contradicts `ng`: what is
    /// called reflected stays on the side of `wo`, what is called transmitted leaves it.
    #[inline]
    #[must_use]
    pub fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, u: Vec2, transport: Transport) -> Option<BsdfSample> {
        let facing = facing(ns, wo);
        let sample = match self {
            Self::Black => return None,
            Self::Diffuse(reflectance) => {
                let local = warp::cosine_hemisphere(u);
                // The rim of the disc lies in the horizon, where the density is 0: no weight of chance could be made of it.
                if local.z <= 0.0 {
                    return None;
                }
                let wi = Frame::around(facing).to_world(local);
                let pdf = warp::cosine_hemisphere_pdf(local.z);
                BsdfSample { wi, weight: *reflectance, pdf, specular: false, transmitted: false, flat: false }
            }
            Self::Phong(phong) => phong.sample(wo, facing, lobe, u)?,
            Self::Mirror(reflectance) => {
                let (wi, flat) = dielectric::reflect_above(wo, facing, ng);
                BsdfSample { wi, weight: *reflectance, pdf: 0.0, specular: true, transmitted: false, flat }
            }
            Self::Dielectric(dielectric) => dielectric.sample(wo, ns, ng, lobe, transport),
            Self::Conductor(conductor) => conductor.sample(wo, facing, ng, u)?,
            Self::RoughDielectric(glass) => glass.sample(wo, facing, ng, lobe, u, transport)?,
            Self::Thin(thin) => thin.sample(wo, facing, ng, lobe)?,
        };
        let crosses = (sample.wi.dot(ng) < 0.0) != (wo.dot(ng) < 0.0);
        (crosses == sample.transmitted).then_some(sample)
    }
}

/// `n` on the side of `wo`.
#[inline]
fn facing(n: Vec3, wo: Vec3) -> Vec3 {
    if wo.dot(n) < 0.0 { -n } else { n }
}

/// Whether `wo` and `wi` are on different sides, if both normals agree on it.
#[inline]
fn crosses(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> Option<bool> {
    let (shading, geometric) = (wo.dot(ns) * wi.dot(ns), wo.dot(ng) * wi.dot(ng));
    if shading > 0.0 && geometric > 0.0 {
        Some(false)
    } else if shading < 0.0 && geometric < 0.0 {
        Some(true)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
