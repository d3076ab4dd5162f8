//! Pieces of profile curves in the plane of radius and height, and their intersection with rays.

use super::cylindrical_ray::{ArcLengthInterval, CylindricalRay};
use super::polynomial::{Coefficient, MAX_DEGREE, evaluate_with_derivative, reparametrize};
use super::root_finding::{
    MAX_DERIVATIVE_CHANGE, MAX_FIRST_NEWTON_STEP, NEWTON_CONVERGENCE_RATE, PIECE_OVERLAP, RootClassification,
    TANGENT_HIT_RELATIVE_SIZE,
};
use arrayvec::ArrayVec;

/// Polynomial piece of a profile: radius and height (ρ, y) as functions of x in \[−1, 1].
#[derive(Clone, Copy, Debug)]
pub struct ProfilePiece<'a> {
    /// Coefficients (ρ, y) of the powers of x, from degree 0.
    pub coefficients: &'a [Coefficient<2>],
    /// Upper bound on the rounding error of a point that is computed from the polynomials
    /// \[object-space length].
    pub point_error_bound: f64,
}

/// Capacity of the list of intervals of the curve parameter x that must still be searched for a
/// hit.
///
/// Sixty halvings shrink an interval to the size of rounding errors. Each halving adds one interval
/// to the list.
const MAX_INTERVALS: usize = 64;

/// Interval of a piece's curve parameter x.
#[derive(Clone, Copy, Debug)]
struct XInterval {
    middle: f64,
    half: f64,
}

impl XInterval {
    const WHOLE: Self = Self { middle: 0.0, half: 1.0 };

    /// Returns the upper half, then the lower half. A stack to which they are pushed in this order
    /// returns the lower half first.
    fn halves(self) -> [Self; 2] {
        let half = 0.5 * self.half;
        [Self { middle: self.middle + half, half }, Self { middle: self.middle - half, half }]
    }
}

/// Two bounds on the terms aₖ xᵏ with k ≥ 2 of a polynomial, for x in \[−1, 1] and for each
/// component.
///
/// The first result bounds the sum of these terms: Σ |aₖ|. The second bounds the change of their
/// derivative: Σ k|aₖ|.
#[inline]
fn higher_term_and_derivative_bounds(a: &[Coefficient<2>]) -> (Coefficient<2>, Coefficient<2>) {
    let (mut rest, mut turn) = ([0.0; 2], [0.0; 2]);
    for (k, c) in a.iter().enumerate().skip(2) {
        for i in 0..2 {
            rest[i] += c[i].abs();
            turn[i] += k as f64 * c[i].abs();
        }
    }
    (rest, turn)
}

impl ProfilePiece<'_> {
    /// Curve parameter x and arc length τ of the nearest hit of `ray`; `None` if the ray misses the
    /// surface that this piece sweeps around the axis.
    ///
    /// Only hits within `t`, an interval of τ, count. Moves the end of `t` to the hit. `size` is
    /// the size of the whole surface \[object-space length]. Intervals of x are halved until each
    /// has no root, one root, or the size of a rounding error.
    pub fn nearest_hit(&self, ray: &CylindricalRay, t: &mut ArcLengthInterval, size: f64) -> Option<(f64, f64)> {
        let mut found = None;
        if self.search_interval(self.coefficients, XInterval::WHOLE, ray, t, size, &mut found) {
            self.search_halves(ray, t, size, &mut found);
        }
        found
    }

    /// Searches both halves of the piece for a nearer hit than `found`, as
    /// [`ProfilePiece::nearest_hit`] does.
    #[cold]
    fn search_halves(
        &self,
        ray: &CylindricalRay,
        t: &mut ArcLengthInterval,
        size: f64,
        found: &mut Option<(f64, f64)>,
    ) {
        let mut intervals: ArrayVec<XInterval, MAX_INTERVALS> = XInterval::WHOLE.halves().into_iter().collect();
        let mut own = [[0.0; 2]; MAX_DEGREE + 1];
        let own = &mut own[..self.coefficients.len()];
        while let Some(interval) = intervals.pop() {
            own.copy_from_slice(self.coefficients);
            reparametrize(own, interval.middle, interval.half);
            if self.search_interval(own, interval, ray, t, size, found) && intervals.remaining_capacity() >= 2 {
                intervals.extend(interval.halves());
            }
        }
    }

    /// Searches the part of the piece over `interval`. A nearer hit (x, τ) replaces `found` and
    /// moves the end of `t`. Returns true if the interval must be halved, since it may have further
    /// hits.
    ///
    /// `a` are the coefficients of the part, for the powers of its own parameter in \[−1, 1].
    #[inline]
    fn search_interval(
        &self,
        a: &[Coefficient<2>],
        interval: XInterval,
        ray: &CylindricalRay,
        t: &mut ArcLengthInterval,
        size: f64,
        found: &mut Option<(f64, f64)>,
    ) -> bool {
        let XInterval { middle, half } = interval;
        let (rest, turn) = higher_term_and_derivative_bounds(a);
        let reach = [a[1][0].abs() + rest[0], a[1][1].abs() + rest[1]];
        let range = |i: usize| [a[0][i] - reach[i], a[0][i] + reach[i]];
        let mut must_halve = false;
        for taus in ray.clip_to_ring(range(0), range(1), *t, self.point_error_bound) {
            if taus.is_empty() {
                continue;
            }
            let extent = reach[0].max(reach[1]);
            let touched = match classify_roots(a, (rest, turn), ray, taus, self.point_error_bound) {
                RootClassification::NoRoot => None,
                RootClassification::Root(x, at) => Some((middle + half * x, at)),
                _ if extent <= 4.0 * self.point_error_bound => Some((middle, 0.5 * (taus.lo + taus.hi))),
                RootClassification::LineInSurface if extent <= TANGENT_HIT_RELATIVE_SIZE * size => {
                    Some((middle, 0.5 * (taus.lo + taus.hi)))
                }
                RootClassification::LineInSurface => None,
                RootClassification::Unclear => {
                    must_halve = true;
                    None
                }
            };
            if let Some((x, at)) = touched
                && t.lo <= at
                && at <= t.hi
            {
                t.hi = at;
                *found = Some((x, at));
            }
        }
        must_halve
    }
}

