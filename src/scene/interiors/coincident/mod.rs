//! Coincident boundaries of dielectric bodies, such as the face that a liquid shares with its
//! glass.
//!
//! The origin of a ray is offset by the position error of the boundary that the ray leaves. So the
//! ray would miss a second boundary within that distance. A path therefore crosses all coincident
//! boundaries at once, entries before exits.

mod search;

pub(in crate::scene) use search::{CoincidentFlags, flag_coincident_primitives};

use super::{Body, InteriorStack};
use crate::math::{Ray, offset_ray_origin};
use crate::scene::geometry::CoincidenceGroup;
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::shape::SurfacePoint;

/// Maximum number of coincident boundaries that are recorded for one hit, besides the boundary that
/// the ray hits. Any more are ignored.
const MAX_COINCIDENT_FACES: usize = 3;

/// A boundary of a dielectric body at a hit, and the direction in which the path crosses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::scene) struct CoincidentFace {
    /// Index of the boundary's material.
    pub material: u32,
    /// True if the path enters the dielectric body.
    pub entering: bool,
    /// Coincidence group of the object: the objects whose boundaries count as one boundary if they
    /// coincide. Faces that agree in group, material and direction are one boundary.
    pub group: CoincidenceGroup,
}

impl CoincidentFace {
    /// The boundary at `surface`, which must bound a dielectric body.
    #[inline]
    pub fn from_surface(surface: &SurfaceInteraction<'_>, entering: bool) -> Self {
        Self {
            material: surface.material_index,
            entering,
            group: surface.coincidence_group.unwrap_or(CoincidenceGroup::UNUSED),
        }
    }
}

/// The boundaries of dielectric bodies that coincide with the boundary at a hit, sorted by material
/// index.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::scene) struct CoincidentFaces([Option<CoincidentFace>; MAX_COINCIDENT_FACES]);

impl CoincidentFaces {
    /// The empty set: no boundary coincides with the one at the hit.
    pub const NONE: Self = Self([None; MAX_COINCIDENT_FACES]);

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0[0].is_none()
    }

    pub fn iter(&self) -> impl Iterator<Item = CoincidentFace> + '_ {
        self.0.iter().flatten().copied()
    }

    fn insert_if_room(&mut self, face: CoincidentFace) {
        if let Some(slot) = self.0.iter_mut().find(|f| f.is_none_or(|f| f == face)) {
            *slot = Some(face);
        }
    }
}

