//! Participating media of a [`SceneDescription`](super::SceneDescription), as the scene file states
//! them.

use glam::DVec3;

use super::{Spanned, TransformStep};

/// A participating medium as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    /// Name that materials and the scene's ambient medium refer to: not empty, without line breaks.
    pub name: String,
    /// Absorption and scattering in 1/length at density 1.
    pub coefficients: MediumCoefficients,
    /// Emitted radiance per length at density 1, in W/(m² sr) per unit of length.
    pub emission: DVec3,
    /// Phase function of the medium.
    pub phase: PhaseFunctionDescription,
    /// Density by position. It multiplies the coefficients and the emission.
    pub density: DensityDescription,
}

/// Absorption and scattering coefficients of a medium, in one of two parametrizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MediumCoefficients {
    /// Absorption and scattering coefficients.
    AbsorptionScattering {
        /// Absorption coefficient σa in 1/length at density 1, at least 0.
        absorption: DVec3,
        /// Scattering coefficient σs in 1/length at density 1, at least 0.
        scattering: DVec3,
    },
    /// Extinction coefficient and single-scattering albedo.
    ExtinctionAlbedo {
        /// Extinction coefficient σt = σa + σs in 1/length at density 1, at least 0.
        extinction: DVec3,
        /// Single-scattering albedo σs/σt, inside [0, 1].
        albedo: DVec3,
    },
}

/// Phase function of a medium, which gives the distribution of directions after scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunctionDescription {
    /// Equal scattering in all directions.
    Isotropic,
    /// Rayleigh scattering: particles much smaller than the wavelength.
    Rayleigh,
    /// Henyey–Greenstein with this mean cosine, inside (−1, 1).
    HenyeyGreenstein(f64),
}

/// Density of a medium as a function of position. It multiplies the medium's coefficients.
#[derive(Clone, Debug, PartialEq)]
pub enum DensityDescription {
    /// Density 1 everywhere.
    Homogeneous,
    /// Densities from a grid file.
    Grid {
        /// Path of the grid file as the text writes it: not empty, without line breaks.
        path: Spanned<String>,
        /// Factor that multiplies the file's densities, above 0.
        scale: f64,
        /// Box that the grid fills.
        extent: TransformedBoxDescription,
    },
    /// A procedural cloud in the ellipsoid inscribed in a box. Its density is noise from 0 to 1.
    Cloud {
        /// Cloud cover, from 0 (empty) to 1 (everywhere).
        cover: f64,
        /// Width of the cloud's soft edge, as a fraction of the ellipsoid's radius, inside [0, 1].
        softness: f64,
        /// Number of noise octaves, from 1 to 16.
        octaves: u32,
        /// Number of noise periods of the first octave along each side of the box, above 0.
        frequency: f64,
        /// Random seed of the noise.
        seed: u32,
        /// Number of grid cells along the longest side of the box, from 2 to 512.
        resolution: u32,
        /// Box that contains the cloud's ellipsoid.
        extent: TransformedBoxDescription,
    },
}

/// A box under an affine transform.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformedBoxDescription {
    /// Corner with the lowest coordinates, before the transform.
    pub min: DVec3,
    /// Opposite corner, above `min` in every coordinate.
    pub max: DVec3,
    /// Steps of the transform to world space; see [`TransformStep::composed_matrix`].
    pub steps: Vec<TransformStep>,
}
