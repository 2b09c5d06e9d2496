//! The figures and animations of the story.

use bracketry::plate::area::AreaOutcome;
use bracketry::plate::control::{RESOLUTION, target_of};
use bracketry::plot::{
    Animation, Color, Dash, Drawing, Interval, Panel, PlanView, PlotError, Pose, RecordedMotion, Role, Scene, Series,
    Snapshot, TimeSeries,
};
use bracketry::report::plate::outline;
use rayon::prelude::*;

use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;
use super::story::{Story, StoryAnimation};
use bracketry::report::Figure;
use bracketry::report::{friction_bands, friction_colors};

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Name of the map from rest to rest.
pub(super) const MAP: &str = "from_rest_map";
/// Chapters.
pub(super) const CHAPTERS: usize = 6;
/// Milliseconds between two points of a curve, and two images of an animation.
const CURVE: usize = 2;
const IMAGE: usize = 50;
/// Speed below which the object counts as sticking to the plate (m/s; the rim's with its spin).
const STICKS: f64 = 1e-6;

/// A trajectory on a regular grid, by column.
struct Columns {
    t: Vec<f64>,
    x: Vec<Vec<f64>>,
}

impl Columns {
    /// Of an exact simulation, every `step` seconds.
    fn of_simulation(trajectory: &bracketry::sim::Trajectory, step: f64) -> Self {
        let count = (trajectory.end() / step).floor() as usize;
        let t: Vec<f64> = (0..=count).map(|k| k as f64 * step).collect();
        let rows: Vec<Vec<f64>> = t.iter().map(|&t| trajectory.sample(t)).collect();
        let x = (0..trajectory.dim()).map(|k| rows.iter().map(|r| r[k]).collect()).collect();
        Self { t, x }
    }

    /// Of states at every millisecond.
    fn of_states(states: &[[f64; 10]]) -> Self {
        let rows = || states.iter().enumerate().step_by(CURVE);
        let x = (0..10).map(|k| rows().map(|(_, x)| x[k]).collect()).collect();
        Self { t: rows().map(|(k, _)| k as f64 * RESOLUTION).collect(), x }
    }

    fn line(&self, name: &str, k: usize, scale: f64) -> Series {
        Series::new(name, self.t.clone(), self.x[k].iter().map(|v| v * scale).collect::<Vec<_>>())
    }

    fn path(&self, name: &str) -> RecordedMotion {
        RecordedMotion::new(name, self.t.clone(), self.x[0].clone(), self.x[1].clone(), self.x[2].clone())
    }
}

/// What becomes of the object where contact over its footprint ends, as a mark in figures has room for.
fn end_of_contact(stopped: Option<&AreaOutcome>) -> Option<&'static str> {
    match stopped? {
        AreaOutcome::Finished => None,
        AreaOutcome::Tipping { .. } => Some("tips"),
        AreaOutcome::LiftOff { .. } => Some("lifts off"),
        AreaOutcome::NotFinite { .. } => Some("state no longer finite"),
    }
}

fn figure(name: &str, caption: &str, drawing: Result<Drawing, PlotError>) -> Figure {
    Figure::new(name, caption, drawing)
}

impl MoveOnEquations {
    fn target(&self) -> Pose {
        let [x, y, phi] = target_of(&self.problem);
        Pose::new(x, y, phi)
    }

