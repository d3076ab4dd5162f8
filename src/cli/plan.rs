//! `caustica plan`, and the lines about a plan that other commands print.

use super::args::PlanArguments;
use super::progress::{Progress, print_message};
use super::scene::{in_pool, load};
use super::settings::settings;
use super::{Exit, Failure};
use crate::integrate::{Algorithm, Balance, Integrator};
use crate::plan::{Decision, Effect, Plan, SceneFeatures};
use crate::study::text::{count_text, signed_count_text};
use crate::study::{ExpectedWork, WorkCounts, expected_work};
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
            json.map_err(Failure::output)? + "\n"
        } else {
            plan_table(algorithm, plan, balance, &work)
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.map_err(Failure::output)?;
        Ok(Exit::Success)
    })
}

/// The simulated and the omitted effects in a line.
pub(super) fn effects_line(plan: &Plan) -> String {
    let names = |keep: fn(&Decision) -> bool| {
        let names: Vec<&str> = plan.decisions.iter().filter(|d| keep(d)).map(|d| d.effect.name()).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
    };
    format!("plan: {}; without {}", names(|d| d.on), names(|d| !d.on))
}

/// Prints the plan and the work of a pass, and warns of omitted effects that the scene needs.
pub(super) fn announce_plan(integrator: &dyn Integrator, progress: &Progress) {
    progress.say(&effects_line(integrator.plan()));
    integrator.balance().iter().for_each(|balance| progress.say(&balance_line(balance)));
    omission_warnings(integrator.plan()).for_each(|line| print_message(&line));
    if integrator.plan().simulated_effects().has(Effect::Caustics) && integrator.radius_law().is_none() {
        print_message(UNSAMPLED_CAUSTICS);
    }
}

/// Warning of an algorithm without photons in a scene with caustics.
const UNSAMPLED_CAUSTICS: &str = "warning: this method finds caustics only by chance: of small lights rarely, of point lights never. \
    The estimated error does not include what it misses. hybrid and sppm find caustics by photons";

/// The numbers of camera rays and photon paths of a pass, in a line.
fn balance_line(balance: &Balance) -> String {
    let Balance { samples, photons, caustic_photons } = balance;
    let mut line =
        format!("each pass: {}", count_with_noun(*samples as usize, "camera ray per pixel", "camera rays per pixel"));
    for (n, which) in [(photons, "photon paths"), (caustic_photons, "photon paths aimed at specular objects")] {
        if let Some(n) = n {
            let _ = write!(line, ", {n} {which}");
        }
    }
    line
}

/// A count with its noun in the singular or plural.
pub(super) fn count_with_noun(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A warning for each effect that the scene needs and the plan omits.
pub(super) fn omission_warnings(plan: &Plan) -> impl Iterator<Item = String> {
    let lacking = plan.decisions.iter().filter(|d| d.needed && !d.on);
    lacking.map(|d| format!("warning: without {}: {}", d.effect, d.effect.symptom_if_missing()))
}

fn plan_table(algorithm: Algorithm, plan: &Plan, balance: Option<Balance>, work: &ExpectedWork) -> String {
    let mut text = format!("{} simulates\n", algorithm.name());
    for decision in &plan.decisions {
        let state = match (decision.on, decision.is_forced()) {
            (true, false) => "on",
            (true, true) => "on, forced",
            (false, false) => "off",
            (false, true) => "off, forced",
        };
        let costs = work.added_by(decision.effect).map_or(String::new(), |w| work_text(w, signed_count_text));
        let line = format!("  {:<16} {state:<14} {costs:<29} {}", decision.effect, decision.reason);
        let _ = writeln!(text, "{line}");
    }
    balance.iter().for_each(|balance| text += &format!("{}\n", balance_line(balance)));
    let _ = writeln!(text, "total about {} per pass", work_text(work.whole, count_text));
    omission_warnings(plan).for_each(|line| text += &format!("{line}\n"));
    text
}

/// Work as text: `+1.9 M rays, +3.0 M gathered`.
fn work_text(work: WorkCounts, number: fn(f64) -> String) -> String {
    let WorkCounts { rays, gathered_photons } = work;
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
    features: SceneFeatures,
    /// Expected rays of the first pass.
    rays: i64,
    /// Expected photons in density estimates of the first pass.
    gathered_photons: i64,
    balance: Option<Balance>,
    effects: Vec<CostedEffect>,
}

#[derive(Debug, Serialize)]
struct CostedEffect {
    #[serde(flatten)]
    effect: EffectReport,
    /// Expected rays that the effect adds to the first pass; `None` if it is not simulated.
    rays: Option<i64>,
    /// Expected photons in density estimates that it adds; `None` if it is not simulated.
    gathered_photons: Option<i64>,
}

#[derive(Debug, Serialize)]
pub(super) struct EffectReport {
    effect: &'static str,
    on: bool,
    /// True if the scene needs the effect.
    needed: bool,
    reason: String,
    /// Flaw of the picture without the effect; `None` if there is none.
    flaw: Option<&'static str>,
}

/// The decisions of a plan as they stand in JSON.
pub(super) fn effect_reports(plan: &Plan) -> Vec<EffectReport> {
    let report = |d: &Decision| EffectReport {
        effect: d.effect.name(),
        on: d.on,
        needed: d.needed,
        reason: d.reason.to_string(),
        flaw: (d.needed && !d.on).then(|| d.effect.symptom_if_missing()),
    };
    plan.decisions.iter().map(report).collect()
}

impl Report {
    fn new(scene: String, algorithm: Algorithm, plan: &Plan, balance: Option<Balance>, work: &ExpectedWork) -> Self {
        let costed = |(report, decision): (EffectReport, &Decision)| {
            let work = work.added_by(decision.effect);
            CostedEffect {
                effect: report,
                rays: work.map(|w| w.rays),
                gathered_photons: work.map(|w| w.gathered_photons),
            }
        };
        Self {
            schema: 2,
            version: env!("CARGO_PKG_VERSION"),
            scene,
            integrator: algorithm.name(),
            features: plan.features,
            balance,
            rays: work.whole.rays,
            gathered_photons: work.whole.gathered_photons,
            effects: effect_reports(plan).into_iter().zip(&plan.decisions).map(costed).collect(),
        }
    }
}
