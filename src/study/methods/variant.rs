//! Rendering methods that a study compares.

use crate::integrate::{Algorithm, Settings};
use crate::plan::{EffectOverrides, Plan};
use crate::scene::{Effect, Scene};

/// Rendering method that a study measures: an algorithm with its settings.
#[derive(Clone, Debug)]
pub struct MethodVariant {
    /// Unique label, such as `sppm` or `sppm --gather-k 20`.
    pub label: String,
    /// Rendering algorithm of the variant.
    pub algorithm: Algorithm,
    /// Settings of the variant. Their seed is the seed of the first picture; the other pictures use
    /// the next integers as seeds.
    pub settings: Settings,
    /// Flags of `caustica render` that select this method, without `--seed` and `--passes`.
    pub flags: Vec<String>,
}

/// Reason why a study cannot compare the given rendering methods.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodVariantError {
    /// The list of methods to compare is empty.
    #[error("there is no method to study")]
    NoMethod,
    /// Two methods have the same label.
    #[error("`{0}` is given twice")]
    DuplicateLabel(String),
    /// There are fewer than two seeds per method, so noise and bias cannot be separated.
    #[error("one seed cannot separate noise from bias: use at least two")]
    OneSeed,
}

pub(super) fn check_method_variants(variants: &[MethodVariant], seeds: u32) -> Result<(), MethodVariantError> {
    if variants.is_empty() {
        return Err(MethodVariantError::NoMethod);
    }
    if seeds < 2 {
        return Err(MethodVariantError::OneSeed);
    }
    let duplicate =
        variants.iter().enumerate().find(|(i, v)| variants[..*i].iter().any(|before| before.label == v.label));
    duplicate.map_or(Ok(()), |(_, v)| Err(MethodVariantError::DuplicateLabel(v.label.clone())))
}

/// Returns the global illumination algorithms that give different pictures of `scene`.
///
/// Photon algorithms are left out if the scene has no light, or no surface or medium that stores
/// photons. `hybrid` is also left out if neither caustics nor interreflection is simulated, because
/// `hybrid` then makes the same picture as `path`.
#[must_use]
pub fn applicable_methods(scene: &Scene, overrides: EffectOverrides) -> Vec<Algorithm> {
    let plan = Plan::new(scene, Algorithm::Hybrid.supported_effects(), overrides);
    let features = &plan.features;
    let stores_photons = features.lights > 0 && features.receivers + features.scattering_media > 0;
    let effects = plan.simulated_effects();
    let hybrid_uses_photons = effects.has(Effect::Caustics) || effects.has(Effect::Interreflection);
    // Position in the list, or `None` for an algorithm that is left out.
    let position = |algorithm: Algorithm| match algorithm {
        Algorithm::Path => Some(0),
        Algorithm::Pm => stores_photons.then_some(1),
        Algorithm::Ppm => stores_photons.then_some(2),
        Algorithm::Sppm => stores_photons.then_some(3),
        Algorithm::Hybrid => (stores_photons && hybrid_uses_photons).then_some(4),
        Algorithm::Distributed | Algorithm::Whitted | Algorithm::Raycast => None,
    };
    let mut applicable: Vec<(u8, Algorithm)> =
        Algorithm::ALL.into_iter().filter_map(|algorithm| Some((position(algorithm)?, algorithm))).collect();
    applicable.sort_by_key(|(position, _)| *position);
    applicable.into_iter().map(|(_, algorithm)| algorithm).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::{diffuse_sphere_on_floor, glass_sphere_on_floor};

    fn variant_with_label(label: &str) -> MethodVariant {
        let settings = Settings::default();
        MethodVariant { label: label.to_owned(), algorithm: Algorithm::Path, settings, flags: Vec::new() }
    }

    #[test]
    fn method_labels_and_seed_counts_are_checked() {
        assert_eq!(check_method_variants(&[variant_with_label("a"), variant_with_label("b")], 2), Ok(()));
        assert_eq!(
            check_method_variants(&[variant_with_label("a"), variant_with_label("b"), variant_with_label("a")], 2),
            Err(MethodVariantError::DuplicateLabel("a".into()))
        );
        assert_eq!(
            (check_method_variants(&[], 2), check_method_variants(&[variant_with_label("a")], 1)),
            (Err(MethodVariantError::NoMethod), Err(MethodVariantError::OneSeed))
        );
    }

    #[test]
    fn hybrid_is_left_out_if_it_uses_no_photons() {
        use Algorithm::{Hybrid, Path, Pm, Ppm, Sppm};
        let all = EffectOverrides::NO_OVERRIDES;
        let (caustics_off, interreflection_off) =
            (all.with_forced_off(Effect::Caustics), all.with_forced_off(Effect::Interreflection));
        let glass = glass_sphere_on_floor(4, 3);
        for overrides in [all, caustics_off, interreflection_off] {
            assert_eq!(applicable_methods(&glass, overrides), [Path, Pm, Ppm, Sppm, Hybrid]);
        }
        let diffuse = diffuse_sphere_on_floor(4, 3);
        assert_eq!(applicable_methods(&diffuse, all), [Path, Pm, Ppm, Sppm, Hybrid]);
        for (scene, overrides) in
            [(&diffuse, interreflection_off), (&glass, interreflection_off.with_forced_off(Effect::Caustics))]
        {
            assert_eq!(applicable_methods(scene, overrides), [Path, Pm, Ppm, Sppm]);
        }
    }
}
