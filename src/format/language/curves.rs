//! Bézier and B-spline curves, the profiles of surfaces of revolution: their descriptions and
//! schemas.

use glam::DVec3;

use super::schema::{BlockSchema, FieldKind, FieldSchema, block_schema, field_schema};

/// A polynomial curve in the xy plane, the profile of a surface of revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileCurve {
    /// Polynomial basis to which `controls` belong.
    pub basis: CurveBasis,
    /// Control points: at least 2 for Bézier curves and 4 for B-splines.
    pub controls: Vec<DVec3>,
}

/// Polynomial basis of a profile curve, which defines its degree and its knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveBasis {
    /// One Bézier curve of degree n − 1 for n control points.
    #[default]
    Bezier,
    /// A uniform, unclamped cubic B-spline of n control points. Its n + 4 knots are i/(n + 3) for i
    /// from 0 to n + 3.
    Bspline,
}

/// Schema of the field `controls` of a Bézier curve.
pub(in crate::format) const BEZIER_CONTROLS: FieldSchema =
    field_schema("controls", FieldKind::Points, "control points, at least 2: a curve of degree n − 1")
        .make_required()
        .mark_as_mit_6837_syntax();

/// Schema of the field `controls` of a uniform cubic B-spline.
pub(in crate::format) const BSPLINE_CONTROLS: FieldSchema =
    field_schema("controls", FieldKind::Points, "control points, at least 4: cubic, with knots i/(n + 3), unclamped")
        .make_required()
        .mark_as_mit_6837_syntax();

/// Schema of a Bézier curve that is the profile of a surface of revolution.
pub(in crate::format) static BEZIER_PROFILE: BlockSchema =
    block_schema("BezierCurve", "one Bézier curve").with_own_fields(&[BEZIER_CONTROLS]).mark_as_mit_6837_syntax();

/// Schema of a uniform cubic B-spline that is the profile of a surface of revolution.
pub(in crate::format) static BSPLINE_PROFILE: BlockSchema = block_schema("BsplineCurve", "a uniform cubic B-spline")
    .with_own_fields(&[BSPLINE_CONTROLS])
    .mark_as_mit_6837_syntax();

impl CurveBasis {
    /// Returns the schema of a profile curve with this basis.
    pub(in crate::format) fn block(self) -> &'static BlockSchema {
        match self {
            Self::Bezier => &BEZIER_PROFILE,
            Self::Bspline => &BSPLINE_PROFILE,
        }
    }
}
