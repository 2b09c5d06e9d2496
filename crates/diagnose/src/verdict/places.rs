//! Where the refitted model is wrong: in which equation, and when.

use bracketry_numerics::statistics::extremes;
use bracketry_symbolic::Symbol;
use bracketry_system::System;

use crate::gain::{Missing, MissingIn, missing};
use crate::library::{Kind, Structure, is_angle};
use crate::report::{Place, Regime, ResidualAcceleration};
use crate::settings::{DiagnosisSettings, PlaceSettings};
use crate::{DiagnoseError, Fit, Record};

/// Where the refitted model is wrong.
#[derive(Default)]
pub(super) struct Places {
    /// By equation and motion; the shares add up to one.
    pub(super) motion: Vec<Place>,
    /// By equation and acceleration, position, tilt.
    pub(super) regimes: Vec<Place>,
    /// What the equations miss over time.
    pub(super) over_time: Vec<ResidualAcceleration>,
}

/// Shares of the squared missing force, beyond noise, by equation and regime.
///
/// Equations count by the force that is missing on their coordinate relative to the one that its measured acceleration needs, both root
/// mean square, so that units do not matter and a force that accelerates several coordinates counts where it acts.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be evaluated.
pub(super) fn places(
    system: &System,
    records: &[Record],
    fit: &Fit,
    settings: &DiagnosisSettings,
) -> Result<Places, DiagnoseError> {
    let (stretches, mechanics) = missing(system, fit, records, &settings.gain.equations)?;
    let limits = &settings.verdict.places;
    let mut names: Vec<&str> = Vec::new();
    for m in stretches.iter().flat_map(|s| &s.equations) {
        if !names.contains(&m.name.as_str()) {
            names.push(&m.name);
        }
    }
    let mut tally = Tally::default();
    let mut system = system.clone();
    for name in names {
        let parts: Vec<(&Missing, &MissingIn)> =
            stretches.iter().filter_map(|s| Some((s, s.equations.iter().find(|m| m.name == name)?))).collect();
        let needed = rms(parts.iter().flat_map(|(_, m)| &m.inertia));
        if needed > 0.0 {
            let view = View::new(&mut system, mechanics.as_ref(), &parts, limits);
            for (stretch, m) in &parts {
                tally.add(name, &view.motion(stretch, m), m, needed, true);
                for regimes in view.others(stretch, m) {
                    tally.add(name, &regimes, m, needed, false);
                }
            }
        }
    }
    let series = |s| move |m| over_time(records, s, m, limits.most_values);
    let over_time = stretches.iter().flat_map(|s| s.equations.iter().map(series(s))).collect();
    let (motion, mut regimes) = tally.places();
    let share = |equation: &str| motion.iter().filter(|p| p.equation == equation).map(|p| p.share).sum::<f64>();
    regimes.retain(|p| share(&p.equation) >= limits.least_share);
    Ok(Places { motion, regimes, over_time })
}

fn rms<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

fn over_time(records: &[Record], stretch: &Missing, m: &MissingIn, most: usize) -> ResidualAcceleration {
    let every = stretch.times.len().div_ceil(most).max(1);
    ResidualAcceleration {
        record: records[stretch.record].name.clone(),
        equation: m.name.clone(),
        bandwidth_hz: stretch.bandwidth,
        std: m.std,
        times: stretch.times.iter().copied().step_by(every).collect(),
        values: m.rate.iter().copied().step_by(every).collect(),
    }
}

/// Error beyond noise and samples by equation and regime, in order of appearance.
#[derive(Default)]
struct Tally {
    rows: Vec<Row>,
}

struct Row {
    equation: String,
    regime: Regime,
    is_motion: bool,
    excess: f64,
    samples: usize,
}

impl Tally {
    fn add(&mut self, equation: &str, regimes: &[Regime], m: &MissingIn, needed: f64, is_motion: bool) {
        for (k, regime) in regimes.iter().enumerate() {
            let excess = (m.force[k] * m.force[k] - m.noise[k]) / (needed * needed);
            let at = self.rows.iter().position(|r| r.equation == equation && r.regime == *regime);
            let at = at.unwrap_or_else(|| {
                let (equation, regime) = (equation.to_owned(), regime.clone());
                self.rows.push(Row { equation, regime, is_motion, excess: 0.0, samples: 0 });
                self.rows.len() - 1
            });
            self.rows[at].excess += excess;
            self.rows[at].samples += 1;
        }
    }

    /// Shares by motion, and by everything else, the largest first.
    fn places(self) -> (Vec<Place>, Vec<Place>) {
        let beyond = |r: &Row| r.excess.max(0.0);
        let total: f64 = self.rows.iter().filter(|r| r.is_motion).map(beyond).sum();
        if !(total > 0.0 && total.is_finite()) {
            return (Vec::new(), Vec::new());
        }
        let samples = |of: &Row| -> usize {
            self.rows.iter().filter(|r| r.is_motion && r.equation == of.equation).map(|r| r.samples).sum()
        };
        let of = |is_motion: bool| {
            let rows = self.rows.iter().filter(|r| r.is_motion == is_motion);
            let mut places: Vec<Place> = rows
                .map(|r| Place {
                    equation: r.equation.clone(),
                    regime: r.regime.clone(),
                    share: beyond(r) / total,
                    time: Some(r.samples as f64 / samples(r) as f64),
                })
                .collect();
            if is_motion {
                places.sort_by(|a, b| b.share.total_cmp(&a.share));
            }
            places
        };
        (of(true), of(false))
    }
}