/// The dielectric bodies around a path before and after the path crosses a boundary. All boundaries
/// that coincide with this boundary are crossed together with it.
pub(super) struct BoundarySides<'a> {
    /// The body whose refractive index holds on the side where the path arrives, with the body's
    /// material index; `None` is air.
    pub near: Option<(u32, &'a Body)>,
    /// The body whose refractive index holds on the other side, with the body's material index;
    /// `None` is air.
    pub far: Option<(u32, &'a Body)>,
    /// True if the boundary and all that coincide with it are null interfaces.
    pub is_null_interface: bool,
    /// Greatest roughness α of the boundary and all boundaries that coincide with it, except null
    /// interfaces. For a coincident boundary with a roughness texture, the texture's mean counts.
    pub roughness: f32,
}

impl InteriorStack {
    /// Returns the dielectric bodies around a path after it crosses the boundary `own` and all
    /// boundaries in `coincident`.
    ///
    /// The path may already have crossed a coincident boundary at its previous vertex. So an entry
    /// into a body that is already on the stack is skipped, unless the path leaves the same body
    /// through `own`. An exit from a body that is not on the stack has no effect.
    pub(super) fn stack_after_crossing(&self, own: CoincidentFace, coincident: &CoincidentFaces) -> Self {
        let mut far = *self;
        let count = |material: u32| self.body_materials().iter().filter(|m| **m == material).count();
        let removed_by_own = |material: u32| usize::from(!own.entering && own.material == material);
        let mut faces = [None; MAX_COINCIDENT_FACES + 1];
        let pending = coincident.iter().filter(|f| !f.entering || count(f.material) <= removed_by_own(f.material));
        faces.iter_mut().zip(pending.chain([own])).for_each(|(slot, face)| *slot = Some(face));
        // Sorting makes the order of simultaneous entries independent of the boundary that was hit.
        faces.sort_unstable();
        faces.iter().flatten().filter(|f| f.entering).for_each(|f| far.push_body(f.material));
        faces.iter().flatten().filter(|f| !f.entering).for_each(|f| far.remove_body(f.material));
        far
    }
}

/// Returns the dielectric bodies before and after a path crosses `surface`, the boundary of `body`.
/// All boundaries that coincide with `surface` are crossed together with it.
///
/// `stack` holds the bodies around the path before the crossing. `entering` is true if the path
/// enters `body`.
pub(super) fn boundary_sides<'a>(
    stack: &InteriorStack,
    scene: &'a Scene,
    surface: &SurfaceInteraction<'_>,
    body: &Body,
    entering: bool,
) -> BoundarySides<'a> {
    let far = stack.stack_after_crossing(CoincidentFace::from_surface(surface, entering), &surface.coincident);
    let mut is_null_interface = body.is_null_interface;
    let mut roughness = if is_null_interface { 0.0 } else { surface.boundary_roughness };
    for face in surface.coincident.iter() {
        let material = &scene.materials[face.material as usize];
        if material.enclosed_body().is_some_and(|other| !other.is_null_interface) {
            is_null_interface = false;
            roughness = material.mean_boundary_roughness().max(roughness);
        }
    }
    let (near, far) =
        (stack.dominant_refracting_body(&scene.materials), far.dominant_refracting_body(&scene.materials));
    BoundarySides { near, far, is_null_interface, roughness }
}

/// Returns the boundaries of other dielectric bodies that coincide with `surface`: their distance
/// from the surface point is within the point's position error.
///
/// `leaf_at` returns the material index at a hit. For a mix, this is the index of one component
/// that is not a mix itself.
#[inline]
pub(in crate::scene) fn coincident_faces_at(
    scene: &Scene,
    surface: &SurfaceInteraction<'_>,
    leaf_at: &dyn Fn(&Hit, &SurfacePoint, CoincidenceGroup) -> u32,
) -> CoincidentFaces {
    if surface.coincidence_group.is_some() {
        find_coincident_faces(scene, surface, leaf_at)
    } else {
        CoincidentFaces::NONE
    }
}

#[inline(never)]
fn find_coincident_faces(
    scene: &Scene,
    surface: &SurfaceInteraction<'_>,
    leaf_at: &dyn Fn(&Hit, &SurfacePoint, CoincidenceGroup) -> u32,
) -> CoincidentFaces {
    let (point, wo) = (&surface.point, surface.wo);
    let [near, far] = [wo, -wo].map(|w| offset_ray_origin(point.p, point.position_error, point.ng, w));
    let length = (far - near).length();
    let mut faces = CoincidentFaces::NONE;
    if length.is_nan() || length <= 0.0 {
        return faces;
    }
    let across = Ray { origin: near, direction: (far - near) / length, t_max: length };
    let own = CoincidentFace::from_surface(surface, surface.is_entering());
    let geometry = &scene.geometry;
    geometry.for_each_hit(&across, |hit| {
        let point = geometry.surface_point(&across, &hit);
        let entering = across.direction.dot(point.ng) < 0.0;
        let group = geometry.coincidence_group(hit.primitive);
        let material = leaf_at(&hit, &point, group);
        let face = CoincidentFace { material, entering, group };
        if face != own && scene.materials[material as usize].enclosed_body().is_some() {
            faces.insert_if_room(face);
        }
    });
    faces.0.sort_unstable_by_key(|face| face.map_or((true, None), |face| (false, Some(face))));
    faces
}

#[cfg(test)]
mod tests;
