//! Boundaries of bodies that coincide.
//!
//! A walk leaves a boundary from beyond the error of its place, and would pass by any other that lies there: of a liquid and its glass
//! that share a face, one would never be crossed. So all of them are crossed at once, those that lead in before those that lead out: as if
//! the bodies overlapped by nothing.

use super::{Body, Hit, HitKind, InteriorStack, Scattering, Scene, SurfaceInteraction};
use crate::accel::{Hierarchy, Primitive};
use crate::math::{Ray, offset_origin};
use crate::shape::Shape;
use glam::Vec2;

/// Boundaries that one point may lie on besides the one that was met; of more, the last found are forgotten.
const MOST: usize = 3;

/// A boundary as a walk goes through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face {
    /// Index of the material.
    pub material: u32,
    /// Whether the walk goes into its body.
    pub entering: bool,
    /// The shape, mesh or plane that it is part of; of one alone, any.
    pub thing: u32,
}

impl Face {
    /// That of `surface`, a boundary.
    #[inline]
    pub fn of(surface: &SurfaceInteraction<'_>, entering: bool) -> Self {
        Self { material: surface.index, entering, thing: surface.crowded.unwrap_or(0) }
    }
}

/// The boundaries that coincide with one that was met, in the order of their materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Touching([Option<Face>; MOST]);

impl Touching {
    pub const NONE: Self = Self([None; MOST]);

    #[inline]
    pub fn is_none(&self) -> bool {
        self.0[0].is_none()
    }

    pub fn faces(&self) -> impl Iterator<Item = Face> + '_ {
        self.0.iter().flatten().copied()
    }

    fn add(&mut self, face: Face) {
        if let Some(place) = self.0.iter_mut().find(|f| f.is_none_or(|f| f == face)) {
            *place = Some(face);
        }
    }
}

/// What lies on both sides of boundaries that coincide.
pub(super) struct Sides {
    /// The body that bends light on the side of the walk, and beyond; `None` is air.
    pub near: Option<(u32, Body)>,
    pub far: Option<(u32, Body)>,
    /// Whether none of them is more than the bound of a place.
    pub clear: bool,
    /// The greatest roughness α of those that are more.
    pub roughness: f32,
}

impl InteriorStack {
    /// What is around beyond the boundary `own` and all that touch it.
    ///
    /// Some of what is found at one place was crossed a moment before. That is so of what leads into a body which is already around, once
    /// more if `own` is about to leave it, and of what leads out of one that is not around.
    pub(super) fn beyond(&self, own: Face, touching: &Touching) -> Self {
        let mut far = *self;
        let count = |material: u32| self.bodies().iter().filter(|m| **m == material).count();
        let spare = |material: u32| usize::from(!own.entering && own.material == material);
        let mut faces = [None; MOST + 1];
        let pending = touching.faces().filter(|f| !f.entering || count(f.material) <= spare(f.material));
        faces.iter_mut().zip(pending.chain([own])).for_each(|(place, face)| *place = Some(face));
        // Of bodies that are entered at once the one of the later material was entered last, whichever boundary was met.
        faces.sort_unstable();
        faces.iter().flatten().filter(|f| f.entering).for_each(|f| far.enter(f.material));
        faces.iter().flatten().filter(|f| !f.entering).for_each(|f| far.leave(f.material));
        far
    }

    /// What `surface`, the boundary of `body`, and all that touches it divide.
    pub(super) fn sides(&self, scene: &Scene, surface: &SurfaceInteraction<'_>, body: &Body, entering: bool) -> Sides {
        let far = self.beyond(Face::of(surface, entering), &surface.touching);
        let others = surface.touching.faces().filter_map(|face| scene.body(face.material));
        let (mut clear, mut roughness) = (body.clear, if body.clear { 0.0 } else { surface.roughness });
        for other in others.filter(|other| !other.clear) {
            clear = false;
            roughness = other.roughness.max(roughness);
        }
        Sides { near: self.densest(&scene.materials), far: far.densest(&scene.materials), clear, roughness }
    }
}

impl Scene {
    pub(super) fn body(&self, material: u32) -> Option<Body> {
        match self.materials[material as usize].scattering {
            Scattering::Boundary(body) => Some(body),
            _ => None,
        }
    }

    /// A number of the shape, mesh or plane that was hit. Patches and surfaces of revolution of one body share theirs: neighbours are both
    /// met at a seam, which the other shapes keep their points off.
    pub(super) fn thing_of(&self, kind: HitKind) -> u32 {
        match kind {
            HitKind::Shape(i, _) => match self.shapes[i as usize] {
                Shape::Patch(_) | Shape::Revolution(_) => u32::MAX,
                _ => i,
            },
            HitKind::Triangle(i, _) => self.shapes.len() as u32 + self.triangle_part[i as usize],
            HitKind::Plane(i) => (self.shapes.len() + self.parts.len()) as u32 + i,
        }
    }

    /// The boundaries between the points from which walks leave `surface`, a boundary, on either side; without what is as it is.
    #[inline]
    pub(super) fn faces_at(&self, surface: &SurfaceInteraction<'_>) -> Touching {
        if surface.crowded.is_some() { self.find_touching(surface) } else { Touching::NONE }
    }

