//! The part that every walk through a scene shares: to the next surface that is there for light, and away from it.

use super::{Inside, Scattering, Scene, Surface};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::{Dimension, Key};
use glam::Vec3;

/// A walk between two surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Where it goes; of unit direction.
    pub ray: Ray,
    /// What it is inside of.
    pub inside: Inside,
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

impl Walk {
    /// Goes to the next surface; `None` where there is none. `key` is that of the vertex.
    #[inline]
    pub fn advance<'a>(&mut self, scene: &'a Scene, key: Key) -> Option<Arrival<'a>> {
        let mut transmittance = Rgb::ONE;
        let mut distance = 0.0;
        let mut crossed = false;
        loop {
            let hit = scene.intersect(&self.ray)?;
            let mut surface = scene.surface(&self.ray, &hit, || key.uniform(Dimension::Mix));
            let boundary = match surface.material.scattering {
                Scattering::Boundary(body) => Some(body),
                _ => None,
            };
            let entering = surface.wo.dot(surface.point.ng) >= 0.0;
            if boundary.is_some() && !entering && !self.inside.holds(surface.index) {
                self.inside.found_inside(surface.index);
            }
            distance += hit.t;
            transmittance *= self.inside.transmittance(scene, hit.t);
            if let Some(body) = boundary {
                let crossing = self.inside.crossing(surface.index, &body, entering, &scene.materials);
                if !crossing.real {
                    self.ray = surface.leave(self.ray.direction);
                    self.inside.cross(surface.index, self.ray.direction, surface.point.ng);
                    crossed = true;
                    continue;
                }
                surface.bsdf = Bsdf::dielectric(crossing.eta, body.roughness);
            }
            return Some(Arrival { surface, transmittance, distance, crossed });
        }
    }

    /// Goes on from `surface` in unit `direction`.
    #[inline]
    pub fn leave(&mut self, surface: &Surface<'_>, direction: Vec3, transmitted: bool) {
        self.ray = surface.leave(direction);
        if transmitted && matches!(surface.material.scattering, Scattering::Boundary(_)) {
            self.inside.cross(surface.index, direction, surface.point.ng);
        }
    }
}

impl Inside {
    /// Part of the light that is left after `distance` in here.
    #[inline]
    #[must_use]
    pub fn transmittance(&self, scene: &Scene, distance: f32) -> Rgb {
        match self.top(&scene.materials) {
            Some((_, body)) if body.absorption != Rgb::ZERO => (-body.absorption * distance).map(libm::expf),
            _ => Rgb::ONE,
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
            let surface = self.surface(&ray, &hit, || 0.0);
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
