//! Rays in cylindrical coordinates: height, and distance from the axis.

use glam::{DVec2, DVec3};

/// Squared sine of the angle between a ray and the y axis, below which the ray counts as nearly
/// parallel to the axis.
///
/// [`CylindricalRay::clip_to_ring`] clips a ray to a ring: a range of distances from the axis and a
/// range of heights. A nearly parallel ray is clipped by the heights only. The distances only
/// decide whether this ray misses the ring.
const MIN_SLANT2: f64 = 1e-2;

/// Interval of the arc length τ along a ray; empty unless `lo <= hi`.
#[derive(Clone, Copy, Debug)]
pub struct ArcLengthInterval {
    pub lo: f64,
    pub hi: f64,
}

impl ArcLengthInterval {
    /// True if no arc length lies in the interval, also if an end is NaN.
    pub fn is_empty(self) -> bool {
        self.lo.is_nan() || self.hi.is_nan() || self.lo > self.hi
    }
}

/// Object-space line, with its distance ρ from the y axis and its height y as functions of the arc
/// length τ.
///
/// τ is 0 at the point nearest to the object-space origin. ρ(τ) = |(x, z)| is convex, and y(τ) is
/// linear.
#[derive(Clone, Copy, Debug)]
pub struct CylindricalRay {
    /// Point of the line at arc length τ = 0.
    pub base: DVec3,
    /// Unit direction of the line.
    pub direction: DVec3,
    /// Coefficients c of the squared distance from the y axis, ρ² = c₀ + 2·c₁·τ + c₂·τ².
    pub radius2_coefficients: [f64; 3],
    /// Arc length τ of the point nearest to the y axis; not finite for rays parallel to the axis.
    pub tau_nearest_axis: f64,
    /// Minimum of ρ², the squared distance from the y axis, at τ = `tau_nearest_axis`; NaN for rays
    /// parallel to the axis.
    pub min_radius2: f64,
}

impl CylindricalRay {
    /// Line along the unit vector `direction`, with τ = 0 at its point `base`.
    pub fn new(base: DVec3, direction: DVec3) -> Self {
        let DVec3 { x, z, .. } = base;
        let slant2 = direction.x * direction.x + direction.z * direction.z;
        let along = x * direction.x + z * direction.z;
        let across = x * direction.z - z * direction.x;
        Self {
            base,
            direction,
            radius2_coefficients: [x * x + z * z, along, slant2],
            tau_nearest_axis: -along / slant2,
            min_radius2: across * across / slant2,
        }
    }

    /// Distance from the y axis at the point `base` + `t` · `direction`, and the derivative of this
    /// distance by `t`. On the axis, the result for the derivative is 0.
    #[inline]
    pub fn radius_and_slope(&self, t: f64) -> (f64, f64) {
        let (x, z) = (self.base.x + t * self.direction.x, self.base.z + t * self.direction.z);
        let radius = (x * x + z * z).sqrt();
        let slope = if radius > 0.0 { (x * self.direction.x + z * self.direction.z) / radius } else { 0.0 };
        (radius, slope)
    }

    /// Height y at arc length `t`.
    #[inline]
    pub fn height_at(&self, t: f64) -> f64 {
        self.base.y + t * self.direction.y
    }

    /// Intervals of arc length, within the interval `t`, in which the line may be inside a ring.
    ///
    /// The ring is around the y axis. It covers the distances `x` from the axis and the heights
    /// `y`, both widened by `margin`. There are at most two intervals, since ρ(τ) is convex.
    /// Missing intervals are empty.
    #[inline]
    pub fn clip_to_ring(&self, x: [f64; 2], y: [f64; 2], t: ArcLengthInterval, margin: f64) -> [ArcLengthInterval; 2] {
        const NOWHERE: ArcLengthInterval = ArcLengthInterval { lo: 1.0, hi: 0.0 };
        let ArcLengthInterval { mut lo, mut hi } = t;
        let (below, above) = (y[0] - margin - self.base.y, y[1] + margin - self.base.y);
        if self.direction.y == 0.0 {
            if below > 0.0 || above < 0.0 {
                return [NOWHERE; 2];
            }
        } else {
            let (a, b) = (below / self.direction.y, above / self.direction.y);
            lo = lo.max(a.min(b));
            hi = hi.min(a.max(b));
        }
        let [inner, outer] = [x[0] - margin, x[1] + margin];
        let slant2 = self.radius2_coefficients[2];
        if slant2 < MIN_SLANT2 {
            // The ray is nearly parallel to the axis. Its distance from the axis differs from the
            // distance at the middle of the interval by at most `half` times the sine of the angle.
            let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
            let radius = self.radius_and_slope(middle).0;
            let reach = half * slant2.sqrt() + margin;
            let away = radius - reach > outer || radius + reach < inner;
            return [if away { NOWHERE } else { ArcLengthInterval { lo, hi } }, NOWHERE];
        }
        let shell = outer * outer - self.min_radius2;
        if shell < 0.0 || outer < 0.0 {
            return [NOWHERE; 2];
        }
        let reach = (shell / slant2).sqrt() + margin;
        (lo, hi) = (lo.max(self.tau_nearest_axis - reach), hi.min(self.tau_nearest_axis + reach));
        let core = inner * inner - self.min_radius2;
        if inner <= 0.0 || core <= 0.0 {
            return [ArcLengthInterval { lo, hi }, NOWHERE];
        }
        let gap = (core / slant2).sqrt() - margin;
        [
            ArcLengthInterval { lo, hi: hi.min(self.tau_nearest_axis - gap) },
            ArcLengthInterval { lo: lo.max(self.tau_nearest_axis + gap), hi },
        ]
    }
}

/// Distance of the point `p` from the y axis, and the unit direction (x, z) from the axis to `p`.
///
/// If `p` lies on the axis, the direction is (1, 0).
#[inline]
pub fn polar_radius_and_direction(p: DVec3) -> (f64, DVec2) {
    let across = DVec2::new(p.x, p.z);
    (across.length(), across.try_normalize().unwrap_or(DVec2::X))
}
