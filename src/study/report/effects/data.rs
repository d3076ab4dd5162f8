//! Tables of a study of effects, as CSV and Markdown.

use super::{About, clock, part};
use crate::study::report::plain::{csv_row, markdown_table, markdown_text};
use crate::study::report::text::{amount, figure, milliseconds, percent, signed};
use crate::study::{EffectResult, EffectStudyResult};

/// CSV with one row per effect, simulated or not; unknown cells are empty. Seconds, and radiance in
/// W/(m² sr).
#[must_use]
pub fn csv(findings: &EffectStudyResult) -> String {
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
    for decision in &findings.plan.decisions {
        let found = findings.effects.iter().find(|f| f.decision.effect == decision.effect);
        let figure =
            |of: &dyn Fn(&EffectResult) -> Option<f64>| found.and_then(of).map_or(String::new(), |v| v.to_string());
        table += &csv_row(&[
            decision.effect.to_string(),
            decision.on.to_string(),
            decision.is_forced().to_string(),
            decision.reason.to_string(),
            figure(&|f| Some(f.cost.seconds)),
            figure(&|f| f.cost.seconds_error),
            figure(&|f| Some(f.cost.ratio)),
            figure(&|f| Some(f.cost.setup)),
            figure(&|f| Some(f.cost.rays)),
            figure(&|f| Some(f.cost.gathers)),
            figure(&|f| Some(f.cost.gathered_photons)),
            figure(&|f| Some(f.gain.rmse)),
            figure(&|f| f.gain.relative_rmse),
            figure(&|f| Some(f.gain.adds)),
            figure(&|f| Some(f.gain.takes)),
        ]);
    }
    table
}

/// The figures as Markdown.
#[must_use]
pub fn markdown(about: &About, findings: &EffectStudyResult) -> String {
    let passes = findings.whole.passes.len();
    let a_pass = |n: u64| amount(n as f64 / passes as f64);
    let mut text = format!(
        "# Cost and contribution of effects: {}\n\nCaustica {}, {}, seed {}, passes of each picture: {passes}. Seconds are {}. Each effect \
         was left out once. The whole picture: {:.1} ms, {} rays and {} gathered photons per pass, mean radiance {} W/(m² sr).\n\n",
        markdown_text(&about.scene),
        env!("CARGO_PKG_VERSION"),
        about.integrator,
        about.seed,
        clock(findings.clock),
        1e3 * findings.whole.seconds() / passes as f64,
        a_pass(findings.whole.counters.rays()),
        a_pass(findings.whole.counters.gathered_photons),
        figure(findings.mean),
    );
    let row = |EffectResult { decision, cost, gain, .. }: &EffectResult| {
        let error = cost.seconds_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        vec![
            decision.effect.to_string(),
            milliseconds(cost.seconds) + &error,
            format!("{:.2}", cost.ratio),
            signed(cost.rays),
            signed(cost.gathered_photons),
            gain.relative_rmse.map_or(figure(gain.rmse), percent),
            part(gain.adds, findings.mean),
            part(gain.takes, findings.mean),
        ]
    };
    let rows: Vec<Vec<String>> = findings.effects.iter().map(row).collect();
    let heads =
        ["effect", "ms per pass", "time ratio", "rays per pass", "gathered photons", "changes", "adds", "takes"];
    text += &markdown_table(&heads, &rows);
    for decision in findings.plan.decisions.iter().filter(|d| !d.on) {
        let state = if decision.is_forced() { "forced off, though " } else { "off: " };
        text += &format!("\n- {}: {state}{}", decision.effect, markdown_text(&decision.reason.to_string()));
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Algorithm, Settings, Silent};
    use crate::plan::{Effect, EffectOverrides};
    use crate::study::EffectStudy;
    use crate::study::tests::matt;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn every_effect_has_a_row() {
        let scene = matt(8, 6);
        let mut settings = Settings::default();
        settings.camera_paths.effects = EffectOverrides::PLANNED.with(Effect::Environment);
        let study = EffectStudy::prepare(&scene, Algorithm::Whitted, &settings);
        let findings = study.run(2, &AtomicBool::new(false), &Silent, |_| {}).unwrap();
        let table = csv(&findings);
        let rows: Vec<&str> = table.split("\r\n").collect();
        assert_eq!(rows.len(), 1 + findings.plan.decisions.len() + 1);
        assert!(rows.iter().any(|row| row.starts_with("shadows,true,false,")));
        // An effect that is off has no figures.
        assert!(rows.iter().any(|row| row.starts_with("caustics,false,") && row.ends_with(",,,,,,,,,,,")));
        let about = About { scene: "a_b.txt".into(), integrator: "whitted", seed: 3, exposure: 0.0 };
        let text = markdown(&about, &findings);
        assert!(text.contains(": a\\_b.txt") && text.contains("| shadows | ") && text.contains("- caustics: off: "));
        assert!(text.contains("| environment | "));
    }
}
