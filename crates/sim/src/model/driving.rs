//! What gives the arguments of a model besides time and states their values: its slots.

use super::inputs::{Hold, InputError, Line, Samples};

/// Where the value of a slot comes from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source {
    /// It lasts until it is set.
    Held(f64),
    /// The value of a table of samples.
    Value(usize),
    /// The slope of a table of samples.
    Slope(usize),
}

/// A table of samples.
#[derive(Debug, Clone)]
struct Table {
    /// Later than they were given by the delay, in seconds.
    samples: Samples,
    delay: f64,
    /// Input and order of derivative that they give; no name for a held input that acts later than it is set.
    of: (String, u32),
    /// The current interval, and its line.
    interval: usize,
    line: Line,
    /// What was set last of a held input, until the simulation goes on.
    set: Option<f64>,
}

/// The slots of a model.
#[derive(Debug, Clone, Default)]
pub(super) struct Driving {
    sources: Vec<Source>,
    tables: Vec<Table>,
    /// The slot of each held input.
    held: Vec<Option<usize>>,
    /// The slot of each live number.
    live: Vec<(String, usize)>,
    /// Slots that change within a segment, and their tables.
    moving: Vec<(usize, usize)>,
    /// Whether a time has been entered.
    entered: bool,
}

impl Driving {
    /// Adds a slot.
    pub(super) fn add(&mut self, source: Source) -> usize {
        self.sources.push(source);
        self.sources.len() - 1
    }

    /// Adds a slot with the value of samples of a derivative of an input, given earlier by a delay in seconds.
    pub(super) fn add_samples(&mut self, of: (&str, u32), samples: Samples, delay: f64) -> usize {
        let table = self.tables.len();
        let slot = self.add(Source::Value(table));
        if samples.hold == Hold::Linear {
            self.moving.push((slot, table));
        }
        let of = (of.0.to_owned(), of.1);
        let samples = samples.delayed(delay);
        let line = samples.line(0);
        self.tables.push(Table { samples, delay, of, interval: 0, line, set: None });
        slot
    }

    /// Adds a slot with the slope of the samples added last.
    pub(super) fn add_slope(&mut self) -> usize {
        self.add(Source::Slope(self.tables.len() - 1))
    }

    /// Adds a slot with a held value; with a delay, a table of what was set.
    pub(super) fn add_held(&mut self, delay: f64) -> usize {
        if delay == 0.0 { self.add(Source::Held(0.0)) } else { self.add_samples(("", 0), Samples::ever(0.0), delay) }
    }

    /// The next input is held in a slot, or is not held.
    pub(super) fn push_input(&mut self, slot: Option<usize>) {
        self.held.push(slot);
    }

    pub(super) fn add_live(&mut self, name: &str, value: f64) -> usize {
        let slot = self.add(Source::Held(value));
        self.live.push((name.to_owned(), slot));
        slot
    }

    /// The slot of a live number.
    pub(super) fn live_slot(&self, name: &str) -> Option<usize> {
        self.live.iter().find(|(n, _)| n == name).map(|(_, slot)| *slot)
    }

    /// Slots and values of the live numbers.
    pub(super) fn live_values(&self) -> impl Iterator<Item = (usize, f64)> {
        self.live.iter().filter_map(|&(_, slot)| match self.sources[slot] {
            Source::Held(value) => Some((slot, value)),
            _ => None,
        })
    }

    /// Sets all held inputs: one value per input.
    pub(super) fn set_inputs(&mut self, u: &[f64]) -> Result<(), InputError> {
        if u.len() != self.held.len() {
            return Err(InputError::WrongLength { expected: self.held.len(), found: u.len() });
        }
        for (input, value) in u.iter().enumerate() {
            self.set_input(input, *value);
        }
        Ok(())
    }

