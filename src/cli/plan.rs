//! `caustica plan`.

use super::args::PlanArguments;
use super::progress::{Progress, tell};
use super::scene::{in_pool, load};
use super::settings::settings;
use super::{Exit, Failure};
use crate::integrate::{Algorithm, Balance, Integrator};
use crate::plan::{Decision, Effect, Plan, SceneFeatures};
use crate::study::text::{amount, signed};
use crate::study::{ExpectedWork, Work, expected_work};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;

pub(super) fn run(arguments: &PlanArguments) -> Result<Exit, Failure> {
    in_pool(&arguments.scene, || {
        let scene = load(&arguments.scene, &())?;
        let algorithm = arguments.method.integrator;
        let settings = settings(&arguments.method, arguments.effects.effects);
        let integrator = algorithm.prepare(&scene, settings);
        let (plan, balance) = (integrator.plan(), integrator.balance());
        let work = expected_work(integrator.as_ref());
        let text = if arguments.json {
            let report = Report::new(arguments.scene.scene.display().to_string(), algorithm, plan, balance, &work);
            let json = serde_json::to_string_pretty(&report);
            json.into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))? + "\n"
        } else {
            table(algorithm, plan, balance, &work)
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
        Ok(Exit::Success)
    })
}

/// The plan in a line.
pub(super) fn line(plan: &Plan) -> String {
    let names = |wanted: fn(&Decision) -> bool| {
        let names: Vec<&str> = plan.decisions.iter().filter(|d| wanted(d)).map(|d| d.effect.name()).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
    };
    format!("plan: {}; without {}", names(|d| d.on), names(|d| !d.on))
}

/// Says what will be simulated and how a pass divides its work, and warns of wishes that do harm.
pub(super) fn announce(integrator: &dyn Integrator, progress: &Progress) {
    progress.say(&line(integrator.plan()));
    integrator.balance().iter().for_each(|balance| progress.say(&balance_line(balance)));
    complaints(integrator.plan()).for_each(|line| tell(&line));
    if integrator.plan().effects().has(Effect::Caustics) && integrator.radius_law().is_none() {
        tell(BY_CHANCE);
    }
}

/// Of an algorithm without photons where there are caustics.
const BY_CHANCE: &str = "warning: light that comes by way of glass and mirrors is found by chance, of small lights rarely and of points never; \
    what was not found is in no error that is told: hybrid and sppm find it by photons";

/// How a pass divides its work, in a line.
fn balance_line(balance: &Balance) -> String {
    let Balance { samples, photons, caustic_photons } = balance;
    let mut line = format!("a pass: {}", counted(*samples as usize, "camera ray a pixel", "camera rays a pixel"));
    for (n, which) in [(photons, "photon paths"), (caustic_photons, "photon paths aimed at casters")] {
        if let Some(n) = n {
            let _ = write!(line, ", {n} {which}");
        }
    }
    line
}

/// A number with its unit.
pub(super) fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// What wishes do to a picture, a line each.
pub(super) fn complaints(plan: &Plan) -> impl Iterator<Item = String> {
    let lacking = plan.decisions.iter().filter(|d| d.called_for && !d.on);
    lacking.map(|d| format!("warning: without {}: {}", d.effect, d.effect.lack()))
}

fn table(algorithm: Algorithm, plan: &Plan, balance: Option<Balance>, work: &ExpectedWork) -> String {
    let mut text = format!("{} simulates\n", algorithm.name());
    for decision in &plan.decisions {
        let state = match (decision.on, decision.is_forced()) {
            (true, false) => "on",
            (true, true) => "on, as wished",
            (false, false) => "off",
            (false, true) => "off, as wished",
        };
        let costs = work.of(decision.effect).map_or(String::new(), |w| in_words(w, signed));
        let line = format!("  {:<16} {state:<14} {costs:<29} {}", decision.effect, decision.reason);
        let _ = writeln!(text, "{line}");
    }
    balance.iter().for_each(|balance| text += &format!("{}\n", balance_line(balance)));
    let _ = writeln!(text, "in all about {} a pass", in_words(work.whole, amount));
    complaints(plan).for_each(|line| text += &format!("{line}\n"));
    text
}

/// Work in words: `+1.9 M rays, +3.0 M gathered`.
fn in_words(work: Work, number: fn(f64) -> String) -> String {
    let Work { rays, gathered_photons } = work;
    match (rays, gathered_photons) {
        (0, 0) => "nothing".to_owned(),
        (rays, 0) => format!("{} rays", number(rays as f64)),
        (0, photons) => format!("{} gathered photons", number(photons as f64)),
        (rays, photons) => format!("{} rays, {} gathered", number(rays as f64), number(photons as f64)),
    }
}

#[derive(Debug, Serialize)]
struct Report {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    facts: SceneFeatures,
    /// Of the first pass.
    rays: i64,
    gathered_photons: i64,
    balance: Option<Balance>,
    effects: Vec<CostedEffect>,
}

#[derive(Debug, Serialize)]
struct CostedEffect {
    #[serde(flatten)]
    effect: EffectReport,
    /// What it adds to the first pass; `None` where it is not simulated.
    rays: Option<i64>,
    gathered_photons: Option<i64>,
}

#[derive(Debug, Serialize)]
pub(super) struct EffectReport {
    effect: &'static str,
    on: bool,
    called_for: bool,
    reason: String,
    /// What is wrong with the picture without it; `None` where nothing is.
    lack: Option<&'static str>,
}

/// The decisions as JSON holds them.
pub(super) fn effects(plan: &Plan) -> Vec<EffectReport> {
    let report = |d: &Decision| EffectReport {
        effect: d.effect.name(),
        on: d.on,
        called_for: d.called_for,
        reason: d.reason.to_string(),
        lack: (d.called_for && !d.on).then(|| d.effect.lack()),
    };
    plan.decisions.iter().map(report).collect()
}

impl Report {
    fn new(scene: String, algorithm: Algorithm, plan: &Plan, balance: Option<Balance>, work: &ExpectedWork) -> Self {
        let costed = |(report, decision): (EffectReport, &Decision)| {
            let work = work.of(decision.effect);
            CostedEffect {
                effect: report,
                rays: work.map(|w| w.rays),
                gathered_photons: work.map(|w| w.gathered_photons),
            }
        };
        Self {
            schema: 1,
            version: env!("CARGO_PKG_VERSION"),
            scene,
            integrator: algorithm.name(),
            facts: plan.facts,
            balance,
            rays: work.whole.rays,
            gathered_photons: work.whole.gathered_photons,
            effects: effects(plan).into_iter().zip(&plan.decisions).map(costed).collect(),
        }
    }
}
