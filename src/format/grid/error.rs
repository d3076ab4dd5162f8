//! Reasons why a density grid file cannot be read.

use crate::format::line_error::{LineError, MessageAndRemedy};
use crate::stats::format_bytes;
use std::path::{Path, PathBuf};

/// Reason why a density grid file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum GridError {
    /// The file cannot be opened or read.
    #[error("cannot read the grid {}: {source}: check that it is a file and that you may read it", path.display())]
    Unreadable {
        /// Path of the grid file.
        path: PathBuf,
        /// Cause reported by the system.
        source: std::io::Error,
    },
    /// A line of the file is invalid.
    #[error(transparent)]
    InvalidLine(#[from] LineError),
    /// The file is longer or shorter than its `size` line implies.
    #[error(
        "{}: {found} bytes follow the empty line, but {} × {} × {} cells of type f32 take {expected}: write the file anew, or \
         correct its size",
        path.display(), size[0], size[1], size[2]
    )]
    LengthMismatch {
        /// Path of the grid file.
        path: PathBuf,
        /// Cells along x, y and z.
        size: [u32; 3],
        /// Length of the densities \[bytes], as it follows from the number of cells in the `size`
        /// line.
        expected: u64,
        /// Length of the part of the file after the header \[bytes].
        found: u64,
    },
    /// A density is negative or not finite.
    #[error(
        "{}: the density of cell ({}, {}, {}), counted from 0, is {value}: it must be finite and at least 0",
        path.display(), cell[0], cell[1], cell[2]
    )]
    InvalidDensity {
        /// Path of the grid file.
        path: PathBuf,
        /// Cell coordinates along x, y and z, from 0.
        cell: [u32; 3],
        /// The invalid density.
        value: f32,
    },
    /// The grid takes more memory than is free.
    #[error(
        "{}: {cells} cells take {} of memory, and {} are free: make the grid coarser, or let it have more (--memory)",
        path.display(), format_bytes(*needed), free.map_or("less".to_owned(), format_bytes)
    )]
    OutOfMemory {
        /// Path of the grid file.
        path: PathBuf,
        /// Number of cells of the grid.
        cells: usize,
        /// Memory that reading the grid takes \[bytes].
        needed: u64,
        /// Memory that is free \[bytes]. `None` if this is unknown; then the system refused the
        /// allocation.
        free: Option<u64>,
    },
}

impl GridError {
    pub(super) fn error_at_line(path: &Path, line: usize, problem: MessageAndRemedy) -> Self {
        Self::InvalidLine(LineError::new(path, line, problem))
    }
}
