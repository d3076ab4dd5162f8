//! SIGTERM and SIGHUP end a render like Ctrl-C.
#![cfg(target_os = "linux")]

use super::CliSandbox;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

/// Starts a shell command and reads its messages until the second pass.
fn start(sandbox: &CliSandbox, prefix: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let program = env!("CARGO_BIN_EXE_caustica");
    let line = format!("{prefix} exec {program} render box.txt -o a.exr --photons 1k --passes 1M");
    let mut child =
        Command::new("sh").current_dir(sandbox.path(".")).args(["-c", &line]).stderr(Stdio::piped()).spawn().unwrap();
    let mut words = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("pass 2/") {
        assert!(words.read_line(&mut said).unwrap() > 0, "{said}");
    }
    (child, words)
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn terminate_and_hang_up_write_the_picture() {
    for signal in ["-TERM", "-HUP"] {
        let sandbox = CliSandbox::new();
        let (mut child, mut words) = start(&sandbox, "");
        send(&child, signal);
        let mut rest = String::new();
        words.read_to_string(&mut rest).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}: {rest}");
        assert!(rest.contains("wrote a.exr"), "{signal}: {rest}");
    }
}

#[test]
fn an_ignored_hang_up_stays_ignored() {
    let sandbox = CliSandbox::new();
    let (mut child, mut words) = start(&sandbox, "trap '' HUP;");
    send(&child, "-HUP");
    let mut said = String::new();
    for _ in 0..20 {
        assert!(words.read_line(&mut said).unwrap() > 0, "{said}");
    }
    assert!(!said.contains("interrupted"), "{said}");
    send(&child, "-TERM");
    words.read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
}
