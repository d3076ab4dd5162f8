//! Collects an importer's messages about content that it ignores, approximates or adds.

use crate::format::import::ImportNote;
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of places that one message names. Further places are only counted.
const MAX_NAMED_PLACES: usize = 3;

/// Messages about a file. Each distinct message occurs once, with all places where it applies.
#[derive(Default)]
pub(in crate::format) struct ImportNotes {
    /// Places where each message applies. The key is a pair: true if the message is about
    /// unsupported content, and the message itself.
    places: BTreeMap<(bool, String), BTreeSet<String>>,
}

impl ImportNotes {
    /// Adds a message about content that the importer ignores or approximates.
    ///
    /// `message` names the content and what the importer does instead. `place` names the object
    /// that has the content. Calls with equal messages give one message with all places.
    pub fn add_unsupported(&mut self, message: &str, place: impl Into<String>) {
        self.add(true, message, place.into());
    }

    /// Adds a message that the file lacks something, such as a camera.
    pub fn add_missing(&mut self, message: &str) {
        self.places.entry((false, message.to_owned())).or_default();
    }

    fn add(&mut self, is_unsupported: bool, message: &str, place: String) {
        self.places.entry((is_unsupported, message.to_owned())).or_default().insert(place);
    }

    /// Returns the messages. A message that has places ends with their number and the first three.
    pub fn into_notes(self) -> Vec<ImportNote> {
        let note = |((is_unsupported, message), places): ((bool, String), BTreeSet<String>)| {
            let message = if places.is_empty() { message } else { format!("{message} ({})", place_list(&places)) };
            ImportNote { message, concerns_unsupported_content: is_unsupported }
        };
        self.places.into_iter().map(note).collect()
    }
}

/// Returns the number of `places` and the first three of them as text, such as `4×: a, b, c, …`.
fn place_list(places: &BTreeSet<String>) -> String {
    let more = if places.len() > MAX_NAMED_PLACES { ", …" } else { "" };
    let names = places.iter().take(MAX_NAMED_PLACES).map(String::as_str).collect::<Vec<_>>().join(", ");
    format!("{}×: {names}{more}", places.len())
}

#[cfg(test)]
mod tests {
    use super::ImportNotes;

    #[test]
    fn equal_messages_become_one_with_its_count() {
        let mut notes = ImportNotes::default();
        for name in ["a", "b", "a", "c", "d"] {
            notes.add_unsupported("sheen is ignored", name);
        }
        notes.add_missing("no camera");
        let notes = notes.into_notes();
        assert_eq!(notes[0].message, "no camera");
        assert_eq!(notes[1].message, "sheen is ignored (4×: a, b, c, …)");
        assert!(notes[1].concerns_unsupported_content && !notes[0].concerns_unsupported_content);
    }
}
