//! Film files: renders that continue after an interruption, and renders in parts.

use super::CliSandbox;
#[cfg(target_os = "linux")]
use caustica::render::{FilmFile, PassSet};
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Returns flags of a render of `passes` passes that writes the picture `name`.exr.
fn flags(name: &str, passes: u32, more: &str) -> String {
    format!("-o {name}.exr --passes {passes} --photons 1k {more}")
}

/// A render that continues from a film has the same bits as an uninterrupted render.
///
/// This holds with any number of threads. No pass is rendered twice.
#[test]
fn continued_renders_have_the_bits_of_one_render() {
    for integrator in ["hybrid", "sppm", "path"] {
        let sandbox = CliSandbox::new();
        let method = format!("--integrator {integrator}");
        sandbox.render("box.txt", &flags("whole", 6, &format!("{method} --stats whole.json"))).expect(0, &[]);
        let film = format!("{method} --film a.film");
        sandbox.render("box.txt", &flags("half", 2, &format!("{film} --threads 1"))).expect(0, &["wrote a.film"]);
        let rest = flags("rest", 6, &format!("{film} --threads 2 --exposure 1 --stats rest.json"));
        sandbox.render("box.txt", &rest).expect(0, &["continuing a.film: 2 passes", "pass 3/6", "pass 6/6"]);
        assert_eq!(sandbox.bytes("rest.exr"), sandbox.bytes("whole.exr"), "{integrator}");
        let stats = |name: &str| serde_json::from_slice::<serde_json::Value>(&sandbox.bytes(name)).unwrap();
        let (mut rest, mut whole) = (stats("rest.json"), stats("whole.json"));
        for report in [&mut rest, &mut whole] {
            report["error"]["halving_seconds"].take();
        }
        assert_eq!((&rest["error"], &rest["counters"]), (&whole["error"], &whole["counters"]), "{integrator}");
        let again = sandbox.render("box.txt", &flags("again", 6, &film));
        again.expect(0, &["continuing a.film: 6 passes", "6 passes in"]);
        assert!(!again.stderr.contains("pass 7"), "{}", again.stderr);
        assert_eq!(sandbox.bytes("again.exr"), sandbox.bytes("whole.exr"), "{integrator}");
        assert!(!sandbox.names().iter().any(|name| name.ends_with(".lock")));
    }
}

/// Films carry light groups: those of a merged render have the bits of one render.
#[test]
fn films_carry_light_groups() {
    let sandbox = CliSandbox::new();
    // Other integrators have mean gather radii, whose rounding depends on the order of merging.
    let grouped = "--light-groups --integrator path";
    sandbox.render("box.txt", &flags("whole", 6, &format!("{grouped} --aov whole-layers.exr"))).expect(0, &[]);
    for part in 1..=2 {
        let more = format!("{grouped} --film {part}.film --shard {part}/2");
        sandbox.render("box.txt", &flags("part", 6, &more)).expect(0, &[]);
    }
    sandbox.run(&["merge", "1.film", "2.film", "-o", "all.film"]).expect(0, &[]);
    let rest = format!("{grouped} --film all.film --aov layers.exr");
    sandbox.render("box.txt", &flags("rest", 6, &rest)).expect(0, &["continuing all.film: 6 passes"]);
    assert_eq!(sandbox.bytes("layers.exr"), sandbox.bytes("whole-layers.exr"));
    let without = sandbox.render("box.txt", &flags("rest", 6, "--film all.film"));
    without.expect(2, &["is of another render", "--light-groups"]);
}

/// Films carry the light that clamping removed, and belong to one window.
#[test]
fn films_carry_windows_and_clamped_light() {
    let sandbox = CliSandbox::new();
    let window = "--crop 3,2,33,28 --clamp 1";
    let stats = |name: &str| serde_json::from_slice::<serde_json::Value>(&sandbox.bytes(name)).unwrap();
    let whole = format!("{window} --integrator path --stats whole.json");
    sandbox.render("box.txt", &flags("whole", 6, &whole)).expect(0, &["clamping removed", "% of the light"]);
    let film = format!("{window} --integrator path --film a.film");
    sandbox.render("box.txt", &flags("half", 2, &film)).expect(0, &[]);
    sandbox.render("box.txt", &flags("rest", 6, &format!("{film} --stats rest.json"))).expect(0, &[]);
    assert_eq!(sandbox.bytes("rest.exr"), sandbox.bytes("whole.exr"));
    let (rest, whole) = (stats("rest.json"), stats("whole.json"));
    assert_eq!(rest["clamped_fraction"], whole["clamped_fraction"]);
    assert!(whole["clamped_fraction"].as_f64().unwrap() > 0.0 && whole["error"]["clamping"].as_f64().unwrap() > 0.0);
    assert_eq!(rest["error"]["clamping"], whole["error"]["clamping"]);
    let other = "--crop 4,2,34,28 --clamp 1 --integrator path --film a.film";
    sandbox.render("box.txt", &flags("other", 6, other)).expect(2, &["is of another render", "--crop 3,2,33,28"]);
}

