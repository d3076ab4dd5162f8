//! Tests of `caustica check` and `caustica convert`.

use super::Workshop;

#[test]
fn check_reports_all_errors_or_warnings() {
    let shop = Workshop::new();
    let fine = shop.run(&["check", "box.txt"]);
    fine.expect(0, &[]);
    assert!(fine.stdout.ends_with("box.txt: no error, 0 warnings\n"), "{}", fine.stdout);
    shop.put("bad.txt", "Group { Spere { } Sphere { center 0 0 0 radius -1 } }\nCamera { }\n");
    let errors = ["did you mean `Sphere`?", "must be above 0", "write `PerspectiveCamera`"];
    shop.run(&["check", "bad.txt"]).expect(1, &errors);
    shop.run(&["plan", "--check", "bad.txt"]).expect(1, &errors);
    let camera = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 width 8 height 8 }";
    shop.put(
        "missing.txt",
        format!("{camera} Group {{ TriangleMesh {{ file a.stl }} TriangleMesh {{ file b.obj }} }}"),
    );
    shop.run(&["check", "missing.txt"]).expect(1, &["convert it to OBJ or PLY", "`b.obj` does not exist"]);
    shop.put(
        "blind.txt",
        format!("{camera} Materials {{ Mirror m {{ }} }} Group {{ Sphere {{ center 0 0 20 radius 1 }} }}"),
    );
    let blind = shop.run(&["check", "blind.txt"]);
    blind.expect(0, &[]);
    assert!(blind.stdout.contains("warning: the camera sees no object"), "{}", blind.stdout);
    shop.put("scene.glb", "glTF");
    shop.run(&["check", "scene.glb"]).expect(1, &["`.glb` is no scene format", "export the meshes as OBJ or PLY"]);
}

#[test]
fn convert_refuses_to_overwrite_files() {
    let shop = Workshop::new();
    shop.run(&["convert", "box.txt", "box.txt"]).expect(2, &["are the same file"]);
    shop.put("taken.txt", "mine");
    shop.run(&["convert", "box.txt", "taken.txt"]).expect(3, &["`taken.txt` exists already", "--force"]);
    shop.run(&["convert", "box.txt", "taken.txt", "--force"]).expect(0, &[]);
    shop.run(&["convert", "taken.txt", "again.txt"]).expect(0, &[]);
    shop.run(&["check", "again.txt"]).expect(0, &[]);
}
