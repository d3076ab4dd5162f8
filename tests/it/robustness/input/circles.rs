//! Files that name themselves, as tests of cycles.
//!
//! The scene language cannot include scenes, and material files cannot name meshes, so no cycle can
//! exist.

use super::{InputSandbox, scene};
use caustica::format::{SceneFile, parse};

#[test]
fn scenes_cannot_include_scenes() {
    for word in ["Include", "include", "#include", "Scene"] {
        let text = scene(&format!("{word} \"self.txt\" Group {{ }}"));
        match parse("self.txt", &text) {
            // `#include` begins a comment up to the end of the line, so the scene is empty.
            Err(error) if word == "#include" => assert!(error.to_string().contains("no Group"), "{error}"),
            Err(error) => assert!(error.offending_text() == word && error.remedy().contains("Group"), "{error}"),
            Ok(_) => panic!("`{word}` was read"),
        }
    }
}

#[test]
fn self_referencing_files_are_read_once() {
    let sandbox = InputSandbox::new();
    let resolved = |more: &str| {
        sandbox.put("self.txt", scene(more));
        SceneFile::read(&sandbox.path("self.txt")).unwrap().resolve()
    };
    let mesh = |file: &str, more: &str| format!("Group {{ TriangleMesh {{ obj_file \"{file}\" {more} }} }}");
    // The scene names itself as a mesh. It has no faces.
    let error = resolved(&mesh("self.txt", "")).err().unwrap();
    assert!(error.to_string().contains("no faces"), "{error}");
    // One mesh is its own material file. It also calls itself, as OBJ allows for curves.
    sandbox.put("a.obj", "mtllib a.obj\ncall a.obj\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    assert!(resolved(&mesh("a.obj", "")).is_ok());
    let error = resolved(&mesh("a.obj", "materials file")).err().unwrap();
    assert!(error.to_string().contains("a.obj") && !error.remedy().is_empty(), "{error}");
    // A material whose image is its own file.
    sandbox.put("b.obj", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n");
    sandbox.put("b.mtl", "newmtl red\nmap_Kd b.mtl\n");
    let error = resolved(&mesh("b.obj", "materials file")).err().unwrap();
    assert!(error.to_string().contains("b.mtl") && error.to_string().contains("picture"), "{error}");
}
