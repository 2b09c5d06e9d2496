//! Effects in signal paths: delays, lags, filters, offsets, drifts, and a tracked point off the center of mass.

use bracketry_numerics::statistics::{median, rms, steps};
use bracketry_symbolic::{Fence, Joint, Notation, Relation};

use super::builder::{Builder, amplitude, dissipation, log_grid};
use super::structure::{Coordinate, Kind};
use crate::effect::{Cause, Change, Coefficient, Effect, Path};
use crate::formula::Formula;
use crate::record::Record;
use crate::signal::Quantity;

/// A measured column and the states that it shows.
struct Sensor {
    name: String,
    states: Vec<usize>,
    noise: f64,
    size: f64,
}

impl Builder {
    /// Effects on inputs and measured columns.
    pub(crate) fn add_paths(&mut self, records: &[Record]) {
        let interval = interval(records);
        let inputs = self.system.input_names();
        let groups: Vec<Vec<String>> = match inputs.len() {
            0 => Vec::new(),
            1 => vec![inputs.clone()],
            _ => std::iter::once(inputs.clone()).chain(inputs.iter().map(|u| vec![u.clone()])).collect(),
        };
        for group in groups {
            let on = if group.len() == 1 { group[0].clone() } else { "inputs".to_owned() };
            self.time(Cause::InputDelay, Path::InputDelay, "delay", &on, group.clone(), interval);
            self.time(Cause::ActuatorLag, Path::ActuatorLag, "lag", &on, group, interval);
        }
        let sensors = self.sensors(records);
        let all: Vec<String> = sensors.iter().map(|s| s.name.clone()).collect();
        if sensors.len() > 1 {
            self.time(Cause::SensorDelay, Path::SensorDelay, "sensor_delay", "all", all.clone(), interval);
        }
        for name in all {
            self.time(Cause::SensorDelay, Path::SensorDelay, "sensor_delay", &name, vec![name.clone()], interval);
            // A filter of all columns alike is a lag of the inputs, but for friction.
            for path in [Path::SensorLag, Path::DigitalFilter] {
                self.time(Cause::SensorLag, path, "sensor_lag", &name, vec![name.clone()], interval);
            }
        }
        self.com_offset(records);
        for i in 0..sensors.len() {
            if self.absorbed(&sensors, i) {
                continue;
            }
            let s = &sensors[i];
            let (name, scale) = (s.name.clone(), (0.1 * s.size).max(s.noise));
            let k = self.name("offset", &identifier(&name));
            let about = format!("offset of {name}: reading minus true value");
            let scale = if scale > 0.0 { scale } else { 1.0 };
            let unit = self.system.quantities.unit(&name).unwrap_or_default();
            let c = Coefficient { scale, ..amplitude(k.clone(), unit, about) };
            let shown = Notation::Sum(symbols(&[name.clone(), k.clone()]));
            let term = Formula::new(format!("{name} + {k}"), shown);
            self.path(Cause::SensorBias, Path::SensorBias, vec![name], term, c);
        }
        for s in sensors {
            self.drift(s, records);
        }
    }

    /// A column grows with time beyond what it measures.
    fn drift(&mut self, sensor: Sensor, records: &[Record]) {
        let Sensor { name, noise, size, .. } = sensor;
        let durations = records.iter().filter_map(|r| Some(r.times.last()? - r.times.first()?));
        let duration = durations.fold(0.0, f64::max);
        let scale = (0.1 * size).max(noise) / duration;
        if !(scale > 0.0 && scale.is_finite()) {
            return;
        }
        let k = self.name("drift", &identifier(&name));
        let about =
            format!("drift of {name}: change of reading minus true value, per unit of time from the start of a run");
        let unit = self.system.quantities.unit_of_derivative(&name, 1).unwrap_or_default();
        let c = Coefficient { scale, ..amplitude(k.clone(), unit, about) };
        let growing = Notation::Product(symbols(&[k.clone(), "t".to_owned()]));
        let shown = Notation::Sum(vec![Notation::symbol(&name), growing]);
        let term = Formula::new(format!("{name} + {k}*t"), shown);
        self.path(Cause::SensorDrift, Path::SensorDrift, vec![name], term, c);
    }

    /// The tracked point of a body in the plane lies off its center of mass, if both coordinates are measured.
    fn com_offset(&mut self, records: &[Record]) {
        let coordinate = |c: &Coordinate| c.position.map(|q| (q, c.rate));
        let translations: Vec<(usize, usize)> = self.structure.translations().filter_map(coordinate).collect();
        let angles = self.structure.coordinates.iter().filter(|c| c.kind == Kind::Angle);
        let turns: Vec<(usize, usize)> = angles.filter_map(coordinate).collect();
        let ([(x, vx), (y, vy)], [(phi, w)]) = (&translations[..], &turns[..]) else { return };
        let shown =
            |state: &usize| records.iter().all(|r| r.measured.iter().any(|m| m.quantity == Quantity::State(*state)));
        if !(shown(x) && shown(y)) {
            return;
        }
        let [x, y, vx, vy, phi, w] = [*x, *y, *vx, *vy, *phi, *w].map(|i| self.state(i));
        let coefficients = [("along", "first"), ("across", "second")].map(|(name, axis)| {
            let about =
                format!("position of the tracked point off the center of mass, along the {axis} axis of the body");
            Coefficient { scale: self.settings.small_offset, ..amplitude(self.name("com", name), "m", about) }
        });
        let offset = coefficients.each_ref().map(|c| c.name.clone());
        let vector = |names: &[String]| Notation::List(Joint::Comma, symbols(names)).fenced(Fence::Parentheses);
        let position = [x.clone(), y.clone()];
        let turned = [Notation::Letters("R".to_owned()), vector(std::slice::from_ref(&phi)), vector(&offset)];
        let shown = Notation::Sum(vec![vector(&position), Notation::Row(turned.to_vec())]);
        self.effects.push(Effect {
            cause: Cause::ComOffset,
            equation: format!("{x}, {y}"),
            term: Formula::new(format!("({x}, {y}) + R({phi})*({}, {})", offset[0], offset[1]), shown),
            coefficients: coefficients.to_vec(),
            change: Change::TrackedPoint { position: [x, y], velocity: [vx, vy], angle: phi, spin: w },
        });
    }

