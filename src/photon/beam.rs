//! Photon beams in participating media, and the map that finds beams near a camera ray.

use super::concatenation::concatenate;
use super::packet::{BeamPiece, BeamPiecePacket, LANES, LineQuery, indices_of_set_bits};
use crate::accel::BoxTree;
use crate::color::Rgb;
use crate::math::{Bounds, Ray, morton_order, rounding_error_bound};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A photon beam: a segment of a photon path in a homogeneous medium.
///
/// The beam starts where the photon entered the medium or scattered. It extends to the medium's
/// boundary along the photon's direction, beyond the sampled scattering point (long beam). In an
/// unbounded medium, it ends at optical depth 20, or outside the scene if that is nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonBeam {
    /// Position of the beam's start.
    pub start: Vec3,
    /// Unit direction in which the photon travels.
    pub direction: Vec3,
    /// Distance from start to end \[length].
    pub length: f32,
    /// Flux of the photon at the beam's start \[W].
    pub flux: Rgb,
    /// Index of the beam's medium in [`Scene::media`](crate::scene::Scene::media).
    pub medium: u32,
    /// Wavelength of the photon as [`Wavelength::byte_code`](crate::color::Wavelength::byte_code);
    /// 0 if it carries all wavelengths.
    pub wavelength_code: u8,
}

impl PhotonBeam {
    /// Creates a beam from its fields; `None` if a field is invalid.
    ///
    /// Start, end and flux must be finite. No channel of the flux may be negative, and one must be
    /// positive. `length` must be positive, and `direction` must not be zero.
    #[must_use]
    pub fn new(start: Vec3, direction: Vec3, length: f32, flux: Rgb, medium: u32, wavelength_code: u8) -> Option<Self> {
        let beam = Self { start, direction, length, flux, medium, wavelength_code };
        beam.is_valid().then_some(beam)
    }

    fn is_valid(&self) -> bool {
        let sum = self.flux.x + self.flux.y + self.flux.z;
        let flux = sum > 0.0 && sum.is_finite() && self.flux.min_element() >= 0.0;
        let end = self.start + self.direction * self.length;
        flux && self.length > 0.0 && self.direction != Vec3::ZERO && self.start.is_finite() && end.is_finite()
    }

    /// The point at distance `s` \[length] from the beam's start, in double precision.
    fn point_at(&self, s: f64) -> DVec3 {
        self.start.as_dvec3() + self.direction.as_dvec3() * s
    }
}

/// Closest approach of a camera ray and a photon beam, with the weight of the beam in the beam
/// estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamIntersection {
    /// Distance \[length] from the ray's origin to the point on the ray that is closest to the
    /// beam.
    pub t: f32,
    /// Distance \[length] from the beam's start to the point on the beam that is closest to the
    /// ray.
    pub s: f32,
    /// Cosine of the angle between the directions of ray and beam.
    pub cos: f32,
    /// Weight of the beam in the beam estimate, K₁(d)/sin θ \[1/length].
    ///
    /// K₁ is the 1D Epanechnikov kernel, d the distance between ray and beam, and θ the angle
    /// between them.
    pub weight: f32,
    /// Squared ratio d²/r² of the distance d between ray and beam to the kernel radius r.
    pub squared_relative_distance: f32,
}

/// Largest sine of the angle between a ray and a photon beam at which both count as parallel.
/// Smaller sines are rounding errors: each direction is off by up to half of this number.
const MIN_SINE: f64 = 2.0 * rounding_error_bound(4) as f64;

impl BeamIntersection {
    /// Returns the closest approach of `ray` and `beam`, for a kernel of radius `radius` \[length].
    ///
    /// `None` if the lines are parallel or at least `radius` apart. Also `None` if a closest point
    /// lies beyond an end of the ray or the beam.
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
        Some(Self {
            t: t as f32,
            s: s as f32,
            cos: d.dot(b) as f32,
            weight: weight as f32,
            squared_relative_distance: x2 as f32,
        })
    }
}

/// Photon beams in a bounding volume hierarchy, for the beam × beam estimate with a 1D kernel.
///
/// The radiance that arrives at the ray's origin is the sum, over the beams near the ray, of flux ·
/// σs · p(−cos) · T(ray, t) · T(beam, s) · weight. Here, σs is the scattering coefficient, p the
/// phase function of the cosine between the directions of travel before and after scattering, and T
/// the transmittance. `cos`, `t`, `s` and `weight` are the fields of [`BeamIntersection`] (Jarosz
/// et al. 2011, "A comprehensive theory of volumetric radiance estimation", section 4.3).
pub struct PhotonBeamMap {
    beams: Vec<PhotonBeam>,
    packets: Vec<BeamPiecePacket>,
    /// Hierarchy over the bounding boxes of `packets`.
    boxes: BoxTree,
    radius: f32,
}

/// Number of beams that one Rayon task handles.
const BEAMS_PER_TASK: usize = 4096;

/// Largest mean number of pieces per beam when [`PhotonBeamMap`] splits its beams. The limit bounds
/// the memory for the pieces.
const MAX_MEAN_BEAM_PIECES: f64 = 4.0;

