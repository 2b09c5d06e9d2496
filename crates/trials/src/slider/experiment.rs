//! A slider on a rail, its measured run and the model that lacks something.

use super::effect::SliderEffect;
use super::error::SyntheticError;
use super::excitation::Excitation;
use bracketry_sim::{Hold, Inputs, Model, Samples, SimulationSettings, simulate};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::fmt::Write;

/// Trials for the strength that gives an effect its size.
const TRIALS: usize = 30;
/// Deviation of an effect's size at which the search for its strength ends.
const CLOSE: f64 = 0.02;
/// Largest deviation of an effect's size from the one that is wanted.
const FAR: f64 = 0.2;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SliderSensors {
    /// Position x and velocity v.
    PositionAndVelocity,
    /// Position x.
    Position,
}

/// A slider with dry friction and an experiment on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Slider {
    /// What is measured.
    pub sensors: SliderSensors,
    /// Mass, kg.
    pub mass: f64,
    /// Coulomb friction, N.
    pub friction: f64,
    /// Deviation of the model's mass, relative; its sign is drawn.
    pub mass_error: f64,
    /// Deviation of the model's friction, relative; its sign is drawn.
    pub friction_error: f64,
    /// How the slider is driven.
    pub excitation: Excitation,
    /// Root mean square of the driving force, N.
    pub drive: f64,
    /// Length of the log, s.
    pub duration: f64,
    /// Samples per second.
    pub rate: f64,
    /// Time for which the slider has been driven when the log begins, s; at rest at x = 0 before.
    pub lead: f64,
    /// Standard deviation of the white noise on each measured column, relative to the column's rms.
    pub noise: f64,
    /// Root mean square of each hidden effect's force, relative to the drive's. At 0.1 a delay is
    /// 8 ms and the compliance of bristles 0.2 mm/N; both in proportion to it.
    pub size: f64,
}

/// A hidden effect as it was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Hidden {
    /// The effect.
    pub effect: SliderEffect,
    /// Its coefficient in SI units: factor of its force, delay, lag, compliance of a spring or of bristles, limit
    /// to the power −8.
    pub strength: f64,
    /// Its shape: Stribeck velocity, frequency, wave number, share of the hanging mass, time to warm up; 0 if it has none.
    pub shape: f64,
    /// Root mean square of its force relative to the drive's.
    pub size: f64,
}

/// What a diagnosis should find.
#[derive(Clone, Debug, PartialEq)]
pub struct SliderTruth {
    /// The effects that the plant has and the model lacks.
    pub hidden: Vec<Hidden>,
    /// The plant's mass, kg.
    pub mass: f64,
    /// The plant's Coulomb friction, N.
    pub friction: f64,
}

/// A log with the model that belongs to it, and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct SliderLog {
    /// Names and values of the columns: `t` (s), input `u` (N), `x` (m), where it is measured `v` (m/s).
    pub columns: Vec<(String, Vec<f64>)>,
    /// The nominal model, as a model file.
    pub model: String,
    /// What was hidden.
    pub truth: SliderTruth,
}

/// The force on the slider.
struct Drive<'a> {
    /// Times in s.
    times: &'a [f64],
    /// Force in N at these times.
    force: &'a [f64],
    /// Number of samples before the log begins.
    before: usize,
}

impl Slider {
    /// The basic trial: 1 kg, 1 N of friction, 8 s at 1 kHz of a multisine with 3 N rms, 1 % noise, a model whose mass is off by 3 % and
    /// whose friction by 5 %, an effect of 10 %. Band, lines and lead are drawn: half of the logs begin at rest.
    pub fn basic(sensors: SliderSensors, random: &mut StdRng) -> Self {
        Self {
            sensors,
            mass: 1.0,
            friction: 1.0,
            mass_error: 0.03,
            friction_error: 0.05,
            excitation: Excitation::random_multisine(random),
            drive: 3.0,
            duration: 8.0,
            rate: 1000.0,
            lead: if random.random_bool(0.5) { 0.0 } else { random.random_range(0.5..2.0) },
            noise: 0.01,
            size: 0.1,
        }
    }

    /// Sampling from 200 Hz to 2 kHz, noise from 0.3 % to 2 %, effects from 3 % to 20 %, drive, friction, excitation and lead at random.
    pub fn random(sensors: SliderSensors, random: &mut StdRng) -> Self {
        Self {
            mass: between(random, 0.3, 3.0),
            friction: between(random, 0.5, 1.5),
            drive: between(random, 2.5, 4.5),
            excitation: Excitation::random(random),
            duration: between(random, 6.0, 12.0),
            rate: between(random, 200.0, 2000.0).round(),
            noise: between(random, 0.003, 0.02),
            size: between(random, 0.03, 0.2),
            ..Self::basic(sensors, random)
        }
    }

