//! What a walk is inside of.

use super::{Body, BoundaryEvent, Material, Scattering};
use glam::Vec3;

/// Bodies that may lie around a point; of more, those entered first are forgotten.
const MOST: usize = 12;

/// The bodies around a point, in the order in which they were entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InteriorStack {
    /// Indices of materials.
    bodies: [u32; MOST],
    count: u8,
}

/// What a boundary divides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Whether the boundary is there for light: else a body of higher priority fills both sides.
    pub real: bool,
    /// The body outside; `None` is air.
    pub outside: Option<Body>,
}

impl Crossing {
    /// What a boundary is for light that is not the bound of a mere place.
    #[inline]
    pub fn meeting(&self) -> BoundaryEvent {
        if self.real { BoundaryEvent::Surface } else { BoundaryEvent::Hidden }
    }

    /// Index inside the boundary's `body` over the index outside it.
    #[inline]
    pub fn eta(&self, body: &Body, index: impl Fn(&Body) -> f32) -> f32 {
        index(body) / self.outside.as_ref().map_or(1.0, index)
    }
}

impl InteriorStack {
    /// In the open.
    pub const NOTHING: Self = Self { bodies: [0; MOST], count: 0 };

    /// Material indices of the bodies, in the order of entry.
    #[must_use]
    pub fn bodies(&self) -> &[u32] {
        &self.bodies[..usize::from(self.count)]
    }

    /// Enters a body.
    #[inline]
    pub(super) fn enter(&mut self, material: u32) {
        if usize::from(self.count) == MOST {
            self.bodies.copy_within(1.., 0);
            self.count -= 1;
        }
        self.bodies[usize::from(self.count)] = material;
        self.count += 1;
    }

    /// Leaves a body; where it was not known to be inside, nothing changes.
    #[inline]
    pub(super) fn leave(&mut self, material: u32) {
        let end = usize::from(self.count);
        if let Some(at) = self.bodies().iter().rposition(|m| *m == material) {
            self.bodies.copy_within(at + 1..end, at);
            self.count -= 1;
        }
    }

    /// Puts a body at the bottom: the walk began inside it unawares.
    pub(super) fn found_inside(&mut self, material: u32) {
        if usize::from(self.count) < MOST {
            self.bodies.copy_within(0..usize::from(self.count), 1);
            self.bodies[0] = material;
            self.count += 1;
        }
    }

    /// Whether a body is known to be around.
    #[inline]
    pub(super) fn holds(&self, material: u32) -> bool {
        self.bodies().contains(&material)
    }

    /// The body whose content counts.
    #[inline]
    pub(super) fn top(&self, materials: &[Material]) -> Option<(u32, Body)> {
        self.greatest(materials, |_| true)
    }

    /// The body whose refractive index counts.
    #[inline]
    pub(super) fn densest(&self, materials: &[Material]) -> Option<(u32, Body)> {
        self.greatest(materials, |body| !body.clear)
    }

    #[inline]
    fn greatest(&self, materials: &[Material], counts: impl Fn(&Body) -> bool) -> Option<(u32, Body)> {
        let mut top: Option<(u32, Body)> = None;
        for index in self.bodies() {
            if let Scattering::Boundary(body) = materials[*index as usize].scattering
                && counts(&body)
                && top.is_none_or(|(_, t)| body.rank() >= t.rank())
            {
                top = Some((*index, body));
            }
        }
        top
    }

    /// What the boundary of `body`, of material `material`, divides for a walk on its way in or out.
    #[inline]
    pub(super) fn crossing(&self, material: u32, body: &Body, entering: bool, materials: &[Material]) -> Crossing {
        let mut around = *self;
        let real = if entering {
            self.densest(materials).is_none_or(|(_, top)| body.priority >= top.priority)
        } else {
            // The walk leaves the body that was entered last among its equals.
            let top = self.densest(materials).is_none_or(|(index, _)| index == material);
            around.leave(material);
            top
        };
        Crossing { real, outside: around.densest(materials).map(|(_, body)| body) }
    }

