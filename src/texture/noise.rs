//! Gradient noise (Perlin 2002), and fractal noise as a sum of its octaves.

use glam::DVec3;

/// Two widths of a footprint, in wavelengths of an octave of noise: the octave begins to fade at
/// the first width, and vanishes at the second.
const FADE_WIDTHS: [f64; 2] = [0.25, 1.0];

/// Offset that is added to the noise position from each octave to the next, so that the lattices of
/// octaves do not align.
const OCTAVE_OFFSET: DVec3 = DVec3::new(17.31, 5.77, 11.93);

/// Fractal noise at `p`, in (−2, 2): Σ 2⁻ⁱ·noise(2ⁱ·p + i·c) over the octaves i.
///
/// i goes from 0 to `octaves` − 1, and c is a constant offset. An octave fades out if its
/// wavelength is small compared with the footprint's `width`, so that textures do not alias. `p`
/// and `width` are in wavelengths of the first octave.
pub(crate) fn fractal_noise(p: DVec3, width: f64, octaves: u32) -> f64 {
    let (mut sum, mut scale, mut weight) = (0.0, 1.0, 1.0);
    for i in 0..octaves {
        let fade = octave_fade(width * scale);
        if fade == 0.0 {
            break;
        }
        sum += weight * fade * gradient_noise(p * scale + OCTAVE_OFFSET * f64::from(i));
        scale *= 2.0;
        weight *= 0.5;
    }
    sum
}

/// Weight in \[0, 1] of an octave of noise: 1 for a small footprint, 0 for a footprint that blurs
/// all details.
///
/// `width` is the width of the footprint in wavelengths of the octave.
fn octave_fade(width: f64) -> f64 {
    let t = ((FADE_WIDTHS[1] - width) / (FADE_WIDTHS[1] - FADE_WIDTHS[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gradient noise at `p`, in \[−1, 1]; 0 at integer coordinates (Perlin 2002, "Improving noise").
///
/// Lattice points are hashed without a table, so the noise does not repeat. The result is 0 if a
/// coordinate is not finite.
pub(super) fn gradient_noise(p: DVec3) -> f64 {
    if !p.is_finite() {
        return 0.0;
    }
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let [x, y, z] = [cell.x as i64, cell.y as i64, cell.z as i64];
    let corner = |dx: i64, dy: i64, dz: i64| {
        let h = lattice_hash(x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz));
        gradient_dot(h, f - DVec3::new(dx as f64, dy as f64, dz as f64))
    };
    let along = |dy, dz| lerp(w.x, corner(0, dy, dz), corner(1, dy, dz));
    lerp(w.z, lerp(w.y, along(0, 0), along(1, 0)), lerp(w.y, along(0, 1), along(1, 1)))
}

/// Linear interpolation from `a` at t = 0 to `b` at t = 1.
fn lerp(t: f64, a: f64, b: f64) -> f64 {
    a + t * (b - a)
}

/// Dot product of `d` with the lattice gradient that hash `h` selects.
///
/// The gradients are the twelve vectors from the center of a cube of side 2 to the midpoints of its
/// edges. Each of the four without a z component has the probability 6/64, each of the others 5/64.
fn gradient_dot(h: u64, d: DVec3) -> f64 {
    let sign = |bit: u64, x: f64| if h >> bit & 1 == 0 { x } else { -x };
    let (a, b) = match h >> 2 & 15 {
        0..4 | 12 => (d.x, d.y),
        4..8 | 13 => (d.y, d.z),
        8..12 | 14 => (d.x, d.z),
        _ => (d.y, d.x),
    };
    sign(0, a) + sign(1, b)
}

/// Hash of integer lattice coordinates, with constants of SplitMix64 (Steele, Lea, Flood 2014).
fn lattice_hash(x: i64, y: i64, z: i64) -> u64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ y as u64).rotate_left(29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ z as u64).rotate_left(31).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^= h >> 30;
    h = h.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h ^ h >> 27
}

#[cfg(test)]
mod tests;
