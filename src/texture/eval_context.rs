//! Where a texture is looked at.

use crate::color::Rgb;
use glam::{DMat2, DVec2, DVec3};

/// Most looks along a long patch; beyond, they grow wider and the texture blurs across the patch too.
const MOST: f64 = 16.0;

/// Longest patch in periods that still tells one texture from its mean.
const LONGEST: f64 = 1e6;

/// A point of a surface with the patch around it that one look covers; a patch of no size sees the point alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureEvalContext {
    /// Texture coordinates.
    pub uv: DVec2,
    /// What `uv` changes by along both axes of the patch, from side to side.
    pub axes: [DVec2; 2],
    /// The point in the space of its object.
    pub p: DVec3,
    /// Width of the patch there \[length].
    pub width: f64,
}

impl TextureEvalContext {
    /// A point alone.
    #[must_use]
    pub fn sharp(uv: DVec2, p: DVec3) -> Self {
        Self { uv, p, ..Self::default() }
    }
}

/// An affine map of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    matrix: DMat2,
    offset: DVec2,
}

impl Default for Coordinates {
    fn default() -> Self {
        Self::new(DVec2::ONE, 0.0, DVec2::ZERO)
    }
}

impl Coordinates {
    /// (u, v) are multiplied by `scale`, turned anticlockwise by `turn` \[radians], then moved by `offset`.
    #[must_use]
    pub fn new(scale: DVec2, turn: f64, offset: DVec2) -> Self {
        let (sin, cos) = libm::sincos(turn);
        let matrix = DMat2::from_cols(DVec2::new(cos, sin) * scale.x, DVec2::new(-sin, cos) * scale.y);
        Self { matrix, offset }
    }

    /// How many times a step may grow.
    pub(super) fn stretch(&self) -> f64 {
        self.matrix.x_axis.length().max(self.matrix.y_axis.length())
    }

    /// The mean of `look` over the patch: looks at a point with the sides of a box around it, one beside the other along the
    /// patch's longer axis (Heckbert 1989, section 3.5; Greene and Heckbert 1986 for a line of looks).
    pub(super) fn spread(&self, place: &TextureEvalContext, look: impl Fn(DVec2, DVec2) -> Rgb) -> Rgb {
        let uv = self.matrix * place.uv + self.offset;
        // Where coordinates run together, as at a pole, their axes know no bounds.
        let [a, b] = place.axes.map(|axis| {
            let axis = self.matrix * axis;
            if axis.is_finite() { axis.clamp_length_max(LONGEST) } else { DVec2::ZERO }
        });
        let (long, short) = if a.length_squared() < b.length_squared() { (b, a) } else { (a, b) };
        if long == DVec2::ZERO {
            return look(uv, DVec2::ZERO);
        }
        let looks = (long.length() / short.length()).ceil().clamp(1.0, MOST);
        let step = long / looks;
        let size = (short * short + step * step).map(f64::sqrt);
        let mut sum = Rgb::ZERO;
        for i in 0..looks as u32 {
            sum += look(uv + step * (f64::from(i) + 0.5 - 0.5 * looks), size);
        }
        sum / looks as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    fn looks(coordinates: &Coordinates, axes: [DVec2; 2]) -> Vec<(DVec2, DVec2)> {
        let seen = RefCell::new(Vec::new());
        let place = TextureEvalContext { uv: DVec2::new(0.25, 0.5), axes, ..TextureEvalContext::default() };
        coordinates.spread(&place, |uv, size| {
            seen.borrow_mut().push((uv, size));
            Rgb::ZERO
        });
        seen.into_inner()
    }

    #[test]
    fn coordinates_are_scaled_then_turned_then_moved() {
        let coordinates = Coordinates::new(DVec2::new(2.0, 4.0), std::f64::consts::FRAC_PI_2, DVec2::new(10.0, 20.0));
        let [(uv, size)] = looks(&coordinates, [DVec2::ZERO; 2])[..] else { panic!("one look") };
        // (½, 2) turned by a quarter is (−2, ½).
        assert!((uv - DVec2::new(8.0, 20.5)).length() < 1e-12 && size == DVec2::ZERO);
        assert!((coordinates.stretch() - 4.0).abs() < 1e-12);
    }

    /// Looks lie side by side along the longer axis, centred on the place, and their boxes make up the patch.
    #[test]
    fn a_long_patch_is_seen_by_looks_along_it() {
        let seen = looks(&Coordinates::default(), [DVec2::new(0.0, 0.1), DVec2::new(0.5, 0.0)]);
        assert_eq!(seen.len(), 5);
        for (i, (uv, size)) in seen.iter().enumerate() {
            assert!((*uv - DVec2::new(0.05 + 0.1 * i as f64, 0.5)).length() < 1e-12, "{uv}");
            assert!((*size - 0.1).length() < 1e-12);
        }
        assert_eq!(looks(&Coordinates::default(), [DVec2::X * 1e3, DVec2::Y * 1e-9]).len(), MOST as usize);
        assert_eq!(looks(&Coordinates::default(), [DVec2::splat(f64::INFINITY), DVec2::ZERO]).len(), 1);
    }
}
