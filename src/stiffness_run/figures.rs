//! A compensation along a log, in pictures.

use bracketry_plot::{Color, Drawing, Interval, Panel, PlotError, Series, TimeSeries};

use super::{CompensatedLog, CompensatedRow};

const HELD: &str = "held: bad input";
const LIMITED: &str = "at a limit";

impl CompensatedLog {
    /// Force of the process, displacement that it causes, and correction of the joints over time; where input was bad or a limit
    /// acted is shaded.
    ///
    /// # Errors
    /// [`PlotError`] for numbers too large for an axis.
    pub fn figure(&self) -> Result<Drawing, PlotError> {
        let t: Vec<f64> = self.rows.iter().map(|row| row.t).collect();
        let line = |name: String, value: &dyn Fn(&CompensatedRow) -> f64| {
            Series::new(name, t.clone(), self.rows.iter().map(value).collect::<Vec<f64>>())
        };
        let mut force = Panel::new("force [N]").height(140.0);
        let mut moved = Panel::new("displacement [mm]").height(140.0);
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            force = force.series(line(axis.to_owned(), &|row| row.wrench[i]));
            moved = moved.series(line(axis.to_owned(), &|row| 1e3 * row.displacement[i]));
        }
        let mut correction = Panel::new("correction [mrad]").height(160.0);
        for i in 0..self.correction_max.len() {
            // A reference that was lost has no correction.
            correction = correction.series(line(format!("joint {}", i + 1), &|row| {
                if row.correction[i].is_finite() { 1e3 * row.correction[i] } else { 0.0 }
            }));
        }
        let mut figure = TimeSeries::new()
            .title(format!("Compensation along the log, {}", self.robot))
            .panel(force)
            .panel(moved)
            .panel(correction)
            .category_color(HELD, Color::band(1))
            .category_color(LIMITED, Color::band(2));
        for (category, acts) in [(HELD, true), (LIMITED, false)] {
            for (start, end) in self.stretches(|row| if acts { row.held } else { row.limited && !row.held }) {
                figure = figure.interval(Interval::new(start, end, category));
            }
        }
        figure.draw()
    }

    /// Intervals of time in which something holds.
    fn stretches(&self, holds: impl Fn(&CompensatedRow) -> bool) -> Vec<(f64, f64)> {
        let mut stretches: Vec<(f64, f64)> = Vec::new();
        let mut open = false;
        for row in &self.rows {
            match (holds(row), open) {
                (true, false) => stretches.push((row.t, row.t + self.period_s)),
                (true, true) => {
                    if let Some(last) = stretches.last_mut() {
                        last.1 = row.t + self.period_s;
                    }
                }
                (false, _) => {}
            }
            open = holds(row);
        }
        stretches
    }
}
