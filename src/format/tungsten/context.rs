//! Access to the objects, files and messages of a Tungsten scene during its import.

use super::object::{ReadRecord, ReadResult, TungstenObject};
use crate::format::SceneError;
use crate::format::import::{ImportOptions, SceneReadError};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_files::{self, FileDefect};
use crate::format::mesh::MeshReadMonitor;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Estimated memory of each JSON object, of each further JSON value, and of each byte of the text
/// \[bytes].
const MEMORY_PER_JSON_PART: [u64; 3] = [400, 100, 4];

/// Members that the importer ignores without a message.
///
/// They are details of Tungsten's renderer or of its pictures.
const SILENTLY_IGNORED_MEMBERS: [&str; 6] = ["name", "type", "sample", "tonemap", "bump_strength", "max_bounces"];

/// Access to the scene file and the files that it refers to, within a memory limit.
pub(super) struct TungstenSceneFiles<'a> {
    /// Path of the scene file.
    pub path: &'a Path,
    /// Observer that receives the path of each file that is read after the scene file.
    pub monitor: &'a dyn MeshReadMonitor,
    /// Memory limit, and permission to read files outside of the scene's folder.
    pub options: &'a ImportOptions,
}

impl TungstenSceneFiles<'_> {
    /// Returns the memory that may still be allocated \[bytes]; `None` if there is no limit.
    pub fn free_memory(&self) -> Option<u64> {
        self.options.memory_limit.available_bytes()
    }

    /// Fails with an error that names `path` if `needed` bytes exceed the free memory.
    pub fn check_memory(&self, path: &Path, needed: u64) -> ReadResult<()> {
        imported_files::check_memory(path, needed, self.free_memory())
    }

    /// Returns the content of a file. Fails if the file cannot be read or exceeds the free memory.
    pub fn read_file(&self, path: &Path) -> ReadResult<Vec<u8>> {
        imported_files::read_file(path, |length| self.check_memory(path, length))
    }

    /// Returns the path of the file `name`, to which `object` refers. Reports the file to the
    /// monitor.
    ///
    /// # Errors
    /// The file does not exist. Or it lies outside the scene's folder, and the options do not allow
    /// this.
    pub fn find_file(&self, name: &str, object: &TungstenObject<'_>) -> ReadResult<PathBuf> {
        let relative = name.replace('\\', "/");
        let found = imported_files::find_file_in_folder(self.path, &relative, self.options);
        let file = found.map_err(|FileDefect { message, help }| object.error(message, &help))?;
        if !file.is_file() {
            return Err(object.error(format!("`{name}` is not a file"), "name a file"));
        }
        self.monitor.on_input_file_found(&file);
        Ok(file)
    }

    /// Parses the JSON of the scene file.
    pub fn parse_json(&self, bytes: &[u8]) -> ReadResult<Value> {
        let count = |byte: u8| bytes.iter().filter(|b| **b == byte).count() as u64;
        let [per_object, per_value, per_byte] = MEMORY_PER_JSON_PART;
        let lists = count(b'[');
        let needed = (count(b'{') + lists) * per_object + count(b',') * per_value + bytes.len() as u64 * per_byte;
        self.check_memory(self.path, needed)?;
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        serde_json::from_slice(text).map_err(|error| self.file_error(format!("JSON: {error}"), "correct the JSON"))
    }

    /// Returns an error about the whole scene file, with the remedy `help`.
    pub fn file_error(&self, message: impl Into<String>, help: &str) -> SceneReadError {
        SceneError::error_without_position(&self.path.display().to_string(), message, help).into()
    }
}

/// Objects, files and messages of a Tungsten scene during its import.
pub(super) struct ImportContext<'a> {
    /// Access to the files that the scene refers to.
    pub files: &'a TungstenSceneFiles<'a>,
    /// The whole scene.
    pub scene: TungstenObject<'a>,
    /// Record of the members that have been read.
    pub record: &'a ReadRecord<'a>,
    /// BSDFs of the list `bsdfs` by name.
    bsdfs: HashMap<&'a str, TungstenObject<'a>>,
    /// Media of the list `media` by name.
    media: HashMap<&'a str, TungstenObject<'a>>,
    /// Primitives of the list `primitives` by name.
    primitives: HashMap<&'a str, TungstenObject<'a>>,
    /// Messages about content that is ignored, approximated or added.
    pub notes: RefCell<ImportNotes>,
}

