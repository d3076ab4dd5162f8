//! Decisions.

use super::{Effect, EffectOverrides, Effects, SceneFeatures};
use crate::scene::Scene;
use std::fmt;

/// Why an effect is simulated, or adds nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// So many objects call for it.
    Objects(usize, &'static str),
    /// So many lights call for it.
    Lights(usize, &'static str),
    /// Light comes from all around.
    Sky,
    /// Things may stand before each other.
    Crowded,
    /// The algorithm has no notion of it.
    NotOfAlgorithm,
    /// No light has power.
    NoLight,
    /// Nothing is a caster.
    NoCaster,
    /// No light reaches a caster without a detour.
    NoLitCaster,
    /// Nothing stores photons.
    NoReceiver,
    /// All receivers absorb all light.
    BlackReceivers,
    /// All there is is one flat object.
    OneFlatObject,
    /// All lights are points, or parallel.
    NoSoftLight,
    /// No light comes from all around.
    NoSky,
    /// Light enters nothing.
    NoBody,
    /// The camera has a lens.
    Lens,
    /// The camera has none.
    NoLens,
    /// Something moves.
    Moving,
    /// Nothing does.
    NothingMoves,
    /// Nothing has a texture.
    NoTexture,
    /// Nothing has bumps.
    NoBump,
    /// So many media.
    Media(usize),
    /// Nothing is filled.
    NoMedium,
    /// A medium is wherever no body is.
    Filled,
    /// No glass parts wavelengths.
    NoDispersion,
    /// It rests on another effect, which is off.
    Without(Effect),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |f: &mut fmt::Formatter<'_>, n: usize, what: &str, rest: &str| {
            write!(f, "{n} {what}{} {rest}", if n == 1 { "" } else { "s" })
        };
        match self {
            Self::Objects(n, what) => counted(f, *n, "object", what),
            Self::Lights(n, what) => counted(f, *n, "light", what),
            Self::Sky => f.write_str("light comes from all around"),
            Self::Crowded => f.write_str("things may stand before each other"),
            Self::NotOfAlgorithm => f.write_str("the algorithm does not simulate it"),
            Self::NoLight => f.write_str("no light has power"),
            Self::NoCaster => f.write_str("nothing is a mirror, glass or smooth metal"),
            Self::NoLitCaster => f.write_str("no light reaches a mirror, glass or smooth metal without a detour"),
            Self::NoReceiver => f.write_str("nothing stores photons"),
            Self::BlackReceivers => f.write_str("whatever stores photons absorbs all light"),
            Self::OneFlatObject => f.write_str("all there is is one flat object, and no light shines along it"),
            Self::NoSoftLight => f.write_str("every light is a point, or parallel"),
            Self::NoSky => f.write_str("no light comes from all around"),
            Self::NoBody => f.write_str("light enters nothing"),
            Self::Lens => f.write_str("the camera has a lens"),
            Self::NoLens => f.write_str("the camera has no lens"),
            Self::Moving => f.write_str("something moves while the shutter is open"),
            Self::NothingMoves => f.write_str("nothing moves while the shutter is open"),
            Self::NoTexture => f.write_str("nothing has a texture"),
            Self::NoBump => f.write_str("nothing has bumps"),
            Self::Media(1) => f.write_str("1 medium scatters, absorbs or glows"),
            Self::Media(n) => write!(f, "{n} media scatter, absorb or glow"),
            Self::NoMedium => f.write_str("nothing is filled with a medium"),
            Self::Filled => f.write_str("a medium is all around"),
            Self::NoDispersion => f.write_str("no glass parts colours"),
            Self::Without(effect) => write!(f, "it rests on {effect}, which adds nothing here"),
        }
    }
}

/// What is done about an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The effect.
    pub effect: Effect,
    /// Whether the scene calls for it.
    pub called_for: bool,
    /// Why.
    pub reason: Reason,
    /// Whether it is simulated.
    pub on: bool,
}

impl Decision {
    /// Whether a wish overrules the scene.
    #[must_use]
    pub fn is_forced(&self) -> bool {
        self.on != self.called_for
    }
}

/// What is simulated, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// What the scene holds.
    pub facts: SceneFeatures,
    /// One decision for each effect, in the order of [`Effect::ALL`].
    pub decisions: Vec<Decision>,
}

impl Plan {
    /// A plan for an algorithm that can simulate `simulated`.
    #[must_use]
    pub fn new(scene: &Scene, simulated: Effects, wishes: EffectOverrides) -> Self {
        let facts = SceneFeatures::of(scene);
        let mut called_for = Effects::NONE;
        let decide = |effect| {
            let reason = match judge(&facts, effect, called_for) {
                _ if !simulated.has(effect) => Err(Reason::NotOfAlgorithm),
                reason => reason,
            };
            if reason.is_ok() {
                called_for = called_for.with(effect);
            }
            let planned = reason.is_ok();
            let on = if simulated.has(effect) { wishes.of(effect).unwrap_or(planned) } else { false };
            let reason = reason.unwrap_or_else(|why| why);
            Decision { effect, called_for: planned, reason, on }
        };
        let decisions = Effect::ALL.map(decide).to_vec();
        Self { facts, decisions }
    }

