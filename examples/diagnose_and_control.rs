//! What a diagnosis is worth in control: the reference move on a plate that differs from its model, planned and
//! corrected with the model as it was and as the diagnosis extended it.
//!
//! An effect is hidden in the plant with contact over the whole footprint. A multisine is recorded with noise, the model of a
//! disk is diagnosed from this log alone, and then both models move the object by 60 mm, 30 mm and 90° at once on the same
//! plant: the plan in open loop, and in closed loop, planning once more every 20 ms from the measured state.
//!
//! ```text
//! cargo run --release --example diagnose_and_control -- --out out
//! cargo run --release --example diagnose_and_control -- --effect tilt_about_y --seed 3
//! ```
#![allow(clippy::print_stdout)]

use anyhow::Context;
use bracketry::diagnose::{DiagnosisSettings, Record, RecordSettings, diagnose};
use bracketry::mpc::problem::ControlRun;
use bracketry::mpc::{ControlProblem, Plant};
use bracketry::plate::control::target_of;
use bracketry::plate::recording::{PlateMismatch, RecordingSettings, multisine, synthetic_log};
use bracketry::plot::{Dash, Drawing, Panel, Role, Series, TimeSeries};
use bracketry::system::System;
use clap::Parser;
use std::path::PathBuf;

/// Effects that leave the states of the model as they are.
const EFFECTS: [&str; 6] =
    ["none", "tilt_about_x", "tilt_about_y", "friction", "anisotropic_friction", "pressure_radius"];

#[derive(Parser)]
struct Options {
    /// One kind of effect; all of them in turn if absent.
    #[arg(long, value_parser = EFFECTS)]
    effect: Option<String>,
    /// Seed of the sign of the effect, the multisine and the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of the multisine in s.
    #[arg(long, default_value_t = 4.0)]
    seconds: f64,
    /// Folder for the figures; none are drawn without it.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// A move on the true plant.
struct Move {
    /// Name of the model that planned it.
    model: &'static str,
    role: Role,
    problem: ControlProblem,
    /// The states under the plan's inputs, played without looking.
    played: Vec<Vec<f64>>,
    run: ControlRun,
}

impl Move {
    /// The reference move, half a second longer, to see that the object stays.
    fn new(
        (name, role): (&'static str, Role),
        model: &System,
        effect: PlateMismatch,
        settings: &RecordingSettings,
    ) -> anyhow::Result<Self> {
        let text = include_str!("../models/plate_move.toml");
        let mut problem = ControlProblem::parse("plate_move.toml", text, |_| Ok(model.clone()))?;
        problem.samples += 25;
        let mut plant = effect.loop_plant(settings)?;
        let run = problem.run(&mut plant)?;
        if let Some(reason) = plant.stopped() {
            anyhow::bail!("{reason}");
        }
        let plan = run.plan.as_ref().context("the method makes no plan")?;
        let mut played = vec![problem.x0.clone()];
        for (k, t) in run.closed_loop.t[..problem.samples].iter().enumerate() {
            let mut x = played[k].clone();
            let u = if k < plan.trajectory.steps() { plan.trajectory.u(k) } else { &[0.0; 2] };
            plant.step(*t, &mut x, u, problem.ocp.dt).map_err(anyhow::Error::from_boxed)?;
            played.push(x);
        }
        Ok(Self { model: name, role, problem, played, run })
    }

    /// Distance (mm) and turn (deg) that are left at the end of a way.
    fn missed(&self, way: &[Vec<f64>]) -> [f64; 2] {
        let target = target_of(&self.problem);
        way.last().map_or([f64::NAN; 2], |end| {
            let distance = (end[0] - target[0]).hypot(end[1] - target[1]);
            [1e3 * distance, (end[2] - target[2]).to_degrees()]
        })
    }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let nominal = System::parse("plate_disk.toml", include_str!("../models/plate_disk.toml"))?;
    let settings = RecordingSettings::default();
    println!("| hidden | found | model | open loop: left, mm | deg | closed loop: left, mm | deg | cost |");
    println!("|---|---|---|---|---|---|---|---|");
    let kinds = options.effect.as_deref().map_or(EFFECTS.to_vec(), |kind| vec![kind]);
    for kind in kinds {
        let effect = PlateMismatch::draw_kind(kind, options.seed).context("no such effect")?;
        let experiment = multisine([0.3, 0.0, 0.0, 0.0, 0.0, 0.0], options.seconds, &settings, options.seed)?;
        let start = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
        let log = synthetic_log(&experiment, start, options.seconds, &effect, &settings, options.seed)?.log;
        let record =
            Record::from_columns(&log.name, log.t.clone(), log.by_name(), &nominal, &RecordSettings::default())?;
        let mut diagnosis = DiagnosisSettings::default();
        diagnosis.study.window = Some(0.5);
        let report = diagnose(&nominal, &[record], &[], &diagnosis, &mut |_| ())?;
        let causes: Vec<String> = report.causes.iter().map(|c| c.name.to_string()).collect();
        let found = if causes.is_empty() { report.verdict.to_string() } else { causes.join(", ") };
        let mut moves = Vec::new();
        let extended = report.evidence.model.as_ref().map(|m| &m.system);
        let models = [("as given", Role::Given, Some(&nominal)), ("extended", Role::Extended, extended)];
        for (name, role, model) in models.into_iter().filter_map(|(name, role, model)| Some((name, role, model?))) {
            let tried = Move::new((name, role), model, effect, &settings)?;
            let ([plan, plan_turn], [distance, turn]) =
                (tried.missed(&tried.played), tried.missed(&tried.run.closed_loop.x));
            println!(
                "| {effect:?} | {found} | {name} | {plan:.2} | {plan_turn:.2} | {distance:.3} | {turn:.3} | {:.4} |",
                tried.run.report.closed_loop_cost
            );
            moves.push(tried);
        }
        if let Some(out) = &options.out {
            std::fs::create_dir_all(out)?;
            draw(kind, &moves)?.save(out.join(format!("diagnose_and_control_{kind}")))?;
        }
    }
    Ok(())
}

/// The object's pose over time with both models.
fn draw(kind: &str, moves: &[Move]) -> anyhow::Result<Drawing> {
    let mut chart =
        TimeSeries::new().title(format!("The reference move; hidden in the plant: {}", kind.replace('_', " ")));
    let targets = moves.first().map_or([0.0; 3], |m| target_of(&m.problem));
    let axes = [("x [mm]", 1e3), ("y [mm]", 1e3), ("φ [°]", 1f64.to_degrees())];
    for (index, (label, scale)) in axes.into_iter().enumerate() {
        let mut panel = Panel::new(label).target(scale * targets[index]);
        for Move { model, role, played, run, .. } in moves {
            for (what, way, dash) in
                [("open loop", played, Dash::Dotted), ("closed loop", &run.closed_loop.x, role.dash())]
            {
                let values: Vec<f64> = way.iter().map(|x| scale * x[index]).collect();
                let series = Series::new(format!("model {model}, {what}"), run.closed_loop.t.clone(), values);
                panel = panel.series(series.role(*role).dash(dash));
            }
        }
        chart = chart.panel(panel);
    }
    Ok(chart.draw()?)
}
