//! The part that every walk through a scene shares: to the next surface that is there for light, and away from it.

use super::interior::left_after;
use super::touching::Face;
use super::{
    BoundaryEvent, Effects, Filling, Hit, Interior, InteriorStack, RayCone, Scattering, Scene, SurfaceInteraction,
};
use crate::color::Rgb;
use crate::math::Ray;
use crate::medium::Medium;
use crate::sampling::{Dimension, Key};
use glam::{DVec3, Vec3};
use rand::RngExt;

/// A walk between two surfaces.
#[derive(Clone, Copy, Debug)]
pub struct PathRay<I> {
    /// Where it goes; of unit direction.
    pub ray: Ray,
    /// What it is inside of.
    pub inside: I,
    /// How much of a surface it sees at once.
    pub cone: RayCone,
}

/// A part of a way that lies in a medium.
#[derive(Clone, Copy, Debug)]
pub struct MediumSegment<'a, I> {
    /// The way, of unit direction, up to its end at `t_max`, which may be at infinity.
    pub ray: Ray,
    /// Index of the medium.
    pub index: u32,
    /// The medium.
    pub medium: &'a Medium,
    /// What it is inside of.
    pub inside: I,
    /// Part of the light that is left after what bodies absorbed before it.
    pub left: Rgb,
    /// Whether the way crossed boundaries before that end a shadow ray.
    pub crossed: bool,
}

/// What ends a step of a walk.
#[derive(Clone, Copy, Debug)]
pub enum PathEvent<'a> {
    /// A surface.
    Surface(SurfaceVertex<'a>),
    /// Light is scattered in a medium.
    Scattered {
        /// Part of the light that is left after what bodies absorbed on the way.
        transmittance: Rgb,
        /// Whether the way crossed boundaries that are not there for light, but end a shadow ray.
        crossed: bool,
    },
    /// Nothing.
    Escaped {
        /// Whether the way crossed boundaries that are not there for light, but end a shadow ray.
        crossed: bool,
    },
}

/// Where a walk arrives.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceVertex<'a> {
    /// The surface.
    pub surface: SurfaceInteraction<'a>,
    /// Part of the light that is left after what lies in between.
    pub transmittance: Rgb,
    /// Length of the way \[length].
    pub distance: f32,
    /// Whether the way crossed boundaries that are not there for light, but end a shadow ray.
    pub crossed: bool,
}

impl<I: Interior> PathRay<I> {
    /// Goes to the next surface. `key` is that of the vertex. `through` is shown every stretch in a medium, in order, and tells where light is
    /// scattered there, if it is.
    #[inline]
    pub fn next_vertex<'a>(
        &mut self,
        scene: &'a Scene,
        key: Key,
        mut through: impl FnMut(&MediumSegment<'a, I>) -> Option<f32>,
    ) -> PathEvent<'a> {
        // Depths add up over many boundaries as products of what is hardly below 1 do not.
        let mut depth = DVec3::ZERO;
        let mut transmittance = Rgb::ONE;
        let mut distance = 0.0;
        let mut crossed = false;
        loop {
            let hit = scene.intersect(&self.ray);
            let cone = self.cone;
            let mut surface = hit.map(|hit| {
                self.cone.travel(hit.t);
                let surface = scene.surface(&self.ray, &hit, &self.cone, || key.uniform(Dimension::Mix));
                self.inside.approach(&surface);
                (surface, hit.t)
            });
            if I::IMMERSED
                && let Some((index, ray, from)) =
                    scene.immersed_part(&self.ray, hit.map_or(f32::INFINITY, |hit| hit.t), &self.inside)
            {
                let (medium, inside) = (&scene.media[index as usize], self.inside);
                let stretch = MediumSegment { ray, index, medium, inside, left: transmittance, crossed };
                if let Some(t) = through(&stretch) {
                    self.ray = Ray::new(ray.at(t), ray.direction);
                    self.cone = cone;
                    self.cone.travel(from + t);
                    return PathEvent::Scattered { transmittance, crossed };
                }
            }
            let Some((surface, t)) = &mut surface else { return PathEvent::Escaped { crossed } };
            distance += *t;
            let more = self.inside.depth(scene, *t);
            if more != Rgb::ZERO {
                depth += more.as_dvec3();
                transmittance = left_after(depth.as_vec3());
            }
            match self.inside.meet(scene, surface, key) {
                BoundaryEvent::Surface => {
                    transmittance *= self.inside.arrive(surface);
                    return PathEvent::Surface(SurfaceVertex { surface: *surface, transmittance, distance, crossed });
                }
                BoundaryEvent::Hidden => crossed = true,
                BoundaryEvent::Clear => {}
            }
            self.ray = surface.leave(self.ray.direction);
            self.inside.cross(surface, self.ray.direction);
        }
    }

    /// Goes on from `surface` in unit `direction`, and returns what throughput is multiplied by for that.
    #[inline]
    pub fn leave(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3, transmitted: bool) -> Rgb {
        self.ray = surface.leave(direction);
        self.cone.leave(&surface.bsdf);
        if transmitted {
            self.inside.cross(surface, direction);
        }
        self.inside.leave(surface, transmitted)
    }

    /// Goes on in unit `direction` from where light was scattered in a medium.
    #[inline]
    pub fn turn(&mut self, direction: Vec3) {
        self.ray = Ray::new(self.ray.origin, direction);
        self.cone.scatter();
    }
}

