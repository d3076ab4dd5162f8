//! Replays the kept fuzz inputs through the functions of the fuzz targets.

use super::{project_path, readers};
use std::fs;

/// Function of a fuzz target, which reads bytes and panics if it finds an error.
type Replay = fn(&[u8]);

/// Folders of `tests/corpus`, each with the function of its fuzz target.
const KINDS: [(&str, Replay); 10] = [
    ("scene", readers::scene),
    ("render", readers::render),
    ("obj", readers::obj),
    ("ply", readers::ply),
    ("mtl", readers::mtl),
    ("gltf", readers::gltf),
    ("mitsuba", readers::mitsuba),
    ("pbrt", readers::pbrt),
    ("grid", readers::grid),
    ("picture", readers::picture),
];

#[test]
fn fuzz_corpus_gives_results_or_typed_errors() {
    for (kind, replay) in KINDS {
        let folder = project_path("tests/corpus").join(kind);
        let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        assert!(paths.len() >= 10, "{kind} holds {} files", paths.len());
        // Inputs are replayed one at a time, so that the last printed path is that of a panic.
        paths.iter().for_each(|path| {
            println!("{}", path.display());
            replay(&fs::read(path).unwrap());
        });
    }
}
