//! References to materials, by index and by name.

use crate::format::error::SceneError;
use crate::format::language::lexer::Token;
use crate::format::language::parser::Parser;
use crate::format::resolve::Resolver;
use crate::format::span::Spanned;

/// Parses the index of a material. The caller has read the word `MaterialIndex`.
pub(in crate::format) fn parse_material_index<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<Spanned<u32>, SceneError> {
    parser.scope.group_uses_materials = true;
    let index = parser.parse_integer(word)?;
    let count = parser.scope.materials.len();
    if (index.value as usize) < count {
        return Ok(index);
    }
    let message = format!("there is no material {}", index.value);
    let help = match count {
        0 => "no material stands before this line: put `Materials { … }` ahead of the Group".to_owned(),
        1 => "the one material is number 0".to_owned(),
        n => format!("materials are numbered from 0 to {}", n - 1),
    };
    Err(parser.lexer.error_at(index.span, message, "out of range", help))
}

/// Parses the name of a material. The caller has read the word `MaterialName`.
pub(in crate::format) fn parse_material_name<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<Spanned<String>, SceneError> {
    parser.scope.group_uses_materials = true;
    let name = parser.parse_name(word)?;
    let help = "name it ahead of the Group: `Materials { Diffuse name { … } }`";
    parser.scope.check_material_exists(parser.lexer, &name, help)?;
    Ok(name)
}

/// Returns the index of the material called `name`; an error if there is none.
pub(in crate::format) fn material_index(r: &Resolver<'_>, name: &Spanned<String>) -> Result<u32, SceneError> {
    r.material_indices.get(name.as_str()).copied().ok_or_else(|| {
        let message = format!("there is no material named `{}`", name.value);
        SceneError::error_at_span(r.source, name.span, message, "unknown name", "define it in Materials first")
    })
}
