//! Tests of `caustica plan` and of `caustica study --effects`.

use super::{CliSandbox, ProgramRun};
use serde_json::Value;

fn run(sandbox: &CliSandbox, line: &str) -> ProgramRun {
    sandbox.run(&line.split_whitespace().collect::<Vec<_>>())
}

fn study(sandbox: &CliSandbox, more: &str) -> ProgramRun {
    run(sandbox, &format!("study --effects box.txt --photons 2k --spp 1 --passes 2 {more}"))
}

fn json(ended: &ProgramRun) -> Value {
    ended.expect(0, &[]);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn effect<'v>(report: &'v Value, name: &str) -> &'v Value {
    report["effects"].as_array().unwrap().iter().find(|e| e["effect"] == name).unwrap()
}

#[test]
fn plan_lists_work_of_each_effect() {
    let sandbox = CliSandbox::new();
    let line = "plan box.txt --photons 20k --spp 2";
    let report = json(&run(&sandbox, &format!("{line} --json")));
    assert!(report["rays"].as_i64() > Some(40 * 30 * 2) && report["gathered_photons"].as_i64() > Some(0));
    assert!(effect(&report, "shadows")["rays"].as_i64() > Some(0));
    assert!(effect(&report, "caustics")["gathered_photons"].as_i64() > Some(0));
    let off = effect(&report, "environment");
    assert!(off["on"] == false && off["rays"].is_null() && off["gathered_photons"].is_null());
    let table = run(&sandbox, line);
    table.expect(0, &[]);
    assert!(table.stdout.contains(" rays, ") && table.stdout.contains("total about "), "{}", table.stdout);
    assert!(table.stdout.lines().all(|l| l.chars().count() <= 110), "{}", table.stdout);
    // The table holds counts and no times, so it does not depend on threads.
    assert_eq!(table.stdout, run(&sandbox, &format!("{line} --threads 1")).stdout);
}

#[test]
fn missing_photons_from_emissive_media_cause_a_warning() {
    let sandbox = CliSandbox::new();
    let scene = |emission: &str| {
        format!(
            "PerspectiveCamera {{ center 0 1 6 lookAt 0 1 0 angle 40 width 8 height 6 }}
            Lights {{ PointLight {{ position 0 5 0 power 1 1 1 }} }}
            Media {{ Medium flame {{ absorption 1 1 1 emission {emission} }} }}
            Materials {{ Diffuse floor {{ reflectance .7 .7 .7 }} Clear inside {{ medium flame }} }}
            Group {{
                MaterialName floor Plane {{ normal 0 1 0 offset 0 }}
                MaterialName inside Sphere {{ center 0 1 0 radius .5 }}
            }}"
        )
    };
    sandbox.put("flame.txt", scene("9 5 1"));
    sandbox.put("smoke.txt", scene("0 0 0"));
    let warning = "media that emit light are seen but light nothing";
    let render = |name: &str, method: &str| {
        let ended = sandbox.render(name, &format!("-o a.exr --photons 1k --passes 1 --integrator {method}"));
        ended.expect(0, &[]);
        ended.stderr.contains(warning)
    };
    for method in ["sppm", "ppm", "pm --final-gathering none"] {
        assert!(render("flame.txt", method) && !render("smoke.txt", method), "{method}");
    }
    for method in ["hybrid", "path", "pm"] {
        assert!(!render("flame.txt", method), "{method}");
    }
}

#[test]
#[ignore = "long: many runs of the program"]
fn effect_overrides_reach_every_command() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.png --effects +caustics,-shadows").expect(0, &["without shadows"]);
    let plan = run(&sandbox, "plan box.txt --effects -shadows --json --photons 1k --spp 1");
    assert_eq!(effect(&json(&plan), "shadows")["on"], false);
    let studied = json(&study(&sandbox, "--wish -shadows --json"));
    assert!(effect(&studied, "shadows")["on"] == false && effect(&studied, "shadows")["cost"].is_null());
}

