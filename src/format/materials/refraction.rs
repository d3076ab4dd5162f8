//! Refractive index of a `Dielectric`: description, fields, reading, writing and conversion.

use crate::color::{DispersionFormula, GLASSES, glass_by_name};
use crate::format::error::SceneError;
use crate::format::language::field_table::FieldGroup;
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::nearest_word;
use crate::format::language::schema::{FieldKind, FieldList, FieldRange, FieldSchema, field_schema};
use crate::format::language::writer::{SceneWriter, SpacedNumbers};
use crate::format::resolve::Resolver;
use crate::format::span::Spanned;
use std::fmt;

/// Absolute index of refraction of a dielectric; air has index 1.
#[derive(Clone, Debug, PartialEq)]
pub enum RefractiveIndexDescription {
    /// One refractive index for all wavelengths.
    Constant(f64),
    /// Name of a glass with a known dispersion formula.
    NamedGlass(Spanned<String>),
    /// Two-term Cauchy equation n(λ) = A + B/λ², whose A and B follow from an index and an Abbe
    /// number.
    Abbe {
        /// Refractive index at the d line, 587.56 nm.
        index: f64,
        /// Abbe number, above 0; a smaller one means more dispersion.
        abbe: f64,
    },
    /// Dispersion formula. Its refractive indices lie in \[0.001, 1000] from 380 to 720 nm.
    Formula(DispersionFormula),
}

impl From<f64> for RefractiveIndexDescription {
    fn from(index: f64) -> Self {
        Self::Constant(index)
    }
}

/// Smallest refractive index that a material may have.
pub const MIN_REFRACTIVE_INDEX: f64 = 0.001;
/// Largest refractive index that a material may have. Ratios and squares of indices then stay far
/// within the range of single precision.
pub const MAX_REFRACTIVE_INDEX: f64 = 1000.0;

/// Schema of the field `indexOfRefraction` of dielectrics.
const REFRACTIVE_INDEX_FIELD: FieldSchema =
    field_schema("indexOfRefraction", FieldKind::Number, "absolute index of refraction")
        .with_range(FieldRange::ClosedInterval(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX))
        .with_default_numbers(&[1.5]);

/// Fields that state the refractive index of a dielectric, with or without dispersion.
pub(super) const REFRACTION: FieldGroup<RefractiveIndexDescription> = FieldGroup {
    list: FieldList::own(&[
        REFRACTIVE_INDEX_FIELD,
        field_schema("abbe", FieldKind::Number, "with `indexOfRefraction`: Abbe number")
            .with_range(FieldRange::Positive)
            .make_optional("none: no dispersion"),
        field_schema("glass", FieldKind::Name, "instead of `indexOfRefraction`: a glass by name"),
        field_schema(
            "cauchy",
            FieldKind::NumberList,
            "instead of `indexOfRefraction`: Cauchy's equation; C is optional",
        )
        .with_range(FieldRange::DescribedOnly("A, B \\[µm²], C \\[µm⁴]")),
        field_schema("sellmeierB", FieldKind::NumberList, "instead of `indexOfRefraction`: Sellmeier's equation")
            .with_range(FieldRange::DescribedOnly("1 to 4")),
        field_schema("sellmeierC", FieldKind::NumberList, "squared resonance wavelengths for `sellmeierB`")
            .with_range(FieldRange::DescribedOnly("1 to 4"))
            .with_unit("µm²"),
    ]),
    parse: parse_refraction,
    write: write_refraction,
    texture_name: |_| None,
};

/// Keywords of fields that state the refractive index. A block has at most one of these fields.
const INDEX_SOURCE_KEYWORDS: [&str; 4] = ["indexOfRefraction", "glass", "cauchy", "sellmeierB"];

/// Largest accepted number of terms of Sellmeier's equation.
const MAX_SELLMEIER_TERMS: usize = 4;

/// Parses the refractive index of a dielectric; 1.5 if no field states it.
fn parse_refraction(f: &BlockFields<'_>) -> Result<RefractiveIndexDescription, SceneError> {
    let is_given = INDEX_SOURCE_KEYWORDS.iter().any(|source| f.get(source).is_some());
    let source = if is_given { Some(f.require_one_field_of(&INDEX_SOURCE_KEYWORDS)?) } else { None };
    for (part, whole) in [("abbe", "indexOfRefraction"), ("sellmeierC", "sellmeierB")] {
        if source.is_none_or(|source| source.name() != whole) {
            f.forbid_fields(&[part], &format!("has no effect without `{whole}`"))?;
        }
    }
    match source.map(|source| (source.name(), source)) {
        Some(("glass", name)) => Ok(RefractiveIndexDescription::NamedGlass(name.value())),
        Some(("cauchy", coefficients)) => parse_cauchy(&coefficients),
        Some(("sellmeierB", strengths)) => parse_sellmeier(&strengths, &f.require_field("sellmeierC")?),
        Some(_) | None => parse_index_and_abbe(f),
    }
}

/// Parses the field `indexOfRefraction` and, if present, the Abbe number in the field `abbe`.
fn parse_index_and_abbe(f: &BlockFields<'_>) -> Result<RefractiveIndexDescription, SceneError> {
    let index = f.value_or_default("indexOfRefraction")?;
    let Some(field) = f.get("abbe") else { return Ok(RefractiveIndexDescription::Constant(index)) };
    let abbe = field.value();
    check_refractive_index_range(&DispersionFormula::from_abbe_number(index, abbe), &field, "is too small")?;
    Ok(RefractiveIndexDescription::Abbe { index, abbe })
}

