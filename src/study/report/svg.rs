//! Log-log plots as inline SVG, without scripts. Their colours suit light and dark pages.

use super::html::escape_html;
use std::fmt::Write;

/// Colours of data series, from the palette of Okabe and Ito (2008). The first ones contrast best
/// with white and black.
///
/// The last one, `currentColor`, is the text colour of the page.
const SERIES_COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "currentColor"];

/// Height of a series label \[px].
const LABEL_HEIGHT: f64 = 16.0;

/// Largest width of a letter in a series label \[px].
const MAX_LETTER_WIDTH: f64 = 6.9;

/// Largest number of letters of a series label. Longer labels are cut; tooltips show the whole
/// label.
const MAX_LABEL_LETTERS: usize = 30;

/// Line style of a series in a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineStyle {
    /// A solid line with markers at the points.
    Solid,
    Dashed,
    Dotted,
}

/// Line and markers of one data series in a plot.
///
/// A point is skipped if its time or its error is not positive and finite, because it has no place
/// on a logarithmic axis.
#[derive(Clone, Debug)]
pub(super) struct PlotSeries {
    pub(super) label: String,
    /// Index of the series, which selects its colour and marker.
    pub(super) series_index: usize,
    pub(super) stroke: LineStyle,
    /// Processor time \[s] and relative error of each point.
    pub(super) points: Vec<(f64, f64)>,
    /// Confidence intervals of the errors of `points`, in the same order; `None` if unknown. Points
    /// beyond the end of this list have no interval.
    pub(super) confidence_intervals: Vec<Option<[f64; 2]>>,
}

/// Straight guide line in a log-log plot, with a given slope and through a given point.
#[derive(Clone, Debug)]
pub(super) struct SlopeGuideLine {
    pub(super) label: String,
    pub(super) slope: f64,
    /// Processor time \[s] and relative error of a point on the line.
    pub(super) through: (f64, f64),
    /// True to put the label below the guide line, because the measured line is above it.
    pub(super) label_below: bool,
}

/// Log-log plot of relative error over processor time.
#[derive(Clone, Debug)]
pub(super) struct LogLogPlot<'a> {
    /// HTML identifier, unique on the page.
    pub(super) id: &'a str,
    pub(super) title: &'a str,
    /// Alternative text of the plot, for readers who do not see it.
    pub(super) alt_text: &'a str,
    /// Width and height of the plot \[px].
    pub(super) size: (f64, f64),
    pub(super) series: Vec<PlotSeries>,
    pub(super) guides: Vec<SlopeGuideLine>,
}

/// Logarithmic axis from value `least` to value `most`.
#[derive(Clone, Copy)]
struct LogAxis {
    least: f64,
    most: f64,
    /// Position of the value `least` on the page \[px].
    least_position: f64,
    /// Position of the value `most` on the page \[px].
    most_position: f64,
}

impl LogAxis {
    /// Makes an axis between two page positions (`from`, `to`) \[px] that contains all positive
    /// finite values with a margin; `None` if there are none.
    fn axis_around_values(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Option<Self> {
        let (least, most) = values
            .filter(|v| is_positive_finite(*v))
            .fold((f64::MAX, 0.0), |(a, b): (f64, f64), v| (a.min(v), b.max(v)));
        if most <= 0.0 {
            return None;
        }
        // The axis spans at least a factor of four, so a single point has ticks around it.
        let margin_factor = f64::max(1.12, (4.0 * least / most).sqrt());
        Some(Self { least: least / margin_factor, most: most * margin_factor, least_position: from, most_position: to })
    }

    fn position_on_axis(&self, value: f64) -> f64 {
        let part = libm::log(value / self.least) / libm::log(self.most / self.least);
        self.least_position + part * (self.most_position - self.least_position)
    }

    /// Returns the values of the ticks at 1, 2 and 5 times powers of ten. The flag of a tick is
    /// true if it has a label.
    fn tick_values(&self) -> Vec<(f64, bool)> {
        let decades = libm::log10(self.most / self.least);
        let first = libm::floor(libm::log10(self.least)) as i32;
        let last = libm::ceil(libm::log10(self.most)) as i32;
        let mut ticks = Vec::new();
        for decade in first..=last {
            for digit in [1.0, 2.0, 5.0] {
                let value = digit * libm::pow(10.0, f64::from(decade));
                if value >= self.least && value <= self.most {
                    ticks.push((value, digit == 1.0 || decades < 2.6));
                }
            }
        }
        ticks
    }
}

fn is_positive_finite(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

/// Returns the CSS colour of the data series with index `style` in a plot.
pub(super) fn series_color(style: usize) -> &'static str {
    SERIES_COLORS[style % SERIES_COLORS.len()]
}

/// Returns the SVG marker at (`x`, `y`) \[px] of the series with index `style`.
pub(super) fn marker_svg(style: usize, x: f64, y: f64) -> String {
    // Markers have about equal area.
    let path = |points: &[(f64, f64)]| {
        let ends: Vec<String> = points.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
        format!("<polygon points=\"{}\"/>", ends.join(" "))
    };
    match style % 6 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>"),
        1 => path(&[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)]),
        2 => path(&[(0.0, -5.2), (4.9, 3.4), (-4.9, 3.4)]),
        3 => path(&[(0.0, -5.2), (5.2, 0.0), (0.0, 5.2), (-5.2, 0.0)]),
        4 => path(&[(0.0, 5.2), (4.9, -3.4), (-4.9, -3.4)]),
        _ => path(&[
            (-1.6, -4.8),
            (1.6, -4.8),
            (1.6, -1.6),
            (4.8, -1.6),
            (4.8, 1.6),
            (1.6, 1.6),
            (1.6, 4.8),
            (-1.6, 4.8),
            (-1.6, 1.6),
            (-4.8, 1.6),
            (-4.8, -1.6),
            (-1.6, -1.6),
        ]),
    }
}

