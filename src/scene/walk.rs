//! The part that every walk through a scene shares: to the next surface that is there for light, and away from it.

use super::{Cone, Detail, Inside, Interior, Scattering, Scene, Surface};
use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::{Dimension, Key};
use glam::Vec3;

/// A walk between two surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Walk<I> {
    /// Where it goes; of unit direction.
    pub ray: Ray,
    /// What it is inside of.
    pub inside: I,
    /// How much of a surface it sees at once.
    pub cone: Cone,
}

/// Where a walk arrives.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a> {
    /// The surface.
    pub surface: Surface<'a>,
    /// Part of the light that is left after what lies in between.
    pub transmittance: Rgb,
    /// Length of the way \[length].
    pub distance: f32,
    /// Whether the way crossed boundaries that are not there for light, but end a shadow ray.
    pub crossed: bool,
}

impl<I: Interior> Walk<I> {
    /// Goes to the next surface; `None` where there is none. `key` is that of the vertex.
    #[inline]
    pub fn advance<'a>(&mut self, scene: &'a Scene, key: Key) -> Option<Arrival<'a>> {
        let mut transmittance = Rgb::ONE;
        let mut distance = 0.0;
        let mut crossed = false;
        loop {
            let hit = scene.intersect(&self.ray)?;
            self.cone.travel(hit.t);
            let mut surface = scene.surface(&self.ray, &hit, &self.cone, || key.uniform(Dimension::Mix));
            self.inside.approach(&surface);
            distance += hit.t;
            transmittance *= self.inside.transmittance(scene, hit.t);
            if self.inside.meet(scene, &mut surface) {
                return Some(Arrival { surface, transmittance, distance, crossed });
            }
            self.ray = surface.leave(self.ray.direction);
            self.inside.cross(&surface, self.ray.direction);
            crossed = true;
        }
    }

    /// Goes on from `surface` in unit `direction`.
    #[inline]
    pub fn leave(&mut self, surface: &Surface<'_>, direction: Vec3, transmitted: bool) {
        self.ray = surface.leave(direction);
        self.cone.leave(&surface.bsdf);
        if transmitted {
            self.inside.cross(surface, direction);
        }
    }
}

impl Scene {
    /// What lies around a point: every body that a ray from it leaves before it enters it.
    #[must_use]
    pub(super) fn inside_at(&self, p: Vec3) -> Inside {
        // No axis, no diagonal: flat boundaries are seldom met edge-on.
        let mut ray = Ray::new(p, Vec3::new(0.267_261_24, 0.801_783_74, 0.534_522_5).normalize());
        let mut entered: Vec<u32> = Vec::new();
        let mut left: Vec<u32> = Vec::new();
        while let Some(hit) = self.intersect(&ray) {
            let surface = self.surface(&ray, &hit, &Cone::point(Detail::NONE), || 0.0);
            if let Scattering::Boundary(_) = surface.material.scattering {
                if surface.wo.dot(surface.point.ng) >= 0.0 {
                    entered.push(surface.index);
                } else if let Some(at) = entered.iter().rposition(|m| *m == surface.index) {
                    entered.swap_remove(at);
                } else {
                    left.push(surface.index);
                }
            }
            ray = surface.leave(ray.direction);
        }
        let mut inside = Inside::NOTHING;
        // What is left first was entered last.
        left.iter().rev().for_each(|material| inside.enter(*material));
        inside
    }
}
