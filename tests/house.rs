//! Checks of the source tree's structure and language, read from its text.
//!
//! Each check lists every offence with its file and line. A check that the tree does not yet pass
//! states how many offences it allows. Lower that number whenever you remove one; never raise it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms (top-level modules, the folders of `src/`) by storey (dependency layer), lowest first.
///
/// A room uses only rooms of lower storeys.
const STOREYS: [&[&str]; 11] = [
    &["math", "stats"],
    &["sampling", "color", "image"],
    &["accel", "texture", "bsdf"],
    &["shape", "medium"],
    &["light", "camera"],
    &["scene"],
    &["plan", "photon"],
    &["integrate"],
    &["render", "format"],
    &["study", "view"],
    &["cli"],
];

/// Names of the former private vocabulary. None may be a whole identifier in `src/`.
const RETIRED: [&str; 26] = [
    "Arrival",
    "Asking",
    "Coat",
    "Dimming",
    "Draft",
    "Dress",
    "Fade",
    "Gathering",
    "Gauge",
    "Glow",
    "Immersed",
    "Lesson",
    "Look",
    "MapMaker",
    "Meeting",
    "Octet",
    "Reading",
    "Relief",
    "Shine",
    "Specks",
    "Stretch",
    "Walk",
    "Walks",
    "Wants",
    "Wardrobe",
    "Wishes",
];

/// Words that may not begin a doc comment: the sentence would lack its subject.
const HEADLESS: [&str; 5] = ["The same", "As ", "Of ", "What ", "Whether"];

/// Most characters of a comment line, indentation included.
const COMMENT_WIDTH: usize = 100;

/// Most lines of a test module inside a source file.
const INLINE_TESTS: usize = 45;

// Number of offences against each rule that are still allowed in `src/`.
const CIRCLES_LEFT: usize = 0;
const SCATTERED_LEFT: usize = 0;
const LONG_TESTS_LEFT: usize = 0;
const RETIRED_LEFT: usize = 12;
const HEADLESS_LEFT: usize = 0;
const WIDE_LEFT: usize = 0;

/// One source file.
struct SourceFile {
    /// Path below `src/`, or below the folder of tests, with slashes.
    name: String,
    text: String,
}

impl SourceFile {
    /// Returns true if the file holds only tests.
    fn is_test(&self) -> bool {
        self.name.ends_with("/tests.rs") || self.name.contains("/tests/")
    }

    /// Returns the text with comments blanked out, line by line.
    ///
    /// A `//` inside a string also cuts the line. No check depends on what follows it.
    fn without_comments(&self) -> String {
        without_comments(&self.text)
    }

    /// Returns the module path below the crate, such as `["scene", "build", "lights"]`.
    fn module(&self) -> Vec<String> {
        let stem = self.name.trim_end_matches(".rs").trim_end_matches("/mod");
        stem.split('/').map(str::to_owned).collect()
    }
}

/// Returns every Rust file below `src/`, sorted by name.
fn sources() -> Vec<SourceFile> {
    rust_files_below("src")
}

/// Returns every Rust file of tests, examples and benches, sorted by name.
fn test_sources() -> Vec<SourceFile> {
    ["tests", "examples", "benches"].into_iter().flat_map(rust_files_below).collect()
}

/// Returns every Rust file below a folder of the repository, sorted by name.
fn rust_files_below(folder: &str) -> Vec<SourceFile> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found = Vec::new();
    collect(&root, &mut found);
    found.sort();
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    found.iter().map(|path| SourceFile { name: name(path), text: fs::read_to_string(path).unwrap() }).collect()
}

fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Splits the inside of a brace list at its top-level commas. `text` begins after the opening
/// brace.
fn split_brace_list(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                items.push(text[start..i].trim());
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(text[start..i].trim());
                start = i + 1;
            }
            _ => {}
        }
    }
    items.retain(|item| !item.is_empty());
    items
}

