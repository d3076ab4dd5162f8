//! What moves while the shutter is open.
//!
//! All of a pass happens at one time: photons and camera rays agree on where things are, and no estimate blurs time. So a ray needs no time
//! of its own, nor the hierarchy boxes that hold a whole motion: things that move have a small hierarchy for themselves, made anew for
//! each pass.

use super::source::{course_area_light, resolve_source};
use super::wardrobe::chart_at;
use super::{LightStrength, Scene, SourceKind};
use crate::camera::Camera;
use crate::light::{EmissionTexture, Light, LightSurface};
use crate::math::{Motion, Transform};
use crate::shape::{Form, Plane, Shape};
use glam::DVec3;
use std::sync::Arc;

/// The time at which a scene stands when nobody says otherwise: half way.
pub(super) const MIDDLE: f64 = 0.5;

/// All that moves. Motions lead to the scene's own coordinates.
#[derive(Debug, Default)]
pub(super) struct Movement {
    /// The last of the scene's shapes.
    pub shapes: Vec<(Shape, Motion)>,
    /// The last of the scene's planes.
    pub planes: Vec<(Plane, Motion)>,
    /// Lights by their index.
    pub sources: Vec<(usize, SourceKind, LightStrength, Motion)>,
    /// The camera before it is moved, about its own place.
    pub camera: Option<(Camera, Motion)>,
    /// How textures lie on what moves, by the index of the chart.
    pub charts: Vec<(usize, Form, Motion)>,
}

impl Movement {
    pub fn is_none(&self) -> bool {
        self.shapes.is_empty() && self.planes.is_empty() && self.sources.is_empty() && self.camera.is_none()
    }
}

/// A shape at a time of its motion; `None` where no numbers can hold it.
pub(super) fn shape_at(shape: &Shape, motion: &Motion, time: f64) -> Option<Shape> {
    shape.transformed(&Transform::new(motion.at(time)).ok()?)
}

/// A plane at a time of its motion.
pub(super) fn plane_at(plane: &Plane, motion: &Motion, time: f64) -> Option<Plane> {
    Some(plane.transformed(&Transform::new(motion.at(time)).ok()?))
}

/// A light at a time of its motion.
pub(super) fn source_at(kind: &SourceKind, motion: &Motion, time: f64) -> Option<SourceKind> {
    Some(kind.transformed(&Transform::new(motion.at(time)).ok()?))
}

/// The strength of a light that moves: a course's colour means what it does half way, and the lamp stays as strong as it is there.
pub(super) fn constant_strength(kind: &SourceKind, strength: LightStrength, motion: &Motion) -> LightStrength {
    let (LightStrength::Course(_), Some(placed)) = (strength, source_at(kind, motion, MIDDLE)) else { return strength };
    resolve_source(&placed, strength, DVec3::ZERO).0.peak().map_or(strength, LightStrength::Physical)
}

impl Scene {
    /// Whether anything moves while the shutter is open.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.movement.is_some()
    }

    /// The scene as it stands at `time` in \[0, 1\], from where the shutter opens to where it closes. Triangles, hierarchies, textures and the sky
    /// are shared.
    #[must_use]
    pub fn at(&self, time: f64) -> Self {
        let mut scene = self.clone();
        let Some(movement) = &self.movement else { return scene };
        let (first, first_plane) =
            (scene.shapes.len() - movement.shapes.len(), scene.planes.len() - movement.planes.len());
        for (i, form, motion) in &movement.charts {
            if let Some(placed) = chart_at(*form, motion, time) {
                scene.charts[*i] = placed;
            }
        }
        for (i, (shape, motion)) in (first..).zip(&movement.shapes) {
            if let Some(placed) = shape_at(shape, motion, time) {
                scene.put(i, placed);
            }
        }
        for (i, (plane, motion)) in (first_plane..).zip(&movement.planes) {
            if let Some(placed) = plane_at(plane, motion, time) {
                scene.planes[i].0 = placed;
            }
        }
        for (i, kind, strength, motion) in &movement.sources {
            if let Some(placed) = source_at(kind, motion, time) {
                (scene.lights[*i], scene.legacy_lights[*i]) = resolve_source(&placed, *strength, DVec3::ZERO);
            }
        }
        if let Some((camera, motion)) = &movement.camera
            && let Ok(map) = Transform::new(motion.at(time))
        {
            scene.camera = camera.moved(&map);
        }
        if !scene.mean_lights.is_empty() {
            scene.mean_lights = scene.lights.iter().map(Light::with_mean_emission).collect();
        }
        scene.settle(self.still);
        scene
    }

    /// Puts another shape in the place of shape `i`, and of the light that it is.
    fn put(&mut self, i: usize, shape: Shape) {
        if let Some(light) = self.shape_attributes[i].light {
            let light = light as usize;
            if let Light::Area(area) = &mut self.lights[light] {
                area.surface = LightSurface::Shape(shape.clone());
                let chart = self.charts[self.shape_attributes[i].chart as usize];
                let remapped = |emission: &Arc<EmissionTexture>| {
                    Arc::new(EmissionTexture { mapping: chart, ..EmissionTexture::clone(emission) })
                };
                area.texture = area.texture.as_ref().map(remapped);
            }
            self.legacy_lights[light] = course_area_light(&self.lights[light]);
        }
        self.shapes[i] = shape;
    }
}
