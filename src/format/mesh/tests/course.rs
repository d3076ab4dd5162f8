//! The course's meshes.

use super::super::{Repair, load};
use std::path::PathBuf;

#[test]
fn the_course_meshes_are_repaired_without_loss() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/course/mesh");
    if !folder.exists() {
        eprintln!("skipped: {} is absent", folder.display());
        return;
    }
    // Closed surfaces: Euler's formula gives the vertices from the triangles.
    for (name, triangles) in
        [("cube.obj", 12), ("bunny_200.obj", 200), ("bunny_1k.obj", 1000), ("bunny_1k_vn.obj", 1000)]
    {
        let mut mesh = load(&folder.join(name), &()).unwrap().mesh;
        let before = mesh.report();
        assert!(before.closed && before.manifold && before.orientable, "{name}");
        assert_eq!((before.triangles, before.components, before.genus), (triangles, 1, Some(0)), "{name}");
        assert_eq!(before.vertices, triangles / 2 + 2, "{name}");
        assert!(before.volume.unwrap() > 0.0, "{name}");
        let weld = Some(Repair::WELD * mesh.diagonal());
        let repaired = mesh.repair(&Repair { weld, duplicates: true, degenerate: true, orient: true });
        assert_eq!((repaired, mesh.report()), (Default::default(), before), "{name}");
    }
}
