//! Random indices of refraction for proptest.

use proptest::array::uniform4;
use proptest::prelude::*;

use super::super::description::{RefractiveIndexDescription, Span, Spanned};
use super::values::random_name;
use crate::color::DispersionFormula;

pub fn random_refractive_index() -> impl Strategy<Value = RefractiveIndexDescription> {
    let cauchy = (0.5..3.0, -0.05..0.1, -0.01..0.01).prop_map(|(a, b, c)| DispersionFormula::Cauchy { a, b, c });
    let strength = prop_oneof![Just(0.0), -0.1..2.0];
    let resonance = prop_oneof![Just(0.0), -1.0..0.1, 0.6..200.0];
    let sellmeier = (uniform4(strength), uniform4(resonance)).prop_map(|(b, c)| DispersionFormula::Sellmeier { b, c });
    let within = |glass: &DispersionFormula| {
        glass.refractive_index_range().is_some_and(|[least, most]| least >= 1e-3 && most <= 1e3)
    };
    prop_oneof![
        (1e-3..=1e3).prop_map(RefractiveIndexDescription::Constant),
        random_name().prop_map(|name| RefractiveIndexDescription::NamedGlass(Spanned::new(name, Span::default()))),
        (1.0..=3.0, 9.0..=1e9).prop_map(|(index, abbe)| RefractiveIndexDescription::Abbe { index, abbe }),
        prop_oneof![cauchy, sellmeier].prop_filter("no index", within).prop_map(RefractiveIndexDescription::Formula),
    ]
}
