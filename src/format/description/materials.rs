//! Materials of a [`SceneDescription`](super::SceneDescription), as the scene file states them.

use crate::color::DispersionFormula;
use glam::DVec3;

use super::{EmissionDescription, NormalPerturbationDescription, Spanned, TexturedValue};

/// A material as the scene file describes it: scattering, emission, normals and inner medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// Name that objects and mixes refer to: not empty, without line breaks. `None` if objects can
    /// refer to the material only by its index.
    pub name: Option<String>,
    /// Model of reflection and transmission, with its parameters.
    pub kind: MaterialKindDescription,
    /// Emitted radiance; `None` for a material that does not emit.
    pub emission: Option<EmissionDescription>,
    /// Bump map or normal map that perturbs shading normals; `None` without one.
    pub normal_perturbation: Option<NormalPerturbationDescription>,
    /// Name of the medium that fills a body with this material; only for `Dielectric` and
    /// `NullInterface`.
    pub medium: Option<Spanned<String>>,
}

/// Reflection and transmission of a material: one variant per model.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialKindDescription {
    /// The Phong model of MIT course 6.837.
    Phong {
        /// Diffuse color kd.
        diffuse: TexturedValue<DVec3>,
        /// Specular color ks.
        specular: TexturedValue<DVec3>,
        /// Phong exponent, at least 0.
        shininess: f64,
        /// Name of a texture that multiplies kd. If no texture has the name, it is the path of a
        /// picture.
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
    /// Boundary of a body of glass, water or another dielectric.
    Dielectric {
        /// Index of refraction of the body.
        refraction: RefractiveIndexDescription,
        /// Absorption inside the body.
        attenuation: DielectricAbsorption,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: TexturedValue<f64>,
        /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
        multiple_scattering: bool,
        /// Priority where bodies overlap (Schmidt and Budge 2002): the highest wins. Among equal
        /// priorities, the body that was entered last wins.
        priority: u8,
    },
    /// Null interface: bounds a region of a medium. Light crosses it unchanged.
    NullInterface {
        /// Priority where bodies overlap: the highest wins.
        priority: u8,
    },
    /// An opaque conductor.
    Conductor {
        /// Complex index of refraction.
        metal: MetalDescription,
        /// GGX α, inside [0, 1]; 0 is smooth.
        roughness: TexturedValue<f64>,
        /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
        multiple_scattering: bool,
    },
    /// A pane without thickness: light passes straight through or is reflected.
    Thin {
        /// Index of refraction relative to the surroundings.
        index: f64,
        /// Transmittance of the pane's interior at normal incidence, inside (0, 1].
        transmittance: TexturedValue<DVec3>,
    },
    /// A diffuse base under a dielectric coat, such as plastic.
    CoatedDiffuse {
        /// Reflectance of the base, inside [0, 1].
        reflectance: TexturedValue<DVec3>,
        /// Index of refraction of the coat relative to the surroundings, inside [1, 4].
        index: f64,
        /// GGX α of the coat, inside [0, 1]; 0 is smooth.
        roughness: TexturedValue<f64>,
        /// True to account for color shifts by interreflection between coat and base, like
        /// `nonlinear` of Mitsuba's `plastic`.
        nonlinear: bool,
    },
    /// Stochastic mix: one of two materials, chosen at random at each point.
    Mix {
        /// Name of the first material, which the scene file defines before the mix.
        first: Spanned<String>,
        /// Name of the second material, which the scene file defines before the mix.
        second: Spanned<String>,
        /// Probability of the second material, inside [0, 1].
        amount: TexturedValue<f64>,
    },
}

impl MaterialDescription {
    /// Returns the names of all textures that the material uses: in its parameters, its bump or
    /// normal map, and its emission.
    ///
    /// A name in a bump map, a normal map or a `Phong` material's `texture` may be the path of a
    /// picture instead.
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

    /// Iterates over the material's fields that hold either the name of a texture or the path of a
    /// picture.
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
    /// Returns the names of the textures that this kind's parameters use, without bump maps and
    /// emission.
    fn texture_names(&self) -> Vec<&Spanned<String>> {
        match self {
            Self::Phong { diffuse, specular, texture, .. } => {
                [diffuse.texture_name(), specular.texture_name(), texture.as_ref()].into_iter().flatten().collect()
            }
            Self::CoatedDiffuse { reflectance, roughness, .. } => {
                [reflectance.texture_name(), roughness.texture_name()].into_iter().flatten().collect()
            }
            Self::Diffuse { reflectance: value }
            | Self::Mirror { reflectance: value }
            | Self::Thin { transmittance: value, .. } => value.texture_name().into_iter().collect(),
            Self::Dielectric { roughness: value, .. }
            | Self::Conductor { roughness: value, .. }
            | Self::Mix { amount: value, .. } => value.texture_name().into_iter().collect(),
            Self::NullInterface { .. } => Vec::new(),
        }
    }

