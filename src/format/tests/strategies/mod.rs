//! Random descriptions for proptest, with every feature of the language.

mod camera;
mod lights;
mod materials;
mod media;
mod objects;
mod shapes;
mod textures;
mod values;

use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use crate::format::description::*;
use camera::random_camera;
use lights::{random_environment_light, random_light};
use materials::{build_materials, random_material_parts};
use media::{fill_bodies_with_random_media, random_media};
use objects::{random_group_item, replace_material_numbers};
use textures::{random_texture_kind, random_textured_value, textures_with_unique_names};
use values::*;

pub fn random_description() -> impl Strategy<Value = SceneDescription> {
    let part = any::<prop::sample::Index>;
    let drafts = vec(
        (
            option::of(random_name()),
            random_material_parts(),
            option::of((part(), part(), random_textured_value(0.0..=1.0))),
        ),
        0..6,
    );
    let textured = vec((random_name(), random_texture_kind()), 0..4);
    let lights = (vec(random_light(), 0..4), option::of((random_environment_light(), part())));
    let filled = (random_media(), vec(option::of(part()), 6), option::of(part()));
    let parts = (random_camera(), random_color(), lights, textured, filled, drafts, vec(random_group_item(), 0..4));
    parts.prop_map(|(camera, background, (mut lights, environment), textured, filled, drafts, items)| {
        if let Some((environment, at)) = environment {
            lights.insert(at.index(lights.len() + 1), environment);
        }
        let textures = textures_with_unique_names(textured);
        let mut materials = build_materials(drafts, &textures);
        let (media, fills, ambient_medium) = filled;
        fill_bodies_with_random_media(&mut materials, &media, &fills);
        let ambient_medium =
            ambient_medium.filter(|_| !media.is_empty()).map(|i| with_empty_span(i.get(&media).value.name.clone()));
        let mut root = ObjectGroup { items };
        replace_material_numbers(&mut root, &materials);
        let lights = lights.into_iter().map(with_empty_span).collect();
        SceneDescription {
            camera: with_empty_span(camera),
            background,
            ambient_medium,
            lights,
            textures,
            media,
            materials,
            root,
        }
    })
}