    /// Simulates the slider with the given effects hidden in it; the same seed gives the same log.
    ///
    /// # Errors
    /// [`SyntheticError`] for settings without meaning and for an effect that cannot be given the wanted size.
    pub fn run(&self, hidden: &[SliderEffect], seed: u64) -> Result<SliderLog, SyntheticError> {
        self.check()?;
        let mut random = StdRng::seed_from_u64(seed);
        let (before, count) = ((self.lead * self.rate).round() as i64, (self.duration * self.rate).round() as i64);
        let times: Vec<f64> = (-before..=count).map(|k| k as f64 / self.rate).collect();
        let before = before as usize;
        let mut force = self.excitation.samples(&times, &mut random);
        let scale = self.drive / rms(&force[before..]);
        for u in &mut force {
            *u *= scale;
        }

        let mut effects: Vec<Hidden> = hidden
            .iter()
            .map(|&effect| {
                let sign = if effect.either_sign() && random.random_bool(0.5) { -1.0 } else { 1.0 };
                let strength = effect.given_strength(self.size).unwrap_or(effect.physics().strength);
                Hidden { effect, strength: sign * strength, shape: effect.random_shape(&mut random), size: 0.0 }
            })
            .collect();
        let states = self.fit_strengths(&mut effects, &Drive { times: &times, force: &force, before })?;
        let mut columns = vec![("t".to_owned(), times[before..].to_vec()), ("u".to_owned(), force[before..].to_vec())];
        let measured = match self.sensors {
            SliderSensors::PositionAndVelocity => &["x", "v"][..],
            SliderSensors::Position => &["x"],
        };
        for (k, name) in measured.iter().enumerate() {
            let mut values: Vec<f64> = states.iter().map(|state| state[k]).collect();
            let deviation = self.noise * rms(&values);
            for value in &mut values {
                let normal: f64 = StandardNormal.sample(&mut random);
                *value += deviation * normal;
            }
            columns.push(((*name).to_owned(), values));
        }
        let mut off = |error: f64| if random.random_bool(0.5) { 1.0 + error } else { 1.0 - error };
        let model = nominal_model(self.mass * off(self.mass_error), self.friction * off(self.friction_error));
        Ok(SliderLog {
            columns,
            model,
            truth: SliderTruth { hidden: effects, mass: self.mass, friction: self.friction },
        })
    }

    fn check(&self) -> Result<(), SyntheticError> {
        // Lead and noise may be zero.
        let settings = [
            ("mass", self.mass, f64::MIN_POSITIVE),
            ("friction", self.friction, f64::MIN_POSITIVE),
            ("drive", self.drive, f64::MIN_POSITIVE),
            ("duration", self.duration, f64::MIN_POSITIVE),
            ("rate", self.rate, f64::MIN_POSITIVE),
            ("size", self.size, f64::MIN_POSITIVE),
            ("lead", self.lead, 0.0),
            ("noise", self.noise, 0.0),
        ];
        match settings.into_iter().find(|(_, value, least)| !(value.is_finite() && value >= least)) {
            Some((name, value, _)) => Err(SyntheticError::Setting { name, value }),
            None => Ok(()),
        }
    }

    /// Changes the strengths until each effect has its size; returns the states in the log.
    fn fit_strengths(&self, effects: &mut [Hidden], drive: &Drive<'_>) -> Result<Vec<Vec<f64>>, SyntheticError> {
        for trial in 1..=TRIALS {
            let states = self.simulate(effects, drive)?;
            let off = |hidden: &Hidden| match hidden.effect.given_strength(self.size) {
                Some(_) => 0.0,
                None => (hidden.size / self.size - 1.0).abs(),
            };
            let worst = effects.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
            let Some(worst) = worst else { return Ok(states) };
            if off(worst) < CLOSE || (trial == TRIALS && off(worst) < FAR) {
                return Ok(states);
            }
            if trial == TRIALS {
                return Err(SyntheticError::Size { effect: worst.effect, wanted: self.size, reached: worst.size });
            }
            for hidden in effects.iter_mut().filter(|h| off(h) > 0.0) {
                hidden.strength *= (self.size / hidden.size).clamp(0.2, 5.0);
            }
        }
        Ok(Vec::new())
    }

