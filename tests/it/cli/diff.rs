//! Tests of `caustica diff`.

use super::{CliSandbox, ProgramRun, read};
use caustica::image::{Image, WriteOptions, sequential_color, write};
use glam::Vec3;
use serde_json::{Value, json};

/// Writes the pictures `a` and `b` of 4 × 2 pixels, as EXR and PNG.
///
/// All pixels of `a` have radiance ½. In `b`, the pixel in column 3, row 1 is lower by (0, ¼, −⅛),
/// and that in column 0, row 1 is lower by ⅛ in blue.
fn sandbox() -> CliSandbox {
    let sandbox = CliSandbox::new();
    let mut pixels = vec![Vec3::splat(0.5); 8];
    put(&sandbox, "a.exr", 4, &pixels);
    put(&sandbox, "a.png", 4, &pixels);
    pixels[7] -= Vec3::new(0.0, 0.25, -0.125);
    pixels[4].z -= 0.125;
    put(&sandbox, "b.exr", 4, &pixels);
    put(&sandbox, "b.png", 4, &pixels);
    sandbox
}

fn put(sandbox: &CliSandbox, name: &str, width: u32, pixels: &[Vec3]) {
    let image = Image::from_pixels(width, pixels.len() as u32 / width, pixels.to_vec()).unwrap();
    write(&sandbox.path(name), &image, &WriteOptions::default()).unwrap();
}

fn run(sandbox: &CliSandbox, line: &str) -> ProgramRun {
    let words: Vec<&str> = ["diff"].into_iter().chain(line.split_whitespace()).collect();
    sandbox.run(&words)
}

fn report(ended: &ProgramRun) -> Value {
    serde_json::from_str(&ended.stdout).unwrap_or_else(|e| panic!("{e}\n{}", ended.stdout))
}

#[test]
fn diff_table_lists_every_metric() {
    let sandbox = sandbox();
    let ended = run(&sandbox, "a.exr b.exr --flip ldr --exposure -1.5");
    ended.expect(0, &[]);
    let lines: Vec<String> = ended.stdout.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(lines[0], "a.exr against b.exr, 4 × 2 pixels");
    // RMSE is √((1/16 + 2/64)/24), as two pixels differ in 24 values.
    for line in [
        "mean radiance 0.500 of the reference 0.490",
        "RMSE 0.0625",
        "largest in red 0",
        "largest in green 0.250 in column 3, row 1",
        "largest in blue 0.125 in column 0, row 1",
        "pixels that differ 2 25.0 %",
    ] {
        assert!(lines.iter().any(|l| l == line), "`{line}` is not in:\n{}", ended.stdout);
    }
    let starts = ["relative MSE ", "relative error ", "FLIP "];
    assert!(starts.iter().all(|start| lines.iter().any(|l| l.starts_with(start))), "{}", ended.stdout);
    assert!(ended.stdout.lines().all(|line| line.chars().count() <= 80), "{}", ended.stdout);
    assert_eq!((ended.stderr.as_str(), sandbox.names().len()), ("", 5), "nothing is written or said unasked");
}

#[test]
fn json_has_every_documented_field() {
    let sandbox = sandbox();
    let ended = run(&sandbox, "a.exr b.exr --json");
    ended.expect(0, &[]);
    let found = report(&ended);
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/command-line.md")).unwrap();
    let section = page.split("\n## Diff report\n").nth(1).unwrap().split("\n## ").next().unwrap();
    let cells =
        section.lines().filter_map(|line| line.strip_prefix("| `")).map(|line| line.split(" |").next().unwrap());
    let names: Vec<&str> = cells.flat_map(|cell| cell.split(", ")).map(|name| name.trim_matches('`')).collect();
    assert!(names.len() > 15);
    for name in names.into_iter().filter(|name| !name.starts_with("map.")) {
        let field = name.split('.').try_fold(&found, |value, part| value.get(part));
        assert!(field.is_some(), "`{name}` is not in\n{}", ended.stdout);
    }
    assert_eq!((&found["width"], &found["height"]), (&json!(4), &json!(2)));
    assert_eq!((&found["a"], &found["b"]), (&json!("a.exr"), &json!("b.exr")));
    assert_eq!(found["mean"], json!({"a": 0.5, "b": 0.5 - 0.25 / 24.0}));
    assert_eq!((&found["rmse"], &found["differing_pixels"]), (&json!(0.0625), &json!(2)));
    let green = json!({"difference": 0.25, "x": 3, "y": 1});
    let blue = json!({"difference": 0.125, "x": 0, "y": 1});
    assert_eq!(found["largest"], json!({"red": null, "green": green, "blue": blue}));
    assert_eq!((&found["flip"]["mode"], &found["flip"]["exposure"]), (&json!("hdr"), &Value::Null));
    assert_eq!((&found["exceeded"], &found["map"]), (&json!([]), &Value::Null));
    // The relative MSE is the mean of d²/(B² + .01) over 24 values, with differences d of ⅛ and ¼
    // from values B.
    let relative = (0.125 * 0.125 / (0.375 * 0.375 + 0.01)
        + 0.25 * 0.25 / (0.25 * 0.25 + 0.01)
        + 0.125 * 0.125 / (0.625 * 0.625 + 0.01))
        / 24.0;
    assert!((found["relative_mse"].as_f64().unwrap() - relative).abs() < 1e-12);
    assert!(found["relative_error"].as_f64() > Some(0.0) && found["flip"]["mean"].as_f64() > Some(0.0));
}

