//! Parametric surfaces.

use super::super::description::Shape;
use super::super::error::SceneError;
use super::fields::{Fields, Kind};
use super::objects::EMISSION;
use crate::shape::parametric::MAX_DEGREE;

pub(super) const PATCHES: &[(&str, Kind)] =
    &[("degreeU", Kind::Integer), ("degreeV", Kind::Integer), ("controls", Kind::Net), EMISSION];

pub(super) const NURBS: &[(&str, Kind)] = &[
    ("degreeU", Kind::Integer),
    ("degreeV", Kind::Integer),
    ("countU", Kind::Integer),
    ("countV", Kind::Integer),
    ("knotsU", Kind::Numbers),
    ("knotsV", Kind::Numbers),
    ("controls", Kind::Net),
    EMISSION,
];

impl Fields<'_> {
    /// One or more patches.
    pub fn patches(&self) -> Result<Shape, SceneError> {
        let degree = [self.degree("degreeU")?, self.degree("degreeV")?];
        let each = (degree[0] as usize + 1) * (degree[1] as usize + 1);
        let controls = self.need("controls")?;
        let found = controls.net().len();
        let rule = format!("must hold {each} points for each patch of these degrees, and holds {found}");
        controls.ensure(found > 0 && found.is_multiple_of(each), &rule)?;
        Ok(Shape::Patches { degree, controls: controls.net().to_vec() })
    }

    pub fn nurbs(&self) -> Result<Shape, SceneError> {
        let degree = [self.degree("degreeU")?, self.degree("degreeV")?];
        let count = [self.controls_along("countU", degree[0])?, self.controls_along("countV", degree[1])?];
        let knots = [
            self.knots("knotsU", u64::from(count[0]) + u64::from(degree[0]) + 1)?,
            self.knots("knotsV", u64::from(count[1]) + u64::from(degree[1]) + 1)?,
        ];
        let controls = self.need("controls")?;
        let (wanted, found) = (u64::from(count[0]) * u64::from(count[1]), controls.net().len() as u64);
        let rule = format!("must hold countU · countV = {wanted} points, and holds {found}");
        controls.ensure(found == wanted, &rule)?;
        Ok(Shape::Nurbs { degree, count, knots, controls: controls.net().to_vec() })
    }

    /// Cubic where it is not given.
    fn degree(&self, name: &str) -> Result<u32, SceneError> {
        let Some(degree) = self.get(name) else { return Ok(3) };
        let rule = format!("must lie between 1 and {MAX_DEGREE}");
        degree.ensure((1.0..=MAX_DEGREE as f64).contains(&degree.number()), &rule)?;
        Ok(degree.number() as u32)
    }

    fn controls_along(&self, name: &str, degree: u32) -> Result<u32, SceneError> {
        let count = self.need(name)?;
        count.ensure(count.number() > f64::from(degree), "must be above the degree")?;
        Ok(count.number() as u32)
    }

    /// None where they are not given.
    fn knots(&self, name: &str, wanted: u64) -> Result<Vec<f64>, SceneError> {
        let Some(knots) = self.get(name) else { return Ok(Vec::new()) };
        let list = knots.list();
        let rule = format!("must hold count + degree + 1 = {wanted} numbers, and holds {}", list.len());
        knots.ensure(list.len() as u64 == wanted, &rule)?;
        knots.ensure(list.windows(2).all(|w| w[0] <= w[1]), "must not decrease")?;
        Ok(list.to_vec())
    }
}
