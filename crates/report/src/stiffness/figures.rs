//! An identification and a compensation along a log, in pictures.

use bracketry_plot::{Color, Drawing, Interval, IntervalChart, Panel, PlotError, Series, TimeSeries, XyChart};
use bracketry_stiffness::{CompensatedLog, CompensatedRow, Identification, Identified, PredictedTranslation};

const IDENTIFIED: &str = "identified";
const UNKNOWN: &str = "not identified (no value; drawn at 0)";
const HELD: &str = "held: bad input";
const LIMITED: &str = "at a limit";

/// Stiffnesses of the joints with their intervals, and which joints the data tell nothing of; none where they tell no stiffness.
pub fn stiffness(found: &Identification) -> Option<Result<Drawing, PlotError>> {
    let mut chart = IntervalChart::new("stiffness [MN·m/rad]")
        .title(format!("Stiffness of the joints with 95 % intervals, {}", found.robot))
        .categories([IDENTIFIED, UNKNOWN]);
    for parameter in found.parameters.iter().filter(|p| p.name == "stiffness") {
        let name = format!("joint {}", parameter.joint);
        chart = match parameter.identified {
            Identified::Yes { value, low, high } => {
                chart.row(name, 1e-6 * value, Some((1e-6 * low, 1e-6 * high)), IDENTIFIED)
            }
            Identified::No { .. } => chart.row(format!("{name}: not identified"), 0.0, None, UNKNOWN),
        };
    }
    chart.rows.iter().any(|row| row.category == IDENTIFIED).then(|| chart.draw())
}

/// What the prediction of the trusted method leaves of the measured translations; none without a prediction. Outliers have a marker of
/// their own, at the frame's edge where they lie beyond.
pub fn residuals(found: &Identification) -> Option<Result<Drawing, PlotError>> {
    let point = |p: &PredictedTranslation, i: usize| (1e3 * p.predicted[i], 1e6 * (p.measured[i] - p.predicted[i]));
    let of = |outlier: bool| found.predictions.iter().filter(move |p| p.outlier == outlier);
    let kept: Vec<(f64, f64)> = of(false).flat_map(|p| [0, 1, 2].map(|i| point(p, i))).collect();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, |m, v| m.max(v.abs()));
    let wide = 1.05 * largest(&mut kept.iter().map(|p| p.0));
    let high = 1.2 * largest(&mut kept.iter().map(|p| p.1));
    let mut panel = Panel::new("measured − predicted [µm]").named_target("", 0.0);
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let (predicted, rest): (Vec<f64>, Vec<f64>) = of(false).map(|p| point(p, i)).unzip();
        panel = panel.series(Series::new(axis, predicted, rest).points());
    }
    let outliers: Vec<(f64, f64)> = of(true).flat_map(|p| [0, 1, 2].map(|i| point(p, i))).collect();
    if !outliers.is_empty() && high > 0.0 {
        let beyond = outliers.iter().any(|(x, y)| x.abs() > wide || y.abs() > high);
        let name =
            if beyond { "excluded as outlier (outside the axes: drawn at the edge)" } else { "excluded as outlier" };
        let shown = outliers.iter().map(|(x, y)| (x.clamp(-wide, wide), y.clamp(-high, high)));
        let (x, y): (Vec<f64>, Vec<f64>) = shown.unzip();
        panel = panel.series(Series::new(name, x, y).crosses().color(Color::INK)).limits(-high, high);
    }
    let title = format!("Translation of the tool point, {}: {}", found.robot, found.trusted);
    (!kept.is_empty()).then(|| XyChart::new("predicted [mm]", panel).title(title).draw())
}

/// Force of the process, displacement that it causes, and correction of the joints over time; where input was bad or a limit
/// acted is shaded.
///
/// # Errors
/// [`PlotError`] for numbers too large for an axis.
pub fn compensated_log(run: &CompensatedLog) -> Result<Drawing, PlotError> {
    let t: Vec<f64> = run.rows.iter().map(|row| row.t).collect();
    let line = |name: String, value: &dyn Fn(&CompensatedRow) -> f64| {
        Series::new(name, t.clone(), run.rows.iter().map(value).collect::<Vec<f64>>())
    };
    let mut force = Panel::new("force [N]").height(140.0);
    let mut moved = Panel::new("displacement [mm]").height(140.0);
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        force = force.series(line(axis.to_owned(), &|row| row.wrench[i]));
        moved = moved.series(line(axis.to_owned(), &|row| 1e3 * row.displacement[i]));
    }
    let mut correction = Panel::new("correction [mrad]").height(160.0);
    for i in 0..run.correction_max.len() {
        correction = correction.series(line(format!("joint {}", i + 1), &|row| 1e3 * row.correction[i]));
    }
    let mut figure = TimeSeries::new()
        .title(format!("Compensation along the log, {}", run.robot))
        .panel(force)
        .panel(moved)
        .panel(correction)
        .category_color(HELD, Color::band(1))
        .category_color(LIMITED, Color::band(2));
    for (category, acts) in [(HELD, true), (LIMITED, false)] {
        for (start, end) in stretches(run, |row| if acts { row.held } else { row.limited && !row.held }) {
            figure = figure.interval(Interval::new(start, end, category));
        }
    }
    figure.draw()
}

/// Intervals of time in which something holds.
fn stretches(run: &CompensatedLog, holds: impl Fn(&CompensatedRow) -> bool) -> Vec<(f64, f64)> {
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    let mut open = false;
    for row in &run.rows {
        match (holds(row), open) {
            (true, false) => stretches.push((row.t, row.t + run.period)),
            (true, true) => {
                if let Some(last) = stretches.last_mut() {
                    last.1 = row.t + run.period;
                }
            }
            (false, _) => {}
        }
        open = holds(row);
    }
    stretches
}
