//! What equations of motion miss over time: as rates of their states, and as forces on their coordinates.

use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

use super::evaluation::{Equations, Evaluated};
use crate::error::DiagnoseError;
use crate::library::Structure;
use crate::record::Record;
use crate::settings::EquationSettings;
use crate::study::Fit;

/// What the equations miss in one stretch of a record, all at the same samples.
pub(crate) struct Missing {
    /// Index of the record.
    pub(crate) record: usize,
    /// Times of the samples, s.
    pub(crate) times: Vec<f64>,
    /// Bandwidth, Hz.
    pub(crate) bandwidth: f64,
    /// The equations.
    pub(crate) equations: Vec<MissingIn>,
    /// The states that measured columns give.
    pub(crate) states: Vec<Option<Vec<f64>>>,
    /// The inputs.
    pub(crate) inputs: Vec<Vec<f64>>,
}

/// What one equation misses.
pub(crate) struct MissingIn {
    /// The state whose time derivative it gives.
    pub(crate) state: usize,
    /// Its name.
    pub(crate) name: String,
    /// Measured minus modeled rate: of a velocity, the force per mass that is missing.
    pub(crate) rate: Vec<f64>,
    /// Standard deviation of `rate` by noise of the sensor.
    pub(crate) std: f64,
    /// The measured rate.
    pub(crate) rate_of_state: Vec<f64>,
    /// The force on the state's coordinate that makes up for what is missing, together with those on the other coordinates.
    pub(crate) force: Vec<f64>,
    /// The force that the measured rates need on the coordinate if nothing else acts.
    pub(crate) inertia: Vec<f64>,
    /// Variance of `force` by noise of the sensors.
    pub(crate) noise: Vec<f64>,
}

/// What the equations of a fitted model miss, and what its coordinates are like.
///
/// One missing force shows in the equations of all coordinates that it accelerates, through the inverse mass matrix M⁻¹: what is missing
/// are the forces τ with `M⁻¹τ = x' − f`, all equations together. The columns of M⁻¹ are those by which the inputs act; a coordinate
/// without an input of its own is taken as accelerated by its force alone.
///
/// # Errors
/// [`DiagnoseError`] for effects that do not fit the model.
pub(crate) fn missing(
    system: &System,
    fit: &Fit,
    records: &[Record],
    settings: &EquationSettings,
) -> Result<(Vec<Missing>, Option<Structure>), DiagnoseError> {
    let equations = Equations::new(system, &fit.effects, &fit.values, true, settings)?;
    let stretches = records.iter().enumerate().flat_map(|(index, record)| equations.evaluate(index, record));
    let list = stretches.filter_map(|stretch| in_stretch(&equations, &stretch)).collect();
    Ok((list, equations.mechanics))
}

fn in_stretch(equations: &Equations, stretch: &Evaluated) -> Option<Missing> {
    let kept = stretch.kept.clone();
    let at = |values: &[f64]| values[kept.clone()].to_vec();
    let mut found = Vec::with_capacity(stretch.rows.len());
    for row in &stretch.rows {
        let difference: Vec<f64> = row.rate.iter().zip(&row.model).map(|(rate, f)| rate - f).collect();
        let rate = at(&stretch.smooth(&difference)?);
        let inertia = at(&stretch.smooth(&row.rate)?);
        if rate.iter().chain(&inertia).any(|v| !v.is_finite()) {
            return None;
        }
        found.push(MissingIn {
            state: row.state,
            name: equations.state_name(row.state),
            force: rate.clone(),
            noise: vec![row.noise * row.noise; rate.len()],
            std: row.noise,
            rate,
            rate_of_state: inertia.clone(),
            inertia,
        });
    }
    if let Some(mechanics) = &equations.mechanics {
        as_forces(stretch, mechanics, &mut found);
    }
    Some(Missing {
        record: stretch.record,
        times: kept.clone().map(|k| stretch.time(k)).collect(),
        bandwidth: stretch.bandwidth,
        equations: found,
        states: stretch.states.iter().map(|values| values.as_ref().map(|v| at(v))).collect(),
        inputs: stretch.inputs.iter().map(|v| at(v)).collect(),
    })
}

/// Turns rates of coordinates into forces on them; where the forces do not tell the rates apart, rates stay.
fn as_forces(stretch: &Evaluated, mechanics: &Structure, found: &mut [MissingIn]) {
    // Coordinates whose equation is there: their place among the coordinates, that of their equation.
    let pairs: Vec<(usize, usize)> = mechanics
        .coordinates
        .iter()
        .enumerate()
        .filter_map(|(j, c)| Some((j, found.iter().position(|m| m.state == c.rate)?)))
        .collect();
    let n = pairs.len();
    for (place, k) in stretch.kept.clone().enumerate() {
        let mut directions = DMatrix::zeros(n, n);
        for (column, (j, _)) in pairs.iter().enumerate() {
            for (state, values) in &stretch.forces[*j] {
                if let Some(row) = pairs.iter().position(|(_, equation)| found[*equation].state == *state) {
                    directions[(row, column)] = values[k];
                }
            }
        }
        let Some(inverse) = directions.try_inverse().filter(|m| m.iter().all(|v| v.is_finite())) else { continue };
        let of = |value: fn(&MissingIn, usize) -> f64| {
            DVector::from_iterator(n, pairs.iter().map(|(_, equation)| value(&found[*equation], place)))
        };
        let force = &inverse * of(|m, place| m.rate[place]);
        let inertia = &inverse * of(|m, place| m.rate_of_state[place]);
        let noise = inverse.map(|v| v * v) * of(|m, _| m.std * m.std);
        for (row, (_, equation)) in pairs.iter().enumerate() {
            let m = &mut found[*equation];
            (m.force[place], m.inertia[place], m.noise[place]) = (force[row], inertia[row], noise[row]);
        }
    }
}
