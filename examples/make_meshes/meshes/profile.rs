//! Profiles in the half-plane (r, y), and the solids of revolution that they bound.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec2};

use super::mesh::Mesh;

/// A point of a profile.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Distance from the axis, and height.
    pub point: DVec2,
    /// Unit direction of travel.
    pub tangent: DVec2,
    /// Index of its `line_to`, `cubic_to` or `arc` in the profile, from 0.
    pub segment: usize,
}

/// A curve with the solid on its left: from the bottom outwards, up the outside, down the inside.
///
/// It is smooth inside a piece. A new piece starts at each corner and repeats the corner's point.
pub struct Profile {
    pieces: Vec<Vec<Sample>>,
    end: DVec2,
    segments: usize,
}

impl Profile {
    /// Starts a profile at (r, y).
    pub fn new(r: f64, y: f64) -> Self {
        Self { pieces: Vec::new(), end: dvec2(r, y), segments: 0 }
    }

    /// Appends a straight line in `steps` equal steps.
    pub fn line_to(self, r: f64, y: f64, steps: usize) -> Self {
        let (start, end) = (self.end, dvec2(r, y));
        self.extend(steps, |t| (start.lerp(end, t), end - start))
    }

    /// Appends a cubic Bézier curve with the inner control points `b` and `c`.
    pub fn cubic_to(self, b: DVec2, c: DVec2, d: DVec2, steps: usize) -> Self {
        let a = self.end;
        self.extend(steps, |t| {
            let s = 1.0 - t;
            let point = a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t);
            (point, (b - a) * (s * s) + (c - b) * (2.0 * s * t) + (d - c) * (t * t))
        })
    }

    /// Appends a circular arc about the center `c` by a signed angle \[rad], counterclockwise
    /// positive.
    pub fn arc(self, c: DVec2, angle: f64, steps: usize) -> Self {
        let start = self.end - c;
        self.extend(steps, |t| {
            let spoke = dvec2(libm::cos(angle * t), libm::sin(angle * t)).rotate(start);
            (c + spoke, spoke.perp() * angle)
        })
    }

    /// Returns the profile's current end and the unit direction there.
    pub fn end(&self) -> (DVec2, DVec2) {
        let tangent = self.pieces.last().and_then(|piece| piece.last()).map_or(DVec2::ZERO, |s| s.tangent);
        (self.end, tangent)
    }

    fn extend(mut self, steps: usize, curve: impl Fn(f64) -> (DVec2, DVec2)) -> Self {
        for step in 0..=steps {
            let (point, direction) = curve(step as f64 / steps as f64);
            let sample = Sample { point, tangent: direction.normalize(), segment: self.segments };
            match self.pieces.last_mut() {
                Some(piece) if step > 0 => piece.push(sample),
                // A segment in the same direction continues the piece and repeats its end.
                // Otherwise a corner starts a new piece.
                Some(piece) if piece.last().is_some_and(|s| s.tangent.dot(sample.tangent) > 1.0 - 1e-9) => {}
                _ => self.pieces.push(vec![sample]),
            }
            self.end = point;
        }
        self.segments += 1;
        self
    }

    /// Sweeps the profile around the y-axis in `around` steps. It must be closed, or start and end
    /// on the axis.
    pub fn revolve(&self, mesh: Mesh, around: usize) -> Mesh {
        self.revolve_with(mesh, around, |sample, angle| {
            let (sin, cos) = libm::sincos(angle);
            let (p, t) = (sample.point, sample.tangent);
            (DVec3::new(p.x * cos, p.y, p.x * sin), DVec3::new(t.y * cos, -t.x, t.y * sin))
        })
    }

    /// Sweeps the profile like [`Profile::revolve`]; `surface` returns position and outward normal
    /// at a sample and an angle.
    ///
    /// `surface` must keep samples on the axis there.
    pub fn revolve_with(
        &self,
        mut mesh: Mesh,
        around: usize,
        surface: impl Fn(&Sample, f64) -> (DVec3, DVec3),
    ) -> Mesh {
        let angle = |j: usize| TAU * (j % around) as f64 / around as f64;
        let on_axis = |sample: &Sample| sample.point.x.abs() < 1e-12;
        let ring = |sample: &Sample| if on_axis(sample) { 1 } else { around };
        let start = self.pieces[0][0];
        let closed = self.end.distance(start.point) < 1e-9;

        let add_positions = |mesh: &mut Mesh, sample: &Sample| -> Vec<usize> {
            (0..ring(sample)).map(|j| mesh.position(surface(sample, angle(j)).0)).collect()
        };
        let first = add_positions(&mut mesh, &start);
        let mut low = first.clone();
        for (number, piece) in self.pieces.iter().enumerate() {
            let mut low_normals = Vec::new();
            for (i, sample) in piece.iter().enumerate() {
                let normals: Vec<_> = (0..ring(sample)).map(|j| mesh.normal(surface(sample, angle(j)).1)).collect();
                if i > 0 {
                    let is_end = number + 1 == self.pieces.len() && i + 1 == piece.len();
                    let high = if is_end && closed { first.clone() } else { add_positions(&mut mesh, sample) };
                    let at = |ring: &[usize], normals: &[usize], j: usize| {
                        (ring[j % ring.len()], normals[j % normals.len()])
                    };
                    for j in 0..around {
                        let (a, b) = (at(&low, &low_normals, j), at(&high, &normals, j));
                        let (c, d) = (at(&high, &normals, j + 1), at(&low, &low_normals, j + 1));
                        match (low.len(), high.len()) {
                            (1, _) => mesh.smooth_face(&[a, b, c]),
                            (_, 1) => mesh.smooth_face(&[a, b, d]),
                            _ => mesh.smooth_face(&[a, b, c, d]),
                        }
                    }
                    low = high;
                }
                low_normals = normals;
            }
        }
        mesh
    }
}
