//! Random groups of objects, with the materials that they use.

use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::shapes::random_shape;
use super::values::*;
use crate::format::description::*;

/// Returns a random group item. [`replace_material_numbers`] replaces its random material number.
pub fn random_group_item() -> impl Strategy<Value = GroupItem> {
    let leaf = (random_shape(), option::of(random_color()))
        .prop_map(|(shape, emission)| ObjectDescription::Shape { shape, emission });
    let object = leaf.prop_recursive(4, 24, 4, |inner| {
        let grouped = prop_oneof![
            3 => inner.clone().prop_map(|object| GroupItem::Object(with_empty_span(object))),
            1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(with_empty_span(i))),
        ];
        prop_oneof![
            vec(grouped, 0..4).prop_map(|items| ObjectDescription::Group(ObjectGroup { items })),
            (vec(random_transform_step(), 0..3), inner.clone()).prop_map(|(steps, object)| {
                ObjectDescription::Transform { steps, object: Box::new(with_empty_span(object)) }
            }),
            (vec(random_motion_step(true), 0..3), inner).prop_map(|(steps, object)| ObjectDescription::Moving {
                steps,
                object: Box::new(with_empty_span(object))
            }),
        ]
    });
    prop_oneof![
        3 => object.prop_map(|object| GroupItem::Object(with_empty_span(object))),
        1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(with_empty_span(i))),
    ]
}

/// Replaces the random material numbers in `group` by valid indices and names of `materials`.
pub fn replace_material_numbers(group: &mut ObjectGroup, materials: &[Spanned<MaterialDescription>]) {
    fn replace_material_numbers_in_object(object: &mut ObjectDescription, materials: &[Spanned<MaterialDescription>]) {
        match object {
            ObjectDescription::Group(group) => replace_material_numbers(group, materials),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                replace_material_numbers_in_object(&mut object.value, materials)
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    group.items.retain(|item| !materials.is_empty() || matches!(item, GroupItem::Object(_)));
    for item in &mut group.items {
        if let GroupItem::MaterialIndex(number) = item {
            let index = number.value as usize % materials.len();
            match &materials[index].value.name {
                Some(name) if number.value & (1 << 20) == 0 => {
                    *item = GroupItem::MaterialName(with_empty_span(name.clone()))
                }
                _ => number.value = index as u32,
            }
        } else if let GroupItem::Object(object) = item {
            replace_material_numbers_in_object(&mut object.value, materials);
        }
    }
}
