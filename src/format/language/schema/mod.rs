//! Schemas of the scene language: its blocks and fields, with units, ranges, defaults and help.
//!
//! The parser checks values against the schemas, and the writer takes keywords from them. The
//! tables in `docs/guide/scene-language.md` are generated from them.

mod block;
mod field;
mod range;
mod reference;

pub(in crate::format) use block::{BlockParser, BlockSchema, block_keywords, block_schema, block_schemas, find_block};
pub(in crate::format) use field::{FieldDefault, FieldKind, FieldList, FieldSchema, field_schema};
pub(in crate::format) use range::FieldRange;
pub(in crate::format) use reference::reference_markdown;

/// Largest accepted absorption or scattering coefficient \[1/length].
///
/// Coefficients up to this value can be multiplied by densities and lengths without overflow in
/// single precision.
pub(in crate::format) const MAX_MEDIUM_COEFFICIENT: f64 = 1e12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::language::all_block_schemas;

    #[test]
    fn schemas_have_help_and_valid_defaults() {
        for block in all_block_schemas() {
            let mut words: Vec<&str> = block.field_keywords().collect();
            let count = words.len();
            words.sort_unstable();
            words.dedup();
            assert_eq!(words.len(), count, "`{}` lists a field twice", block.keyword);
            assert!(!block.help.is_empty() && !block.help.ends_with('.'), "{}", block.keyword);
            for field in block.all_fields() {
                assert!(!field.help.is_empty() && !field.help.ends_with('.'), "{} {}", block.keyword, field.keyword);
                match field.default {
                    FieldDefault::Numbers(numbers) => {
                        assert_eq!(field.violated_rule(numbers), None, "{}", field.keyword)
                    }
                    FieldDefault::Word(word) => {
                        assert!(matches!(field.kind, FieldKind::Word(words) if words.contains(&word)))
                    }
                    FieldDefault::Required | FieldDefault::Optional(_) => {}
                }
            }
        }
    }
}
