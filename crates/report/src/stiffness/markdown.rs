//! An identification as Markdown.

use std::fmt::Write;

use bracketry_stiffness::Identification;

use super::tables::{MATRIX, compliance, methods, springs, stiffness};
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
    let (header, rows) = methods(found);
    table(&mut out, &header, rows);
    for advice in &found.advice {
        let _ = writeln!(out, "- {}", text::advice(advice));
    }
    if !found.parameters.is_empty() {
        out.push_str("\n## Joint springs\n\nN·m/rad, N·m/rad³, rad, N·m.\n\n");
        let (header, rows) = springs(found);
        table(&mut out, &header, rows);
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
        for matrix in [compliance(pose), stiffness(pose)] {
            let _ = writeln!(out, "## {}\n\n{MATRIX}\n", matrix.title);
            table(&mut out, &matrix.header, matrix.rows);
        }
    }
    out
}

fn table(out: &mut String, header: &[&str], rows: Vec<Vec<String>>) {
    let _ = writeln!(out, "| {} |\n|{}", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let _ = writeln!(out, "| {} |", row.join(" | "));
    }
    out.push('\n');
}