/// Kills a render `kills` times by SIGKILL, and checks that the continued render has the bits of a
/// whole one.
#[cfg(unix)]
fn kill_and_continue(kills: u32) {
    let sandbox = CliSandbox::new();
    let arguments = |name: &str| flags(name, 60, "--film a.film --save-every 0");
    sandbox.render("box.txt", &flags("whole", 60, "")).expect(0, &[]);
    for kill in 0..kills {
        let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
        command.current_dir(sandbox.path(".")).args(["render", "box.txt"]).args(arguments("killed").split_whitespace());
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        // The waiting times range from before the first pass to after the last one.
        std::thread::sleep(Duration::from_millis(u64::from(kill * 7919 % 400)));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    sandbox.render("box.txt", &arguments("continued")).expect(0, &["wrote a.film"]);
    assert_eq!(sandbox.bytes("continued.exr"), sandbox.bytes("whole.exr"));
}

#[cfg(unix)]
#[test]
#[ignore = "long: many runs of the program"]
fn killed_renders_go_on_from_the_film() {
    kill_and_continue(8);
}

#[cfg(unix)]
#[test]
#[ignore = "long: 30 killed renders"]
fn often_killed_renders_go_on_from_the_film() {
    kill_and_continue(30);
}

/// A film of another scene or of other settings is refused, and its file does not change.
///
/// Settings that alter no pass may differ.
#[test]
fn films_of_other_renders_are_refused() {
    let sandbox = CliSandbox::new();
    sandbox.put("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for seed in 1..=2 {
        let picture = format!("-o wood{seed}.png --passes 1 --size 8x6 --seed {seed}");
        sandbox.render("box.txt", &picture).expect(0, &[]);
    }
    sandbox.put("wood.png", sandbox.bytes("wood1.png"));
    let textured = "Textures { Image wood { file wood.png } }\nMaterials {\n    Diffuse wooden { reflectance wood }";
    let textured = super::BOX.replacen("Materials {", textured, 1);
    let objects = "MaterialName wooden  Sphere { center 0 1 0 radius .2 }\n\
                   MaterialName white  TriangleMesh { obj_file ball.obj }";
    let mesh = format!("{textured}\nGroup {{ {objects} }}\n");
    sandbox.put("mesh.txt", &mesh);
    sandbox.render("mesh.txt", &flags("a", 1, "--film a.film")).expect(0, &[]);
    let before = sandbox.bytes("a.film");
    let refused = |more: &str, parts: &[&str]| {
        sandbox.render("mesh.txt", &flags("b", 2, &format!("--film a.film {more}"))).expect(2, parts);
        assert_eq!(sandbox.bytes("a.film"), before, "{more}");
    };
    refused("--seed 4", &["is of another render", "seed: 4 here, 0 there"]);
    refused("--spp 2", &["--spp 2` here"]);
    refused("--size 20x15", &["size: 20x15 here, 40x30 there"]);
    refused("--no-error-estimate", &["--no-error-estimate` here"]);
    sandbox.put("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 .5\nf 1 2 3\n");
    refused("", &["file `ball.obj` has another content"]);
    sandbox.put("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    sandbox.put("wood.png", sandbox.bytes("wood2.png"));
    refused("", &["file `wood.png` has another content"]);
    sandbox.put("wood.png", sandbox.bytes("wood1.png"));
    sandbox.render("mesh.txt", &flags("b", 2, "--film a.film --threads 1 --tone filmic -q")).expect(0, &[]);
    sandbox.put("b.film", &before[..before.len() - 9]);
    sandbox.render("mesh.txt", &flags("b", 2, "--film b.film")).expect(1, &["`b.film`", "it is cut off"]);
    sandbox.put("c.film", "no film");
    sandbox.render("mesh.txt", &flags("b", 2, "--film c.film")).expect(1, &["it is no film"]);
    sandbox.run(&["film", "c.film"]).expect(1, &["it is no film"]);
    sandbox.render("mesh.txt", "--film mesh.txt -o b.exr").expect(2, &["are the same file"]);
}

/// A film records the content of each texture file under its path. If two textures are swapped
/// between folders, the film is refused.
#[test]
fn pictures_swapped_between_folders_are_refused() {
    let sandbox = CliSandbox::new();
    let pictures = ["1", "2"].map(|seed| {
        sandbox.render("box.txt", &format!("-o a.png --size 8x6 --seed {seed}")).expect(0, &[]);
        sandbox.bytes("a.png")
    });
    let put = |order: [usize; 2]| {
        for (folder, picture) in ["left", "right"].into_iter().zip(order) {
            std::fs::create_dir_all(sandbox.path(folder)).unwrap();
            sandbox.put(&format!("{folder}/wood.png"), &pictures[picture]);
        }
    };
    let textures = "Textures { Image l { file left/wood.png }  Image r { file right/wood.png } }\n\
                    Materials {\n    Diffuse left { reflectance l }  Diffuse right { reflectance r }";
    let spheres = "MaterialName left  Sphere { center 0 1 0 radius .2 }\n\
                   MaterialName right  Sphere { center 0 1.5 0 radius .2 }";
    let scene = super::BOX.replacen("Materials {", textures, 1);
    sandbox.put("two.txt", format!("{scene}\nGroup {{ {spheres} }}\n"));
    put([0, 1]);
    sandbox.render("two.txt", &flags("a", 1, "--film a.film")).expect(0, &[]);
    put([1, 0]);
    let parts = ["file `left/wood.png` has another content", "file `right/wood.png` has another content"];
    sandbox.render("two.txt", &flags("a", 2, "--film a.film")).expect(2, &parts);
    put([0, 1]);
    // The same film belongs to the scene under its absolute path.
    let absolute = sandbox.path("two.txt");
    let rest = flags("a", 2, "--film a.film");
    sandbox.render(absolute.to_str().unwrap(), &rest).expect(0, &["continuing a.film: 1 pass"]);
}

/// A scene file that changes while pilots run does not count as the scene of the film.
#[test]
fn edits_during_pilots_do_not_enter_the_film() {
    let sandbox = CliSandbox::new();
    let film = |name: &str| flags(name, 2, "--size 160x120 --film a.film");
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(sandbox.path(".")).args(["render", "box.txt"]).args(film("a").split_whitespace());
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut messages = BufReader::new(child.stderr.take().unwrap());
    let mut text = String::new();
    while !text.contains("box.txt:") {
        assert!(messages.read_line(&mut text).unwrap() > 0, "{text}");
    }
    sandbox.put("box.txt", format!("{}\n", super::BOX));
    messages.read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{text}");
    sandbox.render("box.txt", &film("b")).expect(2, &["file `box.txt` has another content"]);
    sandbox.put("box.txt", super::BOX);
    sandbox.render("box.txt", &film("b")).expect(0, &["continuing a.film: 2 passes"]);
}

#[cfg(unix)]
#[test]
fn two_renders_do_not_share_a_film() {
    let sandbox = CliSandbox::new();
    let line = flags("a", 1_000_000, "--film a.film --save-every 0");
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(sandbox.path(".")).args(["render", "box.txt"]).args(line.split_whitespace());
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    while !sandbox.path("a.film").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    sandbox.render("box.txt", &flags("b", 2, "--film a.film")).expect(2, &["another render writes the film"]);
    child.kill().unwrap();
    child.wait().unwrap();
    sandbox.render("box.txt", &flags("b", 2, "--film a.film")).expect(0, &["continuing a.film"]);
}

/// If the new film cannot be written completely, as on a full disk, the old film stays.
#[cfg(unix)]
#[test]
fn full_disks_leave_the_film_whole() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", &flags("a", 2, "--film a.film")).expect(0, &[]);
    let before = sandbox.bytes("a.film");
    let program = env!("CARGO_BIN_EXE_caustica");
    let line =
        format!("trap '' XFSZ; ulimit -f 16; exec {program} render box.txt --film a.film --passes 3 --photons 1k");
    let output = Command::new("sh").current_dir(sandbox.path(".")).args(["-c", &line]).output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(sandbox.bytes("a.film"), before);
}

/// A render survives a clock that was set back: its files are then from the future.
#[cfg(unix)]
#[test]
fn a_clock_set_back_loses_no_film() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", &flags("whole", 6, "")).expect(0, &[]);
    sandbox.render("box.txt", &flags("a", 2, "--film a.film")).expect(0, &[]);
    sandbox.put("a.film.lock", "");
    sandbox.put(".caustica-x.tmp", "");
    let tomorrow = std::time::SystemTime::now() + Duration::from_secs(86_400);
    for name in ["a.film", "a.exr", "a.film.lock", ".caustica-x.tmp", "box.txt"] {
        std::fs::File::open(sandbox.path(name)).unwrap().set_modified(tomorrow).unwrap();
    }
    let rest = flags("a", 6, "--film a.film --save-every 0");
    sandbox.render("box.txt", &rest).expect(0, &["continuing a.film: 2 passes", "pass 6/6", "wrote a.film"]);
    assert_eq!(sandbox.bytes("a.exr"), sandbox.bytes("whole.exr"));
    // A temporary file that seems to be from the future is kept, because it may belong to a running
    // process.
    assert!(sandbox.path(".caustica-x.tmp").exists());
}

