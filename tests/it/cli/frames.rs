//! Frames of a turntable: `--frames` and `--turn`.

use super::{CliSandbox, read};

/// Scene with fourfold symmetry about the vertical axis, seen from the side.
const CROSS: &str = "\
PerspectiveCamera { center 0 1 6  lookAt 0 1 0  angle 40  width 24  height 18 }
Background { color .1 .1 .1 }
Lights { PointLight { position 0 6 0  intensity 60 60 60 } }
Materials { Diffuse white { reflectance .7 .7 .7 } }
Group {
    MaterialName white
    Plane { normal 0 1 0  offset 0 }
    Box { min -1.5 0 -.3  max 1.5 1 .3 }
    Box { min -.3 0 -1.5  max .3 1 1.5 }
}
";

#[test]
fn the_first_frame_is_the_plain_render() {
    let sandbox = CliSandbox::new();
    let files = "-o turn-%04d.exr --aov layers-%d.exr --stats %d.json --passes 1 --photons 1k --seed 5";
    let run = sandbox.render("box.txt", &format!("{files} --frames 0..2 --turn 3"));
    run.expect(0, &["frame 0 of 0 to 1", "frame 1 of 0 to 1", "wrote turn-0001.exr"]);
    sandbox.render("box.txt", "-o plain.exr --seed 5").expect(0, &[]);
    assert_eq!(sandbox.bytes("turn-0000.exr"), sandbox.bytes("plain.exr"));
    let names = ["0.json", "1.json", "box.txt", "layers-0.exr", "layers-1.exr", "plain.exr"];
    assert_eq!(sandbox.names(), [&names[..], &["turn-0000.exr", "turn-0001.exr"]].concat());
    // A frame that is rendered alone has the same bits as in a sequence.
    sandbox.render("box.txt", "-o again-%d.exr --seed 5 --frames 1..2 --turn 3").expect(0, &[]);
    assert_eq!(sandbox.bytes("again-1.exr"), sandbox.bytes("turn-0001.exr"));
}

#[test]
fn turns_show_the_scene_from_all_sides() {
    let sandbox = CliSandbox::new();
    sandbox.put("cross.txt", CROSS);
    sandbox.render("cross.txt", "-o %d.exr --frames 0..8 --integrator path --spp 64").expect(0, &[]);
    let picture = |frame: u32| read(&sandbox.path(&format!("{frame}.exr")));
    let difference = |a: u32, b: u32| {
        let (a, b) = (picture(a), picture(b));
        let pixels = a.pixels().iter().zip(b.pixels());
        pixels.map(|(a, b)| (a.x - b.x).abs()).sum::<f32>() / a.pixels().iter().map(|pixel| pixel.x).sum::<f32>()
    };
    // Quarter turns show the same view with other noise. Eighths of a turn show the cross
    // obliquely.
    assert!(difference(0, 2) < 0.02 && difference(0, 6) < 0.02, "{} {}", difference(0, 2), difference(0, 6));
    assert!(difference(0, 2) > 0.0, "frames have noise of their own");
    assert!(difference(0, 1) > 0.05 && difference(1, 3) < 0.02, "{} {}", difference(0, 1), difference(1, 3));
}

#[test]
fn frames_never_overwrite_inputs_or_each_other() {
    let sandbox = CliSandbox::new();
    let refused = |flags: &str, part: &str| {
        sandbox.render("box.txt", flags).expect(2, &[part]);
    };
    refused("-o a.png --frames 0..4", "has no single place for the number of a frame");
    refused("-o %d.png --stats a.json --frames 0..4", "--stats `a.json`");
    refused("-o %d-%d.png --frames 0..4", "write %04d");
    refused("-o %d.png -o 0%d.png -o %02d.png --frames 3..5", "are the same file");
    refused("-o %d.png --frames 4..4", "has no frames");
    refused("-o %d.png --frames 0..99999", "exceeds frame 10000");
    refused("-o %d.png --turn 4", "--frames");
    refused("-o %d.png --frames 0..4 --film a.film", "cannot be used with");
    refused("-o %d.png --frames 0..4 --film a.film --passes 4 --shard 1/2", "cannot be used with");
    #[cfg(feature = "view")]
    for flag in ["--listen", "--tev"] {
        refused(&format!("-o %d.png --frames 0..4 {flag}"), "cannot be used with");
    }
    sandbox.put("box7.txt", sandbox.bytes("box.txt"));
    sandbox
        .render("box7.txt", "-o %d.png --stats box%d.txt --frames 0..9")
        .expect(2, &["`box7.txt` are the same file"]);
    sandbox
        .put("moving.txt", super::BOX.replace("PerspectiveCamera {", "Moving { Translate 1 0 0  PerspectiveCamera {"));
    let moving = String::from_utf8(sandbox.bytes("moving.txt")).unwrap().replace("height 30 }", "height 30 } }");
    sandbox.put("moving.txt", moving);
    sandbox.render("moving.txt", "-o %d.png --frames 0..2").expect(2, &["moves while the shutter is open"]);
    assert_eq!(sandbox.names(), ["box.txt", "box7.txt", "moving.txt"], "nothing was written");
}
