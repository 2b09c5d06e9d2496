//! An identification as Markdown.

use std::fmt::Write;

use bracketry_stiffness::{Identification, Identified, TWIST_COLUMNS, WRENCH_COLUMNS};

use super::text;

/// An identification as Markdown.
pub fn identification(found: &Identification) -> String {
    let mut out = format!("# Stiffness of {}\n\n{} measurements", found.robot, found.measurements);
    if !found.outliers.is_empty() {
        let _ = write!(out, "; excluded as outliers: lines {}", text::listed(&found.outliers));
    }
    out.push_str(".\n\n");
    if let Some(why) = &found.outliers_kept {
        let _ = writeln!(out, "No outliers excluded: {why}.\n");
    }
    let header = ["method", "error of prediction [σ]", "condition", "χ²/dof", "does not apply"];
    let methods = found.methods.iter().map(|(method, figures)| {
        let numbers = match figures {
            Ok(f) => [f.held_out, f.condition, f.chi_square].map(|value| format!("{value:.3}")),
            Err(_) => Default::default(),
        };
        let failed = figures.as_ref().err().map(ToString::to_string).unwrap_or_default();
        [method.to_string()].into_iter().chain(numbers).chain([failed]).collect()
    });
    table(&mut out, &header, methods);
    for advice in &found.advice {
        let _ = writeln!(out, "- {}", text::advice(advice));
    }
    if !found.parameters.is_empty() {
        out.push_str("\n## Joint springs\n\nN·m/rad, N·m/rad³, rad, N·m.\n\n");
        let parameters = found.parameters.iter().map(|p| {
            let (value, interval) = match &p.identified {
                Identified::Yes { value, low, high } => (format!("{value:.4e}"), format!("{low:.4e} … {high:.4e}")),
                no @ Identified::No { .. } => ("not identified".to_owned(), no.why().unwrap_or_default()),
            };
            vec![p.joint.to_string(), p.name.to_owned(), value, interval]
        });
        table(&mut out, &["joint", "number", "value", "95 % interval"], parameters);
    }
    if let Some(why) = &found.withheld {
        let why = text::withheld(why);
        let _ = writeln!(out, "These springs are not written, and their intervals are not valid: {why}.\n");
    }
    if let Some(residual) = &found.residual {
        out.push_str("## Unexplained residual\n\n");
        for line in text::residual(residual).lines() {
            let _ = writeln!(out, "- {line}");
        }
        out.push('\n');
    }
    if let Some(pose) = &found.cartesian {
        let interval = |i, j| pose.compliance_interval(i, j);
        let title = "Compliance [µm, µrad per N, N·m]";
        matrix(&mut out, title, [TWIST_COLUMNS, WRENCH_COLUMNS], 1e6, |i, j| (pose.compliance[(i, j)], interval(i, j)));
        let interval = |i, j| pose.stiffness_interval(i, j);
        let title = "Stiffness [N, N·m per µm, µrad]";
        matrix(&mut out, title, [WRENCH_COLUMNS, TWIST_COLUMNS], 1e-6, |i, j| (pose.stiffness[(i, j)], interval(i, j)));
    }
    out
}

/// A matrix of entries with their intervals; names of its rows, then of its columns.
fn matrix(
    out: &mut String,
    title: &str,
    [rows, columns]: [[&str; 6]; 2],
    scale: f64,
    entry: impl Fn(usize, usize) -> (f64, (f64, f64)),
) {
    let _ = writeln!(out, "## {title}\n\nTool point, base axes; ± half of the 95 % interval.\n");
    let header: Vec<&str> = std::iter::once("").chain(columns).collect();
    let row = |i: usize| {
        let cell = |j: usize| {
            let (value, (low, high)) = entry(i, j);
            format!("{:.4} ± {:.4}", scale * value, 0.5 * scale * (high - low))
        };
        std::iter::once(rows[i].to_owned()).chain((0..6).map(cell)).collect()
    };
    table(out, &header, (0..6).map(row));
}

fn table(out: &mut String, header: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let _ = writeln!(out, "| {} |\n|{}", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let _ = writeln!(out, "| {} |", row.join(" | "));
    }
    out.push('\n');
}
