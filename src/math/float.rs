//! Scalar functions with small rounding errors, and bounds on rounding errors.

use glam::Vec3;

/// γₙ = nε/(1 − nε) with ε = 2⁻²⁴: bound on the relative error of `n` chained f32 operations.
///
/// Source: Higham 2002, section 3.1; pbrt calls it `gamma`.
#[inline]
#[must_use]
pub const fn rounding_error_bound(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON * 0.5);
    e / (1.0 - e)
}

/// Real roots t of a t² + 2 b t + c = 0, ascending; `None` if the discriminant is negative.
///
/// The coefficient of t is 2 b, not b, and `a` must not be 0. `discriminant` is b² − a c. The
/// caller computes it, because it may know a formula with a smaller rounding error. The formula for
/// the roots avoids cancellation (Higham 2002, section 1.8).
#[inline]
#[must_use]
pub fn quadratic_roots_half_b(a: f64, b: f64, c: f64, discriminant: f64) -> Option<(f64, f64)> {
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    if q == 0.0 {
        return Some((0.0, 0.0));
    }
    let (t0, t1) = (q / a, c / q);
    Some(if t0 < t1 { (t0, t1) } else { (t1, t0) })
}

/// Sine and cosine of the angle 2π·`turns`, for `turns` in \[−1, 1], within one ulp.
///
/// Whole quarter turns are subtracted exactly. Taylor polynomials give sine and cosine of the
/// remaining angle, with an error below 2⁻²⁹ (Cody and Waite 1980, chapter 8).
#[inline]
#[must_use]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let quarters = (turns * 4.0).round();
    let x = f64::from(turns - quarters * 0.25) * std::f64::consts::TAU;
    let y = x * x;
    let sin = x * (1.0 - y * (1.0 / 6.0 - y * (1.0 / 120.0 - y * (1.0 / 5040.0 - y * (1.0 / 362_880.0)))));
    let cos = 1.0 - y * (0.5 - y * (1.0 / 24.0 - y * (1.0 / 720.0 - y * (1.0 / 40_320.0 - y * (1.0 / 3_628_800.0)))));
    let (sin, cos) = (sin as f32, cos as f32);
    match quarters as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Returns three quantities of the segment from `from` to `to`: squared length, unit direction and
/// length.
///
/// `None` if the squared length is 0 or not finite.
#[inline]
#[must_use]
pub fn distance2_direction_distance(from: Vec3, to: Vec3) -> Option<(f32, Vec3, f32)> {
    let d = to - from;
    let d2 = d.length_squared();
    if d2 > 0.0 && d2.is_finite() {
        let distance = d2.sqrt();
        Some((d2, d / distance, distance))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_keeps_the_small_root() {
        // t² − 2·10⁸ t + 1 = 0: the small root is 5·10⁻⁹, lost by the textbook formula.
        let (small, large) = quadratic_roots_half_b(1.0, -1e8, 1.0, 1e16 - 1.0).unwrap();
        assert!((small / 5e-9 - 1.0).abs() < 1e-12, "{small}");
        assert!((large / 2e8 - 1.0).abs() < 1e-12);
        assert!(quadratic_roots_half_b(1.0, 0.0, 1.0, -1.0).is_none());
        assert_eq!(quadratic_roots_half_b(1.0, 0.0, 0.0, 0.0), Some((0.0, 0.0)));
    }

    #[test]
    fn sin_cos_of_turns_agree_with_radians() {
        for i in -1000..=1000 {
            let t = i as f32 / 1000.0;
            let (sin, cos) = sin_cos_turns(t);
            let (s, c) = libm::sincos(f64::from(t) * std::f64::consts::TAU);
            assert!((f64::from(sin) - s).abs() < 7e-8 && (f64::from(cos) - c).abs() < 7e-8, "{t}");
        }
        assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turns(0.5), (0.0, -1.0));
    }

    #[test]
    fn rounding_error_bound_exceeds_n_half_ulps() {
        assert!(
            rounding_error_bound(3) > 3.0 * f32::EPSILON / 2.0 && rounding_error_bound(3) < 3.01 * f32::EPSILON / 2.0
        );
    }
}
