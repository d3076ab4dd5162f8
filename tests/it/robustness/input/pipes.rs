//! Named pipes without a writer and endless devices are refused, not waited for.

use super::{InputSandbox, scene};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Runs the program like [`InputSandbox::run`], but kills it after ten seconds; the exit code is
/// then 124.
fn run(sandbox: &InputSandbox, arguments: &[&str]) -> Output {
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -v 2000000 && exec timeout 10 \"$0\" \"$@\"", env!("CARGO_BIN_EXE_caustica")]);
    shell.current_dir(sandbox.path("")).args(arguments).output().unwrap()
}

#[test]
fn endless_files_are_refused_at_once() {
    let sandbox = InputSandbox::new();
    assert!(Command::new("mkfifo").arg(sandbox.path("pipe")).status().unwrap().success());
    sandbox.put("plain.txt", scene("Group { Sphere { center 0 0 0 radius 1 } }"));
    sandbox.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    let mesh = |name: &str| format!("Group {{ TriangleMesh {{ obj_file \"{name}\" materials file }} }}");
    for (name, library) in [("pipe", "pipe"), ("zero", "/dev/zero")] {
        let text = format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
        sandbox.put(&format!("{name}.obj"), text);
        sandbox.put(&format!("{name}.txt"), scene(&mesh(&format!("{name}.obj"))));
    }
    sandbox.put("mesh.txt", scene(&mesh("pipe")));
    let render = |name| ["render", name, "-o", "a.png"];
    for (arguments, words) in [
        (&render("pipe.txt")[..], ["pipe", "check that it is a file"]),
        (&render("zero.txt"), ["/dev/zero", "check that it is a file"]),
        (&render("pipe"), ["a pipe or a device", "check the path"]),
        (&render("/dev/zero"), ["a pipe or a device", "check the path"]),
        (&render("mesh.txt"), ["a pipe or a device", "name a regular file"]),
        (&["mesh", "pipe"], ["pipe", "check that it is a file"]),
        (&["diff", "pipe", "/dev/zero"], ["pipe", "choose a regular file"]),
        (&["study", "plain.txt", "--methods", "raycast", "--truth", "pipe"], ["pipe", "choose a regular file"]),
    ] {
        let start = Instant::now();
        let ended = run(&sandbox, arguments);
        let message = String::from_utf8_lossy(&ended.stderr).replace(['│', '╭', '╰', '─', '▶'], " ");
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ended.status.code(), Some(1), "{arguments:?}: {message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{arguments:?}: `{word}` is not in: {message}"));
        // A run takes milliseconds, or some hundred on a busy machine.
        assert!(start.elapsed() < Duration::from_secs(5), "{arguments:?}");
    }
}
