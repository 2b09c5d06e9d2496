//! Does analyzing many systems in one process take ever more memory?
//!
//! `cargo run --release --example memory_soak --features measure [SYSTEMS] [STEM]` analyzes random systems, by default 1000, notes the
//! resident memory after each (Linux), and writes STEM.csv, STEM.svg and STEM.png, by default docs/records/memory.
#![allow(clippy::print_stdout)]

use std::fmt::Write as _;

use bracketry::lie::AnalysisOptions;
use bracketry::plot::{Panel, Series, XyChart};
use bracketry::system::System;

/// Deterministic random numbers (`SplitMix64`).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// A random product of functions of the states.
fn term(random: &mut Random, states: usize) -> String {
    let mut text = format!("{}", random.below(9) + 1);
    for _ in 0..=random.below(2) {
        let (i, j) = (random.below(states), random.below(states));
        let factor = match random.below(6) {
            0 => format!("sin(x{i})"),
            1 => format!("cos(x{i} - x{j})"),
            2 => format!("exp(x{i}/5)"),
            3 => format!("x{i}^2"),
            4 => format!("x{i}/(2 + x{j}^2)"),
            _ => format!("x{i}"),
        };
        let _ = write!(text, "*{factor}");
    }
    text
}

/// Two to five states, one or two inputs that enter linearly or need integrators, at times friction, outputs and a point.
fn model(random: &mut Random) -> String {
    let (n, m) = (2 + random.below(4), 1 + random.below(2));
    let list = |prefix: &str, k: usize| (0..k).map(|i| format!("\"{prefix}{i}\"")).collect::<Vec<_>>().join(", ");
    let mut text = format!("name = \"random\"\nstates = [{}]\ninputs = [{}]\n", list("x", n), list("u", m));
    text += "[parameters]\np = 0.7\n[dynamics]\n";
    for i in 0..n {
        let mut rate = format!("p*{}", term(random, n));
        if random.below(2) == 0 {
            let _ = write!(rate, " - {}", term(random, n));
        }
        if random.below(n) < 2 {
            let factor = random.pick(&["1", "x0", "cos(x1)", "(1 + x0^2)"]);
            let _ = write!(rate, " + {factor}*u{}", random.below(m));
        }
        if random.below(12) == 0 {
            let _ = write!(rate, " - 0.3*sign(x{i})");
        }
        if random.below(25) == 0 {
            let _ = write!(rate, " + sin(u{})", random.below(m));
        }
        let _ = writeln!(text, "x{i} = \"{rate}\"");
    }
    if random.below(2) == 0 {
        let _ = writeln!(text, "[outputs]\ny = \"x0*x1\"");
    }
    if random.below(2) == 0 {
        text += "[point]\nx0 = 0.2\n";
    }
    text
}

/// Resident memory of this process in bytes; none where the system does not tell.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|k| k * 1024.0)
}

/// Slope of the line of least squares through (x, y).
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let covariance: f64 = x.iter().zip(y).map(|(a, b)| (a - mx) * (b - my)).sum();
    covariance / x.iter().map(|a| (a - mx).powi(2)).sum::<f64>()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let systems: usize = arguments.next().map_or(Ok(1000), |t| t.parse())?;
    let stem = arguments.next().unwrap_or("docs/records/memory".to_owned());
    let mut random = Random(1);
    let (mut at, mut memory, mut decided) = (Vec::new(), Vec::new(), 0);
    let mut csv = String::from("system,resident_bytes\n");
    for k in 1..=systems {
        let system = System::parse("random.toml", &model(&mut random))?;
        // Some have no affine form; what was tried must be freed all the same.
        if let Ok(analysis) = bracketry::analyze(&system, &AnalysisOptions::default()) {
            decided += usize::from(analysis.report.decided());
        }
        let Some(bytes) = resident() else { return Err("resident memory is told on Linux only".into()) };
        at.push(k as f64);
        memory.push(bytes);
        let _ = writeln!(csv, "{k},{bytes}");
    }
    let late = systems / 5;
    let rate = slope(&at[late..], &memory[late..]);
    let mib = |bytes: f64| bytes / f64::from(1 << 20);
    let most = memory.iter().copied().fold(0.0, f64::max);
    println!("{systems} systems analyzed, {decided} of them decided");
    println!("resident memory: {:.1} MiB after the first, {:.1} MiB at most", mib(memory[0]), mib(most));
    println!("after {late}: {:.1} MiB, at the end {:.1} MiB", mib(memory[late]), mib(memory[systems - 1]));
    println!("slope over the last four fifths: {rate:.0} bytes per system");
    std::fs::write(format!("{stem}.csv"), csv)?;
    let line = Series::new("resident memory", at, memory.iter().map(|&b| mib(b)).collect::<Vec<_>>());
    let panel = Panel::new("resident memory [MiB]").series(line).limits(0.0, 1.2 * mib(most));
    XyChart::new("systems analyzed", panel).title("Memory of one process").integer().draw()?.save(&stem)?;
    Ok(())
}
