//! Truncated, absurd or hostile input: replayed fuzz corpora, counts beyond memory, and limits that
//! hold before allocation.

mod circles;
mod corpus;
mod counts;
mod cuts;
#[cfg(target_os = "linux")]
mod memory;
#[cfg(target_os = "linux")]
mod pipes;
mod readers;

use crate::support::project_path;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A temporary folder in which the program runs.
struct InputSandbox(tempfile::TempDir);

impl InputSandbox {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Writes a file of `length` bytes that begins with `bytes`. The rest is a hole, which takes no
    /// disk space.
    fn put_long(&self, name: &str, bytes: impl AsRef<[u8]>, length: u64) {
        self.put(name, bytes);
        fs::File::options().write(true).open(self.path(name)).unwrap().set_len(length).unwrap();
    }

    /// Runs the program with 2 GB of address space. It dies if it allocates more.
    fn run(&self, arguments: &[&str]) -> Output {
        let program = env!("CARGO_BIN_EXE_caustica");
        let mut command = if cfg!(target_os = "linux") {
            let mut shell = Command::new("sh");
            shell.args(["-c", "ulimit -v 2000000 && exec \"$0\" \"$@\"", program]);
            shell
        } else {
            Command::new(program)
        };
        command.current_dir(self.0.path()).args(arguments).output().unwrap()
    }

    /// Checks that the program refuses `arguments` with exit code `code` and a message that
    /// contains all of `words`.
    #[track_caller]
    fn refused(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let ended = self.run(arguments);
        let text = String::from_utf8_lossy(&ended.stderr);
        let message: String =
            text.replace(['│', '╭', '╰', '─', '▶'], " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ended.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{arguments:?}: `{word}` is not in: {message}"));
    }
}

/// Returns the text of a scene with one light, followed by `more`.
fn scene(more: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0 1 4 direction 0 0 -1 angle 30 width 8 height 6 }} \
         Lights {{ PointLight {{ position 0 3 0 power 9 9 9 }} }} {more}"
    )
}
