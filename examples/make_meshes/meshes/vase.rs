//! A fluted vase. Its outside ripples around the axis and twists with height; the inside is round,
//! so that each flute is a lens.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, dvec2};

use super::mesh::Mesh;
use super::profile::{Profile, Sample};

const FLUTES: f64 = 12.0;
/// Depth of the flutes, to either side of the profile.
const DEPTH: f64 = 0.022;
/// Rotation of the flutes \[rad] per unit of height.
const TWIST: f64 = 0.55;
/// Heights between which the flutes rise and vanish.
const SPAN: (f64, f64) = (0.04, 1.44);
/// Segments of the profile that form the outside.
const OUTSIDE: std::ops::RangeInclusive<usize> = 2..=4;

/// Returns the vase, standing on y = 0, about 1.8 high, as one closed smooth surface.
pub fn vase() -> Mesh {
    profile().revolve_with(Mesh::new("Fluted vase, one closed surface with a wall", 5, 4), 168, fluted)
}

fn profile() -> Profile {
    let outside = Profile::new(0.0, 0.0)
        .line_to(0.32, 0.0, 2)
        .arc(dvec2(0.32, 0.03), FRAC_PI_2, 3)
        .cubic_to(dvec2(0.35, 0.22), dvec2(0.52, 0.40), dvec2(0.52, 0.68), 13)
        .cubic_to(dvec2(0.52, 0.98), dvec2(0.26, 1.10), dvec2(0.26, 1.38), 13)
        .cubic_to(dvec2(0.26, 1.56), dvec2(0.32, 1.68), dvec2(0.38, 1.78), 6);
    let (rim, up) = outside.end();
    let half_wall = 0.02;
    let inner_rim = rim + up.perp() * (2.0 * half_wall);
    outside
        .arc(rim + up.perp() * half_wall, PI, 6)
        .cubic_to(inner_rim - up * 0.12, dvec2(0.21, 1.54), dvec2(0.21, 1.38), 5)
        .cubic_to(dvec2(0.21, 1.10), dvec2(0.45, 0.98), dvec2(0.45, 0.68), 7)
        .cubic_to(dvec2(0.45, 0.34), dvec2(0.28, 0.11), dvec2(0.0, 0.11), 9)
}

/// Returns a point of the outside, at radius R(y, θ) = r + A(y) cos(Nθ + Ty), and its normal, the
/// cross product of the two derivatives.
fn fluted(sample: &Sample, angle: f64) -> (DVec3, DVec3) {
    let (p, t) = (sample.point, sample.tangent);
    let (amplitude, slope) = if OUTSIDE.contains(&sample.segment) { swell(p.y) } else { (0.0, 0.0) };
    let (wave_sin, wave_cos) = libm::sincos(FLUTES * (angle + TWIST * p.y));
    let radius = p.x + amplitude * wave_cos;
    let radius_along = t.x + (slope * wave_cos - amplitude * FLUTES * TWIST * wave_sin) * t.y;
    let radius_around = -amplitude * FLUTES * wave_sin;

    let (sin, cos) = libm::sincos(angle);
    let position = DVec3::new(radius * cos, p.y, radius * sin);
    if radius == 0.0 {
        return (position, DVec3::new(0.0, -t.x, 0.0));
    }
    let along = DVec3::new(radius_along * cos, t.y, radius_along * sin);
    let around = DVec3::new(radius_around * cos - radius * sin, 0.0, radius_around * sin + radius * cos);
    (position, along.cross(around))
}

/// Returns the flutes' amplitude at a height and its derivative: sin² over the span, so both vanish
/// at its ends.
fn swell(y: f64) -> (f64, f64) {
    let (low, high) = SPAN;
    if y <= low || y >= high {
        return (0.0, 0.0);
    }
    let rate = PI / (high - low);
    let (sin, cos) = libm::sincos(rate * (y - low));
    (DEPTH * sin * sin, 2.0 * DEPTH * rate * sin * cos)
}
