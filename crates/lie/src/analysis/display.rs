//! The result of an analysis as text.

use std::fmt;

use crate::analysis::report::{ModeReport, Report};
use crate::answer::Answer;
use crate::controllability::point::{PointReport, Subject};
use crate::dimensions::Dimensions;
use crate::named::Named;

fn yes_no(answer: &Answer<bool>) -> String {
    match answer {
        Answer::Known(true) => "yes".to_owned(),
        Answer::Known(false) => "no".to_owned(),
        Answer::Unknown(why) => format!("unknown ({why})"),
    }
}

/// A dimension among n, with the growth that leads to it.
fn dimension_line(f: &mut fmt::Formatter<'_>, label: &str, dimension: &Answer<usize>, growth: &[usize]) -> fmt::Result {
    let list: Vec<String> = growth.iter().map(ToString::to_string).collect();
    write!(f, "  {label:<22} {dimension}")?;
    if !list.is_empty() {
        write!(f, "   (growth {})", list.join(", "))?;
    }
    writeln!(f)
}

/// More names than this are told in part.
const MAX_NAMES: usize = 16;

/// The brackets that a dimension counts.
fn span_line(f: &mut fmt::Formatter<'_>, basis: &[String]) -> fmt::Result {
    if basis.is_empty() {
        return Ok(());
    }
    let told = &basis[..basis.len().min(MAX_NAMES)];
    let rest = if told.len() < basis.len() { ", …" } else { "" };
    writeln!(f, "    spanned by           {}{rest}", told.join(", "))
}

fn brackets(f: &mut fmt::Formatter<'_>, brackets: &Named<Answer<Vec<String>>>) -> fmt::Result {
    for (name, components) in &brackets.0 {
        match components {
            Answer::Known(list) => writeln!(f, "  {name} = ({})", list.join(", "))?,
            Answer::Unknown(why) => writeln!(f, "  {name} = unknown ({why})")?,
        }
    }
    Ok(())
}

impl fmt::Display for Dimensions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        dimension_line(f, "accessible", &self.accessible_dimension, &self.growth)?;
        span_line(f, &self.basis)?;
        dimension_line(f, "strongly accessible", &self.strongly_accessible_dimension, &self.strong_growth)?;
        if self.strong_basis == self.basis { Ok(()) } else { span_line(f, &self.strong_basis) }
    }
}

impl fmt::Display for ModeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.signs.0.is_empty() {
            writeln!(f, "at a generic point")?;
        } else {
            let signs: Vec<String> =
                self.signs.0.iter().map(|(n, s)| format!("{n} {} 0", if *s > 0 { ">" } else { "<" })).collect();
            writeln!(f, "while {}", signs.join(", "))?;
        }
        write!(f, "{}", self.dimensions)?;
        match &self.autonomous {
            Answer::Known(list) => {
                if !list.is_empty() {
                    writeln!(f, "  no input influences    {}", list.join(",  "))?;
                }
                match self.autonomous_not_found {
                    None => {}
                    Some(1) => writeln!(f, "  and 1 further independent function that was not found in closed form")?,
                    Some(k) => {
                        writeln!(f, "  and {k} further independent functions that were not found in closed form")?;
                    }
                }
            }
            Answer::Unknown(why) => writeln!(f, "  no input influences    unknown ({why})")?,
        }
        if !self.signs.0.is_empty() {
            writeln!(f, "  involutive inputs      {}", yes_no(&self.involutive))?;
            writeln!(f, "  feedback linearizable  {}", yes_no(&self.static_feedback_linearizable))?;
        }
        brackets(f, &self.brackets)
    }
}

