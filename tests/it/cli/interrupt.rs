//! Ctrl-C: the first one ends the render and writes the picture so far. A second one after more
//! than a second ends the program at once, and writes nothing.
#![cfg(unix)]

use super::{CliSandbox, unframed_text};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::Duration;

/// A running render. It is killed when dropped, so that a failed test leaves no process.
struct Render {
    child: Child,
    words: BufReader<ChildStderr>,
}

impl Render {
    fn start(sandbox: &CliSandbox, arguments: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_caustica"))
            .current_dir(sandbox.path("."))
            .args(arguments.split_whitespace())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let words = BufReader::new(child.stderr.take().unwrap());
        Self { child, words }
    }

    /// Reads lines until one contains `part`.
    fn wait_for(&mut self, part: &str) {
        let mut said = String::new();
        while !said.contains(part) {
            let read = self.words.read_line(&mut said).unwrap();
            assert!(read > 0, "it ended before it said `{part}`:\n{said}");
        }
    }

    fn interrupt(&self) {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    }

    /// Returns the exit code and the remaining messages.
    fn end(mut self) -> (Option<i32>, String) {
        let mut rest = String::new();
        self.words.read_to_string(&mut rest).unwrap();
        (self.child.wait().unwrap().code(), unframed_text(&rest))
    }
}

impl Drop for Render {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns N from the words `--passes N` in `words`.
fn passes(words: &str) -> &str {
    let (_, after) = words.split_once("--passes ").unwrap_or_else(|| panic!("no number of passes in: {words}"));
    after.split(' ').next().unwrap()
}

#[test]
fn first_interrupt_ends_pass_and_writes_image() {
    let sandbox = CliSandbox::new();
    let mut render = Render::start(&sandbox, "render box.txt -o a.exr --stats a.json --photons 1k --passes 1M");
    render.wait_for("pass 2/1000000");
    render.interrupt();
    let (code, words) = render.end();
    assert_eq!(code, Some(130), "{words}");
    assert!(
        words.contains("interrupted: the picture so far is written after this pass") && words.contains("wrote a.exr")
    );
    let made = passes(&words);
    sandbox.render("box.txt", &format!("-o b.exr --photons 1k --passes {made}")).expect(0, &[]);
    assert!(sandbox.bytes("a.exr") == sandbox.bytes("b.exr"), "--passes {made} repeats the picture");
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    assert_eq!((stats["ended"].as_str(), stats["passes"].to_string().as_str()), (Some("interrupted"), made));
}

#[test]
fn second_interrupt_stops_at_once_without_image() {
    let sandbox = CliSandbox::new();
    sandbox.put("a.png", "old");
    // One pass takes an hour.
    let mut render = Render::start(&sandbox, "render box.txt -o a.png -o b.exr --stats a.json --photons 1k --spp 1M");
    render.wait_for("box.txt:");
    render.interrupt();
    render.wait_for("interrupt again to stop at once");
    std::thread::sleep(Duration::from_millis(1200));
    render.interrupt();
    let (code, words) = render.end();
    assert!(code == Some(130) && !words.contains("wrote"), "{words}");
    assert_eq!(
        (sandbox.bytes("a.png"), sandbox.names()),
        (b"old".to_vec(), vec!["a.png".to_owned(), "box.txt".to_owned()])
    );
}

/// A closing terminal sends SIGHUP twice: the shell sends one, and the system another.
#[test]
fn signals_in_quick_succession_still_write_the_image() {
    let sandbox = CliSandbox::new();
    let flags = "render box.txt -o a.exr --photons 1k --spp 64 --size 160x120 --passes 1M";
    let mut render = Render::start(&sandbox, flags);
    render.wait_for("pass 2/1000000");
    render.interrupt();
    render.interrupt();
    let (code, words) = render.end();
    assert_eq!(code, Some(130), "{words}");
    assert!(words.contains("wrote a.exr") && words.matches("interrupted: the picture").count() == 1, "{words}");
}

#[test]
fn interrupted_study_reports_finished_rounds() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.exr").expect(0, &[]);
    let line = "study box.txt --methods path,sppm --truth a.exr --photons 1k --spp 1 --seeds 2 --budget 1h -o a.json";
    let mut study = Render::start(&sandbox, line);
    study.wait_for("sppm: 2 passes");
    study.interrupt();
    let (code, words) = study.end();
    assert_eq!(code, Some(130), "{words}");
    assert!(words.contains("interrupted: the study so far is written") && words.contains("wrote a.json"), "{words}");
    let report: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    let last = |i: usize| &report["methods"][i]["checkpoints"].as_array().unwrap().last().unwrap()["passes"];
    assert!(report["interrupted"] == true && last(0) == last(1), "{report}");
}

#[test]
#[ignore = "long: many runs of the program"]
fn interrupted_references_are_discarded() {
    let sandbox = CliSandbox::new();
    let mut study = Render::start(&sandbox, "study box.txt --budget 1h --save-truth a.exr,b.exr");
    study.wait_for("references: 1 pass of each");
    study.interrupt();
    let (code, words) = study.end();
    assert!(code == Some(130) && words.contains("interrupted before anything was measured"), "{code:?} {words}");
    assert_eq!(sandbox.names(), ["box.txt"]);
}
