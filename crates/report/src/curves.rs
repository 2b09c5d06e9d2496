//! At which times a computed motion is drawn, and between which bounds.

use bracketry_plot::Panel;
use bracketry_sim::Trajectory;

/// A line has a point at least at every such part of the motion.
const PARTS: f64 = 400.0;

/// The times of the steps of a motion, at which inputs jump and friction changes its mode, and so many between them that straight lines look
/// like the curve.
pub(crate) fn drawn_times(motion: &Trajectory) -> Vec<f64> {
    let longest = (motion.end() - motion.start()) / PARTS;
    let steps: Vec<f64> = motion.times().collect();
    let mut times = Vec::new();
    for pair in steps.windows(2) {
        let parts = ((pair[1] - pair[0]) / longest).ceil().max(1.0) as usize;
        times.extend((0..parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64));
    }
    times.extend(steps.last());
    times
}

/// A panel with the bounds that are finite.
pub(crate) fn with_bounds(panel: Panel, bounds: (f64, f64)) -> Panel {
    [bounds.0, bounds.1].into_iter().filter(|bound| bound.is_finite()).fold(panel, Panel::bound)
}
