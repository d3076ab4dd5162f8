//! Every documented exit code, and its message.

use super::{BOX, CliSandbox};
use std::time::{Duration, Instant};

#[test]
fn help_and_version_succeed() {
    let sandbox = CliSandbox::new();
    for arguments in [["--help"].as_slice(), &["--version"], &["render", "--help"], &["help", "render"]] {
        let ended = sandbox.run(arguments);
        ended.expect(0, &[]);
        assert!(ended.stdout.contains("caustica"), "{}", ended.stdout);
    }
}

#[test]
fn unreadable_scene_exits_1() {
    let sandbox = CliSandbox::new();
    sandbox.render("none.txt", "-o a.png").expect(1, &["none.txt", "help: check the path"]);
    sandbox.render(".", "-o a.png").expect(1, &["cannot read `.`"]);
    sandbox.put("garbage.txt", [0x7f, b'E', b'L', b'F', 0, 0xff, 0xfe, 0x80, b'\n', 0]);
    sandbox
        .render("garbage.txt", "-o a.png")
        .expect(1, &["garbage.txt:1:6:", "not UTF-8", "help: save the file as UTF-8"]);
    sandbox.put("words.txt", "\0\0\0\0{{{");
    sandbox.render("words.txt", "-o a.png").expect(1, &["words.txt:1:1:", "help:"]);
    sandbox.put("empty.txt", "");
    sandbox.render("empty.txt", "-o a.png").expect(1, &["empty.txt:1:1:", "help:"]);
    assert!(!sandbox.path("a.png").exists());
}

#[test]
fn syntax_error_exits_1_with_snippet_and_help() {
    let sandbox = CliSandbox::new();
    sandbox.put("typo.txt", BOX.replace("  Sphere { center -.4", "  Spere { center -.4"));
    let parts =
        ["typo.txt:19:25: unexpected `Spere`", "MaterialName glass Spere { center", "help: did you mean `Sphere`?"];
    sandbox.render("typo.txt", "-o a.png").expect(1, &parts);
}

#[test]
fn resolve_errors_exit_1() {
    let sandbox = CliSandbox::new();
    let scene = |body: &str| {
        sandbox.put(
            "a.txt",
            format!("PerspectiveCamera {{ center 0 0 5 lookAt 0 0 0 angle 30 }}\nGroup {{\n{body}\n}}\n"),
        );
        sandbox.render("a.txt", "-o a.png")
    };
    let missing = scene("  TriangleMesh { obj_file mesh/no.obj }");
    missing.expect(1, &["a.txt:3:27: the mesh `mesh/no.obj` does not exist", "help: put the file at `mesh/no.obj` or"]);
    sandbox.put("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n");
    scene("  TriangleMesh { obj_file bad.obj }").expect(1, &["a.txt:3:27:", "bad.obj:3:", "help:"]);
    let flat = scene(
        "  Transform { Scale 1e-9 1 1 Transform { Scale 1e-9 1 1 ZRotate 30 Scale 1 1e9 1 Sphere { center 0 0 0 radius 1 } } }",
    );
    flat.expect(1, &["a.txt:3:", "singular", "help: no scale may be zero"]);
    scene("  MaterialName glass").expect(1, &["a.txt:3:", "glass", "help:"]);
    scene("  Plane { normal 0 1 0 offset 0 emission 1 1 1 }").expect(1, &["a.txt:3:3: an infinite plane cannot emit"]);
    assert!(!sandbox.path("a.png").exists());
}

#[test]
fn bad_arguments_exit_2() {
    let sandbox = CliSandbox::new();
    sandbox.run(&[]).expect(2, &["Usage"]);
    sandbox.run(&["rendr"]).expect(2, &["rendr"]);
    sandbox.run(&["render", "box.txt"]).expect(2, &["--output"]);
    for (more, parts) in [
        ("--photon 1k", ["--photon", "--photons"].as_slice()),
        ("--photons many", &["`many` is not a count", "250k"]),
        ("--photons -1", &["-1"]),
        ("--photons 1.5", &["`1.5` is not a count"]),
        ("--photons 5000M", &["`5000M` is too large: the largest count is 4294967295"]),
        ("--passes 0", &["at least 1"]),
        ("--spp 0", &["at least 1"]),
        ("--threads 0", &["at least 1"]),
        ("--threads 1M", &["at most 1024"]),
        ("--time soon", &["`soon` is not a time", "1.5m"]),
        ("--size 0x10", &["1 to 65536"]),
        ("--size 10", &["`10` is not a size", "1280x720"]),
        ("--radius 0", &["above 0"]),
        ("--kernel sphere", &["`sphere`", "box", "cone", "epanechnikov"]),
        ("--filter bok", &["`bok`", "gaussian"]),
        ("--tone gamma", &["`gamma`", "srgb", "filmic", "course"]),
        ("--integrator bdpt", &["bdpt", "pm", "raycast"]),
        ("--exposure nan", &["`nan` is not an exposure", "-64 to 64"]),
        ("--exposure inf", &["`inf` is not an exposure"]),
        ("--exposure 65", &["`65` is not an exposure"]),
        ("--png-bits 12", &["8 or 16"]),
        ("--seed -1", &["-1"]),
        ("--seed 18446744073709551616", &["from 0 to 18446744073709551615"]),
        ("--target-error 2", &["do you mean 2 %"]),
        ("--size 8x8 --size 9x9", &["--size"]),
    ] {
        sandbox.render("box.txt", &format!("-o a.png {more}")).expect(2, parts);
    }
    assert_eq!(sandbox.names(), ["box.txt"]);
}

