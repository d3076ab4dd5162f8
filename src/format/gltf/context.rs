//! Access to a glTF file and the files that it names, with memory checks and errors.

pub(super) use crate::format::import::ReadResult;
use crate::format::import::{ImportOptions, SceneReadError};
use crate::format::imported_files::{self, FileDefect};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{SceneError, SourceText};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

/// Help text of an error for which the importer has no more specific advice.
const REMEDY: &str = "export the file again, or repair it: a glTF validator lists all its defects";

/// Access to the glTF file that is imported and to the files that it names, with the options of the
/// import.
pub(super) struct FileContext<'a> {
    /// Path of the glTF file.
    pub path: &'a Path,
    /// Observer that receives the path of each file that is read after the glTF file.
    pub monitor: &'a dyn MeshReadMonitor,
    /// Memory limit, and permission to read files outside of the folder of the glTF file.
    pub options: &'a ImportOptions,
}

impl FileContext<'_> {
    /// Returns the source text to which errors of the imported scene refer: the name of the glTF
    /// file, with an empty text.
    ///
    /// The text is empty because these errors state no line or column of the file.
    pub fn source(&self) -> SourceText {
        SourceText::new(&self.path.display().to_string(), "")
    }

    /// Returns an error at `place`, a JSON path such as `accessors[3]`, with a general help text.
    pub fn error(&self, place: impl Display, message: impl Display) -> SceneReadError {
        self.error_with_help(place, message, REMEDY)
    }

    /// Returns an error at `place`, a JSON path such as `accessors[3]`, with the help text `help`.
    pub fn error_with_help(&self, place: impl Display, message: impl Display, help: &str) -> SceneReadError {
        let name = self.path.display().to_string();
        SceneError::error_without_position(&name, format!("{place}: {message}"), help).into()
    }

    /// Returns the memory that may still be allocated \[bytes]; `None` without a limit.
    pub fn free_memory(&self) -> Option<u64> {
        self.options.memory_limit.available_bytes()
    }

    /// Fails if `needed` bytes exceed the free memory.
    pub fn check_memory(&self, needed: u64) -> ReadResult<()> {
        imported_files::check_memory(self.path, needed, self.free_memory())
    }

    /// Returns the content of a file. Fails before reading if the file is larger than the free
    /// memory.
    pub fn read_file(&self, path: &Path) -> ReadResult<Vec<u8>> {
        imported_files::read_file(path, |length| self.check_memory(length))
    }

    /// Returns the content of a data URI, or of the file that a relative URI names.
    ///
    /// The file must lie inside the folder of the glTF file, unless the options allow outside
    /// files.
    pub fn read_uri(&self, place: &str, uri: &str) -> ReadResult<Vec<u8>> {
        if let Some(data) = uri.strip_prefix("data:") {
            let Some((_, digits)) = data.split_once(";base64,") else {
                return Err(self.error(place, "its data URI is not encoded in base64"));
            };
            self.check_memory(digits.len() as u64)?;
            return STANDARD.decode(digits).map_err(|e| self.error(place, format!("its data URI is damaged: {e}")));
        }
        let Some(name) = percent_decoded(uri) else {
            return Err(self.error(place, format!("`{uri}` is not a valid URI")));
        };
        if name.contains("://") {
            let help = "download it, and write the name of the file into the glTF file";
            return Err(self.error_with_help(place, format!("`{name}` is not a local file"), help));
        }
        let file = imported_files::find_file_in_folder(self.path, &name, self.options)
            .map_err(|FileDefect { message, help }| self.error_with_help(place, message, &help))?;
        self.monitor.on_input_file_found(&file);
        self.read_file(&file)
    }
}

/// Returns `uri` with its `%` escapes decoded; `None` if an escape is damaged or the result is not
/// UTF-8.
fn percent_decoded(uri: &str) -> Option<Cow<'_, str>> {
    if !uri.contains('%') {
        return Some(uri.into());
    }
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()))?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).ok().map(Cow::Owned)
}

#[cfg(test)]
mod tests {
    use super::percent_decoded;

    #[test]
    fn escapes_of_uris_are_decoded() {
        assert_eq!(percent_decoded("a%20b%C3%A4.bin").as_deref(), Some("a bä.bin"));
        assert_eq!(percent_decoded("a.bin").as_deref(), Some("a.bin"));
        assert!(["%", "%4", "%zz", "%+1", "%ff"].iter().all(|uri| percent_decoded(uri).is_none()));
    }
}