impl fmt::Display for PointReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.dimensions)?;
        writeln!(f, "  equilibrium            {}", yes_no(&self.equilibrium))?;
        if let Some(rank) = self.linear_controllability_rank {
            writeln!(f, "  linear rank            {rank}")?;
        }
        if let Some(s) = &self.stabilizable {
            let why = self.stabilizable_reason.as_deref().filter(|_| s.known().is_some());
            writeln!(f, "  stabilizable           {}{}", yes_no(s), why.map_or(String::new(), |w| format!(": {w}")))?;
        }
        if let Some(modes) = self.uncontrollable_modes.as_ref().and_then(Answer::known).filter(|m| !m.is_empty()) {
            let modes: Vec<String> = modes.iter().map(ToString::to_string).collect();
            writeln!(f, "  uncontrollable modes   {}", modes.join(";  "))?;
        }
        if let Some(brockett) = &self.brockett_condition {
            let what = match brockett {
                Answer::Known(true) => "holds".to_owned(),
                Answer::Known(false) => "fails: no continuous state feedback stabilises".to_owned(),
                Answer::Unknown(why) => format!("unknown ({why})"),
            };
            writeln!(f, "  Brockett's condition   {what}")?;
        }
        writeln!(f, "  small-time control     {}: {}", self.stlc.verdict, self.stlc.reason)?;
        match &self.relative_degree_defined {
            Some(defined) => writeln!(f, "  vector relative degree {}", yes_no(defined)),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.modes.iter().any(|m| m.signs.0.len() > 1) {
            writeln!(f, "modes are combinations of signs; whether each occurs is not checked")?;
        }
        // Modes that agree in everything but their signs are told together.
        let mut told: Vec<&ModeReport> = Vec::new();
        for mode in &self.modes {
            let same = |o: &&ModeReport| {
                o.dimensions == mode.dimensions
                    && o.autonomous == mode.autonomous
                    && o.involutive == mode.involutive
                    && o.static_feedback_linearizable == mode.static_feedback_linearizable
                    && o.brackets == mode.brackets
            };
            if told.iter().any(same) {
                continue;
            }
            told.push(mode);
            write!(f, "{mode}")?;
            let others = self.modes.iter().filter(|o| same(o)).count() - 1;
            match others {
                0 => {}
                1 => writeln!(f, "  the same in 1 other mode")?,
                _ => writeln!(f, "  the same in {others} other modes")?,
            }
        }
        if let Some(d) = &self.switched {
            write!(f, "switching between all modes\n{d}")?;
        }
        if let Some(s) = &self.smoothed {
            write!(f, "smoothed, width {}\n{}", s.epsilon, s.dimensions)?;
        }
        match &self.at_point {
            Some(Answer::Known(p)) => {
                write!(f, "at the point of the model")?;
                if let Some(width) = p.epsilon {
                    let verb = if p.vanishing.len() == 1 { "vanishes" } else { "vanish" };
                    write!(f, ", smoothed with width {width} ({} {verb} there)", p.vanishing.join(", "))?;
                }
                write!(f, "\n{p}")?;
            }
            Some(Answer::Unknown(why)) => writeln!(f, "at the point of the model: unknown ({why})")?,
            None => {}
        }
        let of = if self.global_statements_of == Some(Subject::Smoothed) { "smoothed model: " } else { "" };
        if let Some(algebra) = &self.lie_algebra {
            writeln!(f, "Lie algebra: {algebra}")?;
        }
        writeln!(f, "{of}input fields involutive: {}", yes_no(&self.involutive))?;
        if !matches!(self.involutive, Answer::Known(true)) {
            writeln!(f, "{of}involutive closure of the input fields: {}", self.involutive_closure)?;
        }
        writeln!(
            f,
            "{of}linearizable by static feedback near a generic point: {}",
            yes_no(&self.static_feedback_linearizable)
        )?;
        write!(f, "{}", self.control)?;
        if let Some(o) = &self.observability {
            o.write(f, of)?;
        }
        if !self.brackets.is_empty() {
            writeln!(f, "{of}brackets")?;
            brackets(f, &self.brackets)?;
        }
        if self.decided() && self.certificate.decisions() > 0 {
            let points = self.certificate.points();
            let noun = if points == 1 { "point" } else { "points" };
            let error = self.certificate.error_text();
            write!(f, "exact modulo 2^61-1 at {points} {noun}, error probability {error}; ")?;
        }
        writeln!(f, "{:.3} s", self.seconds)
    }
}
