//! Pixels whose noise is beyond what one pixel may count for.

/// Octaves of size that are told apart; what is larger counts with the last.
const OCTAVES: usize = 32;

/// How many pixels hold light that few passes found, by how bright it was.
///
/// The squared error of such a pixel counts 1, while it would be c > 1. It goes as 1/n² as long as no other pass finds the like, but passes
/// that are added find it in other pixels, so that with n' = mn passes m times as many pixels count min(1, c/m²): all together grow at
/// first, and fall as 1/n' only when the specks have faded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Specks {
    /// Parts of the picture by ⌊log₂ c⌋.
    parts: [f64; OCTAVES],
}

impl Specks {
    /// Adds a part of the picture whose squared error is `square` > 1.
    pub(super) fn add(&mut self, square: f64, part: f64) {
        let octave = libm::log2(square).clamp(0.0, (OCTAVES - 1) as f64);
        self.parts[octave as usize] += part;
    }

    /// The mean square that they count for now.
    pub(super) fn now(&self) -> f64 {
        self.parts.iter().sum()
    }

    /// The mean square that they count for with `more` times as many passes; the whole picture counts 1.
    pub(super) fn after(&self, more: f64) -> f64 {
        let one = |(octave, part): (usize, &f64)| part * (libm::exp2(octave as f64 + 0.5) / (more * more)).min(1.0);
        (more * self.parts.iter().enumerate().map(one).sum::<f64>()).min(1.0)
    }
}
