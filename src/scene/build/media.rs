//! Conversion of media to scene coordinates. A medium moves with the body that it fills.

use super::object::SceneObject;
use crate::math::Motion;
use crate::medium::Medium;
use crate::scene::Material;
use crate::scene::animation::{Animation, MID_SHUTTER, medium_at_time};
use glam::{DAffine3, DVec3};

/// Returns `media` in coordinates relative to `origin`, at mid-shutter. Adds moving media to
/// `animation`.
///
/// A density grid moves with the body that its medium fills. If a medium fills several bodies, its
/// grid moves with the first one; if one of the bodies rests, the grid rests.
pub(super) fn place_media(
    media: &[Medium],
    objects: &[SceneObject],
    materials: &[Material],
    origin: DVec3,
    animation: &mut Animation,
) -> Vec<Medium> {
    let recenter = DAffine3::from_translation(-origin);
    let place = |(index, medium): (usize, &Medium)| {
        let placed = medium.translated(-origin);
        let Some(motion) = motion_of_medium(index as u32, medium, objects, materials) else { return placed };
        let motion = motion.followed_by_map(recenter);
        let at_middle = medium_at_time(&placed, &motion, MID_SHUTTER).unwrap_or_else(|| placed.clone());
        animation.media.push((index, placed, motion));
        at_middle
    };
    media.iter().enumerate().map(place).collect()
}

/// Returns the motion of the first body that medium `index` fills. Returns `None` if one of the
/// bodies that it fills rests, if there are none, or if the medium is homogeneous.
fn motion_of_medium<'a>(
    index: u32,
    medium: &Medium,
    objects: &'a [SceneObject],
    materials: &[Material],
) -> Option<&'a Motion> {
    if medium.is_homogeneous() {
        return None;
    }
    let fills = |object: &&SceneObject| {
        let body = materials.get(object.material as usize).and_then(Material::enclosed_body);
        body.is_some_and(|body| body.medium == Some(index))
    };
    let motions: Option<Vec<&Motion>> = objects.iter().filter(fills).map(|object| object.motion.as_ref()).collect();
    motions?.first().copied()
}