/// Films that exceed `--memory` are refused before their sums are read. A limit slightly above the
/// size in the error message is enough.
#[test]
#[ignore = "long: many runs of the program"]
fn films_count_in_the_memory_limit() {
    let sandbox = CliSandbox::new();
    let size = "--size 400x300 --spp 1 --photons 1k --no-prefix-rays";
    for part in 1..=2 {
        let more = format!("{size} --passes 2 --shard {part}/2 --film part{part}.film");
        sandbox.render("box.txt", &more).expect(0, &["wrote part"]);
    }
    // A film takes 470 bytes for each pixel, and the program 14 MB.
    let refused = ["take 112.8 MB of memory", "allow more --memory"];
    let merge = ["merge", "part1.film", "part2.film", "-o", "sum.exr", "-o", "sum.film", "--memory"];
    sandbox.run(&[&merge[..], &["120M"]].concat()).expect(2, &refused);
    sandbox.run(&[&merge[..], &["130M"]].concat()).expect(0, &["wrote sum.film"]);
    sandbox.run(&["film", "sum.film", "--memory", "60M"]).expect(2, &["takes 56.4 MB", "allow more --memory"]);
    sandbox.run(&["film", "sum.film", "--memory", "75M"]).expect(0, &[]);
    let more = |limit: &str| format!("{size} --passes 4 --film sum.film --memory {limit} --threads 1");
    let before = sandbox.bytes("sum.film");
    sandbox.render("box.txt", &more("60M")).expect(2, &["takes 56.4 MB"]);
    assert_eq!(sandbox.bytes("sum.film"), before);
    // The peak is that of the allocations. The limit also covers the 14 MB of the program itself.
    sandbox.render("box.txt", &format!("{} --save-every 0 --stats stats.json", more("90M"))).expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("stats.json")).unwrap();
    let peak = stats["peak_memory_bytes"].as_u64().unwrap();
    assert!(peak < 76_000_000, "{peak}");
    // Light groups take 210 more bytes per pixel, and clamped light 140. Without an error estimate,
    // a pixel takes 88 bytes.
    for (more, refused) in [("--light-groups --clamp 5", "takes 98.4 MB"), ("--no-error-estimate", "takes 10.6 MB")] {
        sandbox.render("box.txt", &format!("{size} {more} --film more.film")).expect(0, &[]);
        sandbox.run(&["film", "more.film", "--memory", "20M"]).expect(2, &[refused]);
        std::fs::remove_file(sandbox.path("more.film")).unwrap();
    }
}