/// Returns the SVG element of a plot; `None` if there is nothing to draw.
pub(super) fn plot_svg(plot: &LogLogPlot<'_>) -> Option<String> {
    let (width, height) = plot.size;
    let longest = plot.series.iter().map(|s| shortened_label(&s.label).chars().count()).max()?;
    let right = width - 18.0 - MAX_LETTER_WIDTH * longest as f64;
    let points = || {
        plot.series.iter().flat_map(|s| s.points.iter().filter(|p| is_positive_finite(p.0) && is_positive_finite(p.1)))
    };
    let x = LogAxis::axis_around_values(points().map(|p| p.0), (58.0, right))?;
    let y = LogAxis::axis_around_values(points().map(|p| p.1), (height - 46.0, 12.0))?;
    let LogLogPlot { id, .. } = plot;
    let mut svg = format!(
        "<svg id=\"{id}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\">\n<title id=\"{id}-title\">{}</title>\n<desc id=\"{id}-desc\">{}</desc>\n",
        escape_html(plot.title),
        escape_html(plot.alt_text)
    );
    draw_axes(&mut svg, &x, &y, plot.size);
    plot.guides.iter().for_each(|guide| draw_slope_guide(&mut svg, guide, &x, &y));
    let _ = writeln!(
        svg,
        "<clipPath id=\"{id}-clip\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>",
        x.least_position - 6.0,
        y.most_position - 6.0,
        x.most_position - x.least_position + 12.0,
        y.least_position - y.most_position + 12.0
    );
    let mut ends = Vec::new();
    for series in &plot.series {
        ends.extend(draw_series(&mut svg, series, id, &x, &y).map(|end| (end, series)));
    }
    draw_series_labels(&mut svg, ends, &x, &y);
    svg += "</svg>\n";
    Some(svg)
}

fn draw_axes(svg: &mut String, x: &LogAxis, y: &LogAxis, (_, height): (f64, f64)) {
    for (value, has_label) in x.tick_values() {
        let at = x.position_on_axis(value);
        let class = if has_label { "grid" } else { "grid faint" };
        let _ = writeln!(
            svg,
            "<line class=\"{class}\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>",
            y.least_position, y.most_position
        );
        if has_label {
            let _ = writeln!(
                svg,
                "<text class=\"tick\" text-anchor=\"middle\" x=\"{at:.1}\" y=\"{:.1}\">{} s</text>",
                y.least_position + 18.0,
                tick_text(value)
            );
        }
    }
    for (value, has_label) in y.tick_values() {
        let at = y.position_on_axis(value);
        let class = if has_label { "grid" } else { "grid faint" };
        let _ = writeln!(
            svg,
            "<line class=\"{class}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>",
            x.least_position, x.most_position
        );
        if has_label {
            let _ = writeln!(
                svg,
                "<text class=\"tick\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{} %</text>",
                x.least_position - 6.0,
                at + 4.0,
                tick_text(100.0 * value)
            );
        }
    }
    let _ = writeln!(
        svg,
        "<text class=\"tick\" text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">processor time</text>",
        0.5 * (x.least_position + x.most_position),
        height - 8.0
    );
}

/// Returns the text of a tick value of one significant digit, such as `0.05`, `20` or `1000`.
fn tick_text(value: f64) -> String {
    let decimals = libm::ceil(-libm::log10(value) - 1e-9).max(0.0) as usize;
    format!("{value:.decimals$}")
}

