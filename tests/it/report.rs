//! Study reports: pages are well-formed and self-contained, and a browser shows their content.

use crate::support::browser::Browser;
use caustica::image::Image;
use caustica::integrate::{Algorithm, DEFAULT_ALPHA, squared_radius_ratio};
use caustica::sampling::{Dimension, Key};
use caustica::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult, Reference};
use caustica::study::report::methods::{csv_report, markdown_report, method_study_json, methods_html_page};
use glam::Vec3;
use std::collections::BTreeSet;

const WIDTH: u32 = 192;
const HEIGHT: u32 = 144;
const SEEDS: u64 = 6;

fn random(key: Key) -> f64 {
    f64::from(key.uniform_1d(Dimension::Light))
}

/// Returns the radiance of a synthetic image: a floor with a bright spot, and a ball before a wall.
fn radiance(x: f64, y: f64) -> Vec3 {
    let spot = libm::exp(-((x - 0.7) * (x - 0.7) * 60.0 + (y - 0.8) * (y - 0.8) * 300.0));
    let (bx, by) = ((x - 0.4) / 0.2, (y - 0.55) / 0.26);
    let ball = bx * bx + by * by;
    if ball < 1.0 {
        let light = 0.1 + 0.5 * (1.0 - ball).sqrt() * (1.0 - 0.7 * by).max(0.0);
        return Vec3::new(0.9, 0.4, 0.3) * light as f32;
    }
    let wall = if y < 0.6 { 0.15 + 0.2 * y } else { 0.3 + 0.9 * spot };
    Vec3::new(0.8, 0.85, 0.9) * wall as f32
}

fn picture(of: impl Fn(f64, f64, u32) -> Vec3) -> Image {
    let at = |i: u32| of(f64::from(i % WIDTH) / f64::from(WIDTH), f64::from(i / WIDTH) / f64::from(HEIGHT), i);
    Image::from_pixels(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(at).collect()).unwrap()
}

/// Returns synthetic results of a method.
///
/// In its first pass, the method has the standard deviation `noise` and the bias `bias`. A pass
/// takes `pass` seconds.
fn method(label: &str, algorithm: Algorithm, noise: f64, bias: f64, pass: f64, count: u32) -> MethodResult {
    let key = Key::new(5).child_key(label.bytes().map(u64::from).sum());
    let alpha = if algorithm == Algorithm::Pm { 1.0 } else { DEFAULT_ALPHA };
    let shrinks = |i| {
        if matches!(algorithm, Algorithm::Sppm | Algorithm::Hybrid) {
            squared_radius_ratio(DEFAULT_ALPHA, i)
        } else {
            1.0
        }
    };
    let checkpoint = |i: u32| {
        let n = 1 << i;
        let variance = noise * noise * (0..n).map(|i| 1.0 / shrinks(i)).sum::<f64>() / f64::from(n * n);
        let drift = bias * (0..n).map(shrinks).sum::<f64>() / f64::from(n);
        let own = |seed| 0.9 + 0.2 * random(key.child_key(seed).child_key(u64::from(i)));
        let squared_noises: Vec<f64> = (0..SEEDS).map(|seed| variance * own(seed)).collect();
        let squared_errors: Vec<f64> = squared_noises.iter().map(|n| n + drift * drift).collect();
        let seconds = pass * f64::from(n);
        ConvergenceCheckpoint {
            passes: n,
            cpu_seconds: seconds,
            wall_seconds: 0.5 * seconds,
            rays: 3e6 * f64::from(n),
            photon_paths: if algorithm.traces_photons() { 5e5 * f64::from(n) } else { 0.0 },
            squared_noise: squared_noises.iter().sum::<f64>() / SEEDS as f64,
            squared_bias: drift * drift,
            squared_estimated_errors: squared_errors.iter().map(|s| 1.1 * s).collect(),
            rmse: 0.3 * squared_errors[0].sqrt(),
            flip: squared_errors[0].sqrt().min(1.0) * 0.5,
            squared_noises,
            relative_squared_errors: squared_errors,
        }
    };
    let checkpoints: Vec<ConvergenceCheckpoint> = (0..count).map(checkpoint).collect();
    let last = checkpoints.last().unwrap();
    let (grain, blur) = (last.squared_noise.sqrt(), last.squared_bias.sqrt());
    let soft = |x: f64, y: f64| {
        let around = [(-0.02, 0.0), (0.02, 0.0), (0.0, -0.03), (0.0, 0.03)];
        let mean = around.iter().map(|(dx, dy)| radiance(x + dx, y + dy)).sum::<Vec3>() / 4.0;
        radiance(x, y).lerp(mean, (8.0 * blur).min(1.0) as f32)
    };
    let grains =
        |i: u32, amount: f64| (3.0 * amount * (random(key.child_key(99).child_key(u64::from(i))) - 0.5)) as f32;
    let shown = picture(|x, y, i| soft(x, y) + Vec3::splat(grains(i, 0.4 * grain)));
    let reference = picture(|x, y, _| radiance(x, y));
    let pairs = || shown.pixels().iter().zip(reference.pixels());
    MethodResult {
        label: label.into(),
        algorithm,
        render_command: format!(
            "caustica render --integrator {} --seed 1 --passes {} \"room & <ball>.txt\"",
            algorithm.name(),
            1 << (count - 1)
        ),
        setup_seconds: 0.4,
        alpha,
        gather_radii: algorithm.traces_photons().then_some([0.08, 0.02]),
        relative_pixel_errors: pairs().map(|(a, b)| (*a - *b).length() / (b.length() + 0.2)).collect(),
        mean_difference: Image::from_pixels(WIDTH, HEIGHT, pairs().map(|(a, b)| *a - *b).collect()).unwrap(),
        first_seed_picture: shown,
        checkpoints,
    }
}

