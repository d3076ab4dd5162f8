//! The block `Plane` of the scene language: an infinite plane.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::color::Rgb;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{
    ObjectEmission, ObjectPlacement, set_emission_texture, set_texture_mapping_if_needed,
};
use crate::shape::{Plane, TextureMappingKind};
use glam::DVec3;

/// The infinite plane of all points x with normal · x = offset.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneDescription {
    /// Normal of the plane, of any length above 0.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along `normal`, times the length of `normal`.
    pub offset: f64,
}

field_table!(PlaneDescription {
    normal: field_schema("normal", FieldKind::Direction, "normal; its length scales `offset`")
        .make_required()
        .mark_as_mit_6837_syntax(),
    offset: field_schema("offset", FieldKind::Number, "normal · x of the points x of the plane")
        .make_required()
        .mark_as_mit_6837_syntax(),
});

impl ShapeBlock for PlaneDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Plane", "infinite plane")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_mit_6837_syntax();

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        if emission.radiance != Rgb::ZERO {
            let help = "use a Rectangle or a Disc, or give the plane a material without emission";
            return Err(r.error_at(placement.span, "an infinite plane cannot emit light", help));
        }
        let (normal, to_world) = (self.normal, placement.to_world);
        let point = normal * (self.offset / normal.length_squared());
        let plane = Plane::new(point, normal);
        if to_world.is_constant() {
            r.builder.add_plane(
                plane.transformed(&placement.to_world_at_open),
                r.current_material_index,
                emission.radiance,
            );
        } else {
            r.builder.add_moving_plane(plane, to_world.clone(), r.current_material_index, emission.radiance);
        }
        set_texture_mapping_if_needed(r, TextureMappingKind::plane_mapping(normal), to_world);
        set_emission_texture(r, emission);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
