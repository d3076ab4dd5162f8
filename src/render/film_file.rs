//! Film files: stored sums of a render. From a film file, a render can be continued, or merged with
//! others.
//!
//! A file begins with the line `CAUSTICA FILM 2`, followed by blocks. A block consists of three
//! little-endian 32-bit numbers and LZ4-compressed bytes. The numbers are the uncompressed size,
//! the compressed size, and the CRC-32 of the compressed bytes. The first block holds the header as
//! JSON. The other blocks hold the sums in the format of the crate `postcard`. An empty block ends
//! the file.

use super::driver::RenderResult;
use super::pass_set::PassSet;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};

/// First line of a film file. It holds the version number of the format.
const MAGIC: &[u8; 16] = b"CAUSTICA FILM 2\n";

/// Largest uncompressed content of a block of a film file \[bytes].
const MAX_BLOCK_BYTES: usize = 1 << 20;

/// Largest uncompressed size \[bytes] of a film file's blocks, apart from the numbers that are
/// stored for each pixel.
const MAX_FIXED_BYTES: u64 = 1 << 20;

/// Largest uncompressed size \[bytes per pixel] of the numbers that a film file stores for each
/// pixel, such as sums over passes.
///
/// The format of the crate `postcard` stores a 64-bit integer in at most 10 bytes, so the limit has
/// room for about 100 integers.
const MAX_BYTES_PER_PIXEL: u64 = 1024;

/// Size of the buffer in which `postcard` decodes a single number \[bytes].
const NUMBER_BUFFER_BYTES: usize = 16;

/// Name of an input file of a scene, and the SHA-256 digest of its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputDigest {
    /// Path of the file relative to the folder of the scene, with `/` between folders. For a file
    /// outside that folder, only the file name.
    pub name: String,
    /// SHA-256 digest of the file's content, in hexadecimal digits.
    pub digest: String,
}

/// Header of a film file: the scene, settings and program version on which the passes of a render
/// depend.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilmHeader {
    /// Version of the program.
    #[serde(rename = "version")]
    pub program_version: String,
    /// Path of the scene file, as the user gave it.
    pub scene: String,
    /// The scene file and all files that it names, sorted by name and digest.
    pub inputs: Vec<InputDigest>,
    /// Width of the rendered picture or crop window \[pixels].
    pub width: u32,
    /// Height of the rendered picture or crop window \[pixels].
    pub height: u32,
    /// Command-line flags and values of all settings that differ from their defaults, except the
    /// seed.
    pub settings: Vec<String>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of passes of the whole render, if this film file holds only a part of the render, as
    /// with `--shard`; else `None`.
    pub planned_passes: Option<u32>,
}

/// Content of a film file: the header, and the render so far.
#[derive(Debug)]
pub struct FilmFile {
    /// Scene, settings and version on which the passes of the render depend.
    pub header: FilmHeader,
    /// The render so far: film, error estimator, pass numbers and statistics.
    pub rendered: RenderResult,
}

/// Error of reading a film file.
#[derive(Debug, thiserror::Error)]
pub enum FilmFileError {
    /// The file does not begin with the first line of a film file of this version.
    #[error("it is no film of this version of the program")]
    NoFilm,
    /// The file ends before its last block.
    #[error("it is cut off: copy it again, or delete it to begin anew")]
    CutOff,
    /// The content of the file contradicts its checksum, or its parts contradict each other.
    #[error("it is damaged ({what}): copy it again, or delete it to begin anew")]
    Damaged {
        /// Name of the damaged part for the message, such as `its header`.
        what: &'static str,
    },
    /// The system could not read the file.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl FilmHeader {
    /// Returns why the passes of the two renders must not be added: one line for each difference
    /// between their headers. The result is empty if the passes can be added.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut compare = |what: &str, own: &str, other: &str| {
            if own != other {
                lines.push(format!("{what}: {own} here, {other} there"));
            }
        };
        compare("version", &self.program_version, &other.program_version);
        let size = |header: &Self| format!("{}x{}", header.width, header.height);
        compare("size", &size(self), &size(other));
        compare("seed", &self.seed.to_string(), &other.seed.to_string());
        let settings = |header: &Self| match header.settings.join(" ") {
            flags if flags.is_empty() => "the default".to_owned(),
            flags => format!("`{flags}`"),
        };
        compare("settings", &settings(self), &settings(other));
        let changed: Vec<_> = self.inputs.iter().filter(|input| !other.inputs.contains(input)).collect();
        let is_listed = |name: &str| changed.iter().any(|input| input.name == name);
        for input in &changed {
            lines.push(format!("file `{}` has another content or is new", input.name));
        }
        for input in &other.inputs {
            // Skip a changed file: the first loop lists it.
            if !self.inputs.contains(input) && !is_listed(&input.name) {
                lines.push(format!("file `{}` is missing here", input.name));
            }
        }
        lines
    }

    /// Returns the passes that are still missing from the whole render, if the passes `done` are
    /// made.
    ///
    /// The whole render consists of the planned passes, and of all passes up to the last pass of
    /// `done`.
    #[must_use]
    pub fn missing_passes(&self, done: &PassSet) -> PassSet {
        done.missing_below(self.planned_passes.unwrap_or(0).max(done.end()))
    }
}