    /// Object, plate and inputs against time, with the friction modes.
    fn closed_loop(&self) -> TimeSeries {
        let together = &self.together;
        let c = Columns::of_simulation(&together.recording.trajectory, 2e-3);
        let run = &together.run.closed_loop;
        let input = |k: usize| {
            let u: Vec<f64> = run.u.iter().map(|u| u[k]).collect();
            Series::new("", run.t[..u.len()].to_vec(), u).color(Role::Given.color()).step()
        };
        let panel = |label: &str, k: usize, scale: f64| {
            Panel::new(label).series(c.line("", k, scale).color(Role::Given.color()))
        };
        let friction = |panel: Panel, switch: &str| {
            friction_bands(panel, &together.recording.trajectory, &together.switches, switch)
        };
        let bounded = |panel: Panel, k: usize, scale: f64| {
            let b = self.problem.ocp.state_bounds[k];
            panel.bound(b.min * scale).bound(b.max * scale)
        };
        let held = |label: &str, k: usize| {
            let (min, max) = self.problem.ocp.input_bounds[k];
            Panel::new(label).series(input(k)).bound(min).bound(max)
        };
        let [x, y, phi] = target_of(&self.problem);
        friction_colors(TimeSeries::new())
            .title("Position and orientation together, closed loop on exact stick–slip friction")
            .panel(friction(panel("x [m]", 0, 1.0).target(x), "vx"))
            .panel(friction(panel("ẋ [m/s]", 3, 1.0), "vx"))
            .panel(friction(panel("y [m]", 1, 1.0).target(y), "vy"))
            .panel(friction(panel("ẏ [m/s]", 4, 1.0), "vy"))
            .panel(panel("φ [°]", 2, DEGREES).target(phi * DEGREES))
            .panel(bounded(panel("X [m]", 6, 1.0), 6, 1.0))
            .panel(bounded(panel("θ [°]", 8, DEGREES), 8, DEGREES))
            .panel(held("Ẍ [m/s²]", 0))
            .panel(held("θ̈ [rad/s²]", 1))
    }

    /// Both methods over the time of the slower one.
    fn comparison(&self) -> TimeSeries {
        let together = Columns::of_simulation(&self.together.recording.trajectory, 2e-3);
        let steps = Columns::of_simulation(&self.two.trajectory, 5e-3);
        let panel = |label: &str, k: usize, scale: f64| {
            Panel::new(label)
                .series(together.line("together (MPC)", k, scale).color(Role::Given.color()))
                .series(steps.line("two steps (published inputs)", k, scale).color(Color::GREEN).dash(Dash::Dashed))
                .target(target_of(&self.problem)[k] * scale)
        };
        let mut yaw = panel("φ [°]", 2, DEGREES);
        // Spin without friction runs away; what matters happens around the target.
        let limit = 3.0 * target_of(&self.problem)[2] * DEGREES;
        if steps.x[2].iter().any(|v| v.abs() * DEGREES > limit) {
            yaw = yaw.limits(-0.1 * limit, limit);
        }
        let mut chart = TimeSeries::new()
            .title("Together and in two steps, on the same plant")
            .panel(panel("x [m]", 0, 1.0))
            .panel(panel("y [m]", 1, 1.0))
            .panel(yaw);
        let names = ["two steps: turning", "two steps: moving along x", "two steps: moving along y"];
        for (stage, name) in self.two.stages.iter().zip(names) {
            chart = chart.interval(Interval::new(stage.from, stage.to, name));
        }
        chart
    }

    /// Seen from above, both methods side by side.
    fn plan_view(&self) -> PlanView {
        let scene = |title: &str, name: &str, color: Color, trajectory: &bracketry::sim::Trajectory| {
            let path = Columns::of_simulation(trajectory, 5e-3).path(name).color(color);
            Scene::new(title, outline(&self.shape)).trajectory(path).target(self.target())
        };
        PlanView::new()
            .title("Together and in two steps, seen from above in the frame of the plate")
            .scene(scene("Together", "MPC", Role::Given.color(), &self.together.recording.trajectory))
            .scene(scene("Two steps", "published inputs", Color::GREEN, &self.two.trajectory))
    }

    /// States at every millisecond.
    pub(super) fn states(&self) -> Vec<[f64; 10]> {
        let trajectory = &self.together.recording.trajectory;
        let count = (trajectory.end() / RESOLUTION).round() as usize;
        let mut states = vec![[0.0; 10]; count + 1];
        for (k, state) in states.iter_mut().enumerate() {
            trajectory.sample_into(k as f64 * RESOLUTION, state);
        }
        states
    }
}

impl Story {
    /// Every figure, chapter by chapter.
    pub fn figures(&self) -> Vec<Figure> {
        self.chapters().into_iter().flatten().collect()
    }

