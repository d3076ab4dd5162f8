//! Parsing and writing of transform steps, and of `Transform` and `Moving` blocks.

use std::fmt;

use glam::{DMat4, DVec3};

use super::lexer::Token;
use super::parser::Parser;
use super::text::{clip_for_message, is_normalizable};
use super::writer::{SceneWriter, SpacedNumbers};
use crate::format::error::SceneError;
use crate::format::span::Span;
use crate::format::transform_step::TransformStep;
use crate::math::Transform;

/// Keywords of transform steps.
const STEP_KEYWORDS: [&str; 9] =
    ["Scale", "UniformScale", "Translate", "XRotate", "YRotate", "ZRotate", "Rotate", "Matrix4f", "Matrix"];

/// Function that parses an object, light or camera whose keyword is already read. The second
/// argument is this keyword.
type ParseObject<'a, T> = fn(&mut Parser<'a>, Token<'a>) -> Result<T, SceneError>;

/// Parses a `Transform` block: transform steps, then one object. Returns the steps and the object.
///
/// `parse_object` parses the object after its keyword, which must be in `allowed`. Fails if the
/// product of the steps is singular.
pub(in crate::format) fn parse_transform_block<'a, T>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    allowed: &[&str],
    parse_object: ParseObject<'a, T>,
) -> Result<(Vec<TransformStep>, T), SceneError> {
    let (steps, object) = parse_steps_and_object(parser, keyword, allowed, parse_object)?;
    check_not_singular(parser, keyword, &steps)?;
    Ok((steps, object))
}

/// Parses a `Moving` block: the steps of a motion, then the object, light or camera that moves.
/// Returns the steps and the object, light or camera.
///
/// `parse_object` parses the object, light or camera after its keyword, which must be in `allowed`.
/// Fails if a step cannot be animated.
pub(in crate::format) fn parse_moving_block<'a, T>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    allowed: &[&str],
    parse_object: ParseObject<'a, T>,
) -> Result<(Vec<TransformStep>, T), SceneError> {
    let (steps, object) = parse_steps_and_object(parser, keyword, allowed, parse_object)?;
    check_motion_steps(parser, keyword, &steps)?;
    Ok((steps, object))
}

/// Parses `{ … }` with transform steps, then one object, light or camera. Returns the steps and the
/// object, light or camera.
///
/// `parse_object` parses the object, light or camera after its keyword, which must be in `allowed`.
fn parse_steps_and_object<'a, T>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    allowed: &[&str],
    parse_object: ParseObject<'a, T>,
) -> Result<(Vec<TransformStep>, T), SceneError> {
    parser.open_nested_block(keyword)?;
    let mut steps = Vec::new();
    let word = parse_steps_before_object(parser, keyword, allowed, &mut steps)?;
    let object = parse_object(parser, word)?;
    close_transform(parser, keyword)?;
    Ok((steps, object))
}

// The functions below are not inlined into `parse_steps_and_object`: it recurses, and its stack
// frame must stay small.

/// Parses transform steps and appends them to `steps`. Returns the first word after them, which
/// must be in `allowed`.
#[inline(never)]
fn parse_steps_before_object<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    allowed: &[&str],
    steps: &mut Vec<TransformStep>,
) -> Result<Token<'a>, SceneError> {
    let name = keyword.text;
    loop {
        match parser.next_word_or_close()? {
            None => {
                let allows_shapes = allowed.contains(&"Sphere");
                let what = if allows_shapes { "object" } else { "camera or light" };
                let message = format!("`{name}` holds no {what}");
                let example = if allows_shapes { "Sphere" } else { allowed[allowed.len() - 1] };
                let help = format!("put one after its maps: `{name} {{ Translate 2 2 2 {example} {{ … }} }}`");
                return Err(parser.lexer.error_at(keyword.span(), message, "this block", help));
            }
            Some(word) if STEP_KEYWORDS.contains(&word.text) => steps.push(parse_transform_step(parser, word)?),
            Some(word) if allowed.contains(&word.text) => return Ok(word),
            Some(word) => return Err(parser.unexpected_word_error(word, &[&STEP_KEYWORDS[..], allowed].concat())),
        }
    }
}

