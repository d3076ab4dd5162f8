//! Reference intersections of rays with parametric surfaces, in f64, for tests of the solver.
//!
//! The surface is divided into quads. A quad is halved until two triangles approximate it within a
//! known error. Only the control points are shared with the solver.

use glam::{DVec2, DVec3, DVec4, Vec4Swizzles};

/// Surface of a reference piece: a Bézier patch, or a Bézier curve revolved about the y axis.
pub enum ReferenceSurface {
    /// Bézier patch: control points (x, y, z, weight), and the degrees along u and v.
    Patch(Vec<DVec4>, [usize; 2]),
    /// Control points (radius, height) of a Bézier profile; the parameter v is the azimuth in
    /// turns.
    Revolution(Vec<DVec2>),
}

/// Piece of a parametric surface, with bounds on its second derivatives: by u, by v, and mixed.
pub struct ReferencePiece {
    surface: ReferenceSurface,
    second_derivatives: [f64; 3],
}

/// A quad of the reference surface that the ray may hit, within the error bound.
pub struct QuadNearRay {
    /// Interval of the ray parameter t inside the quad's bounding box.
    pub t: [f64; 2],
    /// Absolute cosine of the angle between the ray and the quad's normal.
    pub cos: f64,
    /// True if the quad is at an edge of the surface piece.
    pub edge: bool,
}

/// Hits of one ray with a subdivided reference surface.
pub struct ReferenceHits {
    /// Ray parameter of the nearest hit of a triangle; `None` if the ray misses all triangles.
    pub hit: Option<f64>,
    /// Quads that the ray may hit.
    pub near_quads: Vec<QuadNearRay>,
}

/// Point of a Bézier curve at the parameter `s`; overwrites the control points.
fn de_casteljau<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>>(points: &mut [T], s: f64) -> T {
    for n in (1..points.len()).rev() {
        for i in 0..n {
            points[i] = points[i] * (1.0 - s) + points[i + 1] * s;
        }
    }
    points[0]
}

/// Bounds on the first and the second derivative of a Bézier patch along one parameter axis.
///
/// They are the largest n|Δb| and n(n − 1)|Δ²b| of its control points b, for the degree n.
fn derivative_bounds(points: &[DVec4], degree: [usize; 2], axis: usize) -> (DVec4, DVec4) {
    let columns = degree[1] + 1;
    let step = if axis == 0 { columns } else { 1 };
    let n = degree[axis] as f64;
    let inside = |i: usize, k: usize| if axis == 0 { i + k * step < points.len() } else { i % columns + k < columns };
    let (mut first, mut second) = (DVec4::ZERO, DVec4::ZERO);
    for i in 0..points.len() {
        if inside(i, 1) {
            first = first.max((points[i + step] - points[i]).abs() * n);
        }
        if inside(i, 2) {
            let d = points[i + 2 * step] - 2.0 * points[i + step] + points[i];
            second = second.max(d.abs() * n * (n - 1.0));
        }
    }
    (first, second)
}

impl ReferencePiece {
    /// Piece with bounds on its second derivatives, computed from the control points.
    pub fn new(surface: ReferenceSurface) -> Self {
        let second_derivatives = match &surface {
            ReferenceSurface::Revolution(profile) => {
                let flat: Vec<DVec4> = profile.iter().map(|p| DVec4::new(p.x, p.y, 0.0, 1.0)).collect();
                let (first, second) = derivative_bounds(&flat, [profile.len() - 1, 0], 0);
                let turn = std::f64::consts::TAU;
                let radius = profile.iter().fold(0.0, |r: f64, p| r.max(p.x.abs()));
                [second.xy().length(), radius * turn * turn, first.x * turn]
            }
            ReferenceSurface::Patch(controls, degree) => {
                // A patch is S = A/W with the weight W. From W·S″ = A″ − 2W′S′ − W″S follows a
                // bound on |S″|, and likewise for the mixed derivative.
                let homogeneous: Vec<DVec4> = controls.iter().map(|c| (c.xyz() * c.w).extend(c.w)).collect();
                let least = controls.iter().fold(f64::INFINITY, |m: f64, c| m.min(c.w));
                let far = controls.iter().fold(0.0, |m: f64, c| m.max(c.xyz().length()));
                let sides = [0, 1].map(|axis| derivative_bounds(&homogeneous, *degree, axis));
                let slopes = sides.map(|(first, _)| (first.xyz().length() + first.w * far) / least);
                let own = [0, 1].map(|i| {
                    let (first, second) = sides[i];
                    (second.xyz().length() + 2.0 * first.w * slopes[i] + second.w * far) / least
                });
                let columns = degree[1] + 1;
                let n = (degree[0] * degree[1]) as f64;
                let mixed = (0..controls.len()).filter(|i| i + columns < controls.len() && i % columns + 1 < columns);
                let twist = mixed.fold(DVec4::ZERO, |m, i| {
                    let d =
                        homogeneous[i] + homogeneous[i + columns + 1] - homogeneous[i + 1] - homogeneous[i + columns];
                    m.max(d.abs() * n)
                });
                let (w0, w1) = (sides[0].0.w, sides[1].0.w);
                let twist = (twist.xyz().length() + w0 * slopes[1] + w1 * slopes[0] + twist.w * far) / least;
                [own[0], own[1], twist]
            }
        };
        Self { surface, second_derivatives }
    }