    /// Sets what inputs that act later were held at before the start: one value per input.
    pub(super) fn set_past_inputs(&mut self, u: &[f64]) -> Result<(), InputError> {
        if u.len() != self.held.len() {
            return Err(InputError::WrongLength { expected: self.held.len(), found: u.len() });
        }
        for (slot, value) in self.held.iter().zip(u) {
            if let Some(Source::Value(table)) = slot.map(|slot| &self.sources[slot]) {
                let table = &mut self.tables[*table];
                table.samples = Samples::ever(*value);
                table.line = table.samples.line(table.interval);
            }
        }
        Ok(())
    }

    /// Sets an input; false if it is not held.
    pub(super) fn set_input(&mut self, input: usize, value: f64) -> bool {
        self.set(self.held[input], value)
    }

    /// Sets a live number; false if there is none of that name.
    pub(super) fn set_live(&mut self, name: &str, value: f64) -> bool {
        self.set(self.live_slot(name), value)
    }

    fn set(&mut self, slot: Option<usize>, value: f64) -> bool {
        let Some(slot) = slot else { return false };
        match &mut self.sources[slot] {
            Source::Held(held) => *held = value,
            Source::Value(table) | Source::Slope(table) => self.tables[*table].set = Some(value),
        }
        true
    }

    fn table(&self, input: &str, order: u32) -> Option<usize> {
        self.tables.iter().position(|table| table.of.0 == input && table.of.1 == order)
    }

    /// Replaces the samples of a derivative of an input; false if none with the same hold give it.
    pub(super) fn set_samples(&mut self, input: &str, order: u32, samples: Samples) -> bool {
        let Some(table) = self.table(input, order).map(|i| &mut self.tables[i]) else { return false };
        let fits = table.samples.hold == samples.hold;
        if fits {
            table.samples = samples.delayed(table.delay);
            table.line = table.samples.line(table.interval);
        }
        fits
    }

    /// By how much the samples of an input act later than they are given, s; 0 for an input that none give.
    pub(super) fn samples_delay(&self, input: &str) -> f64 {
        let table = self.tables.iter().find(|table| table.of.0 == input);
        table.map_or(0.0, |table| table.delay)
    }

    /// Whether the same samples give the slots of another model.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.tables.iter().map(|table| &table.of).eq(other.tables.iter().map(|table| &table.of))
    }

    /// Makes the segment that starts at `t` the current one; its end.
    pub(super) fn enter(&mut self, t: f64) -> f64 {
        let mut end = f64::INFINITY;
        for table in &mut self.tables {
            if let Some(value) = table.set.take() {
                let from = if self.entered { t + table.delay } else { f64::NEG_INFINITY };
                table.samples.go_on(t, from, value);
            }
            table.interval = table.samples.interval_near(table.interval, t);
            table.line = table.samples.line(table.interval);
            if let Some(next) = table.samples.times.get(table.interval) {
                end = end.min(*next);
            }
        }
        self.entered = true;
        end
    }

    /// Writes all slots at `t`.
    pub(super) fn load(&self, t: f64, slots: &mut [f64]) {
        for (slot, source) in slots.iter_mut().zip(&self.sources) {
            *slot = match *source {
                Source::Held(value) => value,
                Source::Value(table) => self.tables[table].line.at(t),
                Source::Slope(table) => self.tables[table].line.slope(),
            };
        }
    }

    /// Writes the slots that change within a segment.
    pub(super) fn follow(&self, t: f64, slots: &mut [f64]) {
        for &(slot, table) in &self.moving {
            slots[slot] = self.tables[table].line.at(t);
        }
    }

    /// Writes the means over a span of time of the samples of a model that is driven alike.
    pub(super) fn load_means(&self, samples_of: &Self, from: f64, to: f64, slots: &mut [f64]) {
        for (slot, source) in slots.iter_mut().zip(&self.sources) {
            let means = |table: usize| samples_of.tables[table].samples.means(from, to);
            *slot = match *source {
                Source::Held(_) => continue,
                Source::Value(table) => means(table).0,
                Source::Slope(table) => means(table).1,
            };
        }
    }
}
