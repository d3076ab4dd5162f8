//! Objects of imported scenes: placement in world space, and bounds.

use super::description::{ObjectDescription, ShapeDescription, Span, Spanned};
use super::transform_step::TransformStep;
use glam::{DAffine3, DVec3};

/// Returns an object of the scene language: the surface `shape` under the transform `to_world`.
/// `emission` is its constant radiance, if any.
pub(super) fn placed_object(shape: ShapeDescription, emission: Option<DVec3>, to_world: DAffine3) -> ObjectDescription {
    let object = ObjectDescription::Shape { shape, emission };
    if to_world == DAffine3::IDENTITY {
        return object;
    }
    let steps = vec![TransformStep::Matrix(to_world.into())];
    ObjectDescription::Transform { steps, object: Box::new(Spanned::new(object, Span::default())) }
}

/// Returns the bounds in world space of all that `bounds` contains and of a box under the transform
/// `to_world`. The box reaches from `low` to `high` before the transform.
///
/// Bounds are a lower and an upper corner; `None` contains nothing.
pub(super) fn extended_bounds(
    bounds: Option<(DVec3, DVec3)>,
    to_world: &DAffine3,
    (low, high): (DVec3, DVec3),
) -> (DVec3, DVec3) {
    let mut extended = bounds.unwrap_or((DVec3::INFINITY, DVec3::NEG_INFINITY));
    for corner in 0..8 {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let corner = to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
        extended = (extended.0.min(corner), extended.1.max(corner));
    }
    extended
}
