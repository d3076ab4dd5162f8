//! Decides which effects of light a render simulates, with reasons.

use super::{EffectOverrides, SceneFeatures};
use crate::scene::{CASTER_DESCRIPTION, Effect, Effects, Scene};
use std::fmt;

/// Reason for the decision whether a render simulates an effect of light, such as shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectReason {
    /// Objects need the effect. Holds their number, and words that tell what kind of objects they
    /// are.
    Objects(usize, &'static str),
    /// Lights need the effect. Holds their number, and words that tell what kind of lights they
    /// are.
    Lights(usize, &'static str),
    /// The scene has an environment light.
    EnvironmentLight,
    /// Objects may block light on its way from a light to other objects or to parts of themselves.
    MayOcclude,
    /// The algorithm cannot simulate the effect.
    UnsupportedByAlgorithm,
    /// No light emits any power. If the effect is [`Effect::Interreflection`], no medium emits
    /// either.
    NoLight,
    /// No object is a caustic caster, such as a mirror or glass: see
    /// [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
    NoCaster,
    /// No light reaches a caustic caster, such as a mirror or glass, on a straight path.
    NoLitCaster,
    /// No surface and no medium of the scene stores photons.
    NoReceiver,
    /// All surfaces that store photons are black, and no medium scatters.
    BlackReceivers,
    /// The scene is one flat object, see [`SceneFeatures::is_one_flat_object`].
    OneFlatObject,
    /// All lights with power are delta lights, such as point lights.
    NoSoftLight,
    /// The scene has no environment light.
    NoEnvironmentLight,
    /// The scene has no object with an interior that light enters.
    NoBody,
    /// The camera has a lens, so objects out of focus are blurred.
    Lens,
    /// The camera has no lens.
    NoLens,
    /// An object or the camera moves while the shutter is open.
    Moving,
    /// No object moves while the shutter is open, and neither does the camera.
    NothingMoves,
    /// No object has a texture.
    NoTexture,
    /// No object has a bump or normal map.
    NoBump,
    /// Media need the effect. Holds the number of media that scatter, absorb or emit.
    Media(usize),
    /// No medium of the scene scatters, absorbs or emits.
    NoMedium,
    /// A medium fills the space outside all objects.
    AmbientMedium,
    /// No glass is dispersive.
    NoDispersion,
    /// The effect has no consequence without another effect, which the scene does not need. Holds
    /// that other effect.
    RequiredEffectUnneeded(Effect),
}

impl fmt::Display for EffectReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |f: &mut fmt::Formatter<'_>, n: usize, what: &str, rest: &str| {
            write!(f, "{n} {what}{} {rest}", if n == 1 { "" } else { "s" })
        };
        match self {
            Self::Objects(n, what) => counted(f, *n, "object", what),
            Self::Lights(n, what) => counted(f, *n, "light", what),
            Self::EnvironmentLight => f.write_str("the scene has an environment light"),
            Self::MayOcclude => f.write_str("objects may occlude each other"),
            Self::UnsupportedByAlgorithm => f.write_str("the algorithm does not simulate it"),
            Self::NoLight => f.write_str("no light has power"),
            Self::NoCaster => write!(f, "the scene has no casters: {CASTER_DESCRIPTION}"),
            Self::NoLitCaster => write!(f, "no light reaches a caster directly: {CASTER_DESCRIPTION}"),
            Self::NoReceiver => f.write_str("no surface or medium stores photons"),
            Self::BlackReceivers => f.write_str("all surfaces that store photons absorb all light"),
            Self::OneFlatObject => f.write_str("the scene is one flat object, and no light lies in its plane"),
            Self::NoSoftLight => f.write_str("all lights are points or directional"),
            Self::NoEnvironmentLight => f.write_str("the scene has no environment light"),
            Self::NoBody => f.write_str("light enters no object"),
            Self::Lens => f.write_str("the camera has a lens"),
            Self::NoLens => f.write_str("the camera has no lens"),
            Self::Moving => f.write_str("an object or the camera moves while the shutter is open"),
            Self::NothingMoves => f.write_str("nothing moves while the shutter is open"),
            Self::NoTexture => f.write_str("no object has a texture"),
            Self::NoBump => f.write_str("no object has a bump or normal map"),
            Self::Media(1) => f.write_str("1 medium scatters, absorbs or emits"),
            Self::Media(n) => write!(f, "{n} media scatter, absorb or emit"),
            Self::NoMedium => f.write_str("the scene has no media"),
            Self::AmbientMedium => f.write_str("a medium fills the space between objects"),
            Self::NoDispersion => f.write_str("no glass is dispersive"),
            Self::RequiredEffectUnneeded(effect) => write!(f, "it needs {effect}, which adds nothing here"),
        }
    }
}

