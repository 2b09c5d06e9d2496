//! Figures of an experiment on the plate.

use bracketry_plate::Shape;
use bracketry_plot::{
    Color, Dash, Drawing, Outline, Panel, PlanView, PlotError, Pose, Role, Scene, Series, TimeSeries, Trajectory,
};

use super::{PlateExperiment, PlateLog, PlateRow};

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Motions below this are rounding, in mm and degrees.
const ROUNDING: f64 = 1e-9;

impl PlateExperiment {
    /// Object, plate and contact against time.
    ///
    /// # Errors
    /// [`PlotError`] for numbers too large for an axis.
    pub fn motion_figure(&self) -> Result<Drawing, PlotError> {
        motion(self).draw()
    }

    /// The path of the object seen from above, in the frame of the plate.
    ///
    /// # Errors
    /// As [`Self::motion_figure`].
    pub fn plan_view_figure(&self) -> Result<Drawing, PlotError> {
        plan_view(self).draw()
    }

    /// Run and log in one picture; none without a log.
    ///
    /// # Errors
    /// As [`Self::motion_figure`].
    pub fn comparison_figure(&self) -> Option<Result<Drawing, PlotError>> {
        self.log.as_ref().map(|log| overlay(self, log).draw())
    }

    /// What it is called in figures.
    pub fn title(&self) -> String {
        format!("Experiment {}, model {}", self.setup.experiment.name, self.setup.model.name())
    }

    /// Where the object should go; the other coordinates as they were at the start.
    pub fn target(&self) -> Pose {
        let mut pose = self.setup.start;
        pose[self.setup.coordinate()] = self.setup.experiment.target;
        Pose::new(pose[0], pose[1], pose[2])
    }
}

fn series(name: &str, rows: &[PlateRow], value: impl Fn(&PlateRow) -> f64) -> Series {
    // What the model does not tell is left out.
    let (t, values): (Vec<f64>, Vec<f64>) = rows.iter().map(|r| (r.t, value(r))).filter(|(_, v)| !v.is_nan()).unzip();
    Series::new(name, t, values)
}

fn targeted(ran: &PlateExperiment, panel: Panel, coordinate: usize, scale: f64) -> Panel {
    if ran.setup.coordinate() == coordinate { panel.target(scale * ran.setup.experiment.target) } else { panel }
}

fn motion(ran: &PlateExperiment) -> TimeSeries {
    let rows = &ran.run.rows;
    let panel = |label: &str, k: usize, scale: f64| {
        let line = series("", rows, |r| scale * r.state[k]);
        targeted(ran, Panel::new(label).rounding(ROUNDING).series(line), k, scale)
    };
    let plain = |label: &str, value: &dyn Fn(&PlateRow) -> f64| Panel::new(label).series(series("", rows, value));
    let mut chart = TimeSeries::new()
        .title(ran.title())
        .panel(panel("x [mm]", 0, 1e3))
        .panel(panel("y [mm]", 1, 1e3))
        .panel(panel("φ [°]", 2, DEGREES))
        .panel(plain("plate X [mm]", &|r| 1e3 * r.plate.displacement))
        .panel(plain("plate θ [°]", &|r| DEGREES * r.plate.tilt))
        .panel(plain("normal force [N]", &|r| r.normal_force))
        .panel(plain("share that sticks [1]", &|r| r.stick_fraction).limits(-0.05, 1.05));
    if rows.iter().any(|r| r.gap > 0.0) {
        chart = chart.panel(plain("gap [mm]", &|r| 1e3 * r.gap));
    }
    chart
}

fn overlay(ran: &PlateExperiment, log: &PlateLog) -> TimeSeries {
    let rows = &ran.run.rows;
    let (from, to) = (rows[0].t, rows[rows.len() - 1].t);
    let panel = |label: &str, k: usize, scale: f64, logged: &[f64]| {
        let kept: Vec<(f64, f64)> =
            log.t.iter().zip(logged).filter(|(t, _)| (from..=to).contains(*t)).map(|(t, v)| (*t, scale * v)).collect();
        let (t, v): (Vec<f64>, Vec<f64>) = kept.into_iter().unzip();
        let panel = Panel::new(label)
            .series(Series::new("log", t, v).role(Role::Measured))
            .series(series(ran.setup.model.name(), rows, |r| scale * r.state[k]).color(Color::BLUE).dash(Dash::Dashed))
            .rounding(ROUNDING)
            .height(170.0);
        targeted(ran, panel, k, scale)
    };
    TimeSeries::new()
        .title(format!("{}, beside the log", ran.title()))
        .panel(panel("x [mm]", 0, 1e3, &log.x))
        .panel(panel("y [mm]", 1, 1e3, &log.y))
        .panel(panel("φ [°]", 2, DEGREES, &log.phi))
}

fn plan_view(ran: &PlateExperiment) -> PlanView {
    let rows = &ran.run.rows;
    let column = |k: usize| rows.iter().map(|r| r.state[k]).collect::<Vec<_>>();
    let times: Vec<f64> = rows.iter().map(|r| r.t).collect();
    let path = Trajectory::new(ran.setup.model.name(), times, column(0), column(1), column(2));
    let mut scene = Scene::new("", outline(&ran.setup.object.shape)).trajectory(path).target(ran.target());
    if let Some(log) = &ran.log {
        // Not in the ink of start and target, which lie over it.
        scene = scene.trajectory(Trajectory::new("log", &*log.t, &*log.x, &*log.y, &*log.phi).color(Color::ORANGE));
    }
    PlanView::new()
        .labels("x on the plate [m]", "y on the plate [m]")
        .title(format!("{}, seen from above", ran.title()))
        .scene(scene)
}

/// The contour of an object in pictures.
pub fn outline(shape: &Shape) -> Outline {
    match *shape {
        Shape::Ellipse { a, b } => Outline::Ellipse { a, b },
        Shape::Disk { radius } => Outline::Ellipse { a: radius, b: radius },
        Shape::Rectangle { .. } | Shape::Polygon { .. } => {
            Outline::Polygon(shape.rim(0).into_iter().map(|[x, y]| (x, y)).collect())
        }
    }
}
