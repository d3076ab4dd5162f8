//! Tests of crossing coincident boundaries.

use super::*;

fn coincident_face(material: u32, entering: bool) -> CoincidentFace {
    CoincidentFace { material, entering, group: CoincidenceGroup::group_of_single_object(material) }
}

fn coincident_faces_from_list(list: &[CoincidentFace]) -> CoincidentFaces {
    let mut faces = CoincidentFaces::NONE;
    list.iter().for_each(|f| faces.insert_if_room(*f));
    faces
}

fn interior_stack_of_materials(bodies: &[u32]) -> InteriorStack {
    let mut inside = InteriorStack::EMPTY;
    bodies.iter().for_each(|b| inside.push_body(*b));
    inside
}

/// Crosses the face between a glass (material 0) and its content (material 1). The result does not
/// depend on which of the two boundaries is hit.
#[test]
fn coincident_faces_are_crossed_together() {
    let glass = interior_stack_of_materials(&[0]);
    for (own, other) in
        [(coincident_face(0, false), coincident_face(1, true)), (coincident_face(1, true), coincident_face(0, false))]
    {
        assert_eq!(
            glass.stack_after_crossing(own, &coincident_faces_from_list(&[other])).body_materials(),
            &[1],
            "{own:?}"
        );
    }
    for (own, other) in
        [(coincident_face(1, false), coincident_face(0, true)), (coincident_face(0, true), coincident_face(1, false))]
    {
        assert_eq!(
            interior_stack_of_materials(&[1])
                .stack_after_crossing(own, &coincident_faces_from_list(&[other]))
                .body_materials(),
            &[0],
            "{own:?}"
        );
    }
    // Enter both bodies at once from air, and leave both at once. Then cross a face that two parts
    // of one body share.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_faces_from_list(&[coincident_face(0, true)]))
            .body_materials(),
        &[0, 1]
    );
    assert_eq!(
        interior_stack_of_materials(&[0, 1])
            .stack_after_crossing(coincident_face(1, false), &coincident_faces_from_list(&[coincident_face(0, false)]))
            .body_materials(),
        &[0u32; 0]
    );
    assert_eq!(
        glass
            .stack_after_crossing(coincident_face(0, false), &coincident_faces_from_list(&[coincident_face(0, true)]))
            .body_materials(),
        &[0]
    );
    assert_eq!(
        glass
            .stack_after_crossing(coincident_face(0, true), &coincident_faces_from_list(&[coincident_face(0, false)]))
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
            .stack_after_crossing(own, &coincident_faces_from_list(&[other]))
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
            .stack_after_crossing(coincident_face(0, false), &coincident_faces_from_list(&[coincident_face(1, true)]))
            .body_materials(),
        &[1]
    );
    // A small gap between both bodies: the path left the glass just before it enters the liquid.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_faces_from_list(&[coincident_face(0, false)]))
            .body_materials(),
        &[1]
    );
    // A film thinner than the position error has no effect.
    assert_eq!(
        InteriorStack::EMPTY
            .stack_after_crossing(coincident_face(1, true), &coincident_faces_from_list(&[coincident_face(1, false)]))
            .body_materials(),
        &[0u32; 0]
    );
    assert_eq!(
        interior_stack_of_materials(&[0])
            .stack_after_crossing(
                coincident_face(0, false),
                &coincident_faces_from_list(&[coincident_face(1, true), coincident_face(1, false)])
            )
            .body_materials(),
        &[0u32; 0]
    );
}

#[test]
fn coincident_faces_are_unique_and_limited() {
    let many: Vec<CoincidentFace> = (0..5).map(|m| coincident_face(m % 4, true)).collect();
    assert_eq!(coincident_faces_from_list(&many).iter().count(), MAX_COINCIDENT_FACES);
    assert_eq!(coincident_faces_from_list(&[coincident_face(1, true), coincident_face(1, true)]).iter().count(), 1);
    assert!(CoincidentFaces::NONE.is_empty());
}
