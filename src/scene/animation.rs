//! Animation: the moving parts of a scene, and copies of the scene at a given time.
//!
//! A pass renders one or more instants of the shutter interval, each with its own copy of the
//! scene, so rays carry no time. Only the bounding volume hierarchy over moving shapes is rebuilt
//! for each copy.

use super::build::{derive_scene_data, mean_emission_lights};
use super::delta_light::{mit_6837_area_light, place_delta_light};
use super::geometry::HitPrimitive;
use super::{Hit, LightStrength, Scene, UnscaledDeltaLight};
use crate::camera::Camera;
use crate::light::{EmissionTexture, LightSurface};
use crate::math::{Motion, Transform};
use crate::medium::Medium;
use crate::shape::{Plane, Shape, TextureMapping, TextureMappingKind};
use glam::DVec3;
use std::sync::Arc;

/// Time at which moving parts are placed when a scene is built: the middle of the shutter interval,
/// which runs from 0 to 1.
pub(super) const MID_SHUTTER: f64 = 0.5;

/// The moving shapes, planes, lights, camera, texture mappings and media of a scene, each with its
/// motion.
///
/// Each part is stored as it is before its motion is applied. The motion at time t maps the stored
/// part to its place at t, in coordinates relative to [`Scene::origin`]. Media are an exception:
/// they are stored in their place at time 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Animation {
    /// Moving shapes, which the scene lists after the shapes at rest.
    pub shapes: Vec<(Shape, Motion)>,
    /// Moving planes, which the scene lists after the planes at rest.
    pub planes: Vec<(Plane, Motion)>,
    /// Moving delta lights: index in [`Scene::lights`], light before its motion is applied,
    /// strength and motion.
    pub lights: Vec<(usize, UnscaledDeltaLight, LightStrength, Motion)>,
    /// The camera before its motion is applied, and the motion. The motion rotates and scales about
    /// the camera's position. `None` if the camera rests.
    pub camera: Option<(Camera, Motion)>,
    /// Moving texture mappings: index in the scene's list of texture mappings, kind and motion.
    pub mappings: Vec<(usize, TextureMappingKind, Motion)>,
    /// Media with a moving density grid: index in [`Scene::media`], the medium at time 0 (shutter
    /// opens), and the motion of the dielectric body that the medium fills.
    pub media: Vec<(usize, Medium, Motion)>,
}

impl Animation {
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty() && self.planes.is_empty() && self.lights.is_empty() && self.camera.is_none()
    }
}

/// The transform of `motion` at `time`; `None` if the transform is singular or not finite.
fn motion_transform_at_time(motion: &Motion, time: f64) -> Option<Transform> {
    Transform::new(motion.at_time(time)).ok()
}

/// `shape` moved by `motion` at `time`; `None` if the transform is singular.
pub(super) fn shape_at_time(shape: &Shape, motion: &Motion, time: f64) -> Option<Shape> {
    shape.transformed(&motion_transform_at_time(motion, time)?)
}

/// `plane` moved by `motion` at `time`; `None` if the transform is singular.
pub(super) fn plane_at_time(plane: &Plane, motion: &Motion, time: f64) -> Option<Plane> {
    Some(plane.transformed(&motion_transform_at_time(motion, time)?))
}

/// The delta light `kind` moved by `motion` at `time`; `None` if the transform is singular.
pub(super) fn delta_light_at_time(kind: &UnscaledDeltaLight, motion: &Motion, time: f64) -> Option<UnscaledDeltaLight> {
    Some(kind.transformed(&motion_transform_at_time(motion, time)?))
}

/// `camera` moved by `motion` at `time`; `None` if the transform is singular.
pub(super) fn camera_at_time(camera: &Camera, motion: &Motion, time: f64) -> Option<Camera> {
    Some(camera.transformed(&motion_transform_at_time(motion, time)?))
}

/// Returns the motion of the object at `hit` of `scene`; `None` if the object rests.
pub(super) fn motion_of_hit<'a>(scene: &'a Scene, hit: &Hit) -> Option<&'a Motion> {
    let animation = scene.animation.as_deref()?;
    let geometry = &scene.geometry;
    match hit.primitive {
        HitPrimitive::Triangle(..) => None,
        HitPrimitive::Shape(i, _) => {
            let moving = i.checked_sub(geometry.shapes.first_moving_index())?;
            animation.shapes.get(moving as usize).map(|(_, motion)| motion)
        }
        HitPrimitive::Plane(i) => {
            let first_moving = geometry.planes.len() - animation.planes.len();
            animation.planes.get((i as usize).checked_sub(first_moving)?).map(|(_, motion)| motion)
        }
    }
}

