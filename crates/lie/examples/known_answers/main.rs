//! The analysis against random systems whose answers are known by construction.
//!
//! Each system is put together in coordinates in which its answers are seen, and then hidden by random exact coordinate
//! changes and feedback. Every answer of the report is compared with the truth; each system with a wrong one is printed as a
//! model file.
//!
//! ```text
//! cargo run --release -p bracketry-lie --example known_answers --features measure -- --count 5000 --threads 2
//! ```
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod classes;
mod equations;
mod hide;
mod judge;
mod local;
mod model;
mod outputs;
mod random;
mod tally;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

use bracketry_lie::{AnalysisOptions, analyze};
use bracketry_system::System;
use serde_json::Value;

use classes::{CLASSES, Class};
use judge::{Judgment, judge};
use model::{Model, Question};
use random::Random;
use tally::Tally;

/// What was asked for on the command line.
#[derive(Clone)]
struct Asked {
    seed: u64,
    first: usize,
    count: usize,
    threads: usize,
    class: Option<String>,
    /// A system that takes longer counts as one without an end.
    seconds: u64,
    /// Whether unknown answers are printed, too.
    unknown: bool,
    /// Whether coordinates change by irrational numbers, too.
    irrational: bool,
}

const HELP: &str =
    "options: --count N  --first N  --seed N  --threads N  --class NAME  --seconds N  --unknown  --irrational";

fn read() -> Result<Asked, String> {
    let mut asked = Asked {
        seed: 1,
        first: 0,
        count: 500,
        threads: 1,
        class: None,
        seconds: 60,
        unknown: false,
        irrational: false,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let flag = match word.as_str() {
            "--unknown" => Some(&mut asked.unknown),
            "--irrational" => Some(&mut asked.irrational),
            _ => None,
        };
        if let Some(flag) = flag {
            *flag = true;
            continue;
        }
        let value = words.next().ok_or(HELP)?;
        let number = || value.parse::<u64>().map_err(|_| format!("{word} {value}: not a number; {HELP}"));
        match word.as_str() {
            "--count" => asked.count = number()? as usize,
            "--first" => asked.first = number()? as usize,
            "--seed" => asked.seed = number()?,
            "--threads" => asked.threads = number()? as usize,
            "--seconds" => asked.seconds = number()?,
            "--class" if CLASSES.iter().any(|c| c.0 == value) => asked.class = Some(value),
            _ => {
                let names: Vec<&str> = CLASSES.iter().map(|c| c.0).collect();
                return Err(format!("{word} {value}: {HELP}; classes: {}", names.join(", ")));
            }
        }
    }
    Ok(asked)
}

/// System number `index`, hidden, as a model file.
fn system(asked: &Asked, index: usize, class: Class) -> (Model, String) {
    let mut random = Random::new(asked.seed, index as u64);
    let (model, how) = class(&mut random);
    let mut hidden = model.system();
    if model.question == Question::Analysis {
        hide::hide(&mut hidden, how, &mut random);
    }
    if model.question == Question::Analysis && asked.irrational {
        hide::hide_by_irrational_numbers(&mut hidden, &mut random);
        if random.once_in(2) {
            hide::hide_beside_an_irrational_value(&mut hidden, &mut random);
        }
    }
    let text = hidden.to_toml().expect("a model that can be written");
    (model, text)
}

/// The report of the model in this file; `None` where it takes too long.
fn report(text: &str, question: Question, seconds: u64) -> Option<Result<Value, String>> {
    let (send, receive) = mpsc::channel();
    let text = text.to_owned();
    let work = move || {
        let system = System::parse("known", &text).map_err(|e| e.to_string())?;
        match question {
            Question::Analysis => {
                let analysis = analyze(&system, &AnalysisOptions::default()).map_err(|e| e.to_string())?;
                serde_json::to_value(&analysis.report).map_err(|e| e.to_string())
            }
            Question::Equilibrium => equations::answer_of_trim(&system),
            Question::Parameters => equations::answer_by_cases(&system),
        }
    };
    std::thread::Builder::new().stack_size(64 << 20).spawn(move || send.send(work())).ok()?;
    match receive.recv_timeout(Duration::from_secs(seconds)) {
        Ok(result) => Some(result),
        Err(mpsc::RecvTimeoutError::Disconnected) => Some(Err("the analysis panicked".to_owned())),
        Err(mpsc::RecvTimeoutError::Timeout) => None,
    }
}

/// Analyzes system number `index` and compares.
fn trial(asked: &Asked, index: usize, tally: &Mutex<Tally>) {
    let (name, class) = match &asked.class {
        Some(name) => *CLASSES.iter().find(|c| c.0 == name).expect("a class"),
        None => CLASSES[index % CLASSES.len()],
    };
    let (model, text) = system(asked, index, class);
    let start = Instant::now();
    let found = report(&text, model.question, asked.seconds);
    let seconds = start.elapsed().as_secs_f64();
    let mut lines = Vec::new();
    let mut tally = tally.lock().expect("no panic while it is held");
    tally.time(name, index, seconds);
    match found {
        None => lines.push(format!("no answer within {} s", asked.seconds)),
        Some(Err(why)) => lines.push(why),
        Some(Ok(report)) => {
            for (path, expected) in &model.truth {
                let (judgment, found) = judge(&report, path, expected);
                tally.add(name, path, judgment);
                let told = judgment == Judgment::Wrong || asked.unknown && judgment == Judgment::Unknown;
                if told {
                    let found = found.map_or("absent".to_owned(), |f| f.to_string());
                    lines.push(format!("{judgment:?}: {path}: {found}, expected {expected:?}"));
                }
            }
        }
    }
    if seconds > asked.seconds as f64 || lines.iter().any(|l| l.contains("panicked") || l.starts_with("no answer")) {
        tally.failed += 1;
    }
    if !lines.is_empty() {
        println!("--- system {index} ({name}), {seconds:.2} s\n# {}\n{text}", lines.join("\n# "));
    }
}

fn main() {
    let asked = match read() {
        Ok(asked) => asked,
        Err(why) => {
            eprintln!("{why}");
            std::process::exit(2);
        }
    };
    let tally = Arc::new(Mutex::new(Tally::default()));
    let next = AtomicUsize::new(asked.first);
    let end = asked.first + asked.count;
    std::thread::scope(|scope| {
        for _ in 0..asked.threads.max(1) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= end {
                        break;
                    }
                    trial(&asked, index, &tally);
                    if (index + 1 - asked.first).is_multiple_of(100) {
                        eprintln!("{} of {}", index + 1 - asked.first, asked.count);
                    }
                }
            });
        }
    });
    let tally = tally.lock().expect("all threads ended");
    println!("{tally}");
    std::process::exit(i32::from(tally.wrong() > 0 || tally.failed > 0));
}
