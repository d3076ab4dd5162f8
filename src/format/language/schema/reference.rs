//! Language reference: describes blocks and their fields as Markdown.

use std::fmt::Write;

use super::block::BlockSchema;
use super::field::{FieldDefault, FieldKind, FieldSchema};

/// Returns the reference of `blocks` as Markdown: a list of blocks, then a table of their fields.
///
/// Each list of shared fields appears once, at the end of the table.
pub(in crate::format) fn reference_markdown(blocks: &[&'static BlockSchema]) -> String {
    let mut out = String::new();
    for block in blocks {
        let aliases: String = block.aliases.iter().map(|alias| format!(", `{alias}`")).collect();
        let course = if block.is_mit_6837_syntax { " **Course**" } else { "" };
        let _ = writeln!(out, "- `{}`{aliases}: {}.{course}", block.keyword, block.help);
    }
    out += "\n| block | field | value | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    for block in blocks {
        for (i, field) in block.all_own_fields().enumerate() {
            let name = if i == 0 { format!("`{}`", block.keyword) } else { String::new() };
            write_field_row(field, &name, &mut out);
        }
    }
    // A list of shared fields is identified by the name of its first field.
    let mut seen: Vec<&str> = Vec::new();
    for group in blocks.iter().flat_map(|block| block.all_shared_lists()) {
        if seen.contains(&group[0].keyword) {
            continue;
        }
        seen.push(group[0].keyword);
        let has = |block: &&&BlockSchema| block.all_shared_lists().any(|other| other[0].keyword == group[0].keyword);
        let users: Vec<&str> = blocks.iter().filter(has).map(|block| block.keyword).collect();
        let users = if users.len() == blocks.len() { "all".to_owned() } else { join_in_backticks(&users) };
        for (i, field) in group.iter().enumerate() {
            write_field_row(field, if i == 0 { &users } else { "" }, &mut out);
        }
    }
    out
}

/// Returns type, range and unit of the field's value in words, for the language reference.
fn describe_value(field: &FieldSchema) -> String {
    let noun = match field.kind {
        FieldKind::Point => "point",
        FieldKind::Direction => "direction",
        FieldKind::Color => "color",
        FieldKind::ColorOrTexture => "color or texture",
        FieldKind::Number => "number",
        FieldKind::NumberOrTexture => "number or texture",
        FieldKind::Pair => "two numbers",
        FieldKind::WholeNumber => "whole number",
        FieldKind::Name => "name or path",
        FieldKind::Word(words) => return join_in_backticks(words),
        FieldKind::Curve => "curve",
        FieldKind::Points => "`[ x y z ]` …",
        FieldKind::WeightedPoints => "`[ x y z ]` or `[ x y z w ]` …",
        FieldKind::NumberList => "numbers",
        FieldKind::TransformSteps => "`{ maps }`",
    };
    let unit = if field.unit.is_empty() { String::new() } else { format!(", {}", field.unit) };
    format!("{noun}{}{unit}", field.range.reference_text())
}

/// Returns the field's default in words, for the language reference.
fn describe_default(field: &FieldSchema) -> String {
    match field.default {
        FieldDefault::Required => "required".to_owned(),
        FieldDefault::Optional(meaning) => meaning.to_owned(),
        FieldDefault::Numbers(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
        FieldDefault::Word(word) => format!("`{word}`"),
    }
}

/// Appends the field's row of a Markdown table to `out`.
///
/// The first cell of the row is `blocks`, the names of blocks that have the field.
fn write_field_row(field: &FieldSchema, blocks: &str, out: &mut String) {
    let mut name = format!("`{}`", field.keyword);
    if !field.alias.is_empty() {
        let _ = write!(name, ", `{}`", field.alias);
    }
    let course = if field.is_mit_6837_syntax { " **Course**" } else { "" };
    let (value, default) = (describe_value(field), describe_default(field));
    let _ = writeln!(out, "| {blocks} | {name} | {value} | {default} | {}{course} |", field.help);
}

/// Puts each of `words` in backticks, and joins them with commas.
fn join_in_backticks(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}
