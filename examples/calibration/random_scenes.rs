//! Random scenes: furnished rooms and tables under the sky. No parameter of the program was chosen
//! by them.

use caustica::format::{SourceText, parse, resolve};
use caustica::scene::Scene;
use glam::DVec3;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Names of materials of objects, with the probability weight of each.
const MATERIALS: [(&str, f64); 7] =
    [("clay", 3.0), ("gloss", 1.5), ("mirror", 1.0), ("glass", 3.0), ("frosted", 1.0), ("metal", 1.5), ("pane", 0.3)];

struct SceneGenerator {
    random: SmallRng,
    text: String,
}

/// Returns the scene of a seed, as text of the scene language.
pub fn text(seed: u64) -> String {
    let mut generator = SceneGenerator { random: SmallRng::seed_from_u64(seed), text: String::new() };
    generator.write_scene();
    generator.text
}

/// Returns the scene of a seed, with a picture of the given size \[pixels].
pub fn scene(seed: u64, (width, height): (u32, u32)) -> Result<Scene, Box<dyn Error>> {
    let (name, text) = (format!("random {seed}"), text(seed));
    let source = SourceText::new(&name, &text);
    let mut description = parse(&name, &text)?;
    (description.camera.value.width, description.camera.value.height) = (width, height);
    Ok(resolve(&description, &source, Path::new(env!("CARGO_MANIFEST_DIR")))?)
}