    /// Returns the field `texture` of a `Phong` material, which may be the name of a texture or the
    /// path of a picture file.
    ///
    /// `None` if this field is absent, and for other materials: their textured fields hold names
    /// only.
    fn texture_name_or_path_mut(&mut self) -> Option<&mut Spanned<String>> {
        match self {
            Self::Phong { texture, .. } => texture.as_mut(),
            Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::NullInterface { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::CoatedDiffuse { .. }
            | Self::Mix { .. } => None,
        }
    }

    /// Returns the names of the two materials of a mix; `None` for other kinds.
    #[must_use]
    pub fn mix_material_names(&self) -> Option<[&Spanned<String>; 2]> {
        match self {
            Self::Mix { first, second, .. } => Some([first, second]),
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::NullInterface { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::CoatedDiffuse { .. } => None,
        }
    }

    /// True if the material is the boundary of a dielectric body.
    #[must_use]
    pub fn is_dielectric(&self) -> bool {
        match self {
            Self::Dielectric { .. } => true,
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::NullInterface { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::CoatedDiffuse { .. }
            | Self::Mix { .. } => false,
        }
    }

    /// True if the material is a null interface, which neither reflects nor refracts light.
    #[must_use]
    pub fn is_null_interface(&self) -> bool {
        match self {
            Self::NullInterface { .. } => true,
            Self::Phong { .. }
            | Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::Conductor { .. }
            | Self::Thin { .. }
            | Self::CoatedDiffuse { .. }
            | Self::Mix { .. } => false,
        }
    }
}

/// Index of refraction of a dielectric, relative to air.
#[derive(Clone, Debug, PartialEq)]
pub enum RefractiveIndexDescription {
    /// One refractive index for all wavelengths.
    Index(f64),
    /// Name of a glass with a known dispersion formula.
    Named(Spanned<String>),
    /// Two-term Cauchy equation that has a given index and Abbe number.
    Abbe {
        /// Refractive index at the d line, 587.56 nm.
        index: f64,
        /// Abbe number, above 0; a smaller one means more dispersion.
        abbe: f64,
    },
    /// Dispersion formula. Its indices lie in [0.001, 1000] from 380 to 720 nm.
    Glass(DispersionFormula),
}

impl From<f64> for RefractiveIndexDescription {
    fn from(index: f64) -> Self {
        Self::Index(index)
    }
}

/// Smallest refractive index that a material may have.
pub const MIN_REFRACTIVE_INDEX: f64 = 0.001;
/// Largest refractive index that a material may have. Ratios and squares of indices stay well
/// within single precision.
pub const MAX_REFRACTIVE_INDEX: f64 = 1000.0;

/// Complex index of refraction of a conductor: that of a named metal, or given numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum MetalDescription {
    /// Name of a metal with a known complex index.
    Named(Spanned<String>),
    /// Index η + ik, relative to the surroundings.
    Index {
        /// Real part η of the complex index of refraction, above 0.
        eta: DVec3,
        /// Imaginary part k of the complex index of refraction, at least 0.
        k: DVec3,
    },
}

impl MetalDescription {
    /// Returns the conductor index η + ik, with each component clamped to the range that materials
    /// accept.
    #[must_use]
    pub fn with_nearest_index(eta: DVec3, k: DVec3) -> Self {
        let [least, greatest] = [MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX].map(DVec3::splat);
        Self::Index { eta: eta.clamp(least, greatest), k: k.clamp(DVec3::ZERO, greatest) }
    }
}

/// Absorption inside a dielectric body: none, a coefficient, or a transmittance over a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DielectricAbsorption {
    /// A body that absorbs nothing.
    None,
    /// Absorption coefficient σa in 1/length.
    Coefficient(DVec3),
    /// Transmittance over a given distance.
    Tint {
        /// Transmittance over `distance`, inside (0, 1].
        color: DVec3,
        /// Distance over which `color` is the transmittance, in scene units, above 0.
        distance: f64,
    },
}

impl DielectricAbsorption {
    /// Returns the absorption coefficient \[1/length] of the body, by Beer's law; 0 for `None`.
    #[must_use]
    pub fn absorption_coefficient(self) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Coefficient(sigma) => sigma,
            Self::Tint { color, distance } => -color.map(libm::log) / distance,
        }
    }
}