fn found() -> MethodStudyResult {
    MethodStudyResult {
        scene_path: "room & <ball>.txt".into(),
        study_command: "caustica study \"room & <ball>.txt\" --methods path,hybrid,sppm,pm --budget 60s --seeds 6 --output report.html".into(),
        program: "Caustica 0.1.0".into(),
        machine: "an imagined processor, 2 threads".into(),
        seeds: SEEDS as u32,
        max_cpu_seconds_per_seed: 60.0,
        thread_time_share: 0.85,
        reference: Reference {
            source: "auto: 256 passes of hybrid, twice".into(),
            error: Some(0.004),
            picture: picture(|x, y, _| radiance(x, y)),
        },
        methods: vec![
            method("path", Algorithm::Path, 0.5, 0.0, 0.23, 9),
            method("hybrid", Algorithm::Hybrid, 0.17, 0.02, 0.4, 8),
            method("sppm", Algorithm::Sppm, 0.3, 0.12, 0.31, 8),
            method("sppm --gather-k 20 --photons 2M", Algorithm::Sppm, 0.24, 0.15, 0.45, 8),
            method("pm", Algorithm::Pm, 0.21, 0.085, 0.5, 7),
        ],
        interrupted: false,
    }
}

/// Returns the page without its embedded images, whose base64 text could contain any word.
fn words(page: &str) -> String {
    let mut parts = page.split("base64,");
    let mut text = parts.next().unwrap().to_owned();
    parts.for_each(|part| text += &part[part.find('"').unwrap()..]);
    text
}

/// Returns a message if tags are not nested properly.
fn unbalanced(page: &str) -> Option<String> {
    let mut open = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let Some(end) = rest.find('>') else { return Some("a tag without an end".into()) };
        let tag = &rest[..end];
        let name = |tag: &str| tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap().to_owned();
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        if tag.starts_with('/') {
            let last: Option<String> = open.pop();
            if last.as_ref() != Some(&name(tag)) {
                return Some(format!("{last:?} is closed by {tag}"));
            }
        } else {
            open.push(name(tag));
        }
    }
    (!open.is_empty()).then(|| format!("{open:?} stay open"))
}

#[test]
fn tag_counter_finds_unclosed_tags() {
    assert_eq!(unbalanced("<!DOCTYPE html>\n<a b=\"c\"><d/></a>"), None);
    assert!(unbalanced("<a><b></a></b>").is_some() && unbalanced("<a>").is_some() && unbalanced("</a>").is_some());
}

