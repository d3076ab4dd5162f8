//! Tests of directives that concern the whole scene: shutter, options and color spaces.

use crate::format::description::{GroupItem, ObjectDescription, TransformStep};
use crate::format::pbrt::tests::{import_text, note_messages};
use glam::DVec3;

#[test]
fn objects_move_only_while_the_shutter_is_open() {
    let scene = import_text(
        "Camera \"perspective\" \"float shutteropen\" .25 \"float shutterclose\" .75 WorldBegin \
         ActiveTransform EndTime Translate 0 4 0 ActiveTransform All Shape \"sphere\"",
    );
    let GroupItem::Object(object) = &scene.description.root.items[1] else { panic!() };
    let ObjectDescription::Transform { steps, object } = &object.value else { panic!() };
    assert_eq!(TransformStep::composed_matrix(steps).translation, DVec3::Y);
    let ObjectDescription::Moving { steps, .. } = &object.value else { panic!() };
    assert_eq!(*steps, [TransformStep::Translate(2.0 * DVec3::Y)]);
    assert!(note_messages(&scene).contains("exposures of films"));
}

#[test]
fn times_of_transforms_are_relative_to_the_shutter() {
    let scene = import_text(
        "TransformTimes 10 14 Camera \"perspective\" \"float shutteropen\" 10 \"float shutterclose\" 11 \
         WorldBegin ActiveTransform EndTime Translate 0 4 0 ActiveTransform All Shape \"sphere\"",
    );
    let text = scene.description.to_string();
    assert!(text.contains("Moving") && text.contains("0 1 0") && !text.contains("0 4 0"), "{text}");
    assert!(!note_messages(&scene).contains("exposures of films"));
}

#[test]
fn options_have_a_name_and_one_value() {
    let scene = import_text(
        "Option \"disablepixeljitter\" true Option \"rendercoordsys\" \"world\" Option \"seed\" 3 \
         WorldBegin Shape \"sphere\"",
    );
    assert_eq!(scene.description.root.items.len(), 2);
}

#[test]
fn white_balance_and_color_spaces_have_notes() {
    let notes = note_messages(&import_text("ColorSpace \"rec2020\" Film \"rgb\" \"float whitebalance\" 5000"));
    assert!(notes.contains("white balances") && notes.contains("color spaces"), "{notes}");
    let notes = note_messages(&import_text("ColorSpace \"srgb\" Film \"rgb\" \"float whitebalance\" 0"));
    assert!(!notes.contains("white balances") && !notes.contains("color spaces"), "{notes}");
}
