//! Messages about content of a scene file that is ignored, approximated or added.

use crate::format::import::ImportNote;
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of places that one message names. Further places are only counted.
const NAMED_PLACES: usize = 3;

/// Messages about a file: one for each kind, with the places where it applies.
#[derive(Default)]
pub(in crate::format) struct ImportNotes {
    /// Places by message; the flag is true for content that is not supported.
    places: BTreeMap<(bool, String), BTreeSet<String>>,
}

impl ImportNotes {
    /// Notes content at `place` that is ignored or approximated.
    ///
    /// `message` says which content, and what the importer does instead. Equal messages become one.
    pub fn add_unsupported(&mut self, message: &str, place: impl Into<String>) {
        self.add(true, message, place.into());
    }

    /// Notes that the file leaves something out, such as a camera.
    pub fn add_missing(&mut self, message: &str) {
        self.places.entry((false, message.to_owned())).or_default();
    }

    fn add(&mut self, is_unsupported: bool, message: &str, place: String) {
        self.places.entry((is_unsupported, message.to_owned())).or_default().insert(place);
    }

    /// Returns one message for each kind.
    pub fn into_notes(self) -> Vec<ImportNote> {
        let note = |((is_unsupported, message), places): ((bool, String), BTreeSet<String>)| {
            let message = if places.is_empty() { message } else { format!("{message} ({})", listed(&places)) };
            ImportNote { message, is_unsupported }
        };
        self.places.into_iter().map(note).collect()
    }
}

/// Returns the number of places and the names of the first few.
fn listed(places: &BTreeSet<String>) -> String {
    let more = if places.len() > NAMED_PLACES { ", …" } else { "" };
    let names = places.iter().take(NAMED_PLACES).map(String::as_str).collect::<Vec<_>>().join(", ");
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
        assert!(notes[1].is_unsupported && !notes[0].is_unsupported);
    }
}
