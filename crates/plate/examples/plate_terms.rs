//! Which term of the equations matters when: each is switched off in turn in the published experiments, over friction and
//! frequency. Prints the tables and draws the figures of `docs/records/plate_terms.md`:
//! `cargo run --release -p bracketry-plate --example plate_terms --features measure [FOLDER]`
#![allow(clippy::print_stdout, dead_code)]

mod common;

use bracketry_plate::driven::Course;
use bracketry_plate::experiment::{Experiment, Limits, Map, linspace};
use bracketry_plate::model::Terms;
use bracketry_plate::{Object, PlateError, PlateMotion};
use bracketry_plot::{Color, RegimeMap};
use common::{ELLIPSE, Progress, folder, reduced_plant, save, start};
use std::path::Path;

const MU: &str = "friction coefficient μ";
const FREQUENCY: &str = "frequency [Hz]";
/// Effects below this share of the way do not count.
const MATTERS: f64 = 0.03;
/// Distance in seconds of the instants at which two runs are compared.
const STEP: f64 = 0.01;

/// The terms, how they are switched off, and their colors.
fn terms() -> [(&'static str, Terms, Color); 9] {
    let all = Terms::default();
    [
        ("friction against the spin", Terms { yaw_friction: false, ..all }, Color::VERMILLION),
        ("coupling of the directions", Terms { coupled: false, ..all }, Color::BLUE),
        ("centrifugal y θ'²", Terms { centrifugal: false, ..all }, Color::GREEN),
        ("Coriolis 2 y' θ' in the load", Terms { coriolis: false, ..all }, Color::ORANGE),
        ("Euler y θ'' in the load", Terms { euler: false, ..all }, Color::PURPLE),
        ("thickness h θ'', h θ'²", Terms { thickness: false, ..all }, Color::INK),
        ("load in the friction along x", Terms { load_along_x: false, ..all }, Color::SKY),
        ("torque of the friction along y", Terms { torque_across: false, ..all }, Color(150, 150, 60)),
        ("gyroscopic Sxy θ'²", Terms { gyroscopic: false, ..all }, Color(120, 80, 60)),
    ]
}

struct Case {
    key: &'static str,
    experiment: Experiment,
    duration: f64,
}

/// The coordinate every [`STEP`] seconds, and whether the object went beyond the limits.
#[derive(Clone)]
struct Way {
    values: Vec<f64>,
    run_off: bool,
    /// Whether the load stays positive while the object is on the plate, without which the model says nothing.
    valid: bool,
}

impl Case {
    fn course(&self, terms: Terms, mu: f64, frequency: f64) -> Result<Way, PlateError> {
        let experiment = self.experiment.clone().with_frequency(frequency);
        let begin = start(&experiment);
        let mut plant = reduced_plant(&ELLIPSE, terms, mu, begin)?;
        let travel = Limits::default().travel;
        let mut run_off = false;
        let run = experiment.run_until(&mut plant, self.duration, |_, state| {
            run_off = (0..2).any(|i| (state[i] - begin[i]).abs() > travel);
            run_off
        })?;
        let count = (run.trajectory.end() / STEP).floor() as usize;
        let values = (0..=count).map(|i| run.trajectory.state_at(STEP * i as f64)[run.coordinate()]).collect();
        Ok(Way { values, run_off, valid: run_off || (run.outcome.is_finished() && run.least_load > 0.0) })
    }

    /// Root mean square difference of two courses, as a share of the way to the target; infinite where one runs off the
    /// plate and the other does not.
    fn effect(&self, full: &Way, without: &Way) -> f64 {
        if full.run_off != without.run_off {
            return f64::INFINITY;
        }
        let pairs = full.values.iter().zip(&without.values);
        let sum: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
        let count = full.values.len().min(without.values.len()) as f64;
        (sum / count).sqrt() / (self.experiment.target - self.experiment.start).abs()
    }
}

/// Effects of all terms at one friction and frequency.
struct Effects {
    of_terms: Vec<f64>,
    run_off: bool,
    lifts_off: bool,
}

fn effects(case: &Case, mu: f64, frequency: f64) -> Result<Effects, PlateError> {
    let full = case.course(Terms::default(), mu, frequency)?;
    let mut of_terms = Vec::new();
    for (_, terms, _) in terms() {
        let without = case.course(terms, mu, frequency)?;
        of_terms.push(case.effect(&full, &without));
    }
    Ok(Effects { of_terms, run_off: full.run_off, lifts_off: !full.valid })
}

fn study(case: &Case, folder: &Path) -> anyhow::Result<()> {
    let (mu, frequency) = (linspace(0.05, 0.6, 12), linspace(1.0, 4.0, 13));
    let progress = Progress::new(&case.experiment.name, mu.len() * frequency.len());
    let map = Map::compute(&mu, &frequency, |mu, f| effects(case, mu, f), |done| progress.tell(done));
    drop(progress);
    if let Some(error) = map.results.iter().flatten().find_map(|result| result.as_ref().err()) {
        anyhow::bail!("a case fails: {error}");
    }
    let all: Vec<&Effects> = map.results.iter().flatten().flatten().collect();
    let known: Vec<&Effects> = all.iter().copied().filter(|e| !e.lifts_off).collect();
    println!(
        "\nExperiment {}: of {} places the object lifts off at {}; of the others it runs off the plate at {}\n",
        case.experiment.name,
        all.len(),
        all.len() - known.len(),
        known.iter().filter(|e| e.run_off).count()
    );
    println!(
        "| term switched off | median effect | largest 10 % from | matters (> 3 %) | matters most | decides about running off |"
    );
    println!("|---|---|---|---|---|---|");
    // Without friction the spin of experiment 1 has no bound: there, the question is which term comes next.
    let skipped = usize::from(case.key == "1");
    let most = |e: &Effects| {
        let (index, largest) = e
            .of_terms
            .iter()
            .copied()
            .enumerate()
            .skip(skipped)
            .fold((0, 0.0), |best, (i, v)| if v > best.1 { (i, v) } else { best });
        (largest > MATTERS).then_some(index)
    };
    for (index, (name, ..)) in terms().iter().enumerate() {
        let mut all: Vec<f64> = known.iter().map(|e| e.of_terms[index]).collect();
        all.sort_by(f64::total_cmp);
        let share = |count: usize| 100.0 * count as f64 / known.len() as f64;
        let percent = |v: f64| if v.is_finite() { format!("{:.1} %", 100.0 * v) } else { "runs off".to_owned() };
        println!(
            "| {name} | {} | {} | {:.0} % | {:.0} % | {:.0} % |",
            percent(all[all.len() / 2]),
            percent(all[all.len() * 9 / 10]),
            share(all.iter().filter(|v| **v > MATTERS).count()),
            share(known.iter().filter(|e| most(e) == Some(index)).count()),
            share(all.iter().filter(|v| v.is_infinite()).count()),
        );
    }
    let cells: Vec<Option<usize>> = map
        .results
        .iter()
        .map(|result| match result {
            Some(Ok(e)) if !e.lifts_off => Some(most(e).map_or(0, |index| index + 1)),
            _ => None,
        })
        .collect();
    let mut figure = RegimeMap::new(MU, FREQUENCY)
        .category("no term changes it by more than 3 %", Color(215, 215, 215))
        .cells(mu.clone(), frequency.clone(), cells.chunks(mu.len()).map(<[Option<usize>]>::to_vec))
        .missing("lifts off")
        .mark("as published", 0.3, 1.0 / case.experiment.period)
        .title(format!(
            "Experiment {}: the neglected term that changes the motion most{}",
            case.experiment.name,
            if skipped == 1 { ", besides friction against the spin" } else { "" }
        ));
    for (name, _, color) in terms() {
        figure = figure.category(name, color);
    }
    save(&figure.draw()?, folder, &format!("terms_{}", case.key))?;

    let centrifugal: Vec<Option<usize>> = map
        .results
        .iter()
        .map(|result| match result {
            Some(Ok(e)) if !e.lifts_off => Some(match (e.run_off, e.of_terms[2].is_infinite()) {
                (false, false) => 0,
                (true, true) => 1,
                (true, false) => 2,
                (false, true) => 3,
            }),
            _ => None,
        })
        .collect();
    let drawing = RegimeMap::new(MU, FREQUENCY)
        .category("stays on the plate", Color(215, 215, 215))
        .category("runs off only with y θ'²", Color::VERMILLION)
        .category("runs off with and without", Color::INK)
        .category("runs off only without y θ'²", Color::BLUE)
        .cells(mu.clone(), frequency.clone(), centrifugal.chunks(mu.len()).map(<[Option<usize>]>::to_vec))
        .missing("lifts off")
        .mark("as published", 0.3, 1.0 / case.experiment.period)
        .title(format!(
            "Experiment {}: what the centrifugal term decides within {} s",
            case.experiment.name, case.duration
        ))
        .draw()?;
    save(&drawing, folder, &format!("run_off_{}", case.key))?;
    Ok(())
}

/// Peak sizes in m/s² of the terms in a run of an experiment.
fn peaks(experiment: &Experiment, duration: f64) -> anyhow::Result<()> {
    let (mu, h, g) = (0.3, 0.0025, 9.81);
    let mut plant = reduced_plant(&Object::REFERENCE, Terms::default(), mu, start(experiment))?;
    let run = experiment.run_on(&mut plant, duration)?;
    let mut motion = experiment.motion(0.0)?;
    let mut peaks = [0.0f64; 7];
    for &(from, amplitude) in &run.amplitudes {
        motion.set("A", amplitude);
        for i in 0..500 {
            let t = (from + experiment.period * f64::from(i) / 500.0).min(run.trajectory.end());
            let (k, s) = (motion.at(t), run.trajectory.state_at(t));
            let now = [
                k.acceleration,
                g * k.tilt.sin(),
                s[1] * k.tilt_acceleration,
                s[1] * k.tilt_rate * k.tilt_rate,
                2.0 * s[4] * k.tilt_rate,
                h * k.tilt_acceleration,
                h * k.tilt_rate * k.tilt_rate,
            ];
            for (peak, now) in peaks.iter_mut().zip(now) {
                *peak = peak.max(now.abs());
            }
        }
    }
    print!("| {} |", experiment.name);
    for peak in peaks {
        print!(" {peak:.2} |");
    }
    println!();
    Ok(())
}

/// Time to target and end of the published cases, with all terms and with each switched off.
fn published_cases(cases: &[Case; 3]) -> anyhow::Result<()> {
    println!(
        "\n| μ = 0.3, as published | 1: 98 % at | 1: after 15 s | 2: 98 % at | 3: 98 % at | 3: last second, peak to peak |\n|---|---|---|---|---|---|"
    );
    let all = [("all terms", Terms::default(), Color::INK)];
    for (name, terms, _) in all.into_iter().chain(terms()) {
        print!("| {name} |");
        for case in cases {
            let mut plant = reduced_plant(&ELLIPSE, terms, 0.3, start(&case.experiment))?;
            let run = case.experiment.run_on(&mut plant, 15.0)?;
            let reached = run.reached.map_or_else(|| "never".to_owned(), |t| format!("{t:.2} s"));
            print!(" {reached} |");
            let (low, high) = run.range(14.0);
            match case.key {
                "1" => print!(" {:.1}° |", run.trajectory.state_at(15.0)[2].to_degrees()),
                "3" => print!(" {:.1} mm |", 1e3 * (high - low)),
                _ => {}
            }
        }
        println!();
    }
    Ok(())
}

fn main() -> anyhow::Result<()> {
    let folder = folder()?;
    let cases = [
        Case { key: "1", experiment: Experiment::orientation(), duration: 15.0 },
        Case { key: "2", experiment: Experiment::translation_x(3), duration: 8.0 },
        Case { key: "3", experiment: Experiment::translation_y(), duration: 8.0 },
    ];
    println!("Peak sizes in m/s², μ = 0.3, h = 2.5 mm, disk\n");
    println!(
        "| experiment | X'' | g sin θ | y θ'' | y θ'² | 2 y' θ' | h θ'' | h θ'² |\n|---|---|---|---|---|---|---|---|"
    );
    for case in &cases {
        peaks(&case.experiment, case.duration)?;
    }
    published_cases(&cases)?;
    // On a level plate, experiment 2, none of these terms acts.
    for case in cases.iter().filter(|case| case.key != "2") {
        study(case, &folder)?;
    }
    Ok(())
}
