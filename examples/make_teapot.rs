//! Makes scenes/teapot.txt, a teapot of 48 Bézier patches and a glass of tea: `cargo run --release
//! --example make_teapot`.
//!
//! The file is equal byte for byte on every machine.

use glam::{DVec2, DVec3};
use std::fmt::Write;
use std::path::Path;

/// Distance of a cubic's inner control points from its ends, for a quarter of the unit circle.
const KAPPA: f64 = 0.552_284_75;

/// Control points of a quarter circle.
const QUARTER: [[f64; 2]; 4] = [[1.0, 0.0], [1.0, KAPPA], [KAPPA, 1.0], [0.0, 1.0]];

type Patches = Vec<[DVec3; 16]>;

/// Adds four patches around an axis. `place` maps a station and a point of the unit circle to a
/// position.
fn around(patches: &mut Patches, place: impl Fn(usize, DVec2) -> DVec3) {
    for turn in 0..4 {
        patches.push(std::array::from_fn(|k| {
            let (station, [x, y]) = (k / 4, QUARTER[k % 4]);
            let (x, y) = [(x, y), (-y, x), (-x, -y), (y, -x)][turn];
            place(station, DVec2::new(x, y))
        }));
    }
}

/// Adds a surface of revolution about the y axis; the profile's cubics share their ends.
fn turned(patches: &mut Patches, profile: &[[f64; 2]]) {
    for cubic in profile.windows(4).step_by(3) {
        around(patches, |i, circle| DVec3::new(cubic[i][0] * circle.x, cubic[i][1], -cubic[i][0] * circle.y));
    }
}

/// Adds a tube around a path of cubics in the xy plane: position, radius, and direction \[degrees]
/// at each control point.
fn tube(patches: &mut Patches, path: &[[f64; 4]]) {
    for cubic in path.windows(4).step_by(3) {
        around(patches, |i, circle| {
            let [x, y, radius, direction] = cubic[i];
            let (sin, cos) = libm::sincos(direction.to_radians());
            DVec3::new(x - sin * radius * circle.x, y + cos * radius * circle.x, radius * circle.y)
        });
    }
}

fn teapot() -> Patches {
    let mut patches = Vec::new();
    let body = [
        [0.0, 0.06],
        [0.4, 0.06],
        [0.75, 0.0],
        [0.95, 0.0],
        [1.02, 0.0],
        [0.98, 0.08],
        [1.1, 0.16],
        [1.55, 0.4],
        [1.7, 1.0],
        [1.35, 1.4],
        [1.12, 1.67],
        [0.8, 1.7],
        [0.74, 1.78],
        [0.72, 1.81],
        [0.74, 1.86],
        [0.78, 1.86],
    ];
    turned(&mut patches, &body);
    let lid = [
        [0.77, 1.85],
        [0.72, 1.93],
        [0.5, 2.04],
        [0.2, 2.08],
        [0.08, 2.1],
        [0.08, 2.15],
        [0.12, 2.2],
        [0.28, 2.4],
        [0.16, 2.5],
        [0.0, 2.5],
    ];
    turned(&mut patches, &lid);
    let spout = [
        [1.15, 0.55, 0.42, 0.0],
        [1.7, 0.55, 0.34, 30.0],
        [1.85, 0.95, 0.22, 60.0],
        [2.05, 1.3, 0.17, 58.0],
        [2.16, 1.49, 0.15, 52.0],
        [2.26, 1.66, 0.13, 40.0],
        [2.46, 1.78, 0.15, 32.0],
    ];
    tube(&mut patches, &spout);
    let handle = [
        [-1.2, 1.38, 0.11, 130.0],
        [-1.55, 1.8, 0.11, 165.0],
        [-2.25, 1.85, 0.11, 235.0],
        [-2.3, 1.2, 0.12, 270.0],
        [-2.34, 0.75, 0.12, 300.0],
        [-1.9, 0.5, 0.11, 345.0],
        [-1.35, 0.42, 0.1, 350.0],
    ];
    tube(&mut patches, &handle);
    patches
}

const ABOVE: &str = "\
# A copper teapot of Bézier patches and a glass of tea, turned from B-splines.
#
# Shows: curved surfaces that are intersected without triangles. The file is written by
# examples/make_teapot.rs.
PerspectiveCamera { center 1.2 4.2 9.6  lookAt .55 .85 0  angle 31  width 960  height 720 }

Background { color .02 .025 .03 }

Lights {
    EnvironmentLight { radiance .09 .1 .12 }
    RectangleLight { corner -5 6.5 -1  edge0 1.2 1.2 0  edge1 0 0 2.6  radiance 22 20 17 }
    SphereLight { center 5.5 5 -4.5  radius .22  power 700 620 520 }
}

Materials {
    Diffuse table { reflectance .55 .47 .38 }
    Conductor copper { metal copper roughness .04 }
    Dielectric tea { indexOfRefraction 1.33  tint .85 .42 .1  tintDistance .5 }
    Dielectric glass { indexOfRefraction 1.5  priority 1 }
}

Group {
    MaterialName table
    Rectangle { corner -14 0 12  edge0 28 0 0  edge1 0 0 -26 }
    MaterialName glass
    Transform {
        Translate 2.35 .002 1.9
        Group {
            RevSurface {
                profile BsplineCurve {
                    controls
                        [ 0 0 0 ] [ 0 0 0 ] [ 0 0 0 ]
                        [ .45 0 0 ] [ .56 .03 0 ] [ .64 .4 0 ] [ .72 1 0 ]
                        [ .74 1.12 0 ] [ .68 1.12 0 ]
                        [ .66 1 0 ] [ .58 .42 0 ] [ .48 .14 0 ] [ .3 .1 0 ]
                        [ 0 .1 0 ] [ 0 .1 0 ] [ 0 .1 0 ]
                }
            }
            MaterialName tea
            RevSurface {
                profile BsplineCurve {
                    controls
                        [ 0 .07 0 ] [ 0 .07 0 ] [ 0 .07 0 ]
                        [ .32 .07 0 ] [ .5 .1 0 ] [ .61 .42 0 ]
                        [ .66 .85 0 ] [ .66 .85 0 ] [ .66 .85 0 ]
                        [ .3 .85 0 ]
                        [ 0 .85 0 ] [ 0 .85 0 ] [ 0 .85 0 ]
                }
            }
        }
    }
    MaterialName copper
    Transform {
        Translate 0 .001 0
        YRotate 25
        BezierPatch {
            controls
";

fn main() -> std::io::Result<()> {
    let mut text = ABOVE.to_owned();
    for (i, patch) in teapot().iter().enumerate() {
        let gap = if i == 0 { "" } else { "\n" };
        text += gap;
        for row in patch.chunks(4) {
            let round = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
            let points = row.iter().fold(String::new(), |mut line, p| {
                let _ = write!(line, " [ {} {} {} ]", round(p.x), round(p.y), round(p.z));
                line
            });
            text += &format!("               {points}\n");
        }
    }
    text += "        }\n    }\n}\n";
    std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/teapot.txt"), text)
}