fn parse_cauchy(coefficients: &ParsedField<'_, '_>) -> Result<RefractiveIndexDescription, SceneError> {
    let list = coefficients.number_list();
    let rule = "must be A, B in µm² and, unless 0, C in µm⁴, of n = A + B/λ² + C/λ⁴";
    coefficients.ensure_valid((2..=3).contains(&list.len()), rule)?;
    let (a, b, c) = (list[0], list[1], list.get(2).copied().unwrap_or(0.0));
    let glass = DispersionFormula::Cauchy { a, b, c };
    check_refractive_index_range(&glass, coefficients, "wants B in µm² and C in µm⁴")?;
    Ok(RefractiveIndexDescription::Formula(glass))
}

fn parse_sellmeier(
    strength_field: &ParsedField<'_, '_>,
    wavelength_field: &ParsedField<'_, '_>,
) -> Result<RefractiveIndexDescription, SceneError> {
    let (strengths, wavelengths) = (strength_field.number_list(), wavelength_field.number_list());
    let terms = strengths.len();
    strength_field.ensure_valid((1..=MAX_SELLMEIER_TERMS).contains(&terms), "must be one to four numbers")?;
    let rule = format!("must be as many numbers as `sellmeierB`, which has {terms}");
    wavelength_field.ensure_valid(wavelengths.len() == terms, &rule)?;
    let (mut b, mut c) = ([0.0; MAX_SELLMEIER_TERMS], [0.0; MAX_SELLMEIER_TERMS]);
    b[..terms].copy_from_slice(strengths);
    c[..terms].copy_from_slice(wavelengths);
    let glass = DispersionFormula::Sellmeier { b, c };
    check_refractive_index_range(&glass, wavelength_field, "wants squares of wavelengths, in µm²")?;
    Ok(RefractiveIndexDescription::Formula(glass))
}

/// Fails with an error at `field` if the refractive index of `glass` is outside \[0.001, 1000]
/// anywhere from 380 to 720 nm.
///
/// The error's help text is the name of the field, then `advice` and the accepted range.
fn check_refractive_index_range(
    glass: &DispersionFormula,
    field: &ParsedField<'_, '_>,
    advice: &str,
) -> Result<(), SceneError> {
    let within = glass
        .refractive_index_range()
        .is_some_and(|ends| ends.iter().all(|n| (MIN_REFRACTIVE_INDEX..=MAX_REFRACTIVE_INDEX).contains(n)));
    field.ensure_valid(within, &format!("{advice}: the index must lie between 0.001 and 1000 from 380 to 720 nm"))
}

/// Writes the fields that state the refractive index of a dielectric.
fn write_refraction(refraction: &RefractiveIndexDescription, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
    match refraction {
        RefractiveIndexDescription::Constant(index) => out.write_number("indexOfRefraction", *index),
        RefractiveIndexDescription::NamedGlass(name) => out.write_name_field("glass", name),
        RefractiveIndexDescription::Abbe { index, abbe } => {
            out.write_number("indexOfRefraction", *index)?;
            out.write_number("abbe", *abbe)
        }
        RefractiveIndexDescription::Formula(DispersionFormula::Cauchy { a, b, c }) => {
            out.write_field("cauchy", SpacedNumbers(&[*a, *b, *c]))
        }
        RefractiveIndexDescription::Formula(DispersionFormula::Sellmeier { b, c }) => {
            // Trailing terms with B = C = 0 are padding and were absent in the text.
            let terms = (1..b.len()).rev().find(|i| (b[*i], c[*i]) != (0.0, 0.0)).map_or(1, |last| last + 1);
            out.write_field("sellmeierB", SpacedNumbers(&b[..terms]))?;
            out.write_field("sellmeierC", SpacedNumbers(&c[..terms]))
        }
    }
}

/// Returns a dielectric's refractive index at the d line (587.56 nm). If the dielectric has
/// dispersion, adds its dispersion formula to the scene's list, and also returns the formula's
/// position in this list.
///
/// Without dispersion, adds nothing, and the position is `None`.
pub(super) fn resolve_refractive_index(
    r: &mut Resolver<'_>,
    described: &RefractiveIndexDescription,
) -> Result<(f32, Option<u32>), SceneError> {
    let glass = match described {
        RefractiveIndexDescription::Constant(index) => return Ok((*index as f32, None)),
        RefractiveIndexDescription::NamedGlass(name) => find_glass(r, name)?,
        RefractiveIndexDescription::Abbe { index, abbe } => DispersionFormula::from_abbe_number(*index, *abbe),
        RefractiveIndexDescription::Formula(glass) => *glass,
    };
    Ok((glass.refractive_index_at_d_line(), Some(r.builder.add_dispersion_formula(glass))))
}

/// Returns the dispersion formula of the glass called `name`. The error for an unknown name lists
/// all names.
fn find_glass(r: &Resolver<'_>, name: &Spanned<String>) -> Result<DispersionFormula, SceneError> {
    glass_by_name(name).ok_or_else(|| {
        let names = || GLASSES.iter().map(|g| g.0);
        let message = format!("no glass is called `{}`", name.value);
        let guess = nearest_word(name, names()).map_or(String::new(), |n| format!("did you mean `{n}`? "));
        let known = names().collect::<Vec<_>>().join(", ");
        let help = format!("{guess}known are {known}; of others, give `cauchy`, or `indexOfRefraction` and `abbe`");
        SceneError::error_at_span(r.source, name.span, message, "unknown name", help)
    })
}