    /// The effects that are simulated and called for.
    #[must_use]
    pub fn needed(&self) -> Effects {
        self.decisions.iter().filter(|d| d.on && d.called_for).fold(Effects::NONE, |on, d| on.with(d.effect))
    }

    /// The effects that are simulated.
    #[must_use]
    pub fn effects(&self) -> Effects {
        self.decisions.iter().filter(|d| d.on).fold(Effects::NONE, |on, d| on.with(d.effect))
    }
}

/// Why `effect` is called for, or else why it adds nothing; `before` holds what is called for of the effects listed earlier.
fn judge(facts: &SceneFeatures, effect: Effect, before: Effects) -> Result<Reason, Reason> {
    let need = |there: bool, why: Reason| if there { Ok(()) } else { Err(why) };
    let any = |n: usize, why: Reason| need(n > 0, why);
    // Media that scatter light are lit, and light others.
    let receivers = facts.receivers + facts.scattering_media;
    let scattering = facts.scattering_receivers + facts.scattering_media;
    match effect {
        Effect::Specular => {
            any(facts.casters, Reason::NoCaster)?;
            Ok(Reason::Objects(facts.casters, "of mirror, glass or smooth metal"))
        }
        Effect::Caustics => {
            any(facts.lights, Reason::NoLight)?;
            any(facts.casters, Reason::NoCaster)?;
            any(facts.lit_casters, Reason::NoLitCaster)?;
            any(receivers, Reason::NoReceiver)?;
            Ok(Reason::Objects(facts.lit_casters, "may throw light on others"))
        }
        Effect::CausticBounces => {
            need(before.has(Effect::Caustics), Reason::Without(Effect::Caustics))?;
            any(scattering, Reason::BlackReceivers)?;
            Ok(Reason::Objects(scattering, "may pass caustics on"))
        }
        Effect::Interreflection => {
            // A background is seen through what scatters by the same walks that are scattered there.
            let hazy = facts.background && facts.scattering_media > 0;
            need(facts.lights + facts.glowing_media > 0 || hazy, Reason::NoLight)?;
            any(receivers, Reason::NoReceiver)?;
            any(scattering, Reason::BlackReceivers)?;
            // A walk on from a receiver is also how half of the light of soft lights is found: those are never clear of the object.
            need(!facts.one_flat_object, Reason::OneFlatObject)?;
            Ok(Reason::Objects(scattering, "may light others"))
        }
        Effect::Gathering => {
            need(before.has(Effect::Interreflection), Reason::Without(Effect::Interreflection))?;
            Ok(Reason::Objects(scattering, "may light others"))
        }
        Effect::Shadows => {
            any(facts.lights, Reason::NoLight)?;
            need(!facts.one_flat_object, Reason::OneFlatObject)?;
            Ok(Reason::Crowded)
        }
        Effect::SoftShadows => {
            any(facts.lights, Reason::NoLight)?;
            any(facts.soft_lights, Reason::NoSoftLight)?;
            Ok(Reason::Lights(facts.soft_lights, "with an extent"))
        }
        Effect::Environment => {
            need(facts.environment, Reason::NoSky)?;
            Ok(Reason::Sky)
        }
        Effect::Interiors => {
            if facts.filled {
                return Ok(Reason::Filled);
            }
            any(facts.bodies, Reason::NoBody)?;
            Ok(Reason::Objects(facts.bodies, "that light enters"))
        }
        Effect::Lens => {
            need(facts.lens, Reason::NoLens)?;
            Ok(Reason::Lens)
        }
        Effect::Motion => {
            need(facts.moving, Reason::NothingMoves)?;
            Ok(Reason::Moving)
        }
        Effect::Textures => {
            any(facts.textured, Reason::NoTexture)?;
            Ok(Reason::Objects(facts.textured, "with textures"))
        }
        Effect::Bump => {
            any(facts.bumpy, Reason::NoBump)?;
            Ok(Reason::Objects(facts.bumpy, "with bumps"))
        }
        Effect::Media => {
            any(facts.media, Reason::NoMedium)?;
            Ok(Reason::Media(facts.media))
        }
        Effect::Dispersion => {
            any(facts.dispersive, Reason::NoDispersion)?;
            Ok(Reason::Objects(facts.dispersive, "of glass that parts colours"))
        }
    }
}
