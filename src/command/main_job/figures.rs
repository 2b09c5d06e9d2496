//! The figures of the main job.

use std::path::Path;

use bracketry::plate::Shape;
use bracketry::plot::{Dash, Interval, Outline, Panel, PlanView, Pose, Scene, Series, TimeSeries, Trajectory};
use bracketry::sim;

use bracketry::{friction_bands, friction_colors, target_of};

use super::Job;
use crate::command::output::figure;

/// Draws all of them into `out`.
pub(crate) fn draw(out: &Path, job: &Job) {
    figure(closed_loop(job).draw(), &out.join("closed_loop"));
    figure(comparison(job).draw(), &out.join("comparison"));
    figure(plan_view(job).draw(), &out.join("plan_view"));
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A trajectory on a regular grid, by column.
struct Columns {
    t: Vec<f64>,
    x: Vec<Vec<f64>>,
}

fn columns(trajectory: &sim::Trajectory, step: f64) -> Columns {
    let count = (trajectory.end() / step).floor() as usize;
    let t: Vec<f64> = (0..=count).map(|k| k as f64 * step).collect();
    let rows: Vec<Vec<f64>> = t.iter().map(|&t| trajectory.sample(t)).collect();
    let x = (0..trajectory.dim()).map(|k| rows.iter().map(|r| r[k]).collect()).collect();
    Columns { t, x }
}

fn line(name: &str, c: &Columns, k: usize, scale: f64) -> Series {
    Series::new(name, c.t.clone(), c.x[k].iter().map(|v| v * scale).collect::<Vec<_>>())
}

/// Object, plate and inputs against time, with the friction modes.
fn closed_loop(job: &Job) -> TimeSeries {
    let together = &job.together;
    let c = columns(&together.recording.trajectory, 2e-3);
    let run = &together.run.closed_loop;
    let input = |k: usize| {
        let u: Vec<f64> = run.u.iter().map(|u| u[k]).collect();
        Series::new("", run.t[..u.len()].to_vec(), u).step()
    };
    let panel = |label: &str, k: usize, scale: f64| Panel::new(label).series(line("", &c, k, scale));
    let friction =
        |panel: Panel, switch: &str| friction_bands(panel, &together.recording.trajectory, &together.switches, switch);
    let bounded = |panel: Panel, k: usize, scale: f64| {
        let b = job.problem.ocp.state_bounds[k];
        panel.bound(b.min * scale).bound(b.max * scale)
    };
    let held = |label: &str, k: usize| {
        let (min, max) = job.problem.ocp.input_bounds[k];
        Panel::new(label).series(input(k)).bound(min).bound(max)
    };
    let [x, y, phi] = target_of(&job.problem);
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

/// Both ways over the time of the slower one.
fn comparison(job: &Job) -> TimeSeries {
    let together = columns(&job.together.recording.trajectory, 2e-3);
    let steps = columns(&job.two.trajectory, 5e-3);
    let panel = |label: &str, k: usize, scale: f64| {
        Panel::new(label)
            .series(line("together (MPC)", &together, k, scale))
            .series(line("two steps (published inputs)", &steps, k, scale).dash(Dash::Dashed))
            .target(target_of(&job.problem)[k] * scale)
    };
    let mut yaw = panel("φ [°]", 2, DEGREES);
    // Spin without friction runs away; what matters happens around the target.
    let limit = 3.0 * target_of(&job.problem)[2] * DEGREES;
    if steps.x[2].iter().any(|v| v.abs() * DEGREES > limit) {
        yaw = yaw.limits(-0.1 * limit, limit);
    }
    let mut chart = TimeSeries::new()
        .title("Together and in two steps, on the same plant")
        .panel(panel("x [m]", 0, 1.0))
        .panel(panel("y [m]", 1, 1.0))
        .panel(yaw);
    let names = ["two steps: turning", "two steps: moving along x", "two steps: moving along y"];
    for (stage, name) in job.two.stages.iter().zip(names) {
        chart = chart.interval(Interval::new(stage.from, stage.to, name));
    }
    chart
}

/// Seen from above, both ways side by side.
fn plan_view(job: &Job) -> PlanView {
    let outline = || match job.shape {
        Shape::Ellipse { a, b } => Outline::Ellipse { a, b },
        Shape::Disk { radius } => Outline::Ellipse { a: radius, b: radius },
        Shape::Rectangle { .. } | Shape::Polygon { .. } => {
            Outline::Polygon(job.shape.rim(0).into_iter().map(|[x, y]| (x, y)).collect())
        }
    };
    let [x, y, phi] = target_of(&job.problem);
    let scene = |title: &str, name: &str, trajectory: &sim::Trajectory| {
        let c = columns(trajectory, 5e-3);
        let path = Trajectory::new(name, c.t.clone(), c.x[0].clone(), c.x[1].clone(), c.x[2].clone());
        Scene::new(title, outline()).trajectory(path).target(Pose::new(x, y, phi))
    };
    PlanView::new()
        .title("Seen from above, in the frame of the plate")
        .scene(scene("Together", "MPC", &job.together.recording.trajectory))
        .scene(scene("Two steps", "published inputs", &job.two.trajectory))
}
