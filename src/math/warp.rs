//! Sampling warps: maps from uniform points `u` in \[0, 1)² to other distributions.
//!
//! Directions are unit vectors in a local frame whose z axis is the pole. Pdfs of directions are
//! per steradian.

use super::sin_cos_turns;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Maps `u` in \[0, 1)² to a uniform point of the unit disc (Shirley and Chiu 1997).
#[inline]
#[must_use]
pub fn square_to_uniform_disc(u: Vec2) -> Vec2 {
    let o = u * 2.0 - Vec2::ONE;
    if o == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, turns) =
        if o.x.abs() > o.y.abs() { (o.x, 0.125 * (o.y / o.x)) } else { (o.y, 0.25 - 0.125 * (o.x / o.y)) };
    let (sin, cos) = sin_cos_turns(turns);
    Vec2::new(cos, sin) * radius
}

/// Maps `u` in \[0, 1)² to a cosine-weighted direction of the hemisphere z ≥ 0.
#[inline]
#[must_use]
pub fn square_to_cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = square_to_uniform_disc(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Pdf cosθ/π of [`square_to_cosine_hemisphere`] \[1/sr]; 0 for a negative cosine.
#[inline]
#[must_use]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Maps `u` in \[0, 1)² to a uniform direction of the sphere.
#[inline]
#[must_use]
pub fn square_to_uniform_sphere(u: Vec2) -> Vec3 {
    // 1 − z² = 4u(1−u) without cancellation near the poles.
    let z = 1.0 - 2.0 * u.x;
    vector_from_height_and_azimuth(z, 2.0 * (u.x * (1.0 - u.x)).sqrt(), u.y)
}

/// Maps `u` in \[0, 1)² to a uniform direction of the cone 1 − cosθ ≤ `one_minus_cos` around the z
/// axis.
///
/// The argument is not cosθ, because cosθ has too few digits for narrow cones.
#[inline]
#[must_use]
pub fn square_to_uniform_cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    let drop = u.x * one_minus_cos;
    vector_from_height_and_azimuth(1.0 - drop, (drop * (2.0 - drop)).max(0.0).sqrt(), u.y)
}

/// Pdf of [`square_to_uniform_cone`] \[1/sr]: 1/(2π·`one_minus_cos`).
#[inline]
#[must_use]
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (TAU * one_minus_cos)
}

/// Maps `u` in \[0, 1)² to a direction with the pdf (n+1)/(2π)·cosⁿθ, for n ≥ 0: a Phong lobe.
#[inline]
#[must_use]
pub fn square_to_power_cosine(u: Vec2, n: f32) -> Vec3 {
    // u.x in [0, 1) becomes (0, 1], which avoids powers of zero.
    let cos = libm::powf(1.0 - u.x, 1.0 / (n + 1.0));
    vector_from_height_and_azimuth(cos, (1.0 - cos * cos).max(0.0).sqrt(), u.y)
}

/// Pdf (n+1)/(2π)·cosⁿθ of [`square_to_power_cosine`] \[1/sr]; 0 for a cosine of 0 or less.
#[inline]
#[must_use]
pub fn power_cosine_pdf(cos_theta: f32, n: f32) -> f32 {
    if cos_theta > 0.0 { (n + 1.0) / TAU * libm::powf(cos_theta, n) } else { 0.0 }
}

/// Maps `u` in \[0, 1)² to the barycentric weights of the second and third corner of a triangle.
///
/// The points are uniform by area. Source: Heitz 2019, "A low-distortion map between triangle and
/// square".
#[inline]
#[must_use]
pub fn square_to_uniform_triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let x = u.x * 0.5;
        Vec2::new(x, u.y - x)
    } else {
        let y = u.y * 0.5;
        Vec2::new(u.x - y, y)
    }
}

/// Vector with the z coordinate `z`, the distance `radius` from the z axis, and the azimuth
/// 2π·`turn`.
#[inline]
fn vector_from_height_and_azimuth(z: f32, radius: f32, turn: f32) -> Vec3 {
    let (sin, cos) = sin_cos_turns(turn);
    Vec3::new(radius * cos, radius * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGES: [f32; 4] = [0.0, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0];

    fn midpoint_grid(n: u32) -> impl Iterator<Item = Vec2> {
        (0..n * n).map(move |i| (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32)
    }

    #[test]
    fn warps_of_extreme_inputs_stay_in_range() {
        for x in EDGES {
            for y in EDGES {
                let u = Vec2::new(x, y);
                assert!(square_to_uniform_disc(u).length() <= 1.0 + 1e-6);
                for v in [
                    square_to_cosine_hemisphere(u),
                    square_to_uniform_sphere(u),
                    square_to_uniform_cone(u, 1e-7),
                    square_to_uniform_cone(u, 2.0),
                    square_to_power_cosine(u, 1e4),
                ] {
                    assert!(v.is_finite() && (v.length() - 1.0).abs() < 2e-6, "{u} {v}");
                }
                let b = square_to_uniform_triangle(u);
                assert!(b.min_element() >= 0.0 && b.x + b.y <= 1.0 + 1e-6);
            }
        }
    }

    /// Moments, as means over the midpoints of n × n cells, agree with integrals. The worst
    /// integrand is a square root at an edge of the square, with an error of n^−3/2 = 3·10⁻⁵.
    #[test]
    fn warped_points_have_the_expected_moments() {
        let n = 1024u32;
        let mean = |f: &dyn Fn(Vec2) -> f32| midpoint_grid(n).map(|u| f64::from(f(u))).sum::<f64>() / f64::from(n * n);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a} {b}");
        close(mean(&|u| square_to_uniform_disc(u).length_squared()), 0.5);
        close(mean(&|u| square_to_cosine_hemisphere(u).z), 2.0 / 3.0);
        close(mean(&|u| square_to_uniform_sphere(u).z * square_to_uniform_sphere(u).z), 1.0 / 3.0);
        close(mean(&|u| square_to_uniform_cone(u, 0.25).z), 1.0 - 0.125);
        close(mean(&|u| square_to_power_cosine(u, 7.0).z), 8.0 / 9.0);
        close(mean(&|u| square_to_uniform_triangle(u).x), 1.0 / 3.0);
        close(mean(&|u| square_to_uniform_triangle(u).x * square_to_uniform_triangle(u).y), 1.0 / 12.0);
    }
}
