//! `caustica plan`: shows the effects of light that a scene needs. Also texts about a plan for
//! other commands.

use super::args::PlanArguments;
use super::progress::{ProgressDisplay, print_message};
use super::scene::{load_scene, with_thread_pool};
use super::settings::settings_from_arguments;
use super::value_parsers::count_with_noun;
use super::{CommandFailure, Exit};
use crate::integrate::{Algorithm, EnvironmentGuidingReport, Integrator, RayPhotonBalance, ScatterPointGuidingReport};
use crate::plan::{EffectDecision, Plan, SceneFeatures};
use crate::scene::Effect;
use crate::study::text::{count_text, percent_text, signed_count_text};
use crate::study::{ExpectedWork, WorkCounts, expected_work};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;

pub(super) fn run(arguments: &PlanArguments) -> Result<Exit, CommandFailure> {
    with_thread_pool(&arguments.scene, || {
        let scene = load_scene(&arguments.scene, &())?;
        let algorithm = arguments.method.integrator;
        let settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        let integrator = algorithm.prepare(&scene, settings);
        let work = expected_work(integrator.as_ref());
        let text = if arguments.json {
            let report = PlanCommandReport::new(
                arguments.scene.scene.display().to_string(),
                algorithm,
                integrator.as_ref(),
                &work,
            );
            let json = serde_json::to_string_pretty(&report);
            json.map_err(CommandFailure::output_error)? + "\n"
        } else {
            plan_table(algorithm, integrator.as_ref(), &work)
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.map_err(CommandFailure::output_error)?;
        Ok(Exit::Success)
    })
}

/// Returns a line that lists the simulated and the omitted effects, such as
/// `plan: shadows, specular; without caustics, lens`.
pub(super) fn simulated_effects_line(plan: &Plan) -> String {
    let names = |keep: fn(&EffectDecision) -> bool| {
        let names: Vec<&str> = plan.decisions.iter().filter(|d| keep(d)).map(|d| d.effect.name()).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
    };
    format!("plan: {}; without {}", names(|d| d.is_simulated), names(|d| !d.is_simulated))
}

/// Prints the plan, and the numbers of rays and photons of a pass. Warns of needed effects and of
/// light from media that `integrator` omits. Also warns of caustics that it finds only by chance.
pub(super) fn print_plan(integrator: &dyn Integrator, progress: &ProgressDisplay) {
    progress.print_line(&simulated_effects_line(integrator.plan()));
    pass_work_lines(integrator).iter().for_each(|line| progress.print_line(line));
    omitted_effect_warnings(integrator.plan()).for_each(|line| print_message(&line));
    if finds_caustics_only_by_chance(integrator) {
        print_message(UNSAMPLED_CAUSTICS_WARNING);
    }
    if integrator.omits_light_from_media() {
        print_message(OMITTED_MEDIUM_LIGHT_WARNING);
    }
}

/// True if the render simulates caustics, but `integrator` traces no photons. Camera paths then
/// find caustics only by chance.
///
/// The estimated error of the picture leaves out the caustics that no camera path hit.
pub(super) fn finds_caustics_only_by_chance(integrator: &dyn Integrator) -> bool {
    integrator.plan().simulated_effects().has(Effect::Caustics) && integrator.radius_law().is_none()
}

/// Returns lines about a pass: its numbers of rays and photons, the fraction of indirect light that
/// comes from photon estimates, and the gains of guiding shadow rays.
pub(super) fn pass_work_lines(integrator: &dyn Integrator) -> Vec<String> {
    let counts = integrator.ray_photon_balance().map(|balance| pass_counts_line(&balance));
    let prefix_rays = prefix_rays_line(integrator.prefix_rays_per_pixel());
    let guiding = [environment_guiding_line(integrator), scatter_point_guiding_line(integrator)];
    let lines = [counts, prefix_rays, indirect_photons_line(integrator)].into_iter().chain(guiding);
    lines.flatten().collect()
}

/// Warning for a scene with caustics if the algorithm traces no photons.
const UNSAMPLED_CAUSTICS_WARNING: &str = "warning: this method finds caustics only by chance: of small lights rarely, of point lights never. \
    The estimated error does not include what it misses. hybrid and sppm find caustics by photons";

/// Warning for a scene with emitting media if the light of media does not reach surfaces in this
/// algorithm.
const OMITTED_MEDIUM_LIGHT_WARNING: &str = "warning: with this method, media that emit light are seen but light nothing. \
    hybrid, path and pm with gather rays find their light";

/// Returns a line with the numbers of camera rays and photon paths of a pass.
fn pass_counts_line(balance: &RayPhotonBalance) -> String {
    let RayPhotonBalance { samples_per_pixel: samples, unaimed_paths: photons, aimed_paths: caustic_photons } = balance;
    let mut line =
        format!("each pass: {}", count_with_noun(*samples as usize, "camera ray per pixel", "camera rays per pixel"));
    for (n, which) in [(photons, "photon paths"), (caustic_photons, "photon paths aimed at specular objects")] {
        if let Some(n) = n {
            let _ = write!(line, ", {n} {which}");
        }
    }
    line
}

/// Returns a line with `mean`, the mean number of prefix rays per pixel. Returns `None` if `mean`
/// is 0.
///
/// Prefix rays are extra camera rays that end at the first surface that stores photons.
fn prefix_rays_line(mean: f64) -> Option<String> {
    let reason = "for highlights and caustics seen through glass";
    (mean > 0.0).then(|| format!("and {mean:.2} rays per pixel up to the first diffuse surface, {reason}"))
}

/// Returns a line with the fraction of indirect light that comes from photon estimates, in pass 1
/// and in pass 100. Returns `None` if this fraction is 0 in pass 1.
///
/// Here, indirect light excludes the indirect light of caustics, which photons always carry in
/// `hybrid`.
fn indirect_photons_line(integrator: &dyn Integrator) -> Option<String> {
    let percent = |pass| (100.0 * integrator.interreflection_photon_weight(pass)).round();
    let (first, later) = (percent(0), percent(99));
    let text = format!("photon estimates carry {first} % of the indirect light in pass 1, {later} % in pass 100");
    (integrator.interreflection_photon_weight(0) > 0.0).then_some(text)
}

/// Returns a line with the gain of guiding shadow rays to the environment light: the factor by
/// which the second moment of their contributions falls. Guided rays go where a pilot (simulation
/// before the first pass) found unblocked light. `None` if no ray is guided.
fn environment_guiding_line(integrator: &dyn Integrator) -> Option<String> {
    let report = integrator.environment_guiding_report().filter(|report| report.used)?;
    let percent = percent_text(report.contributing_fraction);
    Some(format!(
        "shadow rays to the environment are guided: {percent} of unguided ones reach it, guided ones have {:.1} times \
         less variance",
        report.variance_gain
    ))
}

/// Returns a line with the gain of guiding scattering points, the points in fog from which shadow
/// rays start. Guided points lie where direct light arrives. The gain is the factor by which
/// variance times work of camera paths falls. `None` if passes do not guide these points.
fn scatter_point_guiding_line(integrator: &dyn Integrator) -> Option<String> {
    let report = integrator.scatter_point_guiding_report().filter(|report| report.used)?;
    Some(format!(
        "shadow rays from fog start in its lit parts: camera paths have {:.1} times less variance for the same work",
        report.efficiency_gain
    ))
}

/// Returns a warning for each effect that the scene needs but the plan omits.
pub(super) fn omitted_effect_warnings(plan: &Plan) -> impl Iterator<Item = String> {
    let omitted = plan.decisions.iter().filter(|d| d.is_needed && !d.is_simulated);
    omitted.map(|d| format!("warning: without {}: {}", d.effect, d.effect.symptom_if_missing()))
}

fn plan_table(algorithm: Algorithm, integrator: &dyn Integrator, work: &ExpectedWork) -> String {
    let plan = integrator.plan();
    let mut text = format!("{} simulates\n", algorithm.name());
    for decision in &plan.decisions {
        let state = match (decision.is_simulated, decision.is_forced_against_need()) {
            (true, false) => "on",
            (true, true) => "on, forced",
            (false, false) => "off",
            (false, true) => "off, forced",
        };
        let costs =
            work.work_of_effect(decision.effect).map_or(String::new(), |w| work_counts_text(w, signed_count_text));
        let line = format!("  {:<16} {state:<14} {costs:<29} {}", decision.effect, decision.reason);
        let _ = writeln!(text, "{line}");
    }
    pass_work_lines(integrator).iter().for_each(|line| text += &format!("{line}\n"));
    let _ = writeln!(text, "total about {} per pass", work_counts_text(work.total, count_text));
    omitted_effect_warnings(plan).for_each(|line| text += &format!("{line}\n"));
    text
}

/// Returns work counts as text, such as `+1.9 M rays, +3.0 M gathered`. Gathered photons are those
/// that density estimates sum.
///
/// The callback `number` formats a count.
fn work_counts_text(work: WorkCounts, number: fn(f64) -> String) -> String {
    let WorkCounts { rays, gathered_photons } = work;
    match (rays, gathered_photons) {
        (0, 0) => "nothing".to_owned(),
        (rays, 0) => format!("{} rays", number(rays as f64)),
        (0, photons) => format!("{} gathered photons", number(photons as f64)),
        (rays, photons) => format!("{} rays, {} gathered", number(rays as f64), number(photons as f64)),
    }
}

/// JSON report of `caustica plan`.
#[derive(Debug, Serialize)]
struct PlanCommandReport {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    features: SceneFeatures,
    /// Expected number of rays of the first pass.
    rays: i64,
    /// Expected number of photons that the first pass sums in density estimates.
    gathered_photons: i64,
    balance: Option<RayPhotonBalance>,
    /// Mean number of prefix rays per pixel of a pass. Prefix rays are extra camera rays that end
    /// at the first surface that stores photons.
    prefix_rays_per_pixel: f64,
    /// Fraction in \[0, 1] of indirect light that comes from photon estimates in the first pass.
    /// The rest comes from camera paths.
    indirect_photon_share: f64,
    /// Report of the pilot simulation that finds from which directions environment light reaches
    /// the scene. Passes use these directions to guide shadow rays. `None` if there was no such
    /// pilot.
    environment_guiding: Option<EnvironmentGuidingReport>,
    /// Report of the pilot simulation that finds where in media direct light arrives. Passes use it
    /// to choose the scattering points from which shadow rays start. `None` if there was no such
    /// pilot, or if it found no light.
    scatter_point_guiding: Option<ScatterPointGuidingReport>,
    effects: Vec<EffectCostReport>,
}

/// JSON of one effect: the decision of the plan, and the work that the effect adds to a pass.
#[derive(Debug, Serialize)]
struct EffectCostReport {
    #[serde(flatten)]
    effect_decision: EffectDecisionReport,
    /// Expected number of rays that the effect adds to the first pass; `None` if the effect is off.
    rays: Option<i64>,
    /// Expected number of photons that density estimates of the first pass sum because of the
    /// effect; `None` if the effect is off.
    gathered_photons: Option<i64>,
}

/// JSON of the plan's decision whether to simulate one effect of light, with its reason.
#[derive(Debug, Serialize)]
pub(super) struct EffectDecisionReport {
    effect: &'static str,
    on: bool,
    /// True if the scene needs the effect and the algorithm can simulate it.
    needed: bool,
    reason: String,
    /// Visible flaw of a picture without the effect, if the scene needs the effect but the plan
    /// omits it; else `None`.
    flaw: Option<&'static str>,
}

/// Returns the decisions of a plan about all effects of light, as JSON records.
pub(super) fn plan_effect_reports(plan: &Plan) -> Vec<EffectDecisionReport> {
    let report = |d: &EffectDecision| EffectDecisionReport {
        effect: d.effect.name(),
        on: d.is_simulated,
        needed: d.is_needed,
        reason: d.reason.to_string(),
        flaw: (d.is_needed && !d.is_simulated).then(|| d.effect.symptom_if_missing()),
    };
    plan.decisions.iter().map(report).collect()
}

impl PlanCommandReport {
    fn new(scene: String, algorithm: Algorithm, integrator: &dyn Integrator, work: &ExpectedWork) -> Self {
        let plan = integrator.plan();
        let cost_report = |(report, decision): (EffectDecisionReport, &EffectDecision)| {
            let work = work.work_of_effect(decision.effect);
            EffectCostReport {
                effect_decision: report,
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
            balance: integrator.ray_photon_balance(),
            prefix_rays_per_pixel: integrator.prefix_rays_per_pixel(),
            indirect_photon_share: integrator.interreflection_photon_weight(0),
            environment_guiding: integrator.environment_guiding_report(),
            scatter_point_guiding: integrator.scatter_point_guiding_report(),
            rays: work.total.rays,
            gathered_photons: work.total.gathered_photons,
            effects: plan_effect_reports(plan).into_iter().zip(&plan.decisions).map(cost_report).collect(),
        }
    }
}
