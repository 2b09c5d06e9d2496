//! Friction modes as shaded bands, alike in all figures.

use bracketry_plot::{Color, Interval, Panel, TimeSeries};
use bracketry_sim::{Mode, Trajectory};

/// Shades the modes of the switching function `switch`, if there is one of that name.
pub fn friction_bands(mut panel: Panel, trajectory: &Trajectory, switches: &[String], switch: &str) -> Panel {
    let Some(i) = switches.iter().position(|s| s == switch) else { return panel };
    for m in trajectory.mode_intervals(i) {
        panel = panel.interval(Interval::new(m.from, m.to, category(m.mode)));
    }
    panel
}

fn category(mode: Mode) -> &'static str {
    match mode {
        Mode::Positive => "slides +",
        Mode::Negative => "slides −",
        Mode::Sliding => "slides",
        Mode::Sticking => "sticks",
    }
}

/// The same color for the same mode in every figure.
pub fn friction_colors(figure: TimeSeries) -> TimeSeries {
    let modes = [Mode::Positive, Mode::Negative, Mode::Sticking, Mode::Sliding];
    modes.into_iter().enumerate().fold(figure, |f, (k, m)| f.category_color(category(m), Color::band(k)))
}
