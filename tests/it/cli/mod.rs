//! The program from outside: its output, messages and exit codes.

mod check;
mod diff;
mod errors;
mod exits;
mod farm;
mod files;
mod film;
mod frames;
mod interrupt;
mod limits;
mod mesh;
mod methods;
mod outputs;
mod repeat;
mod scenes;
mod signals;
mod stats;
mod stereo;
mod study;
#[cfg(feature = "view")]
mod tev;

use crate::support::PATIENCE;
use std::fs;
use std::path::{Path, PathBuf};

/// Temporary folder that holds `box.txt`, in which the program runs.
struct CliSandbox {
    folder: tempfile::TempDir,
}

/// Exit code and output of a run of the program.
struct ProgramRun {
    code: Option<i32>,
    stdout: String,
    /// Messages on standard error, without the frames and line breaks of reports, so that tests can
    /// search for sentences.
    stderr: String,
}

/// Scene of a closed box with a light, glass and a mirror.
const BOX: &str = "\
PerspectiveCamera { center 0 1 3.9  lookAt 0 1 0  angle 40  width 40  height 30 }
Background { color 0 0 0 }
Lights { RectangleLight { corner -.5 1.98 -.5  edge0 1 0 0  edge1 0 0 1  power 20 18 15 } }
Materials {
    Diffuse white { reflectance .75 .75 .75 }
    Diffuse red { reflectance .7 .1 .1 }
    Dielectric glass { indexOfRefraction 1.5  tint .7 .9 .8 }
    Mirror silver { reflectance .9 .9 .9 }
}
Group {
    MaterialName white
    Rectangle { corner -1 0 -1  edge0 0 0 5  edge1 2 0 0 }
    Rectangle { corner -1 2 -1  edge0 2 0 0  edge1 0 0 5 }
    Rectangle { corner -1 0 -1  edge0 2 0 0  edge1 0 2 0 }
    Rectangle { corner -1 0 4  edge0 0 2 0  edge1 2 0 0 }
    MaterialName red
    Rectangle { corner -1 0 -1  edge0 0 2 0  edge1 0 0 5 }
    Rectangle { corner 1 0 -1  edge0 0 0 5  edge1 0 2 0 }
    MaterialName glass  Sphere { center -.4 .4 .5 radius .4 }
    MaterialName silver  Sphere { center .45 .4 -.3 radius .4 }
}
";

/// Flags of a render that is over in a moment.
const SMALL: [&str; 4] = ["--passes", "1", "--photons", "1k"];

impl CliSandbox {
    fn new() -> Self {
        let sandbox = Self { folder: tempfile::tempdir().unwrap() };
        sandbox.put("box.txt", BOX);
        sandbox
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(self.folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program in the folder. Kills it after [`PATIENCE`].
    fn run(&self, arguments: &[&str]) -> ProgramRun {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        command.current_dir(self.folder.path()).args(arguments).timeout(PATIENCE);
        let output = command.output().unwrap();
        ProgramRun {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: unframed_text(&String::from_utf8(output.stderr).unwrap()),
        }
    }

    /// Renders a scene at the least cost. `more` holds flags, separated by spaces.
    fn render(&self, scene: &str, more: &str) -> ProgramRun {
        let mut arguments = vec!["render", scene];
        arguments.extend(more.split_whitespace());
        for flag in SMALL.chunks(2).filter(|flag| !more.contains(flag[0])) {
            arguments.extend(flag);
        }
        self.run(&arguments)
    }
}

impl ProgramRun {
    /// Fails unless the program ended with `code`, and its messages contain all `parts` and no
    /// panic.
    #[track_caller]
    fn expect(&self, code: i32, parts: &[&str]) -> &Self {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        for part in parts {
            assert!(self.stderr.contains(part), "`{part}` is not in:\n{}", self.stderr);
        }
        self
    }
}

/// Returns a report's text without its frame, in one line.
fn unframed_text(text: &str) -> String {
    let bare = text.replace(['│', '╭', '╰', '─', '▶', '╯', '┬', '·'], " ");
    // A × at the start of a line marks an error in a report. Elsewhere it stands between width and
    // height.
    let lines = bare.lines().map(|line| line.trim_start().trim_start_matches("× "));
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

fn read(path: &Path) -> caustica::image::Image {
    caustica::image::read(path).unwrap()
}
