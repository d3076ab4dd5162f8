//! Photon beams and their intersections with camera rays.

use super::packet::{BeamPiece, BeamPiecePacket, LANES, LineQuery, set_bits};
use crate::accel::Boxes;
use crate::color::Rgb;
use crate::math::{Bounds, Ray, morton_order, rounding_error_bound};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A photon beam: the segment of a photon path through a medium.
///
/// The beam starts where the photon entered or scattered, and ends where the photon would leave the
/// medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonBeam {
    /// Start \[length].
    pub start: Vec3,
    /// Unit direction of travel.
    pub direction: Vec3,
    /// Length \[length].
    pub length: f32,
    /// Flux at the start \[W].
    pub flux: Rgb,
    /// Index of the medium.
    pub medium: u32,
    /// Wavelength code; 0 for all wavelengths.
    pub wavelength: u8,
}

impl PhotonBeam {
    /// A beam; `None` if it is invalid.
    ///
    /// A beam is invalid if a position or the flux is not finite, if the flux is zero or negative,
    /// or if length or direction is zero.
    #[must_use]
    pub fn new(start: Vec3, direction: Vec3, length: f32, flux: Rgb, medium: u32, wavelength: u8) -> Option<Self> {
        let beam = Self { start, direction, length, flux, medium, wavelength };
        beam.is_valid().then_some(beam)
    }

    fn is_valid(&self) -> bool {
        let sum = self.flux.x + self.flux.y + self.flux.z;
        let flux = sum > 0.0 && sum.is_finite() && self.flux.min_element() >= 0.0;
        let end = self.start + self.direction * self.length;
        flux && self.length > 0.0 && self.direction != Vec3::ZERO && self.start.is_finite() && end.is_finite()
    }

    /// The point at `s` along the beam.
    fn point_at(&self, s: f64) -> DVec3 {
        self.start.as_dvec3() + self.direction.as_dvec3() * s
    }
}

/// Closest approach of a ray and a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamIntersection {
    /// Distance along the ray.
    pub t: f32,
    /// Distance along the beam.
    pub s: f32,
    /// Cosine of the angle between the directions of ray and beam.
    pub cos: f32,
    /// K₁(d)/sin θ \[1/length]: the 1D kernel at the distance d of the lines, over the sine of
    /// their angle.
    pub weight: f32,
    /// Squared distance of the lines over the squared radius.
    pub x2: f32,
}

/// Sine below which two unit directions count as parallel. Each direction is rounded and normalised
/// in four operations.
const MIN_SINE: f64 = 2.0 * rounding_error_bound(4) as f64;

impl BeamIntersection {
    /// `None` if the lines are at least `radius` apart or parallel, or if the closest approach is
    /// outside a segment.
    #[inline]
    fn new(ray: &Ray, beam: &PhotonBeam, radius: f64) -> Option<Self> {
        let (d, b) = (ray.direction.as_dvec3(), beam.direction.as_dvec3());
        let between = beam.start.as_dvec3() - ray.origin.as_dvec3();
        let normal = d.cross(b);
        let sin2 = normal.length_squared();
        let height = between.dot(normal);
        if height * height >= radius * radius * sin2 || sin2 <= MIN_SINE * MIN_SINE {
            return None;
        }
        let (t, s) = (between.cross(b).dot(normal) / sin2, between.cross(d).dot(normal) / sin2);
        if !(t > 0.0 && t < f64::from(ray.t_max) && s > 0.0 && s < f64::from(beam.length)) {
            return None;
        }
        let x2 = height * height / (radius * radius * sin2);
        let weight = 0.75 * (1.0 - x2) / (radius * sin2.sqrt());
        Some(Self { t: t as f32, s: s as f32, cos: d.dot(b) as f32, weight: weight as f32, x2: x2 as f32 })
    }
}

/// Photon beams in a bounding volume hierarchy.
///
/// Beam × beam estimate with a 1D blur (Jarosz et al. 2011, "A comprehensive theory of volumetric
/// radiance estimation", section 4.3). Radiance towards the ray's origin is Σ flux · σs · p(cos) ·
/// T(ray, t) · T(beam, s) · weight.
pub struct PhotonBeamMap {
    beams: Vec<PhotonBeam>,
    packets: Vec<BeamPiecePacket>,
    /// Bounding boxes of the packets.
    boxes: Boxes,
    radius: f32,
}

/// Largest mean number of pieces per beam.
const MAX_PIECES: f64 = 4.0;

