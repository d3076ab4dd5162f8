//! Tensor-product surfaces: Bézier patches, B-splines and NURBS.

use super::box_bvh::{BoxBvh, Line};
use super::patch_build::{PatchBuilder, PatchLeaf, SubdivisionCut, SubdivisionNode};
use super::patch_piece::PatchPiece;
use super::polynomial::Coefficient;
use super::root_finding::{GAUSS_LEGENDRE, PARAMETRIC_ERROR_FACTOR};
use super::spline::{SplineBasis, SplineError};
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform};
use crate::sampling::DiscreteDistribution;
use crate::shape::bounded_shape::BoundedShape;
use crate::shape::hit::round_t_if_in_range;
use crate::shape::object_ray::{ObjectRay, world_coordinate_bound};
use crate::shape::surface_point::{ShapeSample, SurfacePoint};
use crate::shape::texture_mapping::TexCoord;
use glam::{DVec2, DVec3, DVec4, Vec2, Vec3};
use std::sync::Arc;

/// Threshold for the length of ∂p/∂u × ∂p/∂v, relative to its length at the centre of the leaf. A
/// leaf is a nearly flat piece of the patch.
///
/// The cross product is shorter at poles and collapsed edges. The normal is then computed at a
/// point further inside the leaf.
const COLLAPSED_NORMAL_RATIO: f64 = 1e-7;

/// Tensor-product surface: the points Σ Bᵢ(u) Bⱼ(v) wᵢⱼ pᵢⱼ / Σ Bᵢ(u) Bⱼ(v) wᵢⱼ.
///
/// The pᵢⱼ are control points with weights wᵢⱼ, and u and v are in \[0, 1]. The outer side is the
/// side of ∂p/∂u × ∂p/∂v in object space. Transforms, even mirrors, keep the outer side outside.
#[derive(Clone, Debug)]
pub struct Patch {
    subdivided: Arc<SubdividedPatch>,
    /// Map from object space to world space. The bounding box of the control points is centred at
    /// the object-space origin.
    to_world: Transform,
    /// World-space area \[length²].
    area: f64,
}

/// Patch in object space, divided into nearly flat pieces, which are called leaves.
#[derive(Debug)]
struct SubdividedPatch {
    degree: [usize; 2],
    leaves: Vec<PatchLeaf>,
    /// Polynomial coefficients of all leaves, one leaf after another; [`PatchPiece`] defines them.
    coefficients: Vec<Coefficient<4>>,
    /// Parameter at the start of each knot span, along u and along v.
    knot_span_starts: [Vec<f64>; 2],
    /// Root of the subdivision tree of each Bézier patch.
    ///
    /// There is one Bézier patch per pair of knot spans; v varies fastest.
    subdivision_roots: Vec<SubdivisionNode>,
    /// Inner nodes of all subdivision trees.
    cuts: Vec<SubdivisionCut>,
    leaf_bvh: BoxBvh,
    /// Distribution that selects a leaf (a nearly flat piece) in proportion to its object-space
    /// area.
    leaf_distribution: DiscreteDistribution,
    /// Half the edge lengths of the object-space bounding box, whose centre is the origin.
    half_extent: DVec3,
    /// Radius of the bounding sphere around the object-space origin.
    bounding_radius: f64,
    /// Upper bound on the rounding error of a point that is computed from the leaves' polynomials
    /// \[object-space length].
    point_error_bound: f64,
    /// Estimated memory that the patch takes \[bytes].
    memory_bytes: u64,
}

impl Patch {
    /// Surface with control points (x, y, z, weight), row by row, so that v varies fastest.
    ///
    /// # Errors
    ///
    /// [`SplineError`] if the number of control points does not match the bases, a weight is not
    /// above 0, a value is too large, or the surface has no area.
    pub fn new(bases: [&SplineBasis; 2], controls: &[DVec4]) -> Result<Self, SplineError> {
        Self::with_memory_limit(bases, controls, None)
    }

