//! Inputs that determine the bits of an image, and inputs that do not.

use super::CliSandbox;
use std::time::Instant;

/// Renders with these flags and returns the OpenEXR file.
fn picture(sandbox: &CliSandbox, more: &str) -> Vec<u8> {
    sandbox.render("box.txt", &format!("-o a.exr {more}")).expect(0, &[]);
    sandbox.bytes("a.exr")
}

#[test]
fn same_seed_gives_same_bytes() {
    let sandbox = CliSandbox::new();
    let zero = picture(&sandbox, "--passes 2");
    assert!(zero == picture(&sandbox, "--passes 2 --seed 0"));
    assert!(zero != picture(&sandbox, "--passes 2 --seed 1"));
    let largest = format!("--passes 2 --seed {}", u64::MAX);
    assert!(picture(&sandbox, &largest) == picture(&sandbox, &largest));
    for threads in 1..4 {
        assert!(zero == picture(&sandbox, &format!("--passes 2 --threads {threads}")), "{threads} threads");
    }
    assert!(zero == picture(&sandbox, "--passes 2 --time 1h --quiet --stats a.json --tone filmic"));
}

/// Settings that docs/guide/command-line.md lists as determining the bits of the image do change
/// it.
#[test]
#[ignore = "long: many runs of the program"]
fn documented_settings_change_the_image() {
    let sandbox = CliSandbox::new();
    let sppm = "--integrator sppm --passes 2";
    let plain = picture(&sandbox, sppm);
    for more in [
        "--photons 1001",
        "--caustic-photons 700",
        "--spp 2",
        "--gather-k 20",
        "--radius .1",
        "--kernel cone",
        "--max-bounces 1",
        "--filter box",
    ] {
        assert!(plain != picture(&sandbox, &format!("{sppm} {more}")), "{more}");
    }
    let names = [
        "hybrid",
        "path",
        "ppm",
        "pm",
        "pm --final-gathering none",
        "pm --final-gathering importance",
        "distributed",
        "whitted",
        "raycast",
    ];
    let pictures = names.map(|name| picture(&sandbox, &format!("--passes 2 --integrator {name}")));
    for (i, one) in pictures.iter().enumerate() {
        assert!(*one != plain, "{}", names[i]);
        for (j, other) in pictures[..i].iter().enumerate() {
            assert!(one != other, "{} {}", names[i], names[j]);
        }
    }
}

#[test]
#[ignore = "long: many runs of the program"]
fn timed_render_can_be_repeated() {
    let sandbox = CliSandbox::new();
    let start = Instant::now();
    let ended =
        sandbox.run(&["render", "box.txt", "-o", "a.exr", "--photons", "1k", "--time", "1s", "--stats", "a.json"]);
    let wall_seconds = start.elapsed().as_secs_f64();
    ended.expect(0, &["time was up: --passes", "repeats this picture bit for bit"]);
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    let passes = stats["passes"].as_u64().unwrap();
    assert!(ended.stderr.contains(&format!("--passes {passes} ")), "{}", ended.stderr);
    assert_eq!(stats["ended"], "time");
    // The render ends at most half a mean pass before the limit.
    let pass_seconds = stats["seconds"]["render"].as_f64().unwrap() / passes as f64;
    assert!(wall_seconds + 0.5 * pass_seconds >= 1.0, "{wall_seconds} {pass_seconds}");
    let timed = sandbox.bytes("a.exr");
    assert!(timed == picture(&sandbox, &format!("--photons 1k --passes {passes}")));
    assert!(timed != picture(&sandbox, &format!("--photons 1k --passes {}", passes + 1)));
}

#[test]
fn pass_limit_ends_timed_render_early() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.exr --time 1h --passes 2 --stats a.json").expect(0, &["2 passes in"]);
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    assert_eq!((&stats["ended"], &stats["passes"]), (&"passes".into(), &2.into()));
    // At least one pass is rendered, even with `--time 0`.
    sandbox
        .run(&["render", "box.txt", "-o", "b.exr", "--photons", "1k", "--time", "0"])
        .expect(0, &["--passes 1 repeats"]);
    assert_eq!(sandbox.bytes("b.exr"), picture(&sandbox, ""));
}
