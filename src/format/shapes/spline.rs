//! The blocks `BezierPatch` and `NurbsSurface`, and errors of spline surfaces.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldEntry, FieldGroup, FieldWithCheck, field_table};
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::schema::{
    BlockSchema, FieldKind, FieldList, FieldRange, FieldSchema, block_schema, field_schema,
};
use crate::format::language::writer::{SceneWriter, SpacedNumbers};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::format::span::Span;
use crate::shape::parametric_surface::{MAX_DEGREE, SplineBasis, SplineError};
use crate::shape::{Patch, Shape, TextureMappingKind};
use glam::DVec4;
use std::fmt;

/// Rational Bézier patches that have the same degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatchesDescription {
    /// Degrees along u and v, each from 1 to [`MAX_DEGREE`].
    pub degree: [u32; 2],
    /// Control points (x, y, z, weight): (degree u + 1) · (degree v + 1) for each patch. The index
    /// along v varies fastest. x, y and z are the point's position, not yet multiplied by the
    /// weight.
    pub controls: Vec<DVec4>,
}

/// A rational B-spline surface (NURBS).
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsDescription {
    /// Degrees along u and v, each from 1 to [`MAX_DEGREE`].
    pub degree: [u32; 2],
    /// Number of control points along u and v, each above the degree.
    pub control_counts: [u32; 2],
    /// Knots along u and v: count + degree + 1 nondecreasing numbers each, or an empty list for
    /// uniform knots.
    pub knots: [Vec<f64>; 2],
    /// Control points (x, y, z, weight); the index along v varies fastest. x, y and z are the
    /// point's position, not yet multiplied by the weight.
    pub controls: Vec<DVec4>,
}

const DEGREE_RANGE: FieldRange = FieldRange::ClosedInterval(1.0, MAX_DEGREE as f64);

const DEGREE_U: FieldSchema = field_schema("degreeU", FieldKind::WholeNumber, "degree along u")
    .with_range(DEGREE_RANGE)
    .with_default_numbers(&[3.0]);

const DEGREE_V: FieldSchema = field_schema("degreeV", FieldKind::WholeNumber, "degree along v")
    .with_range(DEGREE_RANGE)
    .with_default_numbers(&[3.0]);

/// Fields for the degrees along u and v of Bézier patches and NURBS surfaces.
const DEGREES: FieldGroup<[u32; 2]> = FieldGroup {
    list: FieldList::shared(&[DEGREE_U, DEGREE_V]),
    parse: |f| Ok([DEGREE_U.parse(f)?, DEGREE_V.parse(f)?]),
    write: |[u, v], out| {
        DEGREE_U.write(out, u)?;
        DEGREE_V.write(out, v)
    },
    texture_name: |_| None,
};

field_table!(BezierPatchesDescription {
    degree: DEGREES,
    controls: FieldWithCheck::new(
        field_schema("controls", FieldKind::WeightedPoints, "control points, patch after patch, those along v first")
            .make_required(),
        check_patch_controls,
    ),
});

impl ShapeBlock for BezierPatchesDescription {
    const BLOCK: &'static BlockSchema = &block_schema("BezierPatch", "one or more Bézier patches of the same degrees")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS]);

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        // Each patch is one shape.
        let span = placement.span;
        let [u, v] = self.degree.map(|d| SplineBasis::bezier_basis(d as usize + 1));
        let bases = [&u.map_err(|e| spline_error(r, span, &e))?, &v.map_err(|e| spline_error(r, span, &e))?];
        // The free memory is queried once, because a query takes longer than building a small
        // patch.
        let mut free = r.memory.available_bytes();
        for net in self.controls.chunks(bases[0].control_count() * bases[1].control_count()) {
            let patch = Patch::with_memory_limit(bases, net, free).map_err(|e| spline_error(r, span, &e))?;
            free = free.map(|free| free.saturating_sub(patch.memory_bytes()));
            add_shape_object(r, placement, Shape::Patch(patch), TextureMappingKind::Uv, emission)?;
        }
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

impl BlockCodec for NurbsDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let degree = DEGREES.parse(f)?;
        let parse_count = |name: &str, degree: u32| {
            let count: u32 = f.value_or_default(name)?;
            f.require_field(name)?.ensure_valid(count > degree, "must be above the degree")?;
            Ok(count)
        };
        let count = [parse_count("countU", degree[0])?, parse_count("countV", degree[1])?];
        let knot_count = |axis: usize| u64::from(count[axis]) + u64::from(degree[axis]) + 1;
        let knots = [parse_knots(f, "knotsU", knot_count(0))?, parse_knots(f, "knotsV", knot_count(1))?];
        let controls = f.require_field("controls")?;
        let (wanted, found) = (u64::from(count[0]) * u64::from(count[1]), controls.weighted_points().len() as u64);
        let rule = format!("must hold countU · countV = {wanted} points, and holds {found}");
        controls.ensure_valid(found == wanted, &rule)?;
        Ok(Self { degree, control_counts: count, knots, controls: controls.weighted_points().to_vec() })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        DEGREES.write(out, &self.degree)?;
        out.write_field("countU", self.control_counts[0])?;
        out.write_field("countV", self.control_counts[1])?;
        for (name, knots) in ["knotsU", "knotsV"].into_iter().zip(&self.knots).filter(|(_, k)| !k.is_empty()) {
            out.write_field(name, SpacedNumbers(knots))?;
        }
        out.write_weighted_points("controls", &self.controls)
    }
}

