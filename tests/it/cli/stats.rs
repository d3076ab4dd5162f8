//! The report of `--stats`, against its description in docs/guide/command-line.md.

use super::CliSandbox;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Adds to `found` the dotted path of each value in `value` that is not an object.
///
/// `path` is the path of `value` itself.
fn json_paths(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                json_paths(value, &path, found);
            }
        }
        _ => assert!(found.insert(path.to_owned()), "{path} comes twice"),
    }
}

/// Returns the fields in the first column of the table under `## Statistics`.
fn documented_fields() -> BTreeSet<String> {
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/command-line.md")).unwrap();
    let section = page.split("\n## ").find(|s| s.starts_with("Statistics")).expect("a section `## Statistics`");
    let mut fields = BTreeSet::new();
    for cell in section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once(" |")).map(|(cell, _)| cell) {
        for field in cell.split(", ").map(|f| f.trim_matches('`')) {
            assert!(fields.insert(field.to_owned()), "{field} is described twice");
        }
    }
    fields
}

fn stats(more: &str) -> Value {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", &format!("-o a.png --integrator sppm --stats a.json {more}")).expect(0, &[]);
    serde_json::from_slice(&sandbox.bytes("a.json")).unwrap()
}

#[test]
#[ignore = "long: many runs of the program"]
fn docs_describe_exactly_every_stats_field() {
    let mut found = BTreeSet::new();
    let balanced = CliSandbox::new();
    // The flags set no photon counts, so that pilots choose the counts and report them. Sky
    // light and scattering fog have pilots of their own, each in a scene without the other.
    balanced.put("sky.txt", super::BOX.replace("Lights {", "Lights { EnvironmentLight { radiance .1 .1 .1 }"));
    let fog = "Media { Medium fog { absorption 0 0 0 scattering .2 .2 .2 } }\nMaterials {";
    let foggy = super::BOX.replace("Materials {", fog).replace("color 0 0 0", "color 0 0 0 medium fog");
    balanced.put("fog.txt", foggy);
    for (scene, integrator) in [("sky.txt", "sppm"), ("fog.txt", "hybrid")] {
        let arguments =
            format!("render {scene} -o a.png --integrator {integrator} --size 8x8 --passes 4 --stats a.json");
        balanced.run(&arguments.split(' ').collect::<Vec<_>>()).expect(0, &[]);
        let mut of_scene = BTreeSet::new();
        json_paths(&serde_json::from_slice(&balanced.bytes("a.json")).unwrap(), "", &mut of_scene);
        found.append(&mut of_scene);
    }
    // A field that is null in one of the scenes has fields of its own in the other.
    let all = found.clone();
    found.retain(|field| !all.iter().any(|other| other.starts_with(&format!("{field}."))));
    // `photons` and `emission_guiding` have the same fields for both maps, which the page describes
    // once, as `*`.
    let found: BTreeSet<String> = found
        .iter()
        .map(|f| f.replace("photons.global.", "photons.*.").replace("photons.caustic.", "photons.*."))
        .map(|f| {
            f.replace("emission_guiding.global.", "emission_guiding.*.")
                .replace("emission_guiding.caustic.", "emission_guiding.*.")
        })
        .collect();
    assert_eq!(found, documented_fields());
}

#[test]
fn stats_report_given_settings() {
    let stats = stats("--seed 5 --threads 2 --passes 3 --photons 2k --caustic-photons 700 --spp 2 --radius .25");
    for (field, value) in [
        ("schema", 3),
        ("seed", 5),
        ("threads", 2),
        ("passes", 3),
        ("width", 40),
        ("height", 30),
        ("triangles", 0),
        ("shapes", 9),
        ("lights", 1),
    ] {
        assert_eq!(stats[field], value, "{field}");
    }
    let photons = &stats["photons"];
    assert_eq!((&photons["global"]["emitted"], &photons["caustic"]["emitted"]), (&6000.into(), &2100.into()));
    assert_eq!((&stats["radii"]["global"], &stats["radii"]["caustic"]), (&0.25.into(), &0.25.into()));
    assert_eq!(
        (&stats["scene"], &stats["integrator"], &stats["ended"]),
        (&"box.txt".into(), &"sppm".into(), &"passes".into())
    );
    assert_eq!(stats["version"], env!("CARGO_PKG_VERSION"));
    let counters = &stats["counters"];
    let count = |name: &str| counters[name].as_u64().unwrap();
    assert_eq!((count("camera_rays"), count("rejected_samples")), (40 * 30 * 2 * 3, 0));
    assert!(count("gathers") > 0 && count("gathered_photons") > 0 && count("photon_rays") >= 8100);
    let times = &stats["seconds"];
    let second = |name: &str| times[name].as_f64().unwrap();
    assert!(second("photons") + second("indexing") + second("camera") <= second("render"));
    let rays: u64 = ["camera_rays", "continuation_rays", "shadow_rays", "photon_rays"].map(count).iter().sum();
    let rate = |name: &str| stats["rates"][name].as_f64().unwrap();
    assert!((rate("rays_per_second") * second("render") / rays as f64 - 1.0).abs() < 1e-9);
    assert!((rate("photons_per_second") * second("photons") / 8100.0 - 1.0).abs() < 1e-9);
}

/// In every channel, emitted flux = absorbed + escaped + stopped + roulette.
///
/// Each path has rounding errors of 2⁻²⁴ per bounce in single precision, and sums are double. The
/// tolerance of 10⁻⁶ holds for paths of up to sixteen bounces; longer ones carry little flux.
#[test]
fn the_energy_audit_adds_up() {
    for more in ["--photons 20k --passes 2", "--photons 20k --max-bounces 0", "--photons 20k --max-bounces 2 --seed 3"]
    {
        let stats = stats(more);
        for map in ["global", "caustic"] {
            let audit = &stats["photons"][map]["audit"];
            for channel in 0..3 {
                let flux = |name: &str| audit[name][channel].as_f64().unwrap();
                let gone = flux("absorbed") + flux("escaped") + flux("stopped") + flux("roulette");
                assert!((flux("emitted") - gone).abs() < 1e-6 * flux("emitted"), "{more} {map} {channel}: {audit}");
                // The box is closed, so no flux escapes.
                assert!(flux("escaped").abs() < 1e-6 * flux("emitted"), "{more} {map}: {audit}");
            }
        }
        // Global photons carry the light's power: all of it, in each pass.
        let emitted = stats["photons"]["global"]["audit"]["emitted"][0].as_f64().unwrap();
        let passes = stats["passes"].as_f64().unwrap();
        assert!((emitted / (20.0 * passes) - 1.0).abs() < 1e-5, "{emitted}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn linux_reports_memory_and_cpu_time() {
    let stats = stats("--photons 20k --passes 2");
    // A small render takes more than a mebibyte and less than two gibibytes.
    assert!((1 << 20..1 << 31).contains(&stats["peak_memory_bytes"].as_u64().unwrap()));
    assert!(stats["cpu_seconds"].as_f64().unwrap() >= 0.0);
}