impl PhotonBeamMap {
    /// Builds the map for a blur of the given radius \[length], without invalid beams.
    ///
    /// The result does not depend on the number of threads.
    #[must_use]
    pub fn build(mut beams: Vec<PhotonBeam>, radius: f32) -> Self {
        beams.retain(PhotonBeam::is_valid);
        let radius = radius.max(0.0);
        let pieces = split_beams(&beams, optimal_piece_length(&beams, radius));
        let beam = |piece: &BeamPiece| &beams[piece.beam as usize];
        let center = |p: &BeamPiece| beam(p).point_at(0.5 * (f64::from(p.from) + f64::from(p.to))).as_vec3();
        let order = morton_order(&pieces, center);
        let run = |run: &[u32]| {
            let pieces = || run.iter().map(|i| pieces[*i as usize]);
            let bounds = pieces().fold(Bounds::EMPTY, |all, p| all.union(p.bounds(beam(&p), radius)));
            (BeamPiecePacket::new(pieces().map(|p| (p, beam(&p).start, beam(&p).direction))), bounds)
        };
        let (packets, bounds): (Vec<BeamPiecePacket>, Vec<Bounds>) = order.par_chunks(LANES).map(run).unzip();
        Self { boxes: Boxes::build(&bounds), beams, packets, radius }
    }

    /// Number of beams.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len()
    }

    /// True if the map is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// Radius of the blur \[length].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Visits every beam whose line passes within the radius of the ray, once per beam.
    ///
    /// The ray has a unit direction. The closest approach must lie within both segments. Allocates
    /// nothing.
    #[inline]
    pub fn visit(&self, ray: &Ray, mut visitor: impl FnMut(&PhotonBeam, BeamIntersection)) {
        let query = LineQuery::new(ray, self.radius);
        self.boxes.along(ray, &mut |index| {
            let packet = &self.packets[index as usize];
            for slot in set_bits(packet.pieces_near_line(&query)) {
                let piece = packet.piece_in_lane(slot);
                let beam = &self.beams[piece.beam as usize];
                if let Some(intersection) = BeamIntersection::new(ray, beam, f64::from(self.radius))
                    && piece.contains(intersection.s, beam)
                {
                    visitor(beam, intersection);
                }
            }
        });
    }
}

impl BeamPiece {
    /// True if the point at distance `s` belongs to this piece; each point belongs to exactly one.
    #[inline]
    fn contains(&self, s: f32, beam: &PhotonBeam) -> bool {
        s >= self.from && (s < self.to || self.to >= beam.length)
    }

    /// Bounding box grown by `radius`, rounded outwards.
    fn bounds(&self, beam: &PhotonBeam, radius: f32) -> Bounds {
        let (a, b, r) = (beam.point_at(self.from.into()), beam.point_at(self.to.into()), f64::from(radius));
        let down = (a.min(b) - r).as_vec3().to_array().map(f32::next_down);
        let up = (a.max(b) + r).as_vec3().to_array().map(f32::next_up);
        Bounds { min: down.into(), max: up.into() }
    }
}

/// Cuts beams into pieces; `length` applies to beams of box growth 1.
fn split_beams(beams: &[PhotonBeam], length: f64) -> Vec<BeamPiece> {
    let of = |(index, beam): (usize, &PhotonBeam)| {
        let (index, whole) = (index as u32, beam.length);
        let count = (f64::from(whole) * sqrt_half_box_area(beam) / length).ceil().max(1.0) as u32;
        let at = move |k: u32| whole * (k as f32 / count as f32);
        (0..count).map(move |k| BeamPiece { beam: index, from: at(k), to: at(k + 1) })
    };
    beams.par_iter().enumerate().flat_map_iter(of).collect()
}

/// Growth of the bounding box with the length of a beam: 0 along an axis, 1 along a diagonal of the
/// cube.
///
/// A beam of length L in n pieces has boxes of total area L² c/n + 12 n r² plus a constant, where c
/// is the square of the growth. The minimum is at n = L √c/(√12 r).
fn sqrt_half_box_area(beam: &PhotonBeam) -> f64 {
    let b = beam.direction.abs();
    f64::from(b.x * b.y + b.y * b.z + b.z * b.x).sqrt()
}

/// Length of pieces, for beams of box growth 1, that minimises the total box area within
/// [`MAX_PIECES`].
fn optimal_piece_length(beams: &[PhotonBeam], radius: f32) -> f64 {
    let total: f64 = beams.iter().map(|b| f64::from(b.length) * sqrt_half_box_area(b)).sum();
    let most = (MAX_PIECES - 1.0) * beams.len().max(1) as f64;
    (12f64.sqrt() * f64::from(radius)).max(total / most).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
