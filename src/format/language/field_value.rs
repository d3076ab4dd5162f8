//! Types of field values: their conversion from parsed text, and their writing as text.

use std::fmt;

use glam::{DVec2, DVec3, DVec4};

use super::curves::{CurveBasis, ProfileCurve};
use super::schema::{FieldDefault, FieldSchema};
use super::transforms::write_transform_field;
use super::writer::SceneWriter;
use crate::format::span::{Span, Spanned};
use crate::format::textured_value::TexturedValue;
use crate::format::transform_step::TransformStep;

/// Parsed value of a field. The [`FieldKind`](super::schema::FieldKind) of the field determines
/// which members are set.
#[derive(Default)]
pub(in crate::format) struct ParsedFieldValue {
    /// Parsed numbers, at most three, in x, y and z. Unused components are 0.
    pub(super) numbers: DVec3,
    /// The name, path or word that the field holds. If the field accepts numbers or a texture: the
    /// name of the texture, empty if the field holds numbers.
    pub(super) text: String,
    pub(super) steps: Vec<TransformStep>,
    /// Polynomial basis of a `profile` curve; `points` holds its control points.
    pub(super) basis: CurveBasis,
    pub(super) points: Vec<DVec3>,
    pub(super) weighted_points: Vec<DVec4>,
    pub(super) number_list: Vec<f64>,
}

/// A type of field values, such as [`DVec3`]. The type of a field's values must fit the
/// [`FieldKind`](super::schema::FieldKind) of the field.
pub(in crate::format) trait FieldValue: PartialEq + Sized {
    /// Returns the parsed `value` as this type.
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self;

    /// Writes the field `name` with this value.
    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result;

    /// Returns the value that an absent field stands for if its schema has no default; `None` if
    /// such a field is an error.
    fn absent_value() -> Option<Self> {
        None
    }

    /// Returns the name of the texture if the field holds such a name instead of numbers; otherwise
    /// `None`.
    fn texture_name(&self) -> Option<&Spanned<String>> {
        None
    }
}

/// Returns the value that an absent `field` stands for; `None` if its absence is an error.
pub(in crate::format) fn default_value<T: FieldValue>(field: &FieldSchema) -> Option<T> {
    let mut value = ParsedFieldValue::default();
    match field.default {
        FieldDefault::Numbers(numbers) => value.numbers.as_mut()[..numbers.len()].copy_from_slice(numbers),
        FieldDefault::Word(word) => word.clone_into(&mut value.text),
        FieldDefault::Required => return None,
        FieldDefault::Optional(_) => return T::absent_value(),
    }
    Some(T::from_parsed_value(&Spanned::new(value, Span::default())))
}

impl FieldValue for DVec3 {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.numbers
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_vec3(name, *self)
    }
}

impl FieldValue for DVec2 {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.numbers.truncate()
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_vec2(name, *self)
    }
}

impl FieldValue for f64 {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.numbers.x
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_number(name, *self)
    }
}

impl FieldValue for u32 {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.numbers.x as Self
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_field(name, self)
    }
}

/// A whole number of a field whose schema limits it to a range inside \[0, 255].
impl FieldValue for u8 {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.numbers.x as Self
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_field(name, self)
    }
}

/// A truth value, written as the word `yes` or `no`.
impl FieldValue for bool {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.text == "yes"
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_field(name, if *self { "yes" } else { "no" })
    }
}

impl FieldValue for Spanned<String> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        Self::new(value.text.clone(), value.span)
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_name_field(name, self)
    }
}

impl<T: FieldValue> FieldValue for TexturedValue<T> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        if value.text.is_empty() {
            Self::Constant(T::from_parsed_value(value))
        } else {
            Self::Texture(FieldValue::from_parsed_value(value))
        }
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        match self {
            Self::Constant(value) => value.write(out, name),
            Self::Texture(texture) => out.write_texture_name_field(name, texture),
        }
    }

    fn texture_name(&self) -> Option<&Spanned<String>> {
        Self::texture_name(self)
    }
}

/// A field that may be absent and has no default. An absent field is not written.
impl<T: FieldValue> FieldValue for Option<T> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        Some(T::from_parsed_value(value))
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        self.as_ref().map_or(Ok(()), |value| value.write(out, name))
    }

    fn absent_value() -> Option<Self> {
        Some(None)
    }

    fn texture_name(&self) -> Option<&Spanned<String>> {
        self.as_ref().and_then(FieldValue::texture_name)
    }
}

/// Steps of a transform. An absent field means an empty list of steps, and an empty list is not
/// written.
impl FieldValue for Vec<TransformStep> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.steps.clone()
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, _: &str) -> fmt::Result {
        write_transform_field(out, self)
    }

    fn absent_value() -> Option<Self> {
        Some(Self::new())
    }
}

/// Points of a field of kind [`Points`](super::schema::FieldKind::Points).
impl FieldValue for Vec<DVec3> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.points.clone()
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_points(name, self)
    }
}

/// Control points (x, y, z, weight) of a field of kind
/// [`WeightedPoints`](super::schema::FieldKind::WeightedPoints).
impl FieldValue for Vec<DVec4> {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        value.weighted_points.clone()
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.write_weighted_points(name, self)
    }
}

impl FieldValue for ProfileCurve {
    fn from_parsed_value(value: &Spanned<ParsedFieldValue>) -> Self {
        Self { basis: value.basis, controls: value.points.clone() }
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, name: &str) -> fmt::Result {
        out.begin_block(format_args!("{name} {}", self.basis.block().keyword))?;
        out.write_points("controls", &self.controls)?;
        out.end_block()
    }
}
