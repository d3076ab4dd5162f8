use super::*;
use glam::DQuat;

/// Texture that blends black and white, with three octaves of noise and two waves per unit length.
fn solid_texture_of_pattern(kind: SolidPattern, amplitude: f64, to_pattern: DAffine3) -> SolidTexture {
    SolidTexture {
        kind,
        colors: [Rgb::ZERO, Rgb::ONE],
        octaves: 3,
        frequency: 2.0,
        amplitude,
        object_to_pattern: to_pattern,
    }
}

#[test]
fn marble_and_wood_have_their_frequency_and_phase() {
    let marble = solid_texture_of_pattern(SolidPattern::Marble, 0.0, DAffine3::IDENTITY);
    let wood = solid_texture_of_pattern(SolidPattern::Wood, 0.0, DAffine3::IDENTITY);
    // At two waves per unit length, the first maximum is at distance ⅛.
    for (solid, p) in [(marble, DVec3::new(0.125, 9.0, 3.0)), (wood, DVec3::new(0.075, 9.0, 0.1))] {
        assert!((solid.color_at(p, 0.0).x - 1.0).abs() < 1e-6);
    }
    let turned = solid_texture_of_pattern(
        SolidPattern::Marble,
        0.0,
        DAffine3::from_quat(DQuat::from_rotation_z(-std::f64::consts::FRAC_PI_2)),
    );
    assert!((turned.color_at(DVec3::new(9.0, 0.125, 3.0), 0.0).x - 1.0).abs() < 1e-6);
}

/// A lookup over a wide footprint agrees with the mean of n point lookups over the same width w.
///
/// The points are midpoints, so the error of their mean is below (w/n)².
#[test]
fn wide_footprints_average_solid_textures() {
    let marble = solid_texture_of_pattern(SolidPattern::Marble, 0.0, DAffine3::IDENTITY);
    let (p, width, n) = (0.1, 0.3, 1000);
    let at = |i: i32| marble.color_at(DVec3::X * (p + width * ((f64::from(i) + 0.5) / f64::from(n) - 0.5)), 0.0).x;
    let mean = (0..n).map(|i| f64::from(at(i))).sum::<f64>() / f64::from(n);
    assert!((f64::from(marble.color_at(DVec3::X * p, width).x) - mean).abs() < 1e-6);
    assert_eq!(marble.color_at(DVec3::X * p, 10.0), Rgb::splat(0.5));
}

/// Averages each pattern over n points. Values lie in \[0, 1], so the tolerance 5/(2√n) is five
/// standard errors or more.
#[test]
fn solid_textures_have_their_stated_mean() {
    let n = 50_000;
    for kind in [SolidPattern::Noise, SolidPattern::Marble, SolidPattern::Wood] {
        let solid = solid_texture_of_pattern(kind, 1.5, DAffine3::IDENTITY);
        let p = |i: u32| DVec3::new(6.180_34, 4.142_14, 7.320_51) * f64::from(i) - 1e5;
        let mean = (0..n).map(|i| f64::from(solid.color_at(p(i), 0.0).x)).sum::<f64>() / f64::from(n);
        assert!((mean - f64::from(solid.mean().x)).abs() < 2.5 / f64::from(n).sqrt(), "{kind:?}: {mean}");
        assert!(solid.color_at(DVec3::splat(f64::INFINITY), 0.0).is_finite());
    }
}
