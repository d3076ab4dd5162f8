//! Serial share of a render by phase, and the limit of its speed-up by Amdahl's law:
//!
//! ```sh
//! cargo run --release --example serial_share -- [--size WxH] [--passes N] [SCENE …]
//! ```
//!
//! A scene is the name of a file in `scenes/` or `tests/scenes/`, without `.txt`.
//!
//! The main thread is no member of the thread pool, so that its processor time is that of all code
//! outside of parallel loops. The processor time of the process is the whole work. Other load
//! changes neither. The serial part inside a parallel loop, such as its longest task, does not
//! count.

use caustica::format::SceneFile;
use caustica::integrate::{Algorithm, PassStage, ProgressMonitor, Settings};
use caustica::render::RenderResult;
use caustica::render::error_estimate::{EstimateSchedule, MIN_ERROR_ESTIMATE_PASSES};
use rustix::time::{ClockId, clock_gettime};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, ThreadId};

/// Scenes of the table.
const SCENES: [&str; 8] = ["cbox-caustic", "ring", "gem", "pool", "goblet", "fishbowl", "god-rays", "many-lights"];

/// Number of threads of the limit.
const THREADS: f64 = 64.0;

/// Number of passes of the render whose limit is stated. It loads the scene and makes pilots once.
const RENDER_PASSES: u32 = 64;

/// Number of error estimates that are timed.
const TIMED_ESTIMATES: u32 = 4;

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

impl Times {
    /// Adds `count` times the given times \[s].
    fn add(&mut self, count: u32, serial: f64, total: f64) {
        self.serial += f64::from(count) * serial;
        self.total += f64::from(count) * total;
    }
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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let paths = ["scenes", "tests/scenes"].map(|scenes| folder.join(scenes).join(format!("{name}.txt")));
    let path = paths.iter().find(|path| path.exists()).ok_or_else(|| format!("there is no scene {name}"))?;
    let stopwatch = Stopwatch::new();
    let mut file = SceneFile::read(path)?;
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
    (0..TIMED_ESTIMATES).for_each(|_| _ = std::hint::black_box(rendered.estimate_error(None)));
    stopwatch.enter(Phase::Load);
    Ok(stopwatch)
}

/// Returns the number of error estimates of a render of [`RENDER_PASSES`] passes.
fn render_estimates() -> u32 {
    let due = EstimateSchedule::due_passes().take_while(|passes| *passes <= RENDER_PASSES);
    due.filter(|passes| *passes >= MIN_ERROR_ESTIMATE_PASSES).count() as u32
}

/// Returns the limit of the speed-up on [`THREADS`] threads, and the serial share of the work.
fn speedup_limit(Times { serial, total }: Times) -> (f64, f64) {
    let share = serial / total;
    (1.0 / (share + (1.0 - share) / THREADS), share)
}

/// Prints one row of the table. `passes` is the number of measured passes.
fn print_row(name: &str, stopwatch: &Stopwatch, passes: u32) {
    let (mut render, mut passes_alone) = (Times::default(), Times::default());
    let mut cells = Vec::new();
    for phase in PHASES {
        let Times { serial, total } = stopwatch.times(phase);
        // Number of times that the render has the phase, and number of times that it was measured.
        let (count, measured) = match phase {
            Phase::Load | Phase::Pilots => (1, 1),
            Phase::Pass | Phase::Photons | Phase::Indexing | Phase::Camera | Phase::Film => (RENDER_PASSES, passes),
            Phase::Estimate => (render_estimates(), TIMED_ESTIMATES),
        };
        let [serial, total] = [serial, total].map(|seconds| seconds / f64::from(measured));
        render.add(count, serial, total);
        if !matches!(phase, Phase::Load | Phase::Pilots) {
            passes_alone.add(count, serial, total);
        }
        cells.push(format!("{:.1} of {:.0}", 1e3 * serial, 1e3 * total));
    }
    let [(limit, share), (limit_of_passes, _)] = [render, passes_alone].map(speedup_limit);
    println!("| `{name}` | {} | {:.2} % | {limit:.0} | {limit_of_passes:.0} |", cells.join(" | "), 100.0 * share);
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut size, mut passes, mut scenes) = ((480, 360), 4, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--size" => {
                let value = words.next().unwrap_or_default();
                let (width, height) = value.split_once('x').ok_or("write --size 480x360")?;
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
    println!("| scene | {} | serial share | limit | limit of the passes |", head.join(" | "));
    println!("|{}", " --- |".repeat(head.len() + 4));
    for name in &scenes {
        print_row(name, &measure(name, size, passes)?, passes);
    }
    Ok(())
}
