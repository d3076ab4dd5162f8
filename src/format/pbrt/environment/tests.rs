//! Tests of environment maps of pbrt: equal areas and directions.

use super::*;

/// Equal areas of the sphere cover equal areas of the octahedral map.
#[test]
fn octahedral_maps_preserve_areas() {
    let n = 400;
    let mut counts = [0u32; 64];
    for i in 0..n * n {
        let (a, b) = (f64::from(i % n) + 0.5, f64::from(i / n) + 0.5);
        let (z, phi) = (2.0 * a / f64::from(n) - 1.0, TAU * b / f64::from(n));
        let r = (1.0 - z * z).sqrt();
        let place = octahedral_coordinates(DVec3::new(r * libm::cos(phi), r * libm::sin(phi), z));
        assert!(place.min_element() >= 0.0 && place.max_element() <= 1.0);
        let cell = (place * 8.0).floor().min(DVec2::splat(7.0));
        counts[(cell.y * 8.0 + cell.x) as usize] += 1;
    }
    let expected = f64::from(n * n) / 64.0;
    // Some points near the four borders of a cell fall into other cells.
    assert!(counts.iter().all(|count| (f64::from(*count) / expected - 1.0).abs() < 0.05), "{counts:?}");
    assert!(octahedral_coordinates(DVec3::Z).abs_diff_eq(DVec2::splat(0.5), 1e-12));
    assert!(octahedral_coordinates(DVec3::X).abs_diff_eq(DVec2::new(1.0, 0.5), 1e-12));
}

/// Compares the converted map with pbrt's map in several directions.
#[test]
fn converted_maps_show_the_rotated_sky() {
    let color = |d: DVec3| (0.5 + 0.5 * d).as_vec3();
    let (width, height) = (64, 32);
    let mut pixels = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let (phi, theta) = (TAU * (f64::from(column) + 0.5) / 64.0, PI * (f64::from(row) + 0.5) / 32.0);
            let sin = libm::sin(theta);
            pixels.push(color(DVec3::new(sin * libm::cos(phi), sin * libm::sin(phi), libm::cos(theta))));
        }
    }
    let image = Image::from_pixels(width, height, pixels).unwrap();
    let tilt = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);
    let map = to_equirectangular(&image, MapLayout::LatitudeLongitude, tilt).unwrap();
    for direction in [DVec3::X, DVec3::Z, DVec3::new(0.6, -0.64, 0.48)] {
        let phi = libm::atan2(direction.x, -direction.z).rem_euclid(TAU);
        let (x, y) = (phi / TAU * 64.0, libm::acos(direction.y) / PI * 32.0);
        let found = map.get(x as u32 % 64, (y as u32).min(31)).unwrap();
        let expected = color(tilt.transpose() * direction);
        // A pixel is up to 0.1 radian wide, and colors change by half of that.
        assert!((found - expected).abs().max_element() < 0.1, "{direction}: {found} {expected}");
    }
}
