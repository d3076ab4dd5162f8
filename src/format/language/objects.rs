//! Parsing and writing of groups, transformed objects and moving objects.

use std::fmt;

use super::lexer::Token;
use super::parser::{Parser, SavedBlockNesting};
use super::schema::block_keywords;
use super::transforms::{parse_moving_block, parse_transform_block, write_transform_steps};
use super::writer::SceneWriter;
use crate::format::description::{GroupItem, ObjectDescription, ObjectGroup};
use crate::format::error::SceneError;
use crate::format::materials::{parse_material_index, parse_material_name};
use crate::format::shapes::{SHAPE_BLOCK_PARSERS, parse_shape, write_shape};
use crate::format::span::Spanned;
use crate::format::transform_step::TransformStep;

/// Keywords of objects that contain other objects.
const NESTING_OBJECT_KEYWORDS: [&str; 3] = ["Group", "Transform", "Moving"];

/// Keywords of a group's entries that are not objects.
const NON_OBJECT_ITEM_KEYWORDS: [&str; 3] = ["numObjects", "MaterialIndex", "MaterialName"];

fn object_keywords() -> Vec<&'static str> {
    block_keywords(&NESTING_OBJECT_KEYWORDS, SHAPE_BLOCK_PARSERS)
}

/// Parses a `Group` block. The caller has read its `keyword`.
pub(in crate::format) fn parse_group<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<ObjectGroup, SceneError> {
    parser.open_nested_block(keyword)?;
    let mut items = Vec::new();
    let mut objects = 0;
    let mut count = None;
    while let Some(word) = parser.next_word_or_close()? {
        let mark = parser.current_block_nesting();
        let error = match word.text {
            "numObjects" => parser.parse_count(word, &mut count).err(),
            "MaterialIndex" => {
                push_item_or_return_error(parse_material_index(parser, word).map(GroupItem::MaterialIndex), &mut items)
            }
            "MaterialName" => {
                push_item_or_return_error(parse_material_name(parser, word).map(GroupItem::MaterialName), &mut items)
            }
            text if is_object_keyword(text) => {
                objects += 1;
                push_item_or_return_error(parse_object(parser, word).map(GroupItem::Object), &mut items)
            }
            _ => Some(unexpected_item_error(parser, word)),
        };
        if let Some(error) = error {
            skip_to_next_item(parser, error, mark)?;
        }
    }
    parser.decrement_nesting_depth();
    parser.check_entry_count("numObjects", count, objects, "object")?;
    Ok(ObjectGroup { items })
}

// The functions below are not inlined into `parse_group`: it recurses, and its stack frame must
// stay small.

/// Appends the entry in `item` to `items` if it was parsed without an error. Otherwise appends
/// nothing and returns the error.
#[inline(never)]
fn push_item_or_return_error(item: Result<GroupItem, SceneError>, items: &mut Vec<GroupItem>) -> Option<SceneError> {
    match item {
        Ok(item) => {
            items.push(item);
            None
        }
        Err(error) => Some(error),
    }
}

/// Records `error`, and skips the rest of the group's entry that has this error.
///
/// `mark` is the block nesting that was saved before the entry was parsed. If the text ended inside
/// a block or the list of errors is full, records nothing and returns `Err(error)`.
#[inline(never)]
fn skip_to_next_item(parser: &mut Parser<'_>, error: SceneError, mark: SavedBlockNesting) -> Result<(), SceneError> {
    parser.record_error(error)?;
    parser.skip_to_next_entry(mark, &[&NON_OBJECT_ITEM_KEYWORDS[..], &object_keywords()].concat());
    Ok(())
}

#[inline(never)]
fn unexpected_item_error<'a>(parser: &Parser<'a>, word: Token<'a>) -> SceneError {
    parser.unexpected_word_error(word, &[&NON_OBJECT_ITEM_KEYWORDS[..], &object_keywords()].concat())
}

fn is_object_keyword(word: &str) -> bool {
    NESTING_OBJECT_KEYWORDS.contains(&word) || SHAPE_BLOCK_PARSERS.iter().any(|entry| entry.block.matches_keyword(word))
}

/// Parses an object and boxes it, so that stack frames of the recursive parser stay small.
fn parse_boxed_object<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<Box<Spanned<ObjectDescription>>, SceneError> {
    parse_object(parser, keyword).map(Box::new)
}

/// Parses an object. The caller has read its `keyword`.
fn parse_object<'a>(parser: &mut Parser<'a>, keyword: Token<'a>) -> Result<Spanned<ObjectDescription>, SceneError> {
    let object = match keyword.text {
        "Group" => ObjectDescription::Group(parse_group(parser, keyword)?),
        "Transform" => {
            let (steps, object) = parse_transform_block(parser, keyword, &object_keywords(), parse_boxed_object)?;
            ObjectDescription::Transform { steps, object }
        }
        "Moving" => {
            let (steps, object) = parse_moving_block(parser, keyword, &object_keywords(), parse_boxed_object)?;
            ObjectDescription::Moving { steps, object }
        }
        _ => {
            let (shape, emission) = parse_shape(parser, keyword)?;
            ObjectDescription::Shape { shape, emission }
        }
    };
    Ok(Spanned::new(object, keyword.span()))
}

/// Writes a group as scene text.
pub(in crate::format) fn write_group(out: &mut SceneWriter<'_, '_>, group: &ObjectGroup) -> fmt::Result {
    out.begin_block("Group")?;
    let objects = group.items.iter().filter(|item| matches!(item, GroupItem::Object(_))).count();
    out.write_line(format_args!("numObjects {objects}"))?;
    for item in &group.items {
        match item {
            GroupItem::MaterialIndex(index) => out.write_line(format_args!("MaterialIndex {}", index.value))?,
            GroupItem::MaterialName(name) => out.write_material_name(name)?,
            GroupItem::Object(object) => write_object(out, object)?,
        }
    }
    out.end_block()
}

fn write_object(out: &mut SceneWriter<'_, '_>, object: &Spanned<ObjectDescription>) -> fmt::Result {
    match &object.value {
        ObjectDescription::Group(group) => write_group(out, group),
        ObjectDescription::Transform { steps, object } => write_transformed_object(out, "Transform", steps, object),
        ObjectDescription::Moving { steps, object } => write_transformed_object(out, "Moving", steps, object),
        ObjectDescription::Shape { shape, emission } => write_shape(out, shape, *emission),
    }
}

fn write_transformed_object(
    out: &mut SceneWriter<'_, '_>,
    keyword: &str,
    steps: &[TransformStep],
    object: &Spanned<ObjectDescription>,
) -> fmt::Result {
    out.begin_block(keyword)?;
    write_transform_steps(out, steps)?;
    write_object(out, object)?;
    out.end_block()
}
