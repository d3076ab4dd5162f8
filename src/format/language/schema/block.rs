//! Schema of one kind of block, and tables of blocks with the functions that convert them.

use super::field::{FieldList, FieldSchema};

/// Schema of one kind of block: `keyword { fields }` or `keyword name { fields }`.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct BlockSchema {
    /// Keyword of the block. The scene writer prints it; the parser also accepts `aliases`.
    pub keyword: &'static str,
    /// Further keywords that the parser accepts for the block.
    pub aliases: &'static [&'static str],
    /// Field lists that the macro `field_table!` declares. The macro also generates the code that
    /// reads and writes these fields.
    pub table_fields: &'static [FieldList],
    /// Fields that only this kind of block has, and that `table_fields` does not contain.
    pub own_fields: &'static [FieldSchema],
    /// Field lists that several kinds of blocks share, and that `table_fields` does not contain.
    pub shared_fields: &'static [&'static [FieldSchema]],
    /// Meaning of the block, in one line of the language reference.
    pub help: &'static str,
    /// True if the block is part of the scene format of MIT course 6.837.
    pub is_mit_6837_syntax: bool,
}

/// Entry of a table of blocks: the schema of one kind of block, and the function that converts its
/// parsed fields.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct BlockParser<P: 'static> {
    /// Schema of the block: keywords, fields and help.
    pub block: &'static BlockSchema,
    /// Function that converts the parsed fields, for example to a light or a shape.
    pub parse: P,
}

/// Creates the schema of a block, without fields and aliases.
pub(in crate::format) const fn block_schema(keyword: &'static str, help: &'static str) -> BlockSchema {
    BlockSchema {
        keyword,
        aliases: &[],
        table_fields: &[],
        own_fields: &[],
        shared_fields: &[],
        help,
        is_mit_6837_syntax: false,
    }
}

impl BlockSchema {
    /// Sets the block's other accepted keywords.
    pub const fn with_aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Sets the field lists that `field_table!` declares.
    pub const fn with_table(mut self, table: &'static [FieldList]) -> Self {
        self.table_fields = table;
        self
    }

    /// Sets the fields that only this kind of block has, and that no `field_table!` declares.
    pub const fn with_own_fields(mut self, fields: &'static [FieldSchema]) -> Self {
        self.own_fields = fields;
        self
    }

    /// Sets the field lists `groups`, which several kinds of blocks share.
    pub const fn with_shared_fields(mut self, groups: &'static [&'static [FieldSchema]]) -> Self {
        self.shared_fields = groups;
        self
    }

    /// Marks the block as part of the scene format of MIT course 6.837.
    pub const fn mark_as_mit_6837_syntax(mut self) -> Self {
        self.is_mit_6837_syntax = true;
        self
    }

    /// True if `word` is the block's keyword or an alias.
    pub fn matches_keyword(&self, word: &str) -> bool {
        self.keyword == word || self.aliases.contains(&word)
    }

    /// Iterates over the fields that only this kind of block has.
    pub(super) fn all_own_fields(&self) -> impl Iterator<Item = &'static FieldSchema> + use<> {
        self.table_fields.iter().filter(|list| !list.is_shared).flat_map(|list| list.fields).chain(self.own_fields)
    }

    /// Iterates over the lists of fields that several kinds of blocks share.
    pub(super) fn all_shared_lists(&self) -> impl Iterator<Item = &'static [FieldSchema]> + use<> {
        let lists = self.table_fields.iter().filter(|list| list.is_shared).map(|list| list.fields);
        lists.chain(self.shared_fields.iter().copied())
    }

    /// Iterates over the block's own fields, then over its shared fields.
    pub fn all_fields(&self) -> impl Iterator<Item = &'static FieldSchema> + use<> {
        self.all_own_fields().chain(self.all_shared_lists().flatten())
    }

    /// Returns the field with keyword or alias `word`; `None` if the block has none.
    pub fn find_field(&self, word: &str) -> Option<&'static FieldSchema> {
        self.all_fields().find(|field| field.matches_keyword(word))
    }

    /// Iterates over the keywords and aliases of all fields.
    pub fn field_keywords(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.all_fields().flat_map(|field| [field.keyword, field.alias]).filter(|word| !word.is_empty())
    }
}

/// Returns the entry of `table` whose block has the keyword or alias `word`; `None` if no entry
/// has it.
pub(in crate::format) fn find_block<P>(
    table: &'static [BlockParser<P>],
    word: &str,
) -> Option<&'static BlockParser<P>> {
    table.iter().find(|entry| entry.block.matches_keyword(word))
}

/// Returns the schemas of all blocks of `table`.
pub(in crate::format) fn block_schemas<P>(table: &'static [BlockParser<P>]) -> Vec<&'static BlockSchema> {
    table.iter().map(|entry| entry.block).collect()
}

/// Returns the words of `before`, followed by the keywords and aliases of all blocks in `table`.
pub(in crate::format) fn block_keywords<P>(
    before: &[&'static str],
    table: &'static [BlockParser<P>],
) -> Vec<&'static str> {
    let blocks = table.iter().map(|entry| entry.block);
    let words = blocks.flat_map(|block| std::iter::once(block.keyword).chain(block.aliases.iter().copied()));
    before.iter().copied().chain(words).collect()
}
