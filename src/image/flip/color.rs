//! Color differences of ꟻLIP (Andersson et al. 2020, section 4.1).

use glam::{DMat3, DVec3, Vec3};
use std::sync::LazyLock;

/// Matrix from linear Rec. 709 RGB to CIE XYZ. White is D65 at (0.3127, 0.3290) and has Y = 1.
const XYZ: DMat3 = DMat3::from_cols_array(&[
    10_135_552.0 / 24_577_794.0,
    2_613_072.0 / 12_288_897.0,
    1_425_312.0 / 73_733_382.0,
    8_788_810.0 / 24_577_794.0,
    8_788_810.0 / 12_288_897.0,
    8_788_810.0 / 73_733_382.0,
    4_435_075.0 / 24_577_794.0,
    887_015.0 / 12_288_897.0,
    70_074_185.0 / 73_733_382.0,
]);

/// Two matrices: from linear RGB to relative XYZ, and back. In relative XYZ, each coordinate is
/// divided by that of white.
static RELATIVE_XYZ: LazyLock<(DMat3, DMat3)> = LazyLock::new(|| {
    let white = XYZ * DVec3::ONE;
    let to = DMat3::from_diagonal(white.recip()) * XYZ;
    (to, to.inverse())
});

/// Exponent q_c of Andersson et al. 2020: the difference of two colors is their HyAB distance to
/// this power.
const COLOR_EXPONENT: f64 = 0.7;
/// Knee of the piecewise linear map from color difference to ꟻLIP error: p_c and p_t of Andersson
/// et al. 2020.
///
/// A color difference of 0.4 times [`MAX_COLOR_DIFFERENCE`] has the error 0.95.
const COLOR_ERROR_KNEE: (f64, f64) = (0.4, 0.95);

/// Converts linear RGB to YCxCz, an opponent space that is linear in XYZ and scaled like CIELAB.
pub(super) fn rgb_to_ycxcz(rgb: Vec3) -> Vec3 {
    let DVec3 { x, y, z } = RELATIVE_XYZ.0 * rgb.as_dvec3();
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)).as_vec3()
}

/// Converts channel Y of YCxCz to luminance relative to white: (Y + 16) / 116.
pub(super) fn ycxcz_y_to_luminance(y: f64) -> f64 {
    (y + 16.0) / 116.0
}

/// Converts YCxCz to CIELAB with Hunt adjustment: chroma is multiplied by L*/100 (Hunt 1952).
///
/// The color is first clamped to the RGB cube.
pub(super) fn hunt_lab_from_ycxcz(ycxcz: DVec3) -> DVec3 {
    let y = ycxcz_y_to_luminance(ycxcz.x);
    let relative = DVec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0);
    hunt_lab_from_rgb((RELATIVE_XYZ.1 * relative).clamp(DVec3::ZERO, DVec3::ONE))
}

/// Converts linear RGB to CIELAB with Hunt adjustment: chroma is multiplied by L*/100.
fn hunt_lab_from_rgb(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let t = RELATIVE_XYZ.0 * rgb;
    let (x, y, z) = (root(t.x), root(t.y), root(t.z));
    let lightness = 116.0 * y - 16.0;
    DVec3::new(lightness, 5.0 * lightness * (x - y), 2.0 * lightness * (y - z))
}

/// HyAB distance: |ΔL*| plus the Euclidean distance in (a*, b*) (Abasi et al. 2020).
fn hyab_distance(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}

/// Largest color difference between two colors of the RGB cube. It occurs between green and blue.
///
/// A color difference is the HyAB distance to the power [`COLOR_EXPONENT`].
static MAX_COLOR_DIFFERENCE: LazyLock<f64> = LazyLock::new(|| {
    libm::pow(hyab_distance(hunt_lab_from_rgb(DVec3::Y), hunt_lab_from_rgb(DVec3::Z)), COLOR_EXPONENT)
});

/// Returns the ꟻLIP error, from 0 to 1, between the colors `a` and `b` in Hunt-adjusted CIELAB.
///
/// The HyAB distance to the power [`COLOR_EXPONENT`] is mapped to an error by two straight segments
/// that meet at [`COLOR_ERROR_KNEE`]. The second segment is flatter, so large differences are
/// compressed.
pub(super) fn color_error(a: DVec3, b: DVec3) -> f64 {
    let error = libm::pow(hyab_distance(a, b), COLOR_EXPONENT);
    let (fraction, at_knee) = COLOR_ERROR_KNEE;
    let knee = fraction * *MAX_COLOR_DIFFERENCE;
    if error < knee {
        at_knee / knee * error
    } else {
        (at_knee + (error - knee) / (*MAX_COLOR_DIFFERENCE - knee) * (1.0 - at_knee)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grays have no chroma. At half the luminance of white, L* is 116 · ∛½ − 16.
    #[test]
    fn greys_have_lightness_only() {
        let lab = hunt_lab_from_ycxcz(rgb_to_ycxcz(Vec3::splat(0.5)).as_dvec3());
        assert!((lab.x - 76.069_26).abs() < 1e-4, "{lab}");
        assert!(lab.y.abs() < 1e-4 && lab.z.abs() < 1e-4, "{lab}");
    }

    /// The red primary has CIELAB (53.24, 80.09, 67.20) under white D65, by Lindbloom's calculator.
    ///
    /// The Hunt adjustment multiplies a* and b* by L*/100.
    #[test]
    fn red_has_the_published_lab() {
        let lab = hunt_lab_from_ycxcz(rgb_to_ycxcz(Vec3::X).as_dvec3());
        let expected = DVec3::new(53.24, 80.09 * 0.5324, 67.20 * 0.5324);
        assert!((lab - expected).abs().max_element() < 0.02, "{lab}");
    }

    #[test]
    fn colours_outside_of_rgb_are_clamped() {
        let bright = hunt_lab_from_ycxcz(rgb_to_ycxcz(Vec3::new(4.0, 4.0, 4.0)).as_dvec3());
        assert!((bright - DVec3::new(100.0, 0.0, 0.0)).abs().max_element() < 1e-9, "{bright}");
    }
}
