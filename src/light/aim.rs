//! Aiming emission at chosen spheres.

use crate::math::{Frame, Sphere, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Balls that together hold everything the emission is meant for.
///
/// Directions are drawn from the mixture of the cones under which a point sees the balls, each cone in proportion to its
/// solid angle. The density of the mixture is then the number of cones around a direction over the sum of their solid
/// angles, however they overlap, so that dividing by it leaves every mean as it was.
#[derive(Clone, Debug, Default)]
pub struct Targets {
    balls: Vec<Sphere>,
}

/// At most so many balls: each costs a few operations an emitted photon.
const MOST: usize = 32;

#[derive(Clone, Copy)]
struct Cone {
    axis: Vec3,
    one_minus_cos: f32,
}

enum View {
    /// The ball is seen under a cone.
    Cone(Cone),
    /// The point is inside the ball.
    Everywhere,
    /// The ball is below the horizon.
    Nowhere,
}

fn view(ball: &Sphere, p: Vec3, horizon: Option<Vec3>) -> View {
    let to = ball.center - p;
    let d2 = to.length_squared();
    let sin2 = ball.radius * ball.radius / d2;
    if sin2.is_nan() || sin2 >= 1.0 {
        return View::Everywhere;
    }
    let axis = to / d2.sqrt();
    if horizon.is_some_and(|n| axis.dot(n) <= -sin2.sqrt()) {
        return View::Nowhere;
    }
    View::Cone(Cone { axis, one_minus_cos: sin2 / (1.0 + (1.0 - sin2).sqrt()) })
}

impl Targets {
    /// Targets around `balls`, merged by neighbourhood where there are many. The balls grow by a few ulps, so that rounding
    /// leaves nothing outside.
    #[must_use]
    pub fn new(balls: impl IntoIterator<Item = Sphere>) -> Self {
        let mut balls: Vec<Sphere> = balls.into_iter().collect();
        merge(&mut balls, MOST);
        for ball in &mut balls {
            ball.radius = ball.radius * (1.0 + 1e-5) + ball.center.abs().max_element() * 1e-6;
        }
        Self { balls }
    }

    /// A direction from `p` towards the targets, above the plane of `horizon` where one is given, with its density per
    /// steradian. `None` where no target is in view.
    #[must_use]
    pub fn sample_direction(&self, p: Vec3, horizon: Option<Vec3>, u: Vec2) -> Option<(Vec3, f32)> {
        let mut cones = [Cone { axis: Vec3::Z, one_minus_cos: 0.0 }; MOST];
        let mut count = 0;
        let mut total = 0.0;
        for ball in &self.balls {
            match view(ball, p, horizon) {
                View::Cone(cone) => {
                    total += cone.one_minus_cos;
                    cones[count] = cone;
                    count += 1;
                }
                View::Nowhere => {}
                View::Everywhere => return everywhere(horizon, u),
            }
        }
        let cones = &cones[..count];
        let mut at = u.x * total;
        let mut chosen = None;
        for cone in cones {
            let rest = (at / cone.one_minus_cos).min(1.0 - f32::EPSILON);
            at -= cone.one_minus_cos;
            chosen = Some((rest, cone));
            if at < 0.0 {
                break;
            }
        }
        let (rest, cone) = chosen?;
        let direction = Frame::around(cone.axis).to_world(warp::cone(Vec2::new(rest, u.y), cone.one_minus_cos));
        // |w − a|² = 2(1 − cos) keeps its digits in narrow cones.
        let around = cones.iter().filter(|c| (direction - c.axis).length_squared() <= 2.0 * c.one_minus_cos);
        // The chosen cone holds its own direction, whatever rounding says at its rim.
        let count = around.count().max(1);
        Some((direction, count as f32 / (TAU * total)))
    }

    /// A point on a plane across unit `direction` from which parallel light reaches the targets, far enough upstream of them
    /// all, with its density per area.
    #[must_use]
    pub fn sample_parallel(&self, direction: Vec3, upstream: f32, u: Vec2) -> Option<(Vec3, f32)> {
        let total: f32 = self.balls.iter().map(|b| PI * b.radius * b.radius).sum();
        let mut at = u.x * total;
        let mut chosen = None;
        for ball in &self.balls {
            let area = PI * ball.radius * ball.radius;
            let rest = (at / area).min(1.0 - f32::EPSILON);
            at -= area;
            chosen = Some((rest, ball));
            if at < 0.0 {
                break;
            }
        }
        let (rest, ball) = chosen?;
        let frame = Frame::around(direction);
        let d = warp::disc(Vec2::new(rest, u.y)) * ball.radius;
        let p = ball.center + frame.s * d.x + frame.t * d.y;
        let count = self.balls.iter().filter(|b| (p - b.center).cross(direction).length() <= b.radius).count().max(1);
        Some((p - direction * (upstream + direction.dot(p)), count as f32 / total))
    }
}

/// `None` in the horizon itself, where the density is 0.
fn everywhere(horizon: Option<Vec3>, u: Vec2) -> Option<(Vec3, f32)> {
    match horizon {
        Some(n) => {
            let local = warp::cosine_hemisphere(u);
            (local.z > 0.0).then(|| (Frame::around(n).to_world(local), warp::cosine_hemisphere_pdf(local.z)))
        }
        None => Some((warp::sphere(u), 1.0 / (2.0 * TAU))),
    }
}

/// Halves the balls by the median of their widest axis until `most` groups are left, then bounds each group.
fn merge(balls: &mut Vec<Sphere>, most: usize) {
    if balls.len() <= most {
        return;
    }
    let extent = crate::math::Bounds::of(balls.iter().map(|b| b.center)).extent();
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
    balls.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let mut upper = balls.split_off(balls.len() / 2);
    if most > 1 {
        merge(balls, most / 2);
        merge(&mut upper, most - most / 2);
        balls.append(&mut upper);
    } else {
        balls.append(&mut upper);
        *balls = balls.drain(..).reduce(Sphere::union).into_iter().collect();
    }
}
