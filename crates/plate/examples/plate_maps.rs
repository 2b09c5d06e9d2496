//! Sweeps the published experiments over friction and frequency on several models and draws the maps of `docs/records/plate_terms.md`:
//! `cargo run --release -p bracketry-plate --example plate_maps --features measure [FOLDER]`
#![allow(clippy::print_stdout, dead_code)]

mod common;

use bracketry_plate::PlateError;
use bracketry_plate::experiment::{Experiment, Map, Summary, linspace};
use bracketry_plate::model::Terms;
use bracketry_plot::{Color, HeatMap, RegimeMap};
use common::{Model, Progress, folder, save};
use std::path::Path;

const MU: &str = "friction coefficient μ";
const FREQUENCY: &str = "frequency [Hz]";
/// Way in m, or turn in rad, below which an object has not moved.
const STUCK: f64 = 1e-3;

type Results = Map<Result<Summary, PlateError>>;

/// What came of a run.
#[derive(Clone, Copy, PartialEq)]
enum Regime {
    Reached,
    Moves,
    Stuck,
    RunOff,
    LiftsOff,
}

impl Regime {
    const ALL: [(Regime, &str, Color); 5] = [
        (Regime::Reached, "reaches the target", Color::GREEN),
        (Regime::Moves, "moves, misses the target", Color::SKY),
        (Regime::Stuck, "does not move", Color::GRAY),
        (Regime::RunOff, "runs off the plate", Color::VERMILLION),
        (Regime::LiftsOff, "lifts off: not covered by the model", Color::PURPLE),
    ];

    fn of(summary: &Summary) -> Self {
        if summary.run_off.is_some() {
            Self::RunOff
        } else if summary.least_load < 0.0 || !summary.outcome.is_finished() {
            Self::LiftsOff
        } else if summary.reached.is_some() {
            Self::Reached
        } else if summary.displacement.iter().all(|d| d.abs() < STUCK) {
            Self::Stuck
        } else {
            Self::Moves
        }
    }
}

/// An experiment with its grid.
struct Sweep {
    key: &'static str,
    experiment: Experiment,
    duration: f64,
    mu: Vec<f64>,
    frequency: Vec<f64>,
}

impl Sweep {
    fn run(&self, model: Model) -> Results {
        let progress = Progress::new(&self.experiment.name, self.mu.len() * self.frequency.len());
        let experiment = model.experiment(self.experiment.clone());
        Map::compute(
            &self.mu,
            &self.frequency,
            |mu, frequency| model.summary(&experiment.clone().with_frequency(frequency), mu, self.duration),
            |done| progress.tell(done),
        )
    }

    fn rows(&self, map: &Results, number: impl Fn(&Summary) -> f64) -> Vec<Vec<f64>> {
        let number = |result: Option<&Result<Summary, PlateError>>| match result {
            Some(Ok(summary)) => number(summary),
            _ => f64::NAN,
        };
        map.numbers(number).chunks(self.mu.len()).map(<[f64]>::to_vec).collect()
    }

    fn published_at(&self) -> (f64, f64) {
        (0.3, 1.0 / self.experiment.period)
    }

    /// Time to target, where there is one.
    fn draw_time(&self, map: &Results, model: &str, folder: &Path) -> anyhow::Result<()> {
        let times = self.rows(map, |s| match Regime::of(s) {
            Regime::Reached => s.reached.unwrap_or(f64::NAN),
            _ => f64::NAN,
        });
        let (x, y) = self.published_at();
        let drawing = HeatMap::new(MU, FREQUENCY, "time to cover 98 % of the distance [s]")
            .values(self.mu.clone(), self.frequency.clone(), times)
            .missing(format!("off the plate, or not reached within {} s", self.duration))
            .mark("as published", x, y)
            .title(format!("Experiment {}: {model}", self.experiment.name))
            .draw()?;
        save(&drawing, folder, &format!("time_{}", self.key))
    }

    fn draw_drift(&self, map: &Results, model: &str, folder: &Path) -> anyhow::Result<()> {
        let drift = self.rows(map, |s| match Regime::of(s) {
            Regime::RunOff | Regime::LiftsOff => f64::NAN,
            _ => 1e3 * s.drift(),
        });
        let (x, y) = self.published_at();
        let drawing = HeatMap::new(MU, FREQUENCY, "drift over the plate [mm/s]")
            .values(self.mu.clone(), self.frequency.clone(), drift)
            .range(0.0, 5.0)
            .missing("runs off or lifts off")
            .mark("as published", x, y)
            .title(format!("Experiment {}: {model}", self.experiment.name))
            .draw()?;
        save(&drawing, folder, &format!("drift_{}", self.key))
    }

    fn draw_regimes(&self, map: &Results, key: &str, model: &str, folder: &Path) -> anyhow::Result<()> {
        let category = |result: &Option<Result<Summary, PlateError>>| match result {
            Some(Ok(summary)) => Regime::ALL.iter().position(|r| r.0 == Regime::of(summary)),
            _ => None,
        };
        let cells: Vec<Option<usize>> = map.results.iter().map(category).collect();
        let (x, y) = self.published_at();
        let mut figure = RegimeMap::new(MU, FREQUENCY)
            .cells(self.mu.clone(), self.frequency.clone(), cells.chunks(self.mu.len()).map(<[Option<usize>]>::to_vec))
            .missing("not run")
            .mark("as published", x, y)
            .title(format!("Experiment {} within {} s: {model}", self.experiment.name, self.duration));
        for (_, name, color) in Regime::ALL {
            figure = figure.category(name, color);
        }
        save(&figure.draw()?, folder, &format!("regimes_{}_{key}", self.key))
    }

    /// How many runs came to what.
    fn count(&self, map: &Results, model: &str) {
        let counts = Regime::ALL.map(|(regime, ..)| {
            map.results.iter().flatten().flatten().filter(|summary| Regime::of(summary) == regime).count()
        });
        let errors = map.results.iter().flatten().filter(|result| result.is_err()).count();
        print!("| {} | {model} |", self.experiment.name);
        for count in counts {
            print!(" {count} |");
        }
        println!(" {errors} |");
    }
}

fn main() -> anyhow::Result<()> {
    let folder = folder()?;
    let mu = linspace(0.05, 0.6, 12);
    let sweeps = [
        Sweep {
            key: "1",
            experiment: Experiment::orientation(),
            duration: 15.0,
            mu: mu.clone(),
            frequency: linspace(1.0, 4.0, 13),
        },
        Sweep {
            key: "2",
            experiment: Experiment::translation_x(3),
            duration: 8.0,
            mu: mu.clone(),
            frequency: linspace(1.0, 5.0, 17),
        },
        Sweep {
            key: "3",
            experiment: Experiment::translation_y(),
            duration: 8.0,
            mu,
            frequency: linspace(1.0, 5.0, 17),
        },
    ];
    let models = [
        ("published", "published model", Model::Published),
        ("point", "point contact", Model::Point),
        ("reduced", "reduced model", Model::Reduced(Terms::default())),
        ("area", "area contact", Model::Area),
    ];
    println!(
        "| experiment | model | reached | moves | stays | runs off | lifts off | refused |\n|---|---|---|---|---|---|---|---|"
    );
    for sweep in &sweeps {
        for (key, name, model) in models {
            let map = sweep.run(model);
            sweep.count(&map, name);
            sweep.draw_regimes(&map, key, name, &folder)?;
            if key == "reduced" {
                sweep.draw_time(&map, name, &folder)?;
                if sweep.key == "1" {
                    sweep.draw_drift(&map, name, &folder)?;
                }
            }
        }
    }
    Ok(())
}
