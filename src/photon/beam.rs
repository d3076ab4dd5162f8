//! Photon beams: where a ray through a medium passes the ways of photons.

use super::packet::{LANES, Piece, Pieces, Wanted, slots};
use crate::accel::Boxes;
use crate::color::Rgb;
use crate::math::{Bounds, Ray, gamma, morton_order};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A photon's way through a medium, from where it entered or scattered to where it left or would scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Start \[scene units].
    pub start: Vec3,
    /// Unit direction of travel.
    pub direction: Vec3,
    /// Length \[scene units].
    pub length: f32,
    /// Flux at the start \[W].
    pub flux: Rgb,
    /// Which medium it crosses.
    pub medium: u32,
    /// The code of its wavelength, 0 where it carries all.
    pub wavelength: u8,
}

impl Beam {
    /// `None` where a place or the flux is not finite, where the flux is zero or negative, or where the beam has no length or no
    /// direction: such beams carry nothing, or would poison an estimate.
    #[must_use]
    pub fn new(start: Vec3, direction: Vec3, length: f32, flux: Rgb, medium: u32, wavelength: u8) -> Option<Self> {
        let beam = Self { start, direction, length, flux, medium, wavelength };
        beam.is_sound().then_some(beam)
    }

    fn is_sound(&self) -> bool {
        let sum = self.flux.x + self.flux.y + self.flux.z;
        let flux = sum > 0.0 && sum.is_finite() && self.flux.min_element() >= 0.0;
        let end = self.start + self.direction * self.length;
        flux && self.length > 0.0 && self.direction != Vec3::ZERO && self.start.is_finite() && end.is_finite()
    }

    /// The point at `s` along the beam.
    fn at(&self, s: f64) -> DVec3 {
        self.start.as_dvec3() + self.direction.as_dvec3() * s
    }
}

/// Where a ray and a beam pass each other closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance along the ray.
    pub t: f32,
    /// Distance along the beam.
    pub s: f32,
    /// Cosine between the ray's direction and the beam's.
    pub cos: f32,
    /// K₁(d)/sin θ \[1/length]: a kernel of integral 1 over the distance of the lines, over the sine between them.
    pub weight: f32,
    /// Squared distance of the lines, in squares of the radius.
    pub x2: f32,
}

/// Sine below which two unit directions, each rounded and normalised in four operations, may be one.
const LEAST_SINE: f64 = 2.0 * gamma(4) as f64;

