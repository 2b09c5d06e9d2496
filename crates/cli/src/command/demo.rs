//! The main job: the story of the plate, from its published equations to a controller that works on the true plant.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::demo::{Finding, MoveOnEquations, MoveOnPlant, Story, StoryEvent, StorySettings};
use clap::Args;
use rayon::prelude::*;

use super::output::{self, PageArgs, csv, figure, json, write};
use super::own_folder::OwnFolder;
use super::progress::spinner;
use super::seed::seed;
use super::{CommonArgs, Outcome, analyze};

/// Distance of the rows of the trajectories on the published equations (s), and of those on the true plant (ms).
const CSV_STEP: f64 = 5e-3;
const CSV_MILLISECONDS: usize = 5;
/// Chapters of the story, and what is made after the last one.
const CHAPTERS: usize = 6;
const AT_THE_END: &str = "report.html, main.json, figures, and animations";

pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("From the published equations of the plate to a controller on the plant", "bracketry demo"),
    ("With other excitations and other noise", "bracketry demo --seed 7 --out out/seed_7"),
    ("For other programs", "bracketry demo --json"),
];

/// Arguments of `bracketry demo`.
#[derive(Args)]
pub(crate) struct DemoArgs {
    #[command(flatten)]
    page: PageArgs,
    /// Seed of the experiments and of the noise
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = seed)]
    seed: Option<u64>,
}

/// Runs everything and writes the results into a folder of its own, chapter by chapter.
pub(crate) fn run(args: &DemoArgs, options: &CommonArgs) -> anyhow::Result<Outcome> {
    let out = options.out.clone().unwrap_or_else(|| PathBuf::from("out/demo"));
    let own = OwnFolder::open(&out)?;
    let progress = spinner("");
    let standard = StorySettings::default();
    let settings = StorySettings { seed: args.seed.unwrap_or(standard.seed), ..standard };
    let mut written = Written { own: &own, text: String::new() };
    let mut broken = Ok(());
    let story = Story::tell(&settings, &mut |event| {
        if broken.is_ok() {
            broken = match event {
                StoryEvent::Working(chapter, what) => {
                    progress.set_message(format!("chapter {chapter} of {CHAPTERS}: {what}"));
                    Ok(())
                }
                StoryEvent::Told(text) => {
                    let printed = if options.json { Ok(()) } else { progress.suspend(|| output::line(text)) };
                    printed.and_then(|()| written.told(text))
                }
                StoryEvent::Found(finding) => written.found(finding),
            };
        }
    })?;
    broken?;
    progress.set_message("figures, animations, and the page");
    let animations = story.animations()?;
    for film in &animations {
        std::fs::write(out.join(format!("{}.gif", film.name)), &film.gif)?;
    }
    story.figures().into_par_iter().for_each(|f| {
        figure(&f.drawing, &out.join(f.name));
    });
    let summary = json(&story.summary())?;
    write(&out.join("main.json"), &summary)?;
    write(&out.join("report.html"), &story.page(&animations, &own.names()?))?;
    progress.finish_and_clear();
    let closing = format!(
        "written to {}: report.html (everything on one page), report.txt, main.json, analysis.json, affine.toml, extended.toml,\n\
         logs and trajectories as CSV, figures as SVG and PNG, animations as GIF; {:.1} s to compute",
        out.display(),
        story.seconds
    );
    write(&out.join("report.txt"), &format!("{}{closing}\n", written.text))?;
    own.record()?;
    args.page.open(&out.join("report.html"));
    if options.json {
        output::print(&summary)?;
    } else {
        output::line(&closing)?;
    }
    Ok(if story.succeeded() { Outcome::Done } else { Outcome::Negative })
}

/// What has been written so far.
struct Written<'a> {
    own: &'a OwnFolder,
    text: String,
}

impl Written<'_> {
    /// The report up to here, which says what is missing.
    fn told(&mut self, text: &str) -> anyhow::Result<()> {
        self.text += text;
        self.text.push('\n');
        let mut report = self.text.clone();
        let _ = writeln!(report, "This run has not ended. Missing: what follows in this report, {AT_THE_END}.");
        write(&self.own.path().join("report.txt"), &report)?;
        self.own.record()
    }

    /// The tables and models of a chapter.
    fn found(&self, finding: Finding<'_>) -> anyhow::Result<()> {
        let out = self.own.path();
        match finding {
            Finding::Analysis(analysis) => analyze::save(analysis, out)?,
            Finding::OnEquations(moved) => on_equations(moved, out)?,
            Finding::AsPublished(moved) => on_plant(moved, &out.join("as_published.csv"))?,
            Finding::Logs(logs) => {
                for log in logs.iter().map(|l| &l.log) {
                    let name = log.name.replace(", ", "_").replace(' ', "_");
                    write(&out.join(format!("log_{name}.csv")), &log.csv())?;
                }
            }
            Finding::Diagnosis(report) => {
                if let Some(model) = &report.evidence.model {
                    write(&out.join("extended.toml"), &model.to_toml()?)?;
                }
            }
            Finding::Extended(moved) => on_plant(moved, &out.join("extended.csv"))?,
        }
        self.own.record()
    }
}

/// The move on the published equations and the published method.
fn on_equations(own: &MoveOnEquations, out: &Path) -> anyhow::Result<()> {
    let sampled = |trajectory: &bracketry::sim::Trajectory| -> Vec<Vec<f64>> {
        let count = (trajectory.end() / CSV_STEP).round() as usize;
        let times = (0..=count).map(|k| k as f64 * CSV_STEP);
        times.map(|t| std::iter::once(t).chain(trajectory.sample(t)).collect()).collect()
    };
    let mut header = states(&own.problem);
    let names = header.clone();
    header.extend(own.problem.plant.input_names());
    let mut rows = sampled(&own.together.recording.trajectory);
    let run = &own.together.run.closed_loop;
    for row in &mut rows {
        let k = run.t.partition_point(|&t| t <= row[0] + 1e-9).clamp(1, run.u.len());
        row.extend(&run.u[k - 1]);
    }
    csv(&out.join("simultaneous.csv"), &header, rows.iter().map(Vec::as_slice))?;
    csv(&out.join("two_step.csv"), &names[..7], sampled(&own.two.trajectory).iter().map(Vec::as_slice))
}

/// A closed loop on the plant.
fn on_plant(moved: &MoveOnPlant, path: &Path) -> anyhow::Result<()> {
    let rows = moved.closed_loop.iter().enumerate().step_by(CSV_MILLISECONDS);
    let rows: Vec<Vec<f64>> =
        rows.map(|(k, x)| std::iter::once(k as f64 * 1e-3).chain(x.iter().copied()).collect()).collect();
    csv(path, &states(&moved.problem), rows.iter().map(Vec::as_slice))
}

fn states(problem: &bracketry::mpc::ControlProblem) -> Vec<String> {
    std::iter::once("t".to_owned()).chain(problem.plant.state_names()).collect()
}
