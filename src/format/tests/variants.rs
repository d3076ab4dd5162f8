//! Test that the random descriptions contain every block of the scene language, and every variant
//! of the fields that have several. `printed_descriptions_parse_back_unchanged` writes and parses
//! these descriptions.

use super::super::description::*;
use super::super::language::all_block_schemas;
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

variant_names!(DISTRIBUTIONS, distribution_name, IntensityDistribution: MapFile ProfileFile);
variant_names!(DENSITY_KINDS, density_kind_name, DensityDescription: Homogeneous Grid Cloud);
variant_names!(PHASE_FUNCTIONS, phase_function_name, PhaseFunctionDescription: Isotropic Rayleigh HenyeyGreenstein);
variant_names!(MEDIUM_COEFFICIENTS, medium_coefficients_name, MediumCoefficients:
    AbsorptionScattering ExtinctionAlbedo);

const MOVING_LIGHT: &str = "LightDescription::Moving";

/// Adds the names of the variants of a light.
fn add_light_names(light: &LightDescription, names: &mut BTreeSet<String>) {
    if let LightDescription::Moving { light, .. } = light {
        names.insert(MOVING_LIGHT.to_owned());
        add_light_names(light, names);
    }
    if let LightDescription::Goniometric(light) = light {
        names.insert(distribution_name(&light.distribution).to_owned());
    }
}

/// Adds the keywords of the blocks in a scene text.
fn add_block_keywords(text: &str, names: &mut BTreeSet<String>) {
    let heads = text.lines().filter(|line| line.ends_with('{'));
    names.extend(heads.filter_map(|line| line.split_whitespace().next()).map(str::to_owned));
}

#[test]
fn random_descriptions_contain_every_block() {
    let mut missing: BTreeSet<&str> = all_block_schemas().map(|block| block.keyword).collect();
    missing.extend([DISTRIBUTIONS, DENSITY_KINDS, PHASE_FUNCTIONS, MEDIUM_COEFFICIENTS, &[MOVING_LIGHT]].concat());
    let mut runner = TestRunner::deterministic();
    for _ in 0..3000 {
        let d = random_description().new_tree(&mut runner).unwrap().current();
        let mut names = BTreeSet::new();
        add_block_keywords(&d.to_string(), &mut names);
        d.lights.iter().for_each(|light| add_light_names(&light.value, &mut names));
        for medium in &d.media {
            names.insert(density_kind_name(&medium.value.density).to_owned());
            names.insert(phase_function_name(&medium.value.phase).to_owned());
            names.insert(medium_coefficients_name(&medium.value.coefficients).to_owned());
        }
        missing.retain(|name| !names.contains(*name));
        if missing.is_empty() {
            return;
        }
    }
    panic!("never generated: {missing:?}");
}
