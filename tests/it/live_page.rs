//! The live page, tested from outside: by HTTP, and in a headless browser.

use crate::support::devtools::DevTools;
use crate::support::{PATIENCE, project_path};
use caustica::image::{self, Image, WriteOptions};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Scene of a box with a lamp and two balls.
const SCENE: &str = "\
PerspectiveCamera { center 0 1 3.9  lookAt 0 1 0  angle 40  width 96  height 72 }
Background { color .1 .1 .2 }
Lights { RectangleLight { corner -.5 1.98 -.5  edge0 1 0 0  edge1 0 0 1  power 20 18 15 } }
Materials {
    Diffuse white { reflectance .75 .75 .75 }
    Dielectric glass { indexOfRefraction 1.5 }
}
Group {
    MaterialName white
    Rectangle { corner -1 0 -1  edge0 0 0 3  edge1 2 0 0 }
    Rectangle { corner -1 0 -1  edge0 2 0 0  edge1 0 2 0 }
    Sphere { center .45 .4 -.3 radius .4 }
    MaterialName glass  Sphere { center -.4 .4 .5 radius .4 }
}
";

/// A running program that serves a live page, in a temporary folder of its own.
struct LiveProgram {
    child: Child,
    messages: BufReader<std::process::ChildStderr>,
    folder: tempfile::TempDir,
    address: String,
}

impl LiveProgram {
    /// Starts the program with the arguments `words`, in a folder with [`SCENE`] as `scene.txt`.
    fn start(words: &str) -> Self {
        Self::start_with_files(words, &[("scene.txt", SCENE)])
    }

    /// Starts the program with the arguments `words`, in a folder with files of these names and
    /// texts.
    fn start_with_files(words: &str, files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
        let mut child = Command::new(env!("CARGO_BIN_EXE_caustica"))
            .current_dir(folder.path())
            .args(words.split_whitespace())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut messages = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        messages.read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("live page: ").unwrap_or_else(|| panic!("{line}")).to_owned();
        Self { child, messages, folder, address }
    }

    /// Replaces a file of the folder as a whole, so that the program never reads half of it.
    fn write(&self, name: &str, text: &str) {
        let aside = self.folder.path().join("aside");
        fs::write(&aside, text).unwrap();
        fs::rename(&aside, self.folder.path().join(name)).unwrap();
    }

    /// Sends an HTTP request for a path below the address of the page, and returns the connection.
    fn request(&self, method: &str, path: &str) -> BufReader<TcpStream> {
        let (host, root) = self.address.strip_prefix("http://").unwrap().split_once('/').unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "{method} /{root}{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
        )
        .unwrap();
        BufReader::new(stream)
    }

    /// Reads states of the page until one fulfils a condition, and returns this state. Panics after
    /// [`PATIENCE`].
    #[track_caller]
    fn wait_for(&self, mut condition: impl FnMut(&Value) -> bool) -> Value {
        let start = Instant::now();
        let mut events = self.request("GET", "events");
        let mut line = String::new();
        loop {
            line.clear();
            assert!(events.read_line(&mut line).unwrap() > 0, "the stream has ended");
            assert!(start.elapsed() < PATIENCE, "no state fulfils the condition");
            if let Some(state) = line.strip_prefix("data: ") {
                let state = serde_json::from_str(state).unwrap();
                if condition(&state) {
                    return state;
                }
            }
        }
    }

    /// Sends the request that the page's script sends for `name`, and waits for the answer's status
    /// line.
    fn post(&self, name: &str) {
        let mut line = String::new();
        self.request("POST", &format!("request/{name}")).read_line(&mut line).unwrap();
        assert!(line.contains(" 204 "), "{line}");
    }
}

/// Returns the bits of the picture that the page saves once the render with this number has paused.
fn saved_bits(program: &LiveProgram, render: u64) -> Vec<u32> {
    program.wait_for(|state| state["render"] == render && state["phase"] == "ended");
    let mut answer = Vec::new();
    program.request("GET", "save/picture.exr").read_to_end(&mut answer).unwrap();
    let body = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap() + 4;
    let path = program.folder.path().join("saved.exr");
    fs::write(&path, &answer[body..]).unwrap();
    let image = image::read(&path).unwrap();
    image.pixels().iter().flat_map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
}

