//! Error estimates of a render: target error, error maps, and forecasts.

use super::{CliSandbox, ProgramRun, read};
use exr::prelude::read_first_flat_layer_from_file;
use serde_json::Value;

const FEW: &str = "--photons 2k --caustic-photons 1k --spp 1";

fn render(sandbox: &CliSandbox, more: &str) -> ProgramRun {
    let words = format!("render box.txt -o a.exr --stats a.json {FEW} {more}");
    sandbox.run(&words.split_whitespace().collect::<Vec<_>>())
}

fn stats(sandbox: &CliSandbox) -> Value {
    serde_json::from_slice(&sandbox.bytes("a.json")).unwrap()
}

fn number(value: &Value, field: &str) -> f64 {
    value[field].as_f64().unwrap_or_else(|| panic!("{field} of {value}"))
}

#[test]
fn render_ends_at_target_error() {
    for integrator in ["path", "hybrid", "sppm", "pm"] {
        let sandbox = CliSandbox::new();
        let ended = render(&sandbox, &format!("--integrator {integrator} --target-error 30% --confidence 80%"));
        ended.expect(0, &["the error is low enough: --passes", "30 % in about", "with 60 % confidence"]);
        let first = stats(&sandbox);
        assert_eq!(first["ended"], "target");
        assert!(number(&first["error"], "high") <= 0.3 && number(&first["error"], "low") > 0.0, "{first}");
        // The render ended as early as possible: one pass fewer does not reach the target.
        let passes = first["passes"].as_u64().unwrap();
        let picture = sandbox.bytes("a.exr");
        if passes > 4 {
            let fewer =
                format!("--integrator {integrator} --target-error 30% --confidence 80% --passes {}", passes - 1);
            render(&sandbox, &fewer).expect(0, &[]);
            assert!(number(&stats(&sandbox)["error"], "high") > 0.3);
        }
        render(&sandbox, &format!("--integrator {integrator} --passes {passes} --no-error-estimate")).expect(0, &[]);
        assert!(
            stats(&sandbox)["error"].is_null() && sandbox.bytes("a.exr") == picture,
            "error estimation changes no bit"
        );
    }
}

#[test]
fn chance_caustics_are_absent_from_error_estimate() {
    let sandbox = CliSandbox::new();
    render(&sandbox, "--integrator path --passes 1").expect(0, &["warning: this method finds caustics only by chance"]);
    for fine in ["--integrator hybrid", "--integrator whitted", "--integrator path --effects -caustics"] {
        let ended = render(&sandbox, &format!("{fine} --passes 1"));
        assert!(ended.code == Some(0) && !ended.stderr.contains("by chance"), "{fine}: {}", ended.stderr);
    }
}

#[test]
fn unreachable_target_ends_with_warning() {
    let sandbox = CliSandbox::new();
    let blurred = "--integrator pm --final-gathering none --radius 1 --target-error 0.1%";
    render(&sandbox, blurred).expect(0, &["more passes cannot reach the error", "choose a smaller --radius"]);
    assert_eq!(stats(&sandbox)["ended"], "floor");
    render(&sandbox, &format!("{blurred} --passes 18")).expect(0, &["18 passes in"]);
    assert_eq!(stats(&sandbox)["ended"], "passes");
}

/// The advice names what causes the bias: the light that a clamp removes, even if blur is larger at
/// first, because gather radii shrink.
#[test]
fn advice_names_the_bias_that_remains() {
    let sandbox = CliSandbox::new();
    render(&sandbox, "--integrator sppm --radius 1 --clamp .05 --target-error 0.1%")
        .expect(0, &["more passes cannot reach the error", "choose a larger limit, or leave out --clamp"]);
}

