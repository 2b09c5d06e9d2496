//! Figures of trials.

use anyhow::Context;
use bracketry_plate::Shape;
use bracketry_plot::{
    Color, Dash, Drawing, Outline, Panel, PlanView, Pose, RecordedMotion, Scene, Series, TimeSeries, XyChart,
};
use bracketry_trials::{Tolerance, TrialOutcome, TrialReport, TrialRun, TrialSetup, pose_error};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Upper ends of the classes of time to target in s, with their colors.
const CLASSES: [(f64, Color); 4] =
    [(1.5, Color::GREEN), (2.5, Color::SKY), (5.0, Color::BLUE), (f64::INFINITY, Color::PURPLE)];

/// Where figures go and what they are of.
pub(crate) struct Figures {
    pub(crate) folder: PathBuf,
    /// Begin of the names of all files.
    pub(crate) stem: String,
    /// What the titles say of case and object.
    pub(crate) what: String,
}

impl Figures {
    fn save(&self, drawing: &Drawing, name: &str) -> anyhow::Result<()> {
        let path = self.folder.join(format!("{}_{name}.png", self.stem));
        std::fs::write(&path, drawing.png()?).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{}", path.display());
        Ok(())
    }

    /// Every trial by the distance and the turn it asks for, and by where it ends, colored by its time to target or marked
    /// with the reason why there is none.
    pub(crate) fn success(&self, name: &str, key: &str, reports: &[TrialReport]) -> anyhow::Result<()> {
        let way = |r: &TrialReport| {
            let [x, y, phi] = pose_error(r.trial.target, r.trial.start);
            [1e3 * x.hypot(y), phi.to_degrees()]
        };
        let target = |r: &TrialReport| [1e3 * r.trial.target[0], 1e3 * r.trial.target[1]];
        let start = |r: &TrialReport| [1e3 * r.trial.start[0], 1e3 * r.trial.start[1]];
        let maps: [(&str, &str, &str, &Point); 3] = [
            ("distances", "distance [mm]", "turn [°]", &way),
            ("targets", "target x [mm]", "target y [mm]", &target),
            ("starts", "start x [mm]", "start y [mm]", &start),
        ];
        for (map, x_label, y_label, point) in maps {
            let mut panel = Panel::new(y_label).height(if map == "distances" { 340.0 } else { 440.0 });
            for series in classes(reports, point) {
                panel = panel.series(series);
            }
            let drawing = XyChart::new(x_label, panel).title(format!("{}: {}", capitalized(name), self.what)).draw()?;
            self.save(&drawing, &format!("{key}_{map}"))?;
        }
        Ok(())
    }