/// Decision of a plan: whether a render simulates one effect of light, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffectDecision {
    /// Effect of light to which the decision applies.
    pub effect: Effect,
    /// True if the scene needs the effect and the algorithm can simulate it.
    pub is_needed: bool,
    /// Reason why `is_needed` is true or false.
    pub reason: EffectReason,
    /// True if the render simulates the effect. It equals `is_needed` unless the user forces the
    /// effect on or off. An effect that the algorithm does not support is never simulated.
    pub is_simulated: bool,
}

impl EffectDecision {
    /// True if the user forced the effect on although the scene does not need it, or off although
    /// it does.
    #[must_use]
    pub fn is_forced_against_need(&self) -> bool {
        self.is_simulated != self.is_needed
    }
}

/// Plan of a render: which effects of light it simulates, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Features of the scene.
    pub features: SceneFeatures,
    /// One decision per effect of light, in the order of [`Effect::ALL`].
    pub decisions: Vec<EffectDecision>,
}

impl Plan {
    /// Decides which effects the render of `scene` simulates, by an algorithm that supports the
    /// effects `supported`.
    ///
    /// `overrides` are effects that the user turned on or off.
    #[must_use]
    pub fn new(scene: &Scene, supported: Effects, overrides: EffectOverrides) -> Self {
        let features = SceneFeatures::from_scene(scene);
        let mut needed = Effects::NONE;
        let decide = |effect| {
            let reason = match decide_effect(&features, effect, needed) {
                _ if !supported.has(effect) => Err(EffectReason::UnsupportedByAlgorithm),
                reason => reason,
            };
            if reason.is_ok() {
                needed = needed.with_effect(effect);
            }
            let is_needed = reason.is_ok();
            let is_simulated = supported.has(effect) && overrides.effect_override(effect).unwrap_or(is_needed);
            let reason = reason.unwrap_or_else(|why| why);
            EffectDecision { effect, is_needed, reason, is_simulated }
        };
        let decisions = Effect::ALL.map(decide).to_vec();
        Self { features, decisions }
    }

    /// Returns the effects that the scene needs and that the render simulates. It leaves out
    /// effects that the user forces on without need.
    #[must_use]
    pub fn needed_and_simulated_effects(&self) -> Effects {
        self.decisions
            .iter()
            .filter(|d| d.is_simulated && d.is_needed)
            .fold(Effects::NONE, |on, d| on.with_effect(d.effect))
    }

    /// Returns the effects that the render simulates.
    #[must_use]
    pub fn simulated_effects(&self) -> Effects {
        self.decisions.iter().filter(|d| d.is_simulated).fold(Effects::NONE, |on, d| on.with_effect(d.effect))
    }
}

