//! Figures of a motion: states and inputs over time, and the path seen from above.

use bracketry_plot::{Drawing, Outline, Panel, PlanView, PlotError, Pose, RecordedMotion, Scene, Series, TimeSeries};
use bracketry_sim::Hold;
use bracketry_steer::Steering;
use bracketry_symbolic::{Func, Node};

use crate::curves::{drawn_times, with_bounds};

/// Points of a line.
const POINTS: usize = 400;
/// Differences below this part of an axis are rounding.
const ROUNDING: f64 = 1e-9;

/// States and inputs over time; `None` without a motion.
pub fn steering_figure(s: &Steering) -> Option<Result<Drawing, PlotError>> {
    let (run, signals) = (s.motion.as_ref()?, s.signals.as_ref()?);
    let times = drawn_times(&run.trajectory);
    let rows: Vec<Vec<f64>> = times.iter().map(|&t| run.trajectory.sample(t)).collect();
    let mut chart = TimeSeries::new()
        .title(format!("{}: motion and inputs", s.system.name))
        .time_label(s.system.quantities.time_title("time"));
    for (k, name) in s.system.state_names().into_iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|x| x[k]).collect();
        let panel = Panel::new(s.system.quantities.title(&name)).rounding(ROUNDING).series(Series::new(
            "",
            times.clone(),
            values,
        ));
        chart = chart.panel(panel.target(s.to[k]));
    }
    for (j, name) in s.system.input_names().into_iter().enumerate() {
        let values: Vec<f64> = signals.values.iter().map(|u| u[j]).collect();
        let series = Series::new("", signals.times.clone(), values);
        let series = if signals.hold == Hold::Previous { series.step() } else { series };
        let panel = Panel::new(format!("input {}", s.system.quantities.title(&name))).rounding(ROUNDING).series(series);
        chart = chart.panel(match s.system.range_of_input(j) {
            Some(range) => with_bounds(panel, range),
            None => panel,
        });
    }
    Some(chart.draw())
}

/// The path of the states x and y seen from above, with the heading where the equations tell it: x' contains the cosine of a
/// state. `None` for a model without such states.
pub fn steering_path(s: &Steering) -> Option<Result<Drawing, PlotError>> {
    let (run, signals) = (s.motion.as_ref()?, s.signals.as_ref()?);
    let (x, y) = (s.system.state_index("x")?, s.system.state_index("y")?);
    let pool = &s.system.pool;
    let angle = pool.reachable(&[s.system.dynamics[x]]).into_iter().find_map(|e| match pool.node(e) {
        Node::Call(Func::Cos, a) => match pool.node(a) {
            Node::Sym(of) => s.system.states.iter().position(|&state| state == of),
            _ => None,
        },
        _ => None,
    });
    let heading = |state: &[f64]| angle.map_or(0.0, |k| state[k]);
    let times: Vec<f64> = (0..=POINTS).map(|k| signals.duration() * k as f64 / POINTS as f64).collect();
    let rows: Vec<Vec<f64>> = times.iter().map(|&t| run.trajectory.sample(t)).collect();
    let column = |k: usize| rows.iter().map(|r| r[k]).collect::<Vec<f64>>();
    let (xs, ys) = (column(x), column(y));
    let extent = |v: &[f64]| {
        v.iter().copied().fold(f64::NEG_INFINITY, f64::max) - v.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let size = extent(&xs).max(extent(&ys)).max(1e-9);
    let (length, width) = (0.045 * size, if angle.is_some() { 0.022 * size } else { 0.045 * size });
    let headings: Vec<f64> = rows.iter().map(|r| heading(r)).collect();
    let motion = RecordedMotion::new("motion", times, xs, ys, headings);
    let scene = Scene::new("", Outline::Ellipse { a: length, b: width })
        .trajectory(motion)
        .time_unit(s.system.quantities.time_unit.name())
        .target(Pose::new(s.to[x], s.to[y], heading(&s.to)));
    Some(
        PlanView::new()
            .title(format!("{}: path, seen from above", s.system.name))
            .labels(s.system.quantities.title("x"), s.system.quantities.title("y"))
            .stamps(12)
            .scene(scene)
            .draw(),
    )
}
