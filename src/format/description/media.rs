//! What a scene file says of its media.

use glam::DVec3;

use super::{Map, Spanned};

/// What is between surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// What materials and the background call it: not empty, no line breaks.
    pub name: String,
    /// What it takes from light and scatters, in 1/length where its density is 1.
    pub coefficients: Coefficients,
    /// Radiance in W/(m² sr) that is gained per length where its density is 1.
    pub emission: DVec3,
    /// Which way light goes on after it scattered.
    pub phase: Phase,
    /// Where it is.
    pub density: Density,
}

/// What a medium takes from light, in one of two ways to say it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coefficients {
    /// Each for itself.
    Parts {
        /// σa, at least 0.
        absorption: DVec3,
        /// σs, at least 0.
        scattering: DVec3,
    },
    /// Both together.
    Whole {
        /// σt = σa + σs, at least 0.
        extinction: DVec3,
        /// σs/σt, inside [0, 1].
        albedo: DVec3,
    },
}

/// Which way light goes on after it scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// All ways alike.
    Isotropic,
    /// As from particles much smaller than its wavelength.
    Rayleigh,
    /// After Henyey and Greenstein, with this mean cosine inside (−1, 1).
    HenyeyGreenstein(f64),
}

/// Where a medium is.
#[derive(Clone, Debug, PartialEq)]
pub enum Density {
    /// 1 everywhere.
    Even,
    /// As a file says.
    Grid {
        /// As written: not empty, no line breaks.
        path: Spanned<String>,
        /// What its numbers are multiplied by, above 0.
        scale: f64,
        /// Where it lies.
        extent: Extent,
    },
    /// A cloud of noise, from 0 to 1, in the ellipsoid that a box holds.
    Cloud {
        /// From 0 (nothing) to 1 (noise everywhere).
        cover: f64,
        /// Part of the radius over which its edge thins out, inside [0, 1].
        softness: f64,
        /// Octaves of noise, 1 … 16.
        octaves: u32,
        /// Waves of the first octave along a side of the box, above 0.
        frequency: f64,
        /// Which of all such clouds.
        seed: u32,
        /// Cells of its grid along the longest side, 2 … 512.
        resolution: u32,
        /// Where it lies.
        extent: Extent,
    },
}

/// A box.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Its least corner, before the maps.
    pub min: DVec3,
    /// Its greatest corner, in each component above the least.
    pub max: DVec3,
    /// From the space of the corners to the world.
    pub maps: Vec<Map>,
}
