//! Renders the images of docs/gallery.md and writes the page:
//!
//! ```sh
//! cargo run --release --example gallery -- [NAME …]
//! ```
//!
//! With names it renders only those. Statistics files beside the images describe the others.

mod entries;

use caustica::cli::{self, Arguments};
use caustica::study::text::percent_text;
use clap::Parser;
use entries::{ENTRIES, Entry};
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the images, as the page and its commands name it.
const FOLDER: &str = "docs/images/gallery";

fn main() -> Result<(), Box<dyn Error>> {
    // Paths of scenes and images are relative to the repository's root.
    std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
    fs::create_dir_all(FOLDER)?;
    let names: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = names.iter().find(|name| ENTRIES.iter().all(|entry| entry.name != **name)) {
        return Err(format!("no picture is called `{unknown}`").into());
    }
    let chosen: Vec<&Entry> =
        ENTRIES.iter().filter(|entry| names.is_empty() || names.iter().any(|name| name == entry.name)).collect();
    match chosen[..] {
        [entry] => render(entry)?,
        // A process of its own for each image: the statistics hold the time of the whole process.
        _ => chosen.into_iter().try_for_each(render_in_process)?,
    }
    let page = page()?;
    fs::write("docs/gallery.md", page)?;
    Ok(())
}

impl Entry {
    fn picture(&self) -> PathBuf {
        Path::new(FOLDER).join(self.name).with_extension("png")
    }

    fn statistics(&self) -> PathBuf {
        Path::new(FOLDER).join(self.name).with_extension("json")
    }

    /// Returns the command that a reader types.
    fn command(&self) -> String {
        let gap = if self.arguments.is_empty() { "" } else { " " };
        format!("caustica render {} -o {}{gap}{}", self.scene, self.picture().display(), self.arguments)
    }
}

fn render(entry: &Entry) -> Result<(), Box<dyn Error>> {
    let command = format!("{} --stats {}", entry.command(), entry.statistics().display());
    eprintln!("\n{command}");
    let arguments = Arguments::try_parse_from(command.split_whitespace())?;
    cli::run(arguments).map(drop).map_err(|failure| format!("{:?}", failure.reports).into())
}

/// Renders `entry` in another process of this program.
fn render_in_process(entry: &Entry) -> Result<(), Box<dyn Error>> {
    let status = Command::new(std::env::current_exe()?).arg(entry.name).status()?;
    if status.success() { Ok(()) } else { Err(format!("`{}` was not rendered: {status}", entry.name).into()) }
}

/// Returns the page, made of the existing images and statistics.
fn page() -> Result<String, Box<dyn Error>> {
    let mut page = String::from(
        "# Gallery\n\nThis page has one picture for each effect, then compositions of many. Below each picture are the command that\n\
         makes it, the passes, the estimated error, the photons stored in all passes, and the wall time and processor\n\
         time, on two cores that other work shared. A render ends at an estimated error of 3 %, or after five minutes.\n\
         In dark pixels, the error is relative to the median radiance of the picture. So pictures that are mostly dark\n\
         have large errors. [What accuracy costs](accuracy-strips.md) shows pictures with smaller and larger errors.\n\
         This command renders all pictures and writes the page:\n\n```sh\n\
         cargo run --release --example gallery\n```\n",
    );
    let mut part = "";
    for entry in ENTRIES {
        if entry.part != part {
            part = entry.part;
            write!(page, "\n## {part}\n")?;
        }
        let text = fs::read_to_string(entry.statistics())?;
        let statistics: serde_json::Value = serde_json::from_str(&text)?;
        let number = |path: &str| statistics.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
        let stored = number("/photons/global/stored") + number("/photons/caustic/stored");
        let photons = if stored > 0.0 { format!("{:.1} M photons", stored / 1e6) } else { "no photons".to_owned() };
        let passes = match number("/passes") {
            1.0 => "1 pass".to_owned(),
            n => format!("{n} passes"),
        };
        let error = statistics.pointer("/error/error").and_then(serde_json::Value::as_f64);
        let error = error.map_or("no error estimate".to_owned(), |error| format!("error {}", percent_text(error)));
        write!(
            page,
            "\n### {}\n\n![{}]({})\n\n{}\n\n```sh\n{}\n```\n\n[{}](../{}): {} × {}, {}, {error}, {photons}, {:.0} s, {:.0} s of the processor.\n",
            entry.title,
            entry.title,
            entry.picture().strip_prefix("docs")?.display(),
            entry.text,
            entry.command(),
            entry.scene,
            entry.scene,
            number("/width"),
            number("/height"),
            passes,
            number("/seconds/render") + number("/seconds/setup"),
            number("/cpu_seconds"),
        )?;
    }
    Ok(page)
}
