//! Images of one pixel or one row, fields of view near 0° and 180°, and invalid cameras.

mod angles;
mod lenses;
mod sizes;

use caustica::format::{SceneError, SourceText, parse, resolve};
use caustica::scene::Scene;
use std::path::Path;

/// Parses and resolves the scene of `text`.
fn resolved_scene(text: &str) -> Result<Scene, SceneError> {
    let description = parse("hard.txt", text)?;
    resolve(&description, &SourceText::new("hard.txt", text), Path::new(""))
}

/// Checks that the scene `text` is refused with a helpful error.
///
/// The error points at the words `place` in the text, and its message or remedy contains `words`.
#[track_caller]
fn assert_refused(text: &str, place: &str, words: &[&str]) {
    let error = resolved_scene(text).err().unwrap_or_else(|| panic!("accepted: {text}"));
    assert!(error.offending_text().contains(place), "{error}: the place is `{}`", error.offending_text());
    let all = format!("{error} {}", error.remedy());
    words.iter().for_each(|word| assert!(all.contains(word), "`{word}` is not in `{all}`"));
}
