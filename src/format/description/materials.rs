//! Materials of a description.

use crate::color::Glass;
use glam::DVec3;

use super::{Emission, NormalPerturbation, Spanned, Value};

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name that `MaterialName` refers to: not empty, no line breaks.
    pub name: Option<String>,
    /// Reflection and transmission.
    pub kind: MaterialKind,
    /// Emitted radiance.
    pub emission: Option<Emission>,
    /// Perturbation of its shading normals.
    pub relief: Option<NormalPerturbation>,
    /// Name of the medium that fills the body of a `Dielectric` or `Clear`.
    pub medium: Option<Spanned<String>>,
}

/// Reflection and transmission of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialKind {
    /// Phong's model of MIT 6.837.
    Phong {
        /// kd.
        diffuse: Value<DVec3>,
        /// ks.
        specular: Value<DVec3>,
        /// The exponent, at least 0.
        shininess: f64,
        /// Name of a texture, else path of a picture, that multiplies kd.
        texture: Option<Spanned<String>>,
    },
    /// A Lambertian surface.
    Diffuse {
        /// Reflectance, inside [0, 1].
        reflectance: Value<DVec3>,
    },
    /// A perfect mirror.
    Mirror {
        /// Reflectance, inside [0, 1].
        reflectance: Value<DVec3>,
    },
    /// Boundary of a body of glass, water or the like.
    Dielectric {
        /// Index of refraction.
        refraction: Refraction,
        /// Absorption inside.
        attenuation: Attenuation,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: Value<f64>,
        /// Priority where bodies overlap: the highest wins; ties go to the body entered last.
        priority: u8,
    },
    /// Null interface: boundary of a region without a surface.
    Clear {
        /// Priority, as for a dielectric.
        priority: u8,
    },
    /// Opaque metal.
    Conductor {
        /// Index of the metal.
        metal: Metal,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: Value<f64>,
    },
    /// Pane without thickness: light passes straight through or is mirrored.
    Thin {
        /// Index of refraction relative to the surroundings.
        index: f64,
        /// Transmittance of the inside at normal incidence, inside (0, 1].
        transmittance: Value<DVec3>,
    },
    /// One of two materials at each point, chosen at random.
    Mix {
        /// Name of a material that stands before this one.
        first: Spanned<String>,
        /// Name of a material that stands before this one.
        second: Spanned<String>,
        /// Probability of the second, inside [0, 1].
        amount: Value<f64>,
    },
}

/// Absolute index of refraction of a dielectric; that of air is 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Refraction {
    /// Equal for all wavelengths.
    Index(f64),
    /// Index of a named glass.
    Named(Spanned<String>),
    /// Cauchy's equation of two terms, by index and Abbe number.
    Abbe {
        /// Index at the d line, 587.56 nm.
        index: f64,
        /// Abbe number, above 0.
        abbe: f64,
    },
    /// Dispersion equation; indices lie in [0.001, 1000] from 380 to 720 nm.
    Glass(Glass),
}

impl From<f64> for Refraction {
    fn from(index: f64) -> Self {
        Self::Index(index)
    }
}

/// Complex index of a conductor.
#[derive(Clone, Debug, PartialEq)]
pub enum Metal {
    /// Index of a named metal.
    Named(Spanned<String>),
    /// Complex index of refraction η + ik relative to the surroundings.
    Index {
        /// η, above 0.
        eta: DVec3,
        /// k, at least 0.
        k: DVec3,
    },
}

/// Absorption inside a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    /// No absorption.
    None,
    /// Absorption coefficient in 1/length.
    Absorption(DVec3),
    /// Transmittance `color` over `distance`.
    Tint {
        /// Transmittance, inside (0, 1].
        color: DVec3,
        /// Distance, above 0.
        distance: f64,
    },
}

impl Attenuation {
    /// Returns the absorption coefficient in 1/length, by Beer's law.
    #[must_use]
    pub fn coefficient(self) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Absorption(sigma) => sigma,
            Self::Tint { color, distance } => -color.map(libm::log) / distance,
        }
    }
}