impl<'a> ImportContext<'a> {
    /// Returns the context of the given `scene`.
    pub fn new(
        files: &'a TungstenSceneFiles<'a>,
        record: &'a ReadRecord<'a>,
        scene: TungstenObject<'a>,
    ) -> ReadResult<Self> {
        let by_name = |list: &str| -> ReadResult<HashMap<&'a str, TungstenObject<'a>>> {
            // The first of several objects with one name counts, as in Tungsten.
            let mut named = HashMap::new();
            for object in scene.children(list)? {
                named.entry(object.name()).or_insert(object);
            }
            Ok(named)
        };
        let (bsdfs, media, primitives) = (by_name("bsdfs")?, by_name("media")?, by_name("primitives")?);
        Ok(Self { files, scene, record, bsdfs, media, primitives, notes: RefCell::default() })
    }

    /// Adds a message that a part of `object` is ignored or approximated.
    pub fn add_note(&self, message: &str, object: &TungstenObject<'_>) {
        self.notes.borrow_mut().add_unsupported(message, object.label());
    }

    /// Adds a message that the whole `object` is ignored or approximated. Records all its members
    /// as read.
    pub fn add_whole_object_note(&self, message: &str, object: &TungstenObject<'_>) {
        object.mark_as_read();
        self.add_note(message, object);
    }

    /// Adds a message for each member of a used object that no part of the importer has read.
    pub fn note_unread_members(&self) {
        for (place, name) in self.record.unread_members() {
            if !SILENTLY_IGNORED_MEMBERS.contains(&name) {
                self.notes.borrow_mut().add_unsupported(&format!("`{name}` is ignored"), place);
            }
        }
    }

    /// Returns the primitive called `name`; `None` if there is none.
    pub fn primitive(&self, name: &str) -> Option<&TungstenObject<'a>> {
        self.primitives.get(name)
    }

    /// Returns the BSDF in the member `name` of `object`: an object, or the name of an entry of
    /// `bsdfs`. `None` if the member is missing.
    pub fn bsdf(&self, object: &TungstenObject<'a>, name: &str) -> ReadResult<Option<TungstenObject<'a>>> {
        object.value(name).map(|value| self.referenced_bsdf(object, name, value)).transpose()
    }

    /// Returns the BSDF that `value` gives, which is the member `name` of `object` or a part of
    /// this member.
    pub fn referenced_bsdf(
        &self,
        object: &TungstenObject<'a>,
        name: &str,
        value: &'a Value,
    ) -> ReadResult<TungstenObject<'a>> {
        referenced(&self.bsdfs, ("BSDF", "bsdfs"), object, name, value)
    }

    /// Returns the medium in the member `name` of `object`: an object, or the name of an entry of
    /// `media`. `None` if the member is missing.
    pub fn medium(&self, object: &TungstenObject<'a>, name: &str) -> ReadResult<Option<TungstenObject<'a>>> {
        object.value(name).map(|value| referenced(&self.media, ("medium", "media"), object, name, value)).transpose()
    }
}

/// Returns the object that `value` gives: the object itself, or the name of one in `list`.
///
/// # Errors
/// If no object of the list has the name, or if `value` is neither a name nor an object.
fn referenced<'a>(
    list: &HashMap<&'a str, TungstenObject<'a>>,
    (kind, list_name): (&str, &str),
    object: &TungstenObject<'a>,
    name: &str,
    value: &'a Value,
) -> ReadResult<TungstenObject<'a>> {
    match value {
        Value::Object(members) => Ok(object.nested(members, name)),
        Value::String(wanted) => list.get(wanted.as_str()).cloned().ok_or_else(|| {
            let help = format!("add a {kind} of this name to `{list_name}`");
            object.error(format!("no {kind} is called `{wanted}`"), &help)
        }),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::Array(_) => {
            let help = format!("write the name of a {kind}, or an object");
            Err(object.error(format!("`{name}` is no {kind}"), &help))
        }
    }
}
