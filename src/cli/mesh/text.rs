//! Text table of the properties of a mesh.

use crate::format::mesh::{MeshReport, RepairCounts};
use std::fmt::Write;

/// Returns a text table of the mesh `name`, with one row per property.
///
/// If `after` is given, the table has two columns of values, before and after. Else it has one
/// column. If `repaired` is given, a last line lists the repairs.
pub(super) fn mesh_report_table(
    name: &str,
    before: &MeshReport,
    repaired: Option<&RepairCounts>,
    after: Option<&MeshReport>,
) -> String {
    let mut text = format!("{name}\n");
    // Writing to a string cannot fail.
    if after.is_some() {
        let _ = writeln!(text, "  {:<24} {:>26} {:>26}", "", "before", "after");
    }
    let after = after.map(mesh_report_rows);
    for (i, (label, value)) in mesh_report_rows(before).into_iter().enumerate() {
        let changed = after.as_ref().map_or("", |rows| rows[i].1.as_str());
        let line = format!("  {label:<24} {value:>26} {changed:>26}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
    if !before.materials.is_empty() {
        let _ = writeln!(text, "  materials: {}", before.materials.join(", "));
    }
    if let Some(done) = repaired {
        let parts = [
            (done.welded_positions, "vertices welded"),
            (done.removed_duplicates, "duplicate triangles removed"),
            (done.removed_degenerates, "degenerate triangles removed"),
            (done.flipped_triangles, "triangles reversed"),
        ];
        let done: Vec<String> = parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        let done = if done.is_empty() { "nothing to repair".to_owned() } else { done.join(", ") };
        let _ = writeln!(text, "  {done}");
    }
    text
}

/// Returns the labels and values of a mesh report.
fn mesh_report_rows(report: &MeshReport) -> Vec<(&'static str, String)> {
    let yes = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let point = |p: [f64; 3]| p.map(|x| format!("{x:.4}")).join(" ");
    let or_none = |x: Option<String>| x.unwrap_or_else(|| "-".to_owned());
    vec![
        ("vertices", report.vertices.to_string()),
        ("repeated vertices", report.repeated_vertices.to_string()),
        ("isolated vertices", report.isolated_vertices.to_string()),
        ("triangles", report.triangles.to_string()),
        ("degenerate faces", report.degenerate_triangles.to_string()),
        ("duplicate faces", report.duplicate_triangles.to_string()),
        ("normals", yes(report.has_normals)),
        ("texture coordinates", yes(report.has_texcoords)),
        ("least coordinates", point(report.bounds_min)),
        ("greatest coordinates", point(report.bounds_max)),
        ("area", format!("{:.6e}", report.area)),
        ("volume", or_none(report.volume.map(|volume| format!("{volume:.6e}")))),
        ("closed", yes(report.is_closed)),
        ("boundary edges", report.boundary_edges.to_string()),
        ("manifold", yes(report.is_manifold)),
        ("non-manifold edges", report.non_manifold_edges.to_string()),
        ("non-manifold vertices", report.non_manifold_vertices.to_string()),
        ("orientable", yes(report.is_orientable)),
        ("inconsistent edges", report.inconsistent_edges.to_string()),
        ("components", report.components.to_string()),
        ("Euler characteristic", report.euler_characteristic.to_string()),
        ("genus", or_none(report.genus.map(|genus| genus.to_string()))),
    ]
}