#[test]
#[ignore = "long: many runs of the program"]
fn effect_study_prints_table_or_json() {
    let sandbox = CliSandbox::new();
    let table = study(&sandbox, "");
    table.expect(0, &["plan: ", "pass 2/2 of each"]);
    let report = json(&study(&sandbox, "--json --quiet --no-prefix-rays"));
    for row in report["effects"].as_array().unwrap() {
        let name = row["effect"].as_str().unwrap();
        assert!(table.stdout.contains(&format!("  {name} ")), "{name} is not in\n{}", table.stdout);
        assert_eq!(row["on"] == true, row["gain"]["rmse"].is_f64(), "{name}");
    }
    assert!(table.stdout.lines().all(|l| l.chars().count() <= 110), "{}", table.stdout);
    assert_eq!((&report["passes"], &report["interrupted"]), (&2.into(), &false.into()));
    assert!(effect(&report, "shadows")["gain"]["takes"].as_f64() > Some(0.0));
    let camera_rays = &report["whole"]["counters"]["camera_rays"];
    assert_eq!(*camera_rays, 40 * 30 * 2);
    assert_eq!(sandbox.names(), ["box.txt"], "nothing is written unasked");
    let fields = ["clock", "mean", "whole"].map(|f| &report[f]);
    assert!(fields.iter().all(|f| !f.is_null()));
}

/// Checks that tags are nested properly, and that every `&` and `<` is markup.
fn check_well_formed(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page.strip_prefix("<!DOCTYPE html>").unwrap();
    while let Some((text, after)) = rest.split_once('<') {
        assert!(!text.contains('>'), "{text}");
        for (at, _) in text.match_indices('&') {
            assert!(["&amp;", "&lt;", "&gt;", "&quot;"].iter().any(|e| text[at..].starts_with(e)), "{text}");
        }
        let (tag, after) = after.split_once('>').unwrap();
        let name = tag.split_whitespace().next().unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if let Some(name) = name.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = after;
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest}");
}

#[test]
fn effect_page_embeds_all_images() {
    let sandbox = CliSandbox::new();
    study(&sandbox, "-o a.html -o a.json").expect(0, &["wrote a.html", "wrote a.json"]);
    assert_eq!(sandbox.names(), ["a.html", "a.json", "box.txt"]);
    let page = String::from_utf8(sandbox.bytes("a.html")).unwrap();
    check_well_formed(&page);
    let report: Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    let rows = report["effects"].as_array().unwrap();
    for row in rows {
        let name = row["effect"].as_str().unwrap();
        assert!(page.contains(&format!("id=\"{name}\"")) == (row["on"] == true) && page.contains(name), "{name}");
        assert!(page.contains(row["reason"].as_str().unwrap()), "{name}");
    }
    let on = rows.iter().filter(|r| r["on"] == true && r["gain"]["rmse"].as_f64() > Some(0.0)).count();
    assert!(page.matches("src=\"data:image/png;base64,iVBORw0KGgo").count() > on, "the whole, and one an effect");
    assert!(page.contains("Light removed by shadows: exposure "));
}

#[test]
fn failed_study_has_exit_code_and_keeps_page() {
    let sandbox = CliSandbox::new();
    sandbox.put("a.html", "old page");
    run(&sandbox, "study --effects").expect(2, &["SCENE"]);
    run(&sandbox, "study --effects box.txt --passes 0 -o a.html").expect(2, &["at least 1"]);
    study(&sandbox, "--simulate shadows -o a.html").expect(2, &["`shadows` is no effect override"]);
    study(&sandbox, "--size 16384x16385 -o a.html").expect(2, &["--size"]);
    run(&sandbox, "study --effects none.txt -o a.html").expect(1, &["none.txt", "help: check the path"]);
    let long = "--spp 100k --passes 1k";
    let refused = |line: &str, parts: &[&str]| {
        run(&sandbox, &format!("study --effects box.txt {long} {line}")).expect(3, parts);
    };
    refused(
        "-o a.png",
        &["`a.png` has no extension of a report", "help: give it the extension .html or .csv or .json or .md"],
    );
    refused("-o no/a.html", &["no folder `no`"]);
    assert_eq!(
        (sandbox.bytes("a.html"), sandbox.names()),
        (b"old page".to_vec(), vec!["a.html".into(), "box.txt".into()])
    );
}
