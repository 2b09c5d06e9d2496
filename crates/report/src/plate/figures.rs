//! Figures of a run on the plate.

use bracketry_plate::run::PlateRow;
use bracketry_plate::{PlateExperiment, PlateLog, Shape};
use bracketry_plot::{
    Animation, Color, Dash, Drawing, Outline, Panel, PlanView, PlotError, Pose, RecordedMotion, Role, Scene, Series,
    Snapshot, TimeSeries,
};

use crate::html::Figure;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Motions below this are rounding, in mm and degrees.
const ROUNDING: f64 = 1e-9;
/// Seconds between two images of the animation, and most of them.
const IMAGE: f64 = 0.05;
const MOST_IMAGES: usize = 1200;
/// Share of sticking contact from which the object counts as sticking, and below which as sliding.
const STICKS: f64 = 0.999;
const SLIDES: f64 = 0.001;

/// How the object touches the plate, with its colors; numbered in this order.
const CONTACT: [(&str, Color); 4] = [
    ("sticks", Color::GRAY),
    ("slides", Color::ORANGE),
    ("sticks in part", Color::GREEN),
    ("off the plate or tipping", Color::PURPLE),
];

/// Object, plate and contact against time.
///
/// # Errors
/// [`PlotError`] for numbers too large for an axis.
pub fn motion_figure(ran: &PlateExperiment) -> Result<Drawing, PlotError> {
    motion(ran).draw()
}

/// The path of the object seen from above, in the frame of the plate.
///
/// # Errors
/// As [`motion_figure`].
pub fn plan_view_figure(ran: &PlateExperiment) -> Result<Drawing, PlotError> {
    plan_view(ran).draw()
}

/// Run and log in one picture; none without a log.
///
/// # Errors
/// As [`motion_figure`].
pub fn comparison_figure(ran: &PlateExperiment) -> Option<Result<Drawing, PlotError>> {
    ran.log.as_ref().map(|log| overlay(ran, log).draw())
}

/// The figures of a run, the motion first.
pub fn figures(ran: &PlateExperiment) -> Vec<Figure> {
    let mut figures = vec![
        Figure::new("motion", "Object, plate, and contact over time", motion_figure(ran)),
        Figure::new("plan_view", "The path of the object on the plate, seen from above", plan_view_figure(ran)),
    ];
    let comparison = comparison_figure(ran);
    figures.extend(comparison.map(|drawing| Figure::new("comparison", "The run compared with the log", drawing)));
    figures
}

fn title(ran: &PlateExperiment) -> String {
    format!("Experiment {}, model {}", ran.setup.experiment.name, ran.setup.model.name())
}

fn target(ran: &PlateExperiment) -> Pose {
    let [x, y, phi] = ran.setup.target();
    Pose::new(x, y, phi)
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
        .title(title(ran))
        .panel(panel("x [mm]", 0, 1e3))
        .panel(panel("y [mm]", 1, 1e3))
        .panel(panel("φ [°]", 2, DEGREES))
        .panel(plain("plate X [mm]", &|r| 1e3 * r.plate.displacement))
        .panel(plain("plate θ [°]", &|r| DEGREES * r.plate.tilt))
        .panel(plain("normal force [N]", &|r| r.normal_force))
        .panel(plain("sticking fraction [1]", &|r| r.stick_fraction).limits(-0.05, 1.05));
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
            .series(series(ran.setup.model.name(), rows, |r| scale * r.state[k]).color(Color::BLUE).dash(Dash::Dashed));
        let panel = match &ran.with_signs_of_log {
            Some(other) => panel.series(
                series("with the signs of the log", &other.rows, |r| scale * r.state[k])
                    .color(Color::GREEN)
                    .dash(Dash::Dotted),
            ),
            None => panel,
        };
        let panel = panel.rounding(ROUNDING).height(170.0);
        targeted(ran, panel, k, scale)
    };
    TimeSeries::new()
        .title(format!("{}, compared with the log", title(ran)))
        .panel(panel("x [mm]", 0, 1e3, &log.x))
        .panel(panel("y [mm]", 1, 1e3, &log.y))
        .panel(panel("φ [°]", 2, DEGREES, &log.phi))
}

fn plan_view(ran: &PlateExperiment) -> PlanView {
    let rows = &ran.run.rows;
    let column = |k: usize| rows.iter().map(|r| r.state[k]).collect::<Vec<_>>();
    let times: Vec<f64> = rows.iter().map(|r| r.t).collect();
    let path = RecordedMotion::new(ran.setup.model.name(), times, column(0), column(1), column(2));
    let mut scene = Scene::new("", outline(&ran.setup.object.shape)).trajectory(path).target(target(ran));
    if let Some(log) = &ran.log {
        // Not in the ink of start and target, which lie over it.
        scene = scene.trajectory(RecordedMotion::new("log", &*log.t, &*log.x, &*log.y, &*log.phi).color(Color::ORANGE));
    }
    PlanView::new()
        .labels("x on the plate [m]", "y on the plate [m]")
        .title(format!("{}, seen from above", title(ran)))
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

/// The object on the plate in real time.
pub fn animation(ran: &PlateExperiment) -> Animation {
    let rows = &ran.run.rows;
    let (from, to) = (rows[0].t, rows[rows.len() - 1].t);
    let count = (((to - from) / IMAGE).floor() as usize + 1).min(MOST_IMAGES);
    let snapshots = (0..count).map(|k| {
        let time = from + IMAGE * k as f64;
        let row = &rows[rows.partition_point(|r| r.t < time - 1e-9).min(rows.len() - 1)];
        Snapshot {
            time,
            displacement: row.plate.displacement,
            tilt: row.plate.tilt,
            pose: Pose::new(row.state[0], row.state[1], row.state[2]),
            gap: row.gap,
            lean: row.lean,
            category: match row.stick_fraction {
                _ if row.gap > 0.0 || row.normal_force.is_nan() => 3,
                s if s >= STICKS => 0,
                s if s <= SLIDES => 1,
                _ => 2,
            },
        }
    });
    let mut animation = Animation::new(outline(&ran.setup.object.shape), 2.0 * ran.setup.object.height)
        .title(title(ran))
        .target(target(ran))
        .path(rows.iter().map(|r| (r.t, r.state[0], r.state[1])));
    for (name, color) in CONTACT {
        animation = animation.category(name, color);
    }
    animation.snapshots(snapshots)
}
