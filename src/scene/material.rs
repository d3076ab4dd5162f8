//! Materials of the resolved scene.

use crate::bsdf::{Bsdf, Dielectric};
use crate::color::Rgb;

/// A surface's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How it scatters.
    pub bsdf: Bsdf,
    /// What lies behind it.
    pub interface: Interface,
    /// How the course's shading sees it.
    pub look: Look,
}

/// The inner side of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface {
    /// Nothing that light enters.
    Opaque,
    /// A body that absorbs with these coefficients \[1/length].
    Body(Rgb),
}

/// Coefficients of Phong's model as the course has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// kd.
    pub diffuse: Rgb,
    /// ks.
    pub specular: Rgb,
    /// The exponent.
    pub shininess: f32,
}

impl Look {
    /// A matt look.
    #[must_use]
    pub fn matt(diffuse: Rgb) -> Self {
        Self { diffuse, specular: Rgb::ZERO, shininess: 0.0 }
    }
}

impl Material {
    /// Lambertian reflection.
    #[must_use]
    pub fn diffuse(reflectance: Rgb) -> Self {
        Self { bsdf: Bsdf::Diffuse(reflectance), interface: Interface::Opaque, look: Look::matt(reflectance) }
    }

    /// Phong's model; energy is kept by scaling (see [`crate::bsdf::Phong`]), the look is not scaled.
    #[must_use]
    pub fn phong(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        let bsdf = if specular == Rgb::ZERO {
            Bsdf::Diffuse(diffuse / diffuse.max_element().max(1.0))
        } else {
            Bsdf::Phong(crate::bsdf::Phong::new(diffuse, specular, shininess))
        };
        Self { bsdf, interface: Interface::Opaque, look: Look { diffuse, specular, shininess } }
    }

    /// A perfect mirror.
    #[must_use]
    pub fn mirror(reflectance: Rgb) -> Self {
        Self { bsdf: Bsdf::Mirror(reflectance), interface: Interface::Opaque, look: Look::matt(reflectance) }
    }

    /// A smooth body of relative index `eta` that absorbs with `absorption` \[1/length].
    #[must_use]
    pub fn dielectric(eta: f32, absorption: Rgb) -> Self {
        let look = Look::matt((-absorption).map(libm::expf));
        Self { bsdf: Bsdf::Dielectric(Dielectric { eta }), interface: Interface::Body(absorption), look }
    }

    /// Absorbs everything.
    #[must_use]
    pub fn black() -> Self {
        Self { bsdf: Bsdf::Black, interface: Interface::Opaque, look: Look::matt(Rgb::ZERO) }
    }
}
