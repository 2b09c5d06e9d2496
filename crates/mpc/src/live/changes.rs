//! What can be changed while a controller runs.

use super::controller::LiveController;
use crate::error::{MpcError, check_value};
use crate::ocp::{Ocp, derivative_name};
use crate::problem::{Schedule, Scheduled};

/// A change of a controller while it runs, for [`LiveController::change`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change<'a> {
    /// The value of a reference.
    Reference {
        /// One of [`LiveController::references`].
        name: &'a str,
        /// Its value from the next preparation on.
        value: f64,
    },
    /// Values of a reference at the next samples.
    ReferenceAhead {
        /// One of [`LiveController::references`].
        name: &'a str,
        /// One per period from the next sample on; the last one holds.
        values: &'a [f64],
    },
    /// The value of a parameter of the controller's model.
    Parameter {
        /// One of [`LiveController::parameters`].
        name: &'a str,
        /// Its value from the next preparation on.
        value: f64,
    },
    /// The bounds of a state or an input.
    Bounds {
        /// One of [`LiveController::states`] or [`LiveController::inputs`].
        name: &'a str,
        /// Smallest value; negative infinity is none.
        min: f64,
        /// Largest value; infinity is none.
        max: f64,
    },
    /// The value of the target of a state.
    Target {
        /// One of [`LiveController::targets`].
        name: &'a str,
        /// Its value from the next preparation on.
        value: f64,
    },
}

/// A checked change of bounds or of a target, by index.
#[derive(Clone, Copy)]
enum Limit {
    State(usize, f64, f64),
    Input(usize, f64, f64),
    Target(usize, f64),
}

impl Limit {
    fn write(self, ocp: &mut Ocp) {
        match self {
            Self::State(i, min, max) => (ocp.state_bounds[i].min, ocp.state_bounds[i].max) = (min, max),
            Self::Input(j, min, max) => ocp.input_bounds[j] = (min, max),
            Self::Target(index, value) => ocp.targets[index].value = value,
        }
    }
}

