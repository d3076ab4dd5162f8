//! The block `Mix` of the scene language: a random mix of two materials.

use super::fields::UNIT_RANGE;
use super::{EnclosedBody, MaterialBlock, MaterialKindDescription};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::scope::MixConstraints;
use crate::format::language::text::clip_for_message;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::references::material_index;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;

/// Largest accepted nesting depth of mixes. Each level can double the number of materials in a mix.
pub(in crate::format) const MAX_MIX_DEPTH: u8 = 8;

/// Stochastic mix of two materials: wherever a ray hits the surface, one of them is chosen at
/// random.
#[derive(Clone, Debug, PartialEq)]
pub struct MixDescription {
    /// Name of the first material, which the scene file defines before the mix.
    pub first: Spanned<String>,
    /// Name of the second material, which the scene file defines before the mix.
    pub second: Spanned<String>,
    /// Probability of the second material, inside \[0, 1].
    pub second_probability: TexturedValue<f64>,
}

field_table!(MixDescription {
    first: field_schema("first", FieldKind::Name, "name of a material that stands before this one").make_required(),
    second: field_schema("second", FieldKind::Name, "name of a material that stands before this one").make_required(),
    second_probability: field_schema("amount", FieldKind::NumberOrTexture, "share of the second material")
        .with_range(UNIT_RANGE)
        .make_required(),
});

impl MaterialBlock for MixDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Mix", "one of two materials at each point, chosen at random")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn parse<'a>(parser: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        let first = parse_mix_component(parser, f.require_field("first")?)?;
        let second = parse_mix_component(parser, f.require_field("second")?)?;
        let amount = f.value_or_default("amount")?;
        check_mix_components(parser, f, &first, &second)?;
        Ok(Self { first, second, second_probability: amount })
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let (first, second) = (material_index(r, &self.first)?, material_index(r, &self.second)?);
        Ok(Material::mix(first, second, r.resolve_fraction_parameter(&self.second_probability, requirements)?))
    }
}

impl MixConstraints {
    /// Returns the properties that limit the use of a material in a mix. The material has the given
    /// kind and index.
    ///
    /// If the material is itself a mix, `constraints_by_name` looks up these properties of its
    /// components.
    pub(in crate::format) fn of_material(
        kind: &MaterialKindDescription,
        index: usize,
        constraints_by_name: impl Fn(&str) -> Self,
    ) -> Self {
        let Some(components) = kind.mix_material_names() else {
            return Self { dielectric_material_index: kind.bounds_dielectric().then_some(index), mix_depth: 0 };
        };
        let [a, b] = components.map(|name| constraints_by_name(&name.value));
        Self {
            dielectric_material_index: a.dielectric_material_index.or(b.dielectric_material_index),
            mix_depth: a.mix_depth.max(b.mix_depth) + 1,
        }
    }

    /// True if the material cannot be part of a mix, because it is a mix of the greatest depth.
    pub(in crate::format) fn is_deepest_mix(self) -> bool {
        self.mix_depth >= MAX_MIX_DEPTH
    }

    /// True if this material and the other one bound two different dielectric bodies.
    ///
    /// Two such materials cannot form a mix: a path could enter one dielectric and leave the other,
    /// and the first body would then stay on the path's stack of bodies.
    pub(in crate::format) fn has_other_dielectric_than(self, other: Self) -> bool {
        match (self.dielectric_material_index, other.dielectric_material_index) {
            (Some(a), Some(b)) => a != b,
            _ => false,
        }
    }
}

/// Returns the name in `field`, by which a `Mix` refers to one of its two materials. Fails unless
/// the text defines a material of this name before the mix.
fn parse_mix_component<'a>(parser: &Parser<'a>, field: ParsedField<'_, 'a>) -> Result<Spanned<String>, SceneError> {
    let name: Spanned<String> = field.value();
    let help = "a mix is made of materials that stand before it";
    parser.scope.check_material_exists(parser.lexer, &name, help)?;
    if parser.scope.material_indices.get(&name.value).is_some_and(|index| *index == parser.scope.materials.len()) {
        let message = format!("`{}` is a part of itself", clip_for_message(&name.value));
        let help = format!("name a material that stands before it as `{}`", field.name());
        return Err(parser.lexer.error_at(name.span, message, "this mix", help));
    }
    Ok(name)
}

/// Fails if a mix of the materials `first` and `second` is not allowed.
fn check_mix_components<'a>(
    parser: &Parser<'a>,
    f: &BlockFields<'a>,
    first: &Spanned<String>,
    second: &Spanned<String>,
) -> Result<(), SceneError> {
    let scope = &parser.scope;
    for component in [&first, &second] {
        if scope.mix_constraints(component).is_deepest_mix() {
            let message = format!("mixes nest more than {MAX_MIX_DEPTH} deep");
            let help = "mix fewer materials, or materials that are no mixes".to_owned();
            return Err(f.error_at(component.span, message, "the deepest that may be", help));
        }
        if scope.material_by_name(component).is_some_and(|material| material.is_null_interface) {
            let message = "a mix cannot be `Clear`, which has no surface".to_owned();
            let help = "mix a `Dielectric { indexOfRefraction 1 … }` of the same medium instead".to_owned();
            return Err(f.error_at(component.span, message, "no surface", help));
        }
    }
    if scope.mix_constraints(first).has_other_dielectric_than(scope.mix_constraints(second)) {
        let message = "a mix cannot be two different Dielectrics".to_owned();
        let help = "mix a Dielectric with an opaque material, or with itself".to_owned();
        return Err(f.error_at(second.span, message, "the second body", help));
    }
    Ok(())
}
