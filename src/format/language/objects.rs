//! Groups, transforms and moving objects.

use std::fmt;

use super::super::description::{Group, GroupItem, ObjectDescription, Spanned};
use super::super::error::SceneError;
use super::lexer::Token;
use super::maps::{moving, transform, write_maps};
use super::materials::{material_by_index, material_by_name};
use super::reader::{Mark, Parser};
use super::schema::keywords;
use super::shapes::{SHAPES, shape, write_shape};
use super::writer::Writer;

/// Keywords of objects that hold objects.
const NESTING: [&str; 3] = ["Group", "Transform", "Moving"];

/// Keywords of the other entries of a group.
const ENTRIES: [&str; 3] = ["numObjects", "MaterialIndex", "MaterialName"];

/// Returns the keywords of all objects.
fn objects() -> Vec<&'static str> {
    keywords(&NESTING, &SHAPES)
}

/// Reads a `Group` block.
pub(super) fn group<'a>(parser: &mut Parser<'a>, keyword: Token<'a>) -> Result<Group, SceneError> {
    parser.descend(keyword)?;
    let mut items = Vec::new();
    let mut objects = 0;
    let mut count = None;
    while let Some(word) = parser.word()? {
        let mark = parser.mark();
        let error = match word.text {
            "numObjects" => parser.count(word, &mut count).err(),
            "MaterialIndex" => push(material_by_index(parser, word).map(GroupItem::MaterialIndex), &mut items),
            "MaterialName" => push(material_by_name(parser, word).map(GroupItem::MaterialName), &mut items),
            text if is_object(text) => {
                objects += 1;
                push(object(parser, word).map(GroupItem::Object), &mut items)
            }
            _ => Some(unexpected(parser, word)),
        };
        if let Some(error) = error {
            recover(parser, error, mark)?;
        }
    }
    parser.ascend();
    parser.check_count("numObjects", count, objects, "object")?;
    Ok(Group { items })
}

// The functions below are not inlined into `group`: it recurses, and its stack frame must stay
// small.

/// Appends an item; returns its error if it has one.
#[inline(never)]
fn push(item: Result<GroupItem, SceneError>, items: &mut Vec<GroupItem>) -> Option<SceneError> {
    match item {
        Ok(item) => {
            items.push(item);
            None
        }
        Err(error) => Some(error),
    }
}

/// Records `error` and continues with the next entry of the group that `mark` is in.
#[inline(never)]
fn recover(parser: &mut Parser<'_>, error: SceneError, mark: Mark) -> Result<(), SceneError> {
    parser.record(error)?;
    parser.skip(mark, &[&ENTRIES[..], &objects()].concat());
    Ok(())
}

#[inline(never)]
fn unexpected<'a>(parser: &Parser<'a>, word: Token<'a>) -> SceneError {
    parser.unexpected(word, &[&ENTRIES[..], &objects()].concat())
}

/// True if `word` is the keyword of an object.
fn is_object(word: &str) -> bool {
    NESTING.contains(&word) || SHAPES.iter().any(|entry| entry.block.is(word))
}

/// Reads an object into memory of its own, so that recursion keeps small frames on the stack.
fn boxed_object<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<Box<Spanned<ObjectDescription>>, SceneError> {
    object(parser, keyword).map(Box::new)
}

/// Reads an object.
fn object<'a>(parser: &mut Parser<'a>, keyword: Token<'a>) -> Result<Spanned<ObjectDescription>, SceneError> {
    let object = match keyword.text {
        "Group" => ObjectDescription::Group(group(parser, keyword)?),
        "Transform" => {
            let (maps, object) = transform(parser, keyword, &objects(), boxed_object)?;
            ObjectDescription::Transform { maps, object }
        }
        "Moving" => {
            let (maps, object) = moving(parser, keyword, &objects(), boxed_object)?;
            ObjectDescription::Moving { maps, object }
        }
        _ => {
            let (shape, emission) = shape(parser, keyword)?;
            ObjectDescription::Shape { shape, emission }
        }
    };
    Ok(Spanned::new(object, keyword.span()))
}

/// Prints a group.
pub(super) fn write_group(out: &mut Writer<'_, '_>, group: &Group) -> fmt::Result {
    out.open("Group")?;
    let objects = group.items.iter().filter(|item| matches!(item, GroupItem::Object(_))).count();
    out.line(format_args!("numObjects {objects}"))?;
    for item in &group.items {
        match item {
            GroupItem::MaterialIndex(index) => out.line(format_args!("MaterialIndex {}", index.value))?,
            GroupItem::MaterialName(name) => out.material_name(name)?,
            GroupItem::Object(object) => write_object(out, object)?,
        }
    }
    out.close()
}

fn write_object(out: &mut Writer<'_, '_>, object: &Spanned<ObjectDescription>) -> fmt::Result {
    match &object.value {
        ObjectDescription::Group(group) => write_group(out, group),
        ObjectDescription::Transform { maps, object } => write_placed(out, "Transform", maps, object),
        ObjectDescription::Moving { maps, object } => write_placed(out, "Moving", maps, object),
        ObjectDescription::Shape { shape, emission } => write_shape(out, shape, *emission),
    }
}

fn write_placed(
    out: &mut Writer<'_, '_>,
    keyword: &str,
    maps: &[super::super::description::TransformStep],
    object: &Spanned<ObjectDescription>,
) -> fmt::Result {
    out.open(keyword)?;
    write_maps(out, maps)?;
    write_object(out, object)?;
    out.close()
}
