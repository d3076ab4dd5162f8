//! What a light cannot reach for certain.

use super::{Emitter, Light};
use crate::math::Sphere;
use crate::shape::Shape;
use glam::Vec3;

/// Rounding of places in f32, in parts of their distance from the origin and from each other.
const MARGIN: f32 = 1e-5;

impl Light {
    /// Whether light that leaves it may reach `ball` in a straight line, `None` being everywhere; `false` only where it cannot. What
    /// stands in between does not count.
    #[must_use]
    pub fn may_reach(&self, ball: Option<Sphere>, domain: Sphere) -> bool {
        let Some(ball) = ball else { return true };
        let margin = MARGIN * (ball.center.abs().max_element() + domain.radius + domain.center.abs().max_element());
        let grown = Sphere { radius: ball.radius + margin, ..ball };
        match self {
            Self::Point { .. } | Self::Directional { .. } | Self::Environment(_) => true,
            Self::Spot(spot) => {
                let to = grown.center - spot.position;
                let distance = to.length();
                // The ball is seen within asin(r/d) of its centre; beyond a right angle the beam is no cone to reckon with.
                if distance <= grown.radius || spot.outer > 1.0 {
                    return true;
                }
                // 2 asin of half the chord keeps its digits in narrow beams.
                let angle = 2.0 * libm::asinf((0.5 * (to / distance - spot.axis).length()).min(1.0));
                angle <= 2.0 * libm::asinf((0.5 * spot.outer).sqrt()) + libm::asinf(grown.radius / distance) + MARGIN
            }
            Self::Area(area) => match area.emitter {
                Emitter::Shape(Shape::Disc(_) | Shape::Rectangle(_)) => {
                    let point = area.emitter.sample(glam::Vec2::splat(0.5)).point;
                    (grown.center - point.p).dot(point.ng) >= -grown.radius
                }
                Emitter::Shape(_) | Emitter::Triangles { .. } => true,
            },
        }
    }

    /// Whether none of its light comes along the plane through `p` across unit `n`, where rounding decides whether what lies in the
    /// plane is in the way; `true` only where that is certain.
    #[must_use]
    pub fn is_clear_of(&self, p: Vec3, n: Vec3) -> bool {
        let beside = |place: Vec3| {
            let margin = MARGIN * (place.abs().max_element() + p.abs().max_element());
            (place - p).dot(n).abs() > margin
        };
        match self {
            Self::Point { position, .. } => beside(*position),
            Self::Spot(spot) => beside(spot.position),
            Self::Directional { direction, .. } => direction.dot(n).abs() > MARGIN,
            Self::Area(_) | Self::Environment(_) => false,
        }
    }
}