    /// Object-space point at the parameters u and v in \[0, 1].
    pub fn point_at(&self, u: f64, v: f64) -> DVec3 {
        match &self.surface {
            ReferenceSurface::Revolution(profile) => {
                let mut buffer = [DVec2::ZERO; 25];
                buffer[..profile.len()].copy_from_slice(profile);
                let p = de_casteljau(&mut buffer[..profile.len()], u);
                let (sin, cos) = libm::sincos(v * std::f64::consts::TAU);
                DVec3::new(p.x * cos, p.y, p.x * sin)
            }
            ReferenceSurface::Patch(controls, [p, q]) => {
                let (mut rows, mut row) = ([DVec4::ZERO; 25], [DVec4::ZERO; 25]);
                for i in 0..=*p {
                    for j in 0..=*q {
                        let c = controls[i * (q + 1) + j];
                        row[j] = (c.xyz() * c.w).extend(c.w);
                    }
                    rows[i] = de_casteljau(&mut row[..=*q], v);
                }
                let a = de_casteljau(&mut rows[..=*p], u);
                a.xyz() / a.w
            }
        }
    }

    /// Subdivides the piece near the ray `o` + t·`d`, and adds to `found` each quad that the ray
    /// may hit.
    ///
    /// `error` is the largest distance between a quad and the surface. Also updates the nearest hit
    /// of `found`.
    pub fn find_quads_near_ray(&self, o: DVec3, d: DVec3, error: f64, found: &mut ReferenceHits) {
        let is_revolution = matches!(self.surface, ReferenceSurface::Revolution(_));
        let parts = if is_revolution { 4 } else { 1 };
        let quad = |[u0, u1, v0, v1]: [f64; 4]| {
            (
                [u0, u1, v0, v1],
                [self.point_at(u0, v0), self.point_at(u1, v0), self.point_at(u1, v1), self.point_at(u0, v1)],
            )
        };
        let part = |i: i32| quad([0.0, 1.0, f64::from(i) / f64::from(parts), f64::from(i + 1) / f64::from(parts)]);
        let mut quads: Vec<([f64; 4], [DVec3; 4])> = (0..parts).map(part).collect();
        let [uu, vv, uv] = self.second_derivatives;
        while let Some(([u0, u1, v0, v1], corners)) = quads.pop() {
            let (du, dv) = (u1 - u0, v1 - v0);
            // a + b bounds the distance between the surface and the bilinear quad through the
            // corners. c bounds the distance between that quad and two triangles.
            let [a, b, c] = [uu * du * du / 8.0, vv * dv * dv / 8.0, uv * du * dv / 4.0];
            let off = a + b + c;
            let min = corners.into_iter().fold(DVec3::INFINITY, DVec3::min) - off;
            let max = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max) + off;
            let (near, far) = ((min - o) / d, (max - o) / d);
            let (lo, hi) = (near.min(far).max_element(), near.max(far).min_element());
            if !(lo <= hi && hi > 0.0) {
                continue;
            }
            if off > error {
                let (u, v) = (0.5 * (u0 + u1), 0.5 * (v0 + v1));
                // Halve the quad along the parameter with the larger error term: a for u, b for v.
                // The term c needs no choice, because either halving halves it.
                let [p, q, r, s] = corners;
                if a > b || a == b && du > dv {
                    let (e, f) = (self.point_at(u, v0), self.point_at(u, v1));
                    quads.extend([([u0, u, v0, v1], [p, e, f, s]), ([u, u1, v0, v1], [e, q, r, f])]);
                } else {
                    let (e, f) = (self.point_at(u0, v), self.point_at(u1, v));
                    quads.extend([([u0, u1, v0, v], [p, q, f, e]), ([u0, u1, v, v1], [e, f, r, s])]);
                }
                continue;
            }
            let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or_zero();
            let edge = u0 == 0.0 || u1 == 1.0 || !is_revolution && (v0 == 0.0 || v1 == 1.0);
            found.near_quads.push(QuadNearRay { t: [lo, hi], cos: normal.dot(d).abs() / d.length(), edge });
            for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
                if let Some(t) = reference_triangle_hit(o, d, corners[i], corners[j], corners[k]) {
                    found.hit = Some(found.hit.map_or(t, |h: f64| h.min(t)));
                }
            }
        }
    }
}

/// Ray parameter of a hit of the triangle abc, edges included (Möller and Trumbore 1997).
fn reference_triangle_hit(o: DVec3, d: DVec3, a: DVec3, b: DVec3, c: DVec3) -> Option<f64> {
    let (e1, e2, s) = (b - a, c - a, o - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    let (x, q) = (s.dot(p) / determinant, s.cross(e1));
    let (y, t) = (d.dot(q) / determinant, e2.dot(q) / determinant);
    let slack = -1e-9;
    (x >= slack && y >= slack && x + y <= 1.0 - slack && t > 0.0).then_some(t)
}
