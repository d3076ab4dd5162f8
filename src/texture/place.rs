//! Where a texture is looked at.

use crate::color::Rgb;
use glam::{DMat2, DVec2, DVec3};

/// Most looks along a long patch; beyond, they grow wider and the texture blurs across the patch too.
const MOST: f64 = 16.0;

/// Longest patch in periods that still tells one texture from its mean.
const LONGEST: f64 = 1e6;

/// A point of a surface with the patch around it that one look covers; a patch of no size sees the point alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Texture coordinates.
    pub uv: DVec2,
    /// What `uv` changes by along both axes of the patch, from side to side.
    pub axes: [DVec2; 2],
    /// The point in the space of its object.
    pub p: DVec3,
    /// Width of the patch there \[length].
    pub width: f64,
}

impl Place {
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
    pub(super) fn spread(&self, place: &Place, look: impl Fn(DVec2, DVec2) -> Rgb) -> Rgb {
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
