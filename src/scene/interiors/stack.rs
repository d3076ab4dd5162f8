//! The stack of dielectric bodies around a point of a path.

use super::{Body, BoundaryEvent};
use crate::scene::Material;
use glam::Vec3;

/// Capacity of the stack. When a body is pushed onto a full stack, the body at the bottom is
/// dropped.
const MAX_BODIES: usize = 12;

/// Stack of the dielectric bodies that contain a point of a path, in the order in which the path
/// entered them. Each body is given by its material index (Schmidt and Budge 2002, "Simple Nested
/// Dielectrics in Ray Traced Images").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InteriorStack {
    /// Material indices of the bodies; only the first `count` are valid.
    body_materials: [u32; MAX_BODIES],
    count: u8,
}

/// Properties of the boundary of a dielectric body: the other body on the outer side, and whether
/// light interacts with the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct BodyInterface {
    /// True if another dielectric body has priority and fills both sides of the boundary, so that
    /// light does not interact with the boundary.
    pub is_hidden: bool,
    /// The dielectric body on the outer side of the boundary; `None` is air.
    pub outside: Option<Body>,
}

impl BodyInterface {
    /// Returns the event for a path at this boundary, which must not be a null interface.
    #[inline]
    pub fn boundary_event(&self) -> BoundaryEvent {
        if self.is_hidden { BoundaryEvent::Hidden } else { BoundaryEvent::Surface }
    }

    /// Refractive index of `body` relative to the outer side.
    ///
    /// `eta` returns the absolute refractive index of a dielectric body.
    #[inline]
    pub fn relative_eta(&self, body: &Body, eta: impl Fn(&Body) -> f32) -> f32 {
        eta(body) / self.outside.as_ref().map_or(1.0, eta)
    }
}

impl InteriorStack {
    /// The empty stack: a point in air.
    pub const EMPTY: Self = Self { body_materials: [0; MAX_BODIES], count: 0 };

    /// Material indices of the dielectric bodies, in the order of entry.
    #[must_use]
    pub fn body_materials(&self) -> &[u32] {
        &self.body_materials[..usize::from(self.count)]
    }

    /// Pushes the dielectric body of `material`, which the path enters, onto the stack.
    #[inline]
    pub(in crate::scene) fn push_body(&mut self, material: u32) {
        if usize::from(self.count) == MAX_BODIES {
            self.body_materials.copy_within(1.., 0);
            self.count -= 1;
        }
        self.body_materials[usize::from(self.count)] = material;
        self.count += 1;
    }

    /// Removes the dielectric body of `material`, which the path leaves, if it is on the stack.
    #[inline]
    pub(in crate::scene) fn remove_body(&mut self, material: u32) {
        let end = usize::from(self.count);
        if let Some(at) = self.body_materials().iter().rposition(|m| *m == material) {
            self.body_materials.copy_within(at + 1..end, at);
            self.count -= 1;
        }
    }

    /// Inserts the dielectric body of `material` at the bottom of the stack, because the path has
    /// started inside it. Does nothing if the stack is full.
    pub(in crate::scene) fn insert_outermost_body(&mut self, material: u32) {
        if usize::from(self.count) < MAX_BODIES {
            self.body_materials.copy_within(0..usize::from(self.count), 1);
            self.body_materials[0] = material;
            self.count += 1;
        }
    }

    #[inline]
    pub(in crate::scene) fn contains(&self, material: u32) -> bool {
        self.body_materials().contains(&material)
    }

    /// The dielectric body that determines absorption and medium, with its material index; `None`
    /// in air. Of all bodies on the stack, this is the one of highest priority.
    #[inline]
    pub(in crate::scene) fn dominant_body<'a>(&self, materials: &'a [Material]) -> Option<(u32, &'a Body)> {
        self.highest_priority_body(materials, |_| true)
    }

    /// The dielectric body that determines the refractive index, with its material index; `None` in
    /// air. Of all bodies on the stack whose boundary is not a null interface, this is the one of
    /// highest priority.
    #[inline]
    pub(in crate::scene) fn dominant_refracting_body<'a>(&self, materials: &'a [Material]) -> Option<(u32, &'a Body)> {
        self.highest_priority_body(materials, |body| !body.is_null_interface)
    }

    #[inline]
    fn highest_priority_body<'a>(
        &self,
        materials: &'a [Material],
        counts: impl Fn(&Body) -> bool,
    ) -> Option<(u32, &'a Body)> {
        let mut top: Option<(u32, &Body)> = None;
        for index in self.body_materials() {
            if let Some(body) = materials[*index as usize].enclosed_body()
                && counts(body)
                && top.is_none_or(|(_, t)| body.overlap_priority() >= t.overlap_priority())
            {
                top = Some((*index, body));
            }
        }
        top
    }

    /// Returns the interface between `body` and the dielectric body on the outer side of the
    /// boundary of `body`.
    ///
    /// The stack holds the bodies around the path that meets the boundary. `material` is the
    /// material index of `body`. `entering` is true if the path enters `body`.
    #[inline]
    pub(in crate::scene) fn interface_at_boundary(
        &self,
        material: u32,
        body: &Body,
        entering: bool,
        materials: &[Material],
    ) -> BodyInterface {
        let mut around = *self;
        let is_hidden = if entering {
            self.dominant_refracting_body(materials).is_some_and(|(_, top)| body.priority < top.priority)
        } else {
            // Among bodies of equal priority, the one entered last fills the space before the
            // boundary.
            let lies_below_top = self.dominant_refracting_body(materials).is_some_and(|(index, _)| index != material);
            around.remove_body(material);
            lies_below_top
        };
        BodyInterface { is_hidden, outside: around.dominant_refracting_body(materials).map(|(_, body)| *body) }
    }

    /// Pushes or removes the dielectric body of `material`, depending on the unit `direction` of
    /// the path.
    ///
    /// `ng` is the geometric normal of the boundary and points out of the body.
    #[inline]
    pub(in crate::scene) fn enter_or_leave_body(&mut self, material: u32, direction: Vec3, ng: Vec3) {
        if direction.dot(ng) < 0.0 { self.push_body(material) } else { self.remove_body(material) }
    }
}

#[cfg(test)]
mod tests;
