//! Outputs that collide with other files, and outputs that cannot be written.

use super::CliSandbox;

#[test]
fn outputs_of_one_path_are_refused() {
    let sandbox = CliSandbox::new();
    for (more, parts) in [
        ("-o a.exr -o ./a.exr", &["-o `./a.exr` and -o `a.exr` are the same file"] as &[&str]),
        ("-o a.exr --aov a.exr", &["--aov `a.exr` and -o `a.exr`"]),
        ("-o a.exr --stats a.exr", &["--stats `a.exr` and -o `a.exr`", "help: choose another path for --stats"]),
        ("-o a.exr --stats box.txt", &["--stats `box.txt` and the scene file `box.txt`"]),
    ] {
        sandbox.render("box.txt", more).expect(2, parts);
    }
    assert_eq!(sandbox.names(), ["box.txt"]);
}

#[test]
fn inputs_of_the_scene_are_not_overwritten() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o sky.exr").expect(0, &[]);
    let sky = sandbox.bytes("sky.exr");
    sandbox.put("sky.txt", "PerspectiveCamera { center 0 0 1 lookAt 0 0 0 angle 40 width 8 height 6 }\nLights { EnvironmentLight { file sky.exr } }\nGroup { }\n");
    sandbox.render("sky.txt", "-o sky.exr").expect(2, &["-o `sky.exr` and the input `sky.exr` are the same file"]);
    assert!(sandbox.bytes("sky.exr") == sky);
}

#[cfg(feature = "view")]
#[test]
fn reference_of_the_live_page_is_not_overwritten() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o truth.exr").expect(0, &[]);
    let truth = sandbox.bytes("truth.exr");
    let flags = "--listen --reference truth.exr -o ./truth.exr";
    sandbox.render("box.txt", flags).expect(2, &["-o `./truth.exr` and --reference `truth.exr` are the same file"]);
    assert!(sandbox.bytes("truth.exr") == truth);
}

#[test]
fn diff_and_mesh_keep_their_inputs() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.exr -o b.exr").expect(0, &[]);
    sandbox.run(&["diff", "a.exr", "b.exr", "-o", "b.exr"]).expect(2, &["-o `b.exr` and the reference `b.exr`"]);
    sandbox.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    sandbox.run(&["mesh", "a.obj", "-o", "a.obj"]).expect(2, &["-o `a.obj` and the mesh `a.obj`"]);
}

/// Runs the program with the words of `line` in the sandbox, and creates a folder with the name of
/// the output `blocked` after the first pass. Checks the exit code, and returns the messages.
#[cfg(unix)]
fn render_with_blocked_output(sandbox: &CliSandbox, line: &str, blocked: &str) -> String {
    use std::io::{BufRead, BufReader, Read};
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_caustica"))
        .current_dir(sandbox.path("."))
        .args(line.split(' '))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut words = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("pass 1/8") {
        assert!(words.read_line(&mut said).unwrap() > 0, "{said}");
    }
    std::fs::create_dir(sandbox.path(blocked)).unwrap();
    words.read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(3), "{said}");
    assert!(said.contains("a folder or device of this name exists"), "{said}");
    said
}

/// If a folder with the name of an output appears during the render, only this output fails.
#[cfg(unix)]
#[test]
fn one_failed_output_loses_no_other() {
    let sandbox = CliSandbox::new();
    let line = "render box.txt -o bad.png -o good.png --stats a.json --photons 1k --passes 8";
    let said = render_with_blocked_output(&sandbox, line, "bad.png");
    assert!(said.contains("wrote good.png"), "{said}");
    assert_eq!(sandbox.names(), ["a.json", "bad.png", "box.txt", "good.png"]);
}

/// If a frame cannot be written, the later frames are still rendered and written.
#[cfg(unix)]
#[test]
fn one_failed_frame_loses_no_later_one() {
    let sandbox = CliSandbox::new();
    let line = "render box.txt -o %d.png --frames 0..3 --photons 1k --passes 8";
    let said = render_with_blocked_output(&sandbox, line, "0.png");
    assert!(said.contains("wrote 2.png"), "{said}");
    assert_eq!(sandbox.names(), ["0.png", "1.png", "2.png", "box.txt"]);
}

#[cfg(unix)]
#[test]
fn error_causes_are_printed_once() {
    let sandbox = CliSandbox::new();
    let ended = sandbox.render("box.txt", "-o /proc/a.png");
    ended.expect(3, &["cannot create a file in `/proc`"]);
    assert_eq!(ended.stderr.matches("os error").count(), 1, "{}", ended.stderr);
}

#[test]
fn completions_and_manual_name_every_command() {
    let sandbox = CliSandbox::new();
    let manual = sandbox.run(&["man"]);
    manual.expect(0, &[]);
    let script = sandbox.run(&["completions", "bash"]);
    script.expect(0, &[]);
    for command in ["render", "plan", "estimate", "study", "diff", "mesh", "check", "convert", "completions", "man"] {
        assert!(script.stdout.contains(command) && manual.stdout.contains(command), "{command}");
    }
    assert!(manual.stdout.contains("target\\-error"), "{}", manual.stdout);
}
