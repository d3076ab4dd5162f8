//! Arguments of the command line.

use caustica::integrate::{IndirectPhotons, LightTracing, Settings};
use std::error::Error;
use std::path::PathBuf;

pub struct Arguments {
    /// The measurement: `foci` or `outliers`.
    pub measurement: String,
    /// Names of foci or scenes; empty for all.
    pub names: Vec<String>,
    pub passes: Option<Vec<u32>>,
    pub seeds: Option<u64>,
    /// Number of passes of a reference.
    pub truth: Option<u32>,
    /// Photon paths per pass that start in all directions.
    pub photons: Option<u32>,
    /// Width and height of the picture.
    pub size: (u32, u32),
    /// Folder for the pictures of each scene.
    pub pictures: Option<PathBuf>,
    without: Vec<String>,
}

impl Arguments {
    pub fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut arguments = Self {
            measurement: words.next().ok_or("name a measurement: foci or outliers")?,
            names: Vec::new(),
            passes: None,
            seeds: None,
            truth: None,
            photons: None,
            size: (64, 48),
            pictures: None,
            without: Vec::new(),
        };
        while let Some(word) = words.next() {
            if !word.starts_with("--") {
                arguments.names.push(word);
                continue;
            }
            let value = words.next().ok_or(format!("{word} needs a value"))?;
            match word.as_str() {
                "--passes" => arguments.passes = Some(value.split(',').map(str::parse).collect::<Result<_, _>>()?),
                "--seeds" => arguments.seeds = Some(value.parse()?),
                "--truth" => arguments.truth = Some(value.parse()?),
                "--photons" => arguments.photons = Some(value.parse()?),
                "--size" => {
                    let (width, height) = value.split_once('x').ok_or("a size is WxH")?;
                    arguments.size = (width.parse()?, height.parse()?);
                }
                "--pictures" => arguments.pictures = Some(value.into()),
                "--without" => arguments.without = value.split(',').map(str::to_owned).collect(),
                _ => return Err(format!("{word} is no option").into()),
            }
        }
        arguments.turn_off(&mut Settings::default())?;
        Ok(arguments)
    }

    /// Turns off the techniques that `--without` names.
    pub fn turn_off(&self, settings: &mut Settings) -> Result<(), String> {
        for technique in &self.without {
            match technique.as_str() {
                "light-tracing" => settings.light_tracing = LightTracing::Off,
                "prefix-rays" => settings.allows_prefix_rays = false,
                "indirect-photons" => settings.indirect_photons = IndirectPhotons::Off,
                _ => return Err(format!("`{technique}` cannot be turned off")),
            }
        }
        Ok(())
    }
}
