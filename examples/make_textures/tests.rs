//! Checks that `scenes/textures` holds what the generators write.

use super::pictures;
use caustica::image::{self, ToneMap, WriteOptions};
use std::path::Path;

#[test]
fn stored_textures_match_their_generators() {
    let (folder, kept) = (tempfile::tempdir().unwrap(), Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/textures"));
    for (name, curve, make) in pictures::ALL {
        let path = folder.path().join(name);
        let tone = ToneMap { curve, ..ToneMap::default() };
        image::write(&path, &make(), &WriteOptions { tone, ..WriteOptions::default() }).unwrap();
        let [made, kept] = [&path, &kept.join(name)].map(|p| std::fs::read(p).unwrap());
        assert!(made == kept, "{name}: run `cargo run --release --example make_textures`");
    }
}
