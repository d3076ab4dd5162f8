//! Effects of light that the user forces on or off, whatever the plan decides.

use crate::scene::{Effect, Effects};
use std::str::FromStr;

/// Effects of light that the user forces on or off. The plan decides about all other effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EffectOverrides {
    forced_on: Effects,
    forced_off: Effects,
}

impl EffectOverrides {
    /// Leaves the decision about every effect to the plan: none is forced on or off.
    pub const NO_OVERRIDES: Self = Self { forced_on: Effects::NONE, forced_off: Effects::NONE };
    /// Forces all effects on.
    pub const ALL_FORCED_ON: Self = Self { forced_on: Effects::ALL, forced_off: Effects::NONE };
    /// Forces all effects off. The picture then shows only direct light without shadows, from the
    /// center of each light.
    pub const ALL_FORCED_OFF: Self = Self { forced_on: Effects::NONE, forced_off: Effects::ALL };

    /// Returns the overrides with `effect` forced on.
    #[must_use]
    pub fn with_forced_on(self, effect: Effect) -> Self {
        Self { forced_on: self.forced_on.with_effect(effect), forced_off: self.forced_off.without_effect(effect) }
    }

    /// Returns the overrides with `effect` forced off.
    #[must_use]
    pub fn with_forced_off(self, effect: Effect) -> Self {
        Self { forced_on: self.forced_on.without_effect(effect), forced_off: self.forced_off.with_effect(effect) }
    }

    /// Returns true if `effect` is forced on, and false if it is forced off; `None` if the plan
    /// decides.
    #[must_use]
    pub fn effect_override(self, effect: Effect) -> Option<bool> {
        if self.forced_on.has(effect) {
            Some(true)
        } else if self.forced_off.has(effect) {
            Some(false)
        } else {
            None
        }
    }
}

/// Error: a word in the text form of [`EffectOverrides`] is unknown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{word}` is no effect override: write auto, all, none, or effects with a sign such as +caustics or -shadows, \
     separated by commas; effects are {}",
    effect_names()
)]
pub struct UnknownOverrideError {
    /// The unknown word.
    pub word: String,
}

/// Returns the names of all effects, separated by commas.
fn effect_names() -> String {
    Effect::ALL.map(Effect::name).join(", ")
}

impl FromStr for EffectOverrides {
    type Err = UnknownOverrideError;

    /// Parses a list of `auto`, `all`, `none`, `+effect` and `-effect`, separated by commas, such
    /// as `none,+shadows`.
    ///
    /// If words contradict each other, the later one counts.
    fn from_str(text: &str) -> Result<Self, UnknownOverrideError> {
        let mut overrides = Self::NO_OVERRIDES;
        for word in text.split(',').map(str::trim) {
            let unknown = || UnknownOverrideError { word: word.to_owned() };
            let named = |name: &str| name.parse::<Effect>().map_err(|_| unknown());
            overrides = match (word, word.strip_prefix('+'), word.strip_prefix('-')) {
                ("auto", ..) => Self::NO_OVERRIDES,
                ("all", ..) => Self::ALL_FORCED_ON,
                ("none", ..) => Self::ALL_FORCED_OFF,
                (_, Some(name), _) => overrides.with_forced_on(named(name)?),
                (_, _, Some(name)) => overrides.with_forced_off(named(name)?),
                _ => return Err(unknown()),
            };
        }
        Ok(overrides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_effect_overrides_win() {
        let read = |text: &str| text.parse::<EffectOverrides>().unwrap();
        assert_eq!(read("all"), EffectOverrides::ALL_FORCED_ON);
        let overrides = read("none, +caustics,-shadows ,+shadows");
        assert_eq!(overrides.effect_override(Effect::Caustics), Some(true));
        assert_eq!(overrides.effect_override(Effect::Shadows), Some(true));
        assert_eq!(overrides.effect_override(Effect::Interiors), Some(false));
        assert_eq!(read("-caustics").effect_override(Effect::Shadows), None);
        assert_eq!(read("-casters"), read("-specular"), "the former name is an alias");
    }

    #[test]
    fn unknown_effect_overrides_are_errors() {
        for bad in ["", "caustics", "+dof", "all,", "-"] {
            let error = bad.parse::<EffectOverrides>().unwrap_err().to_string();
            assert!(error.contains("+caustics") && error.contains("caustic-bounces"), "{error}");
        }
    }
}