fn draw_slope_guide(svg: &mut String, guide: &SlopeGuideLine, x: &LogAxis, y: &LogAxis) {
    let (x0, y0) = guide.through;
    if !(is_positive_finite(x0) && is_positive_finite(y0)) {
        return;
    }
    let error_at = |at: f64| y0 * libm::pow(at / x0, guide.slope);
    // Time at which the guide line has the error `value`; not used for a horizontal line.
    let time_at = |value: f64| x0 * libm::pow(value / y0, 1.0 / guide.slope);
    let (mut from, mut to) = (x.least, x.most);
    if guide.slope < 0.0 {
        (from, to) = (from.max(time_at(y.most)), to.min(time_at(y.least)));
    } else if error_at(from) < y.least || error_at(from) > y.most {
        return;
    }
    if to <= from {
        return;
    }
    let [(x1, y1), (x2, y2)] = [from, to].map(|at| (x.position_on_axis(at), y.position_on_axis(error_at(at))));
    let _ = writeln!(svg, "<line class=\"guide\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>");
    // Put the label at 35 % of the guide line, on the side away from the measured line.
    let (dx, dy, anchor) = if guide.label_below { (-5.0, 13.0, "end") } else { (5.0, -4.0, "start") };
    let (tx, ty) = (x1 + 0.35 * (x2 - x1) + dx, y1 + 0.35 * (y2 - y1) + dy);
    let _ = writeln!(
        svg,
        "<text class=\"guide\" text-anchor=\"{anchor}\" x=\"{tx:.1}\" y=\"{ty:.1}\">{}</text>",
        escape_html(&guide.label)
    );
}

/// Draws a series. Returns the position of its last point on the page \[px]; `None` without points.
fn draw_series(svg: &mut String, series: &PlotSeries, id: &str, x: &LogAxis, y: &LogAxis) -> Option<(f64, f64)> {
    let colour = series_color(series.series_index);
    let mut ends = Vec::new();
    let mut markers = String::new();
    for (i, (time, error)) in series.points.iter().enumerate() {
        if !(is_positive_finite(*time) && is_positive_finite(*error)) {
            continue;
        }
        let (px, py) = (x.position_on_axis(*time), y.position_on_axis(*error));
        ends.push((px, py));
        if let Some([low, high]) = series.confidence_intervals.get(i).copied().flatten() {
            let [y1, y2] = [high, low].map(|v| y.position_on_axis(v.clamp(0.5 * y.least, 2.0 * y.most)));
            let _ =
                write!(markers, "<line class=\"bar\" x1=\"{px:.1}\" x2=\"{px:.1}\" y1=\"{y1:.1}\" y2=\"{y2:.1}\"/>");
        }
        if series.stroke == LineStyle::Solid {
            markers += &marker_svg(series.series_index, px, py);
        }
    }
    let dash = match series.stroke {
        LineStyle::Solid => "",
        LineStyle::Dashed => " stroke-dasharray=\"8 5\"",
        LineStyle::Dotted => " stroke-dasharray=\"1 5\" stroke-linecap=\"round\"",
    };
    let line: Vec<String> = ends.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<g clip-path=\"url(#{id}-clip)\" stroke=\"{colour}\" fill=\"{colour}\"><polyline class=\"line\"{dash} points=\"{}\"/>{markers}</g>",
        line.join(" ")
    );
    ends.last().copied()
}

/// Draws the label of each series to the right of the plot, near the height of the series' last
/// point.
///
/// Labels do not overlap if there is room for all.
fn draw_series_labels(svg: &mut String, mut ends: Vec<((f64, f64), &PlotSeries)>, x: &LogAxis, y: &LogAxis) {
    ends.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
    let heights = spread_label_positions(
        &ends.iter().map(|(end, _)| end.1).collect::<Vec<_>>(),
        (y.most_position + 4.0, y.least_position),
    );
    for (((end_x, end_y), series), at) in ends.into_iter().zip(heights) {
        let colour = series_color(series.series_index);
        let label_x = x.most_position + 14.0;
        let _ = writeln!(
            svg,
            "<polyline class=\"lead\" stroke=\"{colour}\" points=\"{:.1},{end_y:.1} {:.1},{at:.1}\"/><text class=\"label\" x=\"{label_x:.1}\" y=\"{:.1}\">{}<title>{}</title></text>",
            end_x + 6.0,
            label_x - 3.0,
            at + 4.5,
            escape_html(&shortened_label(&series.label)),
            escape_html(&series.label)
        );
    }
}

fn shortened_label(label: &str) -> String {
    if label.chars().count() <= MAX_LABEL_LETTERS {
        return label.to_owned();
    }
    label.chars().take(MAX_LABEL_LETTERS - 1).chain(['…']).collect()
}

/// Returns vertical positions \[px, downwards] at which labels do not overlap. The positions are
/// near the wanted positions `heights`, which are sorted.
///
/// The function first moves labels down until all are below `top` and apart from each other. It
/// then moves labels up until none is below `bottom`. If there is too little room, some labels end
/// above `top`.
fn spread_label_positions(heights: &[f64], (top, bottom): (f64, f64)) -> Vec<f64> {
    let mut placed: Vec<f64> = Vec::with_capacity(heights.len());
    for &height in heights {
        let least = placed.last().map_or(top, |last| last + LABEL_HEIGHT);
        placed.push(height.max(least));
    }
    // Move labels up that are below `bottom`, from the last to the first.
    let mut most = bottom;
    for at in placed.iter_mut().rev() {
        *at = at.min(most);
        most = *at - LABEL_HEIGHT;
    }
    placed
}

#[cfg(test)]
mod tests;
