//! Bidirectional scattering distribution functions (BSDFs).
//!
//! Directions are unit vectors that point away from the surface: `wo` to the previous vertex of the
//! path, `wi` to the next one. `ns` is the shading normal and `ng` the geometric normal, in one
//! half space.

mod adjoint;
mod conductor;
mod dielectric;
mod fresnel;
mod metals;
mod microfacet;
mod phong;
mod rough_dielectric;
mod thin;

pub use adjoint::{photon_deposit_factor, shading_normal_correction};
pub use conductor::Conductor;
pub use dielectric::{Dielectric, DielectricSplit};
pub use fresnel::{Refraction, conductor_reflectance, dielectric_reflectance, refract};
pub use metals::{METALS, named_metal};
pub use phong::Phong;
pub use rough_dielectric::RoughDielectric;
pub use thin::{ThinDielectric, ThinDielectricSplit};

use crate::color::Rgb;
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Roughness α below which a surface counts as smooth: its lobe is narrower than pixels and lights
/// resolve.
pub const SMOOTH_ALPHA: f32 = 1e-3;

/// Roughness α of a conductor above which photons are stored: its lobe is broad enough for density
/// estimation.
pub const PHOTON_STORAGE_ALPHA: f32 = 0.3;

/// Width of a refracted lobe \[rad] below which it counts as a delta: ten roundings of a unit
/// vector in f32.
const MIN_LOBE_WIDTH: f32 = 1e-6;

/// Spread that scattering at a diffuse surface adds to a ray cone, as a tangent.
pub(crate) const DIFFUSE_CONE_SPREAD: f32 = 0.2;

/// The quantity that a path transports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Radiance, on camera paths. Refraction into a denser medium scales it by n².
    Radiance,
    /// Flux, on light paths. Refraction does not scale it.
    Importance,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit direction in which the path continues.
    pub wi: Vec3,
    /// f·|cos|/pdf. For delta lobes, the weight of the lobe over the probability of its choice.
    pub weight: Rgb,
    /// Solid-angle pdf of `wi`, as [`Bsdf::pdf`] returns it \[1/sr]; 0 for delta lobes.
    pub pdf: f32,
    /// True if the lobe is a delta.
    pub specular: bool,
    /// True if the path crosses the surface.
    pub transmitted: bool,
    /// True if a smooth surface scattered by its geometric normal, because the shading normal would
    /// have sent light to the wrong side.
    pub uses_geometric_normal: bool,
}

/// The BSDF at one point of a surface. Small and copied; each hit makes one.
///
/// Every BSDF but a black one is wholly a *receiver* ([`stores_photons`](Self::stores_photons)) or
/// wholly a *caster* ([`casts_caustics`](Self::casts_caustics)). A receiver has no delta lobe:
/// light over such a lobe would be neither in a photon estimate nor in a caustic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Absorbs all light.
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
    ThinDielectric(ThinDielectric),
}

impl Bsdf {
    /// A dielectric interface with relative index `eta` (inside over outside) and roughness α in
    /// \[0, 1].
    ///
    /// The interface is smooth if α is below [`SMOOTH_ALPHA`], or if an index near 1 refracts so
    /// little that roughness has no effect.
    #[must_use]
    pub fn dielectric(eta: f32, alpha: f32) -> Self {
        if alpha < SMOOTH_ALPHA || alpha * (eta - 1.0).abs() < MIN_LOBE_WIDTH {
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

    /// True if it scatters no light.
    #[inline]
    #[must_use]
    pub fn is_black(&self) -> bool {
        match self {
            Self::Black => true,
            Self::Diffuse(reflectance) => *reflectance == Rgb::ZERO,
            Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => false,
        }
    }

    /// True if it is Lambertian reflection alone.
    #[inline]
    #[must_use]
    pub fn is_diffuse(&self) -> bool {
        match self {
            Self::Diffuse(_) => true,
            Self::Black
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => false,
        }
    }

    /// One lobe, chosen by `u` in \[0, 1), divided by the probability of its choice.
    #[inline]
    #[must_use]
    pub fn select_lobe(self, u: f32) -> Self {
        match self {
            Self::Phong(phong) => phong.select_lobe(u),
            Self::Black
            | Self::Diffuse(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => self,
        }
    }

    /// Reflection and refraction of `wo`, if a path may follow both; `None` for other BSDFs.
    #[inline]
    #[must_use]
    pub fn split(&self, wo: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> Option<DielectricSplit> {
        match self {
            Self::Dielectric(dielectric) => Some(dielectric.split(wo, ns, ng, transport)),
            Self::Black
            | Self::Diffuse(_)
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => None,
        }
    }

    /// True if all lobes are deltas, so that next-event estimation and photon estimates contribute
    /// nothing.
    #[inline]
    #[must_use]
    pub fn is_specular(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => true,
            Self::Conductor(conductor) => conductor.is_smooth(),
            Self::Black | Self::Diffuse(_) | Self::Phong(_) | Self::RoughDielectric(_) => false,
        }
    }

    /// True if light can cross the surface.
    #[inline]
    #[must_use]
    pub fn transmits(&self) -> bool {
        match self {
            Self::Dielectric(_) | Self::RoughDielectric(_) | Self::ThinDielectric(_) => true,
            Self::Black | Self::Diffuse(_) | Self::Phong(_) | Self::Mirror(_) | Self::Conductor(_) => false,
        }
    }

    /// True for a *receiver*: photons are stored here, for density estimates that evaluate the BSDF
    /// for each photon.
    ///
    /// The noise of such an estimate grows as the lobe narrows. Diffuse and Phong BSDFs store
    /// photons, and so do conductors rougher than [`PHOTON_STORAGE_ALPHA`]. On smoother conductors
    /// few photons fall into the lobe, and sampling the lobe works better. Dielectrics store none,
    /// even rough ones: an estimate would blur what lies behind them.
    #[inline]
    #[must_use]
    pub fn stores_photons(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::Phong(_) => true,
            Self::Conductor(conductor) => conductor.alpha() > PHOTON_STORAGE_ALPHA,
            Self::Black
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => false,
        }
    }

    /// True for a *caster*: light that it scatters to a receiver is a caustic. Every BSDF is a
    /// receiver ([`stores_photons`](Self::stores_photons)), or a caster, or black.
    ///
    /// Casters are mirrors, dielectrics and thin panes of any roughness, and conductors of
    /// roughness α up to [`PHOTON_STORAGE_ALPHA`].
    ///
    /// Camera paths continue where no photons are stored. Light paths through such vertices belong
    /// to the caustic map, so that each path counts once, however broad the lobe.
    #[inline]
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        !self.stores_photons() && !self.is_black()
    }

    /// Spread that scattering here adds to a ray cone, as a tangent; 0 for deltas.
    ///
    /// The spread is about a fifth of the lobe's width, as many paths sample one lobe.
    #[inline]
    #[must_use]
    pub fn ray_cone_spread(&self) -> f32 {
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => 0.0,
            Self::Diffuse(_) | Self::Phong(_) => DIFFUSE_CONE_SPREAD,
            Self::Conductor(conductor) => conductor.alpha() * DIFFUSE_CONE_SPREAD,
            Self::RoughDielectric(glass) => glass.alpha() * DIFFUSE_CONE_SPREAD,
        }
    }

