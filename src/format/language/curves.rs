//! Tables of the curves after `profile`.

use super::schema::{BlockSchema, FieldKind, FieldSchema, block, field};

/// Control points of a Bézier curve.
pub(super) const BEZIER_CONTROLS: FieldSchema =
    field("controls", FieldKind::Points, "control points, at least 2: a curve of degree n − 1")
        .required()
        .course_syntax();

/// Control points of a B-spline.
pub(super) const BSPLINE_CONTROLS: FieldSchema =
    field("controls", FieldKind::Points, "control points, at least 4: cubic, with knots i/(n + 3), unclamped")
        .required()
        .course_syntax();

/// A Bézier curve as a profile.
pub(super) static BEZIER_PROFILE: BlockSchema =
    block("BezierCurve", "one Bézier curve", &[BEZIER_CONTROLS]).course_syntax();

/// A uniform cubic B-spline as a profile.
pub(super) static BSPLINE_PROFILE: BlockSchema =
    block("BsplineCurve", "a uniform cubic B-spline", &[BSPLINE_CONTROLS]).course_syntax();