/// The texture mapping of `kind` at `time`, for an object that moves by `motion`; `None` if the
/// transform is singular.
pub(super) fn texture_mapping_at_time(kind: TextureMappingKind, motion: &Motion, time: f64) -> Option<TextureMapping> {
    Some(TextureMapping::new(kind, motion_transform_at_time(motion, time)?))
}

/// Copy of `medium` with its density grid moved to the grid's place at `time`; `None` if a
/// transform is singular.
///
/// The grid of the argument `medium` must stand at its place for time 0, when the shutter opens.
/// `motion` moves the body that the medium fills.
pub(super) fn medium_at_time(medium: &Medium, motion: &Motion, time: f64) -> Option<Medium> {
    let opening = motion_transform_at_time(motion, 0.0)?;
    medium.with_transformed_grid(motion.at_time(time) * *opening.inverse())
}

/// Converts the strength [`LightStrength::Mit6837Color`] of a moving delta light to physical units.
/// Other strengths are returned unchanged.
///
/// The conversion depends on the light's distance from the origin, because a `Mit6837Color` states
/// how bright a surface at the origin looks. The light's position at mid-shutter is used, and the
/// light keeps the result while it moves.
pub(super) fn physical_light_strength_at_mid_shutter(
    kind: &UnscaledDeltaLight,
    strength: LightStrength,
    motion: &Motion,
) -> LightStrength {
    let (LightStrength::Mit6837Color(_), Some(placed)) = (strength, delta_light_at_time(kind, motion, MID_SHUTTER))
    else {
        return strength;
    };
    place_delta_light(&placed, strength, DVec3::ZERO).0.nominal_strength().map_or(strength, LightStrength::Physical)
}

/// Returns a copy of `scene` with all moving parts placed at `time`, from 0 (shutter opens) to 1
/// (shutter closes).
///
/// A part stays at its mid-shutter position if its transform is singular at `time`.
pub(super) fn scene_at_time(scene: &Scene, time: f64) -> Scene {
    let mut moved = scene.clone();
    let Some(animation) = &scene.animation else { return moved };
    for (i, kind, motion) in &animation.mappings {
        if let Some(placed) = texture_mapping_at_time(*kind, motion, time) {
            moved.mappings[*i] = placed;
        }
    }
    for (i, (shape, motion)) in animation.shapes.iter().enumerate() {
        if let Some(placed) = shape_at_time(shape, motion, time) {
            replace_moving_shape(&mut moved, i, placed);
        }
    }
    for (i, medium, motion) in &animation.media {
        if let Some(placed) = medium_at_time(medium, motion, time) {
            moved.media[*i] = placed;
        }
    }
    let first_plane = moved.geometry.planes.len() - animation.planes.len();
    for (i, (plane, motion)) in (first_plane..).zip(&animation.planes) {
        if let Some(placed) = plane_at_time(plane, motion, time) {
            moved.geometry.planes[i] = placed;
        }
    }
    for (i, kind, strength, motion) in &animation.lights {
        if let Some(placed) = delta_light_at_time(kind, motion, time) {
            (moved.lights[*i], moved.mit_6837_lights[*i]) = place_delta_light(&placed, *strength, DVec3::ZERO);
        }
    }
    if let Some((camera, motion)) = &animation.camera
        && let Some(placed) = camera_at_time(camera, motion, time)
    {
        moved.camera = placed;
    }
    moved.mean_emission_lights = mean_emission_lights(&moved.lights);
    moved.geometry.rebuild_moving_hierarchy();
    moved.derived = derive_scene_data(&moved);
    moved
}

/// Replaces moving shape `i`, counted from the first moving shape, by `shape`. If the shape emits
/// light, its area light is replaced too.
fn replace_moving_shape(scene: &mut Scene, i: usize, shape: Shape) {
    let object = scene.geometry.objects[scene.geometry.shapes.first_moving_index() as usize + i];
    if let Some(light) = object.light {
        let light = light as usize;
        if let Some(area) = scene.lights[light].as_area_light_mut() {
            area.surface = LightSurface::Shape(shape.clone());
            let mapping = scene.mappings[object.mapping as usize];
            let remapped = |texture: &Arc<EmissionTexture>| {
                Arc::new(EmissionTexture { mapping, ..EmissionTexture::clone(texture) })
            };
            area.texture = area.texture.as_ref().map(remapped);
        }
        scene.mit_6837_lights[light] = mit_6837_area_light(&scene.lights[light]);
    }
    scene.geometry.shapes.replace_moving(i, shape);
}
