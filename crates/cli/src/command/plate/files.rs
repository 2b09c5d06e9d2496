//! Files of a run on the plate: table, plots, animation.

use std::path::Path;

use anyhow::Context;
use bracketry::plot::{Animation, Color, Pose, Snapshot};
use bracketry::{PlateExperiment, PlateReport, PlateRow, outline};

use super::super::output::{csv, figure, json, write};

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
pub(super) fn write_all(
    dir: &Path,
    ran: &PlateExperiment,
    report: &PlateReport,
    gif: bool,
) -> anyhow::Result<Vec<&'static str>> {
    let mut names = vec!["plate.json", "trajectory.csv", "motion.svg", "motion.png", "plan_view.svg", "plan_view.png"];
    write(&dir.join("plate.json"), &json(report)?)?;
    table(&dir.join("trajectory.csv"), &ran.run.rows)?;
    figure(ran.motion_figure(), &dir.join("motion"));
    figure(ran.plan_view_figure(), &dir.join("plan_view"));
    if let Some(drawing) = ran.comparison_figure() {
        figure(drawing, &dir.join("comparison"));
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

fn animation(ran: &PlateExperiment) -> Animation {
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
        .title(ran.title())
        .target(ran.target())
        .path(rows.iter().map(|r| (r.t, r.state[0], r.state[1])));
    for (name, color) in CONTACT {
        animation = animation.category(name, color);
    }
    animation.snapshots(snapshots)
}
