//! What a problem file leaves free.

use super::free::{Free, FreeRange};
use super::reader::{Located, Parsed, Reader};
use crate::ocp::Ocp;
use bracketry_symbolic::{Expr, Pool};
use bracketry_system::{Table, Value};

/// Factor between the guess of an end time and the ends of its range where none are given.
const RANGE: f64 = 100.0;

impl Reader<'_> {
    /// What the file leaves free.
    pub(super) fn free(&self, table: &Table<'_>, horizon: &Table<'_>) -> Parsed<Free> {
        let mut free = Free::default();
        if let Some(v) = horizon.get("end_time")
            && let Value::Table(t) = v.get_ref()
        {
            let remedy = "write end_time = { free = true, min = 0.5, max = 5, guess = 2 }, or end_time = 2";
            let guess = self.free_guess(v, t, "end_time", remedy)?;
            if guess <= 0.0 {
                return Err(self.doc.error(v.span(), "the guess of `end_time` must be positive", remedy).into());
            }
            let range = self.free_range(v, t, "end_time", guess, (guess / RANGE, guess * RANGE))?;
            if range.min <= 0.0 {
                return Err(self.doc.error(v.span(), "`min` of `end_time` must be positive", remedy).into());
            }
            free.end_time = Some(range);
        }
        for (key, v) in self.doc.sub_table(table, "parameters")?.into_iter().flatten() {
            let name: &str = key.get_ref();
            let Value::Table(t) = v.get_ref() else { continue };
            if !t.contains_key("free") {
                continue;
            }
            let known: Vec<String> =
                self.system.parameters.iter().map(|p| self.system.symbol_name(p.symbol).to_owned()).collect();
            if !known.iter().any(|k| k == name) {
                return Err(self.unknown(name, key.span(), "parameter", &known));
            }
            let remedy = format!("write {name} = {{ free = true, min = 0, max = 1, guess = 0.5 }}");
            let guess = self.free_guess(v, t, name, &remedy)?;
            let range = self.free_range(v, t, name, guess, (f64::NEG_INFINITY, f64::INFINITY))?;
            free.parameters.push((name.to_owned(), range));
        }
        let run = self.doc.sub_table(table, "run")?;
        for (key, v) in run.map(|run| self.doc.sub_table(run, "x0")).transpose()?.flatten().into_iter().flatten() {
            let name: &str = key.get_ref();
            let Value::Table(t) = v.get_ref() else { continue };
            let state = self.state(name, key.span())?;
            let remedy =
                format!("write x0 = {{ {name} = {{ free = true, min = -1, max = 1, guess = 0 }} }}, or a number");
            let guess = self.free_guess(v, t, name, &remedy)?;
            let range = self.free_range(v, t, name, guess, (f64::NEG_INFINITY, f64::INFINITY))?;
            free.starts.push((state, range));
        }
        Ok(free)
    }

    fn free_guess(&self, v: Located<'_, '_>, t: &Table<'_>, name: &str, remedy: &str) -> Parsed<f64> {
        self.doc.only_keys(t, &["free", "min", "max", "guess"], &format!("`{name}`"))?;
        if !self.boolean(t, "free", false)? {
            let message = format!("`{name}` is not free, but has a range");
            return Err(self.doc.error(v.span(), message, format!("{remedy}; a number fixes it")).into());
        }
        if !t.contains_key("guess") {
            return Err(self.doc.error(v.span(), format!("`{name}` has no `guess`"), remedy).into());
        }
        Ok(self.number(t, "guess", None)?.0)
    }

    fn free_range(
        &self,
        v: Located<'_, '_>,
        t: &Table<'_>,
        name: &str,
        guess: f64,
        widest: (f64, f64),
    ) -> Parsed<FreeRange> {
        let min = self.number(t, "min", Some(widest.0))?.0;
        let max = self.number(t, "max", Some(widest.1))?.0;
        if !(min < max && min <= guess && guess <= max) {
            let message = format!("the guess {guess} of `{name}` does not lie between {min} and {max}");
            return Err(self.doc.error(v.span(), message, "choose min ≤ guess ≤ max, min < max").into());
        }
        Ok(FreeRange { min, max, guess })
    }

    /// A free initial state keeps the bounds of the state too.
    pub(super) fn starts_within_bounds(&self, run: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        for (state, input) in ocp.free_starts.clone() {
            let (b, (min, max)) = (&ocp.state_bounds[state], ocp.input_bounds[input]);
            let common = (min.max(b.min), max.min(b.max));
            if common.0 >= common.1 {
                let name = self.system.symbol_name(self.system.states[state]);
                let message = format!(
                    "the range {min} to {max} of the initial `{name}` leaves nothing of its bounds {} to {}",
                    b.min, b.max
                );
                let span = run.get("x0").map_or(0..0, toml::Spanned::span);
                return Err(self.doc.error(span, message, "change the range or the bounds, or write a number").into());
            }
            ocp.input_bounds[input] = common;
        }
        Ok(())
    }

    /// Length of an interval: `dt`, or the end time over the number of intervals.
    pub(super) fn interval(&self, horizon: &Table<'_>, steps: usize, end_time: Option<f64>) -> Parsed<f64> {
        let Some(v) = horizon.get("end_time") else { return self.positive(horizon, "dt", None) };
        if horizon.contains_key("dt") {
            let message = "`dt` and `end_time` both define the horizon";
            return Err(self.doc.error(v.span(), message, "remove one of them: dt = end_time/steps").into());
        }
        let end_time = end_time.map_or_else(|| self.positive(horizon, "end_time", None), Ok)?;
        Ok(end_time / steps as f64)
    }

    /// The integrand of a stage cost over τ.
    pub(super) fn over_scaled_time(&self, pool: &mut Pool, stage: Expr) -> Expr {
        match self.remembered.time_scale {
            Some(j) => {
                let scale = pool.var(self.system.symbol_name(self.system.inputs[j]));
                pool.mul(scale, stage)
            }
            None => stage,
        }
    }
}

/// Whether the entry of a parameter leaves it free.
pub(super) fn is_free(v: Located<'_, '_>) -> bool {
    matches!(v.get_ref(), Value::Table(t) if t.contains_key("free"))
}
