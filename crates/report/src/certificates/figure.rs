//! The picture of a region of attraction.

use bracketry_certify::Portrait;
use bracketry_plot::{Color, Drawing, Panel, PlotError, Series, XyChart};
use bracketry_system::Quantities;

fn columns(points: &[[f64; 2]]) -> (Vec<f64>, Vec<f64>) {
    points.iter().map(|p| (p[0], p[1])).unzip()
}

/// The proved region with its curve V = c, simulated motions from it, and the boundary of attraction as simulation shows it.
///
/// # Errors
/// [`PlotError`] for numbers that no axis holds.
pub fn region_figure(title: &str, quantities: &Quantities, portrait: &Portrait) -> Result<Drawing, PlotError> {
    let mut panel = Panel::new(quantities.title(&portrait.axes[1]));
    for (k, motion) in portrait.motions.iter().enumerate() {
        let (x, y) = columns(motion);
        let name = if k == 0 { "simulated motions" } else { "" };
        panel = panel.series(Series::new(name, x, y).color(Color::GRAY.mix(Color(255, 255, 255), 0.4)));
    }
    let (x, y) = columns(&portrait.level);
    panel = panel.series(Series::new("proved: V = c", x, y).color(Color::BLUE));
    if !portrait.boundary.is_empty() {
        let (x, y) = columns(&portrait.boundary);
        panel = panel.series(Series::new("boundary found by simulation", x, y).color(Color::VERMILLION).points());
    }
    let center = Series::new("equilibrium", vec![portrait.center[0]], vec![portrait.center[1]]);
    panel = panel.series(center.color(Color::INK).points()).height(520.0);
    XyChart::new(quantities.title(&portrait.axes[0]), panel).title(title).draw()
}
