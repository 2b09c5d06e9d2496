//! Friction modes as shaded bands, alike in all figures.

use bracketry_plot::{Color, Interval, Panel, TimeSeries};
use bracketry_sim::{FrictionMode, Trajectory};

/// Shades the modes of the switching function `switch`, if there is one of that name.
pub fn friction_bands(mut panel: Panel, trajectory: &Trajectory, switches: &[String], switch: &str) -> Panel {
    let Some(i) = switches.iter().position(|s| s == switch) else { return panel };
    for m in trajectory.mode_intervals(i) {
        panel = panel.interval(Interval::new(m.from, m.to, category(m.mode)));
    }
    panel
}

fn category(mode: FrictionMode) -> &'static str {
    match mode {
        FrictionMode::Positive => "slides +",
        FrictionMode::Negative => "slides −",
        FrictionMode::Sliding => "slides",
        FrictionMode::Sticking => "sticks",
    }
}

/// The same color for the same mode in every figure.
pub fn friction_colors(figure: TimeSeries) -> TimeSeries {
    let modes = [FrictionMode::Positive, FrictionMode::Negative, FrictionMode::Sticking, FrictionMode::Sliding];
    modes.into_iter().enumerate().fold(figure, |f, (k, m)| f.category_color(category(m), Color::band(k)))
}
