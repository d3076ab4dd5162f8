//! Refractive index of a `Dielectric`.

use std::fmt;

use super::super::description::RefractiveIndexDescription;
use super::super::error::SceneError;
use super::fields::{Fields, PresentField};
use super::schema::{Field, Kind, Range, field};
use super::writer::{Numbers, Writer};
use crate::color::DispersionFormula;

/// Least refractive index.
pub(super) const MIN_INDEX: f64 = 0.001;
/// Greatest refractive index: ratios and squares of indices still differ in single precision.
pub(super) const MAX_INDEX: f64 = 1000.0;

/// The index of refraction of dielectrics and thin panes.
pub(super) const INDEX: Field =
    field("indexOfRefraction", Kind::Number, Range::Within(MIN_INDEX, MAX_INDEX), "absolute index of refraction")
        .or(&[1.5]);

/// Alternative fields for the index of refraction.
const SOURCES: [&str; 4] = ["indexOfRefraction", "glass", "cauchy", "sellmeierB"];

/// Greatest number of terms of Sellmeier's equation.
const TERMS: usize = 4;

/// Returns the index of refraction.
pub(super) fn refraction(f: &Fields<'_>) -> Result<RefractiveIndexDescription, SceneError> {
    let given = SOURCES.iter().any(|source| f.get(source).is_some());
    let source = if given { Some(f.one_of(&SOURCES)?) } else { None };
    for (part, whole) in [("abbe", SOURCES[0]), ("sellmeierC", SOURCES[3])] {
        if source.is_none_or(|source| source.name() != whole) {
            f.refuse(&[part], &format!("has no effect without `{whole}`"))?;
        }
    }
    match source.map(|source| (source.name(), source)) {
        Some(("glass", name)) => Ok(RefractiveIndexDescription::Named(name.text())),
        Some(("cauchy", coefficients)) => cauchy(&coefficients),
        Some(("sellmeierB", strengths)) => sellmeier(&strengths, &f.require("sellmeierC")?),
        Some(_) | None => abbe(f),
    }
}

fn abbe(f: &Fields<'_>) -> Result<RefractiveIndexDescription, SceneError> {
    let index = f.number("indexOfRefraction")?;
    let Some(number) = f.get("abbe") else { return Ok(RefractiveIndexDescription::Index(index)) };
    let abbe = number.number();
    check(&DispersionFormula::from_abbe_number(index, abbe), &number, "is too small")?;
    Ok(RefractiveIndexDescription::Abbe { index, abbe })
}

fn cauchy(coefficients: &PresentField<'_, '_>) -> Result<RefractiveIndexDescription, SceneError> {
    let list = coefficients.list();
    let rule = "must be A, B in µm² and, unless 0, C in µm⁴, of n = A + B/λ² + C/λ⁴";
    coefficients.ensure((2..=3).contains(&list.len()), rule)?;
    let (a, b, c) = (list[0], list[1], list.get(2).copied().unwrap_or(0.0));
    let glass = DispersionFormula::Cauchy { a, b, c };
    check(&glass, coefficients, "wants B in µm² and C in µm⁴")?;
    Ok(RefractiveIndexDescription::Glass(glass))
}

fn sellmeier(
    strengths: &PresentField<'_, '_>,
    resonances: &PresentField<'_, '_>,
) -> Result<RefractiveIndexDescription, SceneError> {
    let terms = strengths.list().len();
    strengths.ensure((1..=TERMS).contains(&terms), "must be one to four numbers")?;
    let rule = format!("must be as many numbers as `sellmeierB`, which has {terms}");
    resonances.ensure(resonances.list().len() == terms, &rule)?;
    let (mut b, mut c) = ([0.0; TERMS], [0.0; TERMS]);
    b[..terms].copy_from_slice(strengths.list());
    c[..terms].copy_from_slice(resonances.list());
    let glass = DispersionFormula::Sellmeier { b, c };
    check(&glass, resonances, "wants squares of wavelengths, in µm²")?;
    Ok(RefractiveIndexDescription::Glass(glass))
}

/// Refuses a glass whose index leaves the range; `advice` follows the name of `field`.
fn check(glass: &DispersionFormula, field: &PresentField<'_, '_>, advice: &str) -> Result<(), SceneError> {
    let within = glass.range().is_some_and(|ends| ends.iter().all(|n| (MIN_INDEX..=MAX_INDEX).contains(n)));
    field.ensure(within, &format!("{advice}: the index must lie between 0.001 and 1000 from 380 to 720 nm"))
}

/// Prints the index of refraction.
pub(super) fn write_refraction(out: &mut Writer<'_, '_>, refraction: &RefractiveIndexDescription) -> fmt::Result {
    match refraction {
        RefractiveIndexDescription::Index(index) => out.number("indexOfRefraction", *index),
        RefractiveIndexDescription::Named(name) => out.name("glass", name),
        RefractiveIndexDescription::Abbe { index, abbe } => {
            out.number("indexOfRefraction", *index)?;
            out.number("abbe", *abbe)
        }
        RefractiveIndexDescription::Glass(DispersionFormula::Cauchy { a, b, c }) => {
            out.field("cauchy", Numbers(&[*a, *b, *c]))
        }
        RefractiveIndexDescription::Glass(DispersionFormula::Sellmeier { b, c }) => {
            // Absent terms are not printed.
            let terms = (1..b.len()).rev().find(|i| (b[*i], c[*i]) != (0.0, 0.0)).map_or(1, |last| last + 1);
            out.field("sellmeierB", Numbers(&b[..terms]))?;
            out.field("sellmeierC", Numbers(&c[..terms]))
        }
    }
}