/// Returns the text of an OBJ file: a hilly square of `side` × `side` cells of two triangles.
///
/// It extends from −1 to 1 in x and z, and from 0 to 2 · `height` in y.
fn hills(side: u32, height: f64) -> String {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(side) - 1.0;
    let corners = (0..=side).flat_map(|z| (0..=side).map(move |x| (at(x), at(z))));
    let mut text: String = corners
        .map(|(x, z)| format!("v {x} {} {z}\n", height * (libm::sin(9.0 * x) * libm::cos(7.0 * z) + 1.0)))
        .collect();
    for (x, z) in (0..side).flat_map(|z| (0..side).map(move |x| (x, z))) {
        let [a, b] = [0, 1].map(|row| (z + row) * (side + 1) + x + 1);
        text += &format!("f {a} {b} {}\nf {} {b} {}\n", a + 1, a + 1, b + 1);
    }
    text
}

/// Returns [`SCENE`] with `hills.obj` on its floor.
fn scene_with_hills() -> String {
    SCENE.replace("    Sphere { center .45", "    TriangleMesh { file hills.obj }\n    Sphere { center .45")
}

impl Drop for LiveProgram {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn listening_renders_write_the_same_files() {
    let words = "render scene.txt -o a.exr --passes 5 --photons 2k --seed 3 --listen";
    let mut program = LiveProgram::start(words);
    let last = program.wait_for(|state| state["phase"] == "ended");
    assert_eq!((&last["passes"], &last["ended"], &last["pass_limit"]), (&5.into(), &"passes".into(), &5.into()));
    assert!(last["plan"]["effects"].as_array().unwrap().len() > 5 && last["curve"].as_array().unwrap().len() == 2);
    assert_eq!(program.child.wait().unwrap().code(), Some(0));
    let with_page = fs::read(program.folder.path().join("a.exr")).unwrap();
    let mut plain = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
    let words = words.replace("a.exr", "b.exr").replace(" --listen", "");
    plain.current_dir(program.folder.path()).args(words.split_whitespace()).assert().success();
    assert!(fs::read(program.folder.path().join("b.exr")).unwrap() == with_page);
}

#[test]
fn stop_ends_a_render_like_an_interrupt() {
    let mut program = LiveProgram::start("render scene.txt -o a.exr --time 120s --photons 2k --listen 127.0.0.1:0");
    program.wait_for(|state| state["passes"].as_u64() > Some(0));
    program.post("stop");
    let mut said = String::new();
    program.messages.read_to_string(&mut said).unwrap();
    assert_eq!(program.child.wait().unwrap().code(), Some(130), "{said}");
    assert!(said.contains("wrote a.exr"), "{said}");
}

#[test]
fn wrong_addresses_and_references_are_refused() {
    let fails = |words: &str, code: i32, part: &str| {
        let mut program = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        let scene = project_path("scenes/ring.txt");
        let words: Vec<&str> = words.split_whitespace().collect();
        let output = program.arg(words[0]).arg(scene).args(&words[1..]).timeout(PATIENCE).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && said.contains(part), "{said}");
    };
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    fails(&format!("view --listen {address}"), 2, "cannot serve the live page");
    fails("view --listen example.org:80", 2, "write ADDR:PORT");
    fails("view --reference missing.exr", 1, "cannot read the reference");
    fails("render -o a.png --reference a.exr", 2, "--listen");
}

#[test]
fn the_first_pixels_are_a_preview() {
    // The first pass takes seconds with so many photons.
    let program = LiveProgram::start("view scene.txt --photons 4M --caustic-photons 4M --size 1920x1440");
    let first = program.wait_for(|state| !state["picture"].is_null());
    assert_eq!((&first["picture"]["preview"], &first["passes"]), (&true.into(), &0.into()));
    assert_eq!((&first["picture"]["width"], &first["size"][0]), (&163.into(), &1920.into()));
    assert!(first["first_pixels_seconds"].as_f64() < Some(20.0), "{}", first["first_pixels_seconds"]);
}

