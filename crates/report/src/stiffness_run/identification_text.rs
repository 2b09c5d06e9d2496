//! An identification in words.

use std::fmt;

use super::unexplained::Unexplained;
use super::{Identification, MethodSummary};

type Entries = [[f64; 6]; 6];
type Intervals = [[[f64; 2]; 6]; 6];

impl fmt::Display for Identification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} measurements", self.robot, self.measurements)?;
        if !self.outliers.is_empty() {
            let lines: Vec<String> = self.outliers.iter().map(ToString::to_string).collect();
            writeln!(f, "left out as outliers: lines {}", lines.join(", "))?;
        }
        if let Some(why) = &self.outliers_kept {
            writeln!(f, "no outliers left out: {why}")?;
        }
        self.write_methods(f)?;
        self.write_parameters(f)?;
        if let Some(rest) = &self.unexplained {
            write!(f, "\n{rest}")?;
        }
        if let (Some(compliance), Some(interval)) = (&self.compliance, &self.compliance_interval) {
            writeln!(
                f,
                "\ncompliance at the tool point, base axes [µm, µrad per N, N·m], ± half of the 95 % interval"
            )?;
            write_matrix(f, compliance, interval, 1e6)?;
        }
        if let (Some(stiffness), Some(interval)) = (&self.stiffness, &self.stiffness_interval) {
            writeln!(f, "\nstiffness, its inverse [N, N·m per µm, µrad]")?;
            write_matrix(f, stiffness, interval, 1e-6)?;
        }
        Ok(())
    }
}

impl Identification {
    fn write_methods(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{:24} {:>23} {:>10} {:>8}", "method", "error of prediction [σ]", "condition", "χ²/dof")?;
        for MethodSummary { method, held_out, condition, chi_square, .. } in &self.methods {
            let number = |value: &Option<f64>, digits: usize| {
                value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
            };
            let (held_out, condition, chi_square) = (number(held_out, 3), number(condition, 1), number(chi_square, 2));
            writeln!(f, "{method:24} {held_out:>23} {condition:>10} {chi_square:>8}")?;
        }
        writeln!(f)?;
        self.reasons.iter().try_for_each(|reason| writeln!(f, "{reason}"))?;
        let mut told: Vec<&str> = Vec::new();
        for why in self.methods.iter().filter_map(|method| method.failed.as_deref()) {
            if !told.contains(&why) {
                told.push(why);
                let alike = self.methods.iter().filter(|method| method.failed.as_deref() == Some(why));
                let alike: Vec<&str> = alike.map(|method| method.method.as_str()).collect();
                writeln!(f, "{}: does not apply, {why}", alike.join("; "))?;
            }
        }
        Ok(())
    }

    fn write_parameters(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.parameters.is_empty() {
            writeln!(f, "\nsprings of the joints (N·m/rad, N·m/rad³, rad, N·m), 95 % interval")?;
        }
        for p in &self.parameters {
            match (p.value, &p.why) {
                (Some([value, low, high]), _) => {
                    writeln!(f, "joint {} {:10} {value:.4e}  ({low:.4e} … {high:.4e})", p.joint, p.name)?;
                }
                (None, why) => {
                    let why = why.as_deref().unwrap_or("unknown");
                    writeln!(f, "joint {} {:10} not identified: {why}", p.joint, p.name)?;
                }
            }
        }
        if let Some(why) = &self.withheld {
            writeln!(f, "these springs are not written, and their intervals do not hold: {why}")?;
        } else if !self.parameters.is_empty() {
            writeln!(f, "the intervals hold as far as the model does")?;
        }
        Ok(())
    }
}

impl fmt::Display for Unexplained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [moved, left, noise] = [self.moved_rms_m, self.left_rms_m, self.noise_rms_m].map(|v| 1e6 * v);
        let springs = if self.linear { "the linear springs" } else { "the springs" };
        write!(f, "translations {moved:.1} µm rms; {springs} leave {left:.1} µm, noise alone {noise:.1} µm: ")?;
        if self.share == 0.0 {
            return writeln!(f, "nothing else is to be explained");
        }
        let model = if self.linear { "a linear" } else { "such a" };
        writeln!(
            f,
            "{:.1} % of the rms is nothing that {model} model of the joints explains, most of it at line {}",
            100.0 * self.share,
            self.worst_line
        )?;
        for lost in &self.lost_motion {
            writeln!(
                f,
                "joint {}: lost motion explains {:.0} % of what is left; give it gap = {:.1e}, engaged = {:.0} in the robot file and identify again",
                lost.joint,
                100.0 * lost.share,
                lost.gap,
                lost.engaged
            )?;
        }
        match self.with_lost_motion_rms_m {
            Some(remain) => writeln!(f, "with lost motion {:.1} µm remain", 1e6 * remain),
            None if self.linear => writeln!(f, "no lost motion found"),
            None => Ok(()),
        }
    }
}

fn write_matrix(f: &mut fmt::Formatter<'_>, values: &Entries, intervals: &Intervals, scale: f64) -> fmt::Result {
    for (row, intervals) in values.iter().zip(intervals) {
        let cells: Vec<String> = row
            .iter()
            .zip(intervals)
            .map(|(value, [low, high])| format!("{:9.4} ± {:.4}", scale * value, 0.5 * scale * (high - low)))
            .collect();
        writeln!(f, "{}", cells.join("  "))?;
    }
    Ok(())
}
