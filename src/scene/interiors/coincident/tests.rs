//! Tests of paths that cross coincident boundaries of several bodies at once.

use super::super::{BoundaryContext, Interior};
use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::sampling::{Key, Purpose};
use crate::scene::{Effects, Material, RayCone, SceneBuilder};
use crate::shape::Plane;
use glam::{DVec3, Vec3};

fn coincident_face(material: u32, entering: bool) -> CoincidentFace {
    CoincidentFace { material, entering, group: CoincidenceGroup::group_of_single_object(material) }
}

fn coincident_face_set(list: &[CoincidentFace]) -> CoincidentFaces {
    let mut faces = CoincidentFaces::NONE;
    list.iter().for_each(|f| faces.insert_if_room(*f));
    faces
}

fn interior_stack_of_materials(bodies: &[u32]) -> InteriorStack {
    let mut inside = InteriorStack::EMPTY;
    bodies.iter().for_each(|b| inside.push_body(*b));
    inside
}

/// A path crosses the face between a glass (material 0) and its content (material 1). The result
/// does not depend on which of the two boundaries is hit.
#[test]
fn coincident_faces_are_crossed_together() {
    let glass = interior_stack_of_materials(&[0]);
    for (own, other) in
        [(coincident_face(0, false), coincident_face(1, true)), (coincident_face(1, true), coincident_face(0, false))]
    {
        assert_eq!(glass.stack_after_crossing(own, &coincident_face_set(&[other])).body_materials(), &[1], "{own:?}");
    }
    for (own, other) in
        [(coincident_face(1, false), coincident_face(0, true)), (coincident_face(0, true), coincident_face(1, false))]
    {
        assert_eq!(
            interior_stack_of_materials(&[1])
                .stack_after_crossing(own, &coincident_face_set(&[other]))
                .body_materials(),
            &[0],
            "{own:?}"
        );
    }
    // Enter both bodies at once from air, and leave both at once. Then cross a face that two parts
    // of one body share.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_face_set(&[coincident_face(0, true)]))
            .body_materials(),
        &[0, 1]
    );
    assert_eq!(
        interior_stack_of_materials(&[0, 1])
            .stack_after_crossing(coincident_face(1, false), &coincident_face_set(&[coincident_face(0, false)]))
            .body_materials(),
        &[0u32; 0]
    );
    assert_eq!(
        glass
            .stack_after_crossing(coincident_face(0, false), &coincident_face_set(&[coincident_face(0, true)]))
            .body_materials(),
        &[0]
    );
    assert_eq!(
        glass
            .stack_after_crossing(coincident_face(0, true), &coincident_face_set(&[coincident_face(0, false)]))
            .body_materials(),
        &[0]
    );
}

#[test]
fn objects_of_one_material_count_separately() {
    let part = |object: u32, entering: bool| CoincidentFace {
        material: 0,
        entering,
        group: CoincidenceGroup::group_of_single_object(object),
    };
    let stack_after_crossing = |around: &[u32], own: CoincidentFace, other: CoincidentFace| {
        interior_stack_of_materials(around)
            .stack_after_crossing(own, &coincident_face_set(&[other]))
            .body_materials()
            .len()
    };
    assert_eq!(stack_after_crossing(&[], part(0, true), part(1, true)), 2);
    assert_eq!(stack_after_crossing(&[0, 0], part(1, false), part(0, false)), 0);
    assert_eq!(stack_after_crossing(&[0], part(0, false), part(1, true)), 1);
}

#[test]
fn a_boundary_just_crossed_is_not_crossed_again() {
    // The liquid overlaps the glass slightly, so the path is already inside it.
    assert_eq!(
        interior_stack_of_materials(&[0, 1])
            .stack_after_crossing(coincident_face(0, false), &coincident_face_set(&[coincident_face(1, true)]))
            .body_materials(),
        &[1]
    );
    // A small gap between both bodies: the path left the glass just before it enters the liquid.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_face_set(&[coincident_face(0, false)]))
            .body_materials(),
        &[1]
    );
    // A layer thinner than the position error has no effect.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_face_set(&[coincident_face(1, false)]))
            .body_materials(),
        &[0u32; 0]
    );
    assert_eq!(
        interior_stack_of_materials(&[0])
            .stack_after_crossing(
                coincident_face(0, false),
                &coincident_face_set(&[coincident_face(1, true), coincident_face(1, false)])
            )
            .body_materials(),
        &[0u32; 0]
    );
}

#[test]
fn coincident_faces_are_unique_and_limited() {
    let many: Vec<CoincidentFace> = (0..5).map(|m| coincident_face(m % 4, true)).collect();
    assert_eq!(coincident_face_set(&many).iter().count(), MAX_COINCIDENT_FACES);
    assert_eq!(coincident_face_set(&[coincident_face(1, true), coincident_face(1, true)]).iter().count(), 1);
    assert!(CoincidentFaces::NONE.is_empty());
}

/// A path meets a face of glass that coincides with a face of a mix. The mix resolves to its liquid
/// component with the probability of this component.
///
/// The standard error over 4096 random keys is 0.0072. The tolerance is 5.5 times as large.
#[test]
fn coincident_mixes_resolve_by_their_component_probabilities() {
    const COUNT: u64 = 4096;
    let mut builder = SceneBuilder::new();
    let glass = builder.add_material(Material::dielectric(1.5, Rgb::ZERO));
    let liquid = builder.add_material(Material::dielectric(1.33, Rgb::ZERO));
    let black = builder.add_material(Material::black());
    let mix = builder.add_material(Material::mix(black, liquid, 0.3));
    builder.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), glass, Rgb::ZERO);
    builder.add_plane(Plane::new(DVec3::ZERO, DVec3::NEG_Y), mix, Rgb::ZERO);
    let camera = Camera::perspective(DVec3::Y, DVec3::NEG_Y, DVec3::X, 1.0, 1, 1).unwrap();
    let scene = builder.build(camera).unwrap();
    let ray = Ray::new(scene.camera.center().as_vec3(), Vec3::NEG_Y);
    let mut hit_of_glass = None;
    scene.geometry.for_each_hit(&ray, |hit| {
        if scene.geometry.object_attributes(hit.primitive).material == glass {
            hit_of_glass = Some(hit);
        }
    });
    let (hit, cone) = (hit_of_glass.unwrap(), RayCone::zero_width_cone(Effects::NONE));
    let key = Key::new(1).purpose_key(Purpose::Test);
    let mut crossings = 0;
    for i in 0..COUNT {
        let mut surface = scene.surface_interaction(&ray, &hit, &cone, || 0.5);
        let context = BoundaryContext { key: key.child_key(i), crossed_boundary_count: 0, cone };
        let mut stack = InteriorStack::EMPTY;
        stack.resolve_boundary(&scene, &mut surface, &context);
        let found: Vec<_> = surface.coincident.iter().map(|face| (face.material, face.entering)).collect();
        assert!(found.is_empty() || found == [(liquid, false)], "{found:?}");
        crossings += found.len();
    }
    let share = crossings as f64 / COUNT as f64;
    assert!((share - 0.3).abs() < 0.04, "{share}");
}
