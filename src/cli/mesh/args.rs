//! What can be typed after `caustica mesh`.

use crate::cli::number::{above_zero, bytes, degrees, distance, point};
use clap::Args;
use glam::DVec3;
use std::path::PathBuf;

/// Arguments of `mesh`.
#[derive(Debug, Args)]
pub struct MeshArguments {
    /// The mesh: .obj or .ply
    pub mesh: PathBuf,

    /// Where to write: .obj or .ply
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Write PLY as text
    #[arg(long)]
    pub ascii: bool,

    /// Repair all: --weld, --remove-duplicates, --remove-degenerate and --orient
    #[arg(long)]
    pub repair: bool,

    /// Make vertices one that are at most this far apart, in units of the file  [default: with --repair 1e-9 of the diagonal]
    #[arg(long, value_parser = distance, value_name = "LENGTH")]
    pub weld: Option<f64>,

    /// Remove triangles on the corners of an earlier one
    #[arg(long)]
    pub remove_duplicates: bool,

    /// Remove triangles without area
    #[arg(long)]
    pub remove_degenerate: bool,

    /// Make windings agree, closed surfaces facing outward
    #[arg(long)]
    pub orient: bool,

    /// Turn all triangles and normals around, after --orient
    #[arg(long)]
    pub flip: bool,

    /// Give new normals: smooth over edges of at most this many degrees
    #[arg(long, value_parser = degrees, value_name = "ANGLE")]
    pub smooth: Option<f64>,

    /// Leave out normals
    #[arg(long, conflicts_with = "smooth")]
    pub flat: bool,

    /// Scale about the origin, before anything else
    #[arg(long, value_parser = above_zero, value_name = "FACTOR")]
    pub scale: Option<f64>,

    /// Move, after --scale
    #[arg(long, value_parser = point, allow_hyphen_values = true, value_name = "X,Y,Z")]
    pub translate: Option<DVec3>,

    /// Most memory to take, such as 4G or 512M: a mesh that would take more is refused before it is read  [default: what is free]
    #[arg(long, value_parser = bytes, value_name = "SIZE")]
    pub memory: Option<u64>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Say nothing but the report, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

impl MeshArguments {
    /// Whether the mesh is to be changed.
    pub(super) fn changes(&self) -> bool {
        let repairs = self.repair || self.weld.is_some() || self.remove_duplicates || self.remove_degenerate;
        let normals = self.smooth.is_some() || self.flat;
        repairs || self.orient || self.flip || normals || self.scale.is_some() || self.translate.is_some()
    }
}