impl LiveController {
    /// Makes changes together, from the next preparation on: all of them, or, where one is refused, none.
    ///
    /// A program with other finite bounds than before is laid out anew, which takes longer.
    ///
    /// # Errors
    /// [`MpcError::NoSuchName`]; [`MpcError::Value`] for a number that is not finite, except for a bound that is infinite;
    /// [`MpcError::EmptyBounds`]; [`MpcError::Length`] for a list without a value.
    pub fn change(&mut self, changes: &[Change<'_>]) -> Result<(), MpcError> {
        let mut schedule = self.problem.schedule.clone();
        let (mut limits, mut scheduled) = (Vec::new(), false);
        for change in changes {
            if let Some(limit) = self.limit(change)? {
                limits.push(limit);
            } else {
                self.reschedule(&mut schedule, change)?;
                scheduled = true;
            }
        }
        let (first, points) = self.rows(&schedule);
        let changed = self.controller.change(&mut |ocp| {
            for limit in &limits {
                limit.write(ocp);
            }
            if scheduled {
                schedule.write(ocp, first, points);
            }
        });
        changed.map_err(|e| e.with_names(&self.states(), &self.inputs()))?;
        // A reset starts from these.
        for limit in &limits {
            limit.write(&mut self.problem.ocp);
        }
        self.problem.schedule = schedule;
        Ok(())
    }

    /// [`Change::Reference`] alone.
    ///
    /// # Errors
    /// As [`LiveController::change`].
    pub fn set_reference(&mut self, name: &str, value: f64) -> Result<(), MpcError> {
        self.change(&[Change::Reference { name, value }])
    }

    /// [`Change::ReferenceAhead`] alone.
    ///
    /// # Errors
    /// As [`LiveController::change`].
    pub fn set_reference_ahead(&mut self, name: &str, values: &[f64]) -> Result<(), MpcError> {
        self.change(&[Change::ReferenceAhead { name, values }])
    }

    /// Gives parameters of the controller's model values, together. Each has to be one of
    /// [`parameters`](LiveController::parameters): named in `live_parameters` of the problem file, or an expression of time there.
    ///
    /// # Errors
    /// As [`LiveController::change`].
    pub fn set_parameters(&mut self, values: &[(&str, f64)]) -> Result<(), MpcError> {
        let changes: Vec<Change<'_>> = values.iter().map(|&(name, value)| Change::Parameter { name, value }).collect();
        self.change(&changes)
    }

    /// [`Change::Bounds`] alone.
    ///
    /// # Errors
    /// As [`LiveController::change`].
    pub fn set_bounds(&mut self, name: &str, min: f64, max: f64) -> Result<(), MpcError> {
        self.change(&[Change::Bounds { name, min, max }])
    }

    /// [`Change::Target`] alone.
    ///
    /// # Errors
    /// As [`LiveController::change`].
    pub fn set_target(&mut self, name: &str, value: f64) -> Result<(), MpcError> {
        self.change(&[Change::Target { name, value }])
    }

    /// The change of a bound or a target; none for what is scheduled.
    fn limit(&self, change: &Change<'_>) -> Result<Option<Limit>, MpcError> {
        Ok(match *change {
            Change::Bounds { name, min, max } => Some(self.bounds(name, min, max)?),
            Change::Target { name, value } => {
                finite("the target", name, value)?;
                let known = self.targets();
                match known.iter().position(|n| n == name) {
                    Some(index) => Some(Limit::Target(index, value)),
                    None => return Err(MpcError::NoSuchName { what: "target", name: name.to_owned(), known }),
                }
            }
            Change::Reference { .. } | Change::ReferenceAhead { .. } | Change::Parameter { .. } => None,
        })
    }

    fn bounds(&self, name: &str, min: f64, max: f64) -> Result<Limit, MpcError> {
        for (end, none) in [(min, f64::NEG_INFINITY), (max, f64::INFINITY)] {
            let usable = end.is_finite() || end == none;
            check_value(usable, format!("a bound of `{name}`"), end, "give a finite number, or infinity for none")?;
        }
        let system = &self.problem.system;
        if let Some(i) = system.state_index(name) {
            return Ok(Limit::State(i, min, max));
        }
        let Some(j) = system.input_index(name) else {
            let known = system.state_names().into_iter().chain(system.input_names()).collect();
            return Err(MpcError::NoSuchName { what: "state or input", name: name.to_owned(), known });
        };
        if let Some((lower, upper)) = system.range_of_input(j) {
            let remedy = "the input has a range in the model: keep the bounds within it";
            check_value(max >= lower, format!("the upper bound of `{name}`"), max, remedy)?;
            check_value(min <= upper, format!("the lower bound of `{name}`"), min, remedy)?;
        }
        if let Some(&rest) = self.problem.rest_input.get(j) {
            let what = format!("the rest input of `{name}`");
            check_value(min > max || (min <= rest && rest <= max), what, rest, "leave it within the new bounds")?;
        }
        Ok(Limit::Input(j, min, max))
    }

    /// Puts a reference and its derivatives, which `new` makes by their order, in the place of those there are.
    fn replace_reference(
        &self,
        list: &mut [Scheduled],
        name: &str,
        new: impl Fn(u32) -> Scheduled,
    ) -> Result<(), MpcError> {
        let known = self.references();
        if !known.iter().any(|r| r == name) {
            return Err(MpcError::NoSuchName { what: "reference", name: name.to_owned(), known });
        }
        for scheduled in list {
            let order = if scheduled.name == name { Some(0) } else { scheduled.order_of(name) };
            if let Some(order) = order {
                *scheduled = new(order).derivative_of(name, order);
            }
        }
        Ok(())
    }

    /// Puts what a change says of references and parameters into the schedule.
    fn reschedule(&self, schedule: &mut Schedule, change: &Change<'_>) -> Result<(), MpcError> {
        match *change {
            Change::Reference { name, value } => {
                finite("the reference", name, value)?;
                self.replace_reference(&mut schedule.references, name, |order| {
                    Scheduled::constant(derivative_name(name, order), if order == 0 { value } else { 0.0 })
                })
            }
            Change::Parameter { name, value } => {
                finite("the parameter", name, value)?;
                replace(&mut schedule.parameters, Scheduled::constant(name, value), "live parameter")
            }
            Change::ReferenceAhead { name, values } => {
                let Some(last) = values.len().checked_sub(1) else {
                    return Err(MpcError::Length { what: "the list of values", found: 0, expected: 1 });
                };
                for &value in values {
                    finite("the reference", name, value)?;
                }
                let (first, dt) = (self.next() as f64, self.period());
                self.replace_reference(&mut schedule.references, name, |order| {
                    let mut values = values.to_vec();
                    // The derivative over the period that follows; the last value holds.
                    for _ in 0..order {
                        values = values.windows(2).map(|w| (w[1] - w[0]) / dt).chain([0.0]).collect();
                    }
                    let at = move |t: f64| values[((t / dt).round() - first).clamp(0.0, last as f64) as usize];
                    Scheduled::new(derivative_name(name, order), at)
                })
            }
            Change::Bounds { .. } | Change::Target { .. } => Ok(()),
        }
    }
}

fn finite(what: &str, name: &str, value: f64) -> Result<(), MpcError> {
    check_value(value.is_finite(), format!("{what} `{name}`"), value, "give a finite number")
}

/// Puts a scheduled quantity in the place of the one with its name.
fn replace(list: &mut [Scheduled], new: Scheduled, what: &'static str) -> Result<(), MpcError> {
    match list.iter().position(|s| s.name == new.name) {
        Some(i) => {
            list[i] = new;
            Ok(())
        }
        None => {
            Err(MpcError::NoSuchName { what, name: new.name, known: list.iter().map(|s| s.name.clone()).collect() })
        }
    }
}