/// Returns the largest resident memory \[bytes] of a run of `merge` over `films`.
#[cfg(target_os = "linux")]
fn peak_memory_of_merge(sandbox: &CliSandbox, films: &[String]) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(sandbox.path(".")).arg("merge").args(films).args(["-q", "-o", "sum.exr"]);
    let mut child = command.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    let exit = loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let kilobytes = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak = kilobytes.map_or(peak, |kilobytes| 1024 * kilobytes.parse::<u64>().unwrap());
        if let Some(exit) = child.try_wait().unwrap() {
            break exit;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    assert!(exit.success() && peak > 0);
    peak
}

/// Merging 1,000 films takes the memory of two films: the peak grows by less than five films.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: 1,000 films"]
fn merging_many_films_takes_the_memory_of_two() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", &flags("a", 1, "--film a.film")).expect(0, &[]);
    let FilmFile { header, mut rendered } = FilmFile::read(&sandbox.bytes("a.film")[..]).unwrap();
    let name = |pass: u32| format!("{pass}.film");
    for pass in 0..1000 {
        rendered.pass_numbers = PassSet::default();
        rendered.pass_numbers.insert(pass..pass + 1);
        let mut bytes = Vec::new();
        FilmFile::write(&header, &rendered, &mut bytes).unwrap();
        sandbox.put(&name(pass), bytes);
    }
    let peaks = [2, 1000].map(|count| {
        let films: Vec<String> = (0..count).map(name).collect();
        // One look may miss the last moments of a short run.
        (0..5).map(|_| peak_memory_of_merge(&sandbox, &films)).max().unwrap()
    });
    println!("peak memory of merging 2 films: {} bytes, 1,000 films: {} bytes", peaks[0], peaks[1]);
    // A film takes 334 bytes for each of 40 × 30 pixels.
    assert!(peaks[1] < peaks[0] + 5 * 334 * 40 * 30, "{peaks:?}");
}