#[test]
fn views_follow_edits_of_the_scene() {
    let program = LiveProgram::start("view scene.txt --photons 2k --passes 3");
    let ended = program.wait_for(|state| state["phase"] == "ended");
    assert_eq!((&ended["passes"], &ended["render"], &ended["problems"]), (&3.into(), &1.into(), &0.into()));
    // An error in the scene keeps the picture. The page names the place of the error.
    program.write("scene.txt", &SCENE.replace("Sphere { center .45", "Spere { center .45"));
    let failed = program.wait_for(|state| state["phase"] == "failed");
    assert_eq!((&failed["problems"], failed["picture"].is_null()), (&1.into(), false));
    let mut source = String::new();
    let mut answer = program.request("GET", "source");
    while !source.contains("did you mean `Sphere`?") {
        assert!(answer.read_line(&mut source).unwrap() > 0, "{source}");
    }
    // The scene gets another camera and a smaller picture.
    program.write("scene.txt", &SCENE.replace("width 96  height 72", "width 40  height 30"));
    let mended = program.wait_for(|state| state["phase"] == "ended" && state["problems"] == 0);
    assert_eq!((&mended["size"], &mended["passes"]), (&serde_json::json!([40, 30]), &3.into()));
    // A paused render computes surface layers, such as depth, when the page asks for them.
    let mut status = String::new();
    program.request("GET", "layer/depth").read_line(&mut status).unwrap();
    assert!(status.contains(" 204 "), "{status}");
    let with_layers = program.wait_for(|state| !state["surfaces"].is_null());
    assert_eq!((&with_layers["surfaces"]["width"], &with_layers["passes"]), (&40.into(), &3.into()));
    // The render pauses at its limit. A request ends the pause.
    program.post("resume");
    program.wait_for(|state| state["passes"].as_u64() > Some(5));
}

#[test]
fn edited_views_equal_a_fresh_load() {
    let (words, scene) = ("view scene.txt --photons 2k --passes 2", scene_with_hills());
    let edited = scene.replace("reflectance .75 .75 .75", "reflectance .2 .3 .75");
    let (low, high) = (hills(20, 0.1), hills(20, 0.2));
    let fresh = |scene: &str, mesh: &str| {
        saved_bits(&LiveProgram::start_with_files(words, &[("scene.txt", scene), ("hills.obj", mesh)]), 1)
    };
    let program = LiveProgram::start_with_files(words, &[("scene.txt", &scene), ("hills.obj", &low)]);
    let first = saved_bits(&program, 1);
    // The edit of the material shares the mesh and its hierarchy.
    program.write("scene.txt", &edited);
    let recolored = saved_bits(&program, 2);
    assert!(recolored != first && recolored == fresh(&edited, &low));
    // The edit of the mesh is seen, although the scene file stays.
    program.write("hills.obj", &high);
    let raised = saved_bits(&program, 3);
    assert!(raised != recolored && raised == fresh(&edited, &high));
}

/// Measures the time from an edit of a material to the first pixels, relative to the first load of
/// the scene. The scene has a mesh of 500,000 triangles.
#[test]
#[ignore = "long: eight loads of a large mesh"]
fn material_edits_restart_faster_than_loads() {
    let (scene, mesh) = (scene_with_hills(), hills(500, 0.1));
    let edited = scene.replace("reflectance .75 .75 .75", "reflectance .2 .3 .75");
    let mut ratios: Vec<f64> = (0..4)
        .map(|_| {
            let files = [("scene.txt", scene.as_str()), ("hills.obj", mesh.as_str())];
            let program = LiveProgram::start_with_files("view scene.txt --photons 2k --passes 1", &files);
            let first_pixels = |render: u64| {
                let state = program.wait_for(|state| state["render"] == render && state["phase"] == "ended");
                state["first_pixels_seconds"].as_f64().unwrap()
            };
            let load = first_pixels(1);
            program.write("scene.txt", &edited);
            let edit = first_pixels(2);
            eprintln!("first pixels {load:.3} s after the start, {edit:.3} s after the edit");
            edit / load
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = 0.5 * (ratios[1] + ratios[2]);
    let line = format!("an edit takes {median:.3} of a load (from {:.3} to {:.3})", ratios[0], ratios[3]);
    eprintln!("{line}");
    assert!(median < 0.5, "{line}");
}

/// Processor time of a process and of its threads \[s]; `None` where the system does not tell.
fn processor_seconds(process: &Child) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{}/stat", process.id())).ok()?;
    // Of the fields after the name, the 12th is user time and the 13th system time, in ticks of
    // 10 ms.
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

/// Returns the correlation coefficient of two series of equal length.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (a_mean, b_mean) = (mean(a), mean(b));
    let product = |x: &[f64], x_mean: f64, y: &[f64], y_mean: f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - x_mean) * (y - y_mean)).sum()
    };
    product(a, a_mean, b, b_mean) / (product(a, a_mean, a, a_mean) * product(b, b_mean, b, b_mean)).sqrt()
}

