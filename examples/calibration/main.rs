//! Calibration of error estimates, error targets and forecasts against true errors and real ends.
//!
//! ```sh
//! cargo run --release --example calibration -- [SCENE …] [--random N] [--methods M,…]
//!     [--passes N] [--seeds N] [--photons N] [--size WxH] [--truth PASSES] [--print-scene SEED]
//! ```
//!
//! A scene is the name of a file in `scenes/`, without `.txt`. `--random` adds the scenes of the
//! seeds 0 to N − 1, see [`random_scenes`]. Each scene, method and seed is rendered once, with
//! `--passes` passes. Three tables come from the error estimates along the way:
//!
//! 1. estimated over true error, and how many 90 % intervals contain the true error;
//! 2. how many renders that end by `--target-error` have reached it;
//! 3. forecasts after 8, 16 and 32 passes, against the pass that ends the render.
//!
//! `--truth 0` leaves out the true errors and with them the first two tables.

mod estimates;
mod forecasts;
mod random_scenes;
mod scenes;
mod targets;
mod trace;

use caustica::integrate::Algorithm;
use caustica::plan::{EffectOverrides, Plan};
use caustica::scene::Effect;
use scenes::{TestScene, Truth};
use std::error::Error;
use trace::Trace;

const SCENES: [&str; 6] = ["matte", "ball-lens", "ring", "many-lights", "mirror-caustic", "frosted"];

struct Arguments {
    scenes: Vec<String>,
    random: u64,
    methods: Vec<Algorithm>,
    passes: u32,
    seeds: u64,
    photons: u32,
    size: (u32, u32),
    truth: u32,
}

impl Arguments {
    /// Reads the command line; `None` if it only asked for the text of a random scene.
    fn read() -> Result<Option<Self>, Box<dyn Error>> {
        let method = |name: &str| Algorithm::ALL.into_iter().find(|a| a.name() == name).ok_or("no such method");
        let methods = |text: &str| text.split(',').map(method).collect::<Result<Vec<_>, _>>();
        let mut arguments = Self {
            scenes: Vec::new(),
            random: 0,
            methods: methods("path,hybrid,sppm,ppm,pm")?,
            passes: 16,
            seeds: 8,
            photons: 20_000,
            size: (80, 60),
            truth: 120,
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--random" => arguments.random = value()?.parse()?,
                "--methods" => arguments.methods = methods(&value()?)?,
                "--passes" => arguments.passes = value()?.parse()?,
                "--seeds" => arguments.seeds = value()?.parse()?,
                "--photons" => arguments.photons = value()?.parse()?,
                "--truth" => arguments.truth = value()?.parse()?,
                "--size" => {
                    let size = value()?;
                    let (width, height) = size.split_once('x').ok_or("a size is WxH")?;
                    arguments.size = (width.parse()?, height.parse()?);
                }
                "--print-scene" => {
                    print!("{}", random_scenes::text(value()?.parse()?));
                    return Ok(None);
                }
                _ => arguments.scenes.push(word),
            }
        }
        if arguments.scenes.is_empty() && arguments.random == 0 {
            arguments.scenes = SCENES.map(str::to_owned).to_vec();
        }
        Ok(Some(arguments))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(arguments) = Arguments::read()? else { return Ok(()) };
    let mut traces = Vec::new();
    let names = arguments.scenes.iter().map(|name| TestScene::from_file(name, arguments.size));
    let random = (0..arguments.random).map(|seed| TestScene::random(seed, arguments.size));
    for scene in names.chain(random) {
        let TestScene { name, scene } = scene?;
        let settings = scenes::settings(arguments.photons);
        let truth = (arguments.truth > 0).then(|| Truth::render(&scene, &settings, arguments.size, arguments.truth));
        if let Some(truth) = &truth {
            eprintln!("{name}: references known to {:.2} % but for their bias", 100.0 * truth.uncertainty);
        }
        for algorithm in arguments.methods.iter().copied() {
            let wanted =
                Plan::new(&scene, algorithm.supported_effects(), EffectOverrides::NO_OVERRIDES).simulated_effects();
            // `path` finds caustics rarely, and its passes cannot know what they miss.
            if algorithm == Algorithm::Path && wanted.has(Effect::Caustics) {
                continue;
            }
            for seed in 0..arguments.seeds {
                let mut settings = settings.clone();
                settings.camera_paths.seed = seed;
                let integrator = algorithm.prepare(&scene, settings);
                let trace = Trace::render(&name, algorithm, integrator.as_ref(), arguments.size, arguments.passes);
                traces.push(trace.with_true_errors(truth.as_ref()));
            }
        }
    }
    if arguments.truth > 0 {
        estimates::print(&traces);
        targets::print(&traces);
    }
    forecasts::print(&traces);
    Ok(())
}
