//! Replays the kept fuzz inputs through the functions of the fuzz targets.

use super::{project_path, readers};
use caustica::format::IMPORTERS;
use std::fs;

/// Function of a fuzz target, which reads bytes and panics if it finds an error.
type Replay = fn(&[u8]);

/// Folders of `tests/corpus`, each with the function of its fuzz target.
const KINDS: [(&str, Replay); 11] = [
    ("scene", readers::scene),
    ("render", readers::render),
    ("obj", readers::obj),
    ("ply", readers::ply),
    ("mtl", readers::mtl),
    ("gltf", readers::gltf),
    ("mitsuba", readers::mitsuba),
    ("pbrt", readers::pbrt),
    ("tungsten", readers::tungsten),
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

/// Each importer of [`IMPORTERS`] has a corpus, and each corpus has a fuzz target. A corpus is
/// found by the first word of the importer's name.
#[test]
fn every_importer_has_a_corpus_and_fuzz_target() {
    for importer in IMPORTERS {
        let name = importer.name().split(' ').next().unwrap().to_lowercase();
        assert!(KINDS.iter().any(|(kind, _)| *kind == name), "add a corpus `{name}` for {}", importer.name());
    }
    let manifest = fs::read_to_string(project_path("fuzz/Cargo.toml")).unwrap();
    for (kind, _) in KINDS {
        let is_target = manifest.contains(&format!("name = \"{kind}\"\npath = \"fuzz_targets/{kind}.rs\""));
        assert!(is_target && project_path("fuzz/fuzz_targets").join(format!("{kind}.rs")).is_file(), "{kind}");
    }
}
