//! The block `RevSurface` of the scene language: a surface of revolution.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use super::spline::spline_error;
use crate::format::error::SceneError;
use crate::format::language::curves::{CurveBasis, ProfileCurve};
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::parametric_surface::{SplineBasis, SplineError};
use crate::shape::{Revolution, Shape, TextureMappingKind};
use glam::DVec2;

/// Surface of revolution: the points (x cos θ, y, x sin θ) for all points (x, y) of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct RevolutionDescription {
    /// Profile curve, which rotates about the y axis.
    pub profile: ProfileCurve,
}

field_table!(RevolutionDescription {
    profile: field_schema("profile", FieldKind::Curve, "curve of points (x, y), turned about the y axis")
        .make_required()
        .mark_as_mit_6837_syntax(),
});

impl ShapeBlock for RevolutionDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("RevSurface", "surface of revolution: the points (x cos θ, y, x sin θ) of a profile")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[EMISSION_FIELDS])
            .mark_as_mit_6837_syntax();

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let surface = make_revolution(&self.profile, r.memory.available_bytes());
        let surface = surface.map_err(|e| spline_error(r, placement.span, &e))?;
        add_shape_object(r, placement, Shape::Revolution(surface), TextureMappingKind::Uv, emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

/// Returns the surface of revolution of a profile curve.
///
/// Fails if the curve is invalid, or if the surface takes more than `free` bytes. A `free` of
/// `None` sets no limit.
fn make_revolution(profile: &ProfileCurve, free: Option<u64>) -> Result<Revolution, SplineError> {
    let basis = match profile.basis {
        CurveBasis::Bezier => SplineBasis::bezier_basis(profile.controls.len()),
        CurveBasis::Bspline => SplineBasis::uniform_spline_basis(3, profile.controls.len()),
    }?;
    let controls: Vec<DVec2> = profile.controls.iter().map(|c| c.truncate()).collect();
    Revolution::with_memory_limit(&basis, &controls, free)
}