    /// Simulates the plant, writes the effects' sizes and returns the states at the times of the log.
    fn simulate(&self, effects: &mut [Hidden], drive: &Drive<'_>) -> Result<Vec<Vec<f64>>, SyntheticError> {
        let &Drive { times, force, before } = drive;
        let system = System::parse("slider with a hidden effect", &self.plant(effects))?;
        let delay = |hidden: &&Hidden| hidden.effect == SliderEffect::InputDelay;
        let late: f64 = effects.iter().filter(delay).map(|hidden| hidden.strength).sum();
        // No force before the experiment.
        let signal = |late: f64| {
            let mut at: Vec<f64> = times.iter().map(|t| t + late).collect();
            let mut values = force.to_vec();
            at.insert(0, times[0] - 1.0);
            values.insert(0, 0.0);
            Samples::new(at, values, Hold::Previous)
        };
        let inputs = Inputs::new().samples("u", signal(late)?).samples("command", signal(0.0)?);
        let mut model = Model::new(&system, &inputs)?;
        let mut x0 = vec![0.0, 0.0];
        x0.extend(effects.iter().flat_map(|hidden| hidden.effect.physics().states).map(|state| state.2));
        let end = times[times.len() - 1];
        let run = simulate(model.clone(), times[0], &x0, end, &SimulationSettings::default())?;
        if !run.outcome.is_finished() {
            return Err(SyntheticError::Ended(run.outcome));
        }
        let times = &times[before..];
        let states: Vec<Vec<f64>> = times.iter().map(|&t| run.trajectory.sample(t)).collect();
        let mut squares = vec![0.0; effects.len()];
        for (&t, x) in times.iter().zip(&states) {
            squares.iter_mut().zip(model.output_values(t, x)).for_each(|(sum, force)| *sum += force * force);
        }
        for (hidden, sum) in effects.iter_mut().zip(squares) {
            hidden.size = (sum / times.len() as f64).sqrt() / self.drive;
        }
        Ok(states)
    }

    /// The plant's model file: inputs u and `command`, one output per effect, the difference that it makes to the force.
    fn plant(&self, effects: &[Hidden]) -> String {
        let Self { mass, friction, .. } = self;
        let (mut parameters, mut definitions, mut outputs) = (String::new(), String::new(), String::new());
        let (mut states, mut dynamics) = (String::from("\"x\", \"v\""), String::from("x = \"v\"\n"));
        let mut total = String::from("u");
        if !effects.iter().any(|hidden| hidden.effect.physics().replaces_friction) {
            total.push_str(" - F*sign(v)");
        }
        for (k, hidden) in effects.iter().enumerate() {
            let physics = hidden.effect.physics();
            let text = |template: &str| template.replace("{a}", &format!("a{k}")).replace("{b}", &format!("b{k}"));
            let _ = writeln!(parameters, "a{k} = {:e}\nb{k} = {:e}", hidden.strength, hidden.shape);
            for (name, value) in physics.definitions {
                let _ = writeln!(definitions, "{name} = \"{}\"", text(value));
            }
            for (name, derivative, _) in physics.states {
                let _ = write!(states, ", \"{name}\"");
                let _ = writeln!(dynamics, "{name} = \"{}\"", text(derivative));
            }
            let _ = write!(total, " + ({})", text(physics.force));
            let _ = writeln!(outputs, "difference{k} = \"{}\"", text(physics.difference.unwrap_or(physics.force)));
        }
        format!(
            "states = [{states}]\ninputs = [\"u\", \"command\"]\n[parameters]\nM = {mass:e}\nF = {friction:e}\n{parameters}\
             [definitions]\n{definitions}[dynamics]\n{dynamics}v = \"({total})/M\"\n[outputs]\n{outputs}"
        )
    }
}

impl SliderLog {
    /// The log as CSV: a header and one line per time.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.columns[0].1.len() {
            for (k, (_, values)) in self.columns.iter().enumerate() {
                let _ = write!(text, "{}{}", if k == 0 { "" } else { "," }, values[row]);
            }
            text.push('\n');
        }
        text
    }
}

/// The model file that a diagnosis is given.
fn nominal_model(mass: f64, friction: f64) -> String {
    format!(
        r#"name = "slider"
states = ["x", "v"]
inputs = ["u"]

[parameters]
m = {{ value = {mass}, min = 0, unit = "kg", about = "mass" }}
Fc = {{ value = {friction}, min = 0, unit = "N", about = "Coulomb friction" }}

[dynamics]
x = "v"
v = "(u - Fc*sign(v))/m"
"#
    )
}

/// A number between `low` and `high`, uniform in its logarithm.
fn between(random: &mut StdRng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.random_range(0.0..1.0))
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}