impl FilmFile {
    /// Writes a film file with `header` and `rendered` to `out`.
    ///
    /// # Errors
    /// [`io::Error`] if `out` cannot be written.
    pub fn write(header: &FilmHeader, rendered: &RenderResult, out: &mut impl Write) -> io::Result<()> {
        out.write_all(MAGIC)?;
        write_block(out, &serde_json::to_vec(header)?)?;
        let mut blocks = BlockWriter { out, content: Vec::with_capacity(MAX_BLOCK_BYTES) };
        postcard::to_io(rendered, &mut blocks).map_err(io::Error::other)?;
        blocks.flush()?;
        write_block(out, &[])
    }

    /// Reads a film file from `input`.
    ///
    /// # Errors
    /// [`FilmFileError`] if `input` is not a complete, undamaged film file of this version.
    pub fn read(mut input: impl Read) -> Result<Self, FilmFileError> {
        let header = read_header(&mut input)?;
        let damaged = |what| FilmFileError::Damaged { what };
        let pixels = u64::from(header.width) * u64::from(header.height);
        let most = pixels.saturating_mul(MAX_BYTES_PER_PIXEL) + MAX_FIXED_BYTES;
        let mut blocks = BlockReader { input, block: Vec::new(), next: 0, left: most, failure: None };
        let mut scratch = [0; NUMBER_BUFFER_BYTES];
        let read = postcard::from_io((&mut blocks, &mut scratch)).map(|(rendered, _)| rendered);
        if let Some(error) = blocks.failure.take() {
            return Err(error);
        }
        let rendered: RenderResult = read.map_err(|_| damaged("its sums"))?;
        blocks.check_end()?;
        if !rendered.is_consistent() || rendered.film.size() != (header.width, header.height) {
            return Err(damaged("its sums contradict each other"));
        }
        Ok(Self { header, rendered })
    }
}

/// Returns the header of a film file, without reading the pixels.
///
/// # Errors
/// [`FilmFileError`] if `input` does not begin as a film file of this version.
pub fn read_film_header(mut input: impl Read) -> Result<FilmHeader, FilmFileError> {
    read_header(&mut input)
}

/// Returns the numbers of the passes that a film file holds, without reading the pixels.
///
/// # Errors
/// [`FilmFileError`] if `input` does not begin as a film file of this version.
pub fn read_pass_numbers(mut input: impl Read) -> Result<PassSet, FilmFileError> {
    read_header(&mut input)?;
    // The numbers are the first field of the stored `RenderResult`.
    let numbers = postcard::take_from_bytes(&read_block(&mut input)?).map(|(numbers, _)| numbers);
    let numbers: PassSet = numbers.map_err(|_| FilmFileError::Damaged { what: "the numbers of its passes" })?;
    if numbers.is_consistent() {
        Ok(numbers)
    } else {
        Err(FilmFileError::Damaged { what: "the numbers of its passes" })
    }
}

/// Reads the first line and the header of a film file.
fn read_header(input: &mut impl Read) -> Result<FilmHeader, FilmFileError> {
    let mut magic = [0; MAGIC.len()];
    let read = input.read_exact(&mut magic);
    if read.is_err() || magic != *MAGIC {
        return Err(FilmFileError::NoFilm);
    }
    serde_json::from_slice(&read_block(input)?).map_err(|_| FilmFileError::Damaged { what: "its header" })
}

