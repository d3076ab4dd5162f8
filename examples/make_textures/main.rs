//! Makes the images of scenes/textures.txt: `cargo run --release --example make_textures` writes
//! them into scenes/textures/.
//!
//! The files are equal byte for byte on every machine. `cargo test --example make_textures` checks
//! that the folder holds them.

mod pictures;
#[cfg(test)]
mod tests;

use caustica::image::{self, ToneCurve, ToneMap, WriteOptions};
use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/textures");
    fs::create_dir_all(&folder)?;
    for (name, curve, make) in pictures::ALL {
        let tone = ToneMap { curve, ..ToneMap::default() };
        image::write(&folder.join(name), &make(), &WriteOptions { tone, ..WriteOptions::default() })?;
        let kind = if curve == ToneCurve::Srgb { "light" } else { "numbers" };
        println!("{name:14} {kind:8} {:4} kB", fs::metadata(folder.join(name))?.len() / 1000);
    }
    Ok(())
}