    /// The figures of each chapter.
    pub(super) fn chapters(&self) -> [Vec<Figure>; CHAPTERS] {
        let growth = bracketry::report::analysis::growth_figure(&self.analysis).draw();
        let mut first = vec![figure("growth", "Directions spanned by the brackets, by bracket length.", growth)];
        if let Some(reach) = bracketry::report::analysis::reach_figure(&self.analysis) {
            let caption = "Influence of the inputs on the states, by round of brackets.";
            first.push(figure("reach", caption, reach.draw()));
        }
        let caption = "Coordinates that inputs change from rest to rest, over the largest acceleration of the plate (m/s²) and its largest \
                       tilt (rad).";
        first.push(figure(
            MAP,
            caption,
            bracketry::report::from_rest::from_rest_map_figure(&self.published.quantities, &self.from_rest),
        ));
        let m = &self.on_equations;
        let second = vec![
            figure(
                "closed_loop",
                "Object, plate, and inputs over time; shaded where friction sticks or slides.",
                m.closed_loop().draw(),
            ),
            figure(
                "comparison",
                "The same move with the published method, one coordinate after the other.",
                m.comparison().draw(),
            ),
            figure(
                "plan_view",
                "Both methods, seen from above; the object is drawn at intervals.",
                m.plan_view().draw(),
            ),
        ];
        let on_plant = |moved: &MoveOnPlant, name: &str, title: &str, role: Role| {
            vec![
                figure(
                    name,
                    "Closed loop and open loop on the area-contact plant, compared with the controller's plan; the band is \
                     the tolerance of ± 2 mm and ± 2°.",
                    against_plan(moved, title, role),
                ),
                figure(
                    &format!("{name}_plan_view"),
                    "The closed loop and the open loop on the area-contact plant, seen from above.",
                    self.plan_view(moved, &format!("{title}, seen from above"), role),
                ),
            ]
        };
        let third = on_plant(
            &self.as_published,
            "as_published",
            "Control of the true plant with the published model",
            Role::Given,
        );
        let mut fourth = self.diagnosis.figures();
        for f in &mut fourth {
            f.name = format!("diagnosis_{}", f.name);
        }
        let mut sixth = self.extended.as_ref().map_or_else(Vec::new, |moved| {
            on_plant(moved, "extended", "Control of the true plant with the extended model", Role::Extended)
        });
        if let Some(extended) = &self.extended {
            sixth.push(figure(
                "before_and_after",
                "Closed loop on the area-contact plant with either model; the band is the tolerance of ± 2 mm and ± 2°.",
                before_and_after(&self.as_published, extended),
            ));
        }
        let fifth = self.extended_analysis.iter().map(|a| {
            figure(
                "extended_growth",
                "Directions spanned by the brackets of the extended model.",
                bracketry::report::analysis::growth_figure(a).draw(),
            )
        });
        [first, second, third, fourth, fifth.collect(), sixth]
    }

    /// Animations as GIF: name, chapter, caption.
    ///
    /// # Errors
    /// [`PlotError`] for numbers that no axis holds.
    pub fn animations(&self) -> Result<Vec<StoryAnimation>, PlotError> {
        let mut moves = vec![
            (
                "together",
                2,
                "On the published equations",
                self.animation(&self.on_equations.states(), None, Role::Given),
            ),
            (
                "as_published",
                3,
                "Simulated plant, controller with the published model",
                self.animation_on_plant(&self.as_published, Role::Given),
            ),
        ];
        if let Some(moved) = &self.extended {
            let animation = self.animation_on_plant(moved, Role::Extended);
            moves.push(("extended", 6, "Simulated plant, controller with the extended model", animation));
        }
        moves
            .into_par_iter()
            .map(|(name, chapter, title, animation)| {
                let animation = animation.title(title);
                Ok(StoryAnimation { name, chapter, title, gif: animation.gif()?, still: animation.still()? })
            })
            .collect()
    }

    fn animation_on_plant(&self, moved: &MoveOnPlant, role: Role) -> Animation {
        self.animation(&moved.closed_loop, end_of_contact(moved.stopped.as_ref()), role)
    }

    fn animation(&self, states: &[[f64; 10]], end: Option<&str>, role: Role) -> Animation {
        let target = self.on_equations.target();
        let reach = self.shape().rim(64).into_iter().map(|[x, y]| x.hypot(y)).fold(0.0, f64::max);
        // The end belongs to it wherever it falls.
        let shown = (0..states.len()).filter(|k| k % IMAGE == 0 || k + 1 == states.len());
        let snapshots = shown.map(|k| (k, states[k])).map(|(k, x)| Snapshot {
            time: k as f64 * RESOLUTION,
            displacement: x[6],
            tilt: x[8],
            pose: Pose::new(x[0], x[1], x[2]),
            gap: 0.0,
            lean: 0.0,
            category: usize::from(x[3].hypot(x[4]) + reach * x[5].abs() > STICKS),
        });
        let animation = Animation::new(outline(self.shape()), 0.005)
            .role(role)
            .target(target)
            .path(states.iter().enumerate().map(|(k, x)| (k as f64 * RESOLUTION, x[0], x[1])))
            .category("rests on the plate", Color::GRAY)
            .category("slides", Color::ORANGE)
            .snapshots(snapshots);
        match end {
            Some(what) => animation.end(format!("the object {what}")),
            None => animation,
        }
    }