/// Decides whether a scene with the given `features` needs `effect`. Returns `Ok` with the reason
/// if the scene needs the effect, and `Err` with the reason if not.
///
/// `before` holds the needed effects that precede `effect` in [`Effect::ALL`].
fn decide_effect(features: &SceneFeatures, effect: Effect, before: Effects) -> Result<EffectReason, EffectReason> {
    let need = |condition: bool, otherwise: EffectReason| if condition { Ok(()) } else { Err(otherwise) };
    let any = |n: usize, otherwise: EffectReason| need(n > 0, otherwise);
    let requires = |other: Effect| {
        assert!((other as u16) < effect as u16, "{effect:?} is decided before {other:?}");
        need(before.has(other), EffectReason::RequiredEffectUnneeded(other))
    };
    // Scattering media store photons, so count them as receivers.
    let receivers = features.receivers + features.scattering_media;
    let scattering = features.scattering_receivers + features.scattering_media;
    match effect {
        Effect::Specular => {
            any(features.casters, EffectReason::NoCaster)?;
            Ok(EffectReason::Objects(features.casters, "that can cast caustics"))
        }
        Effect::Caustics => {
            any(features.lights, EffectReason::NoLight)?;
            any(features.casters, EffectReason::NoCaster)?;
            any(features.lit_casters, EffectReason::NoLitCaster)?;
            any(receivers, EffectReason::NoReceiver)?;
            Ok(EffectReason::Objects(features.lit_casters, "may cast caustics"))
        }
        Effect::CausticBounces => {
            requires(Effect::Caustics)?;
            any(scattering, EffectReason::BlackReceivers)?;
            Ok(EffectReason::Objects(scattering, "may reflect caustics"))
        }
        Effect::Interreflection => {
            // With this effect, camera paths sample distances in a scattering medium. Without it,
            // they pass the medium with its transmittance. So the effect changes the noise of a
            // background behind the medium, and must not be omitted.
            let hazy = features.has_background && features.scattering_media > 0;
            need(features.lights + features.emitting_media > 0 || hazy, EffectReason::NoLight)?;
            any(receivers, EffectReason::NoReceiver)?;
            any(scattering, EffectReason::BlackReceivers)?;
            // If the scene has a soft light, `is_one_flat_object` is false, because continued paths
            // may hit that light.
            need(!features.is_one_flat_object, EffectReason::OneFlatObject)?;
            Ok(EffectReason::Objects(scattering, "may light other objects"))
        }
        Effect::Gathering => {
            requires(Effect::Interreflection)?;
            Ok(EffectReason::Objects(scattering, "may light other objects"))
        }
        Effect::Shadows => {
            any(features.lights, EffectReason::NoLight)?;
            need(!features.is_one_flat_object, EffectReason::OneFlatObject)?;
            Ok(EffectReason::MayOcclude)
        }
        Effect::SoftShadows => {
            any(features.lights, EffectReason::NoLight)?;
            any(features.soft_lights, EffectReason::NoSoftLight)?;
            Ok(EffectReason::Lights(features.soft_lights, "with an extent"))
        }
        Effect::Environment => {
            need(features.has_environment_light, EffectReason::NoEnvironmentLight)?;
            Ok(EffectReason::EnvironmentLight)
        }
        Effect::Interiors => {
            if features.has_ambient_medium {
                return Ok(EffectReason::AmbientMedium);
            }
            any(features.bodies, EffectReason::NoBody)?;
            Ok(EffectReason::Objects(features.bodies, "that light enters"))
        }
        Effect::Lens => {
            need(features.has_lens, EffectReason::NoLens)?;
            Ok(EffectReason::Lens)
        }
        Effect::Motion => {
            need(features.has_motion, EffectReason::NothingMoves)?;
            Ok(EffectReason::Moving)
        }
        Effect::Textures => {
            any(features.textured_objects, EffectReason::NoTexture)?;
            Ok(EffectReason::Objects(features.textured_objects, "with textures"))
        }
        Effect::Bump => {
            any(features.bump_mapped_objects, EffectReason::NoBump)?;
            Ok(EffectReason::Objects(features.bump_mapped_objects, "with bump or normal maps"))
        }
        Effect::Media => {
            any(features.media, EffectReason::NoMedium)?;
            Ok(EffectReason::Media(features.media))
        }
        Effect::Dispersion => {
            any(features.dispersive_objects, EffectReason::NoDispersion)?;
            Ok(EffectReason::Objects(features.dispersive_objects, "of dispersive glass"))
        }
    }
}
