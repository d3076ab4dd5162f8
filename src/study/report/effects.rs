//! HTML report of a study of effects; submodule `csv_and_markdown` has CSV and Markdown.

mod csv_and_markdown;

pub use csv_and_markdown::{csv_report, markdown_report};

use super::html::{escape_html, inline_png, number_cells_html};
use super::picture::{auto_exposure_stops, encode_png, exposure_text, negative_part, positive_part};
use super::text::{count_text, percent_text, signed_count_text, signed_milliseconds_text, three_digit_text};
use crate::image::Image;
use crate::study::{ClockKind, EffectResult, EffectStudyResult, StudyError};
use std::fmt::Write;

/// Smallest ratio at which both difference pictures of an effect are shown: the light that the
/// effect adds, and the light that it removes. The ratio is the mean of the weaker picture, divided
/// by the mean of the stronger one. Below this ratio, the weaker picture is mostly noise and is not
/// shown.
const MIN_SHOWN_RATIO: f64 = 0.1;

const STYLE: &str = "\
:root { color-scheme: light dark; }
body { font: 1rem/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2, h3 { line-height: 1.2; } h3 { margin: 0 0 .5rem; }
img { max-width: 100%; height: auto; background: #000; display: block; }
figure { margin: 0; flex: 1 1 24rem; min-width: 0; max-width: 40rem; } figcaption { font-size: .875rem; padding-top: .25rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .75rem; border-bottom: 1px solid #8886; text-align: left; vertical-align: top; }
td.n, th.n { text-align: right; } td.n, tbody th, tfoot th { white-space: nowrap; } thead th { vertical-align: bottom; }
article { border-top: 1px solid #8886; padding: 1.5rem 0; }
.pictures { display: flex; flex-wrap: wrap; gap: 1rem; margin-top: 1rem; }
p { max-width: 48rem; } dl { display: grid; grid-template-columns: max-content 1fr; gap: .25rem 1rem; } dt { font-weight: 600; } dd { margin: 0; }
";

/// Scene name and settings that the report of a study of effects shows at its top.
#[derive(Clone, Debug)]
pub struct EffectReportHeader {
    /// Name of the scene, shown in the report.
    pub scene_name: String,
    /// Name of the rendering algorithm.
    pub integrator: &'static str,
    /// Seed of all pictures.
    pub seed: u64,
    /// Exposure of the picture with all effects \[stops].
    pub exposure: f32,
}

/// Returns the report of a study of effects as an HTML page, which is also well-formed XML.
///
/// # Errors
/// [`StudyError`] if a picture cannot be encoded.
pub fn effects_html_page(about: &EffectReportHeader, findings: &EffectStudyResult) -> Result<String, StudyError> {
    let scene = escape_html(&about.scene_name);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>Effects of {scene}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Cost and contribution of effects: {scene}</h1>\n"
    );
    let passes = findings.full_picture_cost.pass_seconds.len();
    let _ = writeln!(
        page,
        "<p>Rendered by Caustica {} with <code>{}</code>, {passes} {}, seed {}. Each effect in use was left out \
         once. Figures are the whole picture less the one without the effect. Seconds are {}.</p>",
        env!("CARGO_PKG_VERSION"),
        about.integrator,
        if passes == 1 { "pass" } else { "passes" },
        about.seed,
        clock_name(findings.clock),
    );
    let caption = format!("The whole picture: exposure {}.", exposure_text(about.exposure));
    page += "<div class=\"pictures\">\n";
    page += &picture_figure_html(&findings.picture, about.exposure, "the whole picture", &caption)?;
    page += "</div>\n";
    if findings.effects.is_empty() {
        page += "<p>No effect is simulated, so none was left out.</p>\n";
    } else {
        page += &effects_table_html(findings);
        page += "<h2>The effects one by one</h2>\n<p>Light that an effect adds and light that it removes are shown separately, each at its own \
                 exposure. A part below a tenth of the other is mostly noise and not shown.</p>\n";
    }
    for finding in &findings.effects {
        page += &effect_article_html(finding)?;
    }
    page += &omitted_effects_html(findings);
    page += "</body>\n</html>\n";
    Ok(page)
}

fn clock_name(clock: ClockKind) -> &'static str {
    match clock {
        ClockKind::Processor => "of processor time of all threads",
        ClockKind::Wall => "of wall time",
    }
}

fn picture_figure_html(image: &Image, exposure: f32, words: &str, caption: &str) -> Result<String, StudyError> {
    let image = inline_png(&encode_png(image, exposure)?, (image.width(), image.height()), words);
    Ok(format!("<figure>{image}\n<figcaption>{}</figcaption></figure>\n", escape_html(caption)))
}

fn percent_of_mean_text(value: f64, mean: f64) -> String {
    if mean > 0.0 { percent_text(value / mean) } else { three_digit_text(value) }
}

fn effects_table_html(findings: &EffectStudyResult) -> String {
    let heads = [
        "ms per pass",
        "time ratio",
        "ms of setup",
        "rays per pass",
        "gathered photons per pass",
        "RMSE, W/(m² sr)",
        "RMSE / mean",
        "adds / mean",
        "removes / mean",
    ];
    let mut table =
        "<h2>Figures</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">effect</th>".to_owned();
    heads.iter().for_each(|head| table += &format!("<th scope=\"col\" class=\"n\">{head}</th>"));
    table += "</tr></thead>\n<tbody>\n";
    for EffectResult { decision, added_cost, contribution, .. } in &findings.effects {
        let error = added_cost.seconds_standard_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        let cells = [
            signed_milliseconds_text(added_cost.seconds_per_pass) + &error,
            format!("{:.2}", added_cost.time_ratio),
            signed_milliseconds_text(added_cost.setup_seconds),
            signed_count_text(added_cost.rays),
            signed_count_text(added_cost.gathered_photons),
            three_digit_text(contribution.rmse),
            contribution.relative_rmse.map_or("–".to_owned(), percent_text),
            percent_of_mean_text(contribution.added_radiance, findings.mean_radiance),
            percent_of_mean_text(contribution.removed_radiance, findings.mean_radiance),
        ];
        let _ = write!(table, "<tr><th scope=\"row\"><a href=\"#{0}\">{0}</a></th>", decision.effect);
        table += &number_cells_html(&cells);
        table += "</tr>\n";
    }
    let whole = &findings.full_picture_cost;
    let passes = whole.pass_seconds.len() as f64;
    let per_pass = |n: u64| count_text(n as f64 / passes);
    let cells = [
        format!("{:.1}", 1e3 * whole.total_pass_seconds() / passes),
        String::new(),
        format!("{:.1}", 1e3 * whole.setup_seconds),
        per_pass(whole.counters.total_rays()),
        per_pass(whole.counters.gathered_photons),
    ];
    table += "</tbody>\n<tfoot><tr><th scope=\"row\">the whole picture</th>";
    table += &number_cells_html(&cells);
    let _ = write!(
        table,
        "<td colspan=\"4\">mean radiance {} W/(m² sr)</td></tr></tfoot>\n</table></div>\n",
        three_digit_text(findings.mean_radiance)
    );
    let mut notes = "<p>Costs do not add up: effects share work, and some depend on others. ± is the standard error over passes.</p>\n";
    if findings.full_picture_cost.pass_seconds.len() == 1 {
        notes = "<p>Costs do not add up: effects share work, and some depend on others.</p>\n";
    }
    table + notes
}

fn effect_article_html(finding: &EffectResult) -> Result<String, StudyError> {
    let EffectResult { decision, added_cost, contribution, difference, .. } = finding;
    let effect = decision.effect;
    let mut article = format!("<article id=\"{effect}\">\n<h3>{effect}</h3>\n<dl>\n");
    let because = if decision.is_forced_against_need() {
        format!("forced; the scene does not need it: {}", decision.reason)
    } else {
        decision.reason.to_string()
    };
    let changes = if contribution.rmse == 0.0 {
        "nothing: the picture is equal bit for bit".to_owned()
    } else {
        let of_mean =
            contribution.relative_rmse.map_or(String::new(), |r| format!(", {} of the mean", percent_text(r)));
        format!("RMSE {} W/(m² sr){of_mean}", three_digit_text(contribution.rmse))
    };
    let costs = format!(
        "{} ms per pass, {:.2} times the time without it; {} rays and {} gathered photons per pass",
        signed_milliseconds_text(added_cost.seconds_per_pass),
        added_cost.time_ratio,
        signed_count_text(added_cost.rays),
        signed_count_text(added_cost.gathered_photons),
    );
    for (term, text) in [
        ("On, because", because.as_str()),
        ("Without it", effect.symptom_if_missing()),
        ("Costs", &costs),
        ("Changes", &changes),
    ] {
        let _ = writeln!(article, "<dt>{term}</dt><dd>{}</dd>", escape_html(text));
    }
    article += "</dl>\n";
    let most = contribution.added_radiance.max(contribution.removed_radiance);
    let parts = [
        ("added", contribution.added_radiance, positive_part(difference)?),
        ("removed", contribution.removed_radiance, negative_part(difference)?),
    ];
    article += "<div class=\"pictures\">\n";
    for (how, mean, image) in parts {
        let Some(exposure) = auto_exposure_stops(&image).filter(|_| mean >= MIN_SHOWN_RATIO * most) else { continue };
        let caption = format!("Light {how} by {effect}: exposure {}.", exposure_text(exposure));
        article += &picture_figure_html(&image, exposure, &format!("light {how} by {effect}"), &caption)?;
    }
    article += "</div>\n</article>\n";
    Ok(article)
}

fn omitted_effects_html(findings: &EffectStudyResult) -> String {
    let off: Vec<_> = findings.effect_plan.decisions.iter().filter(|d| !d.is_simulated).collect();
    if off.is_empty() {
        return String::new();
    }
    let mut list = "<h2>Not simulated</h2>\n<dl>\n".to_owned();
    for decision in off {
        let reason = escape_html(&decision.reason.to_string());
        let text = if decision.is_forced_against_need() {
            format!("forced off, though {reason}: {}", decision.effect.symptom_if_missing())
        } else {
            reason
        };
        let _ = writeln!(list, "<dt>{}</dt><dd>{text}</dd>", decision.effect);
    }
    list + "</dl>\n"
}
