//! Files of a run on the plate: table, plots, animation.

use std::path::Path;

use anyhow::Context;
use bracketry::plot::{Animation, Color, Dash, Panel, PlanView, Pose, Scene, Series, Snapshot, TimeSeries, Trajectory};
use bracketry::{PlateLog, PlateRow, outline};

use super::super::output::{csv, figure, json, write};
use super::Ran;
use super::report::Report;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Seconds between two images of the animation, and most of them.
const IMAGE: f64 = 0.05;
const MOST_IMAGES: usize = 1200;
/// Share of sticking contact from which the object counts as sticking, and below which as sliding.
const STICKS: f64 = 0.999;
const SLIDES: f64 = 0.001;

/// How the object touches the plate, with its colours; numbered in this order.
const CONTACT: [(&str, Color); 4] = [
    ("sticks", Color::GREY),
    ("slides", Color::ORANGE),
    ("sticks in part", Color::GREEN),
    ("off the plate or tipping", Color::PURPLE),
];

/// Writes everything; gives the names of the files.
pub(super) fn write_all(dir: &Path, ran: &Ran, report: &Report, gif: bool) -> anyhow::Result<Vec<&'static str>> {
    let mut names = vec!["plate.json", "trajectory.csv", "motion.svg", "motion.png", "plan_view.svg", "plan_view.png"];
    write(&dir.join("plate.json"), &json(report)?)?;
    table(&dir.join("trajectory.csv"), &ran.run.rows)?;
    figure(motion(ran).draw(), &dir.join("motion"));
    figure(plan_view(ran).draw(), &dir.join("plan_view"));
    if let Some(log) = &ran.log {
        figure(overlay(ran, log).draw(), &dir.join("comparison"));
        names.extend(["comparison.svg", "comparison.png"]);
    }
    if gif {
        animation(ran).save(dir.join("plate.gif")).context("no animation")?;
        names.push("plate.gif");
    }
    Ok(names)
}

fn table(path: &Path, rows: &[PlateRow]) -> anyhow::Result<()> {
    let header = [
        "t",
        "plate_X",
        "plate_theta",
        "x_plate",
        "y_plate",
        "phi_plate",
        "vx",
        "vy",
        "w",
        "amp",
        "normal_force",
        "stick_fraction",
        "gap",
        "lean",
    ];
    let values: Vec<Vec<f64>> = rows
        .iter()
        .map(|r| {
            let mut row = vec![r.t, r.plate.displacement, r.plate.tilt];
            row.extend(r.state);
            row.extend([r.amplitude, r.normal_force, r.stick_fraction, r.gap, r.lean]);
            row
        })
        .collect();
    // A logged motion has no amplitude of its own: the column is left out.
    let amplitude = rows.iter().all(|r| r.amplitude.is_finite());
    let keep = |name: &&str| amplitude || *name != "amp";
    let names: Vec<String> = header.iter().filter(|n| keep(n)).map(|n| (*n).to_owned()).collect();
    let kept: Vec<Vec<f64>> = values
        .into_iter()
        .map(|row| row.into_iter().zip(header).filter(|(_, n)| keep(n)).map(|(v, _)| v).collect())
        .collect();
    csv(path, &names, kept.iter().map(Vec::as_slice))
}

fn series(name: &str, rows: &[PlateRow], value: impl Fn(&PlateRow) -> f64) -> Series {
    // What the model does not tell is left out.
    let (t, values): (Vec<f64>, Vec<f64>) = rows.iter().map(|r| (r.t, value(r))).filter(|(_, v)| !v.is_nan()).unzip();
    Series::new(name, t, values)
}

fn title(ran: &Ran) -> String {
    format!("Experiment {}, model {}", ran.setup.experiment.name, ran.setup.model.name())
}

fn targeted(ran: &Ran, panel: Panel, coordinate: usize, scale: f64) -> Panel {
    if ran.setup.coordinate() == coordinate { panel.target(scale * ran.setup.experiment.target) } else { panel }
}

/// Object, plate and contact against time.
fn motion(ran: &Ran) -> TimeSeries {
    let rows = &ran.run.rows;
    let panel = |label: &str, k: usize, scale: f64| {
        targeted(ran, Panel::new(label).series(series("", rows, |r| scale * r.state[k])), k, scale)
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
        .panel(plain("share that sticks [1]", &|r| r.stick_fraction).limits(-0.05, 1.05));
    if rows.iter().any(|r| r.gap > 0.0) {
        chart = chart.panel(plain("gap [mm]", &|r| 1e3 * r.gap));
    }
    chart
}

/// Run and log in one picture.
fn overlay(ran: &Ran, log: &PlateLog) -> TimeSeries {
    let rows = &ran.run.rows;
    let (from, to) = (rows[0].t, rows[rows.len() - 1].t);
    let panel = |label: &str, k: usize, scale: f64, logged: &[f64]| {
        let kept: Vec<(f64, f64)> =
            log.t.iter().zip(logged).filter(|(t, _)| (from..=to).contains(*t)).map(|(t, v)| (*t, scale * v)).collect();
        let (t, v): (Vec<f64>, Vec<f64>) = kept.into_iter().unzip();
        let panel = Panel::new(label)
            .series(Series::new("log", t, v).color(Color::ORANGE))
            .series(series(ran.setup.model.name(), rows, |r| scale * r.state[k]).color(Color::BLUE).dash(Dash::Dashed))
            .height(170.0);
        targeted(ran, panel, k, scale)
    };
    TimeSeries::new()
        .title(format!("{}, beside the log", title(ran)))
        .panel(panel("x [mm]", 0, 1e3, &log.x))
        .panel(panel("y [mm]", 1, 1e3, &log.y))
        .panel(panel("φ [°]", 2, DEGREES, &log.phi))
}

/// Where the object should go; the other coordinates as they were at the start.
fn target(ran: &Ran) -> Pose {
    let mut pose = ran.setup.start;
    pose[ran.setup.coordinate()] = ran.setup.experiment.target;
    Pose::new(pose[0], pose[1], pose[2])
}

fn plan_view(ran: &Ran) -> PlanView {
    let rows = &ran.run.rows;
    let column = |k: usize| rows.iter().map(|r| r.state[k]).collect::<Vec<_>>();
    let times: Vec<f64> = rows.iter().map(|r| r.t).collect();
    let path = Trajectory::new(ran.setup.model.name(), times, column(0), column(1), column(2));
    let mut scene = Scene::new("", outline(&ran.setup.object.shape)).trajectory(path).target(target(ran));
    if let Some(log) = &ran.log {
        scene = scene.trajectory(Trajectory::new("log", &*log.t, &*log.x, &*log.y, &*log.phi));
    }
    PlanView::new().title(format!("{}, seen from above in the frame of the plate", title(ran))).scene(scene)
}

fn animation(ran: &Ran) -> Animation {
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