    #[inline(never)]
    fn find_touching(&self, surface: &SurfaceInteraction<'_>) -> Touching {
        let (point, wo) = (&surface.point, surface.wo);
        let [near, far] = [wo, -wo].map(|w| offset_origin(point.p, point.error, point.ng, w));
        let length = (far - near).length();
        let mut touching = Touching::NONE;
        if length.is_nan() || length <= 0.0 {
            return touching;
        }
        let across = Ray { origin: near, direction: (far - near) / length, t_max: length };
        let own = Face::of(surface, wo.dot(point.ng) >= 0.0);
        let mut see = |kind: HitKind, t: f32| {
            let (point, attributes) = self.point(&across, &Hit { t, kind });
            let entering = across.direction.dot(point.ng) < 0.0;
            let face = Face { material: attributes.material, entering, thing: self.thing_of(kind) };
            if face != own && self.body(face.material).is_some() {
                touching.add(face);
            }
        };
        let mut look = |hierarchy: &Hierarchy, first: u32| {
            hierarchy.each(
                &across,
                |i, ray| self.shapes[(first + i) as usize].intersect(ray),
                |hit| {
                    let uv = Vec2::new(hit.u, hit.v);
                    match hit.primitive {
                        Primitive::Triangle(i) => see(HitKind::Triangle(i, uv), hit.t),
                        Primitive::Other(i) => see(HitKind::Shape(first + i, uv), hit.t),
                    }
                },
            );
        };
        look(&self.hierarchy, 0);
        if let Some(moving) = &self.moving {
            look(moving, self.first_moving);
        }
        for (i, (plane, _)) in self.planes.iter().enumerate() {
            if let Some((t, ..)) = plane.intersect(&across) {
                see(HitKind::Plane(i as u32), t);
            }
        }
        touching.0.sort_unstable_by_key(|face| face.map_or((true, None), |face| (false, Some(face))));
        touching
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;

    fn face(material: u32, entering: bool) -> Face {
        Face { material, entering, thing: material }
    }

    fn touching(faces: &[Face]) -> Touching {
        let mut touching = Touching::NONE;
        faces.iter().for_each(|f| touching.add(*f));
        touching
    }

    fn inside(bodies: &[u32]) -> InteriorStack {
        let mut inside = InteriorStack::NOTHING;
        bodies.iter().for_each(|b| inside.enter(*b));
        inside
    }

    /// Glass is 0, what it holds 1: whichever of the shared faces is met, the walk is in the same place beyond it.
    #[test]
    fn shared_faces_are_crossed_at_once() {
        let glass = inside(&[0]);
        for (own, other) in [(face(0, false), face(1, true)), (face(1, true), face(0, false))] {
            assert_eq!(glass.beyond(own, &touching(&[other])).bodies(), &[1], "{own:?}");
        }
        for (own, other) in [(face(1, false), face(0, true)), (face(0, true), face(1, false))] {
            assert_eq!(inside(&[1]).beyond(own, &touching(&[other])).bodies(), &[0], "{own:?}");
        }
        // Both at once from the open, and out again; then two parts of one body that share a face.
        assert_eq!(InteriorStack::NOTHING.beyond(face(1, true), &touching(&[face(0, true)])).bodies(), &[0, 1]);
        assert_eq!(inside(&[0, 1]).beyond(face(1, false), &touching(&[face(0, false)])).bodies(), &[0u32; 0]);
        assert_eq!(glass.beyond(face(0, false), &touching(&[face(0, true)])).bodies(), &[0]);
        assert_eq!(glass.beyond(face(0, true), &touching(&[face(0, false)])).bodies(), &[0]);
    }

    #[test]
    fn things_of_one_material_count_each() {
        let part = |thing: u32, entering: bool| Face { material: 0, entering, thing };
        let beyond =
            |around: &[u32], own: Face, other: Face| inside(around).beyond(own, &touching(&[other])).bodies().len();
        assert_eq!(beyond(&[], part(0, true), part(1, true)), 2);
        assert_eq!(beyond(&[0, 0], part(1, false), part(0, false)), 0);
        assert_eq!(beyond(&[0], part(0, false), part(1, true)), 1);
    }

    #[test]
    fn what_was_crossed_a_moment_before_is_not_crossed_again() {
        // The liquid reached a little into the glass, so the walk is already in it.
        assert_eq!(inside(&[0, 1]).beyond(face(0, false), &touching(&[face(1, true)])).bodies(), &[1]);
        // It left the glass a little before it enters the liquid.
        assert_eq!(InteriorStack::NOTHING.beyond(face(1, true), &touching(&[face(0, false)])).bodies(), &[1]);
        // A film thinner than its error is no film.
        assert_eq!(InteriorStack::NOTHING.beyond(face(1, true), &touching(&[face(1, false)])).bodies(), &[0u32; 0]);
        assert_eq!(
            inside(&[0]).beyond(face(0, false), &touching(&[face(1, true), face(1, false)])).bodies(),
            &[0u32; 0]
        );
    }

    #[test]
    fn only_so_many_are_kept_and_each_once() {
        let many: Vec<Face> = (0..5).map(|m| face(m % 4, true)).collect();
        assert_eq!(touching(&many).faces().count(), MOST);
        assert_eq!(touching(&[face(1, true), face(1, true)]).faces().count(), 1);
        assert!(Material::black().dress.is_none() && Touching::NONE.is_none());
    }
}