#[test]
fn report_page_is_well_formed_and_self_contained() {
    let page = words(&methods_html_page(&found()).unwrap());
    assert_eq!(unbalanced(&page), None);
    for fetched in ["http", "url(//", "@import", "<link", "<iframe", " src=\"/"] {
        assert!(!page.contains(fetched), "{fetched}");
    }
    let ids: Vec<&str> = page.split(" id=\"").skip(1).map(|part| part.split('"').next().unwrap()).collect();
    assert!(ids.len() > 20 && ids.iter().collect::<BTreeSet<_>>().len() == ids.len(), "{ids:?}");
    for link in page.split("href=\"#").skip(1).map(|part| part.split('"').next().unwrap()) {
        assert!(ids.contains(&link), "{link}");
    }
    for reference in page.split("url(#").skip(1).map(|part| part.split(')').next().unwrap()) {
        assert!(ids.contains(&reference), "{reference}");
    }
    for part in [
        "room &amp; &lt;ball&gt;.txt",
        "plateau: bias of 8.50 % stays at r = 0.0800, caustics at r = 0.0200",
        "falls as theory says",
        "never: plateau",
        "auto: 256 passes of hybrid, twice, its own error about 0.400 %",
        "85 % of its threads",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // A figure without its command could not be reproduced.
    assert_eq!(page.matches("<figure").count(), page.matches("<code class=\"command\">").count());
    assert_eq!(methods_html_page(&found()).unwrap(), methods_html_page(&found()).unwrap());
}

#[test]
fn minimal_study_makes_a_page() {
    let mut found = found();
    found.methods.truncate(2);
    found.methods[0].checkpoints.clear();
    let last = &mut found.methods[1];
    last.checkpoints.truncate(1);
    last.checkpoints[0] = ConvergenceCheckpoint { passes: 1, ..ConvergenceCheckpoint::default() };
    last.relative_pixel_errors.fill(0.0);
    let page = words(&methods_html_page(&found).unwrap());
    assert!(unbalanced(&page).is_none() && page.contains("too few checkpoints") && !page.contains("NaN"));
    found.methods.clear();
    assert_eq!(unbalanced(&words(&methods_html_page(&found).unwrap())), None);
    assert!(
        csv_report(&found).lines().count() == 1
            && method_study_json(&found).is_ok()
            && markdown_report(&found).contains("room")
    );
}

#[test]
fn data_files_hold_every_checkpoint() {
    let found = found();
    let table = csv_report(&found);
    let rows: Vec<&str> = table.split("\r\n").collect();
    assert_eq!(rows.len(), 1 + 9 + 8 + 8 + 8 + 7 + 1);
    assert!(rows[1].ends_with("\"caustica render --integrator path --seed 1 --passes 256 \"\"room & <ball>.txt\"\"\""));
    let data: serde_json::Value = serde_json::from_str(&method_study_json(&found).unwrap()).unwrap();
    assert_eq!(data["schema"], 1);
    let methods = data["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 5);
    assert_eq!(methods[0]["checkpoints"][8]["passes"], 256);
    assert_eq!(methods[4]["reaches"][3]["how"], "never");
    assert!((methods[0]["fit"]["error"]["by_passes"]["value"].as_f64().unwrap() + 0.5).abs() < 0.02);
    let text = markdown_report(&found);
    assert!(text.contains("| path | ") && text.contains("never: plateau") && text.contains("```sh\ncaustica render"));
}

#[test]
#[ignore = "long: a browser"]
fn browser_shows_the_page() {
    let Some(browser) = Browser::find() else {
        eprintln!("skipped: no chromium, chromium-browser or google-chrome in PATH");
        return;
    };
    let page = methods_html_page(&found()).unwrap();
    let shown = browser.open("report.html", &page, "", (1000, 900));
    assert!(shown.complaints.is_empty(), "{:?}", shown.complaints);
    let dom = words(&shown.dom);
    assert!(dom.contains("aria-pressed=\"true\">reference</button>"), "the script ran");
    assert_eq!(dom.matches("class=\"picture shown\"").count(), 1);
    assert_eq!(dom.matches("<polyline").count(), page.matches("<polyline").count());

    // The window is high enough to show the whole page, because a screenshot contains only visible
    // parts.
    let high = (1000, 12_000);
    let pm = browser.open("report.html", &page, "#show=pm", high);
    let long = browser.open("report.html", &page, "#show=sppm%20--gather-k%2020%20--photons%202M", high);
    assert!(words(&long.dom).contains("aria-pressed=\"true\">sppm --gather-k 20"));
    let differing = pm.pixels.iter().zip(&long.pixels).filter(|(a, b)| a != b).count();
    // At least a tenth of the image's pixels must differ.
    assert!(differing > (WIDTH * HEIGHT / 10) as usize, "{differing}");

    let press = "<script>document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }))</script></body>";
    let turned = browser.open("report.html", &page.replace("</body>", press), "#show=hybrid", (1000, 900));
    assert!(words(&turned.dom).contains("aria-pressed=\"true\">path</button>") && turned.complaints.is_empty());

    // A page with the plot alone.
    let style = &page[page.find("<style>").unwrap()..page.find("</style>").unwrap() + "</style>".len()];
    let svg = &page[page.find("<svg id=\"errors\"").unwrap()..];
    let svg = &svg[..svg.find("</svg>").unwrap() + "</svg>".len()];
    let plot = browser.open(
        "plot.html",
        &format!("<!DOCTYPE html>{style}<div class=\"plot main\">{svg}</div>"),
        "",
        (1000, 600),
    );
    for colour in [[0x00, 0x72, 0xb2], [0xd5, 0x5e, 0x00], [0x00, 0x9e, 0x73], [0xcc, 0x79, 0xa7], [0xe6, 0x9f, 0x00]] {
        let count = plot.pixels.iter().filter(|p| **p == colour).count();
        // Seven markers have this colour, with about fifty pixels each.
        assert!(count > 200, "{colour:?} {count}");
    }
}