    /// Creates a surface like [`Patch::new`], with at most `free` bytes of memory; `None` for no
    /// limit.
    ///
    /// # Errors
    ///
    /// Those of [`Patch::new`], and [`SplineError::MemoryLimitExceeded`] if the limit does not
    /// suffice.
    pub fn with_memory_limit(
        bases: [&SplineBasis; 2],
        controls: &[DVec4],
        free: Option<u64>,
    ) -> Result<Self, SplineError> {
        let [rows, columns] = bases.map(SplineBasis::control_count);
        if controls.len() != rows * columns {
            return Err(SplineError::WrongNetSize { controls: controls.len(), rows, columns });
        }
        if let Some(i) = controls.iter().position(|c| c.w.is_nan() || c.w <= 0.0) {
            return Err(SplineError::NonPositiveWeight(i));
        }
        let points: Vec<DVec3> = controls.iter().map(|c| c.truncate()).collect();
        if !points.iter().all(|p| p.abs().max_element() < 1e100) || !controls.iter().all(|c| c.w < 1e100) {
            return Err(SplineError::TooLarge);
        }
        let [min, max] = points.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], p| [a.min(*p), b.max(*p)]);
        let center = 0.5 * min + 0.5 * max;
        let max_weight = controls.iter().fold(0.0, |m: f64, c| m.max(c.w));
        let to_homogeneous =
            |(p, c): (&DVec3, &DVec4)| ((*p - center) * (c.w / max_weight)).extend(c.w / max_weight).to_array();
        let homogeneous: Vec<Coefficient<4>> = points.iter().zip(controls).map(to_homogeneous).collect();

        let mut builder = PatchBuilder::new(bases.map(SplineBasis::degree), free);
        for u in bases[0].knot_spans() {
            // Bézier pieces along u are computed first, for each column of the control net. Their
            // rows are then divided along v.
            let columns: Vec<Vec<Coefficient<4>>> =
                (0..columns).map(|j| bases[0].bezier_control_points(u, &homogeneous, (j, columns))).collect();
            for v in bases[1].knot_spans() {
                let mut piece = Vec::new();
                for i in 0..=bases[0].degree() {
                    let row: Vec<Coefficient<4>> = columns.iter().map(|c| c[i]).collect();
                    piece.extend(bases[1].bezier_control_points(v, &row, (0, 1)));
                }
                builder.add_bezier_patch(&piece, [u.range, v.range])?;
            }
        }
        let half = 0.5 * (max - min);
        let size = half.length();
        if size == 0.0 {
            return Err(SplineError::NoArea);
        }
        let [p, q] = bases.map(SplineBasis::degree);
        let noise = size * f64::EPSILON * (64 + 4 * (p * p + q * q)) as f64;
        let bytes = builder.memory_bytes();
        let PatchBuilder { leaves, coefficients: powers, subdivision_roots: roots, cuts, boxes, .. } = builder;
        let placeholder = DiscreteDistribution::new([1.0]).ok_or(SplineError::NoArea)?;
        let mut subdivided = SubdividedPatch {
            degree: [p, q],
            leaf_bvh: BoxBvh::new(&boxes, 4.0 * noise),
            leaf_distribution: placeholder,
            leaves,
            coefficients: powers,
            knot_span_starts: bases.map(|b| b.knot_spans().map(|s| s.range[0]).collect()),
            subdivision_roots: roots,
            cuts,
            half_extent: half,
            bounding_radius: size,
            point_error_bound: noise,
            memory_bytes: bytes,
        };
        let areas = (0..subdivided.leaves.len())
            .map(|i| leaf_area(&subdivided.polynomial_piece_of_leaf(i), &Transform::IDENTITY));
        subdivided.leaf_distribution = DiscreteDistribution::new(areas).ok_or(SplineError::NoArea)?;
        let area = subdivided.leaf_distribution.weight_sum();
        Ok(Self { subdivided: Arc::new(subdivided), to_world: Transform::IDENTITY.translated(center), area })
    }

    /// Estimated memory that the patch takes \[bytes].
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.subdivided.memory_bytes
    }

    /// Returns three values: the line of `ray` in object space, [`ObjectRay::distance_to_base`] and
    /// [`ObjectRay::direction_length`].
    ///
    /// `None` if the line misses the bounding sphere of the patch.
    fn object_line(&self, ray: &Ray) -> Option<(Line, f64, f64)> {
        let ObjectRay { base, direction, distance_to_base: start, direction_length: length } =
            ObjectRay::new(ray, &self.to_world);
        let size = self.subdivided.bounding_radius * (1.0 + 1e-9);
        (base.length_squared() <= size * size).then(|| (Line::new(base, direction), start, length))
    }

    /// World-space surface point of a leaf (a nearly flat piece) at the position `at` in \[−1, 1]².
    ///
    /// `uv` are the surface parameters that are stored in the result.
    fn surface_at(&self, leaf: usize, at: DVec2, uv: Vec2) -> SurfacePoint {
        let subdivided = &*self.subdivided;
        let [p, ..] = subdivided.polynomial_piece_of_leaf(leaf).point_and_derivatives(at);
        // The inverse transpose keeps the outer side of a mirror image.
        let normal = self.to_world.transform_normal(subdivided.leaf_normal(leaf, at)).normalize();
        let scale = world_coordinate_bound(&self.to_world, subdivided.bounding_radius);
        SurfacePoint {
            shape_coords: uv,
            ..SurfacePoint::from_f64(self.to_world.transform_point(p), normal, scale * PARAMETRIC_ERROR_FACTOR)
        }
    }
}