#[test]
fn error_maps_are_layers_of_one_file() {
    let sandbox = CliSandbox::new();
    render(&sandbox, "--integrator sppm --passes 6 --aov maps.exr").expect(0, &["wrote maps.exr"]);
    assert_eq!(read(&sandbox.path("maps.exr")), read(&sandbox.path("a.exr")), "the picture is one of them");
    let layer = read_first_flat_layer_from_file(sandbox.path("maps.exr")).unwrap().layer_data;
    let mut names: Vec<String> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    names.sort();
    let expected = [
        "B",
        "G",
        "R",
        "albedo.B",
        "albedo.G",
        "albedo.R",
        "bias.B",
        "bias.G",
        "bias.R",
        "depth.Z",
        "material.X",
        "motion.X",
        "motion.Y",
        "noise.B",
        "noise.G",
        "noise.R",
        "normal.X",
        "normal.Y",
        "normal.Z",
        "object.X",
        "photons.caustic",
        "photons.global",
        "position.X",
        "position.Y",
        "position.Z",
        "radius.caustic",
        "radius.global",
    ];
    assert_eq!(names, expected);
    let values = |name: &str| -> Vec<f32> {
        let channel = layer.channel_data.list.iter().find(|c| c.name.to_string() == name).unwrap();
        channel.sample_data.values_as_f32().collect()
    };
    // Pixels that show only the light have neither noise nor estimates. They are few.
    let lit = |name: &str| values(name).iter().filter(|v| **v > 0.0).count();
    assert!(values("noise.G").iter().all(|v| *v >= 0.0 && v.is_finite()) && lit("noise.G") > 1100);
    assert!(lit("radius.global") > 1100 && lit("radius.caustic") > 0 && lit("photons.caustic") > 0);
    assert!(values("photons.global").iter().any(|v| *v > 1.0));
    let bias = values("bias.G");
    assert!(bias.iter().any(|v| *v > 0.0) && bias.iter().any(|v| *v < 0.0));

    render(&sandbox, "--integrator path --passes 6 --aov maps.exr").expect(0, &[]);
    let layer = read_first_flat_layer_from_file(sandbox.path("maps.exr")).unwrap().layer_data;
    let surface = 14;
    assert_eq!(layer.channel_data.list.len(), surface + 6, "without estimates there is no blur");

    render(&sandbox, "--integrator path --passes 6 --no-error-estimate --light-groups --aov maps.exr").expect(0, &[]);
    let layer = read_first_flat_layer_from_file(sandbox.path("maps.exr")).unwrap().layer_data;
    assert_eq!(layer.channel_data.list.len(), surface + 3 + 9, "without an estimate there is no noise");
    let values = |name: &str| -> Vec<f32> {
        let channel = layer.channel_data.list.iter().find(|c| c.name.to_string() == name).unwrap();
        channel.sample_data.values_as_f32().collect()
    };
    let [direct, indirect, caustic] = ["direct.G", "indirect.G", "caustic.G"].map(values);
    for (i, picture) in values("G").into_iter().enumerate() {
        let sum = direct[i] + indirect[i] + caustic[i];
        assert!((sum - picture).abs() <= 16.0 * f32::EPSILON * picture, "{sum} {picture}");
    }
    assert!([direct, indirect, caustic].iter().all(|group| group.iter().any(|value| *value > 0.0)));
    render(&sandbox, "--integrator raycast --aov maps.exr").expect(0, &["wrote maps.exr"]);
}

