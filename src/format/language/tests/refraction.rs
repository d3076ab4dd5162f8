//! Tests of the index of refraction: by name, by Abbe number, by equation.

use super::name_with_empty_span;
use super::surfaces::{assert_material_error, parse_material_kinds};
use crate::color::DispersionFormula;
use crate::format::description::{DielectricDescription, MaterialKindDescription, RefractiveIndexDescription};

fn parse_refractive_index(fields: &str) -> RefractiveIndexDescription {
    match parse_material_kinds(&format!("Dielectric {{ {fields} }}")).remove(0) {
        MaterialKindDescription::Dielectric(DielectricDescription { refraction, .. }) => refraction,
        other => panic!("{other:?}"),
    }
}

#[test]
fn five_parametrizations_of_the_index_are_read() {
    assert_eq!(parse_refractive_index(""), RefractiveIndexDescription::Constant(1.5));
    assert_eq!(parse_refractive_index("indexOfRefraction 1.7"), RefractiveIndexDescription::Constant(1.7));
    assert_eq!(
        parse_refractive_index("glass BK7"),
        RefractiveIndexDescription::NamedGlass(name_with_empty_span("BK7"))
    );
    assert_eq!(
        parse_refractive_index("abbe 30 indexOfRefraction 1.6"),
        RefractiveIndexDescription::Abbe { index: 1.6, abbe: 30.0 }
    );
    let cauchy = |c| RefractiveIndexDescription::Formula(DispersionFormula::Cauchy { a: 1.5, b: 0.0042, c });
    assert_eq!(parse_refractive_index("cauchy 1.5 .0042"), cauchy(0.0));
    assert_eq!(parse_refractive_index("cauchy 1.5 .0042 -1e-5 roughness .1"), cauchy(-1e-5));
    let glass = DispersionFormula::Sellmeier { b: [1.1, 0.2, 0.0, 0.0], c: [0.01, 100.0, 0.0, 0.0] };
    assert_eq!(
        parse_refractive_index("sellmeierC .01 100 sellmeierB 1.1 .2"),
        RefractiveIndexDescription::Formula(glass)
    );
    let glass = DispersionFormula::Sellmeier { b: [0.1, 0.2, 0.3, 0.4], c: [0.01, 0.02, 0.03, 9.0] };
    assert_eq!(
        parse_refractive_index("sellmeierB .1 .2 .3 .4 sellmeierC .01 .02 .03 9"),
        RefractiveIndexDescription::Formula(glass)
    );
}

#[test]
fn two_indices_of_refraction_are_refused() {
    let of = |fields: &str| format!("Dielectric {{ {fields} }}");
    for second in ["glass› BK7", "cauchy› 1.5 0", "sellmeierB› 1 sellmeierC .01"] {
        let name = &second[..second.find('›').unwrap()];
        let message = format!("both `indexOfRefraction` and `{name}`");
        assert_material_error(
            &of(&format!("indexOfRefraction 1.5 ‹{second}")),
            &message,
            "keep one of `indexOfRefraction` or `glass`",
        );
    }
    assert_material_error(&of("glass BK7 ‹cauchy› 1.5 0"), "both `glass` and `cauchy`", "keep one of");
    assert_material_error(
        &of("abbe ‹30›"),
        "`abbe` of `Dielectric` cannot be `30`",
        "has no effect without `indexOfRefraction`",
    );
    assert_material_error(&of("glass BK7 abbe ‹30›"), "`abbe`", "has no effect without `indexOfRefraction`");
    assert_material_error(&of("cauchy 1.5 0 sellmeierC ‹.01›"), "`sellmeierC`", "has no effect without `sellmeierB`");
    assert_material_error("‹Dielectric› { sellmeierB 1 }", "has no `sellmeierC`", "add `sellmeierC`");
    assert_material_error(&of("glass ‹}›"), "`glass` wants a name", "write a name after `glass`");
    assert_material_error("Thin { ‹glass› BK7 }", "unexpected `glass`", "");
}

#[test]
fn impossible_indices_are_refused() {
    let of = |fields: &str| format!("Dielectric {{ {fields} }}");
    let range = "the index must lie between 0.001 and 1000 from 380 to 720 nm";
    assert_material_error(
        &of("indexOfRefraction 1.5 abbe ‹0›"),
        "`abbe` of `Dielectric` cannot be `0`",
        "must be above 0",
    );
    assert_material_error(&of("indexOfRefraction 1.5 abbe ‹-30›"), "`abbe`", "must be above 0");
    assert_material_error(&of("indexOfRefraction 1.5 abbe ‹.1›"), "`abbe`", &format!("`abbe` is too small: {range}"));
    assert_material_error(&of("indexOfRefraction 1.5 abbe ‹1e-300›"), "`abbe`", range);
    assert_material_error(&of("indexOfRefraction ‹0› abbe 30"), "`indexOfRefraction`", "between 0.001 and 1000");
    assert_material_error(&of("indexOfRefraction 1.5 abbe ‹1e999›"), "too large for a number", "1.7e308");
    assert_material_error(&of("cauchy ‹1.5›"), "`cauchy` of `Dielectric`", "of n = A + B/λ² + C/λ⁴");
    assert_material_error(&of("cauchy ‹1 2 3 4›"), "`cauchy`", "B in µm²");
    // This B is in nm², not in µm².
    assert_material_error(&of("cauchy ‹1.5 4200›"), "`cauchy`", &format!("wants B in µm² and C in µm⁴: {range}"));
    assert_material_error(&of("cauchy ‹1.5 -1›"), "`cauchy`", range);
    assert_material_error(&of("cauchy ‹1e308 1e308›"), "`cauchy`", range);
    assert_material_error(&of("sellmeierB ‹1 1 1 1 1› sellmeierC 1 1 1 1 1"), "`sellmeierB`", "one to four numbers");
    assert_material_error(
        &of("sellmeierB 1 2 sellmeierC ‹.1›"),
        "`sellmeierC`",
        "as many numbers as `sellmeierB`, which has 2",
    );
    // This C puts a resonance at 500 nm, where the refractive index is infinite.
    assert_material_error(
        &of("sellmeierB 1 sellmeierC ‹.25›"),
        "`sellmeierC`",
        &format!("squares of wavelengths, in µm²: {range}"),
    );
    assert_material_error(&of("sellmeierB -5 sellmeierC ‹.01›"), "`sellmeierC`", range);
}
