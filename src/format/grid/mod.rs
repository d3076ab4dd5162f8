//! Reads and writes density grid files: a text header, an empty line, and the values. The index x
//! varies fastest.
//!
//! ```text
//! caustica-grid 1
//! size 64 32 64
//! type f32
//!
//! ```
//!
//! Values of type `f32` are little-endian single precision. Values of type `text` are decimal
//! numbers, separated by white space. Header lines that begin with `#` are comments.

mod error;
#[cfg(test)]
mod tests;

pub use error::GridError;

use super::line_error::{MessageAndRemedy, escaped_excerpt};
use crate::image::open_file;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

/// Largest accepted number of cells of a grid.
pub const MAX_CELLS: u64 = 1 << 30;

/// Upper bound of the memory per grid cell \[bytes]: 4 for its density, and 4 for majorants (upper
/// bounds of the density in blocks of cells).
pub(super) const MEMORY_PER_CELL: u64 = 8;

/// Largest accepted size of a header, with its empty line \[bytes].
const MAX_HEADER_BYTES: u64 = 4096;

/// Size of the read buffer \[bytes].
const READ_CHUNK_BYTES: usize = 1 << 16;

/// Densities of a medium on a regular grid of cells, as in a grid file.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGridData {
    /// Number of cells along x, y and z, each at least 1.
    pub cell_counts: [u32; 3],
    /// Densities of all cells, finite and at least 0; the index x varies fastest.
    pub densities: Vec<f32>,
}

/// Encoding of the values in a grid file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridEncoding {
    /// Binary numbers: little-endian single precision.
    F32,
    /// Decimal numbers as text, separated by white space.
    Text,
}

/// Content of a grid file's header, and the length of the header.
struct GridHeader {
    size: [u32; 3],
    cell_count: usize,
    encoding: GridEncoding,
    /// Number of header lines, including the empty line that ends the header.
    line_count: usize,
    /// Number of header bytes, including the empty line that ends the header.
    byte_count: u64,
}

/// Reads a grid file, without a limit on memory.
///
/// # Errors
/// [`GridError`].
pub fn read(path: &Path) -> Result<DensityGridData, GridError> {
    read_with_memory_limit(path, None)
}

/// Reads a grid file. Fails before allocating if the grid takes more than `free` bytes.
///
/// A `free` of `None` sets no limit, for systems whose free memory is unknown.
pub fn read_with_memory_limit(path: &Path, free: Option<u64>) -> Result<DensityGridData, GridError> {
    let unreadable = |source| GridError::Unreadable { path: path.into(), source };
    let (file, length) = open_file(path).map_err(unreadable)?;
    decode(path, length, file, free)
}

/// Reads a grid from `file`, a stream of the bytes of a grid file.
///
/// `length` is the size of the whole file in bytes. `path` appears in errors only. `free` limits
/// the memory, see [`read_with_memory_limit`].
///
/// # Errors
/// [`GridError`].
pub fn decode(path: &Path, length: u64, mut file: impl Read, free: Option<u64>) -> Result<DensityGridData, GridError> {
    let unreadable = |source| GridError::Unreadable { path: path.into(), source };
    let mut start = Vec::new();
    Read::take(&mut file, MAX_HEADER_BYTES).read_to_end(&mut start).map_err(unreadable)?;
    let header = parse_header(&start).map_err(|(line, problem)| GridError::error_at_line(path, line, problem))?;
    let rest = start[header.byte_count as usize..].chain(file);
    let body = GridBodyReader { path, header: &header, file_size: length, free_memory: free };
    let values = match header.encoding {
        GridEncoding::F32 => body.read_binary_densities(BufReader::with_capacity(READ_CHUNK_BYTES, rest))?,
        GridEncoding::Text => body.read_text_densities(rest)?,
    };
    if let Some(i) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        return Err(GridError::InvalidDensity {
            path: path.into(),
            cell: grid_cell_coordinates(header.size, i),
            value: values[i],
        });
    }
    Ok(DensityGridData { cell_counts: header.size, densities: values })
}

