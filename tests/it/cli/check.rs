//! Tests of `caustica check` and `caustica convert`.

use super::CliSandbox;

#[test]
fn check_reports_all_errors_or_warnings() {
    let sandbox = CliSandbox::new();
    let fine = sandbox.run(&["check", "box.txt"]);
    fine.expect(0, &[]);
    assert!(fine.stdout.ends_with("box.txt: no error, 0 warnings\n"), "{}", fine.stdout);
    sandbox.put("bad.txt", "Group { Spere { } Sphere { center 0 0 0 radius -1 } }\nCamera { }\n");
    let errors = ["did you mean `Sphere`?", "must be above 0", "write `PerspectiveCamera`"];
    sandbox.run(&["check", "bad.txt"]).expect(1, &errors);
    sandbox.run(&["plan", "--check", "bad.txt"]).expect(1, &errors);
    let camera = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 width 8 height 8 }";
    sandbox.put(
        "missing.txt",
        format!("{camera} Group {{ TriangleMesh {{ file a.stl }} TriangleMesh {{ file b.obj }} }}"),
    );
    sandbox.run(&["check", "missing.txt"]).expect(1, &["convert it to OBJ or PLY", "`b.obj` does not exist"]);
    sandbox.put(
        "blind.txt",
        format!("{camera} Materials {{ Mirror m {{ }} }} Group {{ Sphere {{ center 0 0 20 radius 1 }} }}"),
    );
    let blind = sandbox.run(&["check", "blind.txt"]);
    blind.expect(0, &[]);
    assert!(blind.stdout.contains("warning: the camera sees no object"), "{}", blind.stdout);
    let render = sandbox.render("blind.txt", "-o a.png --passes 1");
    render.expect(0, &["warning: the camera sees no object"]);
    let quiet = sandbox.render("blind.txt", "-o a.png --passes 1 --quiet");
    assert!(!quiet.stderr.contains("camera"), "{}", quiet.stderr);
    sandbox.put("scene.fbx", "Kaydara");
    sandbox.run(&["check", "scene.fbx"]).expect(1, &["`.fbx` is no scene format", "export the meshes as OBJ or PLY"]);
}

#[test]
fn convert_refuses_to_overwrite_files() {
    let sandbox = CliSandbox::new();
    sandbox.run(&["convert", "box.txt", "box.txt"]).expect(2, &["are the same file"]);
    sandbox.put("taken.txt", "mine");
    sandbox.run(&["convert", "box.txt", "taken.txt"]).expect(3, &["`taken.txt` exists already", "--force"]);
    sandbox.run(&["convert", "box.txt", "taken.txt", "--force"]).expect(0, &[]);
    sandbox.run(&["convert", "taken.txt", "again.txt"]).expect(0, &[]);
    sandbox.run(&["check", "again.txt"]).expect(0, &[]);
    // A mesh that the scene names is an input too.
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    sandbox.put("corner.obj", mesh);
    let camera = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 width 8 height 8 }";
    sandbox.put("corner.txt", format!("{camera} Group {{ TriangleMesh {{ file corner.obj }} }}"));
    sandbox.run(&["convert", "corner.txt", "corner.obj", "--force"]).expect(2, &["are the same file"]);
    assert_eq!(sandbox.bytes("corner.obj"), mesh.as_bytes());
}

#[test]
fn gltf_scenes_are_read_by_every_command() {
    let sandbox = CliSandbox::new();
    let text = std::fs::read_to_string(crate::support::project_path("tests/data/gltf/cell.gltf")).unwrap();
    sandbox.put("cell.gltf", &text);
    sandbox.run(&["check", "cell.gltf", "--strict"]).expect(0, &[]);
    sandbox.run(&["plan", "cell.gltf", "--size", "8x8"]).expect(0, &[]);
    sandbox.put("cell.dat", &text);
    sandbox.run(&["check", "cell.dat"]).expect(1, &[]);
    sandbox.run(&["check", "cell.dat", "--format", "gltf"]).expect(0, &[]);
    sandbox.run(&["check", "cell.gltf", "--format", "usd"]).expect(2, &["write one of txt, caustica, gltf, glb"]);
    // Each kind of loss gives one warning, which --strict makes an error.
    sandbox.put(
        "sheen.gltf",
        text.replacen("\"doubleSided\": true,", "\"alphaMode\": \"OPAQUE\",", 1).replacen(
            "\"KHR_materials_specular\": {",
            "\"KHR_materials_sheen\": {}, \"KHR_materials_specular\": {",
            1,
        ),
    );
    let check = sandbox.run(&["check", "sheen.gltf"]);
    check.expect(0, &[]);
    assert!(check.stdout.contains("sheen.gltf: warning: sheen is ignored (1×: material `floor`)"), "{}", check.stdout);
    sandbox.run(&["plan", "sheen.gltf"]).expect(0, &["warning: sheen is ignored"]);
    sandbox.run(&["check", "sheen.gltf", "--strict"]).expect(1, &["sheen is ignored", "without --strict"]);
    sandbox.run(&["convert", "sheen.gltf", "-o", "text.txt", "--strict"]).expect(1, &["sheen is ignored"]);
    sandbox.run(&["convert", "sheen.gltf", "-o", "text.txt"]).expect(0, &["warning: sheen is ignored"]);
    sandbox.run(&["check", "text.txt"]).expect(0, &[]);
    for name in ["text-mesh0.ply", "text-mesh2.ply"] {
        assert!(sandbox.names().iter().any(|n| n == name), "{:?}", sandbox.names());
    }
}

#[test]
fn files_of_gltf_scenes_are_inputs() {
    let sandbox = CliSandbox::new();
    let text = std::fs::read_to_string(crate::support::project_path("tests/data/gltf/cell.gltf")).unwrap();
    let start = text.find("data:application").unwrap();
    let end = start + text[start..].find('"').unwrap();
    sandbox.put("cell.gltf", format!("{}missing.bin{}", &text[..start], &text[end..]));
    sandbox.run(&["check", "cell.gltf"]).expect(1, &["buffers[0]: the file `missing.bin` does not exist"]);
    sandbox.put("taken.png", vec![0; 1000]);
    sandbox.put("cell.gltf", format!("{}taken.png{}", &text[..start], &text[end..]));
    let render = sandbox.render("cell.gltf", "-o taken.png");
    render.expect(2, &["are the same file"]);
}