#[test]
fn flip_uses_given_viewing_conditions() {
    let sandbox = sandbox();
    let flip = |line: &str| {
        let ended = run(&sandbox, &format!("{line} --json"));
        ended.expect(0, &[]);
        report(&ended)["flip"].clone()
    };
    for (line, mode) in [
        ("a.png b.png", "ldr"),
        ("a.png b.exr", "hdr"),
        ("a.exr b.png", "hdr"),
        ("a.png b.png --flip hdr", "hdr"),
        ("a.exr b.exr --flip ldr", "ldr"),
    ] {
        assert_eq!(flip(line)["mode"], mode, "{line}");
    }
    assert_eq!(flip("a.png b.png")["exposure"], 0.0);
    let dark = flip("a.exr b.exr --flip ldr --exposure -6");
    assert_eq!(dark["exposure"], -6.0);
    assert!(dark["mean"].as_f64() < flip("a.exr b.exr --flip ldr")["mean"].as_f64());
    let near = flip("a.png b.png --pixels-per-degree 10");
    assert_eq!(near["pixels_per_degree"], 10.0);
    assert_ne!(near["mean"], flip("a.png b.png")["mean"]);
}

#[test]
fn threshold_fails_only_above_its_value() {
    let sandbox = sandbox();
    let found = report(&run(&sandbox, "a.exr b.exr --json"));
    let figures = [
        ("max-rmse", found["rmse"].as_f64().unwrap()),
        ("max-relative", found["relative_error"].as_f64().unwrap()),
        ("max-flip", found["flip"]["mean"].as_f64().unwrap()),
        ("max-difference", 0.25),
    ];
    for (flag, figure) in figures {
        run(&sandbox, &format!("a.exr b.exr --{flag} {figure}")).expect(0, &[]);
        let below = figure * (1.0 - 1e-9);
        let reason = format!("--{flag}: ");
        let ended = run(&sandbox, &format!("a.exr b.exr --{flag} {below} --json"));
        assert_eq!(report(ended.expect(4, &[&reason, " is more than "]))["exceeded"], json!([flag]));
    }
    run(&sandbox, "a.exr b.exr --max-relative 400%").expect(0, &[]);
    run(&sandbox, "a.exr b.exr --max-relative 0.001%").expect(4, &["--max-relative"]);
    let ended = run(&sandbox, "a.exr b.exr --max-rmse 0 --max-flip 1 --identical --quiet");
    ended.expect(4, &["--max-rmse: an RMSE of 0.0625 is more than 0", "--identical: 2 pixels differ"]);
    assert!(!ended.stderr.contains("max-flip") && ended.stdout.contains("RMSE"));
}

#[test]
fn identical_images_have_zero_difference() {
    let sandbox = sandbox();
    for line in ["a.exr a.exr", "a.png a.png"] {
        let strict = "--identical --max-rmse 0 --max-relative 0 --max-flip 0 --max-difference 0 --json";
        let ended = run(&sandbox, &format!("{line} {strict}"));
        ended.expect(0, &[]);
        let found = report(&ended);
        assert!(["rmse", "relative_mse", "relative_error"].iter().all(|f| found[f] == 0.0), "{found}");
        assert_eq!((&found["flip"]["mean"], &found["differing_pixels"]), (&json!(0.0), &json!(0)));
        assert_eq!(found["largest"], json!({"red": null, "green": null, "blue": null}));
    }
    // No level of an 8-bit PNG is exactly ½.
    run(&sandbox, "a.png a.exr --identical").expect(4, &["8 pixels differ"]);
}