/// Expands a `use` tree, such as `a::{b, c::{d, self}}`, to full paths.
fn expand_use_tree(tree: &str) -> Vec<Vec<String>> {
    let tree = tree.trim();
    let Some(brace) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        return vec![path.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()];
    };
    let head: Vec<String> =
        tree[..brace].split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect();
    let tails = split_brace_list(&tree[brace + 1..]).into_iter().flat_map(expand_use_tree);
    tails.map(|tail| head.iter().cloned().chain(tail).filter(|part| part != "self").collect()).collect()
}

/// Returns the length in bytes of the path or `use` tree at the start of `text`.
fn use_tree_length(text: &str) -> usize {
    let mut depth = 0;
    for (i, c) in text.char_indices() {
        match c {
            '{' if depth > 0 || text[..i].ends_with("::") => depth += 1,
            '}' if depth > 0 => depth -= 1,
            c if depth == 0 && !c.is_alphanumeric() && c != '_' && c != ':' => return i,
            _ => {}
        }
    }
    text.len()
}

/// Returns the paths that begin with `prefix::` anywhere in the code, brace lists expanded.
fn paths_with_prefix(code: &str, prefix: &str) -> Vec<Vec<String>> {
    let mark = format!("{prefix}::");
    let mut found = Vec::new();
    for (at, _) in code.match_indices(&mark) {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$') {
            continue;
        }
        let rest = &code[at..];
        let end = use_tree_length(rest);
        found.extend(expand_use_tree(rest[..end].trim_end_matches(':')));
    }
    found
}

/// Returns the storey of a room, counted from 0 at the bottom.
fn storey_of_room(room: &str) -> Option<usize> {
    STOREYS.iter().position(|rooms| rooms.contains(&room))
}

/// Returns why room `from` may not use room `to`, or `None` if it may.
fn room_use_objection(from: &str, to: &str) -> Option<String> {
    match (storey_of_room(from), storey_of_room(to)) {
        (Some(_), Some(_)) if from == to => None,
        (Some(a), Some(b)) if b < a => None,
        (Some(a), Some(b)) => Some(format!("{from} (storey {a}) uses {to} (storey {b})")),
        (None, _) => Some(format!("{from} is not in the list of rooms")),
        (_, None) => Some(format!("{from} uses {to}, which is not in the list of rooms")),
    }
}

/// Fails with a list of the offences if there are more than `allowed`.
#[track_caller]
fn assert_at_most(allowed: usize, rule: &str, offences: &[String]) {
    let count = offences.len();
    eprintln!("{count} of {allowed} allowed offences: {rule}");
    assert!(count <= allowed, "{count} offences, {allowed} allowed: {rule}\n{}", offences.join("\n"));
}

#[test]
fn rooms_use_only_lower_rooms() {
    let mut uses = 0;
    let mut offences = Vec::new();
    for file in sources() {
        let Some((room, _)) = file.name.split_once('/') else { continue };
        offences.extend(room_use_objection(room, room).map(|o| format!("src/{}: {o}", file.name)));
        for path in paths_with_prefix(&file.without_comments(), "crate") {
            let Some(used) = path.get(1) else { continue };
            uses += 1;
            offences.extend(room_use_objection(room, used).map(|o| format!("src/{}: {o}", file.name)));
        }
    }
    // A parser that finds no `use` would pass every tree.
    assert!(uses > 100, "only {uses} uses found");
    assert_at_most(0, "a room uses only rooms of lower storeys", &offences);
}

/// Returns the source file of the module `path`.
///
/// If the module has no file, returns that of the nearest ancestor that has one.
fn module_file<'a>(modules: &'a BTreeMap<Vec<String>, String>, path: &[String]) -> Option<&'a String> {
    (1..=path.len()).rev().find_map(|n| modules.get(&path[..n]))
}

