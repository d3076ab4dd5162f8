//! Materials of a description.

use crate::color::DispersionFormula;
use glam::DVec3;

use super::{EmissionDescription, NormalPerturbationDescription, Spanned, TexturedValue};

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// Name that `MaterialName` refers to: not empty, no line breaks.
    pub name: Option<String>,
    /// Reflection and transmission.
    pub kind: MaterialKindDescription,
    /// Emitted radiance.
    pub emission: Option<EmissionDescription>,
    /// Perturbation of its shading normals.
    pub normal_perturbation: Option<NormalPerturbationDescription>,
    /// Name of the medium that fills the body of a `Dielectric` or `Clear`.
    pub medium: Option<Spanned<String>>,
}

/// Reflection and transmission of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialKindDescription {
    /// Phong's model of MIT 6.837.
    Phong {
        /// kd.
        diffuse: TexturedValue<DVec3>,
        /// ks.
        specular: TexturedValue<DVec3>,
        /// The exponent, at least 0.
        shininess: f64,
        /// Name of a texture, else path of a picture, that multiplies kd.
        texture: Option<Spanned<String>>,
    },
    /// A Lambertian surface.
    Diffuse {
        /// Reflectance, inside [0, 1].
        reflectance: TexturedValue<DVec3>,
    },
    /// A perfect mirror.
    Mirror {
        /// Reflectance, inside [0, 1].
        reflectance: TexturedValue<DVec3>,
    },
    /// Boundary of a body of glass, water or the like.
    Dielectric {
        /// Index of refraction.
        refraction: RefractiveIndexDescription,
        /// Absorption inside.
        attenuation: DielectricAbsorption,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: TexturedValue<f64>,
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
        metal: MetalDescription,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: TexturedValue<f64>,
    },
    /// Pane without thickness: light passes straight through or is mirrored.
    Thin {
        /// Index of refraction relative to the surroundings.
        index: f64,
        /// Transmittance of the inside at normal incidence, inside (0, 1].
        transmittance: TexturedValue<DVec3>,
    },
    /// One of two materials at each point, chosen at random.
    Mix {
        /// Name of a material that stands before the mix.
        first: Spanned<String>,
        /// Name of a material that stands before the mix.
        second: Spanned<String>,
        /// Probability of the second, inside [0, 1].
        amount: TexturedValue<f64>,
    },
}

impl MaterialDescription {
    /// Returns the names of the textures that the material follows. The texture of
    /// [`MaterialKindDescription::Phong`] may be the path of a picture instead.
    #[must_use]
    pub fn texture_names(&self) -> Vec<&Spanned<String>> {
        let mut textures = self.kind.texture_names();
        match &self.normal_perturbation {
            Some(
                NormalPerturbationDescription::Bump { texture, .. } | NormalPerturbationDescription::NormalMap(texture),
            ) => textures.push(texture),
            None => {}
        }
        match &self.emission {
            Some(EmissionDescription::Texture { name, .. }) => textures.push(name),
            Some(EmissionDescription::Radiance(_)) | None => {}
        }
        textures
    }

    /// Returns the fields that hold the name of a texture, or else the path of a picture.
    pub fn texture_names_or_paths_mut(&mut self) -> impl Iterator<Item = &mut Spanned<String>> {
        let normal_perturbation = match &mut self.normal_perturbation {
            Some(
                NormalPerturbationDescription::Bump { texture, .. } | NormalPerturbationDescription::NormalMap(texture),
            ) => Some(texture),
            None => None,
        };
        self.kind.texture_name_or_path_mut().into_iter().chain(normal_perturbation)
    }
}

impl MaterialKindDescription {
    /// Returns the names of the textures that its parameters follow.
    fn texture_names(&self) -> Vec<&Spanned<String>> {
        match self {
            Self::Phong { diffuse, specular, texture, .. } => {
                [diffuse.texture(), specular.texture(), texture.as_ref()].into_iter().flatten().collect()
            }
            Self::Diffuse { reflectance: value }
            | Self::Mirror { reflectance: value }
            | Self::Thin { transmittance: value, .. } => value.texture().into_iter().collect(),
            Self::Dielectric { roughness: value, .. }
            | Self::Conductor { roughness: value, .. }
            | Self::Mix { amount: value, .. } => value.texture().into_iter().collect(),
            Self::Clear { .. } => Vec::new(),
        }
    }

    /// Returns the field that holds the name of a texture, or else the path of a picture.
    fn texture_name_or_path_mut(&mut self) -> Option<&mut Spanned<String>> {
        match self {
            Self::Phong { texture, .. } => texture.as_mut(),
            Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::Clear { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::Mix { .. } => None,
        }
    }

    /// Returns the names of the materials that a mix chooses from; `None` for other kinds.
    #[must_use]
    pub fn mix_parts(&self) -> Option<[&Spanned<String>; 2]> {
        match self {
            Self::Mix { first, second, .. } => Some([first, second]),
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::Clear { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. } => None,
        }
    }

    /// True for the boundary of a dielectric body.
    #[must_use]
    pub fn is_dielectric(&self) -> bool {
        match self {
            Self::Dielectric { .. } => true,
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Clear { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::Mix { .. } => false,
        }
    }

    /// True for a null interface: the material has no surface.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        match self {
            Self::Clear { .. } => true,
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::Mix { .. } => false,
        }
    }
}

/// Absolute index of refraction of a dielectric; that of air is 1.
#[derive(Clone, Debug, PartialEq)]
pub enum RefractiveIndexDescription {
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
    Glass(DispersionFormula),
}

impl From<f64> for RefractiveIndexDescription {
    fn from(index: f64) -> Self {
        Self::Index(index)
    }
}

/// Complex index of a conductor.
#[derive(Clone, Debug, PartialEq)]
pub enum MetalDescription {
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
pub enum DielectricAbsorption {
    /// No absorption.
    None,
    /// Absorption coefficient in 1/length.
    Coefficient(DVec3),
    /// Transmittance `color` over `distance`.
    Tint {
        /// Transmittance, inside (0, 1].
        color: DVec3,
        /// Distance, above 0.
        distance: f64,
    },
}

impl DielectricAbsorption {
    /// Returns the absorption coefficient in 1/length, by Beer's law.
    #[must_use]
    pub fn coefficient(self) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Coefficient(sigma) => sigma,
            Self::Tint { color, distance } => -color.map(libm::log) / distance,
        }
    }
}
