//! The squared error of a picture: its parts and their uncertainties.

/// Parts of the squared relative error of a picture, with the variances of their estimates.
///
/// Errors are relative, see [`RelativeErrorWeights`](crate::image::RelativeErrorWeights).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SquaredErrorParts {
    /// Squared relative noise of the picture: the variance of the mean of the passes.
    pub noise: f64,
    /// Relative variance 2/N of the squared noise of one picture about its expectation. N is the
    /// effective sample count: the squared noise varies like the mean square of N independent
    /// Gaussian values.
    pub realised_noise_relative_variance: f64,
    /// Relative variance of the estimate `noise` about the true value, the expected squared noise
    /// of the picture.
    pub noise_estimate_relative_variance: f64,
    /// Squared relative blur of the picture: the squared bias of photon density estimates.
    pub blur: f64,
    /// Variance of the estimate `blur`.
    pub blur_variance: f64,
    /// Squared relative error due to camera paths that are the same in all passes.
    pub shared_paths: f64,
    /// Variance of the estimate `shared_paths`.
    pub shared_paths_variance: f64,
    /// Squared relative bias due to the light that clamping removes from camera paths.
    pub clamping: f64,
    /// Variance of the estimate `clamping`.
    pub clamping_variance: f64,
}

impl SquaredErrorParts {
    /// Returns the squared error: the sum of the parts.
    pub fn total(&self) -> f64 {
        self.noise + self.blur + self.shared_paths + self.clamping
    }

    /// Returns the variance of the estimated [`total`](Self::total) about the true squared error of
    /// the picture.
    fn variance(&self) -> f64 {
        let bias = self.blur + self.shared_paths + self.clamping;
        let realised = self.noise * (self.noise + 2.0 * bias) * self.realised_noise_relative_variance;
        let estimated = self.noise * self.noise * self.noise_estimate_relative_variance;
        realised + estimated + self.blur_variance + self.shared_paths_variance + self.clamping_variance
    }

    /// Returns the lower and upper end of the error interval.
    ///
    /// The ends are √(E² ∓ `half_width`·σ). E² is the estimated squared error
    /// [`total`](Self::total), and σ the standard deviation of this estimate. A negative square
    /// becomes 0.
    pub fn error_interval(&self, half_width: f64) -> (f64, f64) {
        let deviation = half_width * self.variance().sqrt();
        ((self.total() - deviation).max(0.0).sqrt(), (self.total() + deviation).sqrt())
    }
}
