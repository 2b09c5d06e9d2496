//! Figures of an experiment: inputs with their limits, and expected outputs with the band of the noise.

use bracketry_experiment::{Design, Discrimination, Identification};
use bracketry_plot::{Color, Dash, Drawing, Panel, PlotError, Role, Series, TimeSeries};
use bracketry_sim::Hold;

/// Half the width of the band of the noise, in standard deviations.
const BAND: f64 = 2.0;

fn chart_of(design: &Design) -> TimeSeries {
    TimeSeries::new().time_label(design.quantities.time_title("time"))
}

/// A panel per input.
fn inputs(mut chart: TimeSeries, design: &Design) -> TimeSeries {
    let signals = &design.signals;
    for (j, name) in signals.names.iter().enumerate() {
        let values: Vec<f64> = signals.values.iter().map(|u| u[j]).collect();
        let series = Series::new("", signals.times.clone(), values).color(Color::INK);
        let series = if signals.hold == Hold::Previous { series.step() } else { series };
        chart = chart.panel(limited(
            Panel::new(format!("input {}", design.quantities.title(name))).series(series),
            design,
            name,
        ));
    }
    chart
}

/// A panel with the limits of a name.
fn limited(panel: Panel, design: &Design, name: &str) -> Panel {
    match design.limits.iter().find(|l| l.name == name) {
        Some(limit) => panel.named_bound("limit", limit.low).named_bound("limit", limit.high),
        None => panel,
    }
}

fn column(rows: &[Vec<f64>], k: usize, shift: f64) -> Vec<f64> {
    rows.iter().map(|y| y[k] + shift).collect()
}

/// The lines between which measurements lie mostly.
fn band(mut panel: Panel, design: &Design, rows: &[Vec<f64>], k: usize) -> Panel {
    for (side, name) in [(-BAND, "±2 standard deviations"), (BAND, "")] {
        let values = column(rows, k, side * design.noise[k].std);
        panel =
            panel.series(Series::new(name, design.signals.times.clone(), values).color(Color::GRAY).dash(Dash::Dotted));
    }
    panel
}

/// Inputs, and the outputs of both explanations and of the refitted one, with the band of the noise about the other one.
///
/// # Errors
/// [`PlotError`] for numbers that no axis holds.
pub fn discrimination_figure(d: &Discrimination) -> Result<Drawing, PlotError> {
    let design = &d.design;
    let title = format!("{} or {}", d.names[0], d.names[1]);
    let mut chart = inputs(chart_of(design).title(title), design);
    let truth = usize::from(d.weaker().truth == d.names[1]);
    let line = |name: &str, rows: &[Vec<f64>], k: usize, role: Role| {
        Series::new(name, design.signals.times.clone(), column(rows, k, 0.0)).role(role)
    };
    for (k, noise) in design.noise.iter().enumerate() {
        let mut panel = Panel::new(design.quantities.title(&noise.column));
        panel = panel.series(line(&d.names[0], &d.outputs[0], k, Role::Given));
        panel = panel.series(line(&d.names[1], &d.outputs[1], k, Role::Extended));
        if !d.refitted.is_empty() {
            let name = format!("{} refitted", d.weaker().refitted);
            panel = panel.series(line(&name, &d.refitted, k, Role::Refitted));
        }
        chart = chart.panel(limited(band(panel, design, &d.outputs[truth], k), design, &noise.column));
    }
    chart.draw()
}

/// Inputs and outputs, with the band of the noise.
///
/// # Errors
/// [`PlotError`] for numbers that no axis holds.
pub fn identification_figure(d: &Identification) -> Result<Drawing, PlotError> {
    let design = &d.design;
    let mut chart = inputs(chart_of(design).title(d.model.name.clone()), design);
    for (k, noise) in design.noise.iter().enumerate() {
        let values = column(&d.outputs, k, 0.0);
        let series = Series::new("expected", design.signals.times.clone(), values).role(Role::Given);
        let panel = band(Panel::new(design.quantities.title(&noise.column)).series(series), design, &d.outputs, k);
        chart = chart.panel(limited(panel, design, &noise.column));
    }
    chart.draw()
}
