//! Parses the names of textures, media and materials, which stand between keyword and `{`.

use super::lexer::Token;
use super::parser::Parser;
use super::text::{clip_for_message, is_identifier};
use crate::format::error::SceneError;
use crate::format::span::Spanned;

/// Parses the optional name between a block's keyword and its `{`; `None` if there is no name.
///
/// Error messages call the block `what`, such as "material".
pub(in crate::format) fn parse_block_name(
    parser: &mut Parser<'_>,
    what: &str,
) -> Result<Option<Spanned<String>>, SceneError> {
    let token = parser.lexer.peek_token();
    let name = match token.text {
        "" | "{" => return Ok(None),
        "\"" => parser.lexer.read_quoted_string()?,
        text => {
            parser.lexer.consume_token(token);
            Spanned::new(text.to_owned(), token.span())
        }
    };
    let shown = clip_for_message(&name.value);
    if token.text != "\"" && !is_identifier(token.text) {
        let message = format!("`{shown}` is not a plain name");
        let help = format!("put it in quotes, or open the block with `{{`: names start with a letter, not `{shown}`");
        return Err(parser.lexer.error_at(name.span, message, &format!("as a {what}'s name"), help));
    }
    if name.value.is_empty() {
        let help = "write a name, or leave the quotes out".to_owned();
        return Err(parser.lexer.error_at(name.span, format!("the {what}'s name is empty"), "empty", help));
    }
    Ok(Some(name))
}

/// Parses the mandatory name of a texture or medium. The caller has read the block's keyword
/// `word`.
///
/// Error messages use the nouns `one` and `many`, such as "medium" and "media".
///
/// # Errors
/// If there is no name, or if `is_taken` returns true for the name.
pub(in crate::format) fn parse_unique_block_name<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    (one, many): (&str, &str),
    is_taken: impl Fn(&Parser<'a>, &str) -> bool,
) -> Result<String, SceneError> {
    let Some(name) = parse_block_name(parser, one)? else {
        let message = format!("this `{}` has no name", word.text);
        let help = format!("name it, so that materials can use it: `{} name {{ … }}`", word.text);
        return Err(parser.lexer.error_at(word.span(), message, &format!("this {one}"), help));
    };
    if is_taken(parser, &name.value) {
        let message = format!("two {many} are called `{}`", clip_for_message(&name.value));
        return Err(parser.lexer.error_at(name.span, message, "the second", "give it another name".to_owned()));
    }
    Ok(name.value)
}
