//! Schemas of Bézier and B-spline curves, the profiles of surfaces of revolution.

use super::schema::{BlockSchema, FieldKind, FieldSchema, block_schema, field_schema};

/// Schema of the field `controls` of a Bézier curve.
pub(super) const BEZIER_CONTROLS: FieldSchema =
    field_schema("controls", FieldKind::Points, "control points, at least 2: a curve of degree n − 1")
        .make_required()
        .mark_as_course_syntax();

/// Schema of the field `controls` of a uniform cubic B-spline.
pub(super) const BSPLINE_CONTROLS: FieldSchema =
    field_schema("controls", FieldKind::Points, "control points, at least 4: cubic, with knots i/(n + 3), unclamped")
        .make_required()
        .mark_as_course_syntax();

/// Schema of a Bézier curve that is the profile of a surface of revolution.
pub(super) static BEZIER_PROFILE: BlockSchema =
    block_schema("BezierCurve", "one Bézier curve").with_fields(&[BEZIER_CONTROLS]).mark_as_course_syntax();

/// Schema of a uniform cubic B-spline that is the profile of a surface of revolution.
pub(super) static BSPLINE_PROFILE: BlockSchema =
    block_schema("BsplineCurve", "a uniform cubic B-spline").with_fields(&[BSPLINE_CONTROLS]).mark_as_course_syntax();
