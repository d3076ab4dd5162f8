//! Finding the dielectric bodies around a point.

use super::{CoincidentFace, InteriorStack, coincident_faces_at};
use crate::math::Ray;
use crate::scene::{Effects, Hit, Material, RayCone, Scene};
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
    let (mut containing_bodies, mut crossed): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    while let Some(hit) = scene.intersect(&ray) {
        let mut surface = scene.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::NONE), || 0.0);
        let material_of = |hit: &Hit| scene.geometry.object_attributes(hit.primitive).material;
        if let Some(leaf) = leaf_with_body(&scene.materials, material_of(&hit)) {
            (surface.material_index, surface.material) = (leaf, &scene.materials[leaf as usize]);
            let own = CoincidentFace::from_surface(&surface, surface.is_entering());
            let coincident = coincident_faces_at(scene, &surface, &|hit, _, _| {
                let material = material_of(hit);
                leaf_with_body(&scene.materials, material).unwrap_or(material)
            });
            let count = |material| entered.iter().filter(|m| **m == material).count();
            // Entries and exits are handled as in `InteriorStack::stack_after_crossing`, except
            // that an exit without an entry means that the body contains the start of the ray.
            let removed_by_own = usize::from(!own.entering && count(own.material) > 0);
            let pending_entry = |face: &CoincidentFace| {
                count(face.material) <= if face.material == own.material { removed_by_own } else { 0 }
            };
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
                    None => containing_bodies.push(material),
                }
            }
        }
        ray = surface.spawn_ray(ray.direction);
    }
    let mut stack = InteriorStack::EMPTY;
    // The body that the ray leaves first was entered last.
    containing_bodies.iter().rev().for_each(|material| stack.push_body(*material));
    stack
}

/// Returns the index of a material that bounds a dielectric body: `index` itself or, if `index` is
/// a mix, a component to which the mix can resolve. `None` if there is no such material.
///
/// A point therefore counts as inside a body even if the mix on the body's boundary resolves to the
/// body's material only on some paths. The result does not depend on the order of a mix's
/// components.
fn leaf_with_body(materials: &[Material], index: u32) -> Option<u32> {
    let material = &materials[index as usize];
    let Some(([first, second], amount)) = material.kind().as_mix() else {
        return material.enclosed_body().map(|_| index);
    };
    let amount = amount.mean();
    let parts = [(first, amount < 1.0), (second, amount > 0.0)].into_iter().filter(|(_, is_chosen)| *is_chosen);
    parts.filter_map(|(part, _)| leaf_with_body(materials, part)).min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::color::Rgb;
    use crate::scene::SceneBuilder;
    use crate::shape::{Shape, Sphere};
    use glam::DVec3;

    #[test]
    fn order_of_mix_components_does_not_change_interiors() {
        let interior = |glass_first: bool, amount: f32| {
            let mut builder = SceneBuilder::new();
            let glass = builder.add_material(Material::dielectric(1.5, Rgb::ZERO));
            let black = builder.add_material(Material::black());
            let (first, second) = if glass_first { (glass, black) } else { (black, glass) };
            let mix = builder.add_material(Material::mix(first, second, amount));
            builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), mix, Rgb::ZERO);
            let camera = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
            builder.build(camera).unwrap().derived.camera_interior.body_materials().to_vec()
        };
        for amount in [0.25, 0.75] {
            assert_eq!((interior(true, amount), interior(false, amount)), (vec![0], vec![0]), "{amount}");
        }
        // With amount 1, no hit resolves to the first part.
        assert_eq!((interior(true, 1.0), interior(false, 1.0)), (vec![], vec![0]));
    }
}