/// A render that is too large for any machine ends at once, with exit code 2.
///
/// 4000 million paths in a closed box would store about ten thousand million photons, which is more
/// than the program can index.
#[test]
fn excessive_memory_exits_2_at_once() {
    let sandbox = CliSandbox::new();
    let start = Instant::now();
    let photons = sandbox.render("box.txt", "-o a.png --integrator sppm --photons 4000M --caustic-photons 0");
    photons.expect(2, &["4000000000 photon paths", "help: choose fewer --photons"]);
    let picture = sandbox.render("box.txt", "-o a.png --size 16385x16384");
    picture.expect(2, &["16385", "268435456 pixels", "help: choose a smaller --size"]);
    sandbox.render("box.txt", "-o a.png --size 65536x65536").expect(2, &["65536"]);
    assert!(start.elapsed() < Duration::from_secs(30));
    assert_eq!(sandbox.names(), ["box.txt"]);
}

/// An output that cannot be written ends the program with exit code 3 before the render.
///
/// The render would take minutes, longer than the time limit of a run.
#[test]
fn unwritable_output_exits_3_before_rendering() {
    let sandbox = CliSandbox::new();
    std::fs::create_dir(sandbox.path("folder.png")).unwrap();
    let long = "--spp 100k --passes 1k";
    sandbox.render("box.txt", &format!("-o a.jpg {long}")).expect(3, &["`a.jpg`", ".png or .exr"]);
    sandbox.render("box.txt", &format!("-o a.png -o b {long}")).expect(3, &["`b`", ".png or .exr"]);
    sandbox.render("box.txt", &format!("-o no/a.png {long}")).expect(3, &["no folder `no`", "create it"]);
    sandbox.render("box.txt", &format!("-o folder.png {long}")).expect(3, &["a folder or device of this name exists"]);
    sandbox.render("box.txt", &format!("-o a.png --stats no/a.json {long}")).expect(3, &["no folder `no`"]);
    sandbox
        .render("box.txt", &format!("-o a.png --stats folder.png {long}"))
        .expect(3, &["`folder.png`", "folder or device"]);
    assert_eq!(sandbox.names(), ["box.txt", "folder.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn read_only_folder_exits_3_before_rendering() {
    let sandbox = CliSandbox::new();
    let long = "--spp 100k --passes 1k";
    sandbox.render("box.txt", &format!("-o /proc/a.png {long}")).expect(3, &["cannot create a file in `/proc`"]);
    sandbox.render("box.txt", &format!("-o a.png --stats /proc/a.json {long}")).expect(3, &["`/proc`"]);
}

#[test]
fn failed_render_keeps_old_files() {
    let sandbox = CliSandbox::new();
    sandbox.put("a.png", "old picture");
    sandbox.put("a.json", "old report");
    sandbox.put("typo.txt", BOX.replace("Sphere", "Spere"));
    sandbox.render("typo.txt", "-o a.png --stats a.json").expect(1, &[]);
    sandbox.render("box.txt", "-o a.png -o a.gif --stats a.json").expect(3, &[]);
    sandbox.render("box.txt", "-o a.png --stats a.json --photons 4000M").expect(2, &[]);
    assert_eq!((sandbox.bytes("a.png"), sandbox.bytes("a.json")), (b"old picture".to_vec(), b"old report".to_vec()));
    sandbox.render("box.txt", "-o a.png --stats a.json").expect(0, &[]);
    assert!(sandbox.bytes("a.png").starts_with(b"\x89PNG") && sandbox.bytes("a.json").starts_with(b"{"));
    assert_eq!(sandbox.names(), ["a.json", "a.png", "box.txt", "typo.txt"]);
}