    fn plan_view(&self, moved: &MoveOnPlant, title: &str, role: Role) -> Result<Drawing, PlotError> {
        let [x, y, phi] = target_of(&moved.problem);
        let scene = |title: &str, states: &[[f64; 10]], stopped: Option<&AreaOutcome>| {
            let mut path = Columns::of_states(states).path("").role(role);
            path.end = end_of_contact(stopped).map(str::to_owned);
            Scene::new(title, outline(self.shape())).trajectory(path).target(Pose::new(x, y, phi))
        };
        PlanView::new()
            .title(title)
            .scene(scene("Closed loop", &moved.closed_loop, moved.stopped.as_ref()))
            .scene(scene("Plan alone", &moved.plan_alone, moved.plan_stopped.as_ref()))
            .draw()
    }
}

/// Panels of x (mm), y (mm) and yaw (deg) with targets and tolerances, filled by `series` of coordinate and scale.
fn pose_panels(moved: &MoveOnPlant, series: impl Fn(usize, f64) -> Vec<Series>) -> TimeSeries {
    let target = target_of(&moved.problem);
    let axes = [("x [mm]", 1e3, 2.0), ("y [mm]", 1e3, 2.0), ("φ [°]", DEGREES, 2.0)];
    axes.into_iter().enumerate().fold(TimeSeries::new(), |chart, (k, (label, scale, tolerance))| {
        let at = scale * target[k];
        let panel = Panel::new(label).target(at).target_band(at - tolerance, at + tolerance);
        chart.panel(series(k, scale).into_iter().fold(panel, Panel::series))
    })
}

/// The plan, what it does alone, and the closed loop.
fn against_plan(moved: &MoveOnPlant, title: &str, role: Role) -> Result<Drawing, PlotError> {
    let (closed, alone) = (Columns::of_states(&moved.closed_loop), Columns::of_states(&moved.plan_alone));
    let promised = |k: usize, scale: f64| {
        let plan = moved.run.plan.as_ref().map(|p| &p.trajectory)?;
        let t: Vec<f64> = (0..=plan.steps()).map(|i| i as f64 * moved.problem.ocp.dt).collect();
        let values: Vec<f64> = (0..=plan.steps()).map(|i| scale * plan.x(i)[k]).collect();
        Some(Series::new("plan, as predicted by its model", t, values).role(Role::Promised))
    };
    pose_panels(moved, |k, scale| {
        let mut all: Vec<Series> = promised(k, scale).into_iter().collect();
        let lines = [
            (&alone, "open loop, true plant", Dash::Dotted, &moved.plan_stopped),
            (&closed, "closed loop, true plant", role.dash(), &moved.stopped),
        ];
        all.extend(lines.map(|(columns, name, dash, stopped)| {
            ending(columns.line(name, k, scale).role(role).dash(dash), stopped.as_ref())
        }));
        all
    })
    .title(title)
    .draw()
}

/// A line with a mark where contact over the footprint ended.
fn ending(line: Series, stopped: Option<&AreaOutcome>) -> Series {
    Series { end: end_of_contact(stopped).map(str::to_owned), ..line }
}

/// The closed loops with both models.
fn before_and_after(published: &MoveOnPlant, extended: &MoveOnPlant) -> Result<Drawing, PlotError> {
    let (before, after) = (Columns::of_states(&published.closed_loop), Columns::of_states(&extended.closed_loop));
    pose_panels(extended, |k, scale| {
        vec![
            ending(before.line("published model", k, scale).role(Role::Given), published.stopped.as_ref()),
            ending(after.line("extended model", k, scale).role(Role::Extended), extended.stopped.as_ref()),
        ]
    })
    .title("Closed loop on the true plant, published and extended model")
    .draw()
}