/// Returns the `use` edges between files of one room, as pairs of file names.
///
/// A module file and its own submodules belong together, so edges between ancestor and descendant
/// are left out.
fn use_edges(files: &[SourceFile]) -> BTreeMap<String, BTreeSet<String>> {
    let modules: BTreeMap<Vec<String>, String> = files.iter().map(|f| (f.module(), f.name.clone())).collect();
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.is_test()) {
        let module = file.module();
        let text = file.without_comments();
        // Inline tests may use anything.
        let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or("");
        let mut targets: Vec<Vec<String>> =
            paths_with_prefix(text, "crate").into_iter().map(|p| p[1..].to_vec()).collect();
        for path in paths_with_prefix(text, "super") {
            let ups = path.iter().take_while(|part| *part == "super").count();
            if ups <= module.len() {
                targets.push(module[..module.len() - ups].iter().chain(&path[ups..]).cloned().collect());
            }
        }
        for path in paths_with_prefix(text, "self") {
            targets.push(module.iter().chain(&path[1..]).cloned().collect());
        }
        for target in targets.iter().filter(|target| target.first() == module.first()) {
            let Some(other) = module_file(&modules, target) else { continue };
            let path: Vec<String> = modules.iter().find(|(_, name)| *name == other).unwrap().0.clone();
            if !path.starts_with(&module) && !module.starts_with(&path) {
                edges.entry(file.name.clone()).or_default().insert(other.clone());
            }
        }
    }
    edges
}

