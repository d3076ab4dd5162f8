//! Participating media of a description.

use glam::DVec3;

use super::{Spanned, TransformStep};

/// A participating medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    /// Name that materials and the background refer to: not empty, no line breaks.
    pub name: String,
    /// Absorption and scattering in 1/length at density 1.
    pub coefficients: MediumCoefficients,
    /// Radiance in W/(m² sr) gained per length at density 1.
    pub emission: DVec3,
    /// Phase function.
    pub phase: PhaseFunctionDescription,
    /// Density.
    pub density: DensityDescription,
}

/// Absorption and scattering of a medium, in one of two parametrizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MediumCoefficients {
    /// Absorption and scattering.
    AbsorptionScattering {
        /// σa, at least 0.
        absorption: DVec3,
        /// σs, at least 0.
        scattering: DVec3,
    },
    /// Extinction and albedo.
    ExtinctionAlbedo {
        /// σt = σa + σs, at least 0.
        extinction: DVec3,
        /// σs/σt, inside [0, 1].
        albedo: DVec3,
    },
}

/// Phase function of a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunctionDescription {
    /// Equal in all directions.
    Isotropic,
    /// Rayleigh scattering: particles much smaller than the wavelength.
    Rayleigh,
    /// Henyey–Greenstein with this mean cosine, inside (−1, 1).
    HenyeyGreenstein(f64),
}

/// Density of a medium.
#[derive(Clone, Debug, PartialEq)]
pub enum DensityDescription {
    /// 1 everywhere: a homogeneous medium.
    Homogeneous,
    /// Densities of a grid file.
    Grid {
        /// Path as written: not empty, no line breaks.
        path: Spanned<String>,
        /// Factor of the densities, above 0.
        scale: f64,
        /// Box that the grid fills.
        extent: TransformedBoxDescription,
    },
    /// Noise from 0 to 1 in the ellipsoid inscribed in a box.
    Cloud {
        /// Amount of noise, from 0 (empty) to 1 (everywhere).
        cover: f64,
        /// Share of the radius over which the edge fades, inside [0, 1].
        softness: f64,
        /// Octaves of noise, 1 … 16.
        octaves: u32,
        /// Periods of the first octave along a side of the box, above 0.
        frequency: f64,
        /// Seed of the noise.
        seed: u32,
        /// Grid cells along the longest side, 2 … 512.
        resolution: u32,
        /// Box that the grid fills.
        extent: TransformedBoxDescription,
    },
}

/// A box, transformed.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformedBoxDescription {
    /// Its least corner, before the maps.
    pub min: DVec3,
    /// Its greatest corner, in each component above the least.
    pub max: DVec3,
    /// From the space of the corners to the world.
    pub maps: Vec<TransformStep>,
}
