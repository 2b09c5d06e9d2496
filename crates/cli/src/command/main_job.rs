//! The main job: the story of the plate, from its published equations to a controller that works on the true plant.

use std::path::{Path, PathBuf};

use bracketry_cli::demo::{Story, StoryEvent, StorySettings};

use super::output::{self, csv, figure, folder, json, write};
use super::{Outcome, OutputArgs, analyze};

/// Distance of the rows of the trajectories on the published equations (s), and of those on the true plant (ms).
const CSV_STEP: f64 = 5e-3;
const CSV_MILLISECONDS: usize = 5;

/// Runs everything and writes `out/`.
pub(crate) fn run(options: &OutputArgs, seed: Option<u64>) -> anyhow::Result<Outcome> {
    let out = options.out.clone().unwrap_or_else(|| PathBuf::from("out"));
    folder(&out)?;
    let mut text = String::new();
    let mut broken = Ok(());
    let progress = output::spinner("");
    let standard = StorySettings::default();
    let settings = StorySettings { seed: seed.unwrap_or(standard.seed), ..standard };
    let story = Story::tell(&settings, &mut |event| match event {
        StoryEvent::Working(what) => progress.set_message(what.to_owned()),
        StoryEvent::Told(chapter) => {
            text += chapter;
            text.push('\n');
            if !options.json && broken.is_ok() {
                broken = progress.suspend(|| output::line(chapter));
            }
        }
    })?;
    broken?;
    progress.set_message("figures, animations and the page");
    let animations = story.animations()?;
    write(&out.join("report.html"), &story.page(&animations))?;
    for film in &animations {
        std::fs::write(out.join(format!("{}.gif", film.name)), &film.gif)?;
    }
    analyze::save(&story.analysis, &out)?;
    for f in story.figures() {
        figure(f.drawing, &out.join(f.name));
    }
    write_tables(&story, &out)?;
    let summary = json(&story.summary())?;
    write(&out.join("main.json"), &summary)?;
    progress.finish_and_clear();
    let closing = format!(
        "written to {}: report.html (everything on one page), report.txt, main.json, analysis.json, affine.toml, extended.toml,\n\
         logs and trajectories as CSV, figures as svg and png, animations as gif; {:.1} s to compute",
        out.display(),
        story.seconds
    );
    text += &closing;
    text.push('\n');
    write(&out.join("report.txt"), &text)?;
    if options.json {
        output::print(&summary)?;
    } else {
        output::line(&closing)?;
    }
    Ok(if story.succeeded() { Outcome::Done } else { Outcome::Negative })
}

/// Trajectories and logs as CSV, the extended model as a model file.
fn write_tables(story: &Story, out: &Path) -> anyhow::Result<()> {
    let own = &story.on_equations;
    let sampled = |trajectory: &bracketry::sim::Trajectory| -> Vec<Vec<f64>> {
        let count = (trajectory.end() / CSV_STEP).round() as usize;
        let times = (0..=count).map(|k| k as f64 * CSV_STEP);
        times.map(|t| std::iter::once(t).chain(trajectory.sample(t)).collect()).collect()
    };
    let mut header = vec!["t".to_owned()];
    header.extend(own.problem.plant.state_names());
    let states = header.clone();
    header.extend(own.problem.plant.input_names());
    let mut rows = sampled(&own.together.recording.trajectory);
    let run = &own.together.run.closed_loop;
    for row in &mut rows {
        let k = run.t.partition_point(|&t| t <= row[0] + 1e-9).clamp(1, run.u.len());
        row.extend(&run.u[k - 1]);
    }
    csv(&out.join("simultaneous.csv"), &header, rows.iter().map(Vec::as_slice))?;
    csv(&out.join("two_step.csv"), &states[..7], sampled(&own.two.trajectory).iter().map(Vec::as_slice))?;
    for (name, moved) in [("as_published", Some(&story.as_published)), ("extended", story.extended.as_ref())] {
        let Some(moved) = moved else { continue };
        let rows = moved.closed_loop.iter().enumerate().step_by(CSV_MILLISECONDS);
        let rows: Vec<Vec<f64>> =
            rows.map(|(k, x)| std::iter::once(k as f64 * 1e-3).chain(x.iter().copied()).collect()).collect();
        csv(&out.join(format!("{name}.csv")), &states, rows.iter().map(Vec::as_slice))?;
    }
    for log in story.logs.iter().map(|l| &l.log) {
        let name = log.name.replace(", ", "_").replace(' ', "_");
        write(&out.join(format!("log_{name}.csv")), &log.csv())?;
    }
    if let Some(model) = &story.diagnosis.report.evidence.model {
        write(&out.join("extended.toml"), &model.to_toml()?)?;
    }
    Ok(())
}
