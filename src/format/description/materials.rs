//! What a scene file says of its materials.

use crate::color::Glass;
use glam::DVec3;

use super::{Emission, Relief, Spanned, Value};

/// What a surface does with light.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What `MaterialName` calls it: not empty, no line breaks.
    pub name: Option<String>,
    /// How it reflects and transmits.
    pub kind: MaterialKind,
    /// What it sends out by itself.
    pub emission: Option<Emission>,
    /// What makes it look uneven.
    pub relief: Option<Relief>,
    /// Name of the medium that fills the body, where the material is a `Dielectric` or a `Clear`.
    pub medium: Option<Spanned<String>>,
}

/// How a material reflects and transmits.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialKind {
    /// The course's material.
    Phong {
        /// kd.
        diffuse: Value<DVec3>,
        /// ks.
        specular: Value<DVec3>,
        /// The exponent, at least 0.
        shininess: f64,
        /// Name of a texture, else path of a picture, that kd is multiplied by.
        texture: Option<Spanned<String>>,
    },
    /// A Lambertian surface.
    Diffuse {
        /// Share of light that it sends back, inside [0, 1].
        reflectance: Value<DVec3>,
    },
    /// A perfect mirror.
    Mirror {
        /// Share of light that it sends back, inside [0, 1].
        reflectance: Value<DVec3>,
    },
    /// A body of glass, water, and the like.
    Dielectric {
        /// How it bends light.
        refraction: Refraction,
        /// What the inside takes from light on its way.
        attenuation: Attenuation,
        /// GGX α of its surface, inside [0, 1]; 0 is smooth.
        roughness: Value<f64>,
        /// Where bodies overlap, the one of the highest priority counts; of equal ones, that which was entered last.
        priority: u8,
    },
    /// A place without a surface that light could tell.
    Clear {
        /// As of a dielectric.
        priority: u8,
    },
    /// A metal, which light does not enter.
    Conductor {
        /// What it is made of.
        metal: Metal,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: Value<f64>,
    },
    /// A pane without thickness: light goes straight through or is mirrored.
    Thin {
        /// Index of refraction of the pane over that of what is around it.
        index: f64,
        /// Share of light that is left after it has crossed the inside once at right angles, inside (0, 1].
        transmittance: Value<DVec3>,
    },
    /// One of two materials at each place, by chance.
    Mix {
        /// Name of a material that stands before this one.
        first: Spanned<String>,
        /// Name of a material that stands before this one.
        second: Spanned<String>,
        /// Share of the second, inside [0, 1].
        amount: Value<f64>,
    },
}

/// How the inside of a dielectric bends light, by absolute indices of refraction: that of air is 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Refraction {
    /// All light alike.
    Index(f64),
    /// As a substance of the table of names.
    Named(Spanned<String>),
    /// Like Cauchy's equation of two terms.
    Abbe {
        /// The index at the line d, 587.56 nm.
        index: f64,
        /// Abbe's number, above 0.
        abbe: f64,
    },
    /// By its own equation, whose indices lie inside [0.001, 1000] from 380 to 720 nm.
    Own(Glass),
}

impl From<f64> for Refraction {
    fn from(index: f64) -> Self {
        Self::Index(index)
    }
}

/// What a conductor is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Metal {
    /// A metal of the table of names.
    Named(Spanned<String>),
    /// The complex index of refraction η + ik over that of what is around it.
    Index {
        /// Above 0.
        eta: DVec3,
        /// At least 0.
        k: DVec3,
    },
}

/// What the inside of a dielectric takes from light on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    /// Nothing.
    None,
    /// Absorption coefficient in 1/length.
    Absorption(DVec3),
    /// The share `color` remains after `distance`.
    Tint {
        /// Inside (0, 1].
        color: DVec3,
        /// Above 0.
        distance: f64,
    },
}

impl Attenuation {
    /// Absorption coefficient in 1/length, by Beer's law.
    #[must_use]
    pub fn coefficient(self) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Absorption(sigma) => sigma,
            Self::Tint { color, distance } => -color.map(libm::log) / distance,
        }
    }
}
