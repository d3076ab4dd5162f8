//! CSV and Markdown reports of a study of effects.

use super::{EffectReportHeader, clock_name, percent_of_mean_text};
use crate::study::report::csv_and_markdown::{csv_row, escape_markdown, markdown_table};
use crate::study::report::text::{
    count_text, percent_text, signed_count_text, signed_milliseconds_text, three_digit_text,
};
use crate::study::{EffectResult, EffectStudyResult};

/// Returns the report of a study of effects as CSV, with one row per effect. The row of an effect
/// that is not simulated has no numbers.
///
/// Times are in seconds, radiance in W/(m² sr).
#[must_use]
pub fn csv_report(findings: &EffectStudyResult) -> String {
    let mut table = csv_row(&[
        "effect",
        "on",
        "forced",
        "reason",
        "seconds",
        "seconds_error",
        "ratio",
        "setup",
        "rays",
        "gathers",
        "gathered_photons",
        "rmse",
        "relative_rmse",
        "adds",
        "takes",
    ]);
    for decision in &findings.effect_plan.decisions {
        let result = findings.effects.iter().find(|f| f.decision.effect == decision.effect);
        let number_cell =
            |of: &dyn Fn(&EffectResult) -> Option<f64>| result.and_then(of).map_or(String::new(), |v| v.to_string());
        table += &csv_row(&[
            decision.effect.to_string(),
            decision.is_simulated.to_string(),
            decision.is_forced_against_need().to_string(),
            decision.reason.to_string(),
            number_cell(&|f| Some(f.added_cost.seconds_per_pass)),
            number_cell(&|f| f.added_cost.seconds_standard_error),
            number_cell(&|f| Some(f.added_cost.time_ratio)),
            number_cell(&|f| Some(f.added_cost.setup_seconds)),
            number_cell(&|f| Some(f.added_cost.rays)),
            number_cell(&|f| Some(f.added_cost.gathers)),
            number_cell(&|f| Some(f.added_cost.gathered_photons)),
            number_cell(&|f| Some(f.contribution.rmse)),
            number_cell(&|f| f.contribution.relative_rmse),
            number_cell(&|f| Some(f.contribution.added_radiance)),
            number_cell(&|f| Some(f.contribution.removed_radiance)),
        ]);
    }
    table
}

/// Returns the report of a study of effects as Markdown.
#[must_use]
pub fn markdown_report(about: &EffectReportHeader, findings: &EffectStudyResult) -> String {
    let passes = findings.full_picture_cost.pass_seconds.len();
    let per_pass = |n: u64| count_text(n as f64 / passes as f64);
    let mut text = format!(
        "# Cost and contribution of effects: {}\n\nCaustica {}, {}, seed {}, passes of each picture: {passes}. Seconds are {}. Each effect \
         was left out once. The whole picture: {:.1} ms, {} rays and {} gathered photons per pass, mean radiance {} W/(m² sr).\n\n",
        escape_markdown(&about.scene_name),
        env!("CARGO_PKG_VERSION"),
        about.integrator,
        about.seed,
        clock_name(findings.clock),
        1e3 * findings.full_picture_cost.total_pass_seconds() / passes as f64,
        per_pass(findings.full_picture_cost.counters.total_rays()),
        per_pass(findings.full_picture_cost.counters.gathered_photons),
        three_digit_text(findings.mean_radiance),
    );
    let row = |EffectResult { decision, added_cost, contribution, .. }: &EffectResult| {
        let error = added_cost.seconds_standard_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        vec![
            decision.effect.to_string(),
            signed_milliseconds_text(added_cost.seconds_per_pass) + &error,
            format!("{:.2}", added_cost.time_ratio),
            signed_count_text(added_cost.rays),
            signed_count_text(added_cost.gathered_photons),
            contribution.relative_rmse.map_or(three_digit_text(contribution.rmse), percent_text),
            percent_of_mean_text(contribution.added_radiance, findings.mean_radiance),
            percent_of_mean_text(contribution.removed_radiance, findings.mean_radiance),
        ]
    };
    let rows: Vec<Vec<String>> = findings.effects.iter().map(row).collect();
    let heads =
        ["effect", "ms per pass", "time ratio", "rays per pass", "gathered photons", "changes", "adds", "takes"];
    text += &markdown_table(&heads, &rows);
    for decision in findings.effect_plan.decisions.iter().filter(|d| !d.is_simulated) {
        let state = if decision.is_forced_against_need() { "forced off, though " } else { "off: " };
        text += &format!("\n- {}: {state}{}", decision.effect, escape_markdown(&decision.reason.to_string()));
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Algorithm, Settings, SilentMonitor};
    use crate::plan::EffectOverrides;
    use crate::scene::Effect;
    use crate::study::EffectStudy;
    use crate::study::tests::diffuse_sphere_on_floor;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn csv_and_markdown_list_every_effect() {
        let scene = diffuse_sphere_on_floor(8, 6);
        let mut settings = Settings::default();
        settings.camera_paths.effects = EffectOverrides::NO_OVERRIDES.with_forced_on(Effect::Environment);
        let study = EffectStudy::prepare(&scene, Algorithm::Whitted, &settings);
        let findings = study.run(2, &AtomicBool::new(false), &SilentMonitor, |_| {}).unwrap();
        let table = csv_report(&findings);
        let rows: Vec<&str> = table.split("\r\n").collect();
        assert_eq!(rows.len(), 1 + findings.effect_plan.decisions.len() + 1);
        assert!(rows.iter().any(|row| row.starts_with("shadows,true,false,")));
        // An effect that is off has empty cells.
        assert!(rows.iter().any(|row| row.starts_with("caustics,false,") && row.ends_with(",,,,,,,,,,,")));
        let about = EffectReportHeader { scene_name: "a_b.txt".into(), integrator: "whitted", seed: 3, exposure: 0.0 };
        let text = markdown_report(&about, &findings);
        assert!(text.contains(": a\\_b.txt") && text.contains("| shadows | ") && text.contains("- caustics: off: "));
        assert!(text.contains("| environment | "));
    }
}
