//! The point and footprint at which a texture is evaluated.

use crate::color::Rgb;
use glam::{DMat2, DVec2, DVec3};

/// Largest number of box lookups along a footprint. A footprint that would need more gets longer
/// boxes instead.
const MAX_LOOKUPS: f64 = 16.0;

/// Largest length of a footprint, in periods of the texture. Longer footprints are shortened to
/// this length.
///
/// The mean over so long a footprint is practically the mean of the texture.
const MAX_FOOTPRINT_PERIODS: f64 = 1e6;

/// A surface point at which a texture is evaluated, with the footprint over which it is averaged.
///
/// If the footprint has zero size, the texture is evaluated at the point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureEvalContext {
    /// Texture coordinates of the point.
    pub uv: DVec2,
    /// Full axes of the footprint. Each is the difference of `uv` between both ends of the axis.
    pub footprint_axes: [DVec2; 2],
    /// The point in object space.
    pub object_p: DVec3,
    /// Diameter of the footprint in object space \[length], used by solid textures.
    pub footprint_width: f64,
}

impl TextureEvalContext {
    /// Context for an evaluation at a point: texture coordinates `uv`, object-space point `p`, no
    /// footprint.
    #[must_use]
    pub fn unfiltered(uv: DVec2, p: DVec3) -> Self {
        Self { uv, object_p: p, ..Self::default() }
    }
}

/// An affine map from the texture coordinates of a surface to those of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    matrix: DMat2,
    offset: DVec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self::new(DVec2::ONE, 0.0, DVec2::ZERO)
    }
}

impl UvTransform {
    /// Creates the map that scales (u, v) by `scale`, then rotates, then adds `offset`.
    ///
    /// The rotation is anticlockwise by `turn` \[radians].
    #[must_use]
    pub fn new(scale: DVec2, turn: f64, offset: DVec2) -> Self {
        let (sin, cos) = libm::sincos(turn);
        let matrix = DMat2::from_cols(DVec2::new(cos, sin) * scale.x, DVec2::new(-sin, cos) * scale.y);
        Self { matrix, offset }
    }

    /// Greatest factor by which the map scales lengths.
    pub(super) fn max_scale(&self) -> f64 {
        self.matrix.x_axis.length().max(self.matrix.y_axis.length())
    }

    /// Mean color of a texture over the footprint of `context`, as a mean of several box lookups.
    ///
    /// `lookup` returns the texture's mean over a box, given the box's center and sides in texture
    /// coordinates. The boxes lie side by side along the longer axis of the footprint (Heckbert
    /// 1989, section 3.5; Greene and Heckbert 1986).
    pub(super) fn filter_anisotropic(&self, context: &TextureEvalContext, lookup: impl Fn(DVec2, DVec2) -> Rgb) -> Rgb {
        let uv = self.matrix * context.uv + self.offset;
        // Bound the axes. They are very long or not finite where texture coordinates are singular,
        // for example at a pole of a sphere.
        let [a, b] = context.footprint_axes.map(|axis| {
            let axis = self.matrix * axis;
            if axis.is_finite() { axis.clamp_length_max(MAX_FOOTPRINT_PERIODS) } else { DVec2::ZERO }
        });
        let (long, short) = if a.length_squared() < b.length_squared() { (b, a) } else { (a, b) };
        if long == DVec2::ZERO {
            return lookup(uv, DVec2::ZERO);
        }
        let lookups = (long.length() / short.length()).ceil().clamp(1.0, MAX_LOOKUPS);
        let step = long / lookups;
        let size = (short * short + step * step).map(f64::sqrt);
        let mut sum = Rgb::ZERO;
        for i in 0..lookups as u32 {
            sum += lookup(uv + step * (f64::from(i) + 0.5 - 0.5 * lookups), size);
        }
        sum / lookups as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// Returns center and sides of each box that [`UvTransform::filter_anisotropic`] looks up at
    /// (¼, ½).
    fn recorded_lookups(coordinates: &UvTransform, axes: [DVec2; 2]) -> Vec<(DVec2, DVec2)> {
        let seen = RefCell::new(Vec::new());
        let context =
            TextureEvalContext { uv: DVec2::new(0.25, 0.5), footprint_axes: axes, ..TextureEvalContext::default() };
        coordinates.filter_anisotropic(&context, |uv, size| {
            seen.borrow_mut().push((uv, size));
            Rgb::ZERO
        });
        seen.into_inner()
    }

    #[test]
    fn texture_coordinates_are_scaled_rotated_then_translated() {
        let coordinates = UvTransform::new(DVec2::new(2.0, 4.0), std::f64::consts::FRAC_PI_2, DVec2::new(10.0, 20.0));
        let [(uv, size)] = recorded_lookups(&coordinates, [DVec2::ZERO; 2])[..] else { panic!("one lookup") };
        // (½, 2) rotated by 90° is (−2, ½).
        assert!((uv - DVec2::new(8.0, 20.5)).length() < 1e-12 && size == DVec2::ZERO);
        assert!((coordinates.max_scale() - 4.0).abs() < 1e-12);
    }

    /// Lookups lie side by side along the longer axis, centered on the point, and their boxes tile
    /// the footprint.
    #[test]
    fn anisotropic_footprints_are_tiled_by_lookups() {
        let seen = recorded_lookups(&UvTransform::default(), [DVec2::new(0.0, 0.1), DVec2::new(0.5, 0.0)]);
        assert_eq!(seen.len(), 5);
        for (i, (uv, size)) in seen.iter().enumerate() {
            assert!((*uv - DVec2::new(0.05 + 0.1 * i as f64, 0.5)).length() < 1e-12, "{uv}");
            assert!((*size - 0.1).length() < 1e-12);
        }
        assert_eq!(
            recorded_lookups(&UvTransform::default(), [DVec2::X * 1e3, DVec2::Y * 1e-9]).len(),
            MAX_LOOKUPS as usize
        );
        assert_eq!(recorded_lookups(&UvTransform::default(), [DVec2::splat(f64::INFINITY), DVec2::ZERO]).len(), 1);
    }
}