/// Parses the `{ … }` after `keyword`, which holds only transform steps. Fails if their product is
/// singular.
pub(in crate::format) fn parse_transform_steps<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<Vec<TransformStep>, SceneError> {
    let mut steps = Vec::new();
    parser.open_block(keyword)?;
    while let Some(word) = parser.next_word_or_close()? {
        if !STEP_KEYWORDS.contains(&word.text) {
            return Err(parser.unexpected_word_error(word, &STEP_KEYWORDS));
        }
        steps.push(parse_transform_step(parser, word)?);
    }
    check_not_singular(parser, keyword, &steps)?;
    Ok(steps)
}

/// Parses the `}` after the object of a `Transform` or `Moving` block.
#[inline(never)]
fn close_transform<'a>(parser: &mut Parser<'a>, keyword: Token<'a>) -> Result<(), SceneError> {
    if let Some(word) = parser.next_word_or_close()? {
        let message = format!("unexpected `{}` after the object of `{}`", clip_for_message(word.text), keyword.text);
        let help = "maps stand before the object; put several objects into a Group".to_owned();
        return Err(parser.lexer.error_at(word.span(), message, "`}` belongs here", help));
    }
    parser.decrement_nesting_depth();
    Ok(())
}

/// Fails if the product of `steps` is singular.
#[inline(never)]
fn check_not_singular<'a>(parser: &Parser<'a>, keyword: Token<'a>, steps: &[TransformStep]) -> Result<(), SceneError> {
    match Transform::new(TransformStep::composed_matrix(steps)) {
        Ok(_) => Ok(()),
        Err(_) => Err(singular_transform_error(parser, keyword.span(), "this `Transform` flattens its object")),
    }
}

/// Fails if one of `steps` cannot be animated: a matrix, or a scale of 0 or below.
#[inline(never)]
fn check_motion_steps<'a>(parser: &Parser<'a>, keyword: Token<'a>, steps: &[TransformStep]) -> Result<(), SceneError> {
    const FLAT_SCALE_ERROR: (&str, &str) =
        ("a scale of 0 or below", "a motion cannot go through flat: scale by more than 0");
    for step in steps {
        let (what, help) = match *step {
            TransformStep::Matrix(_) => {
                ("a matrix", "write Translate, Rotate and Scale instead, or put it into a Transform inside")
            }
            TransformStep::Scale(s) if s.min_element() <= 0.0 => FLAT_SCALE_ERROR,
            TransformStep::UniformScale(s) if s <= 0.0 => FLAT_SCALE_ERROR,
            TransformStep::Scale(_)
            | TransformStep::UniformScale(_)
            | TransformStep::Translate(_)
            | TransformStep::RotateX(_)
            | TransformStep::RotateY(_)
            | TransformStep::RotateZ(_)
            | TransformStep::Rotate { .. } => continue,
        };
        let message = format!("`{}` cannot grow by {what}", keyword.text);
        return Err(parser.lexer.error_at(keyword.span(), message, "this motion", help.to_owned()));
    }
    Ok(())
}

