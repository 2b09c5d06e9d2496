//! An identification as Markdown.

use std::fmt::Write;

use super::Identification;
use super::identification::TWIST;
use super::log::WRENCH;

impl Identification {
    /// The report as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("# Stiffness of {}\n\n{} measurements", self.robot, self.measurements);
        if !self.outliers.is_empty() {
            let lines: Vec<String> = self.outliers.iter().map(ToString::to_string).collect();
            let _ = write!(out, "; left out as outliers: lines {}", lines.join(", "));
        }
        out.push_str(".\n\n");
        if let Some(why) = &self.outliers_kept {
            let _ = writeln!(out, "No outliers left out: {why}.\n");
        }
        let header = ["method", "error of prediction [σ]", "condition", "χ²/dof", "does not apply"];
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.3}"));
        let row = |m: &super::MethodSummary| {
            let failed = m.failed.clone().unwrap_or_default();
            vec![m.method.clone(), number(m.held_out), number(m.condition), number(m.chi_square), failed]
        };
        table(&mut out, &header, self.methods.iter().map(row));
        self.reasons.iter().for_each(|reason| {
            let _ = writeln!(out, "- {reason}");
        });
        if !self.parameters.is_empty() {
            out.push_str("\n## Springs of the joints\n\nN·m/rad, N·m/rad³, rad, N·m.\n\n");
            let row = |p: &super::ParameterSummary| {
                let (value, interval) = match p.value {
                    Some([value, low, high]) => (format!("{value:.4e}"), format!("{low:.4e} … {high:.4e}")),
                    None => ("not identified".to_owned(), p.why.clone().unwrap_or_default()),
                };
                vec![p.joint.to_string(), p.name.clone(), value, interval]
            };
            table(&mut out, &["joint", "number", "value", "95 % interval"], self.parameters.iter().map(row));
        }
        if let Some(why) = &self.withheld {
            let _ = writeln!(out, "These springs are not written, and their intervals do not hold: {why}.\n");
        }
        if let Some(rest) = &self.unexplained {
            out.push_str("## What they do not explain\n\n");
            rest.to_string().lines().for_each(|line| {
                let _ = writeln!(out, "- {line}");
            });
            out.push('\n');
        }
        for (title, values, intervals, columns, rows, scale) in [
            ("Compliance [µm, µrad per N, N·m]", self.compliance, self.compliance_interval, WRENCH, TWIST, 1e6),
            ("Stiffness [N, N·m per µm, µrad]", self.stiffness, self.stiffness_interval, TWIST, WRENCH, 1e-6),
        ] {
            let (Some(values), Some(intervals)) = (values, intervals) else { continue };
            let _ = writeln!(out, "## {title}\n\nTool point, base axes; ± half of the 95 % interval.\n");
            let header: Vec<&str> = std::iter::once("").chain(columns).collect();
            let row = |i: usize| {
                let cell = |j: usize| {
                    let [low, high] = intervals[i][j];
                    format!("{:.4} ± {:.4}", scale * values[i][j], 0.5 * scale * (high - low))
                };
                std::iter::once(rows[i].to_owned()).chain((0..6).map(cell)).collect()
            };
            table(&mut out, &header, (0..6).map(row));
        }
        out
    }
}

fn table(out: &mut String, header: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let _ = writeln!(out, "| {} |\n|{}", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let _ = writeln!(out, "| {} |", row.join(" | "));
    }
    out.push('\n');
}
