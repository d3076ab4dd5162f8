//! Gradient noise.

use glam::DVec3;

/// Widths of a patch, in wavelengths, between which an octave fades: narrower it is there, wider it is its mean, which is 0.
const FADE: [f64; 2] = [0.25, 1.0];

/// Moves one octave against the next, so that their lattices do not meet.
const SHIFT: DVec3 = DVec3::new(17.31, 5.77, 11.93);

/// Σ 2⁻ⁱ noise(2ⁱ p) over `octaves`, each faded as a patch of `width` would blur it.
pub(super) fn fractal(p: DVec3, width: f64, octaves: u32) -> f64 {
    let (mut sum, mut scale, mut weight) = (0.0, 1.0, 1.0);
    for i in 0..octaves {
        let there = fade(width * scale);
        if there == 0.0 {
            break;
        }
        sum += weight * there * noise(p * scale + SHIFT * f64::from(i));
        scale *= 2.0;
        weight *= 0.5;
    }
    sum
}

/// What is left of an octave under a patch of `width` wavelengths.
fn fade(width: f64) -> f64 {
    let t = ((FADE[1] - width) / (FADE[1] - FADE[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Noise in [−1, 1] with value 0 at whole coordinates (Perlin 2002, "Improving noise"); the lattice is hashed without a table, so it
/// does not repeat. Coordinates that are not finite give 0.
pub(super) fn noise(p: DVec3) -> f64 {
    if !p.is_finite() {
        return 0.0;
    }
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let [x, y, z] = [cell.x as i64, cell.y as i64, cell.z as i64];
    let corner = |dx: i64, dy: i64, dz: i64| {
        let h = hash(x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz));
        slope(h, f - DVec3::new(dx as f64, dy as f64, dz as f64))
    };
    let along = |dy, dz| lerp(w.x, corner(0, dy, dz), corner(1, dy, dz));
    lerp(w.z, lerp(w.y, along(0, 0), along(1, 0)), lerp(w.y, along(0, 1), along(1, 1)))
}

fn lerp(t: f64, a: f64, b: f64) -> f64 {
    a + t * (b - a)
}

/// One of the twelve directions to the middles of a cube's edges, four of them twice as likely, times `d`.
fn slope(h: u64, d: DVec3) -> f64 {
    let sign = |bit: u64, x: f64| if h >> bit & 1 == 0 { x } else { -x };
    let (a, b) = match h >> 2 & 15 {
        0..4 | 12 => (d.x, d.y),
        4..8 | 13 => (d.y, d.z),
        8..12 | 14 => (d.x, d.z),
        _ => (d.y, d.x),
    };
    sign(0, a) + sign(1, b)
}

/// Mixes lattice coordinates (the finaliser of Steele, Lea, Flood 2014).
fn hash(x: i64, y: i64, z: i64) -> u64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ y as u64).rotate_left(29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ z as u64).rotate_left(31).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^= h >> 30;
    h = h.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h ^ h >> 27
}
