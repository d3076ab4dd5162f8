//! Keyed randomness.
//!
//! A number is a function of (seed, purpose, pass, path, bounce, dimension) and of nothing else: not of the thread, nor of how
//! many numbers were drawn before. So a skipped effect shifts no other draw, and any pass can be computed alone.

use glam::Vec2;
use rand::{SeedableRng, rngs::SmallRng};

/// What a sequence of numbers is for; two purposes never share numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Photons of the global map.
    GlobalPhotons = 1,
    /// Photons aimed at what casts caustics.
    CausticPhotons,
    /// Camera rays.
    Camera,
    /// The pilot that finds radii before the first pass.
    Pilot,
    /// The pilot that weighs the lights for aimed emission.
    LightWeights,
    /// Statistical tests.
    Test,
    /// The pilot that finds what the camera sees.
    Visible,
    /// The pilot from which emission learns what is seen.
    Learning,
    /// Photons that guide gather rays.
    Guides,
    /// The pilot that finds how a pass should divide its work.
    Balance,
    /// The times of passes.
    Shutter,
}

/// The name of one decision at one vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Dimension {
    /// Which light emits or is sampled.
    Light = 1,
    /// Where on a light.
    LightPosition,
    /// Which way from a light.
    LightDirection,
    /// Which target of an aimed emission.
    LightTarget,
    /// Where in the pixel.
    Film,
    /// Which lobe of a BSDF.
    BsdfLobe,
    /// Which direction in a lobe.
    BsdfDirection,
    /// Whether the path goes on.
    Roulette,
    /// Which of the materials that are mixed.
    Mix,
    /// Where a disc is probed.
    Probe,
    /// Which part of a scattering function.
    Part,
    /// Whether a faint reflection is looked at.
    Worth,
    /// Where in the lens.
    Lens,
    /// When, while the shutter is open.
    Time,
    /// Which wavelength.
    Wavelength,
    /// Which direction after scattering in a medium.
    Phase,
    /// What happens on the way through a medium.
    Medium,
}

/// A name for a place in the space of random decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u64);

impl Key {
    /// The root key of a render.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(mix(seed ^ 0x6a09_e667_f3bc_c909))
    }

    /// The key of part `n` of this one: a pass, a path, a bounce.
    #[inline]
    #[must_use]
    pub fn with(self, n: u64) -> Self {
        Self(mix(self.0.wrapping_add(n.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15))))
    }

    /// The key of a purpose.
    #[must_use]
    pub fn purpose(self, purpose: Purpose) -> Self {
        self.with(purpose as u64)
    }

    /// 64 random bits for a dimension.
    #[inline]
    #[must_use]
    pub fn bits(self, dimension: Dimension) -> u64 {
        mix(self.0 ^ (dimension as u64).wrapping_mul(0xd6e8_feb8_6659_fd93))
    }

    /// A number in \[0, 1).
    #[inline]
    #[must_use]
    pub fn uniform(self, dimension: Dimension) -> f32 {
        unit((self.bits(dimension) >> 40) as u32)
    }

    /// A point in \[0, 1)².
    #[inline]
    #[must_use]
    pub fn uniform_2d(self, dimension: Dimension) -> Vec2 {
        let bits = self.bits(dimension);
        Vec2::new(unit((bits >> 40) as u32), unit((bits >> 8) as u32 & 0xff_ffff))
    }

    /// A generator for decisions that take an unknown number of draws.
    #[must_use]
    pub fn rng(self) -> SmallRng {
        SmallRng::seed_from_u64(self.0)
    }
}

/// A 24-bit integer to \[0, 1), exactly.
#[inline]
pub(super) fn unit(bits: u32) -> f32 {
    bits as f32 * (1.0 / 16_777_216.0)
}

/// A bijection of 64-bit words without visible structure (Stafford's variant 13 of the MurmurHash3 finaliser).
#[inline]
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_depend_on_every_part_of_the_name() {
        let base = |seed: u64, pass: u64, path: u64, bounce: u64| {
            Key::new(seed).purpose(Purpose::Test).with(pass).with(path).with(bounce)
        };
        let reference = base(1, 2, 3, 4).bits(Dimension::Light);
        let others = [
            base(2, 2, 3, 4).bits(Dimension::Light),
            base(1, 3, 3, 4).bits(Dimension::Light),
            base(1, 2, 4, 4).bits(Dimension::Light),
            base(1, 2, 3, 5).bits(Dimension::Light),
            base(1, 3, 2, 4).bits(Dimension::Light),
            base(1, 2, 3, 4).bits(Dimension::Film),
            Key::new(1).purpose(Purpose::Camera).with(2).with(3).with(4).bits(Dimension::Light),
        ];
        assert!(others.iter().all(|o| *o != reference));
        assert_eq!(base(1, 2, 3, 4).bits(Dimension::Light), reference);
    }

    /// Chi-square over 32² cells of a million points with consecutive keys; false alarm 10⁻⁴ a direction.
    #[test]
    fn consecutive_paths_fill_the_square() {
        const CELLS: usize = 32;
        let n = 1_000_000u64;
        let key = Key::new(7).purpose(Purpose::Test);
        let mut counts = vec![0u32; CELLS * CELLS];
        for path in 0..n {
            let u = key.with(path).uniform_2d(Dimension::LightPosition);
            assert!(u.cmpge(Vec2::ZERO).all() && u.cmplt(Vec2::ONE).all());
            counts[(u.y * CELLS as f32) as usize * CELLS + (u.x * CELLS as f32) as usize] += 1;
        }
        let expected = n as f64 / (CELLS * CELLS) as f64;
        let chi2: f64 = counts.iter().map(|c| (f64::from(*c) - expected) * (f64::from(*c) - expected) / expected).sum();
        // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance 2/(9ν).
        let nu = (CELLS * CELLS - 1) as f64;
        let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
        assert!(z.abs() < 3.9, "z = {z}");
    }
}
