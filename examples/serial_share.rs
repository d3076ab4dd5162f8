//! Serial share of a render by phase, and the limit of its speed-up by Amdahl's law:
//!
//! ```sh
//! cargo run --release --example serial_share -- [--size WxH] [--passes N] [SCENE …]
//! ```
//!
//! A scene is the name of a file in `scenes/`, without `.txt`. The main thread is no member of the
//! thread pool, so that its processor time is that of all code outside of parallel loops. The
//! processor time of the process is the whole work. Both are independent of other load. The serial
//! part inside a parallel loop, such as its longest task, does not count.

use caustica::format::SceneFile;
use caustica::integrate::{Algorithm, PassStage, ProgressMonitor, Settings};
use caustica::render::RenderResult;
use rustix::time::{ClockId, clock_gettime};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, ThreadId};

/// Scenes of the table.
const SCENES: [&str; 10] =
    ["matte", "ring", "gem", "glass-ball", "pool", "still-life", "fishbowl", "god-rays", "many-lights", "window"];

/// Number of threads of the limit.
const THREADS: f64 = 64.0;

/// Number of passes of the render whose limit is stated. It loads the scene and makes pilots once.
const RENDER_PASSES: f64 = 64.0;

/// Number of error estimates of that render.
const RENDER_ESTIMATES: f64 = 10.0;

/// Phases in the order of the table.
const PHASES: [Phase; 8] = [
    Phase::Load,
    Phase::Pilots,
    Phase::Pass,
    Phase::Photons,
    Phase::Indexing,
    Phase::Camera,
    Phase::Film,
    Phase::Estimate,
];

/// A phase of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    /// Reading and building the scene.
    Load,
    /// Pilots before the first pass.
    Pilots,
    /// Preparation of a pass.
    Pass,
    /// Photon paths.
    Photons,
    /// Photon maps.
    Indexing,
    /// Camera paths.
    Camera,
    /// Sums of picture and error.
    Film,
    /// Error estimate.
    Estimate,
}

/// Processor time of the main thread and of the process \[s].
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    serial: f64,
    total: f64,
}

/// Times by phase.
struct Stopwatch {
    main: ThreadId,
    state: Mutex<State>,
}

struct State {
    phase: Phase,
    since: Times,
    sums: BTreeMap<Phase, Times>,
}

/// Returns the processor times so far.
fn now() -> Times {
    let seconds = |clock| {
        let time = clock_gettime(clock);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    };
    Times { serial: seconds(ClockId::ThreadCPUTime), total: seconds(ClockId::ProcessCPUTime) }
}

impl Stopwatch {
    fn new() -> Self {
        let state = State { phase: Phase::Load, since: now(), sums: BTreeMap::new() };
        Self { main: thread::current().id(), state: Mutex::new(state) }
    }

    /// Ends the current phase and begins another. Other threads than the main one change nothing.
    fn enter(&self, phase: Phase) {
        if thread::current().id() != self.main {
            return;
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (time, since, ended) = (now(), state.since, state.phase);
        let sum = state.sums.entry(ended).or_default();
        sum.serial += time.serial - since.serial;
        sum.total += time.total - since.total;
        (state.phase, state.since) = (phase, time);
    }

    /// Returns the times of a phase.
    fn times(&self, phase: Phase) -> Times {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).sums.get(&phase).copied().unwrap_or_default()
    }
}

impl ProgressMonitor for Stopwatch {
    fn begin_stage(&self, stage: PassStage, _: u64) {
        self.enter(match stage {
            PassStage::Photons => Phase::Photons,
            PassStage::Indexing => Phase::Indexing,
            PassStage::Camera => Phase::Camera,
        });
    }

    fn report_progress(&self, _: u64) {}
}

/// Renders a scene, and returns the times of its phases.
fn measure(name: &str, size: (u32, u32), passes: u32) -> Result<Stopwatch, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.txt"));
    let stopwatch = Stopwatch::new();
    let mut file = SceneFile::read(&path)?;
    (file.description.camera.value.width, file.description.camera.value.height) = size;
    let scene = file.resolve()?;
    stopwatch.enter(Phase::Pilots);
    let mut settings = Settings::default();
    settings.camera_paths.estimate_error = true;
    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
    let mut rendered = RenderResult::without_passes(integrator.as_ref(), size);
    for number in 0..passes {
        stopwatch.enter(Phase::Pass);
        let pass = integrator.render_pass(number, &stopwatch);
        stopwatch.enter(Phase::Film);
        rendered.estimator.iter_mut().for_each(|estimator| estimator.add(number, &pass));
        rendered.film.add(&pass.image);
    }
    stopwatch.enter(Phase::Estimate);
    std::hint::black_box(rendered.estimate_error(None));
    stopwatch.enter(Phase::Load);
    Ok(stopwatch)
}

/// Prints one row of the table.
fn print_row(name: &str, stopwatch: &Stopwatch, passes: u32) {
    let per_pass = RENDER_PASSES / f64::from(passes);
    let mut render = Times::default();
    let mut cells = Vec::new();
    for phase in PHASES {
        let Times { serial, total } = stopwatch.times(phase);
        let (count, divisor) = match phase {
            Phase::Load | Phase::Pilots => (1.0, 1.0),
            Phase::Pass | Phase::Photons | Phase::Indexing | Phase::Camera | Phase::Film => {
                (per_pass, f64::from(passes))
            }
            Phase::Estimate => (RENDER_ESTIMATES, 1.0),
        };
        render.serial += count * serial;
        render.total += count * total;
        cells.push(format!("{:.1} of {:.0}", 1e3 * serial / divisor, 1e3 * total / divisor));
    }
    let share = render.serial / render.total;
    let limit = 1.0 / (share + (1.0 - share) / THREADS);
    println!("| `{name}` | {} | {:.2} % | {limit:.0} |", cells.join(" | "), 100.0 * share);
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut size, mut passes, mut scenes) = ((320, 240), 4, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--size" => {
                let value = words.next().unwrap_or_default();
                let (width, height) = value.split_once('x').ok_or("write --size 320x240")?;
                size = (width.parse()?, height.parse()?);
            }
            "--passes" => passes = words.next().unwrap_or_default().parse::<u32>()?.max(4),
            name => scenes.push(name.to_owned()),
        }
    }
    if scenes.is_empty() {
        scenes = SCENES.map(str::to_owned).to_vec();
    }
    rayon::ThreadPoolBuilder::new().build_global()?;
    let head = ["load", "pilots", "pass", "photons", "indexing", "camera", "film", "estimate"];
    println!("| scene | {} | serial share | limit |", head.join(" | "));
    println!("|{}", " --- |".repeat(head.len() + 3));
    for name in &scenes {
        print_row(name, &measure(name, size, passes)?, passes);
    }
    Ok(())
}