/// Measures the time from the start of the program until a running browser shows a recognisable
/// picture.
///
/// Other load on the machine lengthens wall times. So the test bounds the processor time of the
/// program, and the ratio of the times to its first pixels and to its first pass.
#[test]
#[ignore = "long: half a minute in a browser"]
fn the_first_picture_precedes_the_first_pass() {
    let Some(mut browser) = DevTools::start() else {
        eprintln!("SKIPPED: no chromium, chromium-browser or google-chrome in PATH, and CAUSTICA_CHROMIUM is not set");
        return;
    };
    // Luma of the canvas on a coarse grid; empty until a picture covers it.
    let thumbnail = "(() => { const shown = document.getElementById('canvas'); \
                     if (!viewerHasPicture() || !shown.width) return []; \
                     const small = document.createElement('canvas'); [small.width, small.height] = [24, 18]; \
                     const context = small.getContext('2d'); context.drawImage(shown, 0, 0, 24, 18); \
                     const bytes = context.getImageData(0, 0, 24, 18).data; \
                     return Array.from({length: 24 * 18}, (_, i) => bytes[4 * i] + bytes[4 * i + 1] + bytes[4 * i + 2]); \
                     function viewerHasPicture() { return !document.getElementById('overlay').hidden || document.body.dataset.passes > 0; } })()";
    let numbers =
        |value: Value| -> Vec<f64> { value.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect() };
    let scene = project_path("scenes/goblet.txt");
    let start = Instant::now();
    let shown = LiveProgram::start(&format!("view {} --time 600s", scene.display()));
    browser.open(&shown.address, 1280, 800);
    let mut early = Vec::new();
    while early.is_empty() {
        assert!(start.elapsed() < Duration::from_secs(120), "the page shows no picture");
        early = numbers(browser.value(thumbnail));
    }
    let (seconds, work) = (start.elapsed().as_secs_f64(), processor_seconds(&shown.child));
    assert_eq!(browser.value("document.body.dataset.passes"), "0", "the picture is a preview");
    let state = shown.wait_for(|state| state["passes"].as_u64() > Some(0));
    let first_pixels = state["first_pixels_seconds"].as_f64().unwrap();
    let first_pass = state["seconds"].as_f64().unwrap() / state["passes"].as_f64().unwrap();
    browser.wait_for("Number(document.body.dataset.passes) >= 1 && document.getElementById('overlay').hidden");
    let likeness = correlation(&early, &numbers(browser.value(thumbnail)));
    let line = format!(
        "picture after {seconds:.2} s of wall time and {:.2} s of processor time; the program had its pixels \
         after {first_pixels:.2} s, {:.2} of a pass of {first_pass:.2} s; likeness {likeness:.3}",
        work.unwrap_or(0.0),
        first_pixels / first_pass
    );
    eprintln!("{line}");
    // Two cores have six seconds of processor time in three seconds.
    assert!(work.is_none_or(|work| work < 6.0), "{line}");
    assert!(3.0 * first_pixels < first_pass, "{line}");
    assert!(likeness > 0.8, "{line}");
}