/// How the samples of one equation are told apart.
struct View {
    name: String,
    /// Whether the state is the rate of a coordinate.
    is_rate: bool,
    /// Whether the coordinate has dry friction.
    sliding: bool,
    near_rest: f64,
    lingering: f64,
    typical_rate: f64,
    /// The quantity whose thirds are told apart, and where they end.
    thirds: Option<(usize, String, [f64; 2])>,
    /// Angles in the equation, as states or inputs, by name.
    angles: Vec<(Angle, String)>,
}

enum Angle {
    State(usize),
    Input(usize),
}

impl View {
    fn new(
        system: &mut System,
        mechanics: Option<&Structure>,
        parts: &[(&Missing, &MissingIn)],
        limits: &PlaceSettings,
    ) -> Self {
        let state = parts[0].1.state;
        let coordinate = mechanics.and_then(|m| m.coordinates.iter().find(|c| c.rate == state));
        let values = |i: usize| parts.iter().filter_map(move |(s, _)| s.states[i].as_ref()).flatten();
        let position = coordinate.map_or(Some(state), |c| c.position);
        let thirds = position.and_then(|i| {
            let (low, high) = extremes(values(i).copied());
            let third = (high - low) / 3.0;
            let name = system.symbol_name(system.states[i]).to_owned();
            (third > 0.0 && third.is_finite()).then_some((i, name, [low + third, high - third]))
        });
        let used = system.pool.symbols_of(&[system.dynamics[state]]);
        let mut angles = Vec::new();
        let states = system.states.clone();
        for (i, &s) in states.iter().enumerate() {
            let own = position == Some(i) && coordinate.is_some_and(|c| c.kind == Kind::Angle);
            if !own && parts[0].0.states[i].is_some() && angle(system, s, &used) {
                angles.push((Angle::State(i), system.symbol_name(s).to_owned()));
            }
        }
        for (i, s) in system.inputs.clone().into_iter().enumerate() {
            if angle(system, s, &used) {
                angles.push((Angle::Input(i), system.symbol_name(s).to_owned()));
            }
        }
        angles.truncate(limits.most_angles);
        Self {
            name: parts[0].1.name.clone(),
            is_rate: coordinate.is_some(),
            sliding: coordinate.is_some_and(|c| c.has_dry_friction),
            near_rest: limits.near_rest * rms(values(state)),
            typical_rate: rms(parts.iter().flat_map(|(_, m)| &m.rate_of_state)),
            lingering: limits.lingering,
            thirds,
            angles,
        }
    }

    /// Rest, reversal, or motion in either direction; for a state that is no velocity, its thirds.
    fn motion(&self, stretch: &Missing, m: &MissingIn) -> Vec<Regime> {
        let Some(v) = stretch.states[m.state].as_ref() else { return Vec::new() };
        if !self.is_rate {
            return self.by_thirds(stretch).unwrap_or_default();
        }
        let (name, limit) = (&self.name, self.near_rest);
        let moving = |v: &f64| Regime::Motion { name: name.clone(), sliding: self.sliding, positive: *v > 0.0 };
        let mut regimes: Vec<Regime> = v.iter().map(moving).collect();
        let longest = self.lingering * 2.0 * limit / self.typical_rate.max(f64::MIN_POSITIVE);
        let mut from = 0;
        for run in v.chunk_by(|a, b| (a.abs() <= limit) == (b.abs() <= limit)) {
            let to = from + run.len();
            if run[0].abs() <= limit {
                let name = name.clone();
                let rests = stretch.times[to - 1] - stretch.times[from] > longest;
                let near_zero = if rests { Regime::Rest { name, limit } } else { Regime::Reversal { name, limit } };
                regimes[from..to].fill(near_zero);
            }
            from = to;
        }
        regimes
    }

    /// By acceleration, position and tilt.
    fn others(&self, stretch: &Missing, m: &MissingIn) -> Vec<Vec<Regime>> {
        let typical = self.typical_rate;
        let rate = |a: &f64| Regime::Rate { name: self.name.clone(), above: a.abs() > typical, typical };
        let mut all = vec![m.rate_of_state.iter().map(rate).collect()];
        if self.is_rate {
            all.extend(self.by_thirds(stretch));
        }
        for (angle, name) in &self.angles {
            let values = match angle {
                Angle::State(i) => stretch.states[*i].as_ref(),
                Angle::Input(i) => stretch.inputs.get(*i),
            };
            let tilt = |v: &f64| Regime::Tilt { name: name.clone(), positive: *v > 0.0 };
            all.extend(values.map(|values| values.iter().map(tilt).collect()));
        }
        all
    }

    fn by_thirds(&self, stretch: &Missing) -> Option<Vec<Regime>> {
        let (state, name, [low, high]) = self.thirds.as_ref()?;
        let third = |v: &f64| Regime::Third {
            name: name.clone(),
            from: (*v >= *low).then_some(if *v > *high { *high } else { *low }),
            to: (*v <= *high).then_some(if *v < *low { *low } else { *high }),
        };
        Some(stretch.states[*state].as_ref()?.iter().map(third).collect())
    }
}

/// Whether a symbol that an equation uses is an angle.
fn angle(system: &mut System, symbol: Symbol, used: &[Symbol]) -> bool {
    used.contains(&symbol) && is_angle(system, symbol)
}
