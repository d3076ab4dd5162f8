//! Why a grid could not be read.

use crate::format::problem::{LineError, Problem};
use crate::stats::bytes;
use std::path::{Path, PathBuf};

/// Why a file of densities could not be read.
#[derive(Debug, thiserror::Error)]
pub enum GridError {
    /// It cannot be opened or read.
    #[error("cannot read the grid {}: {source}: check that it is a file and that you may read it", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line cannot be understood.
    #[error(transparent)]
    Line(#[from] LineError),
    /// The numbers are more or fewer than the size tells.
    #[error(
        "{}: {found} bytes follow the empty line, but {} × {} × {} cells of type f32 take {expected}: write the file anew, or \
         mend its size",
        path.display(), size[0], size[1], size[2]
    )]
    Length {
        /// The file.
        path: PathBuf,
        /// Cells along x, y and z.
        size: [u32; 3],
        /// Bytes that the cells take.
        expected: u64,
        /// Bytes that are there.
        found: u64,
    },
    /// A number that is no density.
    #[error(
        "{}: the density of cell ({}, {}, {}), counted from 0, is {value}: it must be finite and at least 0",
        path.display(), cell[0], cell[1], cell[2]
    )]
    Cell {
        /// The file.
        path: PathBuf,
        /// Column, row and layer.
        cell: [u32; 3],
        /// Its density.
        value: f32,
    },
    /// More cells than there is memory for.
    #[error(
        "{}: {cells} cells take {} of memory, and {} are free: make the grid coarser, or let it have more (--memory)",
        path.display(), bytes(*needed), free.map_or("less".to_owned(), bytes)
    )]
    NoMemory {
        /// The file.
        path: PathBuf,
        /// How many.
        cells: usize,
        /// Bytes that they take, with what reading them takes.
        needed: u64,
        /// Bytes that may be taken, where that number is known.
        free: Option<u64>,
    },
}

impl GridError {
    pub(super) fn line(path: &Path, line: usize, problem: Problem) -> Self {
        Self::Line(LineError::new(path, line, problem))
    }
}