impl BoundedShape for Patch {
    fn transformed(&self, map: &Transform) -> Option<Self> {
        let to_world = Transform::new(*map.forward() * *self.to_world.forward()).ok()?;
        let subdivided = &self.subdivided;
        let area = match to_world.uniform_scale() {
            Some(scale) => scale * scale * subdivided.leaf_distribution.weight_sum(),
            None => (0..subdivided.leaves.len())
                .map(|i| leaf_area(&subdivided.polynomial_piece_of_leaf(i), &to_world))
                .sum(),
        };
        Some(Self { subdivided: Arc::clone(subdivided), to_world, area })
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (line, start, length) = self.object_line(ray)?;
        let subdivided = &*self.subdivided;
        let end = f64::from(ray.t_max) * length - start;
        let size = subdivided.bounding_radius * (1.0 + 1e-9);
        let mut found: Option<(usize, DVec2, f64)> = None;
        subdivided.leaf_bvh.visit_hit_leaves(&line, [(-start).max(-size), end.min(size)], |leaf, range| {
            if let Some(at) =
                subdivided.polynomial_piece_of_leaf(leaf).nearest_hit(&line, range, subdivided.bounding_radius)
            {
                found = Some((leaf, at, range[1]));
            }
        });
        let (leaf, at, t) = found?;
        let t = round_t_if_in_range(ray, (start + t) / length)?;
        let uv = subdivided.leaves[leaf].leaf_to_surface_uv(at);
        Some(ShapeHit { t, shape_coords: uv })
    }

    fn surface_point(&self, ray: &Ray, _t: f32, uv: Vec2) -> SurfacePoint {
        let (leaf, mut at) = self.subdivided.find_leaf(uv);
        if let Some((line, ..)) = self.object_line(ray) {
            // `uv` is rounded to f32, so the point may lie beside the ray. Newton steps move it
            // back onto the ray. `most` is the longest step that this rounding explains.
            let most = 2.0 * f64::from(f32::EPSILON) / self.subdivided.leaves[leaf].parameter_half_widths;
            for _ in 0..2 {
                let step = self.subdivided.polynomial_piece_of_leaf(leaf).newton_step_at(&line, at);
                if step.abs().cmple(most).all() {
                    at = (at + step).clamp(DVec2::NEG_ONE, DVec2::ONE);
                }
            }
        }
        self.surface_at(leaf, at, uv)
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..8 {
            let side = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let corner =
                self.to_world.transform_point(self.subdivided.half_extent * DVec3::new(side(0), side(1), side(2)));
            (min, max) = (min.min(corner), max.max(corner));
        }
        (min, max)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..self.clone() }
    }

    fn area(&self) -> f64 {
        self.area
    }

    /// Chooses a leaf (a nearly flat piece) with a probability proportional to its object-space
    /// area, then uniform parameters in that leaf.
    fn sample(&self, u: Vec2) -> ShapeSample {
        let subdivided = &*self.subdivided;
        let (leaf, _) = subdivided.leaf_distribution.sample(u.x);
        let at =
            DVec2::new(f64::from(subdivided.leaf_distribution.remapped_sample(u.x, leaf)), f64::from(u.y)) * 2.0 - 1.0;
        let uv = subdivided.leaves[leaf].leaf_to_surface_uv(at);
        let point = self.surface_at(leaf, at, uv);
        ShapeSample { pdf: self.pdf(&point), point, shape_coords: uv }
    }

    fn pdf(&self, seen: &SurfacePoint) -> f32 {
        let subdivided = &*self.subdivided;
        let (leaf, at) = subdivided.find_leaf(seen.shape_coords);
        let [_, along_x, along_y] = subdivided.polynomial_piece_of_leaf(leaf).point_and_derivatives(at);
        let element = self.to_world.transform_vector(along_x).cross(self.to_world.transform_vector(along_y)).length();
        (f64::from(subdivided.leaf_distribution.probability(leaf)) / (4.0 * element)) as f32
    }

    fn tex_coord(&self, _p: Vec3, uv: Vec2) -> TexCoord {
        let (leaf, at) = self.subdivided.find_leaf(uv);
        let [_, along_x, along_y] = self.subdivided.polynomial_piece_of_leaf(leaf).point_and_derivatives(at);
        let half = self.subdivided.leaves[leaf].parameter_half_widths;
        TexCoord::from_derivatives(
            uv,
            self.to_world.transform_vector(along_x / half.x),
            self.to_world.transform_vector(along_y / half.y),
        )
    }
}

