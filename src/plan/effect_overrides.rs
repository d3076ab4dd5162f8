//! What a user wants of the effects, whatever the scene calls for.

use super::{Effect, Effects};
use std::str::FromStr;

/// Effects to force on or off; all others follow the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EffectOverrides {
    on: Effects,
    off: Effects,
}

impl EffectOverrides {
    /// As the scene calls for.
    pub const PLANNED: Self = Self { on: Effects::NONE, off: Effects::NONE };
    /// Everything, needed or not.
    pub const ALL: Self = Self { on: Effects::ALL, off: Effects::NONE };
    /// Nothing but light that comes straight from the middle of each light.
    pub const NONE: Self = Self { on: Effects::NONE, off: Effects::ALL };

    /// These, and `effect` forced on.
    #[must_use]
    pub fn with(self, effect: Effect) -> Self {
        Self { on: self.on.with(effect), off: self.off.without(effect) }
    }

    /// These, and `effect` forced off.
    #[must_use]
    pub fn without(self, effect: Effect) -> Self {
        Self { on: self.on.without(effect), off: self.off.with(effect) }
    }

    /// What is wished of `effect`, if anything.
    #[must_use]
    pub fn of(self, effect: Effect) -> Option<bool> {
        if self.on.has(effect) {
            Some(true)
        } else if self.off.has(effect) {
            Some(false)
        } else {
            None
        }
    }
}

/// A word that names no effect.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{word}` is no wish: write auto, all, none, or effects with a sign such as +caustics or -shadows, divided by commas; effects are {}",
    names()
)]
pub struct UnknownOverride {
    /// The word.
    pub word: String,
}

fn names() -> String {
    Effect::ALL.map(Effect::name).join(", ")
}

impl FromStr for EffectOverrides {
    type Err = UnknownOverride;

    /// Reads `auto`, `all`, `none`, `+effect` and `-effect`, divided by commas; later words win.
    fn from_str(text: &str) -> Result<Self, UnknownOverride> {
        let mut wishes = Self::PLANNED;
        for word in text.split(',').map(str::trim) {
            let unknown = || UnknownOverride { word: word.to_owned() };
            let named = |name: &str| Effect::ALL.into_iter().find(|e| e.name() == name).ok_or_else(unknown);
            wishes = match (word, word.strip_prefix('+'), word.strip_prefix('-')) {
                ("auto", ..) => Self::PLANNED,
                ("all", ..) => Self::ALL,
                ("none", ..) => Self::NONE,
                (_, Some(name), _) => wishes.with(named(name)?),
                (_, _, Some(name)) => wishes.without(named(name)?),
                _ => return Err(unknown()),
            };
        }
        Ok(wishes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_words_win() {
        let read = |text: &str| text.parse::<EffectOverrides>().unwrap();
        assert_eq!(read("all"), EffectOverrides::ALL);
        let wishes = read("none, +caustics,-shadows ,+shadows");
        assert_eq!(wishes.of(Effect::Caustics), Some(true));
        assert_eq!(wishes.of(Effect::Shadows), Some(true));
        assert_eq!(wishes.of(Effect::Interiors), Some(false));
        assert_eq!(read("-caustics").of(Effect::Shadows), None);
    }

    #[test]
    fn what_names_no_effect_is_refused() {
        for bad in ["", "caustics", "+dof", "all,", "-"] {
            let error = bad.parse::<EffectOverrides>().unwrap_err().to_string();
            assert!(error.contains("+caustics") && error.contains("caustic-bounces"), "{error}");
        }
    }
}