/// Reader of the uncompressed content of all blocks of a film file. It holds one block at a time.
struct BlockReader<R> {
    input: R,
    block: Vec<u8>,
    /// Index in `block` of the next byte to read.
    next: usize,
    /// Largest number of bytes that further blocks may hold. A file with more is damaged.
    left: u64,
    /// Error of reading the last block, kept here because `postcard` does not pass on the error of
    /// its reader.
    failure: Option<FilmFileError>,
}

impl<R: Read> BlockReader<R> {
    /// Reads the next block. An empty block ends the file.
    fn read_next_block(&mut self) -> Result<(), FilmFileError> {
        self.block = read_block(&mut self.input)?;
        self.next = 0;
        let size = self.block.len() as u64;
        self.left = self.left.checked_sub(size).ok_or(FilmFileError::Damaged { what: "it is too long" })?;
        Ok(())
    }

    /// Fails unless all bytes of the block were read, and the next block is the empty block that
    /// ends the file.
    fn check_end(&mut self) -> Result<(), FilmFileError> {
        let is_read = self.next == self.block.len();
        self.read_next_block()?;
        if is_read && self.block.is_empty() { Ok(()) } else { Err(FilmFileError::Damaged { what: "it is too long" }) }
    }
}

impl<R: Read> Read for BlockReader<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.next == self.block.len() {
            self.read_next_block().map_err(|error| {
                self.failure = Some(error);
                io::ErrorKind::InvalidData
            })?;
        }
        let taken = bytes.len().min(self.block.len() - self.next);
        bytes[..taken].copy_from_slice(&self.block[self.next..][..taken]);
        self.next += taken;
        Ok(taken)
    }
}

/// Writer that divides its bytes into blocks of a film file.
struct BlockWriter<'a, W> {
    out: &'a mut W,
    content: Vec<u8>,
}

impl<W: Write> Write for BlockWriter<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(MAX_BLOCK_BYTES - self.content.len());
        self.content.extend_from_slice(&bytes[..taken]);
        if self.content.len() == MAX_BLOCK_BYTES {
            self.flush()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        if !self.content.is_empty() {
            write_block(self.out, &self.content)?;
            self.content.clear();
        }
        Ok(())
    }
}

/// Writes `content` as one compressed block of a film file.
fn write_block(out: &mut impl Write, content: &[u8]) -> io::Result<()> {
    let compressed = lz4_flex::block::compress(content);
    for number in [content.len() as u32, compressed.len() as u32, crc32fast::hash(&compressed)] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(&compressed)
}

/// Reads one block of a film file, and returns its uncompressed content.
fn read_block(input: &mut impl Read) -> Result<Vec<u8>, FilmFileError> {
    let mut number = || {
        let mut bytes = [0; 4];
        read_exact(input, &mut bytes).map(|()| u32::from_le_bytes(bytes))
    };
    let (size, compressed_size, checksum) = (number()? as usize, number()? as usize, number()?);
    let is_valid =
        size <= MAX_BLOCK_BYTES && compressed_size <= lz4_flex::block::get_maximum_output_size(MAX_BLOCK_BYTES);
    if !is_valid {
        return Err(FilmFileError::Damaged { what: "the size of a block" });
    }
    let mut compressed = vec![0; compressed_size];
    read_exact(input, &mut compressed)?;
    if crc32fast::hash(&compressed) != checksum {
        return Err(FilmFileError::Damaged { what: "a checksum" });
    }
    let content = lz4_flex::block::decompress(&compressed, size);
    content.ok().filter(|content| content.len() == size).ok_or(FilmFileError::Damaged { what: "a block" })
}

/// Fills `bytes` from `input`; fails with [`FilmFileError::CutOff`] if the input ends too early.
fn read_exact(input: &mut impl Read, bytes: &mut [u8]) -> Result<(), FilmFileError> {
    input.read_exact(bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => FilmFileError::CutOff,
        _ => FilmFileError::Io(error),
    })
}

#[cfg(test)]
mod tests;
