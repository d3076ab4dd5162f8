//! How a Dielectric bends light.

use super::super::description::Refraction;
use super::super::error::SceneError;
use super::fields::{Fields, Found};
use super::materials::INDICES;
use crate::color::Glass;

/// The fields of which one says how light is bent.
const WAYS: [&str; 4] = ["indexOfRefraction", "glass", "cauchy", "sellmeierB"];

/// Most terms of Sellmeier's equation.
const TERMS: usize = 4;

impl Fields<'_> {
    pub(super) fn refraction(&self) -> Result<Refraction, SceneError> {
        let given = WAYS.iter().any(|way| self.get(way).is_some());
        let way = if given { Some(self.one_of(&WAYS)?) } else { None };
        for (part, whole) in [("abbe", WAYS[0]), ("sellmeierC", WAYS[3])] {
            if let Some(part) = self.get(part) {
                let rule = format!("says nothing without `{whole}`");
                part.ensure(way.is_some_and(|way| way.name() == whole), &rule)?;
            }
        }
        match way {
            Some(way) if way.name() == "glass" => Ok(Refraction::Named(way.text())),
            Some(way) if way.name() == "cauchy" => cauchy(&way),
            Some(way) if way.name() == "sellmeierB" => sellmeier(&way, &self.need("sellmeierC")?),
            _ => self.abbe(self.index()?),
        }
    }

    fn abbe(&self, index: f64) -> Result<Refraction, SceneError> {
        let Some(number) = self.get("abbe") else { return Ok(Refraction::Index(index)) };
        let abbe = number.positive()?;
        check(&Glass::of_abbe(index, abbe), &number, "is too small")?;
        Ok(Refraction::Abbe { index, abbe })
    }
}

fn cauchy(field: &Found<'_, '_>) -> Result<Refraction, SceneError> {
    let list = field.list();
    let rule = "must be A, B in µm² and, unless 0, C in µm⁴, of n = A + B/λ² + C/λ⁴";
    field.ensure((2..=3).contains(&list.len()), rule)?;
    let (a, b, c) = (list[0], list[1], list.get(2).copied().unwrap_or(0.0));
    let glass = Glass::Cauchy { a, b, c };
    check(&glass, field, "wants B in µm² and C in µm⁴")?;
    Ok(Refraction::Own(glass))
}

fn sellmeier(strengths: &Found<'_, '_>, resonances: &Found<'_, '_>) -> Result<Refraction, SceneError> {
    let terms = strengths.list().len();
    strengths.ensure((1..=TERMS).contains(&terms), "must be one to four numbers")?;
    let rule = format!("must be as many numbers as `sellmeierB`, which has {terms}");
    resonances.ensure(resonances.list().len() == terms, &rule)?;
    let (mut b, mut c) = ([0.0; TERMS], [0.0; TERMS]);
    b[..terms].copy_from_slice(strengths.list());
    c[..terms].copy_from_slice(resonances.list());
    let glass = Glass::Sellmeier { b, c };
    check(&glass, resonances, "wants squares of wavelengths, in µm²")?;
    Ok(Refraction::Own(glass))
}

/// Refuses indices out of range, at `field`, of which `advice` says more.
fn check(glass: &Glass, field: &Found<'_, '_>, advice: &str) -> Result<(), SceneError> {
    let within = glass.range().is_some_and(|ends| ends.iter().all(|n| INDICES.contains(n)));
    field.ensure(within, &format!("{advice}: the index must lie between 0.001 and 1000 from 380 to 720 nm"))
}
