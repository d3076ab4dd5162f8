//! Tables of the curves after `profile`.

use super::schema::{Block, Field, Kind, Range, field};

/// Control points of a Bézier curve.
pub(super) const BEZIER_CONTROLS: Field =
    field("controls", Kind::Points, Range::Any, "control points, at least 2: a curve of degree n − 1")
        .required()
        .course();

/// Control points of a B-spline.
pub(super) const BSPLINE_CONTROLS: Field =
    field("controls", Kind::Points, Range::Any, "control points, at least 4: cubic, with knots i/(n + 3), unclamped")
        .required()
        .course();

/// A Bézier curve as a profile.
pub(super) static BEZIER_PROFILE: Block = Block {
    keyword: "BezierCurve",
    aliases: &[],
    fields: &[BEZIER_CONTROLS],
    shared: &[],
    help: "one Bézier curve",
    course: true,
};

/// A uniform cubic B-spline as a profile.
pub(super) static BSPLINE_PROFILE: Block = Block {
    keyword: "BsplineCurve",
    aliases: &[],
    fields: &[BSPLINE_CONTROLS],
    shared: &[],
    help: "a uniform cubic B-spline",
    course: true,
};
