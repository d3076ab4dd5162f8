//! A path tracer of one scene of pbrt, `spotfog`, that shares no code with the renderer.

use crate::support::test_key;
use glam::{DVec3, Vec3};
use rand::RngExt;
use rand::rngs::SmallRng;
use std::f64::consts::{PI, TAU};

/// Extinction of the fog \[1/length].
const EXTINCTION: f64 = 0.15;

/// Albedo of the fog.
const FOG_ALBEDO: f64 = 0.1 / 0.15;

/// Number of scattering points of a path: pbrt's `maxdepth`.
const DEPTH: u32 = 8;

/// Offset of rays that leave a surface.
const OFFSET: f64 = 1e-6;

/// Sides of a surface on which rays that leave it travel through fog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fog {
    /// Fog on both sides of every surface.
    Everywhere,
    /// Fog only on the side of the normal, as in pbrt. Walls turn their backs to the camera.
    InFrontOfSheets,
}

/// Intersection of a ray with a surface.
struct Hit {
    distance: f64,
    /// Normal of the surface, in the direction of pbrt's outer side.
    normal: DVec3,
    albedo: DVec3,
}

/// Returns a random unit vector whose cosine to `axis` is `cos`.
fn around(axis: DVec3, cos: f64, rng: &mut SmallRng) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let (phi, sin) = (TAU * rng.random::<f64>(), (1.0 - cos * cos).max(0.0).sqrt());
    x * (sin * libm::cos(phi)) + y * (sin * libm::sin(phi)) + axis * cos
}

/// Returns the nearest surface: a ball, the floor, and two walls.
fn nearest(origin: DVec3, direction: DVec3) -> Option<Hit> {
    let mut hit: Option<Hit> = None;
    let mut keep = |distance: f64, normal: DVec3, albedo: DVec3| {
        if distance > OFFSET && hit.as_ref().is_none_or(|hit| distance < hit.distance) {
            hit = Some(Hit { distance, normal, albedo });
        }
    };
    let center = DVec3::new(-1.0, 1.0, 2.7);
    let (from, half) = (origin - center, (origin - center).dot(direction));
    let root = half * half - from.length_squared() + 0.25;
    if root > 0.0 {
        let distance = -half - root.sqrt();
        keep(distance, (from + direction * distance).normalize(), DVec3::splat(0.07));
    }
    let walls = [
        (DVec3::NEG_Y, 1.0, DVec3::new(-6.0, -1.0, -2.0), DVec3::new(4.0, -1.0, 8.0)),
        (DVec3::Z, 6.0, DVec3::new(-6.0, -1.0, 6.0), DVec3::new(4.0, 9.0, 6.0)),
        (DVec3::X, 4.0, DVec3::new(4.0, -1.0, 0.0), DVec3::new(4.0, 9.0, 6.0)),
    ];
    for (normal, offset, low, high) in walls {
        let distance = (offset - normal.dot(origin)) / normal.dot(direction);
        let point = origin + direction * distance;
        let is_inside = (0..3).all(|i| normal[i] != 0.0 || (point[i] > low[i] && point[i] < high[i]));
        if is_inside {
            keep(distance, normal, DVec3::new(0.2, 0.2, 0.3));
        }
    }
    hit
}

/// Returns the direction to the spotlight, its distance, and its irradiance across that direction;
/// `None` if it does not shine on the point.
fn spotlight(point: DVec3) -> Option<(DVec3, f64, f64)> {
    let position = DVec3::new(-4.0, 5.0, 1.0);
    let axis = (DVec3::new(-1.0, 1.0, 3.0) - position).normalize();
    let (to, distance) = ((position - point).normalize(), position.distance(point));
    let [outer, inner] = [16.0_f64, 11.0].map(|degrees| libm::cos(degrees.to_radians()));
    let x = ((-to.dot(axis) - outer) / (inner - outer)).clamp(0.0, 1.0);
    let is_hidden = nearest(point, to).is_some_and(|hit| hit.distance < distance);
    (x > 0.0 && !is_hidden).then(|| (to, distance, 2500.0 * x * x * (3.0 - 2.0 * x) / (distance * distance)))
}

/// Returns the radiance of one path from the camera.
fn radiance(direction: DVec3, fog: Fog, rng: &mut SmallRng) -> DVec3 {
    let (mut origin, mut direction, mut is_foggy) = (DVec3::ZERO, direction, true);
    let (mut throughput, mut sum) = (DVec3::ONE, DVec3::ZERO);
    for _ in 0..DEPTH {
        let hit = nearest(origin, direction);
        let distance = if is_foggy { -libm::log(1.0 - rng.random::<f64>()) / EXTINCTION } else { f64::INFINITY };
        let dimmed = |distance: f64| libm::exp(-EXTINCTION * distance);
        match hit {
            Some(hit) if hit.distance <= distance => {
                let facing = if hit.normal.dot(direction) < 0.0 { hit.normal } else { -hit.normal };
                is_foggy = fog == Fog::Everywhere || facing == hit.normal;
                throughput *= hit.albedo;
                origin += direction * hit.distance + facing * OFFSET;
                if let Some((to, distance, irradiance)) = spotlight(origin) {
                    let transmittance = if is_foggy { dimmed(distance) } else { 1.0 };
                    sum += throughput * (irradiance * transmittance * to.dot(facing).max(0.0) / PI);
                }
                let cos = rng.random::<f64>().sqrt();
                direction = around(facing, cos, rng);
            }
            _ if distance.is_finite() => {
                throughput *= FOG_ALBEDO;
                origin += direction * distance;
                if let Some((_, distance, irradiance)) = spotlight(origin) {
                    sum += throughput * (irradiance * dimmed(distance) / (4.0 * PI));
                }
                let cos = 1.0 - 2.0 * rng.random::<f64>();
                direction = around(DVec3::Z, cos, rng);
            }
            _ => break,
        }
    }
    sum
}

/// Returns the picture with this many samples per pixel.
pub fn spotfog_picture((width, height): (u32, u32), samples: u32, fog: Fog, seed: u64) -> Vec<Vec3> {
    let tangent = libm::tan(35.0_f64.to_radians());
    let turn = glam::DMat3::from_rotation_x(-5.0_f64.to_radians());
    let pixel = |i: u32| {
        let mut rng = test_key(seed).child_key(u64::from(i)).rng();
        let mut sum = DVec3::ZERO;
        for _ in 0..samples {
            let (x, y) = (f64::from(i % width) + rng.random::<f64>(), f64::from(i / width) + rng.random::<f64>());
            let (x, y) = (2.0 * x - f64::from(width), f64::from(height) - 2.0 * y);
            let direction = DVec3::new(x, y, f64::from(height) / tangent).normalize();
            sum += radiance(turn * direction, fog, &mut rng);
        }
        (sum / f64::from(samples)).as_vec3()
    };
    (0..width * height).map(pixel).collect()
}