impl SceneGenerator {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let x: f64 = self.random.random();
        ((low + (high - low) * x) * 1000.0).round() / 1000.0
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.random.random::<f64>() < probability
    }

    fn color(&mut self, low: f64, high: f64) -> String {
        vector(DVec3::new(self.between(low, high), self.between(low, high), self.between(low, high)))
    }

    fn line(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    /// Writes a scene of extent 4 × 3 × 4 around (0, 1.5, 0): in a closed room or under the sky.
    fn write_scene(&mut self) {
        let room = self.chance(0.6);
        let (angle, height) = (self.between(-0.6, 0.6), self.between(0.8, 2.6));
        let distance = if room { 1.85 } else { self.between(3.0, 5.0) };
        let eye = DVec3::new(distance * libm::sin(angle), height, distance * libm::cos(angle));
        let at = DVec3::new(self.between(-0.4, 0.4), self.between(0.3, 1.0), self.between(-0.5, 0.3));
        let field = if room { self.between(60.0, 80.0) } else { self.between(30.0, 50.0) };
        self.line(&format!(
            "PerspectiveCamera {{ center {}  lookAt {}  up 0 1 0  angle {field}  width 64  height 48 }}",
            vector(eye),
            vector(at)
        ));
        let fog = room && self.chance(0.2);
        self.line(&format!("Background {{ color 0 0 0{} }}", if fog { "  medium fog" } else { "" }));
        self.write_lights(room);
        if fog {
            let density = self.between(0.03, 0.3);
            self.line(&format!("Media {{ Medium fog {{ scattering {0} {0} {0} }} }}", density));
        }
        self.write_materials();
        self.line("Group {");
        self.write_walls(room);
        let objects = 2 + (self.between(0.0, 4.0) as usize);
        (0..objects).for_each(|_| self.write_object());
        self.line("}");
    }

    fn write_lights(&mut self, room: bool) {
        self.line("Lights {");
        let lights = 1 + self.between(0.0, 2.5) as usize;
        for _ in 0..lights {
            let [x, z] = [self.between(-1.5, 1.2), self.between(-1.5, 1.2)];
            let strength = self.between(5.0, 30.0);
            let power = |scale: f64| vector(DVec3::new(1.0, 0.95, 0.85) * (strength * scale));
            let edge = self.between(0.05, 0.8);
            let line = match self.between(0.0, 4.0) as u32 {
                0 => format!("PointLight {{ position {x} 2.7 {z}  intensity {} }}", power(0.3)),
                1 => format!(
                    "SpotLight {{ position {x} 2.8 {z}  lookAt {} .3 {}  angle {}  penumbra .3  intensity {} }}",
                    0.3 * x,
                    0.3 * z,
                    self.between(10.0, 40.0),
                    power(1.0)
                ),
                2 => format!("SphereLight {{ center {x} 2.6 {z}  radius .08  radiance {} }}", power(12.0)),
                _ => format!(
                    "RectangleLight {{ corner {x} 2.95 {z}  edge0 {edge} 0 0  edge1 0 0 {edge}  radiance {} }}",
                    power(0.25 / (edge * edge))
                ),
            };
            self.line(&line);
        }
        if !room {
            let (sky, sun) = (self.color(0.2, 0.8), self.chance(0.5));
            self.line(&format!("EnvironmentLight {{ radiance {sky} }}"));
            if sun {
                self.line("DirectionalLight { direction .5 -.8 -.3  irradiance 4 3.8 3.2 }");
            }
        }
        self.line("}");
    }

    fn write_materials(&mut self) {
        self.line("Materials {");
        for wall in ["floor", "side", "back"] {
            let color = self.color(0.3, 0.85);
            self.line(&format!("Diffuse {wall} {{ reflectance {color} }}"));
        }
        let [clay, diffuse] = [self.color(0.1, 0.8), self.color(0.1, 0.6)];
        let (index, absorption) = (self.between(1.3, 2.0), self.between(0.0, 0.6));
        let (shininess, frosted, brushed) =
            (self.between(5.0, 200.0), self.between(0.05, 0.5), self.between(0.05, 0.5));
        self.line(&format!("Diffuse clay {{ reflectance {clay} }}"));
        self.line(&format!("Phong gloss {{ diffuseColor {diffuse}  specularColor .3 .3 .3  shininess {shininess} }}"));
        self.line("Mirror mirror { reflectance .9 .9 .9 }");
        self.line(&format!("Dielectric glass {{ indexOfRefraction {index}  absorption {absorption} 0 0 }}"));
        self.line(&format!("Dielectric frosted {{ indexOfRefraction 1.5  roughness {frosted} }}"));
        self.line(&format!("Conductor metal {{ metal gold  roughness {brushed} }}"));
        self.line("Thin pane { indexOfRefraction 1.5  transmittance .9 .9 .9 }");
        self.line("}");
    }

    fn write_walls(&mut self, room: bool) {
        self.line("MaterialName floor");
        if !room {
            self.line("Rectangle { corner -8 0 8  edge0 16 0 0  edge1 0 0 -16 }");
            return;
        }
        self.line("Rectangle { corner -2 0 2  edge0 4 0 0  edge1 0 0 -4 }");
        self.line("Rectangle { corner -2 3 -2  edge0 4 0 0  edge1 0 0 4 }");
        self.line("MaterialName side");
        self.line("Rectangle { corner -2 0 2  edge0 0 0 -4  edge1 0 3 0 }");
        self.line("Rectangle { corner 2 0 -2  edge0 0 0 4  edge1 0 3 0 }");
        self.line("MaterialName back");
        self.line("Rectangle { corner -2 0 -2  edge0 4 0 0  edge1 0 3 0 }");
        self.line("Rectangle { corner 2 0 2  edge0 -4 0 0  edge1 0 3 0 }");
    }

    fn write_object(&mut self) {
        let mut left = self.between(0.0, MATERIALS.iter().map(|(_, weight)| weight).sum());
        let mut material = MATERIALS[0].0;
        for (name, weight) in MATERIALS {
            material = name;
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
        let [x, z, size] = [self.between(-1.3, 1.3), self.between(-1.4, 0.6), self.between(0.2, 0.55)];
        let y = if self.chance(0.7) { size } else { size + self.between(0.0, 1.0) };
        let turn = self.between(0.0, 90.0);
        let shape = match self.between(0.0, 5.0) as u32 {
            0 => format!(
                "Box {{ min {} {} {}  max {} {} {} }}",
                x - size,
                y - size,
                z - size,
                x + size,
                y + size,
                z + size
            ),
            1 => format!("Cylinder {{ bottom {x} {} {z}  top {x} {} {z}  radius {size} }}", y - size, y + size),
            2 => format!(
                "Transform {{ Translate {x} {y} {z}  YRotate {turn}  UniformScale {size}  \
                 TriangleMesh {{ obj_file mesh/gem.obj }} }}"
            ),
            3 => format!(
                "Transform {{ Translate {x} {y} {z}  YRotate {turn}  Scale {size} {size} {}  \
                 Sphere {{ center 0 0 0  radius 1 }} }}",
                0.5 * size
            ),
            _ => format!("Sphere {{ center {x} {y} {z}  radius {size} }}"),
        };
        self.line(&format!("MaterialName {material}"));
        self.line(&shape);
    }
}

/// Returns three numbers as text of the scene language.
fn vector(v: DVec3) -> String {
    let mut text = String::new();
    let _ = write!(text, "{:.4} {:.4} {:.4}", v.x, v.y, v.z);
    text
}
