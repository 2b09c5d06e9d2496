//! Our side of the comparison with other systems; see `run.py`, which runs both and writes the table.
//!
//! Prints one JSON object: CPU time of the process, medians, in seconds.
#![allow(clippy::print_stdout)]

mod control;
#[path = "../../crates/native/benches/model/mod.rs"]
mod model;
mod simulation;
mod systems;

use std::hint::black_box;
use std::time::Duration;

use bracketry::lie::Evidence;
use bracketry::lie::algebra::HallBasis;
use bracketry::native::{Backend, Function, Workspace};
use bracketry::symbolic::{Bindings, Pool};
use cpu_time::ProcessTime;
use serde_json::json;

/// Median CPU time of `runs` calls, in seconds, and what the last one gave.
fn median<T>(runs: usize, mut f: impl FnMut() -> T) -> (f64, T) {
    let mut last = f();
    let mut times: Vec<Duration> = (0..runs)
        .map(|_| {
            let begin = ProcessTime::now();
            last = black_box(f());
            begin.elapsed()
        })
        .collect();
    times.sort();
    (times[times.len() / 2].as_secs_f64(), last)
}

/// Hall brackets of the plate up to `length`, without and with their generic rank.
fn plate(smooth: bool, length: usize) -> serde_json::Value {
    let brackets = |rank: bool| {
        let mut pool = Pool::new();
        let v = systems::plate(&mut pool, smooth);
        let basis = HallBasis::new(3, length).expect("a small basis");
        let generators = v.generators();
        let fields = basis.fields(&mut pool, &v.states, &generators).expect("small brackets");
        let found = if rank { pool.rank(&fields, &Bindings::new()).expect("a rank").rank } else { 0 };
        let nonzero = fields.iter().filter(|f| f.iter().any(|&e| !pool.is_zero(e))).count();
        (fields.len(), nonzero, found)
    };
    let (alone, _) = median(51, || brackets(false));
    let (with_rank, (count, nonzero, rank)) = median(51, || brackets(true));
    json!({"brackets": alone, "with_rank": with_rank, "count": count, "nonzero": nonzero, "rank": rank})
}

fn trailers(n: usize, runs: usize) -> serde_json::Value {
    let (seconds, dimension) = median(runs, || {
        let mut pool = Pool::new();
        let v = systems::trailers(&mut pool, n);
        v.accessibility(&mut pool, &mut Evidence::default()).expect("a rank").dimension()
    });
    json!({"seconds": seconds, "dimension": dimension})
}

/// One call of the compiled Jacobian, and the sum of its entries at the first point.
fn jacobian() -> serde_json::Value {
    const CALLS: usize = 200_000;
    let f = Function::with_backend(model::tape(), Backend::Native).expect("a supported host");
    let (mut work, mut out) = (Workspace::default(), [0.0; model::ROWS * model::COLUMNS]);
    let mut x = [0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0];
    f.call(&x, &mut work, &mut out);
    let sum: f64 = out.iter().sum();
    let mut calls = |f: &mut dyn FnMut(&[f64; 9], &mut [f64; model::ROWS * model::COLUMNS])| {
        median(21, || {
            for i in 0..CALLS {
                x[0] = 0.02 + 1e-9 * i as f64;
                f(black_box(&x), &mut out);
                black_box(&out);
            }
        })
        .0 / CALLS as f64
    };
    let native = calls(&mut |x, out| f.call(x, &mut work, out));
    let by_hand = calls(&mut model::by_hand);
    json!({"native": native, "by_hand": by_hand, "instructions": f.tape().code().len(), "sum": sum})
}

fn algebra() -> serde_json::Value {
    json!({
        "plate_one_mode_6": plate(false, 6),
        "plate_smoothed_5": plate(true, 5),
        "trailers_6": trailers(6, 51),
        "trailers_10": trailers(10, 21),
        "trailers_20": trailers(20, 7),
        "jacobian": jacobian(),
    })
}

fn main() {
    let asked = |part: &str| std::env::args().any(|argument| argument == part);
    let report = if asked("simulation") {
        simulation::report()
    } else if asked("control") {
        control::report()
    } else {
        algebra()
    };
    println!("{report}");
}