/// Parses the numbers of a transform step. The caller has read its keyword `word`.
#[inline(never)]
fn parse_transform_step<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<TransformStep, SceneError> {
    let (step, span) = match word.text {
        "Scale" | "Translate" => {
            let v = parser.parse_numbers(word)?;
            let vector = DVec3::from_array(v.value);
            (if word.text == "Scale" { TransformStep::Scale(vector) } else { TransformStep::Translate(vector) }, v.span)
        }
        "Rotate" => {
            parser.open_block(word)?;
            let v = parser.parse_numbers::<4>(word)?;
            let [x, y, z, angle] = v.value;
            let axis = DVec3::new(x, y, z);
            parser.close_block()?;
            if !is_normalizable(axis) {
                let message = "the axis of `Rotate` must have a length above 0 (and below 1e154)".to_owned();
                let help = "write axis and degrees: `Rotate { 0 1 0 90 }`".to_owned();
                return Err(parser.lexer.error_at(v.span, message, "this axis", help));
            }
            (TransformStep::Rotate { axis, angle }, v.span)
        }
        "Matrix4f" | "Matrix" => {
            parser.open_block(word)?;
            let m = parser.parse_numbers::<16>(word)?;
            parser.close_block()?;
            let matrix = DMat4::from_cols_array(&m.value);
            if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
                let message = format!("the fourth row of `{}` must be 0 0 0 1", word.text);
                let help = "columns are listed one after the other: every fourth number is 0, the last is 1";
                return Err(parser.lexer.error_at(m.span, message, "this matrix", help.to_owned()));
            }
            (TransformStep::Matrix(matrix), m.span)
        }
        "XRotate" | "YRotate" | "ZRotate" | "UniformScale" => {
            let v = parser.parse_numbers::<1>(word)?;
            let step = match (word.text, v.value[0]) {
                ("XRotate", angle) => TransformStep::RotateX(angle),
                ("YRotate", angle) => TransformStep::RotateY(angle),
                ("ZRotate", angle) => TransformStep::RotateZ(angle),
                (_, scale) => TransformStep::UniformScale(scale),
            };
            (step, v.span)
        }
        _ => return Err(parser.unexpected_word_error(word, &STEP_KEYWORDS)),
    };
    match Transform::new(step.matrix()) {
        Ok(_) => Ok(step),
        Err(_) => Err(singular_transform_error(parser, span, &format!("`{}` flattens its object", word.text))),
    }
}

fn singular_transform_error(parser: &Parser<'_>, span: Span, message: &str) -> SceneError {
    let help = "scales must not be 0, nor the columns of a matrix lie in one plane; for flat shapes use Disc, \
                Rectangle or Triangle";
    parser.lexer.error_at(span, message.to_owned(), "singular", help.to_owned())
}

/// Writes transform steps, one on each line.
pub(in crate::format) fn write_transform_steps(out: &mut SceneWriter<'_, '_>, steps: &[TransformStep]) -> fmt::Result {
    steps.iter().try_for_each(|step| match *step {
        TransformStep::Scale(s) => out.write_line(format_args!("Scale {}", SpacedNumbers(&s.to_array()))),
        TransformStep::UniformScale(s) => out.write_line(format_args!("UniformScale {}", SpacedNumbers(&[s]))),
        TransformStep::Translate(t) => out.write_line(format_args!("Translate {}", SpacedNumbers(&t.to_array()))),
        TransformStep::RotateX(angle) => out.write_line(format_args!("XRotate {}", SpacedNumbers(&[angle]))),
        TransformStep::RotateY(angle) => out.write_line(format_args!("YRotate {}", SpacedNumbers(&[angle]))),
        TransformStep::RotateZ(angle) => out.write_line(format_args!("ZRotate {}", SpacedNumbers(&[angle]))),
        TransformStep::Rotate { axis, angle } => {
            out.write_line(format_args!("Rotate {{ {} }}", SpacedNumbers(&[axis.x, axis.y, axis.z, angle])))
        }
        TransformStep::Matrix(m) => {
            out.write_line(format_args!("Matrix4f {{ {} }}", SpacedNumbers(&m.to_cols_array())))
        }
    })
}

/// Writes the field `Transform` of a texture or medium. Writes nothing if `steps` is empty.
pub(in crate::format) fn write_transform_field(out: &mut SceneWriter<'_, '_>, steps: &[TransformStep]) -> fmt::Result {
    if steps.is_empty() {
        return Ok(());
    }
    out.begin_block("Transform")?;
    write_transform_steps(out, steps)?;
    out.end_block()
}
