//! Clouds made of noise.

use crate::sampling::Key;
use crate::texture::noise::fractal;
use glam::DVec3;
use rand::RngExt;

/// A cloud in the ellipsoid that the unit cube holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cloud {
    /// Octaves of noise: each has half the wavelength and half the strength of the one before.
    pub octaves: u32,
    /// Wavelengths of the first octave along the cube's side.
    pub scale: f64,
    /// How much of the sky it covers, from 0 (nothing) to 1 (noise everywhere).
    pub cover: f64,
    /// The part of the radius, from 0 to 1, over which the edge thins out; 0 is a hard edge.
    pub softness: f64,
    /// Which of all such clouds.
    pub seed: u64,
}

impl Cloud {
    /// Its density, from 0 to 1, at points of the unit cube, told no finer than `width` (in sides of the cube; 0 is all).
    #[must_use]
    pub fn density(&self, width: f64) -> impl Fn(DVec3) -> f32 + Sync + use<> {
        let mut rng = Key::new(self.seed).rng();
        // Far enough that clouds of two seeds share no part, near enough that sums keep their digits.
        let shift = DVec3::from_array(std::array::from_fn(|_| 65536.0 * rng.random::<f64>()));
        let Self { octaves, scale, cover, softness, .. } = *self;
        move |p| {
            let inwards = 1.0 - (2.0 * p - 1.0).length();
            let edge = if inwards <= 0.0 { 0.0 } else { smooth(inwards / softness.max(f64::MIN_POSITIVE)) };
            // The edge takes from the cover, so that it frays rather than fades.
            let cover = cover.clamp(0.0, 1.0) * edge;
            if !(cover > 0.0) {
                return 0.0;
            }
            let height = (0.5 + fractal(p * scale + shift, width * scale, octaves)).clamp(0.0, 1.0);
            ((height - (1.0 - cover)) / cover).max(0.0) as f32
        }
    }
}

/// From 0 to 1 without a kink.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
