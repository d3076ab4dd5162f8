//! Rewrites the reference tables of `docs/guide/scene-language.md` from the tables of the program.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/scene-language.md");
    let page = std::fs::read_to_string(&path)?;
    std::fs::write(path, caustica::format::update_reference_tables(&page))
}
