//! SIGTERM and SIGHUP end a render like Ctrl-C. SIGKILL leaves the picture of the last update.
#![cfg(target_os = "linux")]

use super::{CliSandbox, read};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

/// Starts a render with `flags`, and reads its messages until the second pass.
///
/// `launcher` holds shell words that precede the program, such as `nohup`.
fn start(sandbox: &CliSandbox, launcher: &str, flags: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let program = env!("CARGO_BIN_EXE_caustica");
    let line = format!("{launcher} {program} render box.txt -o a.exr --photons 1k --passes 1M --time 120s {flags}");
    let mut child =
        Command::new("sh").current_dir(sandbox.path(".")).args(["-c", &line]).stderr(Stdio::piped()).spawn().unwrap();
    let mut words = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("pass 2/") {
        assert!(words.read_line(&mut said).unwrap() > 0, "{said}");
    }
    (child, words)
}

/// Launcher that restores the default action of SIGHUP and SIGTERM.
const DEFAULT_SIGNALS: &str = "exec env --default-signal=HUP,TERM";

/// True if `env` can restore the default actions of signals (GNU coreutils 8.31 and later).
fn env_restores_signals() -> bool {
    let env = Command::new("env").args(["--default-signal=HUP,TERM", "true"]).stderr(Stdio::null()).status();
    env.is_ok_and(|status| status.success())
}

/// True if this process ignores SIGHUP, for example under `nohup`. Programs that it starts inherit
/// this.
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(ignored.trim(), 16).unwrap() & 1 != 0
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn terminate_and_hang_up_write_the_picture() {
    let launcher = if env_restores_signals() { DEFAULT_SIGNALS } else { "exec" };
    for signal in ["-TERM", "-HUP"] {
        if signal == "-HUP" && launcher != DEFAULT_SIGNALS && hang_up_is_ignored() {
            eprintln!("skipped the case of SIGHUP: this process ignores it, and `env` cannot restore it");
            continue;
        }
        let sandbox = CliSandbox::new();
        let (mut child, mut words) = start(&sandbox, launcher, "");
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
    let (mut child, mut words) = start(&sandbox, "trap '' HUP; exec", "");
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

#[test]
fn killed_renders_leave_the_last_update() {
    for (flags, is_updated) in [("", true), ("--update 0", false)] {
        let sandbox = CliSandbox::new();
        let (mut child, _words) = start(&sandbox, "exec", flags);
        send(&child, "-KILL");
        assert_eq!(child.wait().unwrap().code(), None);
        assert_eq!(sandbox.path("a.exr").exists(), is_updated, "{flags}");
        if is_updated {
            let picture = read(&sandbox.path("a.exr"));
            assert_eq!((picture.width(), picture.height()), (40, 30));
        }
    }
}
