use super::*;

fn series_with_points(label: &str, style: usize, points: &[(f64, f64)]) -> PlotSeries {
    PlotSeries {
        label: label.into(),
        series_index: style,
        stroke: LineStyle::Solid,
        points: points.to_vec(),
        confidence_intervals: Vec::new(),
    }
}

#[test]
fn series_labels_do_not_overlap() {
    let placed = spread_label_positions(&[10.0, 11.0, 12.0, 80.0, 99.0, 100.0], (10.0, 100.0));
    assert!(placed.windows(2).all(|pair| pair[1] - pair[0] >= LABEL_HEIGHT - 1e-9), "{placed:?}");
    assert!(placed[0] >= 10.0 - 1e-9 && placed[5] <= 100.0 && placed[1] == 26.0);
}

#[test]
fn log_axis_decades_have_equal_length() {
    let axis = LogAxis::axis_around_values([0.01, 10.0].into_iter(), (0.0, 300.0)).unwrap();
    assert!(
        (axis.position_on_axis(1.0)
            - axis.position_on_axis(0.1)
            - (axis.position_on_axis(0.1) - axis.position_on_axis(0.01)))
        .abs()
            < 1e-9
    );
    let labelled: Vec<f64> = axis.tick_values().into_iter().filter(|t| t.1).map(|t| t.0).collect();
    let expected = [0.01, 0.1, 1.0, 10.0];
    assert!(labelled.len() == 4 && labelled.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
    assert_eq!([0.05, 0.5, 2.0, 100.0, 0.01].map(tick_text), ["0.05", "0.5", "2", "100", "0.01"]);
    // A single point has ticks around it.
    assert!(LogAxis::axis_around_values([3.0].into_iter(), (0.0, 1.0)).unwrap().tick_values().len() >= 2);
}

#[test]
fn plots_skip_values_without_logarithm() {
    let draw = |points: &[(f64, f64)]| {
        let all = vec![series_with_points("a<b", 0, points)];
        plot_svg(&LogLogPlot { id: "p", title: "t", alt_text: "w", size: (400.0, 300.0), series: all, guides: vec![] })
    };
    assert!(draw(&[(0.0, 1.0), (1.0, -1.0), (1.0, f64::NAN)]).is_none());
    let svg = draw(&[(1.0, 0.5), (2.0, 0.0), (4.0, 0.25)]).unwrap();
    assert_eq!(svg.matches("<circle").count(), 2);
    assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
}