#[test]
fn difference_maps_are_coloured_or_numeric() {
    let sandbox = sandbox();
    let written = run(&sandbox, "a.exr b.exr --map absolute -o map.png --json");
    // The largest difference of a pixel, as a mean over channels, is (¼ + ⅛)/3. Colours end at the
    // 99th percentile of eight pixels. It covers the seven smallest differences, which are up to
    // ⅛/3.
    written.expect(0, &["wrote map.png: absolute, colours from 0 to 0.0417"]);
    let colors = json!({"from": 0.0, "to": 0.125 / 3.0});
    assert_eq!(report(&written)["map"], json!({"file": "map.png", "kind": "absolute", "colors": colors}));
    let near = |found: Vec3, expected: Vec3| (found - expected).abs().max_element() < 0.01;
    let map = read(&sandbox.path("map.png"));
    assert!(near(map.get(3, 1).unwrap(), sequential_color(1.0)) && near(map.get(1, 0).unwrap(), sequential_color(0.0)));

    run(&sandbox, "a.exr b.exr --map signed -o map.exr --quiet").expect(0, &[]);
    let map = read(&sandbox.path("map.exr"));
    assert_eq!((map.get(3, 1), map.get(0, 1)), (Some(Vec3::new(0.0, 0.25, -0.125)), Some(Vec3::Z * 0.125)));
    run(&sandbox, "a.exr b.exr --map relative -o relative.exr").expect(0, &["wrote relative.exr: relative"]);
    let map = read(&sandbox.path("relative.exr"));
    let square: f64 = map.pixels().iter().map(|p| f64::from(p.x * p.x)).sum::<f64>() / 8.0;
    let whole = report(&run(&sandbox, "a.exr b.exr --json"));
    assert!((square.sqrt() - whole["relative_error"].as_f64().unwrap()).abs() < 1e-7);
    run(&sandbox, "a.exr b.exr -o flip.exr").expect(0, &[]);
    let mean: f64 = read(&sandbox.path("flip.exr")).pixels().iter().map(|p| f64::from(p.y)).sum::<f64>() / 8.0;
    assert!((mean - whole["flip"]["mean"].as_f64().unwrap()).abs() < 1e-9);
    run(&sandbox, "a.exr b.exr -o flip.png").expect(0, &["wrote flip.png: flip, colours from 0 to 1"]);
    // The map is written even if a threshold is exceeded, because it shows where.
    run(&sandbox, "a.exr b.exr -o why.png --identical").expect(4, &["wrote why.png"]);
    assert!(sandbox.path("why.png").exists());
}

#[test]
fn unreadable_or_incomparable_images_exit_1() {
    let sandbox = sandbox();
    run(&sandbox, "none.png a.png").expect(1, &["cannot read `none.png`"]);
    run(&sandbox, "a.png box.txt").expect(1, &["`box.txt` is not a PNG, OpenEXR or Radiance HDR picture"]);
    put(&sandbox, "small.exr", 2, &[Vec3::ONE; 4]);
    let sizes = ["`small.exr` has 2 × 2 pixels, but `a.exr` has 4 × 2", "help: render both with the same --size"];
    run(&sandbox, "small.exr a.exr -o map.png").expect(1, &sizes);
    let mut pixels = [Vec3::ONE; 8];
    pixels[6].y = f32::NAN;
    put(&sandbox, "nan.exr", 4, &pixels);
    let place = ["`nan.exr` has a pixel that is not finite, in column 2, row 1", "help:"];
    run(&sandbox, "nan.exr a.exr -o map.png").expect(1, &place);
    run(&sandbox, "a.exr nan.exr -o map.png").expect(1, &place);
    assert!(!sandbox.path("map.png").exists());
}

#[test]
fn bad_arguments_exit_2_and_bad_outputs_3() {
    let sandbox = sandbox();
    for (line, parts) in [
        ("a.png", ["<B>", ""]),
        ("a.png b.png --max-relative most", ["`most` is not a fraction", "2% or 0.02"]),
        ("a.png b.png --max-rmse -1", ["-1", ""]),
        ("a.png b.png --max-flip nan", ["`nan` is not a bound", ""]),
        ("a.png b.png --map colour", ["colour", "signed"]),
        ("a.png b.png --pixels-per-degree 0", ["1 to 1000", ""]),
        ("a.png b.png --flip hdr --exposure 1", ["--exposure applies to LDR-FLIP", "--flip ldr"]),
        ("a.exr b.exr --exposure 1", ["--exposure applies to LDR-FLIP", "--flip ldr"]),
    ] {
        run(&sandbox, line).expect(2, &parts);
    }
    run(&sandbox, "none.png none.png -o map.jpg").expect(3, &["`map.jpg`", ".png or .exr"]);
    run(&sandbox, "a.png b.png -o no/map.png").expect(3, &["no folder `no`", "create it"]);
}
