//! Finding the dielectric bodies around a point.

use super::{CoincidentFace, InteriorStack, coincident_faces_at};
use crate::math::Ray;
use crate::scene::{Effects, RayCone, Scene};
use glam::Vec3;

/// Returns the dielectric bodies that contain point `p`, by tracing a ray from `p` out of the
/// scene.
///
/// A body contains the point if the ray leaves the body without having entered it.
pub(in crate::scene) fn interior_stack_at(scene: &Scene, p: Vec3) -> InteriorStack {
    // This direction is neither an axis nor a diagonal, so the ray seldom hits flat boundaries
    // edge-on.
    let mut ray = Ray::new(p, Vec3::new(0.267_261_24, 0.801_783_74, 0.534_522_5).normalize());
    let mut entered: Vec<u32> = Vec::new();
    let (mut left, mut crossed): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    while let Some(hit) = scene.intersect(&ray) {
        let surface = scene.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::NONE), || 0.0);
        if surface.material.bounded_body().is_some() {
            let own = CoincidentFace::from_surface(&surface, surface.is_entering());
            let coincident = coincident_faces_at(scene, &surface);
            let count = |material| entered.iter().filter(|m| **m == material).count();
            // Entries and exits are handled as in `InteriorStack::stack_after_crossing`, with one
            // difference. An exit without an entry means that the body contains the start of the
            // ray.
            let spare = usize::from(!own.entering && count(own.material) > 0);
            let pending_entry =
                |face: &CoincidentFace| count(face.material) <= if face.material == own.material { spare } else { 0 };
            let mut entries: Vec<u32> =
                coincident.iter().filter(|f| f.entering && pending_entry(f)).map(|f| f.material).collect();
            entries.extend(own.entering.then_some(own.material));
            let pending_exit = |f: &CoincidentFace| !crossed.contains(&f.material) || count(f.material) > 0;
            let exits = coincident.iter().filter(|f| !f.entering && pending_exit(f));
            let exits: Vec<u32> = exits.map(|f| f.material).chain((!own.entering).then_some(own.material)).collect();
            crossed.extend(entries.iter().chain(&exits));
            entered.extend(entries);
            for material in exits {
                match entered.iter().rposition(|m| *m == material) {
                    Some(at) => drop(entered.swap_remove(at)),
                    None => left.push(material),
                }
            }
        }
        ray = surface.spawn_ray(ray.direction);
    }
    let mut stack = InteriorStack::EMPTY;
    // The body that the ray leaves first was entered last.
    left.iter().rev().for_each(|material| stack.push_body(*material));
    stack
}