/// Writes a grid file.
///
/// # Errors
/// The cause reported by the system.
pub fn write(path: &Path, grid: &DensityGridData, encoding: GridEncoding) -> std::io::Result<()> {
    write_to(BufWriter::new(File::create(path)?), grid, encoding)
}

/// Writes the content of a grid file to `out`.
///
/// # Errors
/// The error of `out`.
pub fn write_to(mut out: impl Write, grid: &DensityGridData, encoding: GridEncoding) -> std::io::Result<()> {
    let [x, y, z] = grid.cell_counts;
    let word = if encoding == GridEncoding::F32 { "f32" } else { "text" };
    write!(out, "caustica-grid 1\nsize {x} {y} {z}\ntype {word}\n\n")?;
    for row in grid.densities.chunks(x.max(1) as usize) {
        match encoding {
            GridEncoding::F32 => row.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))?,
            GridEncoding::Text => {
                let words: Vec<String> = row.iter().map(f32::to_string).collect();
                writeln!(out, "{}", words.join(" "))?;
            }
        }
    }
    out.flush()
}

/// Parses the header from the first bytes of a file.
///
/// An error holds the line number, from 1, with a message and a remedy.
fn parse_header(start: &[u8]) -> Result<GridHeader, (usize, MessageAndRemedy)> {
    if start.starts_with(b" BDV") {
        return Err((1, ("this is an OpenVDB file".to_owned(), "sample it on a grid, and write that as `type f32`")));
    }
    let (mut size, mut encoding, mut bytes) = (None, None, 0);
    for (i, line) in start.split_inclusive(|byte| *byte == b'\n').enumerate() {
        bytes += line.len();
        let line_error = |message: &str, remedy| (i + 1, (message.to_owned(), remedy));
        let text = std::str::from_utf8(line).map(str::trim).ok();
        let words: Vec<&str> = text.unwrap_or("\u{fffd}").split_whitespace().collect();
        match words[..] {
            ["caustica-grid", "1"] if i == 0 => {}
            ["caustica-grid", _] if i == 0 => return Err(line_error("this version is not known", "write version 1")),
            _ if i == 0 => return Err(line_error("this is no grid", "begin the file with the line `caustica-grid 1`")),
            ["size", x, y, z] if size.is_none() => {
                size = Some(parse_grid_size([x, y, z]).map_err(|problem| (i + 1, problem))?)
            }
            ["type", "f32"] if encoding.is_none() => encoding = Some(GridEncoding::F32),
            ["type", "text"] if encoding.is_none() => encoding = Some(GridEncoding::Text),
            ["type", _] if encoding.is_none() => {
                return Err(line_error("this type is not known", "write `type f32` or `type text`"));
            }
            [] if line.ends_with(b"\n") => {
                let no_size = || line_error("the size is missing", "write `size NX NY NZ` ahead of the empty line");
                let (size, cells) = size.ok_or_else(no_size)?;
                let no_type =
                    || line_error("the type is missing", "write `type f32` or `type text` ahead of the empty line");
                let encoding = encoding.ok_or_else(no_type)?;
                return Ok(GridHeader {
                    size,
                    cell_count: cells,
                    encoding,
                    line_count: i + 1,
                    byte_count: bytes as u64,
                });
            }
            [word, ..] if word.starts_with('#') => {}
            _ => {
                let remedy = "write `size NX NY NZ` and `type f32` or `type text`, each once, then an empty line";
                return Err(line_error("this line says nothing of a grid", remedy));
            }
        }
    }
    let lines = start.split_inclusive(|byte| *byte == b'\n').count();
    let message = "no empty line ends what stands before the numbers".to_owned();
    Err((lines.max(1), (message, "write one after at most 4096 bytes")))
}

/// Parses the three words of a `size` line; returns the size and the number of cells.
fn parse_grid_size(words: [&str; 3]) -> Result<([u32; 3], usize), MessageAndRemedy> {
    let mut size = [0_u32; 3];
    for (side, word) in size.iter_mut().zip(words) {
        let number = word.parse().ok().filter(|n| *n > 0);
        *side = number.ok_or_else(|| {
            (format!("`{}` is no number of cells", escaped_excerpt(word)), "write whole numbers from 1 on")
        })?;
    }
    let product = size.iter().try_fold(1_u64, |product, side| product.checked_mul(u64::from(*side)));
    match product.filter(|cells| *cells <= MAX_CELLS) {
        Some(cells) => Ok((size, cells as usize)),
        None => Err((format!("{} × {} × {} cells are too many", size[0], size[1], size[2]), "at most 2³⁰ may be")),
    }
}

