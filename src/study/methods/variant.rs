//! Methods to compare.

use crate::integrate::{Algorithm, Settings};
use crate::plan::{Effect, EffectOverrides, Plan};
use crate::scene::Scene;

/// An algorithm with its settings.
#[derive(Clone, Debug)]
pub struct MethodVariant {
    /// Unique label, such as `sppm` or `sppm --gather-k 20`.
    pub label: String,
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Settings, with the first seed.
    pub settings: Settings,
    /// Flags of `caustica render` for the algorithm and its settings, without `--seed` and
    /// `--passes`.
    pub flags: Vec<String>,
}

/// Reason why variants cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodVariantError {
    /// The list is empty.
    #[error("there is no method to study")]
    None,
    /// Two variants have one label.
    #[error("`{0}` is given twice")]
    Twice(String),
    /// One seed cannot separate noise from bias.
    #[error("one seed cannot separate noise from bias: use at least two")]
    OneSeed,
}

pub(super) fn check_variants(variants: &[MethodVariant], seeds: u32) -> Result<(), MethodVariantError> {
    if variants.is_empty() {
        return Err(MethodVariantError::None);
    }
    if seeds < 2 {
        return Err(MethodVariantError::OneSeed);
    }
    let twice = variants.iter().enumerate().find(|(i, v)| variants[..*i].iter().any(|before| before.label == v.label));
    twice.map_or(Ok(()), |(_, v)| Err(MethodVariantError::Twice(v.label.clone())))
}

/// Global-illumination methods that differ for a scene. Photon methods need a light and a receiver;
/// `hybrid` equals `path` without caustics.
#[must_use]
pub fn applicable_methods(scene: &Scene, overrides: EffectOverrides) -> Vec<Algorithm> {
    let plan = Plan::new(scene, Algorithm::Hybrid.simulates(), overrides);
    let facts = &plan.features;
    let photons = facts.lights > 0 && facts.receivers + facts.scattering_media > 0;
    let applies = |algorithm: &Algorithm| match algorithm {
        Algorithm::Path => true,
        Algorithm::Hybrid => photons && plan.simulated_effects().has(Effect::Caustics),
        _ => photons,
    };
    let all = [Algorithm::Path, Algorithm::Pm, Algorithm::Ppm, Algorithm::Sppm, Algorithm::Hybrid];
    all.into_iter().filter(applies).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::{glass_on_floor, matt};

    fn variant(label: &str) -> MethodVariant {
        let settings = Settings::default();
        MethodVariant { label: label.to_owned(), algorithm: Algorithm::Path, settings, flags: Vec::new() }
    }

    #[test]
    fn labels_and_seeds_are_checked() {
        assert_eq!(check_variants(&[variant("a"), variant("b")], 2), Ok(()));
        assert_eq!(
            check_variants(&[variant("a"), variant("b"), variant("a")], 2),
            Err(MethodVariantError::Twice("a".into()))
        );
        assert_eq!(
            (check_variants(&[], 2), check_variants(&[variant("a")], 1)),
            (Err(MethodVariantError::None), Err(MethodVariantError::OneSeed))
        );
    }

    #[test]
    fn methods_apply_where_they_differ() {
        use Algorithm::{Hybrid, Path, Pm, Ppm, Sppm};
        assert_eq!(applicable_methods(&glass_on_floor(4, 3), EffectOverrides::PLANNED), [Path, Pm, Ppm, Sppm, Hybrid]);
        assert_eq!(applicable_methods(&matt(4, 3), EffectOverrides::PLANNED), [Path, Pm, Ppm, Sppm]);
        let without = EffectOverrides::PLANNED.without(Effect::Caustics);
        assert_eq!(applicable_methods(&glass_on_floor(4, 3), without), [Path, Pm, Ppm, Sppm]);
    }
}
