//! Colours as ꟻLIP compares them (section 4.1 of Andersson et al. 2020).

use glam::{DMat3, DVec3, Vec3};
use std::sync::LazyLock;

/// Columns: CIE XYZ of the primaries of Rec. 709 with the white point D65 at (0.3127, 0.3290), so that white has Y = 1.
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

/// Linear RGB to XYZ over that of white, and back.
static TO_WHITE: LazyLock<(DMat3, DMat3)> = LazyLock::new(|| {
    let white = XYZ * DVec3::ONE;
    let to = DMat3::from_diagonal(white.recip()) * XYZ;
    (to, to.inverse())
});

/// Exponent of colour differences, q_c.
const COLOR_EXPONENT: f64 = 0.7;
/// Where the slope of errors changes, as part of the largest, and the error that is given there: p_c and p_t.
const KNEE: (f64, f64) = (0.4, 0.95);

/// YCxCz of linear RGB: linear as XYZ, scaled as CIELAB.
pub(super) fn opponent(rgb: Vec3) -> Vec3 {
    let DVec3 { x, y, z } = TO_WHITE.0 * rgb.as_dvec3();
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)).as_vec3()
}

/// Luminance over that of white, of the first channel of YCxCz.
pub(super) fn luminance(y: f64) -> f64 {
    (y + 16.0) / 116.0
}

/// CIELAB of YCxCz with the chroma scaled by lightness (Hunt 1952), after what no screen shows is clamped.
pub(super) fn hunt_lab(ycxcz: DVec3) -> DVec3 {
    let y = luminance(ycxcz.x);
    let relative = DVec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0);
    lab_of_rgb((TO_WHITE.1 * relative).clamp(DVec3::ZERO, DVec3::ONE))
}

fn lab_of_rgb(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let t = TO_WHITE.0 * rgb;
    let (x, y, z) = (root(t.x), root(t.y), root(t.z));
    let lightness = 116.0 * y - 16.0;
    DVec3::new(lightness, 5.0 * lightness * (x - y), 2.0 * lightness * (y - z))
}

/// HyAB: lightness by its difference, chroma by its distance (Abasi et al. 2020).
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}

/// The largest error of colours: green against blue.
static LARGEST: LazyLock<f64> =
    LazyLock::new(|| libm::pow(hyab(lab_of_rgb(DVec3::Y), lab_of_rgb(DVec3::Z)), COLOR_EXPONENT));

/// The error of two colours in [0, 1]: HyAB to a power, large differences pressed together.
pub(super) fn color_error(a: DVec3, b: DVec3) -> f64 {
    let error = libm::pow(hyab(a, b), COLOR_EXPONENT);
    let (part, given) = KNEE;
    let knee = part * *LARGEST;
    if error < knee {
        given / knee * error
    } else {
        (given + (error - knee) / (*LARGEST - knee) * (1.0 - given)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L* of half the light of white is 116 · ∛½ − 16; greys have no chroma.
    #[test]
    fn greys_have_lightness_only() {
        let lab = hunt_lab(opponent(Vec3::splat(0.5)).as_dvec3());
        assert!((lab.x - 76.069_26).abs() < 1e-4, "{lab}");
        assert!(lab.y.abs() < 1e-4 && lab.z.abs() < 1e-4, "{lab}");
    }

    /// CIELAB of the red primary is (53.24, 80.09, 67.20) (Lindbloom's calculator, D65), times L*/100 for chroma.
    #[test]
    fn red_has_the_published_lab() {
        let lab = hunt_lab(opponent(Vec3::X).as_dvec3());
        let expected = DVec3::new(53.24, 80.09 * 0.5324, 67.20 * 0.5324);
        assert!((lab - expected).abs().max_element() < 0.02, "{lab}");
    }

    #[test]
    fn light_that_no_screen_shows_is_clamped() {
        let bright = hunt_lab(opponent(Vec3::new(4.0, 4.0, 4.0)).as_dvec3());
        assert!((bright - DVec3::new(100.0, 0.0, 0.0)).abs().max_element() < 1e-9, "{bright}");
    }
}