/// Tests whether a ray hits the surface that a profile piece sweeps around the axis. `a` are the
/// polynomial coefficients of the piece.
///
/// A hit is an x in \[−1, 1] and a τ in `t` at which profile and ray have equal radius and height.
/// `rest` and `turn` are the [`higher_term_and_derivative_bounds`] of `a`. `noise` bounds the
/// rounding error of points computed from `a`.
#[inline]
fn classify_roots(
    a: &[Coefficient<2>],
    (rest, turn): (Coefficient<2>, Coefficient<2>),
    ray: &CylindricalRay,
    t: ArcLengthInterval,
    noise: f64,
) -> RootClassification<f64> {
    let dy = ray.direction.y;
    let at = 0.5 * (t.lo + t.hi);
    let (radius, slope) = ray.radius_and_slope(at);
    let [dx, dh] = a[1];
    let determinant = slope * dh - dx * dy;
    let least = determinant.abs();
    // If the τ interval is narrow for the piece's curvature, Newton's method could not be proved to
    // converge in it. The interval is then widened, which does not change the result.
    let wander = dh.abs() * turn[0] + dx.abs() * turn[1];
    let mut half = 0.5 * (t.hi - t.lo) + noise;
    if wander < least {
        half = half.max(8.0 * wander / least);
    }
    let ends = [ray.radius_and_slope(at - half), ray.radius_and_slope(at + half)];
    let bow = (ends[0].0 - radius + slope * half).max(ends[1].0 - radius - slope * half).max(0.0);
    let bend = (slope - ends[0].1).max(ends[1].1 - slope).max(0.0);
    let miss = [radius - a[0][0], ray.height_at(at) - a[0][1]];
    let error = [rest[0] + bow + noise, rest[1] + noise];
    let across = slope * miss[1] - dy * miss[0];
    let along = dx * miss[1] - dh * miss[0];
    if across.abs() > least + dy.abs() * error[0] + slope.abs() * error[1]
        || along.abs() > least * half + dh.abs() * error[0] + dx.abs() * error[1]
    {
        return RootClassification::NoRoot;
    }
    let change = [turn[0] + bend * half, turn[1]];
    let (from_x, from_t) =
        (dy.abs() * change[0] + slope.abs() * change[1], dh.abs() * change[0] + dx.abs() * change[1]);
    if from_x < MAX_DERIVATIVE_CHANGE * least && from_t < MAX_DERIVATIVE_CHANGE * least * half {
        let blur = noise * (dy.abs() + slope.abs()).max((dh.abs() + dx.abs()) / half) / least;
        let start = (across / determinant, along / determinant);
        return newton_root(a, ray, at, half, start, PIECE_OVERLAP + 4.0 * blur)
            .map_or(RootClassification::NoRoot, |(x, t)| RootClassification::Root(x, t));
    }
    let blur = (dy.abs() + slope.abs() + bend) * noise;
    let most = least + dh.abs() * bend + dy.abs() * turn[0] + (slope.abs() + bend) * turn[1];
    if most <= blur { RootClassification::LineInSurface } else { RootClassification::Unclear }
}

/// Curve parameter x and arc length τ of the only possible hit, by Newton's method.
///
/// The search covers x in \[−1, 1] and τ within `half` of `at`. `start` is the first iterate, as
/// (x, τ − `at`). A hit also counts if it is outside this box by at most `tolerance` half widths of
/// the box. `None` if there is no hit.
fn newton_root(
    a: &[Coefficient<2>],
    ray: &CylindricalRay,
    at: f64,
    half: f64,
    start: (f64, f64),
    tolerance: f64,
) -> Option<(f64, f64)> {
    let dy = ray.direction.y;
    let (mut x, mut z) = (start.0.clamp(-1.0, 1.0), start.1.clamp(-half, half));
    let mut longest = MAX_FIRST_NEWTON_STEP;
    loop {
        let ([px, py], [dx, dh]) = evaluate_with_derivative(a, x);
        let (radius, slope) = ray.radius_and_slope(at + z);
        let miss = [radius - px, ray.height_at(at + z) - py];
        let determinant = slope * dh - dx * dy;
        let step_x = (slope * miss[1] - dy * miss[0]) / determinant;
        let step_z = (dx * miss[1] - dh * miss[0]) / determinant;
        let step = step_x.abs().max(step_z.abs() / half);
        // Newton's method converges more slowly than it must for a root in the box, so there is
        // none.
        if step.is_nan() || step > longest.max(tolerance) {
            return None;
        }
        longest *= NEWTON_CONVERGENCE_RATE;
        let (next_x, next_z) = ((x + step_x).clamp(-1.0, 1.0), (z + step_z).clamp(-half, half));
        let moved = (next_x - x).abs().max((next_z - z).abs() / half);
        (x, z) = (next_x, next_z);
        if step <= tolerance {
            return Some((x, at + z));
        }
        // If x* were a root and T(x) the next iterate, then |T(x) − x*| ≤ ⅔|x − x*|. An iterate
        // that stands still but still has a long step is no root, so there is none.
        if moved <= 0.01 * tolerance {
            return None;
        }
    }
}
