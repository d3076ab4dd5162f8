//! A polygon mesh and its OBJ text.

use std::collections::HashMap;
use std::fmt::Write;

use glam::DVec3;

/// A corner of a face: a position and, on smooth surfaces, a normal.
#[derive(Clone, Copy)]
pub struct Corner {
    position: usize,
    normal: Option<usize>,
}

/// A mesh of convex polygons, counterclockwise seen from outside.
///
/// Adjacent faces share positions, so that the surface is closed by its indices. Normals have their
/// own indices, so that an edge may be sharp.
pub struct Mesh {
    title: &'static str,
    position_digits: usize,
    normal_digits: usize,
    positions: Vec<DVec3>,
    normals: Vec<String>,
    known_normals: HashMap<String, usize>,
    faces: Vec<Vec<Corner>>,
}

impl Mesh {
    /// Returns an empty mesh. The digits are those after the decimal point in the file.
    pub fn new(title: &'static str, position_digits: usize, normal_digits: usize) -> Self {
        Self {
            title,
            position_digits,
            normal_digits,
            positions: Vec::new(),
            normals: Vec::new(),
            known_normals: HashMap::new(),
            faces: Vec::new(),
        }
    }

    /// Adds a position and returns its index.
    pub fn position(&mut self, p: DVec3) -> usize {
        self.positions.push(p);
        self.positions.len() - 1
    }

    /// Returns the index of a normal of any length, adding it unless the file already has an equal
    /// one.
    pub fn normal(&mut self, n: DVec3) -> usize {
        let line = line("vn", n.normalize(), self.normal_digits);
        let next = self.normals.len();
        *self.known_normals.entry(line).or_insert_with_key(|line| {
            self.normals.push(line.clone());
            next
        })
    }

    /// Adds a face with a normal at each corner, given as (position, normal).
    pub fn smooth_face(&mut self, corners: &[(usize, usize)]) {
        self.faces.push(corners.iter().map(|&(position, n)| Corner { position, normal: Some(n) }).collect());
    }

    /// Adds a face without normals.
    pub fn flat_face(&mut self, positions: &[usize]) {
        self.faces.push(positions.iter().map(|&position| Corner { position, normal: None }).collect());
    }

    /// Returns the number of triangles after each polygon is split into a fan.
    pub fn triangle_count(&self) -> usize {
        self.faces.iter().map(|face| face.len() - 2).sum()
    }

    /// Returns the text of the OBJ file.
    pub fn to_obj(&self) -> String {
        let mut text = format!("# {}. Made by examples/make_meshes.\n", self.title);
        for &p in &self.positions {
            text += &line("v", p, self.position_digits);
        }
        for normal in &self.normals {
            text += normal;
        }
        for face in &self.faces {
            text.push('f');
            for corner in face {
                // Writing to a string cannot fail.
                let _ = match corner.normal {
                    Some(normal) => write!(text, " {}//{}", corner.position + 1, normal + 1),
                    None => write!(text, " {}", corner.position + 1),
                };
            }
            text.push('\n');
        }
        text
    }
}

fn line(keyword: &str, v: DVec3, digits: usize) -> String {
    let [x, y, z] = v.to_array().map(|value| number(value, digits));
    format!("{keyword} {x} {y} {z}\n")
}

/// Returns a decimal without trailing zeros or a negative zero.
fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
