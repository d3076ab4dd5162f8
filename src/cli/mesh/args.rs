//! Arguments of `caustica mesh`: mesh files, and the repairs to make.

use crate::cli::value_parsers::{
    parse_bytes, parse_degrees, parse_nonnegative_length, parse_point, parse_positive_factor,
};
use clap::Args;
use glam::DVec3;
use std::path::PathBuf;

/// Arguments of `mesh`.
#[derive(Debug, Args)]
pub struct MeshArguments {
    /// Mesh file: .obj or .ply
    pub mesh: PathBuf,

    /// File to write: .obj or .ply
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Write PLY as text
    #[arg(long)]
    pub ascii: bool,

    /// Do all repairs: --weld, --remove-duplicates, --remove-degenerate and --orient
    #[arg(long)]
    pub repair: bool,

    /// Merge vertices at most this far apart, in units of the written mesh (after
    /// --scale)  [default with --repair: 1e-9 of the mesh's diagonal]
    #[arg(long, value_parser = parse_nonnegative_length, value_name = "LENGTH")]
    pub weld: Option<f64>,

    /// Remove triangles that have the same vertices as an earlier triangle
    #[arg(long)]
    pub remove_duplicates: bool,

    /// Remove triangles whose area is zero
    #[arg(long)]
    pub remove_degenerate: bool,

    /// Give neighboring triangles the same winding; triangles of closed surfaces face outward
    #[arg(long)]
    pub orient: bool,

    /// Reverse the winding of all triangles and the sign of all normals, after --orient
    #[arg(long)]
    pub flip: bool,

    /// Compute new vertex normals. Edges are shaded smooth if the normals of their two faces differ
    /// by at most this many degrees, else sharp
    #[arg(long, value_parser = parse_degrees, value_name = "ANGLE")]
    pub smooth: Option<f64>,

    /// Remove the vertex normals, so that faces are shaded flat
    #[arg(long, conflicts_with = "smooth")]
    pub flat: bool,

    /// Scale by this factor about the origin, before all other changes
    #[arg(long, value_parser = parse_positive_factor, value_name = "FACTOR")]
    pub scale: Option<f64>,

    /// Move the mesh by this vector, after --scale
    #[arg(long, value_parser = parse_point, allow_hyphen_values = true, value_name = "X,Y,Z")]
    pub translate: Option<DVec3>,

    /// Memory limit of the program, such as 4G or 512M. A mesh that needs more is refused before it
    /// is read  [default: the free memory]
    #[arg(long, value_parser = parse_bytes, value_name = "SIZE")]
    pub memory: Option<u64>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Print only the report, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

impl MeshArguments {
    /// True if the arguments change the mesh.
    pub(super) fn changes_mesh(&self) -> bool {
        let repairs = self.repair || self.weld.is_some() || self.remove_duplicates || self.remove_degenerate;
        let normals = self.smooth.is_some() || self.flat;
        repairs || self.orient || self.flip || normals || self.scale.is_some() || self.translate.is_some()
    }
}
