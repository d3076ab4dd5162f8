//! Pairs of pictures for two eyes: `--stereo`.

use super::{BOX, CliSandbox, read};

/// Text of the box whose camera is displaced along the rows of the picture by `x`.
fn displaced_box(x: f64) -> String {
    BOX.replace("center 0 1 3.9  lookAt 0 1 0", &format!("center {x} 1 3.9  lookAt {x} 1 0"))
}

#[test]
fn eyes_equal_displaced_cameras() {
    let sandbox = CliSandbox::new();
    sandbox.put("left.txt", displaced_box(-0.125));
    sandbox.put("right.txt", displaced_box(0.125));
    let flags = "--integrator path --spp 16";
    let run = sandbox.render("box.txt", &format!("-o a.b.exr --stats a.json --stereo 0.25 --seed 5 {flags}"));
    run.expect(0, &["picture of the left eye", "picture of the right eye", "wrote a.b-right.exr"]);
    sandbox.render("left.txt", &format!("-o l.exr --seed 5 {flags}")).expect(0, &[]);
    sandbox.render("right.txt", &format!("-o r.exr --seed 6 {flags}")).expect(0, &[]);
    let names = ["a-left.json", "a-right.json", "a.b-left.exr", "a.b-right.exr", "box.txt"];
    assert_eq!(sandbox.names(), [&names[..], &["l.exr", "left.txt", "r.exr", "right.txt"]].concat());
    let difference = |a: &str, b: &str| {
        let (a, b) = (read(&sandbox.path(a)), read(&sandbox.path(b)));
        let pixels = a.pixels().iter().zip(b.pixels());
        pixels.map(|(a, b)| (a.x - b.x).abs()).sum::<f32>() / a.pixels().iter().map(|pixel| pixel.x).sum::<f32>()
    };
    // The rays are equal except for rounding of their origins, so few paths differ.
    let (left, right) = (difference("l.exr", "a.b-left.exr"), difference("r.exr", "a.b-right.exr"));
    assert!(left < 0.01 && right < 0.01, "{left} {right}");
    let eyes = difference("a.b-left.exr", "a.b-right.exr");
    assert!(eyes > 0.05, "{eyes}");
}

#[test]
fn impossible_stereo_pairs_are_refused() {
    let sandbox = CliSandbox::new();
    let refused = |scene: &str, flags: &str, part: &str| {
        sandbox.render(scene, flags).expect(2, &[part]);
    };
    refused("box.txt", "-o a.png --stereo 0", "is not a length");
    refused("box.txt", "-o %d.png --stereo 1 --frames 0..2", "cannot be used with");
    refused("box.txt", "-o a.png --stereo 1 --film a.film", "cannot be used with");
    #[cfg(feature = "view")]
    for flag in ["--listen", "--tev"] {
        refused("box.txt", &format!("-o a.png --stereo 1 {flag}"), "cannot be used with");
    }
    sandbox.put("flat.txt", BOX.replace("PerspectiveCamera", "OrthographicCamera").replace("angle 40", "size 2"));
    refused("flat.txt", "-o a.png --stereo 1", "needs a perspective camera");
    let moving = BOX.replace("PerspectiveCamera {", "Moving { Translate 1 0 0  PerspectiveCamera {");
    sandbox.put("moving.txt", moving.replace("height 30 }", "height 30 } }"));
    refused("moving.txt", "-o a.png --stereo 1", "moves while the shutter is open");
    sandbox.put("a-left.png", BOX);
    refused("a-left.png", "-o a.png --stereo 1", "are the same file");
    assert_eq!(sandbox.names(), ["a-left.png", "box.txt", "flat.txt", "moving.txt"], "nothing was written");
}