impl PhotonBeamMap {
    /// Builds the map for beam estimates with a 1D kernel of radius `radius` \[length]. Beams for
    /// which [`PhotonBeam::new`] would return `None` are left out.
    ///
    /// The result does not depend on the number of threads.
    #[must_use]
    pub fn build(mut beams: Vec<PhotonBeam>, radius: f32) -> Self {
        if !beams.par_iter().with_min_len(BEAMS_PER_TASK).all(PhotonBeam::is_valid) {
            beams.retain(PhotonBeam::is_valid);
        }
        let radius = radius.max(0.0);
        let pieces = split_beams(&beams, optimal_beam_piece_length(&beams, radius));
        let beam = |piece: &BeamPiece| &beams[piece.beam as usize];
        let center = |p: &BeamPiece| beam(p).point_at(0.5 * (f64::from(p.from) + f64::from(p.to))).as_vec3();
        let order = morton_order(&pieces, center);
        let packet_and_bounds = |indices: &[u32]| {
            let pieces = || indices.iter().map(|i| pieces[*i as usize]);
            let bounds = pieces().fold(Bounds::EMPTY, |all, p| all.union(p.expanded_bounds(beam(&p), radius)));
            (BeamPiecePacket::new(pieces().map(|p| (p, beam(&p).start, beam(&p).direction))), bounds)
        };
        let (packets, bounds): (Vec<BeamPiecePacket>, Vec<Bounds>) =
            order.par_chunks(LANES).map(packet_and_bounds).unzip();
        Self { boxes: BoxTree::build(&bounds), beams, packets, radius }
    }

    /// Number of photon beams in the map.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len()
    }

    /// True if the map holds no beam.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// Radius of the 1D kernel of beam estimates \[length].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Calls `visitor` once for each beam that passes within the kernel radius of `ray`, with the
    /// beam and its closest approach to the ray.
    ///
    /// `ray` must have a unit direction. A beam is skipped if one of the two closest points lies
    /// beyond an end of the ray or of the beam.
    #[inline]
    pub fn visit_near_ray(&self, ray: &Ray, mut visitor: impl FnMut(&PhotonBeam, BeamIntersection)) {
        let query = LineQuery::new(ray, self.radius);
        self.boxes.visit_boxes_along_ray(ray, &mut |index| {
            let packet = &self.packets[index as usize];
            for slot in indices_of_set_bits(packet.beam_pieces_near_line(&query)) {
                let piece = packet.beam_piece_in_lane(slot);
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
    /// True if this piece of `beam` contains the beam's point at distance `s` \[length] from the
    /// beam's start.
    ///
    /// Each point of a beam is in exactly one piece.
    #[inline]
    fn contains(&self, s: f32, beam: &PhotonBeam) -> bool {
        s >= self.from && (s < self.to || self.to >= beam.length)
    }

    /// Bounding box of this piece of `beam`, expanded by `radius` \[length] and rounded outwards.
    fn expanded_bounds(&self, beam: &PhotonBeam, radius: f32) -> Bounds {
        let (a, b, r) = (beam.point_at(self.from.into()), beam.point_at(self.to.into()), f64::from(radius));
        let down = (a.min(b) - r).as_vec3().to_array().map(f32::next_down);
        let up = (a.max(b) + r).as_vec3().to_array().map(f32::next_up);
        Bounds { min: down.into(), max: up.into() }
    }
}

/// Splits each beam into pieces of equal length, because short pieces have small bounding boxes.
///
/// A beam of length L is split into ⌈L·g/`length`⌉ pieces. The factor g of [`sqrt_half_box_area`]
/// depends on the beam's direction. Along a coordinate axis, g = 0, and the beam stays whole,
/// because its box is thin. Along a space diagonal, g = 1, and the pieces are at most `length`
/// long.
fn split_beams(beams: &[PhotonBeam], length: f64) -> Vec<BeamPiece> {
    let pieces_of = |index: u32| {
        let beam = &beams[index as usize];
        let whole = beam.length;
        let count = (f64::from(whole) * sqrt_half_box_area(beam) / length).ceil().max(1.0) as u32;
        let at = move |k: u32| whole * (k as f32 / count as f32);
        (0..count).map(move |k| BeamPiece { beam: index, from: at(k), to: at(k + 1) })
    };
    let starts = (0..beams.len()).into_par_iter().step_by(BEAMS_PER_TASK);
    let chunk =
        |start: usize| (start as u32..beams.len().min(start + BEAMS_PER_TASK) as u32).flat_map(pieces_of).collect();
    let chunks: Vec<Vec<BeamPiece>> = starts.map(chunk).collect();
    concatenate(&chunks.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// Returns g = √(A/2), where A is the surface area of the bounding box of a unit-length segment of
/// the beam.
///
/// g ranges from 0 along a coordinate axis to 1 along a space diagonal. Let a beam of length L be
/// split into n pieces, whose boxes are expanded by r. Half the area of all boxes is then L²g²/n +
/// 12nr² + constant, which is least for n = Lg/(√12 r).
fn sqrt_half_box_area(beam: &PhotonBeam) -> f64 {
    let b = beam.direction.abs();
    f64::from(b.x * b.y + b.y * b.z + b.z * b.x).sqrt()
}

/// Returns the piece length for [`split_beams`] that minimises the total surface area of the
/// bounding boxes of all pieces.
///
/// `radius` is the kernel radius \[length], by which boxes are expanded. The mean number of pieces
/// per beam is at most [`MAX_MEAN_BEAM_PIECES`].
fn optimal_beam_piece_length(beams: &[PhotonBeam], radius: f32) -> f64 {
    let lengths = beams.par_iter().with_min_len(BEAMS_PER_TASK).map(|b| f64::from(b.length) * sqrt_half_box_area(b));
    // The sum is serial: its rounding depends on the order.
    let total: f64 = lengths.collect::<Vec<_>>().iter().sum();
    let most = (MAX_MEAN_BEAM_PIECES - 1.0) * beams.len().max(1) as f64;
    (12f64.sqrt() * f64::from(radius)).max(total / most).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