impl Crossing {
    /// `None` where the lines keep `radius` or more apart, pass outside of either segment, or are parallel.
    #[inline]
    fn of(ray: &Ray, beam: &Beam, radius: f64) -> Option<Self> {
        let (d, b) = (ray.direction.as_dvec3(), beam.direction.as_dvec3());
        let between = beam.start.as_dvec3() - ray.origin.as_dvec3();
        let normal = d.cross(b);
        let sin2 = normal.length_squared();
        let height = between.dot(normal);
        if height * height >= radius * radius * sin2 || sin2 <= LEAST_SINE * LEAST_SINE {
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

/// Beams that a ray can be asked for.
///
/// Beam × beam with a blur in one dimension (Jarosz et al. 2011, A comprehensive theory of volumetric radiance estimation,
/// section 4.3): radiance towards the ray's origin is Σ flux · σs · p(cos) · T(ray, t) · T(beam, s) · weight.
pub struct BeamMap {
    beams: Vec<Beam>,
    packets: Vec<Pieces>,
    /// Of the packets.
    boxes: Boxes,
    radius: f32,
}

/// Pieces per beam that the map may hold on average.
const MOST_PIECES: f64 = 4.0;

impl BeamMap {
    /// Indexes beams for a blur of the given radius. Those that [`Beam::new`] refuses are left out. The result does not depend on the
    /// number of threads.
    #[must_use]
    pub fn build(mut beams: Vec<Beam>, radius: f32) -> Self {
        beams.retain(Beam::is_sound);
        let radius = radius.max(0.0);
        let pieces = cut(&beams, piece_length(&beams, radius));
        let beam = |piece: &Piece| &beams[piece.beam as usize];
        let middle = |p: &Piece| beam(p).at(0.5 * (f64::from(p.from) + f64::from(p.to))).as_vec3();
        let order = morton_order(&pieces, middle);
        let run = |run: &[u32]| {
            let pieces = || run.iter().map(|i| pieces[*i as usize]);
            let bounds = pieces().fold(Bounds::EMPTY, |all, p| all.union(p.bounds(beam(&p), radius)));
            (Pieces::new(pieces().map(|p| (p, beam(&p).start, beam(&p).direction))), bounds)
        };
        let (packets, bounds): (Vec<Pieces>, Vec<Bounds>) = order.par_chunks(LANES).map(run).unzip();
        Self { boxes: Boxes::build(&bounds), beams, packets, radius }
    }

    /// How many beams are stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len()
    }

    /// Whether no beam is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// The radius of the blur \[scene units].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Visits every beam that passes the ray, of unit direction, closer than the radius at `0 < t < t_max`, once, where neither ends
    /// before. Allocates nothing.
    #[inline]
    pub fn visit(&self, ray: &Ray, mut visitor: impl FnMut(&Beam, Crossing)) {
        let wanted = Wanted::new(ray, self.radius);
        self.boxes.along(ray, &mut |index| {
            let packet = &self.packets[index as usize];
            for slot in slots(packet.near_line(&wanted)) {
                let piece = packet.piece(slot);
                let beam = &self.beams[piece.beam as usize];
                if let Some(crossing) = Crossing::of(ray, beam, f64::from(self.radius))
                    && piece.holds(crossing.s, beam)
                {
                    visitor(beam, crossing);
                }
            }
        });
    }
}

impl Piece {
    /// Whether a place along the beam counts for this piece: each does for exactly one.
    #[inline]
    fn holds(&self, s: f32, beam: &Beam) -> bool {
        s >= self.from && (s < self.to || self.to >= beam.length)
    }

    /// A box around all that is within `radius`, rounded outwards.
    fn bounds(&self, beam: &Beam, radius: f32) -> Bounds {
        let (a, b, r) = (beam.at(self.from.into()), beam.at(self.to.into()), f64::from(radius));
        let down = (a.min(b) - r).as_vec3().to_array().map(f32::next_down);
        let up = (a.max(b) + r).as_vec3().to_array().map(f32::next_up);
        Bounds { min: down.into(), max: up.into() }
    }
}

/// Cuts beams into pieces: of spread one, into such of the given length.
fn cut(beams: &[Beam], length: f64) -> Vec<Piece> {
    let of = |(index, beam): (usize, &Beam)| {
        let (index, whole) = (index as u32, beam.length);
        let count = (f64::from(whole) * spread(beam) / length).ceil().max(1.0) as u32;
        let at = move |k: u32| whole * (k as f32 / count as f32);
        (0..count).map(move |k| Piece { beam: index, from: at(k), to: at(k + 1) })
    };
    beams.par_iter().enumerate().flat_map_iter(of).collect()
}

/// How much the box of a beam outgrows the beam: zero along an axis, one along a diagonal of the cube.
///
/// A beam of length L cut into n pieces has boxes of total area L² c/n + n·12 r² + what does not depend on n, where c is the
/// square of this: least at n = L √c/(√12 r).
fn spread(beam: &Beam) -> f64 {
    let b = beam.direction.abs();
    f64::from(b.x * b.y + b.y * b.z + b.z * b.x).sqrt()
}

/// The length of pieces for beams of spread one that makes areas least, or that keeps to [`MOST_PIECES`]: again the least area,
/// now for a given number.
fn piece_length(beams: &[Beam], radius: f32) -> f64 {
    let total: f64 = beams.iter().map(|b| f64::from(b.length) * spread(b)).sum();
    let most = (MOST_PIECES - 1.0) * beams.len().max(1) as f64;
    (12f64.sqrt() * f64::from(radius)).max(total / most).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