impl Scene {
    /// Part of the light that is left of what comes from the end of `ray` to its start, which is inside of `inside`; unbiased. Surfaces let
    /// nothing through. The direction of a ray that ends must reach from its start to its end, that of others be a unit vector.
    #[must_use]
    pub fn shadow_transmittance<I: Interior>(&self, ray: &Ray, mut inside: I, key: Key) -> Rgb {
        let target = ray.at(ray.t_max);
        let ends = ray.t_max.is_finite();
        let (mut depth, mut left) = (DVec3::ZERO, DVec3::ONE);
        let mut ray = *ray;
        let mut rng = key.rng();
        loop {
            let length = ray.direction.length();
            let unit = Ray::new(ray.origin, ray.direction / length);
            let hit = self.intersect(&ray).map(|hit| Hit { t: hit.t * length, ..hit });
            let surface = hit.map(|hit| self.surface(&unit, &hit, &RayCone::point(Effects::NONE), || rng.random()));
            if let Some(surface) = &surface {
                inside.approach(surface);
            }
            let distance = hit.map_or(ray.t_max * length, |hit| hit.t);
            depth += inside.depth(self, bounded(distance)).as_dvec3();
            if let Some((index, part, _)) = self.immersed_part(&unit, distance, &inside) {
                left *= self.media[index as usize].transmittance_f64(&part, part.t_max, &mut rng);
            }
            let remaining = left_after(depth.as_vec3()) * left.as_vec3();
            let Some(mut surface) = surface else { return remaining };
            if remaining == Rgb::ZERO || inside.meet(self, &mut surface, key) != BoundaryEvent::Clear {
                return Rgb::ZERO;
            }
            ray = if ends { surface.segment_to(target, unit.direction) } else { surface.leave(unit.direction) };
            inside.cross(&surface, unit.direction);
        }
    }

    /// Part of the light that is left of what comes along `ray`, of unit direction, in what lies around its start, whatever stands in the way;
    /// unbiased.
    #[inline]
    #[must_use]
    pub fn dimming<I: Interior>(&self, ray: &Ray, inside: &I, key: Key) -> Rgb {
        let left = inside.transmittance(self, bounded(ray.t_max));
        match self.immersed_part(ray, ray.t_max, inside) {
            Some((index, part, _)) => {
                left * self.media[index as usize].transmittance(&part, part.t_max, &mut key.rng())
            }
            None => left,
        }
    }

    /// The medium around, the part of `ray`, of unit direction, that lies in it up to `end`, and where that begins.
    #[inline]
    fn immersed_part<I: Interior>(&self, ray: &Ray, end: f32, inside: &I) -> Option<(u32, Ray, f32)> {
        let Filling { medium, everywhere } = inside.medium(self)?;
        let whole = Ray { t_max: end, ..*ray };
        if !everywhere {
            return Some((medium, whole, 0.0));
        }
        let (o, d) = ((ray.origin - self.filled.center).as_dvec3(), ray.direction.as_dvec3());
        let radius = f64::from(self.filled.radius);
        let middle = -o.dot(d);
        let half = (radius * radius - (o + d * middle).length_squared()).sqrt();
        // Not so for a ray that passes the ball by, whose half is no number.
        let (from, to) = ((middle - half).max(0.0) as f32, ((middle + half) as f32).min(end));
        if !(half > 0.0 && from < to) {
            return None;
        }
        let part = if from > 0.0 { Ray { origin: ray.at(from), ..whole } } else { whole };
        Some((medium, Ray { t_max: to - from, ..part }, from))
    }

    /// What lies around a point: every body that a ray from it leaves before it enters it.
    #[must_use]
    pub(super) fn inside_at(&self, p: Vec3) -> InteriorStack {
        // No axis, no diagonal: flat boundaries are seldom met edge-on.
        let mut ray = Ray::new(p, Vec3::new(0.267_261_24, 0.801_783_74, 0.534_522_5).normalize());
        let mut entered: Vec<u32> = Vec::new();
        let (mut left, mut met): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
        while let Some(hit) = self.intersect(&ray) {
            let surface = self.surface(&ray, &hit, &RayCone::point(Effects::NONE), || 0.0);
            if let Scattering::Boundary(_) = surface.material.scattering {
                let own = Face::of(&surface, surface.wo.dot(surface.point.ng) >= 0.0);
                let touching = self.faces_at(&surface);
                let count = |material| entered.iter().filter(|m| **m == material).count();
                // As in `InteriorStack::beyond`, but what leads out of a body that was never met was around from the start.
                let spare = usize::from(!own.entering && count(own.material) > 0);
                let room = |face: &Face| count(face.material) <= if face.material == own.material { spare } else { 0 };
                let mut entries: Vec<u32> =
                    touching.faces().filter(|f| f.entering && room(f)).map(|f| f.material).collect();
                entries.extend(own.entering.then_some(own.material));
                let exits =
                    touching.faces().filter(|f| !f.entering && (!met.contains(&f.material) || count(f.material) > 0));
                let exits: Vec<u32> =
                    exits.map(|f| f.material).chain((!own.entering).then_some(own.material)).collect();
                met.extend(entries.iter().chain(&exits));
                entered.extend(entries);
                for material in exits {
                    match entered.iter().rposition(|m| *m == material) {
                        Some(at) => drop(entered.swap_remove(at)),
                        None => left.push(material),
                    }
                }
            }
            ray = surface.leave(ray.direction);
        }
        let mut inside = InteriorStack::NOTHING;
        // What is left first was entered last.
        left.iter().rev().for_each(|material| inside.enter(*material));
        inside
    }
}

/// How far a body absorbs: one without an end is open by mistake, and lets light in.
fn bounded(distance: f32) -> f32 {
    if distance.is_finite() { distance } else { 0.0 }
}