impl ShapeBlock for NurbsDescription {
    const BLOCK: &'static BlockSchema = &block_schema("NurbsSurface", "rational B-spline surface")
        .with_own_fields(&[
            field_schema("countU", FieldKind::WholeNumber, "number of control points along u")
                .with_range(FieldRange::DescribedOnly("above the degree"))
                .make_required(),
            field_schema("countV", FieldKind::WholeNumber, "number of control points along v")
                .with_range(FieldRange::DescribedOnly("above the degree"))
                .make_required(),
            field_schema("knotsU", FieldKind::NumberList, "`countU` + `degreeU` + 1 knots along u")
                .with_range(FieldRange::DescribedOnly("nondecreasing"))
                .make_optional("uniform"),
            field_schema("knotsV", FieldKind::NumberList, "`countV` + `degreeV` + 1 knots along v")
                .with_range(FieldRange::DescribedOnly("nondecreasing"))
                .make_optional("uniform"),
            field_schema("controls", FieldKind::WeightedPoints, "control points, those along v first").make_required(),
        ])
        .with_shared_fields(&[DEGREES.list.fields, EMISSION_FIELDS]);

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let basis = |i: usize| match (self.degree[i] as usize, self.control_counts[i] as usize) {
            (degree, count) if self.knots[i].is_empty() => SplineBasis::uniform_spline_basis(degree, count),
            (degree, count) => SplineBasis::new(degree, count, self.knots[i].clone()),
        };
        let surface = || Patch::with_memory_limit([&basis(0)?, &basis(1)?], &self.controls, r.memory.available_bytes());
        let surface = surface().map_err(|e| spline_error(r, placement.span, &e))?;
        add_shape_object(r, placement, Shape::Patch(surface), TextureMappingKind::Uv, emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

/// Fails unless `controls` holds the control points of one or more whole patches.
fn check_patch_controls(f: &BlockFields<'_>, controls: &ParsedField<'_, '_>) -> Result<(), SceneError> {
    let points_per_patch: usize = DEGREES.parse(f)?.iter().map(|degree| *degree as usize + 1).product();
    let found = controls.weighted_points().len();
    let rule = format!("must hold {points_per_patch} points for each patch of these degrees, and holds {found}");
    controls.ensure_valid(found > 0 && found.is_multiple_of(points_per_patch), &rule)
}

/// Returns the knots in the field `name`; an empty list if the field is absent.
///
/// # Errors
/// If the field does not hold exactly `wanted` knots, or if a knot is below the one before it.
fn parse_knots(f: &BlockFields<'_>, name: &str, wanted: u64) -> Result<Vec<f64>, SceneError> {
    let Some(knots) = f.get(name) else { return Ok(Vec::new()) };
    let list = knots.number_list();
    let rule = format!("must hold count + degree + 1 = {wanted} numbers, and holds {}", list.len());
    knots.ensure_valid(list.len() as u64 == wanted, &rule)?;
    knots.ensure_valid(list.windows(2).all(|w| w[0] <= w[1]), "must not decrease")?;
    Ok(list.to_vec())
}

/// Converts the error of a curve or surface to a scene error at `span`, with a remedy.
///
/// An exceeded memory limit is marked as out of memory.
pub(super) fn spline_error(r: &Resolver<'_>, span: Span, error: &SplineError) -> SceneError {
    if matches!(error, SplineError::MemoryLimitExceeded { .. }) {
        let help = "bend surfaces less, or let the scene have more memory (--memory)";
        return r.error_at(span, &error.to_string(), help).marked_out_of_memory();
    }
    let help = match error {
        SplineError::InvalidDegree(_) => "join curves of lower degree, or use a B-spline",
        SplineError::TooLarge => "choose units in which coordinates are below 1e100",
        SplineError::NarrowKnotSpan(_) => "give that knot and the next the same value, or part them further",
        SplineError::NoArea => "move control points off the axis and away from each other, or leave it out",
        _ => "give control points and knots that fit",
    };
    r.error_at(span, &error.to_string(), help)
}
