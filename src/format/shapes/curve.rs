//! The blocks `BezierCurve` and `BsplineCurve` without `profile`: curves of the scene format of MIT
//! course 6.837, which have no surface and are not visible.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::curves::{BEZIER_CONTROLS, BSPLINE_CONTROLS, CurveBasis};
use crate::format::language::field_table::{BlockCodec, FieldWithCheck, field_table};
use crate::format::language::schema::{BlockSchema, block_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement};
use glam::DVec3;

/// A Bézier curve, which the scene format of MIT course 6.837 can contain. It has no surface, so
/// the renderer skips it.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierCurveDescription {
    /// Control points in the xy plane, at least 2.
    pub controls: Vec<DVec3>,
}

/// A uniform, unclamped cubic B-spline, which the scene format of MIT course 6.837 can contain. It
/// has no surface, so the renderer skips it.
#[derive(Clone, Debug, PartialEq)]
pub struct BsplineCurveDescription {
    /// Control points in the xy plane, at least 4.
    pub controls: Vec<DVec3>,
}

field_table!(BezierCurveDescription {
    controls: FieldWithCheck::new(BEZIER_CONTROLS, |_, controls| {
        controls.curve_with_basis(CurveBasis::Bezier).map(drop)
    }),
});

field_table!(BsplineCurveDescription {
    controls: FieldWithCheck::new(BSPLINE_CONTROLS, |_, controls| {
        controls.curve_with_basis(CurveBasis::Bspline).map(drop)
    }),
});

impl ShapeBlock for BezierCurveDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("BezierCurve", "one Bézier curve; without `profile` it has no surface and is not visible")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[EMISSION_FIELDS])
            .mark_as_mit_6837_syntax();

    fn add(&self, _: &mut Resolver<'_>, _: &ObjectPlacement<'_>, _: &ObjectEmission) -> Result<(), SceneError> {
        // A curve has no surface.
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

impl ShapeBlock for BsplineCurveDescription {
    const BLOCK: &'static BlockSchema = &block_schema(
        "BsplineCurve",
        "a uniform cubic B-spline; without `profile` it has no surface and is not visible",
    )
    .with_table(Self::FIELDS)
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_mit_6837_syntax();

    fn add(&self, _: &mut Resolver<'_>, _: &ObjectPlacement<'_>, _: &ObjectEmission) -> Result<(), SceneError> {
        // A curve has no surface.
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
