//! Materials of the resolved scene.

use crate::bsdf::{Bsdf, Conductor, Thin, conductor_reflectance};
use crate::color::Rgb;

/// A surface's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How it scatters.
    pub scattering: Scattering,
    /// How the course's shading sees it.
    pub look: PhongAppearance,
    /// Index of what it wears; without textures both of the above are means.
    pub dress: Option<u32>,
}

/// How a surface scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scattering {
    /// By a function that is the same wherever the surface stands.
    Fixed(Bsdf),
    /// The boundary of a body that light enters: the function depends on what is on its other side.
    Boundary(Body),
    /// At each hit one of two materials, chosen by chance.
    Mix {
        /// Index of the first material.
        first: u32,
        /// Index of the second material.
        second: u32,
        /// Probability of the second.
        amount: f32,
    },
}

impl Scattering {
    /// Whether it sends light on in beams: see [`Bsdf::casts_caustics`]. A mix does not know.
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        match self {
            Self::Fixed(bsdf) => bsdf.casts_caustics(),
            Self::Boundary(body) => !body.clear,
            Self::Mix { .. } => false,
        }
    }
}

/// A body that light enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Absolute index of refraction: 1 is air.
    pub index: f32,
    /// Absorption \[1/length].
    pub absorption: Rgb,
    /// Where bodies overlap, the one of the highest priority counts; of several, the one that was entered last (Schmidt and
    /// Budge 2002, "Simple Nested Dielectrics in Ray Traced Images").
    pub priority: u8,
    /// Roughness α of its surface; 0 is smooth.
    pub roughness: f32,
    /// Index of its glass, where the refractive index depends on the wavelength; `index` is that at the d line.
    pub glass: Option<u32>,
    /// Index of the medium that fills it.
    pub medium: Option<u32>,
    /// Whether it has no surface that light could tell, and is but a place where the medium is. Of equal priority, other bodies
    /// displace it.
    pub clear: bool,
}

impl Body {
    /// A smooth body of absolute `index` that is filled with nothing.
    #[must_use]
    pub fn new(index: f32) -> Self {
        Self { index, absorption: Rgb::ZERO, priority: 0, roughness: 0.0, glass: None, medium: None, clear: false }
    }

    /// A place that is filled with a medium, which light enters and leaves without noticing.
    #[must_use]
    pub fn clear(medium: u32) -> Self {
        Self { medium: Some(medium), clear: true, ..Self::new(1.0) }
    }

    /// What decides between bodies that overlap: the greater counts.
    pub(super) fn rank(&self) -> (u8, bool) {
        (self.priority, !self.clear)
    }
}

/// Coefficients of Phong's model as the course has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongAppearance {
    /// kd.
    pub diffuse: Rgb,
    /// ks.
    pub specular: Rgb,
    /// The exponent.
    pub shininess: f32,
}

impl PhongAppearance {
    /// A matt look.
    #[must_use]
    pub fn matt(diffuse: Rgb) -> Self {
        Self { diffuse, specular: Rgb::ZERO, shininess: 0.0 }
    }
}

impl Material {
    fn fixed(bsdf: Bsdf, look: PhongAppearance) -> Self {
        Self { scattering: Scattering::Fixed(bsdf), look, dress: None }
    }

    /// Lambertian reflection.
    #[must_use]
    pub fn diffuse(reflectance: Rgb) -> Self {
        Self::fixed(Bsdf::Diffuse(reflectance), PhongAppearance::matt(reflectance))
    }

    /// Phong's model; energy is kept by scaling (see [`crate::bsdf::Phong`]), the look is not scaled.
    #[must_use]
    pub fn phong(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        Self::fixed(phong(diffuse, specular, shininess), PhongAppearance { diffuse, specular, shininess })
    }

    /// A perfect mirror.
    #[must_use]
    pub fn mirror(reflectance: Rgb) -> Self {
        Self::fixed(Bsdf::Mirror(reflectance), PhongAppearance::matt(reflectance))
    }

    /// A smooth body of absolute `index` that absorbs with `absorption` \[1/length].
    #[must_use]
    pub fn dielectric(index: f32, absorption: Rgb) -> Self {
        Self::body(Body { absorption, ..Body::new(index) })
    }

    /// The boundary of a body.
    #[must_use]
    pub fn body(body: Body) -> Self {
        let look = PhongAppearance::matt((-body.absorption).map(libm::expf));
        Self { scattering: Scattering::Boundary(body), look, dress: None }
    }

    /// Material `second` with probability `amount`, else material `first`; both are indices of materials that were added before.
    /// It looks as `look`.
    #[must_use]
    pub fn mix(first: u32, second: u32, amount: f32, look: PhongAppearance) -> Self {
        Self { scattering: Scattering::Mix { first, second, amount }, look, dress: None }
    }

    /// A metal of refractive index `eta` + i`k` and roughness α in \[0, 1].
    #[must_use]
    pub fn conductor(eta: Rgb, k: Rgb, alpha: f32) -> Self {
        let facing = conductor_reflectance(1.0, eta, k);
        Self::fixed(Bsdf::Conductor(Conductor::new(eta, k, alpha)), PhongAppearance::matt(facing))
    }

    /// A sheet without thickness, of index `eta`, that keeps `transmittance` in (0, 1] of what crosses it perpendicularly.
    #[must_use]
    pub fn thin(eta: f32, transmittance: Rgb) -> Self {
        Self::fixed(Bsdf::Thin(Thin { eta, transmittance }), PhongAppearance::matt(transmittance))
    }

    /// Absorbs everything.
    #[must_use]
    pub fn black() -> Self {
        Self::fixed(Bsdf::Black, PhongAppearance::matt(Rgb::ZERO))
    }
}

/// Phong's model, which is Lambert's where nothing shines.
pub(super) fn phong(diffuse: Rgb, specular: Rgb, shininess: f32) -> Bsdf {
    if specular == Rgb::ZERO {
        Bsdf::Diffuse(diffuse / diffuse.max_element().max(1.0))
    } else {
        Bsdf::Phong(crate::bsdf::Phong::new(diffuse, specular, shininess))
    }
}