    /// Empirical distribution of the time to target: the share of all trials that have arrived.
    pub(crate) fn times(&self, all: &[(&str, &[TrialReport])]) -> anyhow::Result<()> {
        let times = |reports: &[TrialReport]| -> Vec<f64> {
            let mut times: Vec<f64> = reports.iter().filter_map(|r| r.outcome.time()).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        let end = all.iter().flat_map(|(_, reports)| times(reports)).fold(1.0, f64::max);
        let mut panel = Panel::new("share of the trials at their target [%]").limits(0.0, 100.0);
        for (name, reports) in all {
            let times = times(reports);
            let share = |k: usize| 100.0 * k as f64 / reports.len() as f64;
            let x: Vec<f64> = [0.0].into_iter().chain(times.iter().copied()).chain([end]).collect();
            let y: Vec<f64> = (0..=times.len()).chain([times.len()]).map(share).collect();
            panel = panel.series(Series::new(*name, x, y).step());
        }
        let drawing =
            XyChart::new("time to target [s]", panel).title(format!("Time to target: {}", self.what)).draw()?;
        self.save(&drawing, "times")
    }

    /// Errors at the end with the box of the tolerance; what lies beyond twice the tolerance is left out.
    pub(crate) fn errors(&self, all: &[(&str, &[TrialReport])], tolerance: Tolerance) -> anyhow::Result<()> {
        let (position, angle) = (1e3 * tolerance.position, tolerance.angle.to_degrees());
        let errors = |r: &TrialReport| [1e3 * r.final_error[0], 1e3 * r.final_error[1], r.final_error[2].to_degrees()];
        let panel = |label: &str, index: usize, bound: f64| {
            let mut panel = Panel::new(label).height(230.0).limits(-2.2 * bound, 2.2 * bound);
            for (name, reports) in all {
                let near = |e: &[f64; 3]| {
                    e[0].abs() <= 2.0 * position && e[1].abs() <= 2.0 * position && e[2].abs() <= 2.0 * angle
                };
                let (x, y): (Vec<f64>, Vec<f64>) =
                    reports.iter().map(errors).filter(near).map(|e| (e[0], e[index])).unzip();
                panel = panel.series(Series::new(*name, x, y).points());
            }
            for (name, size, dash) in [("tolerance", 1.0, Dash::Solid), ("twice the tolerance", 2.0, Dash::Dotted)] {
                let corners = [[-size, -size], [size, -size], [size, size], [-size, size], [-size, -size]];
                let (x, y): (Vec<f64>, Vec<f64>) = corners.iter().map(|[a, b]| (a * position, b * bound)).unzip();
                panel = panel.series(Series::new(name, x, y).color(Color::INK).dash(dash));
            }
            panel
        };
        let drawing = TimeSeries::new()
            .title(format!("Errors at the end: {}", self.what))
            .time_label("error along x [mm]")
            .panel(panel("error along y [mm]", 1, position))
            .panel(panel("error of the yaw [°]", 2, angle))
            .draw()?;
        self.save(&drawing, "errors")
    }

    /// One trial: pose, plate and inputs against time with their bounds, and the view from above.
    pub(crate) fn trial(
        &self,
        name: &str,
        key: &str,
        report: &TrialReport,
        run: &TrialRun,
        setup: &TrialSetup,
    ) -> anyhow::Result<()> {
        let trial = &report.trial;
        let title = format!("{}, trial {}: {}", capitalized(name), trial.index, self.what);
        let t: Vec<f64> = run.samples.iter().map(|s| s.t).collect();
        let line = |name: &str, value: &dyn Fn(usize) -> f64| {
            Series::new(name, t.clone(), (0..t.len()).map(value).collect::<Vec<f64>>())
        };
        let sample = |k: usize| &run.samples[k];
        // The target's yaw in the turn in which the object ends.
        let end = run.samples.last().map_or(0.0, |s| s.object[2]);
        let yaw = trial.target[2] + TAU * ((end - trial.target[2]) / TAU).round();
        let limits = &setup.limits;
        let bounded = |label: &str, bound: f64, series: Series| {
            Panel::new(label).height(95.0).series(series).bound(bound).bound(-bound)
        };
        let mut figure = TimeSeries::new()
            .title(title.clone())
            .panel(
                Panel::new("position [mm]")
                    .height(140.0)
                    .series(line("x", &|k| 1e3 * sample(k).object[0]))
                    .series(line("y", &|k| 1e3 * sample(k).object[1]))
                    .target(1e3 * trial.target[0])
                    .target(1e3 * trial.target[1]),
            )
            .panel(
                Panel::new("yaw [°]")
                    .height(95.0)
                    .series(line("", &|k| sample(k).object[2].to_degrees()))
                    .target(yaw.to_degrees()),
            )
            .panel(bounded("X [mm]", 1e3 * limits.stroke, line("", &|k| 1e3 * sample(k).plate.displacement)))
            .panel(bounded("θ [°]", limits.tilt.to_degrees(), line("", &|k| sample(k).plate.tilt.to_degrees())));
        let instants: Vec<f64> = run.controls.iter().map(|c| c.t).collect();
        let held = |value: &dyn Fn(&bracketry_plate::control::Command) -> f64| {
            Series::new("", instants.clone(), run.controls.iter().map(|c| value(&c.acting)).collect::<Vec<f64>>())
                .step()
        };
        figure = figure
            .panel(bounded("Ẍ [m/s²]", limits.displacement_acceleration, held(&|c| c.displacement_acceleration)))
            .panel(bounded("θ̈ [rad/s²]", limits.tilt_acceleration, held(&|c| c.tilt_acceleration)));
        self.save(&figure.draw()?, &format!("{key}_trial"))?;

        // Up to a little after the arrival.
        let until = report.outcome.time().unwrap_or(f64::INFINITY) + 0.05;
        let shown: Vec<&[f64; 6]> = run.samples.iter().filter(|s| s.t <= until).map(|s| &s.object).collect();
        let column = |i: usize| shown.iter().map(|s| s[i]).collect::<Vec<f64>>();
        let motion = RecordedMotion::new("", &t[..shown.len()], column(0), column(1), column(2));
        let scene = Scene::new("", outline(&setup.object.shape)).trajectory(motion).target(Pose::new(
            trial.target[0],
            trial.target[1],
            trial.target[2],
        ));
        let drawing = PlanView::new().title(title).scene(scene).stamps(5).draw()?;
        self.save(&drawing, &format!("{key}_plan"))
    }
}

/// The place of a trial in a map.
type Point = dyn Fn(&TrialReport) -> [f64; 2];

/// Trials as points, one series for each class of times and for each reason of failing.
fn classes(reports: &[TrialReport], point: &Point) -> Vec<Series> {
    let mut series = Vec::new();
    let mut add = |name: String, color: Color, belongs: &dyn Fn(&TrialReport) -> bool| {
        let (x, y): (Vec<f64>, Vec<f64>) =
            reports.iter().filter(|r| belongs(r)).map(point).map(|[x, y]| (x, y)).unzip();
        if !x.is_empty() {
            series.push(Series::new(name, x, y).color(color).points());
        }
    };
    let mut above = 0.0;
    for (below, color) in CLASSES {
        let name = match (above, below) {
            (0.0, _) => format!("reached within {below} s"),
            (_, f64::INFINITY) => format!("reached after {above} s"),
            _ => format!("reached after {above} to {below} s"),
        };
        add(name, color, &|r| r.outcome.time().is_some_and(|t| t > above && t <= below || t == 0.0 && above == 0.0));
        above = below;
    }
    let mut labels: Vec<&str> = Vec::new();
    for report in reports {
        let label = report.outcome.label();
        if !matches!(report.outcome, TrialOutcome::Reached { .. }) && !labels.contains(&label) {
            labels.push(label);
        }
    }
    for (label, color) in labels.iter().zip([Color::VERMILLION, Color::ORANGE, Color::INK, Color::GRAY].iter().cycle())
    {
        add(format!("not reached: {label}"), *color, &|r| r.outcome.label() == *label);
    }
    series
}

/// A name as the first word of a title.
fn capitalized(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The shape as the plot crate draws it.
fn outline(shape: &Shape) -> Outline {
    match shape {
        Shape::Ellipse { a, b } => Outline::Ellipse { a: *a, b: *b },
        Shape::Disk { radius } => Outline::Ellipse { a: *radius, b: *radius },
        other => Outline::Polygon(other.rim(4).into_iter().map(|[x, y]| (x, y)).collect()),
    }
}