/// Returns the strongly connected components of more than one node, each sorted.
fn import_cycles(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reach = |from: &String| {
        let (mut seen, mut stack) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(node) = stack.pop() {
            for next in edges.get(&node).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    stack.push(next.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<String>> = edges.keys().map(|node| (node, reach(node))).collect();
    let mut found: BTreeSet<Vec<String>> = BTreeSet::new();
    for (node, there) in &reached {
        if there.contains(*node) {
            found.insert(there.iter().filter(|n| reached.get(n).is_some_and(|r| r.contains(*node))).cloned().collect());
        }
    }
    found.into_iter().collect()
}

#[test]
fn files_of_a_room_form_no_circle() {
    let edges = use_edges(&sources());
    assert!(edges.values().map(BTreeSet::len).sum::<usize>() > 100, "too few edges found");
    let offences: Vec<String> = import_cycles(&edges)
        .into_iter()
        .map(|circle| {
            let inside = |name: &String| edges[name].iter().filter(|n| circle.contains(n)).cloned().collect::<Vec<_>>();
            let lines: Vec<String> =
                circle.iter().map(|name| format!("    {name} uses {}", inside(name).join(", "))).collect();
            format!("circle of {} files:\n{}", circle.len(), lines.join("\n"))
        })
        .collect();
    assert_at_most(CIRCLES_LEFT, "files of a room do not use each other in a circle", &offences);
}

/// Returns the name of the type that an `impl` line is inherent to; `None` for trait
/// implementations and other lines.
fn inherent_impl_type(line: &str) -> Option<String> {
    let rest = line.strip_prefix("impl")?;
    let rest = match rest.strip_prefix('<') {
        Some(generics) => {
            let mut depth = 1;
            let end = generics.char_indices().find(|(i, c)| {
                let arrow = *c == '>' && generics[..*i].ends_with('-');
                depth += i32::from(*c == '<') - i32::from(*c == '>' && !arrow);
                depth == 0
            })?;
            &generics[end.0 + 1..]
        }
        None => rest,
    };
    let head = rest.strip_prefix(' ')?.split('{').next()?.split(" where ").next()?;
    if head.contains(" for ") {
        return None;
    }
    let path = head.split('<').next()?.trim();
    Some(path.rsplit("::").next()?.to_owned())
}

/// Returns the name of the type that a line defines; `None` for other lines.
fn defined_type(line: &str) -> Option<&str> {
    let line = line.strip_prefix("pub").map_or(line, |rest| rest.split_once(' ').map_or("", |(_, rest)| rest));
    let rest = ["struct ", "enum ", "union "].iter().find_map(|keyword| line.strip_prefix(keyword))?;
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

#[test]
fn types_have_impls_in_at_most_two_files() {
    let files: Vec<SourceFile> = sources().into_iter().filter(|file| !file.is_test()).collect();
    let room = |file: &SourceFile| file.name.split('/').next().unwrap().to_owned();
    // A private type may have the same name in several files of a room.
    let mut definitions: BTreeSet<(String, String)> = BTreeSet::new();
    for file in &files {
        definitions.extend(
            file.without_comments().lines().filter_map(defined_type).map(|name| (name.to_owned(), file.name.clone())),
        );
    }
    let mut homes: BTreeMap<(String, String, String), BTreeSet<String>> = BTreeMap::new();
    for file in &files {
        for name in file.without_comments().lines().filter_map(inherent_impl_type) {
            let own = definitions.contains(&(name.clone(), file.name.clone()));
            let elsewhere = definitions.iter().find(|(n, home)| *n == name && home.starts_with(&room(file)));
            let home = if own { file.name.clone() } else { elsewhere.map_or(String::new(), |(_, home)| home.clone()) };
            homes.entry((room(file), name, home)).or_default().insert(file.name.clone());
        }
    }
    assert!(homes.len() > 100, "only {} types found", homes.len());
    let offences: Vec<String> = homes
        .iter()
        .filter(|(_, files)| files.len() > 2)
        .map(|((_, name, _), files)| {
            format!("{name}: {} files: {}", files.len(), files.iter().cloned().collect::<Vec<_>>().join(", "))
        })
        .collect();
    assert_at_most(SCATTERED_LEFT, "the impl blocks of a type stand in at most two files", &offences);
}

#[test]
fn inline_test_modules_are_short() {
    let mut offences = Vec::new();
    for file in sources() {
        let Some((_, module)) = file.text.split_once("#[cfg(test)]\nmod tests {\n") else { continue };
        let lines = module.lines().take_while(|line| *line != "}").count();
        if lines > INLINE_TESTS {
            offences.push(format!("src/{}: {lines} lines", file.name));
        }
    }
    assert_at_most(LONG_TESTS_LEFT, "a longer test module stands in its own file", &offences);
}

#[test]
fn identifiers_avoid_retired_words() {
    let mut offences = Vec::new();
    for file in sources() {
        for (i, line) in file.without_comments().lines().enumerate() {
            for word in line.split(|c: char| !c.is_alphanumeric() && c != '_') {
                if RETIRED.contains(&word) {
                    offences.push(format!("src/{}:{}: {word}", file.name, i + 1));
                }
            }
        }
    }
    assert_at_most(RETIRED_LEFT, "identifiers avoid the retired words", &offences);
}

/// Returns the text of a doc comment line; `None` for other lines.
fn doc_comment_text(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
}

/// Returns the doc comments that begin with a word of [`HEADLESS`].
fn comments_without_subject(files: &[SourceFile]) -> Vec<String> {
    let mut offences = Vec::new();
    for file in files {
        let mut inside = false;
        for (i, line) in file.text.lines().enumerate() {
            let text = doc_comment_text(line);
            if let Some(text) = text.filter(|_| !inside)
                && HEADLESS.iter().any(|head| text.trim_start().starts_with(head))
            {
                offences.push(format!("{}:{}: {}", file.name, i + 1, line.trim()));
            }
            inside = text.is_some();
        }
    }
    offences
}

/// Returns the comment lines that are wider than [`COMMENT_WIDTH`].
fn too_wide_comments(files: &[SourceFile]) -> Vec<String> {
    let mut offences = Vec::new();
    for file in files {
        for (i, line) in file.text.lines().enumerate() {
            let width = line.chars().count();
            if line.trim_start().starts_with("//") && width > COMMENT_WIDTH {
                offences.push(format!("{}:{}: {width} characters", file.name, i + 1));
            }
        }
    }
    offences
}

#[test]
fn doc_comments_begin_with_their_subject() {
    assert_at_most(HEADLESS_LEFT, "a doc comment begins with its subject", &comments_without_subject(&sources()));
    assert_at_most(0, "a doc comment of a test begins with its subject", &comments_without_subject(&test_sources()));
}

#[test]
fn comment_lines_fit_in_100_columns() {
    assert_at_most(WIDE_LEFT, "comment lines have at most 100 characters", &too_wide_comments(&sources()));
    assert_at_most(0, "comment lines of tests have at most 100 characters", &too_wide_comments(&test_sources()));
}

#[test]
fn the_program_entry_is_short() {
    let main = sources().into_iter().find(|file| file.name == "main.rs").unwrap();
    let lines = main.text.lines().count();
    assert!(lines <= 59, "src/main.rs has {lines} lines: move logic to a room");
}

#[test]
fn source_has_no_todo() {
    let mut offences = Vec::new();
    for file in sources() {
        for (i, line) in file.text.lines().enumerate() {
            for word in ["todo!", "unimplemented!", "TODO", "FIXME"] {
                if line.contains(word) {
                    offences.push(format!("src/{}:{}: {word}", file.name, i + 1));
                }
            }
        }
    }
    assert_at_most(0, "nothing is left for later", &offences);
}

/// Files that may read the wall clock, for the ages of temporary files and the stamps of files.
///
/// The wall clock can go backwards, so all other files use the monotonic clock.
const WALL_CLOCK: [&str; 3] = ["image/replace.rs", "image/replace/tests.rs", "format/file_stamp.rs"];

#[test]
fn time_is_measured_by_the_monotonic_clock() {
    let mut offences = Vec::new();
    for file in sources().iter().filter(|file| !WALL_CLOCK.contains(&file.name.as_str())) {
        for (i, line) in file.without_comments().lines().enumerate() {
            if line.contains("SystemTime") || line.contains("UNIX_EPOCH") {
                offences.push(format!("src/{}:{}", file.name, i + 1));
            }
        }
    }
    assert_at_most(0, "only files of the list read the wall clock", &offences);
}

#[test]
fn use_paths_are_read_in_every_form() {
    let text = "use crate::math::Ray;\nuse crate::{cli, scene::{Scene, Hit as H}, image};\n\
                let x = crate::color::channel_mean(y); // crate::study\n macro { $crate::plan::Plan }";
    let rooms: Vec<String> =
        paths_with_prefix(&without_comments(text), "crate").into_iter().map(|path| path[1].clone()).collect();
    assert_eq!(rooms, ["math", "cli", "scene", "scene", "image", "color"]);
    let found = paths_with_prefix("use super::super::a::{self, b::C};\npub(super) fn f() {}", "super");
    assert_eq!(found, [vec!["super", "super", "a"], vec!["super", "super", "a", "b", "C"]]);
    assert!(room_use_objection("photon", "scene").is_none() && room_use_objection("photon", "photon").is_none());
    for (from, to) in [("scene", "photon"), ("photon", "plan"), ("math", "color"), ("attic", "attic"), ("cli", "attic")]
    {
        assert!(room_use_objection(from, to).is_some(), "{from} {to}");
    }
}

#[test]
fn inherent_impls_differ_from_trait_impls() {
    let named = |line: &str| inherent_impl_type(line);
    assert_eq!(named("impl Scene {").as_deref(), Some("Scene"));
    assert_eq!(named("impl<'a, F: Fn(u32) -> Option<u8>> Walk<'a, F> {").as_deref(), Some("Walk"));
    assert_eq!(named("impl super::Parser<'_> {").as_deref(), Some("Parser"));
    for other in ["impl Shape for Sphere {", "impl<T: Copy> From<T> for Rgb {", "    impl Inner {", "implicit"] {
        assert_eq!(named(other), None, "{other}");
    }
}

#[test]
fn circles_are_found() {
    let file = |name: &str, text: &str| SourceFile { name: name.to_owned(), text: text.to_owned() };
    let files = [
        file("a/mod.rs", "mod b; mod c; mod d; mod e;"),
        file("a/b.rs", "use super::c::C;"),
        file("a/c.rs", "use crate::a::d::D;"),
        file("a/d.rs", "use super::{e::E, b::B};"),
        file("a/e.rs", "use super::Top; // use super::d::D\n#[cfg(test)]\nmod tests { use super::super::d::D; }"),
    ];
    assert_eq!(import_cycles(&use_edges(&files)), [["a/b.rs", "a/c.rs", "a/d.rs"]]);
}
