//! Round brilliants: 57 facets and the girdle, cut like a gemstone, plane by plane.

use std::f64::consts::{FRAC_PI_8, TAU};

use glam::{DVec2, DVec3};

use super::mesh::Mesh;

/// Tolkowsky's proportions (Diamond Design, 1919): angles of the main facets \[degrees] and the
/// table's radius over the girdle's.
const CROWN_DEGREES: f64 = 34.5;
const PAVILION_DEGREES: f64 = 40.75;
const TABLE_RADIUS: f64 = 0.53;
/// Half the girdle's height where the main facets touch it.
const GIRDLE: f64 = 0.03;
/// Extent of the star facets from the table's edge towards the girdle, and of the lower halves from
/// the girdle towards the axis.
const STAR_REACH: f64 = 0.5;
const LOWER_HALF_REACH: f64 = 0.77;
/// Numbers of sides of a round girdle and of a faceted one: multiples of 16, so that corners of the
/// outline lie where halves touch.
const ROUND_SIDES: usize = 96;
const FACETED_SIDES: usize = 16;

/// The half-space of points p with n · p ≤ d.
struct Plane {
    n: DVec3,
    d: f64,
}

impl Plane {
    /// Returns the plane through three points whose half-space contains the origin.
    fn through(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let n = (b - a).cross(c - a).normalize();
        let n = if n.dot(a) < 0.0 { -n } else { n };
        Self { n, d: n.dot(a) }
    }
}

/// Returns the stone with many sides: girdle of radius 1 about y = 0, table up.
pub fn gem() -> Mesh {
    cut("Round brilliant cut: 57 flat facets and a girdle of 96", ROUND_SIDES)
}

/// Returns the stone with few triangles and a girdle of flat facets.
pub fn brilliant() -> Mesh {
    cut("Brilliant cut: 57 flat facets and a girdle of 16", FACETED_SIDES)
}

fn cut(title: &'static str, sides: usize) -> Mesh {
    let mut mesh = Mesh::new(title, 9, 0);
    let planes = planes(sides);
    let mut known: Vec<(DVec3, usize)> = Vec::new();
    for (i, plane) in planes.iter().enumerate() {
        let others = planes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other);
        let mut face: Vec<usize> = Vec::new();
        for p in facet(plane, others) {
            // Facets that share a corner compute it up to rounding.
            let found = known.iter().find(|(q, _)| q.distance(p) < 1e-9).map(|(_, index)| *index);
            let index = found.unwrap_or_else(|| {
                let index = mesh.position(p);
                known.push((p, index));
                index
            });
            if !face.contains(&index) {
                face.push(index);
            }
        }
        mesh.flat_face(&face);
    }
    mesh
}

fn planes(sides: usize) -> Vec<Plane> {
    let at = |radius: f64, eighth: f64, y: f64| {
        let (sin, cos) = libm::sincos(eighth * 2.0 * FRAC_PI_8);
        DVec3::new(radius * cos, y, radius * sin)
    };
    let crown_slope = libm::tan(CROWN_DEGREES.to_radians());
    let pavilion_slope = libm::tan(PAVILION_DEGREES.to_radians());
    let table_height = GIRDLE + (1.0 - TABLE_RADIUS) * crown_slope;
    // Adjacent main facets touch half-way between their azimuths. The tips of stars and lower
    // halves lie there.
    let half_way = libm::cos(FRAC_PI_8);
    let star_radius = (1.0 - STAR_REACH) * TABLE_RADIUS * half_way + STAR_REACH;
    let star_height = GIRDLE + (1.0 - star_radius * half_way) * crown_slope;
    let lower_radius = 1.0 - LOWER_HALF_REACH;
    let lower_height = -GIRDLE - (1.0 - lower_radius * half_way) * pavilion_slope;

    let mut planes = vec![Plane { n: DVec3::Y, d: table_height }];
    for k in 0..8 {
        let k = f64::from(k);
        let star = at(star_radius, k + 0.5, star_height);
        let lower = at(lower_radius, k + 0.5, lower_height);
        let last_star = at(star_radius, k - 0.5, star_height);
        let last_lower = at(lower_radius, k - 0.5, lower_height);
        planes.push(Plane::through(at(1.0, k, GIRDLE), star, last_star));
        planes.push(Plane::through(at(1.0, k, -GIRDLE), lower, last_lower));
        planes.push(Plane::through(at(TABLE_RADIUS, k, table_height), at(TABLE_RADIUS, k + 1.0, table_height), star));
        for side in [k, k + 1.0] {
            planes.push(Plane::through(at(1.0, side, GIRDLE), at(1.0, k + 0.5, GIRDLE), star));
            planes.push(Plane::through(at(1.0, side, -GIRDLE), at(1.0, k + 0.5, -GIRDLE), lower));
        }
    }
    let step = TAU / sides as f64;
    planes.extend((0..sides).map(|k| {
        let (sin, cos) = libm::sincos((k as f64 + 0.5) * step);
        Plane { n: DVec3::new(cos, 0.0, sin), d: libm::cos(0.5 * step) }
    }));
    planes
}

/// Returns the convex polygon that the other planes leave of a plane, counterclockwise seen from
/// outside (Sutherland and Hodgman 1974).
fn facet<'a>(plane: &Plane, others: impl Iterator<Item = &'a Plane>) -> Vec<DVec3> {
    let (u, v) = plane.n.any_orthonormal_pair();
    let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
    let mut polygon: Vec<DVec3> = corners.map(|(a, b)| plane.n * plane.d + u * a + v * b).to_vec();
    for other in others {
        let mut kept = Vec::new();
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let inside = DVec2::new(other.d - other.n.dot(p), other.d - other.n.dot(q));
            if inside.x >= 0.0 {
                kept.push(p);
            }
            if inside.x.min(inside.y) < 0.0 && inside.x.max(inside.y) >= 0.0 {
                kept.push(p.lerp(q, inside.x / (inside.x - inside.y)));
            }
        }
        polygon = kept;
    }
    polygon
}
