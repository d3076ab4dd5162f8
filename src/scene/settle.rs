//! What follows from where things are: the hierarchy of what moves, the ball in which light from infinity counts, and what camera and lights
//! are inside of or touch.

use super::{InteriorStack, Scene};
use crate::accel::Hierarchy;
use crate::light::Light;
use crate::math::{Bounds, Sphere};
use crate::shape::Shape;
use std::sync::Arc;

/// How far light from infinity is followed beyond the bounded shapes, in their radii, where unbounded planes catch it.
const OPEN_DOMAIN: f32 = 4.0;

/// How far a medium that fills the scene reaches, in distances of the farthest that is to be seen. Without an end, most photons would be lost in
/// it far away.
const FILLED: f32 = 2.0;

impl Scene {
    /// Makes all that follows from where things are; `still` is the box around what does not move.
    pub(super) fn settle(&mut self, still: Bounds) {
        let boxes: Vec<Bounds> = self.shapes[self.first_moving as usize..].iter().map(Shape::bounds).collect();
        self.moving = (!boxes.is_empty()).then(|| Arc::new(Hierarchy::build(&[], &boxes)));
        let planes = self.planes.iter().map(|(plane, _)| plane.place().0.length());
        self.domain = domain(boxes.into_iter().fold(still, Bounds::union), planes);
        let places = self.lights.iter().filter_map(Light::emission_point).chain([self.camera.center().as_vec3()]);
        let farthest = places.map(|p| p.distance(self.domain.center)).fold(self.domain.radius, f32::max);
        self.filled = Sphere { center: self.domain.center, radius: farthest * FILLED };
        self.camera_inside = InteriorStack::NOTHING;
        self.light_inside = vec![InteriorStack::NOTHING; self.lights.len()];
        self.light_contact = self.lights.iter().map(|light| self.contact_of(light)).collect();
        if self.has_bodies() {
            self.camera_inside = self.inside_at(self.camera.center().as_vec3());
            let start = |light: &Light| light.emission_point().map_or(InteriorStack::NOTHING, |p| self.inside_at(p));
            self.light_inside = self.lights.iter().map(start).collect();
        }
    }
}

/// The ball in which light from infinity counts, around the bounded shapes, or where there are none around the eye at the origin;
/// `planes` are the distances of unbounded planes.
fn domain(bounds: Bounds, planes: impl Iterator<Item = f32>) -> Sphere {
    let ball = bounds.bounding_sphere();
    let Some(farthest) = planes.reduce(f32::max) else { return ball };
    let radius = if ball.radius > 0.0 {
        ball.radius
    } else if farthest > 0.0 {
        farthest
    } else {
        1.0
    };
    Sphere { center: ball.center, radius: radius * OPEN_DOMAIN }
}
