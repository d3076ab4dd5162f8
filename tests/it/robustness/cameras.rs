//! Images of one pixel or one row, fields of view near 0° and 180°, and invalid cameras.

mod angles;
mod lenses;
mod sizes;

use caustica::format::{SceneError, SourceText, parse, resolve};
use caustica::scene::Scene;
use std::path::Path;

/// Parses and resolves the scene of `text`.
fn resolved(text: &str) -> Result<Scene, SceneError> {
    let description = parse("hard.txt", text)?;
    resolve(&description, &SourceText::new("hard.txt", text), Path::new(""))
}

/// Checks that `text` is refused at the words `place`, with `words` in the message or the remedy.
#[track_caller]
fn refused(text: &str, place: &str, words: &[&str]) {
    let error = resolved(text).err().unwrap_or_else(|| panic!("accepted: {text}"));
    assert!(error.text().contains(place), "{error}: the place is `{}`", error.text());
    let all = format!("{error} {}", error.remedy());
    words.iter().for_each(|word| assert!(all.contains(word), "`{word}` is not in `{all}`"));
}
