//! Output files and messages.

use super::{CliSandbox, read};
use glam::Vec3;

#[test]
fn one_render_writes_all_its_outputs() {
    let sandbox = CliSandbox::new();
    sandbox
        .render("box.txt", "-o a.png -o b.EXR --output c.exr")
        .expect(0, &["wrote a.png", "wrote b.EXR", "wrote c.exr"]);
    assert_eq!(sandbox.names(), ["a.png", "b.EXR", "box.txt", "c.exr"], "and leaves no litter");
    assert!(sandbox.bytes("a.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    assert!(sandbox.bytes("b.EXR").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    assert_eq!(sandbox.bytes("b.EXR"), sandbox.bytes("c.exr"));
    let (png, exr) = (read(&sandbox.path("a.png")), read(&sandbox.path("c.exr")));
    assert_eq!((png.width(), png.height(), exr.width(), exr.height()), (40, 30, 40, 30));
    // Both files hold the same image. The rounding error of 8 bits is 1/510 of the signal. The
    // slope of the signal against radiance is at least 1/2.4.
    for (a, b) in png.pixels().iter().zip(exr.pixels()) {
        let b = b.clamp(Vec3::ZERO, Vec3::ONE);
        assert!((*a - b).abs().max_element() < 2.4 / 510.0 + 1e-5, "{a} {b}");
    }
    assert!(exr.pixels().iter().any(|p| p.max_element() > 1.0), "EXR is not clamped");
}

#[test]
fn size_flags_accept_suffixes() {
    let sandbox = CliSandbox::new();
    sandbox
        .render(
            "box.txt",
            "-o a.exr --integrator sppm --size 17x9 --photons 2.5k --caustic-photons 0.001M --stats a.json",
        )
        .expect(0, &[]);
    let picture = read(&sandbox.path("a.exr"));
    assert_eq!((picture.width(), picture.height()), (17, 9));
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    assert_eq!((&stats["width"], &stats["height"]), (&17.into(), &9.into()));
    assert_eq!(stats["photons"]["global"]["emitted"], 2500);
    assert_eq!(stats["photons"]["caustic"]["emitted"], 1000);
}

#[test]
fn tone_exposure_and_bits_affect_only_png() {
    let sandbox = CliSandbox::new();
    let make = |name: &str, more: &str| {
        sandbox.render("box.txt", &format!("-o {name}.png -o {name}.exr {more}")).expect(0, &[]);
        sandbox.bytes(&format!("{name}.png"))
    };
    let plain = make("plain", "");
    assert_eq!(plain, make("srgb", "--tone srgb --exposure 0 --png-bits 8"));
    for (name, more) in [
        ("filmic", "--tone filmic"),
        ("course", "--tone course"),
        ("bright", "--exposure +1"),
        ("dark", "--exposure -1.5"),
        ("deep", "--png-bits 16"),
    ] {
        assert!(plain != make(name, more), "{name}");
        assert_eq!(sandbox.bytes(&format!("{name}.exr")), sandbox.bytes("plain.exr"), "{name}");
    }
    // The data of the header chunk begins at byte 16, and its ninth byte is the bit depth.
    assert_eq!((plain[24], sandbox.bytes("deep.png")[24]), (8, 16));
    let mean = |name: &str| read(&sandbox.path(name)).pixels().iter().map(|p| p.element_sum()).sum::<f32>();
    assert!(mean("dark.png") < mean("plain.png") && mean("plain.png") < mean("bright.png"));
}

#[test]
fn quiet_prints_nothing_and_messages_use_stderr() {
    let sandbox = CliSandbox::new();
    for quiet in ["-q", "--quiet"] {
        let ended = sandbox.render("box.txt", &format!("-o a.png --stats a.json {quiet}"));
        ended.expect(0, &[]);
        assert_eq!((ended.stdout.as_str(), ended.stderr.as_str()), ("", ""));
    }
    let ended = sandbox.render("box.txt", "-o a.png --passes 2");
    ended.expect(0, &["box.txt: 0 triangles, 9 shapes, 1 light", "pass 1/2", "pass 2/2", "wrote a.png", "2 passes in"]);
    assert_eq!(ended.stdout, "");
    sandbox.render("box.txt", "-o a.png --quiet --kernel sphere").expect(2, &["sphere"]);
}

#[test]
fn raycast_defaults_to_course_sampling_and_tone() {
    let sandbox = CliSandbox::new();
    let made = sandbox.run(&["render", "box.txt", "-o", "a.png", "--integrator", "raycast", "--stats", "a.json"]);
    made.expect(0, &["1 pass in"]);
    sandbox.run(&["render", "box.txt", "-o", "b.png", "--integrator", "raycast", "--tone", "course"]).expect(0, &[]);
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("b.png"));
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    assert_eq!((&stats["integrator"], &stats["radii"]), (&"raycast".into(), &serde_json::Value::Null));
    assert_eq!(stats["counters"]["camera_rays"], 40 * 30);
    assert_eq!((&stats["counters"]["photon_rays"], &stats["counters"]["shadow_rays"]), (&0.into(), &0.into()));
}

/// A reader that closes the message pipe does not stop the render.
#[cfg(unix)]
#[test]
fn closed_pipe_loses_no_image() {
    let sandbox = CliSandbox::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_caustica"))
        .current_dir(sandbox.path("."))
        .args("render box.txt -o a.png --photons 1k --passes 4".split(' '))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(sandbox.path("a.png").exists());
}
