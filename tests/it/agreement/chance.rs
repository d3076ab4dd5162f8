//! Mix materials, for which each hit selects a receiver or a caster at random. All integrators
//! agree on their light.
//!
//! Photon paths and camera paths choose independently, and each light path must count once.

use super::compare::{Grid, Renders, compare_renders};
use super::methods::{ALL, Effort, Method};
use crate::support::scene_from_text;

const SIZE: (u32, u32) = (12, 12);
const EFFORT: Effort = Effort { passes: 12, samples: 4, photons: 20_000, caustic: 20_000, radius: 0.1 };

/// Compares every integrator with path tracing, with a floor of the material `m` that the scene
/// text `material` defines.
///
/// A lamp that faces up lights a diffuse ceiling. A polished metal wall casts a caustic on the
/// floor. The floor reflects light to ceiling and wall.
fn check_methods_agree_on_floor(name: &str, material: &str) {
    let scene = scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 1.4 0  direction 0 -1 0  up 0 0 1  angle 60  width 12  height 12 }}
        Background {{ color 0 0 0 }}
        Lights {{ RectangleLight {{ corner .9 .5 -.4  edge0 0 0 1  edge1 .6 0 0  radiance 6 5 4 }} }}
        Materials {{ Diffuse white {{ reflectance .8 .8 .8 }} Conductor wall {{ metal silver  roughness .2 }} {material} }}
        Group {{ MaterialName m Rectangle {{ corner -2 0 -2  edge0 0 0 4  edge1 4 0 0 }}
            MaterialName white Rectangle {{ corner -2 1.5 -2  edge0 0 0 4  edge1 4 0 0 }}
            MaterialName wall Rectangle {{ corner -1 0 -2  edge0 0 1.5 0  edge1 0 0 4 }} }}"
    ));
    let grid = Grid::new(SIZE, 6);
    let path = Renders::new(Method::Path, &scene, Effort { samples: 256, ..EFFORT });
    for method in ALL.into_iter().filter(|method| *method != Method::Path) {
        compare_renders(name, &Renders::new(method, &scene, EFFORT), &path, &grid, (0.1, 0.06));
    }
}

#[test]
#[ignore = "long: many samples by several integrators"]
fn integrators_agree_on_mix_of_receiver_and_caster() {
    let mix =
        "Diffuse a { reflectance .9 .7 .5 } Mirror b { reflectance .9 .8 .7 } Mix m { first a second b amount .4 }";
    check_methods_agree_on_floor("mix", mix);
}

#[test]
#[ignore = "long: many samples by several integrators"]
fn integrators_agree_on_smooth_plastic() {
    check_methods_agree_on_floor("smooth plastic", "CoatedDiffuse m { reflectance .9 .5 .2  indexOfRefraction 1.8 }");
}

#[test]
#[ignore = "long: t-tests of two materials with every integrator"]
fn integrators_agree_on_rough_plastic() {
    for (name, roughness) in [("polished plastic", 0.15), ("matt plastic", 0.4)] {
        let plastic =
            format!("CoatedDiffuse m {{ reflectance .9 .5 .2  indexOfRefraction 1.8  roughness {roughness} }}");
        check_methods_agree_on_floor(name, &plastic);
    }
}

#[test]
#[ignore = "long: t-tests of clear coats over two materials with every integrator"]
fn integrators_agree_on_principled_with_clear_coat() {
    for (name, fields) in [
        ("coated plastic and metal", "metallic .5  roughness .2  clearcoat 1  clearcoatRoughness .1"),
        ("smooth lacquer on rough metal", "metallic 1  roughness .5  clearcoat .8"),
    ] {
        check_methods_agree_on_floor(name, &format!("Principled m {{ baseColor .9 .5 .2  {fields} }}"));
    }
}
