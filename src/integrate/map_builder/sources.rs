//! Photon sources of the photon map builder.

use crate::integrate::policy::PhotonMapRequest;
use crate::integrate::settings::Settings;
use crate::photon::{PhotonSource, StoreMask};
use crate::scene::{Effect, Effects, Scene};

/// Photon sources of a pass, one for each set of photon paths.
#[derive(Debug)]
pub(super) struct PhotonSources<'a> {
    /// Source of the unaimed photon paths, which start in all directions; `None` if passes trace no
    /// such paths.
    pub unaimed: Option<PhotonSource<'a>>,
    /// Source of the photon paths aimed at casters, such as mirrors and glass; `None` if passes
    /// trace no such paths. The source emits in all directions if no light reaches a caster.
    pub aimed: Option<PhotonSource<'a>>,
}

impl<'a> PhotonSources<'a> {
    /// Makes the sources of the photon paths that `request` names and for which `settings` give a
    /// number of paths, restricted to the light that `effects` simulate.
    pub fn new(scene: &'a Scene, settings: &Settings, request: PhotonMapRequest, effects: Effects) -> Self {
        let source = |mask: StoreMask, paths: u32, new_source: &dyn Fn() -> Option<PhotonSource<'a>>| {
            if paths == 0 || mask == StoreMask::NONE {
                return None;
            }
            restrict_to_effects(new_source()?, effects)
        };
        let unaimed = || PhotonSource::emitting_in_all_directions(scene);
        // If a user forces the effect of caustics on in a scene without lit casters, aimed paths
        // start in all directions.
        let aimed = || PhotonSource::aimed_at_casters(scene).or_else(unaimed);
        Self {
            unaimed: source(request.unaimed, settings.unaimed_paths, &unaimed),
            aimed: source(request.aimed, settings.aimed_paths, &aimed),
        }
    }

    /// Returns the sources of the photon paths that `request` names, restricted to the light that
    /// `effects` simulate.
    pub fn restricted_to(&self, request: PhotonMapRequest, effects: Effects) -> Self {
        let keep = |source: &Option<PhotonSource<'a>>, mask: StoreMask| {
            let source = source.clone().filter(|_| mask != StoreMask::NONE)?;
            restrict_to_effects(source, effects)
        };
        Self { unaimed: keep(&self.unaimed, request.unaimed), aimed: keep(&self.aimed, request.aimed) }
    }

    /// Returns the sources for `scene`, which must be the same scene at another shutter time.
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PhotonSources<'b> {
        let placed = |source: &Option<PhotonSource<'a>>| source.as_ref().map(|source| source.for_scene_at_time(scene));
        PhotonSources { unaimed: placed(&self.unaimed), aimed: placed(&self.aimed) }
    }

    /// True if there is no source, so that no photon paths are traced.
    pub fn is_empty(&self) -> bool {
        self.aimed.is_none() && self.unaimed.is_none()
    }
}

/// Returns `source` restricted to the light that `effects` simulate; `None` if no light is left.
fn restrict_to_effects<'a>(source: PhotonSource<'a>, effects: Effects) -> Option<PhotonSource<'a>> {
    let source = source.with_effects(effects);
    if effects.has(Effect::Environment) { Some(source) } else { source.without_environment_light() }
}
