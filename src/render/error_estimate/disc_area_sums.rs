//! Sums over passes of powers of the gather disc area, for forecasts of noise and blur.

use crate::integrate::squared_radius_ratio;

/// Number of passes, counted from the first, that are summed one by one. Later passes are summed in
/// groups.
pub(super) const EXACT_PASSES: u32 = 1024;

/// Divisor for the size of a group of passes that is summed at once. The first [`EXACT_PASSES`]
/// passes are summed one by one. After them, the next group has n/`GROUP_DIVISOR` passes, where n
/// is the number of passes summed so far.
pub(super) const GROUP_DIVISOR: u32 = 128;

/// Sums over passes from which the noise and the blur after any number of passes are forecast.
///
/// Two powers of the gather disc area, relative to the first pass, are summed: area^−1 for the
/// variance of photon estimates, and area^`blur_exponent` for their blur.
#[derive(Clone, Copy, Debug)]
pub(super) struct DiscAreaSums {
    /// Parameter α of the radius law r²ᵢ₊₁ = r²ᵢ·(i + α)/(i + 1) (Knaus and Zwicker 2011). rᵢ is
    /// the gather radius of pass i = 1, 2, …; it stays fixed if α is 1.
    alpha: f64,
    /// Exponent p: the blur of a pass is proportional to the p-th power of its gather disc area.
    blur_exponent: f64,
    /// Number of summed passes.
    pub passes: u32,
    /// Gather disc area of the next pass, relative to the first pass. The next pass is not summed
    /// yet.
    next_relative_area: f64,
    /// Sum over passes of 1/area. The variance of the summed photon estimates is proportional to
    /// this sum.
    pub inverse_area_sum: f64,
    /// Sum over passes of area^`blur_exponent`. The blur of the picture is proportional to this sum
    /// divided by `passes`.
    pub area_power_sum: f64,
}

impl DiscAreaSums {
    pub fn new(alpha: f64, blur_exponent: f64) -> Self {
        Self {
            alpha,
            blur_exponent,
            passes: 0,
            next_relative_area: squared_radius_ratio(alpha, 0),
            inverse_area_sum: 0.0,
            area_power_sum: 0.0,
        }
    }

    /// Returns the sums over the first `passes` passes, with a relative error below 10⁻³.
    pub fn of_passes(alpha: f64, blur_exponent: f64, passes: u32) -> Self {
        let mut sums = Self::new(alpha, blur_exponent);
        sums.advance_to(passes);
        sums
    }

    /// Adds passes until the sums hold `passes` passes. Does nothing if they already hold that
    /// many.
    pub fn advance_to(&mut self, passes: u32) {
        while self.passes < passes {
            if self.passes + self.group_size() > passes { self.add_pass() } else { self.add_group() }
        }
    }

    /// Adds the next group of passes: a single pass up to [`EXACT_PASSES`] passes, then
    /// 1/[`GROUP_DIVISOR`] of the passes summed so far.
    pub fn add_group(&mut self) {
        if self.group_size() > 1 { self.add_passes_by_midpoint(self.group_size()) } else { self.add_pass() }
    }

    /// Returns the number of passes that the next [`add_group`](Self::add_group) adds.
    fn group_size(&self) -> u32 {
        if self.passes < EXACT_PASSES { 1 } else { self.passes / GROUP_DIVISOR }
    }

    fn add_pass(&mut self) {
        self.inverse_area_sum += 1.0 / self.next_relative_area;
        self.area_power_sum += if self.blur_exponent == 1.0 {
            self.next_relative_area
        } else {
            libm::pow(self.next_relative_area, self.blur_exponent)
        };
        self.passes += 1;
        let i = f64::from(self.passes);
        self.next_relative_area *= (i + self.alpha) / (i + 1.0);
    }

    /// Adds the next `count` passes at once by the midpoint rule.
    ///
    /// The rule uses area ∝ n^(α − 1), which holds for large pass numbers n, with the parameter α
    /// of the radius law.
    fn add_passes_by_midpoint(&mut self, count: u32) {
        let n = f64::from(self.passes);
        let at = |i: f64| self.next_relative_area * libm::pow(i / n, self.alpha - 1.0);
        let middle = at(n + 0.5 * f64::from(count));
        self.next_relative_area = at(n + f64::from(count));
        self.inverse_area_sum += f64::from(count) / middle;
        self.area_power_sum += f64::from(count) * libm::pow(middle, self.blur_exponent);
        self.passes += count;
    }
}
