//! Measures how long scenes of each format take to load, and how much memory their instances take:
//! `cargo run --release --example load_time`.
//!
//! The files are written into a temporary folder: a wavy grid of a million triangles with normals
//! and texture coordinates, and 100,000 instances of a cube. Each measurement is a process of its
//! own. The output is two Markdown tables.

mod files;

use caustica::format::{SceneFile, mesh};
use caustica::stats::peak_memory;
use std::error::Error;
use std::path::Path;
use std::process::Command;

/// Number of processes for each file. The median of their times counts.
const RUNS: usize = 3;

/// Length of a clock tick of `/proc` \[seconds].
const TICK: f64 = 0.01;

/// Number of instances.
const INSTANCES: u32 = 100_000;

/// Returns the processor time of all threads of this process so far \[seconds].
fn processor_time() -> Result<f64, Box<dyn Error>> {
    let line = std::fs::read_to_string("/proc/self/stat")?;
    // The name of the program, in parentheses, may hold blanks. The twelfth and thirteenth words
    // after it are user and system time.
    let numbers = line.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks = numbers.map(str::parse::<f64>).sum::<Result<f64, _>>()?;
    Ok(ticks * TICK)
}

/// Result of one process: processor times of reading the file and of building the scene \[seconds],
/// and peak memory \[bytes].
type Measured = [f64; 3];

/// Reads a mesh, or reads a scene and builds it.
fn measure(path: &Path) -> Result<Measured, Box<dyn Error>> {
    let start = processor_time()?;
    let is_mesh = path.extension().is_some_and(|extension| extension == "ply" || extension == "obj");
    if is_mesh {
        let loaded = mesh::load(path, &())?;
        let seconds = processor_time()? - start;
        drop(loaded);
        return Ok([seconds, 0.0, peak_memory().unwrap_or(0) as f64]);
    }
    let file = SceneFile::read(path)?;
    let read = processor_time()? - start;
    let scene = file.resolve()?;
    let built = processor_time()? - start - read;
    drop((scene, file));
    Ok([read, built, peak_memory().unwrap_or(0) as f64])
}

/// Returns the medians over processes that measure `path`.
fn median(path: &Path) -> Result<Measured, Box<dyn Error>> {
    let mut columns = [const { Vec::new() }; 3];
    for _ in 0..RUNS {
        let output = Command::new(std::env::current_exe()?).arg(path).output()?;
        let text = String::from_utf8(output.stdout)?;
        let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        if numbers.len() != columns.len() {
            return Err(format!("{}: {}", path.display(), String::from_utf8_lossy(&output.stderr)).into());
        }
        columns.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
    }
    Ok(columns.map(|mut column| {
        column.sort_by(f64::total_cmp);
        column[RUNS / 2]
    }))
}

fn main() -> Result<(), Box<dyn Error>> {
    if let Some(path) = std::env::args().nth(1) {
        let [read, built, peak] = measure(Path::new(&path))?;
        println!("{read} {built} {peak}");
        return Ok(());
    }
    let folder = tempfile::tempdir()?;
    println!("| file | reading [s] | building [s] | peak memory [MB] |\n| --- | --- | --- | --- |");
    for (name, path) in files::write_meshes(folder.path())? {
        let [read, built, peak] = median(&path)?;
        println!("| {name} | {read:.2} | {built:.2} | {:.0} |", peak / 1e6);
    }
    println!("\n| {INSTANCES} instances | time [s] | bytes per instance |\n| --- | --- | --- |");
    let one = files::write_instances(folder.path(), 1)?;
    let many = files::write_instances(folder.path(), INSTANCES)?;
    for ((name, one), (_, many)) in one.into_iter().zip(many) {
        let ([.., least], [read, built, peak]) = (median(&one)?, median(&many)?);
        println!("| {name} | {:.2} | {:.0} |", read + built, (peak - least) / f64::from(INSTANCES));
    }
    Ok(())
}
