//! Makes the meshes of the caustics scenes: `cargo run --release --example make_meshes` writes them
//! into mesh/.
//!
//! The files are equal byte for byte on every machine. `cargo test --example make_meshes` checks
//! that mesh/ holds them and that they are valid.

mod meshes;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::{fs, io};

fn main() -> io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("mesh");
    fs::create_dir_all(&folder)?;
    for (name, make) in meshes::ALL {
        let mesh = make();
        let text = mesh.to_obj();
        fs::write(folder.join(name), &text)?;
        println!("{name:12} {:6} triangles {:5} kB", mesh.triangle_count(), text.len() / 1000);
    }
    Ok(())
}
