//! Mesh generators, one file each.

mod gem;
mod goblet;
mod knot;
mod lens;
mod mesh;
mod pool;
mod profile;
mod ring;
mod vase;
mod wine;

pub use mesh::Mesh;

/// A function that makes a mesh.
pub type Generator = fn() -> Mesh;

/// Every mesh: the name of its file in mesh/ and its generator.
pub const ALL: [(&str, Generator); 9] = [
    ("brilliant.obj", gem::brilliant),
    ("gem.obj", gem::gem),
    ("goblet.obj", goblet::goblet),
    ("knot.obj", knot::knot),
    ("lens.obj", lens::lens),
    ("pool.obj", pool::pool),
    ("ring.obj", ring::ring),
    ("vase.obj", vase::vase),
    ("wine.obj", wine::wine),
];
