//! Sampled directions, with their weights and pdfs.

use crate::color::Rgb;
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};

/// A direction sampled from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit direction in which the path continues.
    pub wi: Vec3,
    /// Weight f(wo, wi)·|cosθ|/pdf, where θ is the angle between `wi` and the shading normal.
    ///
    /// For a delta lobe, the weight is the lobe's reflectance or transmittance, divided by the
    /// probability of choosing the lobe. Refracted radiance is also divided by the squared relative
    /// index.
    pub weight: Rgb,
    /// Solid-angle pdf of `wi` \[1/sr], equal to [`Bsdf::pdf`](super::Bsdf::pdf); 0 for a delta
    /// lobe.
    pub pdf: f32,
    /// True if the direction was sampled from a delta lobe.
    pub is_specular: bool,
    /// True if the path crosses the surface.
    pub is_transmitted: bool,
    /// True if a specular direction was computed with the geometric normal instead of the shading
    /// normal.
    ///
    /// Such a sample replaces one that the shading normal would send to the wrong side of the
    /// surface.
    pub uses_geometric_normal: bool,
}

impl BsdfSample {
    /// Creates a sample of a delta lobe.
    #[inline]
    pub(super) fn specular_sample(wi: Vec3, weight: Rgb, is_transmitted: bool, uses_geometric_normal: bool) -> Self {
        Self { wi, weight, pdf: 0.0, is_specular: true, is_transmitted, uses_geometric_normal }
    }

    /// Creates a sample of a lobe that has a finite pdf.
    #[inline]
    pub(crate) fn non_specular_sample(wi: Vec3, weight: Rgb, pdf: f32, is_transmitted: bool) -> Self {
        NonSpecularSample { wi, weight, pdf, is_transmitted }.into()
    }
}

/// A direction sampled from a lobe with a finite pdf. The type cannot describe a delta lobe.
///
/// The fields are those of [`BsdfSample`].
pub(super) struct NonSpecularSample {
    pub wi: Vec3,
    pub weight: Rgb,
    pub pdf: f32,
    pub is_transmitted: bool,
}

impl NonSpecularSample {
    /// Samples a direction of Lambertian reflection from random numbers `u` in \[0, 1)²; `None` if
    /// the direction lies in the surface. The unit normal `facing_ns` is the shading normal on the
    /// side of the previous vertex.
    #[inline]
    pub fn lambertian_sample(reflectance: Rgb, facing_ns: Vec3, u: Vec2) -> Option<Self> {
        let local = warp::square_to_cosine_hemisphere(u);
        // A direction on the horizon has a pdf of 0, so it has no MIS weight.
        if local.z <= 0.0 {
            return None;
        }
        let wi = Frame::from_normal(facing_ns).to_world(local);
        let pdf = warp::cosine_hemisphere_pdf(local.z);
        Some(Self { wi, weight: reflectance, pdf, is_transmitted: false })
    }
}

impl From<NonSpecularSample> for BsdfSample {
    #[inline]
    fn from(sample: NonSpecularSample) -> Self {
        let NonSpecularSample { wi, weight, pdf, is_transmitted } = sample;
        Self { wi, weight, pdf, is_specular: false, is_transmitted, uses_geometric_normal: false }
    }
}
