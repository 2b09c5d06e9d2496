//! Solves the first sample of problem files from their guess, and prints cost, programs and time.
//!
//! `cargo run --release -p bracketry-mpc --example first_plan --features measure -- [--hessian gauss-newton|exact|automatic] [--log] FILE…`
#![allow(clippy::print_stdout)]

use bracketry_mpc::sqp::Hessian;
use bracketry_mpc::{ControlProblem, PlannedTrajectory, Sqp, SqpSettings, SymbolicDynamics};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut hessian, mut log, mut files) = (None, false, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(a) = arguments.next() {
        match a.as_str() {
            "--log" => log = true,
            "--hessian" => {
                hessian = match arguments.next().as_deref() {
                    Some("gauss-newton") => Some(Hessian::GaussNewton),
                    Some("exact") => Some(Hessian::Exact),
                    Some("automatic") => Some(Hessian::Automatic),
                    _ => None,
                }
            }
            _ => files.push(a),
        }
    }
    for file in files {
        let p = ControlProblem::read(&file)?;
        let convergence = p.method.convergence();
        let settings = SqpSettings {
            hessian: hessian.unwrap_or(convergence.hessian),
            smoothing: p.widths(),
            qp: p.qp,
            ..SqpSettings::default()
        };
        let mut sqp = Sqp::new(Box::new(SymbolicDynamics::new(&p.system)?), p.ocp.clone(), settings)?;
        let mut guess = PlannedTrajectory::constant(p.ocp.steps, &p.x0, &vec![0.0; p.ocp.inputs()]);
        for (k, u) in p.guess.iter().enumerate() {
            guess.u_mut(k).copy_from_slice(u);
        }
        let s = sqp.solve(&p.x0, &guess)?;
        let name = std::path::Path::new(&file).file_stem().map(|s| s.to_string_lossy().into_owned());
        let miss = s.miss.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        println!(
            "{:24} {:14.5} programs {:4} {:9.1} ms defect {:.1e} miss {miss:.1e} {}",
            name.unwrap_or_default(),
            s.cost,
            s.iterations.len(),
            1e3 * s.seconds,
            s.defect,
            s.status
        );
        for i in s.iterations.iter().filter(|_| log) {
            println!(
                "    {:12.5} defect {:.1e} predicted {:9.2e} ratio {:9.2e} prox {:.1e} fraction {:.3}{} {:?} {}",
                i.objective,
                i.defect,
                i.predicted,
                i.ratio,
                i.proximal,
                i.fraction,
                if i.correction { " soc" } else { "" },
                i.qp,
                i.qp_iterations
            );
        }
    }
    Ok(())
}
