//! Three texture images: a globe, a tile's normal map, and a roughness map of scratches.

use caustica::color::Rgb;
use caustica::image::{Image, ToneCurve};
use caustica::texture::{SolidPattern, SolidTexture};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// File name, transfer curve, and generator.
pub type Entry = (&'static str, ToneCurve, fn() -> Image);

/// All images.
pub const ALL: [Entry; 3] = [
    ("globe.png", ToneCurve::Srgb, globe),
    ("tile.png", ToneCurve::Legacy, tile),
    ("scratches.png", ToneCurve::Legacy, scratches),
];

fn picture(width: u32, height: u32, pixel: impl Fn(DVec2) -> Rgb) -> Image {
    let at = |i: u32| {
        let (x, y) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        pixel(DVec2::new(x / f64::from(width), 1.0 - y / f64::from(height)))
    };
    Image::from_pixels(width, height, (0..width * height).map(at).collect()).unwrap_or_else(|e| panic!("{e}"))
}

fn noise(octaves: u32, frequency: f64, amplitude: f64) -> SolidTexture {
    let colors = [Rgb::ZERO, Rgb::ONE];
    SolidTexture {
        kind: SolidPattern::Noise,
        colors,
        octaves,
        frequency,
        amplitude,
        object_to_pattern: DAffine3::IDENTITY,
    }
}

/// Returns a planet as a map of longitude and latitude.
///
/// Its land is noise on the sphere, so the map has no seam and no pinched pole.
fn globe() -> Image {
    let (land, climate) = (noise(7, 1.3, 1.6), noise(3, 2.5, 1.0));
    picture(512, 256, |uv| {
        let (sin, cos) = libm::sincos(TAU * (uv.x - 0.5));
        let (up, around) = libm::sincos(PI * (uv.y - 0.5));
        let p = DVec3::new(around * sin, up, around * cos);
        let height = land.color_at(p + 3.7, 0.0).x;
        let cold = up.abs() as f32 + 0.35 * (climate.color_at(p - 9.1, 0.0).x - 0.5);
        let color = |r: f32, g: f32, b: f32| Vec3::new(r, g, b);
        match height {
            _ if cold > 0.86 => color(0.85, 0.88, 0.92),
            h if h < 0.44 => color(0.015, 0.05, 0.18),
            h if h < 0.50 => color(0.03, 0.14, 0.30),
            h if h < 0.52 => color(0.62, 0.52, 0.32),
            h if h > 0.80 => color(0.45, 0.40, 0.36),
            _ if cold > 0.66 => color(0.30, 0.32, 0.20),
            _ if cold < 0.28 => color(0.05, 0.20, 0.04),
            _ if cold < 0.42 => color(0.50, 0.38, 0.18),
            _ => color(0.12, 0.28, 0.07),
        }
    })
}

/// Returns the normal map of a tile with slanted edges and a boss in its middle.
fn tile() -> Image {
    let height = |p: DVec2| {
        let edge = 0.5 - (p - 0.5).abs().max_element();
        let boss = 0.09 - ((p - 0.5).length() - 0.2).max(0.0);
        smooth(edge / 0.1) * 0.06 + smooth(boss / 0.09) * 0.07
    };
    picture(128, 128, |uv| {
        let step = 0.5 / 128.0;
        let slope = |d: DVec2| (height(uv + d) - height(uv - d)) / (2.0 * step);
        let n = DVec3::new(-slope(DVec2::X * step), -slope(DVec2::Y * step), 1.0).normalize();
        // The writer truncates levels; half a level more rounds them.
        (n * 0.5 + 0.5).as_vec3() + 0.5 / 255.0
    })
}

/// Returns a roughness map: fine strokes along u on a smooth ground.
fn scratches() -> Image {
    let strokes =
        SolidTexture { object_to_pattern: DAffine3::from_scale(DVec3::new(6.0, 90.0, 1.0)), ..noise(2, 1.0, 1.2) };
    let stains = noise(4, 4.0, 1.2);
    picture(256, 256, |uv| {
        // Sampling around a cylinder makes the map periodic in u.
        let (sin, cos) = libm::sincos(TAU * uv.x);
        let p = DVec3::new(cos / TAU, uv.y, sin / TAU);
        let stroke = (strokes.color_at(p, 0.0).x - 0.5).max(0.0) * 1.2;
        let level = 0.03 + 0.25 * stroke + 0.2 * smooth(f64::from(stains.color_at(p, 0.0).x - 0.45) / 0.2) as f32;
        // Few levels make a small file.
        Rgb::splat((level.min(0.29) * 64.0).round() / 64.0 + 0.5 / 255.0)
    })
}

/// Returns a smooth step from 0 to 1.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