    /// f(wo, wi) \[1/sr], without the cosine; 0 for deltas.
    ///
    /// The value is also 0 if `ns` and `ng` disagree on whether `wo` and `wi` lie on one side.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> Rgb {
        let Some(directions_cross_surface) = directions_cross_surface(wo, wi, ns, ng) else { return Rgb::ZERO };
        if directions_cross_surface && !self.transmits() {
            return Rgb::ZERO;
        }
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => Rgb::ZERO,
            Self::RoughDielectric(glass) => glass.evaluate(wo, wi, face_forward(ns, wo), ng, transport),
            Self::Diffuse(reflectance) => *reflectance * FRAC_1_PI,
            Self::Phong(phong) => phong.evaluate(wo, wi, ns),
            Self::Conductor(conductor) => conductor.evaluate(wo, wi, ns),
        }
    }

    /// Solid-angle pdf with which [`Bsdf::sample`] samples `wi` \[1/sr]; 0 for deltas. Equal in
    /// both transports.
    #[inline]
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        let Some(directions_cross_surface) = directions_cross_surface(wo, wi, ns, ng) else { return 0.0 };
        if directions_cross_surface && !self.transmits() {
            return 0.0;
        }
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => 0.0,
            Self::RoughDielectric(glass) => glass.pdf(wo, wi, face_forward(ns, wo), ng),
            Self::Diffuse(_) => warp::cosine_hemisphere_pdf(wi.dot(ns).abs()),
            Self::Phong(phong) => phong.pdf(wo, wi, ns),
            Self::Conductor(conductor) => conductor.pdf(wo, wi, ns),
        }
    }

    /// Samples the direction in which the path continues; `None` if it is absorbed.
    ///
    /// `lobe` and `u` are uniform in \[0, 1). The result agrees with `ng`: reflected directions
    /// stay on the side of `wo`, transmitted ones leave it.
    #[inline]
    #[must_use]
    pub fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, u: Vec2, transport: Transport) -> Option<BsdfSample> {
        let face_forward = face_forward(ns, wo);
        let sample = match self {
            Self::Black => return None,
            Self::Diffuse(reflectance) => {
                let local = warp::square_to_cosine_hemisphere(u);
                // The rim of the disc lies in the horizon, where the pdf is 0, so no MIS weight
                // exists.
                if local.z <= 0.0 {
                    return None;
                }
                let wi = Frame::from_normal(face_forward).to_world(local);
                let pdf = warp::cosine_hemisphere_pdf(local.z);
                BsdfSample {
                    wi,
                    weight: *reflectance,
                    pdf,
                    specular: false,
                    transmitted: false,
                    uses_geometric_normal: false,
                }
            }
            Self::Phong(phong) => phong.sample(wo, face_forward, lobe, u)?,
            Self::Mirror(reflectance) => {
                let (wi, uses_geometric_normal) = dielectric::reflect_above_surface(wo, face_forward, ng);
                BsdfSample {
                    wi,
                    weight: *reflectance,
                    pdf: 0.0,
                    specular: true,
                    transmitted: false,
                    uses_geometric_normal,
                }
            }
            Self::Dielectric(dielectric) => dielectric.sample(wo, ns, ng, lobe, transport),
            Self::Conductor(conductor) => conductor.sample(wo, face_forward, ng, u)?,
            Self::RoughDielectric(glass) => glass.sample(wo, face_forward, ng, lobe, u, transport)?,
            Self::ThinDielectric(thin) => thin.sample(wo, face_forward, ng, lobe)?,
        };
        let directions_cross_surface = (sample.wi.dot(ng) < 0.0) != (wo.dot(ng) < 0.0);
        (directions_cross_surface == sample.transmitted).then_some(sample)
    }
}

/// `n`, flipped to the side of `wo`.
#[inline]
fn face_forward(n: Vec3, wo: Vec3) -> Vec3 {
    if wo.dot(n) < 0.0 { -n } else { n }
}

/// True if `wo` and `wi` lie on different sides; `None` if the normals disagree on it.
#[inline]
fn directions_cross_surface(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> Option<bool> {
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
