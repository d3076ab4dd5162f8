//! Rules for the two materials of a `Mix`.

use crate::format::error::SceneError;
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::parser::Parser;
use crate::format::language::text::clip_for_message;
use crate::format::span::Spanned;

/// Largest accepted nesting depth of mixes. Each level can double the number of materials in a mix.
const MAX_MIX_DEPTH: u8 = 8;

/// Returns the name of a material that a `Mix` refers to in `field`. Fails unless the text defines
/// this material before the mix.
pub(super) fn parse_mix_component<'a>(
    parser: &Parser<'a>,
    field: ParsedField<'_, 'a>,
) -> Result<Spanned<String>, SceneError> {
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
pub(super) fn check_mix_components<'a>(
    parser: &Parser<'a>,
    f: &BlockFields<'a>,
    first: &Spanned<String>,
    second: &Spanned<String>,
) -> Result<(), SceneError> {
    let scope = &parser.scope;
    for component in [&first, &second] {
        if scope.mix_constraints(component).mix_depth == MAX_MIX_DEPTH {
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
    // Otherwise, a path could enter one dielectric and leave the other. The first would stay on the
    // path's stack of bodies.
    if let (Some(a), Some(b)) =
        (scope.mix_constraints(first).dielectric_index, scope.mix_constraints(second).dielectric_index)
        && a != b
    {
        let message = "a mix cannot be two different Dielectrics".to_owned();
        let help = "mix a Dielectric with an opaque material, or with itself".to_owned();
        return Err(f.error_at(second.span, message, "the second body", help));
    }
    Ok(())
}
