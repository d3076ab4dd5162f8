//! Tests of `caustica study` of integrators.

use super::{CliSandbox, ProgramRun};
use crate::support::shell::shell_words;
use serde_json::Value;

fn run(sandbox: &CliSandbox, line: &str) -> ProgramRun {
    let words = shell_words(line);
    sandbox.run(&words.iter().map(String::as_str).collect::<Vec<_>>())
}

fn json(ended: &ProgramRun) -> Value {
    ended.expect(0, &[]);
    serde_json::from_str(&ended.stdout).unwrap()
}

/// Flags of a study with the least cost.
const LEAST: &str = "--photons 1k --spp 1 --seeds 2 --budget 100s --passes 3";

/// Returns a sandbox that holds a reference of the box, and another reference with another seed.
fn with_references() -> CliSandbox {
    let sandbox = CliSandbox::new();
    for (name, seed) in [("a", 100), ("b", 200)] {
        sandbox.render("box.txt", &format!("-o {name}.exr --seed {seed} --spp 4 --passes 4")).expect(0, &[]);
    }
    sandbox
}

fn methods(report: &Value) -> Vec<&str> {
    report["methods"].as_array().unwrap().iter().map(|m| m["label"].as_str().unwrap()).collect()
}

#[test]
#[ignore = "long: many runs of the program"]
fn study_commands_repeat_it_bit_for_bit() {
    let sandbox = with_references();
    sandbox.put("my box.txt", sandbox.bytes("box.txt"));
    let line = "study 'my box.txt' --methods path,pm --variant 'sppm --gather-k 9 --radius .05' --max-bounces 9 --seed 5 \
                --wish -caustic-bounces --filter tent --truth a.exr,b.exr --size 40x30 --json --quiet";
    let report = json(&run(&sandbox, &format!("{line} {LEAST}")));
    assert_eq!(methods(&report), ["path", "pm", "sppm --gather-k 9 --radius .05"]);
    for method in report["methods"].as_array().unwrap() {
        let command = method["command"].as_str().unwrap();
        let rendered = run(&sandbox, command.strip_prefix("caustica ").unwrap());
        rendered.expect(0, &["wrote "]);
        // The last image of the first seed is the image that the command renders. Its error against
        // this image is zero.
        let picture = shell_words(command).pop().unwrap();
        let again = json(&run(&sandbox, &format!("{} {LEAST}", line.replace("a.exr,b.exr", &picture))));
        let same = again["methods"].as_array().unwrap().iter().find(|m| m["label"] == method["label"]).unwrap();
        let last = same["checkpoints"].as_array().unwrap().last().unwrap();
        assert_eq!((&last["passes"], &last["squares"][0]), (&3.into(), &0.0.into()), "{command}");
        assert!(last["squares"][1].as_f64() > Some(0.0), "another seed gives another picture");
    }
    let command = report["command"].as_str().unwrap().strip_prefix("caustica ").unwrap().to_owned();
    let again = json(&run(&sandbox, &format!("{command} --json")));
    let figures = |report: &Value| {
        let rows = report["methods"].as_array().unwrap().iter().flat_map(|m| m["checkpoints"].as_array().unwrap());
        rows.map(|c| [&c["squares"], &c["noise2"], &c["bias2"], &c["rmse"]].map(Value::to_string)).collect::<Vec<_>>()
    };
    assert_eq!(figures(&again), figures(&report), "{command}");
}

