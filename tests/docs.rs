//! Tests that the documentation is true: its commands run, its scenes render, its tables agree with
//! the program.

mod it {
    pub mod support {
        pub mod shell;
    }
}

use caustica::cli::{Arguments, Command, Exit, FarmEngine, MethodArguments};
use caustica::format::grid::{self, DensityGridData, GridEncoding};
use caustica::format::mesh::{self, MeshFormat};
use caustica::format::{SourceText, parse, resolve};
use caustica::image::{self, Image, WriteOptions};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use clap::{Args as _, CommandFactory, Parser};
use it::support::shell::shell_words;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::time::Duration;

fn repository_root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns README.md and all pages below docs/: path from the repository's root, and text.
fn documentation_pages() -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    let mut folders = vec![repository_root().join("docs")];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.push(repository_root().join("README.md"));
    let page = |path: &Path| {
        (path.strip_prefix(repository_root()).unwrap().to_owned(), std::fs::read_to_string(path).unwrap())
    };
    paths.iter().map(|path| page(path)).collect()
}

/// Returns the contents of the fenced blocks of `page` that are marked with `language`.
fn fenced_blocks(page: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut open: Option<(bool, String)> = None;
    for line in page.lines() {
        match (&mut open, line.trim_start().strip_prefix("```")) {
            (None, Some(info)) => open = Some((info.trim() == language, String::new())),
            (Some((wanted, text)), Some(_)) => {
                if *wanted {
                    blocks.push(std::mem::take(text));
                }
                open = None;
            }
            (Some((_, text)), None) => *text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

/// Returns a shell block's commands as words. Continued lines are joined; comments, prompts and
/// environment settings are removed.
fn shell_commands(block: &str) -> Vec<Vec<String>> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().map(|line| shell_words(line.trim().trim_start_matches("$ ")));
    let setting = |word: &String| {
        word.split_once('=').is_some_and(|(name, _)| name.chars().all(|c| c.is_ascii_uppercase() || c == '_'))
    };
    lines
        .map(|words| words.into_iter().skip_while(setting).collect::<Vec<_>>())
        .filter(|words| !words.is_empty())
        .collect()
}

/// Returns the arguments of `caustica` in a command, `None` for other programs.
fn caustica_arguments(words: &[String]) -> Option<Vec<String>> {
    match words[0].rsplit('/').next() {
        Some("caustica") => Some(words[1..].to_vec()),
        Some("cargo") if words.get(1).is_some_and(|w| w == "run") && !words.iter().any(|w| w == "--example") => {
            let at = words.iter().position(|w| w == "--")?;
            Some(words[at + 1..].to_vec())
        }
        _ => None,
    }
}

/// Runs a documented command with a small render. `folder` stands for the repository's root.
fn run_documented_command(page: &str, line: &[String], folder: &Path) {
    let command_line = format!("{page}: {}", line.join(" "));
    if let Some(arguments) = caustica_arguments(line) {
        let parsed =
            match Arguments::try_parse_from(std::iter::once("caustica").chain(arguments.iter().map(String::as_str))) {
                Ok(parsed) => Some(parsed.command),
                Err(e) if e.exit_code() == 0 => None,
                Err(e) => panic!("{command_line}\n{e}"),
            };
        let mut arguments = arguments;
        let (scene, outputs): (Option<&Path>, Vec<&PathBuf>) = match &parsed {
            Some(Command::Render(render)) => {
                set_small_render_flags(&mut arguments, render.method.caustic_photons.is_some());
                if let Some(shard) = render.shard {
                    set_flag(&mut arguments, "--passes", &shard.count.to_string());
                }
                if render.frames.is_some() {
                    set_flag(&mut arguments, "--frames", "0..1");
                }
                let outputs = render.output.iter().chain(&render.stats).chain(&render.film);
                (Some(&render.scene.scene), outputs.collect())
            }
            Some(Command::View(view)) => return show_documented_view(&arguments, &view.scene.scene),
            Some(Command::Estimate(estimate)) => {
                set_small_render_flags(&mut arguments, estimate.method.caustic_photons.is_some());
                let passes = arguments.iter().position(|word| word == "--passes").unwrap();
                arguments.drain(passes..passes + 2);
                set_flag(&mut arguments, "--pilot", "0.1s");
                (Some(&estimate.scene.scene), Vec::new())
            }
            Some(Command::Plan(plan)) => (Some(&plan.scene.scene), Vec::new()),
            Some(Command::Study(study)) => {
                set_small_render_flags(&mut arguments, study.method.caustic_photons.is_some());
                if !study.kind.effects {
                    set_flag(&mut arguments, "--budget", "0.1s");
                    set_flag(&mut arguments, "--truth-time", "0.2s");
                }
                (Some(&study.scene.scene), study.output.iter().collect())
            }
            Some(Command::Diff(diff)) => (None, diff.output.iter().collect()),
            Some(Command::Mesh(mesh)) => (Some(&mesh.mesh), mesh.output.iter().collect()),
            Some(Command::Check(check)) => (Some(&check.scene), Vec::new()),
            Some(Command::Convert(convert)) => (Some(&convert.scene), convert.output_file().into_iter().collect()),
            Some(Command::Merge(merge)) => (None, merge.output.iter().collect()),
            Some(Command::Film(_)) => (None, Vec::new()),
            Some(Command::Farm(farm)) => {
                // The machine of this test has no Slurm.
                arguments.push("--dry-run".to_owned());
                let FarmEngine::Slurm(slurm) = &farm.engine;
                (Some(&slurm.scene.scene), Vec::new())
            }
            Some(Command::Completions { .. } | Command::Man) | None => (None, Vec::new()),
        };
        // Scenes that the page asks the reader to save are in the folder, others in the project.
        let scene = scene.filter(|scene| !folder.join(scene).is_file());
        if let Some(scene) = scene.and_then(Path::to_str) {
            let mapped = repository_root().join(scene).to_str().unwrap().to_owned();
            arguments.iter_mut().filter(|a| *a == scene).for_each(|a| *a = mapped.clone());
        }
        for name in &outputs {
            assert!(name.is_relative(), "{command_line}\nwrites outside of the project");
            let parent = name.parent().unwrap();
            if repository_root().join(parent).is_dir() {
                std::fs::create_dir_all(folder.join(parent)).unwrap();
            }
        }
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        let output = command.current_dir(folder).args(&arguments).timeout(Duration::from_secs(60)).output().unwrap();
        assert!(output.status.success(), "{command_line}\n{}", String::from_utf8_lossy(&output.stderr));
        for name in outputs {
            let mut first_file = name.to_str().unwrap().replace("%04d", "0000");
            if matches!(&parsed, Some(Command::Render(render)) if render.stereo.is_some()) {
                first_file = first_file.replace('.', "-left.");
            }
            assert!(folder.join(&first_file).is_file(), "{command_line}\nwrote no {first_file}");
        }
        return;
    }
    let word = |i: usize| line.get(i).map_or("", String::as_str);
    match (word(0), word(1)) {
        ("mkdir", _) => line[1..].iter().filter(|w| !w.starts_with('-')).for_each(|w| {
            std::fs::create_dir_all(folder.join(w)).unwrap();
        }),
        ("cargo", "run") => {
            let name = line.iter().skip_while(|w| *w != "--example").nth(1).unwrap_or_else(|| panic!("{command_line}"));
            let examples = repository_root().join("examples");
            let there = examples.join(format!("{name}.rs")).is_file() || examples.join(name).join("main.rs").is_file();
            assert!(there, "{command_line}\nthere is no such example");
        }
        ("pip", "install") | ("python", _) => {
            let path = if word(0) == "pip" { word(2) } else { word(1) };
            assert!(repository_root().join(path).exists(), "{command_line}\nthere is no {path}");
        }
        ("cargo", "+nightly") => {
            let [target, corpus] = [6, 7].map(|i| word(i).to_owned());
            let there = repository_root().join(format!("fuzz/fuzz_targets/{target}.rs")).is_file()
                && repository_root().join(corpus).is_dir();
            assert!(line[2..4] == ["fuzz", "run"] && there, "{command_line}\nthere is no such target or corpus");
        }
        ("cargo", "build" | "test" | "bench" | "install" | "doc" | "clippy" | "fmt") | ("git" | "cd", _) => {}
        _ => panic!("{command_line}\nthis test does not know how to try this command: teach it"),
    }
}

/// Starts a documented `caustica view`, and ends it once it has printed the address of its page.
fn show_documented_view(arguments: &[String], scene: &Path) {
    let mut arguments = arguments.to_vec();
    set_flag(&mut arguments, "--size", "32x24");
    let mapped = repository_root().join(scene).to_str().unwrap().to_owned();
    arguments.iter_mut().filter(|a| Path::new(a) == scene).for_each(|a| *a = mapped.clone());
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_caustica"));
    let mut child = command.args(&arguments).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(line.starts_with("live page: http://127.0.0.1:"), "{line}");
}

/// Replaces size, passes and numbers of photons in `arguments` by those of a small render.
fn set_small_render_flags(arguments: &mut Vec<String>, caustic: bool) {
    let mut small = vec![("--size", "32x24"), ("--passes", "1"), ("--photons", "1k")];
    if caustic {
        small.push(("--caustic-photons", "1k"));
    }
    small.into_iter().for_each(|(flag, value)| set_flag(arguments, flag, value));
}

/// Sets a flag to a value; an earlier value of the flag is replaced.
fn set_flag(arguments: &mut Vec<String>, flag: &str, value: &str) {
    if let Some(at) = arguments.iter().position(|a| a == flag) {
        arguments.drain(at..at + 2);
    }
    arguments.retain(|a| !a.starts_with(&format!("{flag}=")));
    arguments.extend([flag.to_owned(), value.to_owned()]);
}

/// Returns the name and text of each scene file that a page asks the reader to save.
///
/// The text is the first scene after the words "Save it as".
fn scenes_to_save(page: &str) -> Vec<(String, String)> {
    page.split("Save it as")
        .skip(1)
        .map(|rest| {
            let name = rest.split('`').nth(1).expect("a file name in backticks").to_owned();
            (name, fenced_blocks(rest, "caustica").remove(0))
        })
        .collect()
}

#[test]
fn documented_commands_run() {
    let mut tried = 0;
    for (name, page) in documentation_pages() {
        let folder = tempfile::tempdir().unwrap();
        for (file, text) in scenes_to_save(&page) {
            std::fs::write(folder.path().join(file), text).unwrap();
        }
        for line in fenced_blocks(&page, "sh").iter().flat_map(|block| shell_commands(block)) {
            run_documented_command(&name.to_string_lossy(), &line, folder.path());
            tried += usize::from(caustica_arguments(&line).is_some());
        }
    }
    assert!(tried >= 4, "docs/guide/command-line.md alone has four");
}

#[test]
fn commands_parse_like_a_shell() {
    let block = "# a comment\n$ A_B=1 caustica render 'my scene.txt' \\\n  -o \"a b.png\"  # why\n\ncargo run --release -- render x\n";
    let read = shell_commands(block);
    assert_eq!(read.len(), 2);
    assert_eq!(caustica_arguments(&read[0]).unwrap(), ["render", "my scene.txt", "-o", "a b.png"]);
    assert_eq!(caustica_arguments(&read[1]).unwrap(), ["render", "x"]);
    assert_eq!(caustica_arguments(&shell_words("cargo run --example caustica -- x")), None);
    let mut arguments = shell_words("render x --size 9x9 --photons=2M --time 5m");
    set_small_render_flags(&mut arguments, false);
    assert_eq!(arguments, shell_words("render x --time 5m --size 32x24 --passes 1 --photons 1k"));
    assert_eq!(fenced_blocks("```sh\na\n```\n```text\nb\n```\n  ```sh\n  c\n  ```\n", "sh"), ["a\n", "  c\n"]);
}

/// Returns the cells of the table rows of a section of docs/guide/command-line.md.
fn guide_table_rows(section: &str) -> Vec<Vec<String>> {
    let page = std::fs::read_to_string(repository_root().join("docs/guide/command-line.md")).unwrap();
    let heading = format!("\n## {section}\n");
    let (_, after) = page.split_once(&heading).unwrap_or_else(|| panic!("no section {section}"));
    let rows = after.split("\n## ").next().unwrap().lines().filter(|line| line.starts_with("| "));
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
    rows.map(cells).skip(2).collect()
}

#[test]
fn docs_list_every_flag_with_default() {
    assert_flags_are_listed("render", "Flags");
    assert_flags_are_listed("diff", "Diff");
    assert_flags_are_listed("mesh", "Mesh");
    assert_flags_are_listed("merge", "Merge");
}

/// The sections about the other commands name all their flags, and no flag that a command lacks.
///
/// A section may refer to the flags of the algorithm, which the section `Flags` lists.
#[test]
fn docs_name_every_flag_of_other_commands() {
    let guide = |page: &str| std::fs::read_to_string(repository_root().join("docs/guide").join(page)).unwrap();
    let (commands, live) = (guide("command-line.md"), guide("live-page.md"));
    for (command, page, section) in [
        ("check", &commands, "Check"),
        ("convert", &commands, "Convert"),
        ("plan", &commands, "Plan"),
        ("estimate", &commands, "Estimate"),
        ("study", &commands, "Study"),
        ("film", &commands, "Merge"),
        ("view", &live, "Flags of view"),
    ] {
        let (_, after) = page.split_once(&format!("\n## {section}\n")).unwrap();
        let text = after.split("\n## ").next().unwrap();
        let named: BTreeSet<String> =
            text.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').filter_map(long_flag).collect();
        let flags = flags_of_command(&[command]);
        let of_algorithm: BTreeSet<String> = if text.contains("[flags of the algorithm]") {
            MethodArguments::augment_args(clap::Command::new("")).get_arguments().filter_map(argument_flag).collect()
        } else {
            BTreeSet::new()
        };
        let of_check = if text.contains("[`check`](#check)") { flags_of_command(&["check"]) } else { BTreeSet::new() };
        let missing: Vec<_> = flags
            .difference(&named)
            .filter(|flag| !of_algorithm.contains(*flag) && !of_check.contains(*flag))
            .collect();
        assert!(missing.is_empty(), "the section {section} does not name {missing:?} of {command}");
        let first_cells = text.lines().filter_map(|line| line.strip_prefix("| `-")?.split(" | ").next());
        for flag in first_cells.flat_map(|cell| cell.split(['`', ' ', ',']).filter_map(long_flag).collect::<Vec<_>>()) {
            assert!(command == "film" || flags.contains(&flag), "{command} has no flag {flag}");
        }
    }
}

/// Returns `word` if it is the name of a long flag, such as `--size`.
fn long_flag(word: &str) -> Option<String> {
    let name = word.trim_end_matches('-').strip_prefix("--")?;
    name.starts_with(|c: char| c.is_ascii_lowercase()).then(|| format!("--{name}"))
}

fn argument_flag(argument: &clap::Arg) -> Option<String> {
    argument.get_long().filter(|long| *long != "help").map(|long| format!("--{long}"))
}

/// Returns the long flags of a command, given as the names of nested subcommands.
fn flags_of_command(names: &[&str]) -> BTreeSet<String> {
    let arguments = Arguments::command();
    let command = names.iter().fold(&arguments, |command, name| command.find_subcommand(name).unwrap());
    command.get_arguments().filter_map(argument_flag).collect()
}

fn assert_flags_are_listed(command: &str, section: &str) {
    let arguments = Arguments::command();
    let command = arguments.find_subcommand(command).unwrap();
    let rows = guide_table_rows(section);
    let bare = |text: &str| text.replace('`', "");
    let mut known = BTreeSet::new();
    for argument in command.get_arguments().filter(|a| a.get_id() != "help") {
        let Some(long) = argument.get_long() else { continue };
        known.insert(format!("--{long}"));
        let mut first = argument.get_short().map_or(String::new(), |c| format!("`-{c}`, "));
        let takes = argument.get_num_args().is_none_or(|n| n.takes_values());
        let value = argument
            .get_value_names()
            .unwrap_or_default()
            .first()
            .filter(|_| takes && argument.get_action().takes_values());
        first += &value.map_or(format!("`--{long}`"), |value| format!("`--{long} {value}`"));
        let row = rows.iter().find(|row| row[0] == first).unwrap_or_else(|| panic!("no row for {first}"));
        let help = argument.get_help().unwrap().to_string();
        let default = match argument.get_default_values() {
            [value] if value.to_str() != Some("false") => value.to_str().unwrap().to_owned(),
            _ if argument.is_required_set() => "required".to_owned(),
            _ => help.split_once("[default: ").map_or("none", |(_, d)| d.trim_end_matches(']')).to_owned(),
        };
        assert_eq!(bare(&row[1]), default, "{first}");
        for value in argument.get_possible_values().iter().filter(|_| value.is_some()) {
            assert!(row[2].contains(&format!("`{}`", value.get_name())), "{first}: {}", value.get_name());
        }
    }
    let listed: BTreeSet<String> = rows
        .iter()
        .map(|row| bare(&row[0]).split([' ', ',']).find(|w| w.starts_with("--")).unwrap().to_owned())
        .collect();
    assert_eq!(listed, known);
}

#[test]
fn docs_list_every_exit_code() {
    let codes: Vec<String> = guide_table_rows("Exit codes").iter().map(|row| row[0].replace('`', "")).collect();
    let known = [Exit::Success, Exit::Input, Exit::Usage, Exit::Output, Exit::Differ, Exit::Farm, Exit::Interrupted];
    assert_eq!(codes, known.map(|exit| (exit as u8).to_string()));
}

/// The page about farms lists each flag that `farm slurm` has beyond those of `render`.
#[test]
fn farm_page_lists_its_flags() {
    let page = std::fs::read_to_string(repository_root().join("docs/guide/farm.md")).unwrap();
    let arguments = Arguments::command();
    let flags = |command: &clap::Command| -> BTreeSet<String> {
        command.get_arguments().filter_map(|argument| argument.get_long()).map(|long| format!("--{long}")).collect()
    };
    let slurm = arguments.find_subcommand("farm").unwrap().find_subcommand("slurm").unwrap();
    let render = flags(arguments.find_subcommand("render").unwrap());
    let same = ["--passes", "--target-error", "--threads", "--memory"].map(str::to_owned);
    let own: BTreeSet<String> = flags(slurm).difference(&render).cloned().chain(same).collect();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `--"));
    let listed: BTreeSet<String> = rows.map(|row| format!("--{}", row.split([' ', '`']).next().unwrap())).collect();
    assert_eq!(listed, own);
}

/// Returns the anchor that GitHub gives a heading.
fn heading_anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    for (name, page) in documentation_pages() {
        let folder = repository_root().join(name.parent().unwrap());
        for (at, _) in page.match_indices("](") {
            let target = page[at + 2..].split(')').next().unwrap();
            if target.contains("://") {
                continue;
            }
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { repository_root().join(&name) } else { folder.join(file) };
            assert!(path.exists(), "{} links to {target}", name.display());
            if !heading.is_empty() {
                let text = std::fs::read_to_string(&path).unwrap();
                let found = text.lines().any(|l| l.starts_with('#') && heading_anchor(l) == heading);
                assert!(found, "{} links to {target}", name.display());
            }
        }
    }
}

/// Folders of the repository. If a page names a file in one of them in backticks, the file must
/// exist.
const NAMED: [&str; 7] = ["src/", "tests/", "docs/", "scenes/", "examples/", "benches/", ".ci/"];

#[test]
fn paths_in_backticks_exist() {
    let mut tried = 0;
    for (name, page) in documentation_pages() {
        let text = page.split("```").step_by(2).collect::<String>();
        for path in text.split('`').skip(1).step_by(2).filter(|p| NAMED.iter().any(|n| p.starts_with(n))) {
            let path = path.split([' ', '*', '<', '{']).next().unwrap();
            tried += 1;
            assert!(repository_root().join(path).exists(), "{} names {path}", name.display());
        }
    }
    assert!(tried > 20, "{tried} paths");
}

#[test]
fn scenes_of_language_page_render() {
    let read = |page: &str| fenced_blocks(&std::fs::read_to_string(repository_root().join(page)).unwrap(), "caustica");
    let mut scenes = read("docs/guide/scene-language.md");
    scenes.extend(read("docs/guide/first-picture.md"));
    assert!(scenes.len() >= 2);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("mesh")).unwrap();
    std::fs::write(folder.path().join("mesh/cube.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let faces = "v -.4 0 0\nv .4 0 0\nv 0 .8 0\nv 0 .4 .6\n";
    let parts = "mtllib faces.mtl\nusemtl lamp\nf 1 2 4\nusemtl matt\nf 2 3 4\nusemtl mirror\nf 3 1 4\n";
    std::fs::write(folder.path().join("mesh/faces.obj"), format!("{faces}{parts}")).unwrap();
    let mtl = "newmtl lamp\nKe 4 4 3\nnewmtl matt\nKd .8 .2 .1\nillum 1\nnewmtl mirror\nKd 0\nKs .9\nillum 3\n";
    std::fs::write(folder.path().join("mesh/faces.mtl"), mtl).unwrap();
    let converted = mesh::load(&folder.path().join("mesh/faces.obj"), &()).unwrap().mesh;
    converted.write(&folder.path().join("mesh/faces.ply"), MeshFormat::PlyBinary, &[]).unwrap();
    std::fs::create_dir(folder.path().join("textures")).unwrap();
    let gray = Image::from_pixels(2, 2, vec![glam::Vec3::splat(0.5); 4]).unwrap();
    image::write(&folder.path().join("textures/tile.png"), &gray, &WriteOptions::default()).unwrap();
    std::fs::create_dir(folder.path().join("grids")).unwrap();
    let flame = DensityGridData { cell_counts: [2, 3, 2], densities: vec![0.5; 12] };
    grid::write(&folder.path().join("grids/flame.grid"), &flame, GridEncoding::F32).unwrap();
    for (i, text) in scenes.iter().enumerate() {
        let mut description = parse("scene-language.md", text).unwrap();
        (description.camera.value.width, description.camera.value.height) = (32, 24);
        let scene = resolve(&description, &SourceText::new("scene-language.md", text), folder.path()).unwrap();
        let ray_cast = Algorithm::Raycast.prepare(&scene, Settings::default());
        let image = ray_cast.render_pass(0, &SilentMonitor).image;
        assert!(image.iter().all(|p| p.is_finite()) && image.iter().any(|p| *p != scene.background()), "scene {i}");

        std::fs::write(folder.path().join("a.txt"), description.to_string()).unwrap();
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
        let arguments = ["render", "a.txt", "-o", "a.png", "--passes", "1", "--photons", "1k"];
        let output =
            command.current_dir(folder.path()).args(arguments).timeout(Duration::from_secs(60)).output().unwrap();
        assert!(output.status.success(), "scene {i}\n{}", String::from_utf8_lossy(&output.stderr));
    }
}
