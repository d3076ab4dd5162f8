//! Photon aim: samples emitted rays that enter the bounding spheres of chosen objects.

use crate::math::{BoundingSphere, Bounds, Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Bounding spheres of the objects at which lights aim photons. The spheres do the work of Jensen's
/// projection maps (Jensen 2001).
///
/// Each sphere subtends a cone from the emitting point. Sampling chooses a cone with a probability
/// proportional to its solid angle, and then a uniform direction in this cone. Cones may overlap:
/// the pdf of a direction is the number of cones that contain it, divided by the sum of all solid
/// angles.
#[derive(Clone, Debug, Default)]
pub struct PhotonAim {
    spheres: Vec<BoundingSphere>,
}

/// Largest number of spheres of a [`PhotonAim`]. It is small, because the emission of each photon
/// loops over all spheres.
const MAX_SPHERES: usize = 32;

/// Cone of directions that a sphere subtends from a point outside it.
#[derive(Clone, Copy)]
struct SubtendedCone {
    /// Unit axis of the cone: the direction from the point to the center of the sphere.
    axis: Vec3,
    /// 1 − cosine of the cone's half angle.
    one_minus_cos: f32,
}

/// Directions that lead from an emitting point to a sphere.
enum SubtendedDirections {
    /// A cone of directions leads to the sphere, because the point is outside it.
    Cone(SubtendedCone),
    /// All directions lead to the sphere, because the point is inside it.
    All,
    /// No direction leads to the sphere, because it is below the plane of the emitting surface.
    None,
}

/// Returns the directions from `p` that lead to `sphere`.
///
/// `horizon` is the unit normal of an emitting surface at `p`. No direction leads to a sphere below
/// the plane of this surface. If `horizon` is `None`, light leaves `p` in all directions.
fn directions_to_sphere(sphere: &BoundingSphere, p: Vec3, horizon: Option<Vec3>) -> SubtendedDirections {
    let to = sphere.center - p;
    let d2 = to.length_squared();
    let sin2 = sphere.radius * sphere.radius / d2;
    if sin2.is_nan() || sin2 >= 1.0 {
        return SubtendedDirections::All;
    }
    let axis = to / d2.sqrt();
    if horizon.is_some_and(|n| axis.dot(n) <= -sin2.sqrt()) {
        return SubtendedDirections::None;
    }
    SubtendedDirections::Cone(SubtendedCone { axis, one_minus_cos: sin2 / (1.0 + (1.0 - sin2).sqrt()) })
}

impl PhotonAim {
    /// Creates an aim at `spheres`. If there are more than 32, neighbouring spheres are merged.
    ///
    /// Each sphere is expanded by the rounding errors of the positions inside.
    #[must_use]
    pub fn new(spheres: impl IntoIterator<Item = BoundingSphere>) -> Self {
        let mut spheres: Vec<BoundingSphere> = spheres.into_iter().collect();
        merge_neighbouring_spheres(&mut spheres, MAX_SPHERES);
        for sphere in &mut spheres {
            sphere.radius = sphere.radius * (1.0 + 1e-5) + sphere.center.abs().max_element() * 1e-6;
        }
        Self { spheres }
    }

    /// Samples a unit direction from `p` towards one of the spheres, by `u` in \[0, 1)². Returns
    /// the direction and its pdf \[1/sr].
    ///
    /// `horizon` is the unit normal of an emitting surface at `p`, or `None` if light leaves `p` in
    /// all directions. Spheres below the plane of this surface are not sampled. If a sphere
    /// contains `p`, all directions above the surface are sampled. Returns `None` if no sphere can
    /// be sampled, or if the pdf is 0.
    #[must_use]
    pub fn sample_direction(&self, p: Vec3, horizon: Option<Vec3>, u: Vec2) -> Option<(Vec3, f32)> {
        let mut cones = [SubtendedCone { axis: Vec3::Z, one_minus_cos: 0.0 }; MAX_SPHERES];
        let mut count = 0;
        let mut total = 0.0;
        for sphere in &self.spheres {
            match directions_to_sphere(sphere, p, horizon) {
                SubtendedDirections::Cone(cone) => {
                    total += cone.one_minus_cos;
                    cones[count] = cone;
                    count += 1;
                }
                SubtendedDirections::None => {}
                SubtendedDirections::All => return sample_sphere_or_hemisphere(horizon, u),
            }
        }
        let cones = &cones[..count];
        let (within, chosen) = locate_in_intervals(cones.iter().map(|cone| cone.one_minus_cos), u.x * total)?;
        let cone = &cones[chosen];
        let direction = Frame::from_normal(cone.axis)
            .to_world(warp::square_to_uniform_cone(Vec2::new(within, u.y), cone.one_minus_cos));
        // For unit vectors, |w − a|² = 2(1 − cos), which keeps its digits in narrow cones.
        let around = cones.iter().filter(|c| (direction - c.axis).length_squared() <= 2.0 * c.one_minus_cos);
        // The chosen cone contains the direction, even if rounding at its rim says otherwise.
        let count = around.count().max(1);
        Some((direction, count as f32 / (TAU * total)))
    }

    /// Samples the origin of a ray that travels along unit `direction` and enters one of the
    /// spheres, by `u` in \[0, 1)². Returns the origin and its pdf per area \[1/length²].
    ///
    /// All origins lie in one plane. It is perpendicular to `direction`, and lies at the distance
    /// `upstream` \[length] from the coordinate origin, on the side from which the light comes.
    /// Returns `None` if there are no spheres.
    #[must_use]
    pub fn sample_parallel_ray_start(&self, direction: Vec3, upstream: f32, u: Vec2) -> Option<(Vec3, f32)> {
        let areas = || self.spheres.iter().map(|s| PI * s.radius * s.radius);
        let total: f32 = areas().sum();
        let (within, chosen) = locate_in_intervals(areas(), u.x * total)?;
        let sphere = &self.spheres[chosen];
        let frame = Frame::from_normal(direction);
        let d = warp::square_to_uniform_disc(Vec2::new(within, u.y)) * sphere.radius;
        let p = sphere.center + frame.s * d.x + frame.t * d.y;
        let around = self.spheres.iter().filter(|s| (p - s.center).cross(direction).length() <= s.radius);
        let count = around.count().max(1);
        Some((p - direction * (upstream + direction.dot(p)), count as f32 / total))
    }
}

/// Finds the interval that contains the number `at` ≥ 0. The intervals adjoin each other and have
/// the given `widths`; the first starts at 0.
///
/// Returns the position of `at` in its interval, as a fraction in \[0, 1) of the interval's width,
/// and the index of the interval. An `at` beyond the last interval is moved to the end of this
/// interval. Returns `None` if there is no interval.
#[inline]
fn locate_in_intervals(widths: impl Iterator<Item = f32>, mut at: f32) -> Option<(f32, usize)> {
    let mut chosen = None;
    for (i, width) in widths.enumerate() {
        chosen = Some(((at / width).min(1.0 - f32::EPSILON), i));
        at -= width;
        if at < 0.0 {
            break;
        }
    }
    chosen
}

/// Samples a unit direction by `u` in \[0, 1)², and returns it with its pdf \[1/sr].
///
/// If `horizon` is a unit normal, the direction is cosine-weighted around it. If `horizon` is
/// `None`, the direction is uniform over the sphere. Returns `None` if the direction is
/// perpendicular to `horizon`, because the pdf is 0 there.
fn sample_sphere_or_hemisphere(horizon: Option<Vec3>, u: Vec2) -> Option<(Vec3, f32)> {
    match horizon {
        Some(n) => {
            let local = warp::square_to_cosine_hemisphere(u);
            (local.z > 0.0).then(|| (Frame::from_normal(n).to_world(local), warp::cosine_hemisphere_pdf(local.z)))
        }
        None => Some((warp::square_to_uniform_sphere(u), 1.0 / (2.0 * TAU))),
    }
}

/// Merges neighbouring spheres until at most `most` are left in `spheres`. A merged sphere bounds a
/// group of neighbours.
///
/// Groups are formed by repeated halving at the median along the axis of largest extent.
fn merge_neighbouring_spheres(spheres: &mut Vec<BoundingSphere>, most: usize) {
    if spheres.len() <= most {
        return;
    }
    let extent = Bounds::from_points(spheres.iter().map(|b| b.center)).extent();
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
    spheres.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let mut upper = spheres.split_off(spheres.len() / 2);
    if most > 1 {
        merge_neighbouring_spheres(spheres, most / 2);
        merge_neighbouring_spheres(&mut upper, most - most / 2);
        spheres.append(&mut upper);
    } else {
        spheres.append(&mut upper);
        *spheres = spheres.drain(..).reduce(BoundingSphere::union).into_iter().collect();
    }
}