#[test]
#[ignore = "long: many runs of the program"]
fn study_prints_table_and_writes_data() {
    let sandbox = with_references();
    let made = run(&sandbox, &format!("study box.txt --truth a.exr,b.exr -o a.json {LEAST}"));
    made.expect(0, &["path: 1 pass after", "hybrid: 3 passes after", "wrote a.json"]);
    let report: Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    assert_eq!(methods(&report), ["path", "pm", "ppm", "sppm", "hybrid"], "all that apply");
    for method in report["methods"].as_array().unwrap() {
        let label = method["label"].as_str().unwrap();
        assert!(made.stdout.contains(&format!("\n{label}: prepared in ")), "{}", made.stdout);
        assert!(made.stdout.contains(method["command"].as_str().unwrap()), "{}", made.stdout);
        let checkpoints = method["checkpoints"].as_array().unwrap();
        assert_eq!(checkpoints.iter().map(|c| c["passes"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 3]);
        for checkpoint in checkpoints {
            assert_eq!(checkpoint["squares"].as_array().unwrap().len(), 2);
            assert!(checkpoint["noise2"].as_f64() > Some(0.0) && checkpoint["seconds"].as_f64() > Some(0.0));
            let rays = checkpoint["rays"].as_f64().unwrap() / checkpoint["passes"].as_f64().unwrap();
            assert!(rays > 40.0 * 30.0, "a camera ray a pixel at least");
        }
        assert_eq!(method["radii"].is_null(), label == "path");
    }
    let table = made.stdout.lines().filter(|l| !l.contains("caustica render"));
    assert!(table.clone().all(|l| l.chars().count() <= 110), "{}", made.stdout);
    assert!(made.stdout.contains("reference: a.exr, b.exr\nreference: noise "));
    assert_eq!((&report["interrupted"], &report["seeds"], &report["width"]), (&false.into(), &2.into(), &40.into()));
}

#[test]
fn study_references_are_cached() {
    let sandbox = CliSandbox::new();
    let least = "--photons 1k --spp 1 --seeds 2 --budget 0s --json";
    let made = run(&sandbox, &format!("study box.txt --methods path --save-truth a.exr,b.exr {least}"));
    let first = json(&made);
    made.expect(0, &["references: 1 pass of each", "wrote a.exr", "wrote b.exr"]);
    assert!(first["truth"]["source"].as_str().unwrap().starts_with("auto: 1 pass of hybrid, twice: "));
    assert!(first["truth"]["error"].as_f64() > Some(0.0) && sandbox.bytes("a.exr") != sandbox.bytes("b.exr"));
    let again = json(&run(&sandbox, &format!("study box.txt --methods path --truth a.exr,b.exr {least}")));
    assert_eq!(again["methods"][0]["checkpoints"][0]["squares"], first["methods"][0]["checkpoints"][0]["squares"]);
    assert_eq!(again["truth"]["error"], first["truth"]["error"]);
    assert_eq!(sandbox.names(), ["a.exr", "b.exr", "box.txt"]);
}

#[test]
#[ignore = "long: many runs of the program"]
fn knobs_vary_one_at_a_time() {
    let sandbox = with_references();
    let line = "study box.txt --knobs hybrid --truth a.exr,b.exr --seeds 2 --passes 1 --photons 1k --json";
    let report = json(&run(&sandbox, line));
    let labels = methods(&report);
    assert_eq!(labels[0], "hybrid");
    assert!(labels.contains(&"hybrid --photons 250 --caustic-photons 125"), "{labels:?}");
    // The radii are ½, 1 and 2 times the radius of the caustic map.
    let caustic = report["methods"][0]["radii"][1].as_f64().unwrap();
    let radii: Vec<f64> = labels.iter().filter_map(|l| l.strip_prefix("hybrid --radius ")?.parse().ok()).collect();
    let expected = [0.5, 1.0, 2.0].map(|by| by * caustic);
    assert!(
        radii.len() == 3 && radii.iter().zip(expected).all(|(r, e)| (r / e - 1.0).abs() < 1e-6),
        "{radii:?} {caustic}"
    );
    for method in report["methods"].as_array().unwrap() {
        let command = method["command"].as_str().unwrap();
        assert!(command.contains("--spp ") && command.contains("--caustic-photons "), "{command}");
    }
}

#[test]
fn impossible_studies_are_refused_before_work() {
    let sandbox = with_references();
    sandbox.render("box.txt", "-o a.png").expect(0, &[]);
    let names = sandbox.names();
    let refused = |code: i32, line: &str, parts: &[&str]| {
        run(&sandbox, &format!("study box.txt --budget 1h {line}")).expect(code, parts);
    };
    refused(2, "--methods bdpt", &["'bdpt'", "sppm"]);
    refused(2, "--methods path,path --truth a.exr", &["`path` is given twice"]);
    refused(
        2,
        "--methods path --variant 'sppm --gather-k many'",
        &["--variant \"sppm --gather-k many\"", "not a count"],
    );
    refused(2, "--variant 'bdpt'", &["no method `bdpt`", "help: begin with one of"]);
    refused(2, "--integrator path", &["--integrator", "--budget"]);
    run(&sandbox, "study box.txt --integrator path").expect(2, &["--effects"]);
    refused(2, "--effects --methods path", &["--effects", "--methods"]);
    refused(2, "--seeds 1", &["at least 2"]);
    refused(2, "--seeds 1M", &["at most 1000"]);
    refused(2, "--truth a.exr,a.exr", &["`a.exr` is named twice: two references must be independent"]);
    refused(2, "--truth a.exr,", &["write A.exr,B.exr"]);
    refused(2, "--truth a.exr --truth-time 3s", &["--truth-time applies to rendered references"]);
    refused(2, "--truth a.exr --save-truth c.exr,d.exr", &["--save-truth applies to rendered references"]);
    refused(2, "--truth a.exr --size 2000x2000 --seeds 1000 --methods path,pm", &["GB", "fewer --seeds"]);
    refused(1, "--truth a.exr,a.png", &["`a.png` is a PNG", "OpenEXR"]);
    refused(1, "--truth a.exr --size 20x15", &["`a.exr` has 40 × 30 pixels, but the study 20 × 15: give --size 40x30"]);
    refused(1, "--truth none.exr", &["none.exr"]);
    refused(
        3,
        "-o a.png",
        &["`a.png` has no extension of a report", "help: give it the extension .html or .csv or .json or .md"],
    );
    refused(3, "-o no/a.json", &["no folder `no`"]);
    refused(3, "--save-truth c.exr,d.png", &["`d.png` cannot hold a reference", "help: give it the extension .exr"]);
    refused(3, "--save-truth no/c.exr,d.exr", &["no folder `no`"]);
    assert_eq!(sandbox.names(), names);
}
