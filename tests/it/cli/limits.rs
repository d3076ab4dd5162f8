//! The end of a render: without limits, of a preview, and with limits.

use super::{CliSandbox, ProgramRun};
use serde_json::Value;

/// Scene of a ball on a plane under a point light. Its only noise comes from edges and from one
/// bounce of indirect light.
const BALL: &str = "\
PerspectiveCamera { center 0 2 6  lookAt 0 .8 0  angle 35  width 24  height 18 }
Lights { PointLight { position 3 5 3  power 200 200 200 } }
Materials { Diffuse white { reflectance .6 .6 .6 } }
Group {
    MaterialName white
    Plane { normal 0 1 0 offset 0 }
    Sphere { center 0 .8 0 radius .8 }
}
";

/// Renders the ball with the flags `more`, and returns the run and its statistics.
fn rendered(more: &str) -> (ProgramRun, Value) {
    let sandbox = CliSandbox::new();
    sandbox.put("ball.txt", BALL);
    let line = format!("render ball.txt -o a.exr --stats a.json --photons 2k {more}");
    let ended = sandbox.run(&line.split_whitespace().collect::<Vec<_>>());
    ended.expect(0, &["wrote a.exr"]);
    (ended, serde_json::from_slice(&sandbox.bytes("a.json")).unwrap())
}

#[test]
fn default_render_ends_at_three_percent() {
    for integrator in ["hybrid", "path"] {
        let (ended, stats) = rendered(&format!("--integrator {integrator} --spp 1"));
        ended.expect(0, &["ended by error: at most 3.0 % with 90 % confidence", "repeats this picture bit for bit"]);
        let limits = serde_json::json!(
            { "default": true, "passes": null, "seconds": 300.0, "error": 0.03, "confidence": 0.9 }
        );
        assert_eq!((&stats["ended"], &stats["limits"]), (&"target".into(), &limits));
        assert!(stats["error"]["high"].as_f64().is_some_and(|high| high > 0.0 && high <= 0.03), "{stats}");
        assert!(stats["passes"].as_u64() > Some(4), "{stats}");
    }
}

#[test]
fn preview_ends_at_ten_percent() {
    let (ended, stats) = rendered("--preview --spp 1");
    ended.expect(0, &["ended by error: at most 10 %"]);
    assert_eq!((&stats["ended"], &stats["limits"]["error"]), (&"target".into(), &0.1.into()));
    assert!(stats["error"]["high"].as_f64().is_some_and(|high| high > 0.03 && high <= 0.1), "{stats}");
    let (ended, stats) = rendered("--preview --passes 2");
    assert_eq!((&stats["ended"], &stats["passes"]), (&"passes".into(), &2.into()));
    assert!(!ended.stderr.contains("ended by"), "{}", ended.stderr);
}

#[test]
fn given_limits_overrule_defaults() {
    for (more, reason, passes) in
        [("--passes 3", "passes", 3), ("--time 0s", "time", 1), ("--target-error 90%", "target", 4)]
    {
        let (ended, stats) = rendered(&format!("{more} --integrator path"));
        assert_eq!((&stats["ended"], &stats["passes"]), (&reason.into(), &passes.into()));
        assert_eq!(stats["limits"]["default"], false);
        assert!(!ended.stderr.contains("ended by"), "{}", ended.stderr);
    }
    let sandbox = CliSandbox::new();
    for refused in ["--target-error 5%", "--no-error-estimate"] {
        sandbox.render("box.txt", &format!("-o a.png --preview {refused}")).expect(2, &["cannot be used with"]);
    }
}

#[test]
fn render_without_error_estimate_has_fixed_pass_count() {
    let (_, stats) = rendered("--no-error-estimate");
    assert_eq!((&stats["ended"], &stats["passes"]), (&"passes".into(), &16.into()));
    let (_, stats) = rendered("--preview --integrator raycast");
    assert_eq!((&stats["ended"], &stats["passes"]), (&"passes".into(), &1.into()));
}

#[test]
fn estimate_forecasts_default_render_and_preview() {
    let sandbox = CliSandbox::new();
    sandbox.put("ball.txt", BALL);
    let line = "estimate ball.txt --integrator path --pilot 0s";
    let table = sandbox.run(&line.split(' ').collect::<Vec<_>>());
    let ends =
        ["without a limit, a render ends at an error of 3.0 %", "with --preview, a render ends at an error of 10 %"];
    assert!(ends.iter().all(|end| table.stdout.contains(end)), "{}", table.stdout);
    let json = sandbox.run(&format!("{line} --json").split(' ').collect::<Vec<_>>());
    let report: Value = serde_json::from_str(&json.stdout).unwrap();
    let (_, stats) = rendered("--integrator path");
    let [expected, made] = [&report["default"], &stats].map(|report| report["passes"].as_f64().unwrap());
    assert!((expected / made - 1.0).abs() < 0.25, "{expected} {made}");
    assert_eq!((&report["default"]["ended"], &report["preview"]["passes"]), (&"target".into(), &4.into()));
}
