//! The plan of the house holds: rooms use only rooms below them, files stay short, and nothing is left for later.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms by storey; a room uses only rooms of lower storeys.
const STOREYS: [&[&str]; 10] = [
    &["math", "sampling", "color", "image", "stats"],
    &["accel", "texture", "bsdf"],
    &["shape", "medium"],
    &["light", "camera"],
    &["scene"],
    &["plan", "photon"],
    &["integrate"],
    &["render", "format"],
    &["study"],
    &["cli"],
];

fn storey(room: &str) -> Option<usize> {
    STOREYS.iter().position(|rooms| rooms.contains(&room))
}

/// Every source file with its text, by its path below `src/` with slashes.
fn sources() -> Vec<(String, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    walk(&root, &mut found);
    found.sort();
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    found.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect()
}

/// The text without comments. A `//` in a string cuts the line too, which hides no path that matters.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// The rooms that code names: x of `crate::x` and of `crate::{x, …}`.
fn uses(code: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let path = &code[at + "crate::".len()..];
        let Some(list) = path.strip_prefix('{') else {
            rooms.push(word(path));
            continue;
        };
        let mut depth = 0;
        let mut entry = true;
        for (i, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => entry = true,
                c if entry && !c.is_whitespace() => {
                    rooms.push(word(&list[i..]));
                    entry = false;
                }
                _ => {}
            }
        }
    }
    rooms
}

/// What is wrong with a room that uses another, if anything.
fn objection(from: &str, to: &str) -> Option<String> {
    match (storey(from), storey(to)) {
        (Some(_), Some(_)) if from == to => None,
        (Some(a), Some(b)) if b < a => None,
        (Some(a), Some(b)) => Some(format!("{from} ({a}) uses {to} ({b})")),
        (None, _) => Some(format!("{from} is no room of the plan")),
        (_, None) => Some(format!("{from} uses {to}, which is no room of the plan")),
    }
}

#[test]
fn rooms_use_only_rooms_below_them() {
    let mut seen = 0;
    let mut wrong = Vec::new();
    for (name, text) in sources() {
        let Some((room, _)) = name.split_once('/') else { continue };
        wrong.extend(objection(room, room).map(|o| format!("src/{name}: {o}")));
        for used in uses(&code(&text)) {
            seen += 1;
            wrong.extend(objection(room, &used).map(|o| format!("src/{name}: {o}")));
        }
    }
    // The reader of `use` lines would pass everything if it found nothing.
    assert!(seen > 100, "{seen} uses");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn uses_are_read_in_every_form() {
    let text = "use crate::math::Ray;\nuse crate::{cli, scene::{Scene, Hit}, image};\nlet x = crate::color::mean(y); // crate::study";
    assert_eq!(uses(&code(text)), ["math", "cli", "scene", "image", "color"]);
    assert!(objection("photon", "scene").is_none() && objection("photon", "photon").is_none());
    for (from, to) in [("scene", "photon"), ("photon", "plan"), ("math", "color"), ("attic", "attic"), ("cli", "attic")]
    {
        assert!(objection(from, to).is_some(), "{from} {to}");
    }
}

#[test]
fn files_are_short() {
    for (name, text) in sources() {
        let most = if name == "main.rs" { 59 } else { 449 };
        let lines = text.lines().count();
        assert!(lines <= most, "src/{name} has {lines} lines: split it");
    }
}

#[test]
fn nothing_is_left_for_later() {
    for (name, text) in sources() {
        for (i, line) in text.lines().enumerate() {
            for word in ["todo!", "unimplemented!", "TODO", "FIXME"] {
                assert!(!line.contains(word), "src/{name}:{}: {word}", i + 1);
            }
        }
    }
}