#[cfg(test)]
impl Patch {
    /// World-space point at the surface parameters (u, v) = `uv`.
    pub(super) fn point_at_uv(&self, uv: Vec2) -> DVec3 {
        let (leaf, at) = self.subdivided.find_leaf(uv);
        self.to_world.transform_point(self.subdivided.polynomial_piece_of_leaf(leaf).point_and_derivatives(at)[0])
    }
}

impl SubdividedPatch {
    /// Returns leaf number `leaf`, a nearly flat piece of the surface, as polynomials that rays can
    /// intersect.
    fn polynomial_piece_of_leaf(&self, leaf: usize) -> PatchPiece<'_> {
        let [p, q] = self.degree;
        let room = (p + 1) * (q + 1);
        let powers = &self.coefficients[leaf * room..(leaf + 1) * room];
        let PatchLeaf { center_point: point, linear_terms: bounds, .. } = self.leaves[leaf];
        PatchPiece {
            coefficients: powers,
            center_point: point,
            columns: q + 1,
            linear_terms: bounds,
            point_error_bound: self.point_error_bound,
        }
    }

    /// Index of the leaf (nearly flat piece) that contains the surface parameters `uv`.
    ///
    /// Also returns the position of `uv` within the leaf, in \[−1, 1]².
    fn find_leaf(&self, uv: Vec2) -> (usize, DVec2) {
        let uv = uv.as_dvec2();
        let span = |axis: usize| self.knot_span_starts[axis].partition_point(|b| *b <= uv[axis]).saturating_sub(1);
        let mut branch = self.subdivision_roots[span(0) * self.knot_span_starts[1].len() + span(1)];
        loop {
            match branch {
                SubdivisionNode::Cut(cut) => {
                    let cut = &self.cuts[cut as usize];
                    branch = cut.children[usize::from(uv[cut.axis] >= cut.split_value)];
                }
                SubdivisionNode::Leaf(leaf) => {
                    let l = &self.leaves[leaf as usize];
                    return (
                        leaf as usize,
                        ((uv - l.parameter_center) / l.parameter_half_widths).clamp(DVec2::NEG_ONE, DVec2::ONE),
                    );
                }
            }
        }
    }

    /// Object-space normal ∂p/∂u × ∂p/∂v of a leaf (a nearly flat piece), not normalised.
    ///
    /// `at` is the position in the leaf, in \[−1, 1]². Where the cross product vanishes, the result
    /// is the cross product at a point further inside the leaf.
    fn leaf_normal(&self, leaf: usize, at: DVec2) -> DVec3 {
        let piece = self.polynomial_piece_of_leaf(leaf);
        let [_, middle_x, middle_y] = piece.point_and_derivatives(DVec2::ZERO);
        let least = COLLAPSED_NORMAL_RATIO * middle_x.cross(middle_y).length();
        let mut inward = 0.0;
        loop {
            let [_, along_x, along_y] = piece.point_and_derivatives(at * (1.0 - inward));
            let normal = along_x.cross(along_y);
            if normal.length() > least || inward > 0.9 {
                return if normal.length_squared() > 0.0 { normal } else { DVec3::Z };
            }
            inward = if inward == 0.0 { 1e-5 } else { 10.0 * inward };
        }
    }
}

/// World-space area of the piece `piece` under `to_world` \[length²], by Gauss–Legendre quadrature.
fn leaf_area(piece: &PatchPiece<'_>, to_world: &Transform) -> f64 {
    let element = |x: f64, y: f64| {
        let [_, along_x, along_y] = piece.point_and_derivatives(DVec2::new(x, y));
        to_world.transform_vector(along_x).cross(to_world.transform_vector(along_y)).length()
    };
    GAUSS_LEGENDRE.iter().flat_map(|(x, wx)| GAUSS_LEGENDRE.iter().map(move |(y, wy)| wx * wy * element(*x, *y))).sum()
}

#[cfg(test)]
mod tests;
