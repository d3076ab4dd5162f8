//! Test that the random descriptions contain every kind of material, light, shape, texture and
//! medium. `printed_descriptions_parse_back_unchanged` writes and parses these descriptions.

use super::super::description::*;
use super::strategies::random_description;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::collections::BTreeSet;

/// Defines the list of variant names of `$type`, and a function that names a value's variant.
///
/// The match is exhaustive, so a new variant does not compile until it is listed.
macro_rules! variant_names {
    ($names:ident, $name:ident, $type:ident: $($variant:ident)*) => {
        const $names: &[&str] = &[$(concat!(stringify!($type), "::", stringify!($variant))),*];

        fn $name(value: &$type) -> &'static str {
            match value {
                $($type::$variant { .. } => concat!(stringify!($type), "::", stringify!($variant)),)*
            }
        }
    };
}

variant_names!(MATERIAL_KINDS, material_kind_name, MaterialKindDescription:
    Phong Diffuse Mirror Dielectric NullInterface Conductor Thin CoatedDiffuse Mix);
variant_names!(LIGHT_KINDS, light_kind_name, LightDescription:
    Point Directional Spot Sphere Disc Rectangle Oriented Moving Environment);
variant_names!(LIGHT_PATTERNS, light_pattern_name, LightPattern: Picture Map Profile);
variant_names!(SHAPE_KINDS, shape_kind_name, ShapeDescription:
    Sphere Plane Disc Rectangle Box Cylinder Cone Triangle Mesh Revolution Curve Patches Nurbs);
variant_names!(TEXTURE_KINDS, texture_kind_name, TextureKindDescription: Image Checker Solid);
variant_names!(DENSITY_KINDS, density_kind_name, DensityDescription: Homogeneous Grid Cloud);
variant_names!(PHASE_FUNCTIONS, phase_function_name, PhaseFunctionDescription: Isotropic Rayleigh HenyeyGreenstein);
variant_names!(MEDIUM_COEFFICIENTS, medium_coefficients_name, MediumCoefficients:
    AbsorptionScattering ExtinctionAlbedo);

fn add_light_names(light: &LightDescription, names: &mut BTreeSet<&'static str>) {
    names.insert(light_kind_name(light));
    match light {
        LightDescription::Moving { light, .. } => add_light_names(light, names),
        LightDescription::Oriented { pattern, .. } => _ = names.insert(light_pattern_name(pattern)),
        _ => {}
    }
}

fn add_shape_names(object: &ObjectDescription, names: &mut BTreeSet<&'static str>) {
    match object {
        ObjectDescription::Group(group) => add_shape_names_of_group(group, names),
        ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
            add_shape_names(&object.value, names);
        }
        ObjectDescription::Shape { shape, .. } => _ = names.insert(shape_kind_name(shape)),
    }
}

fn add_shape_names_of_group(group: &ObjectGroup, names: &mut BTreeSet<&'static str>) {
    for item in &group.items {
        if let GroupItem::Object(object) = item {
            add_shape_names(&object.value, names);
        }
    }
}

#[test]
fn random_descriptions_contain_every_variant() {
    let mut missing: BTreeSet<&str> = [
        MATERIAL_KINDS,
        LIGHT_KINDS,
        LIGHT_PATTERNS,
        SHAPE_KINDS,
        TEXTURE_KINDS,
        DENSITY_KINDS,
        PHASE_FUNCTIONS,
        MEDIUM_COEFFICIENTS,
    ]
    .concat()
    .into_iter()
    .collect();
    let mut runner = TestRunner::deterministic();
    for _ in 0..3000 {
        let d = random_description().new_tree(&mut runner).unwrap().current();
        let mut names = BTreeSet::new();
        names.extend(d.materials.iter().map(|material| material_kind_name(&material.value.kind)));
        d.lights.iter().for_each(|light| add_light_names(&light.value, &mut names));
        add_shape_names_of_group(&d.root, &mut names);
        names.extend(d.textures.iter().map(|texture| texture_kind_name(&texture.value.kind)));
        for medium in &d.media {
            names.insert(density_kind_name(&medium.value.density));
            names.insert(phase_function_name(&medium.value.phase));
            names.insert(medium_coefficients_name(&medium.value.coefficients));
        }
        missing.retain(|name| !names.contains(name));
        if missing.is_empty() {
            return;
        }
    }
    panic!("never generated: {missing:?}");
}
