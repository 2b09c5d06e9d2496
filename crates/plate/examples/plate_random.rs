//! Simulates random objects on random plates, in parallel, and counts what became of them:
//! `cargo run --release -p bracketry-plate --example plate_random --features measure -- 10000 1`
//!
//! The arguments are the number of objects and the first seed. Each object is simulated for 0.25 s: any shape, size,
//! thickness, mass, friction law, restitution and plate motion, at rest, sliding or thrown; one in ten at absurd speeds, some
//! impossible, which must be refused.
#![allow(clippy::print_stdout)]

#[path = "../tests/main/random_object.rs"]
mod random_object;

use random_object::{Outcome, run};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (count, first) = (arguments.next().unwrap_or(1000), arguments.next().unwrap_or(1));
    let begin = Instant::now();
    let timed = |seed: u64| {
        let start = Instant::now();
        let outcome = std::panic::catch_unwind(|| run(seed, 0.25)).unwrap_or_else(|_| Outcome {
            kind: "panic".into(),
            impossible: false,
            refused: false,
            fault: Some("panic".into()),
            events: 0,
            unresolved: 0,
        });
        (seed, start.elapsed().as_secs_f64(), outcome)
    };
    let outcomes: Vec<_> = (first..first + count).into_par_iter().map(timed).collect();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, _, outcome) in &outcomes {
        *kinds.entry(&outcome.kind).or_default() += 1;
    }
    println!("{count} objects from seed {first} in {:.0} s", begin.elapsed().as_secs_f64());
    for (kind, number) in kinds {
        println!("{number:6}  {kind}");
    }
    let events: usize = outcomes.iter().map(|(_, _, o)| o.events).sum();
    let unresolved: usize = outcomes.iter().map(|(_, _, o)| o.unresolved).sum();
    println!("{events} events; {unresolved} steps with approximate friction");
    let mut slowest: Vec<_> = outcomes.iter().collect();
    slowest.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (seed, seconds, outcome) in slowest.iter().take(5) {
        println!("slowest: seed {seed}: {seconds:.3} s, {} events, {}", outcome.events, outcome.kind);
    }
    let faults: Vec<_> = outcomes.iter().filter_map(|(seed, _, o)| o.fault.as_ref().map(|f| (seed, f))).collect();
    println!("{} faults", faults.len());
    for (seed, fault) in faults.iter().take(20) {
        println!("  seed {seed}: {fault}");
    }
    if !faults.is_empty() {
        std::process::exit(1);
    }
}
