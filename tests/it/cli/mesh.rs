//! Tests of `caustica mesh`.

use super::{CliSandbox, ProgramRun};
use serde_json::Value;

/// OBJ file of a box of 2 × 2 × 1 with two materials and faults.
///
/// One face has reversed winding, one occurs twice, and one has no area. One vertex is unused.
const WORN: &str = "mtllib worn.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nv 0 0 1\nv 2 0 1\nv 0 2 1\nv 2 2 1\nv 9 9 9\nv 2 2 1\n\
usemtl red\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nusemtl glass\nf 3 4 10 7\nf 1 5 7 3\nf 2 4 8 6\nf 2 6 8 4\nf 1 1 2\n";

fn sandbox() -> CliSandbox {
    let sandbox = CliSandbox::new();
    sandbox.put("worn.obj", WORN);
    sandbox.put("worn.mtl", "newmtl red\nKd .8 .1 .1\nmap_Kd red.png\nnewmtl glass\nNi 1.5\nillum 7\n");
    sandbox
}

fn run(sandbox: &CliSandbox, line: &str) -> ProgramRun {
    sandbox.run(&line.split_whitespace().collect::<Vec<_>>())
}

fn report(sandbox: &CliSandbox, line: &str) -> Value {
    let ended = run(sandbox, &format!("mesh {line} --json"));
    ended.expect(0, &[]);
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn mesh_report_lists_defects() {
    let sandbox = sandbox();
    let report = report(&sandbox, "worn.obj");
    assert!(report["after"].is_null() && report["repaired"].is_null() && report["schema"] == 1);
    let before = &report["before"];
    for (field, value) in [
        ("vertices", 10),
        ("isolated_vertices", 1),
        ("repeated_vertices", 1),
        ("triangles", 15),
        ("duplicate_faces", 2),
        ("degenerate_faces", 1),
        ("non_manifold_edges", 5),
        ("boundary_edges", 0),
        ("components", 1),
    ] {
        assert_eq!(before[field], value, "{field}");
    }
    assert_eq!(before["materials"], serde_json::json!(["red", "glass"]));
    assert_eq!((&before["manifold"], &before["volume"]), (&Value::Bool(false), &Value::Null));
    let table = run(&sandbox, "mesh worn.obj");
    table.expect(0, &[]);
    assert!(
        table.stdout.starts_with("worn.obj\n") && table.stdout.contains("materials: red, glass"),
        "{}",
        table.stdout
    );
    assert!(table.stdout.lines().all(|line| line.chars().count() <= 80), "{}", table.stdout);
}

#[test]
fn repaired_mesh_is_equal_in_every_format() {
    let sandbox = sandbox();
    let mut reports = Vec::new();
    for output in ["a.obj", "b.ply", "c.ply --ascii"] {
        let repaired = report(&sandbox, &format!("worn.obj --repair --smooth 30 -o {output}"));
        let after = &repaired["after"];
        for (field, value) in [("triangles", 12), ("vertices", 24), ("genus", 0), ("euler_characteristic", 2)] {
            assert_eq!(after[field], value, "{field}");
        }
        assert_eq!((&after["closed"], &after["volume"], &after["area"]), (&true.into(), &4.0.into(), &16.0.into()));
        assert_eq!(repaired["repaired"]["duplicates"], 2);
        assert_eq!(repaired["repaired"]["degenerate"], 1);
        assert!(repaired["repaired"]["turned"].as_u64() > Some(0));
        let mut again = report(&sandbox, output.trim_end_matches(" --ascii"))["before"].clone();
        // OBJ counts positions as vertices, and PLY holds no materials. These two numbers may
        // differ.
        again["vertices"] = 24.into();
        again["materials"] = after["materials"].clone();
        assert_eq!(again, *after, "{output}");
        reports.push(again);
    }
    let table = run(&sandbox, "mesh worn.obj --orient --remove-duplicates --remove-degenerate");
    table.expect(0, &[]);
    assert!(table.stdout.contains("2 duplicate triangles removed, 1 degenerate"), "{}", table.stdout);
    assert!(table.stdout.lines().nth(1).unwrap().trim_end().ends_with("after"));
    assert!(run(&sandbox, "mesh a.obj --repair").stdout.contains("nothing to repair"));
}

#[test]
fn meshes_are_transformed_and_flattened() {
    let sandbox = sandbox();
    let fine = report(&sandbox, "worn.obj --repair --scale 2 --translate -1,0,.5 -o a.ply")["after"].clone();
    assert_eq!(
        (&fine["min"], &fine["max"]),
        (&serde_json::json!([-1.0, 0.0, 0.5]), &serde_json::json!([3.0, 4.0, 2.5]))
    );
    assert_eq!(fine["volume"], 32.0);
    assert_eq!(report(&sandbox, "a.ply --flip")["after"]["volume"], -32.0);
    assert_eq!(report(&sandbox, "a.ply --smooth 90 -o b.ply")["after"]["normals"], true);
    assert_eq!(report(&sandbox, "b.ply --flat")["after"]["normals"], false);
    assert_eq!(report(&sandbox, "b.ply --weld 1.9 --remove-degenerate")["repaired"]["welded"], 0);
    assert_eq!(report(&sandbox, "b.ply --weld 2.1")["repaired"]["welded"], 4);
}

#[test]
fn obj_output_brings_its_materials() {
    let sandbox = sandbox();
    run(&sandbox, "mesh worn.obj -o beside.obj").expect(0, &["wrote beside.obj"]);
    let text = |name: &str| String::from_utf8(sandbox.bytes(name)).unwrap();
    assert!(text("beside.obj").contains("mtllib worn.mtl\n"));
    assert!(!sandbox.names().contains(&"beside.mtl".to_owned()));
    std::fs::create_dir(sandbox.path("far")).unwrap();
    run(&sandbox, "mesh worn.obj -o far/out.obj --quiet").expect(0, &[]);
    assert!(text("far/out.obj").contains("mtllib out.mtl\n") && text("far/out.mtl").contains("newmtl glass\nNi 1.5\n"));
    // The material file is now in another folder than the image, so the path of the image is
    // absolute.
    assert!(text("far/out.mtl").lines().any(|line| line.starts_with("map_Kd /") && line.ends_with("red.png")));
    let bare = text("far/out.mtl").lines().filter(|line| !line.contains(".png")).collect::<Vec<_>>().join("\n");
    sandbox.put("far/out.mtl", bare);
    sandbox
        .put("glassy.txt", super::BOX.replace("Group {", "Group { TriangleMesh { file far/out.obj materials file }"));
    sandbox.render("glassy.txt", "-o a.png").expect(0, &["wrote a.png"]);
    run(&sandbox, "mesh worn.obj -o far/out.ply").expect(0, &["note: PLY cannot hold materials"]);
    std::fs::remove_file(sandbox.path("worn.mtl")).unwrap();
    run(&sandbox, "mesh worn.obj -o far/out.obj").expect(0, &["warning: materials are named but not written"]);
    assert!(!text("far/out.obj").contains("mtllib") && text("far/out.obj").contains("usemtl glass"));
}

#[test]
fn impossible_mesh_requests_are_refused() {
    let sandbox = sandbox();
    run(&sandbox, "mesh none.obj").expect(1, &["there is no mesh file none.obj"]);
    sandbox.put("bad.obj", "v 0 0 0\nf 1 2 3\n");
    run(&sandbox, "mesh bad.obj -o a.ply").expect(1, &["bad.obj:2: `2` names no vertex"]);
    sandbox.put("bad.ply", "ply\nformat ascii 1.0\nelement vertex 4294967295\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
    run(&sandbox, "mesh bad.ply").expect(1, &["bad.ply:3: 4294967295 times `vertex` need"]);
    sandbox.put("thin.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    run(&sandbox, "mesh thin.obj --remove-degenerate -o a.ply")
        .expect(1, &["the repair leaves no triangle of `thin.obj`"]);
    run(&sandbox, "mesh worn.obj --scale 1e308 --translate 1e308,0,0").expect(2, &["are too large"]);
    run(&sandbox, "mesh worn.obj -o a.stl").expect(3, &["`a.stl` has no extension of a mesh format", ".obj or .ply"]);
    run(&sandbox, "mesh worn.obj -o none/a.ply").expect(3, &["there is no folder"]);
    for wrong in ["--smooth 181", "--weld -1", "--scale 0", "--translate 1,2", "--flat --smooth 3", "--spp 3"] {
        assert_eq!(run(&sandbox, &format!("mesh worn.obj {wrong}")).code, Some(2), "{wrong}");
    }
    assert_eq!(run(&sandbox, "mesh").code, Some(2));
    assert_eq!(sandbox.names(), ["bad.obj", "bad.ply", "box.txt", "thin.obj", "worn.mtl", "worn.obj"]);
}