/// The merged PNG of `raycast` has the tone curve of that algorithm.
#[test]
fn merged_picture_has_the_tone_of_its_algorithm() {
    let sandbox = CliSandbox::new();
    for part in 1..=2 {
        let shard = format!("--integrator raycast --passes 2 --shard {part}/2 --film part{part}.film");
        sandbox.render("box.txt", &shard).expect(0, &[]);
    }
    sandbox.render("box.txt", "--integrator raycast --passes 2 -o whole.png").expect(0, &[]);
    sandbox.run(&["merge", "part1.film", "part2.film", "-o", "sum.png"]).expect(0, &["wrote sum.png"]);
    let pixels = |name: &str| image::open(sandbox.path(name)).unwrap().to_rgb8();
    assert_eq!(pixels("sum.png"), pixels("whole.png"));
    sandbox.run(&["merge", "part1.film", "part2.film", "--tone", "srgb", "-o", "other.png"]).expect(0, &[]);
    assert_ne!(pixels("other.png"), pixels("whole.png"));
}

/// The films of all parts of a render add up to the bits of one render, in any order.
#[test]
#[ignore = "long: many runs of the program"]
fn merged_parts_have_the_bits_of_one_render() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", &flags("whole", 7, "--film whole.film")).expect(0, &[]);
    for part in 1..=3 {
        let more = format!("--photons 1k --passes 7 --shard {part}/3 --film part{part}.film");
        sandbox.render("box.txt", &more).expect(0, &["wrote part"]);
    }
    sandbox.run(&["merge", "part2.film", "part1.film", "-o", "some.exr"]).expect(0, &["passes 5–7 are missing"]);
    let parts = ["part3.film", "part1.film", "part3.film", "part2.film"];
    let arguments = [&["merge"], &parts[..], &["-o", "sum.exr", "-o", "sum.film"]].concat();
    sandbox.run(&arguments).expect(0, &["part3.film has the passes of an earlier film", "7 passes", "estimated error"]);
    assert_eq!(sandbox.bytes("sum.exr"), sandbox.bytes("whole.exr"));
    let text = |name: &str| {
        let run = sandbox.run(&["film", name]);
        run.expect(0, &[]);
        run.stdout.lines().filter(|line| !line.starts_with("time")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(text("sum.film"), text("whole.film"));
    assert!(text("part2.film").contains(&"missing   5: 1–2, 5–7".to_owned()), "{:?}", text("part2.film"));

    sandbox.run(&["merge", "whole.film", "part1.film", "-o", "x.exr"]).expect(1, &["both renders have passes 1–2"]);
    sandbox.render("box.txt", &flags("a", 2, "--seed 3 --film other.film")).expect(0, &[]);
    sandbox.run(&["merge", "part1.film", "other.film", "-o", "x.exr"]).expect(1, &["seed: 0 here, 3 there"]);
    sandbox.run(&["merge", "part1.film", "-o", "part1.film"]).expect(2, &["are the same file"]);
    sandbox.render("box.txt", "--passes 2 --shard 3/9 --film z.film").expect(2, &["has none of 2 passes"]);
    let other = sandbox.render("box.txt", "--photons 1k --passes 7 --shard 1/3 --film part2.film");
    other.expect(2, &["which are not those of --shard"]);
}
