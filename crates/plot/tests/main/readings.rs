//! What a page reads from a figure: scales, names of curves, and values.

use bracketry_plot::{BarChart, IntervalChart, Panel, Series, TimeSeries, XyChart};

/// Elements that start so, as they stand in the document.
fn elements<'a>(svg: &'a str, start: &str) -> Vec<&'a str> {
    svg.lines().filter(|l| l.starts_with(start)).collect()
}

/// The numbers of an attribute.
fn numbers(element: &str, attribute: &str) -> Vec<f64> {
    let (_, rest) = element.split_once(&format!("{attribute}=\"")).unwrap();
    rest.split('"').next().unwrap().split([' ', ',']).filter(|s| !s.is_empty()).map(|v| v.parse().unwrap()).collect()
}

#[test]
fn the_points_of_a_curve_give_its_values_with_the_scales_of_its_panel() {
    let (t, v) = (vec![0.0, 1.0, 2.0, 4.0], vec![0.0, 3.0, -1.0, 2.0]);
    let panel = Panel::new("v [m/s]").series(Series::new("a", t.clone(), v.clone()));
    let drawing = TimeSeries::new().panel(Panel::new("u")).panel(panel).draw().unwrap();
    let panels = elements(drawing.svg(), "<g data-panel");
    assert_eq!(panels.len(), 2);
    assert!(panels[1].contains("data-title=\"v [m/s]\"") && panels[1].contains("data-x-title=\"time [s]\""));
    let curves = elements(drawing.svg(), "<polyline");
    let curve = curves.iter().find(|l| l.contains("data-curve")).unwrap();
    assert!(curve.contains("data-panel=\"1\"") && curve.contains("data-name=\"a\""), "{curve}");
    let [frame, x, y] = ["data-box", "data-x", "data-y"].map(|name| numbers(panels[1], &format!(" {name}")));
    let points = numbers(curve, " points");
    assert_eq!(points.len(), 2 * t.len());
    for (k, p) in points.chunks(2).enumerate() {
        let across = x[0] + (p[0] - frame[0]) / (frame[2] - frame[0]) * (x[1] - x[0]);
        let up = y[0] + (frame[3] - p[1]) / (frame[3] - frame[1]) * (y[1] - y[0]);
        assert!((across - t[k]).abs() < 1e-3 && (up - v[k]).abs() < 1e-2, "{across}, {up}");
    }
}

#[test]
fn curves_set_aside_say_so_and_clouds_have_their_points() {
    let panel = Panel::new("n").series(Series::new("a", [1.0, 2.0], [1.0, 2.0])).series(Series::new(
        "b",
        [1.0, 2.0],
        [1.0, 2.0],
    ));
    let drawing = XyChart::new("k", panel).beside().draw().unwrap();
    let shifts: Vec<f64> = elements(drawing.svg(), "<polyline")
        .iter()
        .filter(|l| l.contains("data-shift"))
        .map(|l| numbers(l, "data-shift")[0])
        .collect();
    assert!(shifts.len() == 2 && shifts[0] == -shifts[1] && shifts[1] > 0.0, "{shifts:?}");
    let cloud = Panel::new("e").series(Series::new("residual", [3.0, 1.0, 2.0], [1.0, 0.0, 2.0]).points());
    let drawing = XyChart::new("k", cloud).draw().unwrap();
    let points = elements(drawing.svg(), "<g data-panel").into_iter().find(|l| l.contains("data-points")).unwrap();
    assert_eq!(numbers(points, "data-points").len(), 6);
}

#[test]
fn bars_and_intervals_say_their_values() {
    let bars =
        BarChart::new("error [%]", ["1 s", "2 s"]).series("before", [4.0, 8.5]).series("after", [1.0, 0.25]).draw();
    let svg = bars.unwrap();
    let said: Vec<&str> = elements(svg.svg(), "<rect").into_iter().filter(|l| l.contains("<title>")).collect();
    assert_eq!(said.len(), 4);
    assert!(said.iter().any(|l| l.contains("<title>2 s after: 0.25 %</title>")), "{said:?}");
    let rows = IntervalChart::new("k [N/m]").row("joint 1", 2.0, Some((1.5, 2.5)), "identified").draw().unwrap();
    assert!(rows.svg().contains("<title>joint 1: 2 N/m (1.5 … 2.5), identified</title>"));
}

#[test]
fn names_are_no_markup_and_nothing_of_this_is_seen() {
    let panel = |name: &str| Panel::new("x [m]").series(Series::new(name, [0.0, 1.0], [0.0, 1.0]));
    let drawing = TimeSeries::new().panel(panel("a\"<b>&\u{1}")).draw().unwrap();
    assert!(drawing.svg().contains("data-name=\"a&quot;&lt;b&gt;&amp; \""));
    assert!(drawing.png().is_ok());
}