    /// Goes through a boundary in unit `direction`, where `ng` points out of its body.
    #[inline]
    pub(super) fn cross_boundary(&mut self, material: u32, direction: Vec3, ng: Vec3) {
        if direction.dot(ng) < 0.0 { self.enter(material) } else { self.leave(material) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn materials() -> Vec<Material> {
        let body = |index, priority| Material::body(Body { priority, ..Body::new(index) });
        // Water, ice, glass.
        vec![body(1.33, 0), body(1.31, 1), body(1.5, 2)]
    }

    fn body(i: usize) -> Body {
        match materials()[i].scattering {
            Scattering::Boundary(body) => body,
            _ => unreachable!(),
        }
    }

    fn inside(bodies: &[u32]) -> InteriorStack {
        let mut inside = InteriorStack::NOTHING;
        bodies.iter().for_each(|b| inside.enter(*b));
        inside
    }

    #[test]
    fn the_highest_priority_counts_whatever_the_order_of_entry() {
        let m = materials();
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            assert_eq!(inside(&order).top(&m).unwrap().0, 2);
        }
        assert!(!inside(&[2]).crossing(0, &body(0), true, &m).real, "water begins inside the glass");
        assert!(!inside(&[2, 0]).crossing(0, &body(0), false, &m).real);
        let out = inside(&[2, 0]).crossing(2, &body(2), false, &m);
        assert_eq!(out, Crossing { real: true, outside: Some(body(0)) }, "glass to the water that began inside it");
        assert_eq!(out.eta(&body(2), |b| b.index), 1.5 / 1.33);
    }

    /// The same boundary met from both sides has the same index ratio: a walk and its reverse see one interface.
    #[test]
    fn a_boundary_is_the_same_from_both_sides() {
        let m = materials();
        for around in [&[][..], &[0], &[1], &[2], &[0, 1], &[0, 2], &[0, 1, 2]] {
            for material in 0..3u32 {
                if around.contains(&material) {
                    continue;
                }
                let outside = inside(around);
                let inwards = outside.crossing(material, &body(material as usize), true, &m);
                let mut within = outside;
                within.enter(material);
                assert_eq!(inwards, within.crossing(material, &body(material as usize), false, &m));
            }
        }
    }

    #[test]
    fn bodies_of_one_priority_nest_and_equal_materials_merge() {
        let mut m = materials();
        for material in &mut m {
            if let Scattering::Boundary(body) = &mut material.scattering {
                body.priority = 0;
            }
        }
        assert_eq!(inside(&[2, 0]).top(&m).unwrap().0, 0, "the last one entered counts");
        let glass = Body { priority: 0, ..body(2) };
        let crossing = inside(&[2]).crossing(2, &glass, true, &m);
        assert_eq!(crossing.eta(&glass, |b| b.index), 1.0, "glass in the same glass is no boundary");
    }

    #[test]
    fn what_is_clear_gives_way_and_has_no_index() {
        let mut m = materials();
        m.push(Material::body(Body::clear(0)));
        m.push(Material::body(Body { priority: 9, ..Body::clear(1) }));
        assert_eq!(inside(&[0, 3]).top(&m).unwrap().0, 0, "of equals, what is not clear");
        assert_eq!(inside(&[3]).top(&m).unwrap().0, 3);
        assert_eq!(inside(&[2, 4]).top(&m).unwrap().0, 4, "smoke that displaces glass");
        assert_eq!(inside(&[2, 4]).densest(&m).unwrap().0, 2, "but the glass bends light");
        let into = inside(&[4]).crossing(2, &body(2), true, &m);
        assert_eq!(into, Crossing { real: true, outside: None });
    }

    #[test]
    fn more_bodies_than_there_is_room_for_lose_the_outermost() {
        let mut deep = inside(&[0; MOST]);
        deep.enter(2);
        assert_eq!((deep.bodies().len(), deep.bodies().last()), (MOST, Some(&2)));
        deep.leave(2);
        deep.leave(7);
        assert_eq!(deep.bodies(), &[0; MOST - 1]);
    }
}
