//! Tables that assign fields of a scene-language block to the members of a description struct.
//! Parser, writer and language reference are generated from these tables.

use std::fmt;

use super::field_value::{FieldValue, default_value};
use super::fields::{BlockFields, ParsedField};
use super::schema::{FieldList, FieldSchema};
use super::writer::SceneWriter;
use crate::format::error::SceneError;
use crate::format::span::Spanned;

/// Conversion of a description struct from and to the fields of its block in scene text.
///
/// [`field_table!`] implements it from a table.
pub(in crate::format) trait BlockCodec: Sized {
    /// Fields that the type's [`field_table!`] declares, in the order of the table. Empty for a
    /// type without a field table; the schema of its block lists the fields instead.
    const FIELDS: &'static [FieldList] = &[];

    /// Converts the parsed fields of a block to a description.
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError>;

    /// Writes the fields of the block.
    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result;

    /// Returns the names of textures in fields that accept a number or a texture.
    ///
    /// The list is empty for a type without a [`field_table!`].
    fn field_textures(&self) -> Vec<&Spanned<String>> {
        Vec::new()
    }
}

/// Implements [`BlockCodec`] for a description struct from a table. Each entry is a member of the
/// struct and the [`FieldEntry`] that reads and writes this member.
///
/// Fields are parsed, checked and written in the order of the table.
macro_rules! field_table {
    ($description:ident { $($member:ident: $entry:expr),* $(,)? }) => {
        impl $crate::format::language::field_table::BlockCodec for $description {
            const FIELDS: &'static [$crate::format::language::schema::FieldList] =
                &[$(const { &$entry }.field_list()),*];

            fn parse_fields(
                f: &$crate::format::language::fields::BlockFields<'_>,
            ) -> Result<Self, $crate::format::error::SceneError> {
                use $crate::format::language::field_table::FieldEntry;
                Ok(Self { $($member: const { &$entry }.parse(f)?),* })
            }

            fn write_fields(
                &self,
                out: &mut $crate::format::language::writer::SceneWriter<'_, '_>,
            ) -> std::fmt::Result {
                use $crate::format::language::field_table::FieldEntry;
                $(const { &$entry }.write(out, &self.$member)?;)*
                Ok(())
            }

            fn field_textures(&self) -> Vec<&$crate::format::span::Spanned<String>> {
                use $crate::format::language::field_table::FieldEntry;
                [$(const { &$entry }.texture_name(&self.$member)),*].into_iter().flatten().collect()
            }
        }
    };
}
pub(in crate::format) use field_table;

/// Entry of a field table: one field, or several fields that together give one value of type `T`.
pub(in crate::format) trait FieldEntry<T> {
    /// Returns the value that the fields of `f` give. If these fields are absent, returns their
    /// default value.
    ///
    /// # Errors
    /// If a required field is absent, or if the value violates a rule.
    fn parse(&self, f: &BlockFields<'_>) -> Result<T, SceneError>;

    /// Writes `value` as fields of a block.
    fn write(&self, out: &mut SceneWriter<'_, '_>, value: &T) -> fmt::Result;

    /// Returns the name of the texture that `value` refers to; `None` if `value` refers to no
    /// texture.
    fn texture_name<'v>(&self, value: &'v T) -> Option<&'v Spanned<String>>;
}

impl<T: FieldValue> FieldEntry<T> for FieldSchema {
    fn parse(&self, f: &BlockFields<'_>) -> Result<T, SceneError> {
        f.value_or_default(self.keyword)
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, value: &T) -> fmt::Result {
        if self.is_default_omitted && default_value(self).is_some_and(|default: T| default == *value) {
            return Ok(());
        }
        value.write(out, self.keyword)
    }

    fn texture_name<'v>(&self, value: &'v T) -> Option<&'v Spanned<String>> {
        value.texture_name()
    }
}

/// Function that fails if the value of a field violates a rule. The rule may involve other fields
/// of the block, such as "at most half of `angle`".
///
/// The function is called only if the block has the field.
pub(in crate::format) type FieldCheck = fn(&BlockFields<'_>, &ParsedField<'_, '_>) -> Result<(), SceneError>;

/// Entry of a field table: a field, and a function that checks its value, for example against the
/// values of other fields.
#[derive(Clone, Copy)]
pub(in crate::format) struct FieldWithCheck {
    field: FieldSchema,
    check: FieldCheck,
}

impl FieldWithCheck {
    /// Creates a table entry for `field`. `check` is called only if the block has the field.
    pub const fn new(field: FieldSchema, check: FieldCheck) -> Self {
        Self { field, check }
    }

    /// Returns a list with this field only.
    pub const fn field_list(&'static self) -> FieldList {
        self.field.field_list()
    }
}

impl<T: FieldValue> FieldEntry<T> for FieldWithCheck {
    fn parse(&self, f: &BlockFields<'_>) -> Result<T, SceneError> {
        let value = self.field.parse(f)?;
        f.get(self.field.keyword).map_or(Ok(()), |field| (self.check)(f, &field))?;
        Ok(value)
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, value: &T) -> fmt::Result {
        self.field.write(out, value)
    }

    fn texture_name<'v>(&self, value: &'v T) -> Option<&'v Spanned<String>> {
        self.field.texture_name(value)
    }
}

/// Several fields that together give one value of type `T`, such as the refractive index.
pub(in crate::format) struct FieldGroup<T: 'static> {
    /// Fields of the group.
    pub list: FieldList,
    /// Function that converts the parsed fields to the value.
    pub parse: fn(&BlockFields<'_>) -> Result<T, SceneError>,
    /// Function that writes a value as fields of a block.
    pub write: fn(&T, &mut SceneWriter<'_, '_>) -> fmt::Result,
    /// Function that returns the name of the texture that a value refers to; `None` if it refers to
    /// none.
    pub texture_name: fn(&T) -> Option<&Spanned<String>>,
}

impl<T> FieldGroup<T> {
    /// Returns the list of the group's fields.
    pub const fn field_list(&'static self) -> FieldList {
        self.list
    }
}

impl<T> FieldEntry<T> for FieldGroup<T> {
    fn parse(&self, f: &BlockFields<'_>) -> Result<T, SceneError> {
        (self.parse)(f)
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>, value: &T) -> fmt::Result {
        (self.write)(value, out)
    }

    fn texture_name<'v>(&self, value: &'v T) -> Option<&'v Spanned<String>> {
        (self.texture_name)(value)
    }
}