/// Returns the cell coordinates (x, y, z), from 0, of the grid value with index `i`.
fn grid_cell_coordinates(size: [u32; 3], i: usize) -> [u32; 3] {
    let (row, layer) = (size[0] as usize, size[0] as usize * size[1] as usize);
    [i % row, i % layer / row, i / layer].map(|i| i as u32)
}

/// Reader of the densities that follow the header of a grid file.
struct GridBodyReader<'a> {
    path: &'a Path,
    header: &'a GridHeader,
    /// Size of the whole file \[bytes].
    file_size: u64,
    /// Memory that is free \[bytes]; `None` if unknown.
    free_memory: Option<u64>,
}

impl GridBodyReader<'_> {
    /// Returns an empty list with capacity for the densities of all cells.
    ///
    /// Fails if the grid and `more` bytes exceed the free memory, or if the system refuses the
    /// allocation. `more` is the memory of other data, such as the file's text.
    fn allocate_densities(&self, more: u64) -> Result<Vec<f32>, GridError> {
        let Self { path, header, free_memory: free, .. } = *self;
        let needed = MEMORY_PER_CELL * header.cell_count as u64 + more;
        let mut values = Vec::new();
        if free.is_some_and(|free| needed > free) || values.try_reserve_exact(header.cell_count).is_err() {
            return Err(GridError::OutOfMemory { path: path.into(), cells: header.cell_count, needed, free });
        }
        Ok(values)
    }

    fn read_binary_densities(&self, mut from: impl Read) -> Result<Vec<f32>, GridError> {
        let Self { path, header, file_size: length, .. } = *self;
        let (expected, found) = (4 * header.cell_count as u64, length.saturating_sub(header.byte_count));
        if expected != found {
            return Err(GridError::LengthMismatch { path: path.into(), size: header.size, expected, found });
        }
        let mut values = self.allocate_densities(0)?;
        let mut chunk = [0; READ_CHUNK_BYTES];
        while values.len() < header.cell_count {
            let chunk = &mut chunk[..READ_CHUNK_BYTES.min(4 * (header.cell_count - values.len()))];
            from.read_exact(chunk).map_err(|source| GridError::Unreadable { path: path.into(), source })?;
            values.extend(chunk.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)));
        }
        Ok(values)
    }

    fn read_text_densities(&self, mut from: impl Read) -> Result<Vec<f32>, GridError> {
        let Self { path, header, file_size: length, .. } = *self;
        let line_error = |line, message, remedy| GridError::error_at_line(path, line, (message, remedy));
        let count = |found: usize| format!("{found} numbers follow, but the size asks for {}", header.cell_count);
        const REMEDY: &str = "give one number for each cell, x running fastest, and nothing behind them";
        // A value takes at least a digit and a separator.
        let most = length.saturating_sub(header.byte_count).div_ceil(2);
        if most < header.cell_count as u64 {
            return Err(line_error(header.line_count, format!("at most {}", count(most as usize)), REMEDY));
        }
        let mut values = self.allocate_densities(length)?;
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).map_err(|source| GridError::Unreadable { path: path.into(), source })?;
        let mut lines = header.line_count;
        for line in bytes.split(|byte| *byte == b'\n') {
            lines += 1;
            for word in line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
                if values.len() == header.cell_count {
                    return Err(line_error(lines, format!("more than {}", count(header.cell_count)), REMEDY));
                }
                let text = String::from_utf8_lossy(word);
                let number = text.parse().map_err(|_| {
                    line_error(
                        lines,
                        format!("`{}` is no number", escaped_excerpt(&text)),
                        "write numbers, parted by spaces or lines",
                    )
                })?;
                values.push(number);
            }
        }
        if values.len() < header.cell_count {
            return Err(line_error(lines, count(values.len()), REMEDY));
        }
        Ok(values)
    }
}
