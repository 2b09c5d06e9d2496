//! How close a trajectory comes to where quotients of the equations have no value.

use bracketry_symbolic::Expr;

use crate::system::System;

/// Share of its largest length below which a vector counts as vanishing.
const NEAR: f64 = 1e-2;

/// Where a vector whose direction the equations use nearly vanishes, though that direction is no dry friction.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestApproach {
    /// Its components as they are written, with commas.
    pub name: String,
    /// Its smallest length, in the unit of its components.
    pub length: f64,
    /// The row before it, in the order of the trajectory.
    pub row: usize,
}

impl System {
    /// Where a trajectory, one row of states and inputs for each time, comes close to the singular point of a quotient σ/|σ| that
    /// is no dry friction ([`SwitchedForm::singular`](crate::SwitchedForm::singular)): closer than 1 % of the largest |σ| on the
    /// way, straight from row to row. What depends on derivatives of inputs is left out.
    pub fn closest_approaches<'a>(&self, rows: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> Vec<ClosestApproach> {
        let mut system = self.clone();
        let form = system.set_valued_form();
        if form.singular.is_empty() {
            return Vec::new();
        }
        let arguments = [&system.states[..], &system.inputs[..]].concat();
        let rows: Vec<Vec<f64>> = rows.map(|(x, u)| [x, u].concat()).collect();
        let mut found = Vec::new();
        for quotient in form.singular {
            let components: &[Expr] = &quotient.components;
            let Ok(tape) = system.compile(&arguments, components) else { continue };
            let mut work = Vec::new();
            let values = |row: &Vec<f64>| {
                let mut sigma = vec![0.0; components.len()];
                tape.eval(row, &mut work, &mut sigma);
                sigma
            };
            let sigmas: Vec<Vec<f64>> = rows.iter().map(values).collect();
            let longest = sigmas.iter().map(|s| dot(s, s).sqrt()).filter(|l| l.is_finite()).fold(0.0, f64::max);
            let alone = sigmas.first().map(|s| (dot(s, s).sqrt(), 0));
            let between = sigmas.windows(2).enumerate().map(|(k, pair)| (distance_from_zero(&pair[0], &pair[1]), k));
            let closest = between.chain(alone).filter(|c| c.0.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((length, row)) = closest.filter(|(length, _)| *length <= NEAR * longest) {
                found.push(ClosestApproach { name: quotient.name, length, row });
            }
        }
        found
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The distance of the straight line from a to b from the origin.
fn distance_from_zero(a: &[f64], b: &[f64]) -> f64 {
    let along: Vec<f64> = a.iter().zip(b).map(|(a, b)| b - a).collect();
    let square = dot(&along, &along);
    let share = if square > 0.0 { (-dot(a, &along) / square).clamp(0.0, 1.0) } else { 0.0 };
    let nearest: Vec<f64> = a.iter().zip(&along).map(|(a, d)| a + share * d).collect();
    dot(&nearest, &nearest).sqrt()
}