#[test]
fn estimate_forecasts_passes_that_suffice() {
    let sandbox = CliSandbox::new();
    let line = format!("price box.txt {FEW} --integrator path --pilot 0s --errors 40%,20%");
    let table = sandbox.run(&line.split_whitespace().collect::<Vec<_>>());
    table.expect(0, &["plan: "]);
    assert!(
        table.stdout.contains("after 8 passes the estimated error is") && table.stdout.lines().count() == 6,
        "{}",
        table.stdout
    );
    let listed = sandbox.run(&format!("{line} --json --quiet").split_whitespace().collect::<Vec<_>>());
    let list: Value = serde_json::from_str(&listed.stdout).unwrap();
    for (price, error) in list["prices"].as_array().unwrap().iter().zip([0.4, 0.2]) {
        assert_eq!(number(price, "error"), error);
        assert!(number(price, "seconds") >= number(price, "seconds_low"));
        assert!(number(price, "seconds") <= number(price, "seconds_high"));
        let flags = price["flags"].as_str().unwrap();
        assert!(flags.contains("--target-error"), "{flags}");
        let words = format!("render box.txt -o a.exr --stats a.json {flags}");
        sandbox.run(&words.split_whitespace().collect::<Vec<_>>()).expect(0, &[]);
        let (passes, ended) = (number(price, "passes"), number(&stats(&sandbox), "passes"));
        // The variance is estimated from eight passes of 1200 pixels. Its error, and so that of the
        // number of passes, is a few percent.
        assert!((ended - passes).abs() <= 1.0 + 0.15 * passes, "{ended} {passes}");
    }
    assert_eq!(number(&list, "range_probability"), 0.8);
    let words =
        format!("price box.txt {FEW} --integrator pm --radius 1 --final-gathering none --errors 0.1% --pilot 0s");
    let never = sandbox.run(&words.split_whitespace().collect::<Vec<_>>());
    assert!(never.stdout.contains("never: ") && never.stdout.contains("bias that stays"), "{}", never.stdout);
}

#[test]
fn error_flags_need_an_estimating_integrator() {
    let sandbox = CliSandbox::new();
    for (more, words) in [
        ("--integrator raycast --target-error 2%", "--target-error needs an error estimate"),
        ("--integrator raycast --light-groups --aov a.exr", "--light-groups needs light that is simulated"),
        ("--integrator raycast --clamp 2", "--clamp needs light that is simulated"),
        ("--clamp 0", "is not a radiance"),
        ("--crop 0,0,41,10", "exceeds the picture of 40 × 30 pixels"),
        ("--crop 5,0,5,10", "is no window"),
        ("--target-error 2% --no-gauge", "cannot be used with"),
        ("--target-error 0", "not an error"),
        ("--confidence 100%", "not a confidence"),
        ("--alpha 0", "not an exponent"),
    ] {
        render(&sandbox, more).expect(2, &[words]);
    }
    render(&sandbox, "--aov a.png").expect(3, &[".exr"]);
    assert_eq!(sandbox.names(), ["box.txt"]);
}

#[test]
fn estimate_compares_algorithms() {
    let sandbox = CliSandbox::new();
    let line = format!("price box.txt {FEW} --integrator path --pilot 0s --errors 40%,30% --compare path,sppm,ppm");
    let run = |line: &str| sandbox.run(&line.split_whitespace().collect::<Vec<_>>());
    let table = run(&line).stdout;
    let (_, times) = table.split_once("time by method").expect(&table);
    let rows: Vec<&str> = times.lines().skip(1).collect();
    assert_eq!(rows[0].split_whitespace().collect::<Vec<_>>(), ["error", "path", "sppm", "ppm"]);
    assert!(rows.len() == 3 && rows[1..].iter().all(|row| row.matches('*').count() == 1), "{table}");
    // The scene has a glass ball, whose caustics path tracing misses. It may be the quickest
    // algorithm, but it cannot estimate its own error there.
    let path_cells = rows[1..].iter().map(|row| &row[row.find('%').unwrap() + 1..row.find(')').expect(row)]);
    assert!(path_cells.clone().all(|cell| cell.contains('(') && !cell.contains('*')), "{table}");

    let report: Value = serde_json::from_str(&run(&format!("{line} --json --quiet")).stdout).unwrap();
    let compared = report["compared"].as_array().unwrap();
    assert!(report["integrator"] == "path" && compared.len() == 2 && compared[0]["integrator"] == "sppm", "{report}");
    assert!(report["misses_caustics"] == true && compared.iter().all(|r| r["misses_caustics"] == false), "{report}");
    assert!(compared[0]["prices"][1]["flags"].as_str().unwrap().contains("--integrator sppm"));

    run(&format!("price box.txt {FEW} --compare sppm,whitted")).expect(2, &["whitted, which leaves light out"]);
}
