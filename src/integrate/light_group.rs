//! Light groups: direct, indirect and caustic light, which add up to the picture.

use super::vertex::PathHistory;
use crate::color::Rgb;

enum_with_all! {
    /// Part of a picture's light: direct, indirect or caustic.
    ///
    /// The surfaces on the light's way to the camera determine the part. A *receiver* is a surface
    /// or medium that stores photons, such as a diffuse wall; a *caster* passes photons on, such as
    /// glass. Casters between the camera and the first receiver do not change the part.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum LightGroup {
        /// Light that goes straight from a light to the camera path's first receiver (surface or
        /// medium that stores photons). Also light that the camera sees without any receiver:
        /// lights, the environment and the background.
        Direct,
        /// Light that another receiver (surface or medium that stores photons) has scattered before
        /// it reaches the camera path's first receiver.
        Indirect,
        /// Light that reaches the camera path's first receiver (surface or medium that stores
        /// photons) via one or more casters, such as glass, without another receiver before.
        Caustic,
    }
}

impl LightGroup {
    /// Returns the name of the group, such as `direct`. Layers of image files have this name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Caustic => "caustic",
        }
    }

    /// Returns the group of light that a camera path finds after the receivers (surfaces and media
    /// that store photons) and casters (such as glass) of `history`.
    #[inline]
    pub(super) fn of_found_light(history: PathHistory) -> Self {
        match (history.receivers, history.casters_since_receiver) {
            (0, _) | (1, 0) => Self::Direct,
            (1, _) => Self::Caustic,
            (_, _) => Self::Indirect,
        }
    }

    /// Returns the group of direct light at a receiver (surface or medium that stores photons).
    /// `history` counts the receivers and casters on the path before it.
    #[inline]
    pub(super) fn of_direct_light(history: PathHistory) -> Self {
        Self::of_found_light(PathHistory { receivers: history.receivers + 1, casters_since_receiver: 0 })
    }

    /// Returns the group of a photon estimate from the caustic map at a receiver (surface or medium
    /// that stores photons). `history` counts the receivers and casters on the path before it.
    #[inline]
    pub(super) fn of_caustic_map(history: PathHistory) -> Self {
        Self::of_found_light(PathHistory { receivers: history.receivers + 1, casters_since_receiver: 1 })
    }
}

/// Light of one camera ray, divided into the groups of [`LightGroup`], as contributions to the
/// pixel \[W/(m² sr)].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GroupedLight {
    /// True if light is added; if false, [`GroupedLight::add`] does nothing.
    pub is_wanted: bool,
    sums: [Rgb; LightGroup::ALL.len()],
}

impl GroupedLight {
    /// Returns an accumulator whose light is 0 in all groups. If `is_wanted` is false,
    /// [`GroupedLight::add`] does nothing, so the light stays 0.
    pub fn new(is_wanted: bool) -> Self {
        Self { is_wanted, ..Self::default() }
    }

    /// Adds `light` to the sum of `group`.
    #[inline]
    pub fn add(&mut self, group: LightGroup, light: Rgb) {
        if self.is_wanted {
            self.sums[group as usize] += light;
        }
    }

    /// Multiplies the light of each group by `factor`, channel by channel.
    pub fn scale(&mut self, factor: Rgb) {
        self.sums.iter_mut().for_each(|sum| *sum *= factor);
    }

    /// Returns the light of each group in the order of [`LightGroup::ALL`], and resets it to 0.
    pub fn take_sums(&mut self) -> [Rgb; LightGroup::ALL.len()] {
        std::mem::take(&mut self.sums)
    }
}
