//! Shortest moves and what their planning takes:
//! `cargo run --release -p bracketry-plate --example plate_times --features measure [MOVES]`
#![allow(clippy::print_stdout)]

use bracketry_plate::control::{MovePlanner, PlannedMove, PlanningBudget, PlateLimits};
use bracketry_plate::{Object, Shape};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::PI;

const MU: f64 = 0.3;
const PROGRAMS: [usize; 3] = [250, 500, 1000];
/// Moves by x, y (m) and yaw (°) of the reference ellipse, with the start, and the shortest duration in s for which an
/// interior-point solver finds one with the reduced model.
const MOVES: [(&str, [f64; 3], [f64; 3], f64); 6] = [
    ("60 mm, 30 mm, 90°", [0.0, 0.0, 0.0], [0.06, 0.03, 90.0], 1.2),
    ("turn by 90°", [0.0, 0.0, 0.0], [0.0, 0.0, 90.0], 1.2),
    ("100 mm, 80 mm", [0.0, 0.0, 0.0], [0.1, 0.08, 0.0], 0.6),
    ("150 mm, −150 mm, −103°", [-0.08, 0.07, 0.0], [0.07, -0.08, -103.0], 1.6),
    ("−50 mm, 50 mm, 69°", [0.03, -0.02, 0.0], [-0.02, 0.03, 69.0], 1.2),
    ("turn by 160°", [0.0, 0.0, 0.0], [0.0, 0.0, 160.0], 1.6),
];

fn objects() -> anyhow::Result<Vec<(&'static str, Object)>> {
    let of = |shape| Object { shape, ..Object::REFERENCE };
    Ok(vec![
        ("ellipse 0.30 m × 0.20 m", of(Shape::REFERENCE_ELLIPSE)),
        ("disk of 0.12 m", of(Shape::Disk { radius: 0.12 })),
        ("rectangle 0.28 m × 0.14 m", of(Shape::Rectangle { a: 0.14, b: 0.07 })),
        ("triangle", of(Shape::polygon(&[[-0.1, -0.08], [0.12, -0.06], [0.0, 0.12]])?)),
        ("rectangle 0.30 m × 0.03 m", of(Shape::Rectangle { a: 0.15, b: 0.015 })),
    ])
}

fn budget(programs: usize) -> PlanningBudget {
    PlanningBudget { programs, seconds: f64::INFINITY }
}

/// The value below which a share of the sorted values lies.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((share * values.len() as f64) as usize).min(values.len() - 1)]
}

fn print_moves() -> anyhow::Result<()> {
    let object = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
    let planner = MovePlanner::new(&object, MU, &PlateLimits::default())?;
    println!(
        "| move | reduced model [s] | {} |",
        PROGRAMS.map(|p| format!("{p} programs [s] (planned in)")).join(" | ")
    );
    println!("|---|---|---|---|---|");
    for (name, start, [x, y, yaw], reduced) in MOVES {
        let mut cells = Vec::new();
        for programs in PROGRAMS {
            let plan = planner.plan(start, [x, y, yaw.to_radians()], &budget(programs))?;
            cells.push(plan.map_or("no plan".to_owned(), |plan| {
                let missed = if plan.arrives { "" } else { ", misses" };
                format!("{:.2}{missed} ({:.2})", plan.duration, plan.seconds)
            }));
        }
        println!("| {name} | {reduced} | {} |", cells.join(" | "));
    }
    Ok(())
}

fn print_random(count: usize) -> anyhow::Result<()> {
    println!(
        "| object | arrive | duration: median, 95 % [s] | planning: median, 95 %, largest [s] | programs: median |"
    );
    println!("|---|---|---|---|---|");
    for (name, object) in objects()? {
        let planner = MovePlanner::new(&object, MU, &PlateLimits::default())?;
        let mut random = StdRng::seed_from_u64(2026);
        let mut pose = || [0.1, 0.1, PI].map(|limit: f64| random.random_range(-limit..limit));
        let mut plans: Vec<PlannedMove> = Vec::new();
        for _ in 0..count {
            plans.extend(planner.plan(pose(), pose(), &budget(500))?);
        }
        let arrive = plans.iter().filter(|plan| plan.arrives).count();
        let of = |value: fn(&PlannedMove) -> f64| plans.iter().map(value).collect::<Vec<_>>();
        let (mut durations, mut seconds, mut programs) =
            (of(|p| p.duration), of(|p| p.seconds), of(|p| p.programs as f64));
        println!(
            "| {name} | {arrive}/{count} | {:.2}, {:.2} | {:.2}, {:.2}, {:.2} | {:.0} |",
            quantile(&mut durations, 0.5),
            quantile(&mut durations, 0.95),
            quantile(&mut seconds, 0.5),
            quantile(&mut seconds, 0.95),
            quantile(&mut seconds, 1.0),
            quantile(&mut programs, 0.5),
        );
    }
    Ok(())
}

fn main() -> anyhow::Result<()> {
    let count = std::env::args().nth(1).map_or(Ok(20), |text| text.parse())?;
    print_moves()?;
    println!();
    print_random(count)
}