/// Measures the processor time of a render with the page open in a browser, relative to the same
/// render without a page. Renders with and without the page alternate.
#[test]
#[ignore = "long: a minute in a browser"]
fn an_open_page_costs_at_most_three_percent() {
    let Some(mut browser) = DevTools::start() else {
        eprintln!("SKIPPED: no chromium, chromium-browser or google-chrome in PATH, and CAUSTICA_CHROMIUM is not set");
        return;
    };
    let scene = project_path("scenes/matte.txt");
    let words = format!("{} -o a.png --size 200x150 --passes 8 --photons 20k --spp 4 --update 0", scene.display());
    let cpu_seconds = |folder: &std::path::Path| -> f64 {
        let stats: Value = serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
        stats["cpu_seconds"].as_f64().unwrap()
    };
    let plain = || {
        let folder = tempfile::tempdir().unwrap();
        let mut program = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        program.current_dir(folder.path()).arg("render").args(words.split_whitespace());
        program.args(["--stats", "a.json", "--quiet"]).timeout(Duration::from_secs(200)).assert().success();
        cpu_seconds(folder.path())
    };
    let mut with_page = || {
        let mut shown = LiveProgram::start(&format!("render {words} --stats a.json --quiet --listen"));
        browser.open(&shown.address, 1280, 800);
        browser.wait_for("Number(document.body.dataset.passes) >= 1");
        assert_eq!(shown.child.wait().unwrap().code(), Some(0));
        cpu_seconds(shown.folder.path())
    };
    // The order alternates, so that a drift of the machine's speed cancels out.
    let mut ratios: Vec<f64> = (0..8)
        .map(|pair| {
            let first = if pair % 2 == 0 { plain() } else { 0.0 };
            let page = with_page();
            page / if pair % 2 == 0 { first } else { plain() }
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = 0.5 * (ratios[3] + ratios[4]);
    let line = format!("processor time with the page: {median:.3} (from {:.3} to {:.3})", ratios[0], ratios[7]);
    eprintln!("{line}");
    assert!(median < 1.03, "{line}");
}

#[test]
#[ignore = "long: a minute in a browser"]
fn the_page_works_in_a_browser() {
    let Some(mut browser) = DevTools::start() else {
        eprintln!("SKIPPED: no chromium, chromium-browser or google-chrome in PATH, and CAUSTICA_CHROMIUM is not set");
        return;
    };
    let references = tempfile::tempdir().unwrap();
    let reference = references.path().join("grey.exr");
    let grey = Image::from_pixels(96, 72, vec![Vec3::splat(0.2); 96 * 72]).unwrap();
    image::write(&reference, &grey, &WriteOptions::default()).unwrap();
    let words = format!("view scene.txt --photons 5k --time 3600s --light-groups --reference {}", reference.display());
    let program = LiveProgram::start(&words);
    let text = |id: &str| format!("document.getElementById('{id}').textContent");
    let click = |id: &str| format!("document.getElementById('{id}').click()");
    let passes = "Number(document.body.dataset.passes)";
    // Expression for the sum of the bytes of the canvas, which changes with the picture.
    let painted = "(() => { const c = document.getElementById('canvas'); return c.width && \
                   c.getContext('2d').getImageData(0, 0, c.width, c.height).data.reduce((a, b) => a + b, 0); })()";
    // Expression for a fact about what the canvas shows: `layer`, `sequence` or `zoom`.
    let shown = |key: &str| format!("document.getElementById('canvas').dataset.{key}");
    let select_layer = |layer: &str| {
        format!(
            "(() => {{ const l = document.getElementById('layer'); l.value = '{layer}'; \
             l.dispatchEvent(new Event('change')); }})()"
        )
    };

    // The page loads, refines its picture, and shows error, plan and photons.
    browser.open(&program.address, 1280, 800);
    browser.wait_for(&format!("{passes} >= 5"));
    browser.wait_for("document.querySelector('#curve svg path.error')");
    browser.wait_for(&format!("{}.includes('the true error is probably between')", text("error-text")));
    browser.wait_for("document.querySelectorAll('#plan tr').length > 10");
    browser.wait_for("document.querySelectorAll('#photons tr').length > 5");
    browser.wait_for(&format!("{}.includes('RectangleLight')", text("source")));
    browser.wait_for(&format!("{painted} > 1e6"));

    // While the render is stopped, only the tested controls can change the picture.
    browser.press(" ");
    browser.wait_for(&format!("{}.startsWith('stopped')", text("status")));
    browser.wait_for(&format!("{} === 'Resume'", text("stop")));
    browser.wait_for(&format!("{} === document.body.dataset.sequence", shown("sequence")));
    let still = browser.value(painted);

    // Both axes of the curve have labels, and none covers another.
    let labels = "[...document.querySelectorAll('#curve svg text')].map((text) => text.getBoundingClientRect())";
    let apart = "a === b || a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top";
    let readable = format!("((all) => all.length > 1 && all.every((a) => all.every((b) => {apart})))({labels})");
    assert_eq!(browser.value(&readable), true);

    browser.press("]");
    browser.wait_for(&format!("{} === '+0.5' && {painted} > {still}", text("exposure-value")));
    browser.press("[");
    browser.wait_for(&format!("{painted} === {still}"));
    browser.press("t");
    browser.wait_for(&format!("document.getElementById('tone').value === 'filmic' && {painted} !== {still}"));
    browser.press("t");
    browser.press("t");
    browser.wait_for(&format!("{painted} === {still}"));

    // Tone mapping in the page gives the bytes of the program's own PNG.
    browser.press("1");
    let block = "(async () => { const bitmap = await createImageBitmap(await (await fetch('save/picture.png')).blob()); \
                 const saved = document.createElement('canvas'); \
                 [saved.width, saved.height] = [bitmap.width, bitmap.height]; \
                 saved.getContext('2d').drawImage(bitmap, 0, 0); const shown = document.getElementById('canvas'); \
                 const left = Math.round(shown.width / 2 - bitmap.width / 2); \
                 const top = Math.round(shown.height / 2 - bitmap.height / 2); \
                 const a = saved.getContext('2d').getImageData(0, 0, bitmap.width, bitmap.height).data; \
                 const b = shown.getContext('2d').getImageData(left, top, bitmap.width, bitmap.height).data; \
                 return Math.max(...a.map((byte, i) => Math.abs(byte - b[i]))); })()";
    browser.wait_for(&format!("{} === '1'", shown("zoom")));
    let difference = browser.value(block);
    assert!(difference.as_f64() <= Some(1.0), "{difference} levels");
    browser.press("+");
    browser.wait_for(&format!("{painted} !== {still}"));
    browser.press("0");
    browser.wait_for(&format!("{painted} === {still}"));

    // Tests values under the pointer, and the comparison with a file.
    browser.drag(&[(400.0, 400.0)]);
    browser.wait_for(&format!("/^\\(\\d+, \\d+\\)  [\\d.e-]+  .* reference: 0.2  0.2  0.2$/.test({})", text("values")));
    browser.press("f");
    browser.wait_for(&format!("{} === 'showing: reference' && {painted} !== {still}", text("overlay")));
    browser.press("f");
    browser.wait_for(&format!("{painted} === {still}"));

    // Tests layers, and the comparison with a pinned picture.
    browser.press("p");
    browser.press("l");
    browser.wait_for(&format!(
        "{} === 'noise' && !document.getElementById('legend').hidden && {painted} !== {still}",
        shown("layer")
    ));
    browser.value(&select_layer("picture"));
    browser.wait_for(&format!("{painted} === {still}"));
    // Layers of surfaces are made while the render is stopped.
    let maps = ["bias", "radius.caustic", "photons.caustic"];
    let surfaces = ["albedo", "normal", "depth", "position", "object", "material", "motion"];
    for layer in maps.into_iter().chain(surfaces).chain(["caustic", "picture"]) {
        let before = browser.value(painted);
        browser.value(&select_layer(layer));
        browser.wait_for(&format!("{} === '{layer}' && {painted} !== {before}", shown("layer")));
    }
    browser.wait_for(&format!("{painted} === {still}"));
    browser.press("]");
    browser.press("f");
    browser.wait_for(&format!("{} === 'showing: pinned'", text("overlay")));
    browser.press("d");
    browser.wait_for(&format!("{} === 'now | pinned'", text("overlay")));
    browser.press("d");
    browser.press("[");

    // Resumes the render, edits the scene with an error, and corrects it.
    let before = browser.value(passes);
    browser.value(&click("stop"));
    browser.wait_for(&format!("{passes} > {before}"));
    program.write("scene.txt", &SCENE.replace("MaterialName glass", "MaterialName gloss"));
    browser.wait_for(&format!(
        "!document.getElementById('problems').hidden && {}.includes('line 13')",
        text("problem-list")
    ));
    browser.wait_for("document.querySelector('#source .wrong')");
    program.write("scene.txt", &SCENE.replace("reflectance .75 .75 .75", "reflectance .2 .3 .75"));
    browser.wait_for(&format!("document.getElementById('problems').hidden && {passes} >= 1"));
    browser.wait_for(&format!("{}.includes('.2 .3 .75')", text("source")));

    // A movement of the camera restarts the render.
    let render = browser.value("Number(document.body.dataset.render)");
    browser.press("o");
    browser.drag(&[(400.0, 400.0), (450.0, 410.0), (520.0, 420.0)]);
    browser.wait_for(&format!("Number(document.body.dataset.render) > {render} && {passes} >= 1"));
    program.wait_for(|state| state["orbit"]["yaw"].as_f64().unwrap() < -0.5);
    browser.press("r");
    program.wait_for(|state| state["orbit"]["yaw"] == 0.0 && state["passes"].as_u64() > Some(0));

    // The page follows the color scheme of the system.
    let lightness = "getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0] / 255";
    browser.wait_for(&format!("{lightness} > 0.9"));
    browser.prefer_dark_colors();
    browser.wait_for(&format!("{lightness} < 0.2"));

    // Nothing overflows in a narrow window, and the console has no complaints.
    browser.resize(500, 900);
    browser.wait_for("document.documentElement.scrollWidth <= 500");
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}