    fn time(&mut self, cause: Cause, path: Path, base: &str, on: &str, signals: Vec<String>, interval: f64) {
        let k = self.name(base, &identifier(on));
        let what = match path {
            Path::ActuatorLag => "follows its command with this time constant",
            Path::InputDelay => "acts this much later than logged",
            Path::SensorLag => "is shown by a filter with this time constant",
            Path::DigitalFilter => "is shown by a digital filter with this time constant",
            Path::SensorDelay | Path::SensorBias | Path::SensorDrift => "is logged this much later than it happens",
        };
        let shown = signals.join(", ");
        let term = match path {
            Path::ActuatorLag => Formula::new(format!("{shown}: {k}*der(y) = u - y"), lagged(&signals, &k, "u")),
            Path::DigitalFilter => {
                let how = "from sample to sample";
                let law = Notation::Row(vec![lagged(&signals, &k, "x"), Notation::text(format!(", {how}"))]);
                Formula::new(format!("{shown}: {k}*der(y) = x - y, {how}"), law)
            }
            Path::SensorLag => Formula::new(format!("{shown}: {k}*der(y) = x - y"), lagged(&signals, &k, "x")),
            Path::InputDelay | Path::SensorDelay | Path::SensorBias | Path::SensorDrift => {
                Formula::new(format!("{shown}(t - {k})"), delayed(&signals, &k))
            }
        };
        let longest = self.settings.longest_delay;
        // Trials of filters need no simulation, and their secants hold less far.
        let dense = matches!(path, Path::SensorLag | Path::DigitalFilter);
        let trials = self.settings.time_trials * if dense { 2 } else { 1 };
        let c = Coefficient {
            min: 0.0,
            max: 10.0 * longest.max(interval),
            scale: interval,
            trials: log_grid(0.5 * interval, longest.max(20.0 * interval), trials),
            ..dissipation(k, self.system.quantities.time_unit.name(), format!("{shown} {what}"))
        };
        self.path(cause, path, signals, term, c);
    }

    /// Measured columns, each name once.
    fn sensors(&self, records: &[Record]) -> Vec<Sensor> {
        let mut sensors: Vec<Sensor> = Vec::new();
        for m in records.iter().flat_map(|r| &r.measured) {
            if sensors.iter().any(|s| s.name == m.name) {
                continue;
            }
            let states = match m.quantity {
                Quantity::State(i) => vec![i],
                Quantity::Output(o) => {
                    let used = self.system.outputs.get(o).map(|o| self.system.pool.symbols_of(&[o.1]));
                    let used = used.unwrap_or_default();
                    (0..self.system.states.len()).filter(|&i| used.contains(&self.system.states[i])).collect()
                }
            };
            let size = rms(m.values.iter().copied());
            sensors.push(Sensor { name: m.name.clone(), states, noise: m.noise, size });
        }
        sensors
    }

    /// Whether an offset of a column is the same as another initial state: it shows one state only, which no equation and
    /// no other column contains.
    fn absorbed(&self, sensors: &[Sensor], i: usize) -> bool {
        let [state] = sensors[i].states[..] else { return false };
        let elsewhere = sensors.iter().enumerate().any(|(j, s)| j != i && s.states.contains(&state));
        !elsewhere && !self.system.pool.symbols_of(&self.system.dynamics).contains(&self.system.states[state])
    }
}

/// The median sampling interval, s.
pub(super) fn interval(records: &[Record]) -> f64 {
    median(records.iter().flat_map(|r| steps(&r.times)).collect()).filter(|s| *s > 0.0).unwrap_or(1e-3)
}

fn symbols(names: &[String]) -> Vec<Notation> {
    names.iter().map(Notation::symbol).collect()
}

/// u(t − τ) of each signal.
fn delayed(signals: &[String], tau: &str) -> Notation {
    let time = Notation::Sum(vec![Notation::symbol("t"), Notation::Negative(Box::new(Notation::symbol(tau)))]);
    let at = |u: Notation| Notation::Row(vec![u, time.clone().fenced(Fence::Parentheses)]);
    Notation::List(Joint::Comma, symbols(signals).into_iter().map(at).collect())
}

/// τ y' = u − y for each signal, with a name in place of u.
fn lagged(signals: &[String], tau: &str, of: &str) -> Notation {
    let y = || Notation::symbol("y");
    let rate = Notation::Product(vec![Notation::symbol(tau), y().dotted(1)]);
    let gap = Notation::Sum(vec![Notation::symbol(of), Notation::Negative(Box::new(y()))]);
    let each = Notation::List(Joint::Comma, symbols(signals));
    Notation::Row(vec![each, Notation::Sign(':'), Notation::text(" "), rate.relation(Relation::Equal, gap)])
}

/// A name made of the characters that names may have.
fn identifier(text: &str) -> String {
    text.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}
