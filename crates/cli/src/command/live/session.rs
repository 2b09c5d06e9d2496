//! What a controller answers to the messages of its peer.

use std::collections::BTreeMap;

use bracketry::mpc::closed_loop::{Counts, LateSamples};
use bracketry::mpc::controller::FallbackReason;
use bracketry::mpc::live::{Change, LiveStep, LoopLog};
use bracketry::mpc::{LiveController, MpcError};

use super::outbox::Outbox;
use super::protocol::{
    Answer, Bounds, Measure, Number, Numbers, OverTime, PROTOCOL, Prediction, Refusal, Request, Reset, Set,
};

/// Whether a session goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    Message,
    End,
}

/// What a message did, as far as it concerns when the next measurement is due.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Happened {
    #[default]
    Nothing,
    Answered,
    StartedAgain,
}

/// A controller and the outcomes of its samples.
pub(super) struct Session {
    controller: LiveController,
    counts: Counts,
    late: LateSamples,
    measured: Vec<String>,
    /// Since the last preparation.
    happened: Happened,
}

impl Session {
    pub(super) fn new(controller: LiveController) -> Self {
        Self {
            measured: controller.measured(),
            controller,
            counts: Counts::default(),
            late: LateSamples::default(),
            happened: Happened::Nothing,
        }
    }

    pub(super) fn hello(&self) -> Answer<'static> {
        let c = &self.controller;
        Answer::Hello {
            protocol: PROTOCOL,
            version: env!("CARGO_PKG_VERSION"),
            period: c.period(),
            steps: c.problem().ocp.steps,
            compensated_delay: c.compensated_delay(),
            measured: c.measured(),
            states: c.states(),
            inputs: c.inputs(),
            references: c.references(),
            parameters: c.parameters(),
            targets: c.targets(),
        }
    }

    /// What can be done before the next message; what the last one did.
    pub(super) fn prepare(&mut self) -> Result<Happened, MpcError> {
        self.controller.prepare()?;
        Ok(std::mem::take(&mut self.happened))
    }

    /// Answers a line, or tells why it could not be read.
    pub(super) fn handle(&mut self, line: Result<&str, &'static str>, outbox: &Outbox) -> Next {
        let request = line.map_err(|why| ("json", why.to_owned())).and_then(Request::read);
        let done = match request {
            Ok(Request::End) => return Next::End,
            Ok(Request::Measure(measure)) => match self.measure(&measure) {
                Ok(()) => {
                    self.answer(measure.predict, outbox);
                    return Next::Message;
                }
                Err(refusal) => Err(refusal),
            },
            Ok(Request::Predict) => {
                outbox.put(&Answer::Prediction(self.prediction()));
                return Next::Message;
            }
            Ok(Request::Heartbeat) => {
                self.heartbeat(outbox);
                return Next::Message;
            }
            Ok(Request::Hello(hello)) if hello.protocol != PROTOCOL => {
                Err(("protocol", format!("this is version {PROTOCOL} of the protocol, not {}", hello.protocol)))
            }
            Ok(Request::Hello(_)) => Ok(()),
            Ok(Request::Set(set)) => self.set(&set),
            Ok(Request::Reset(reset)) => self.reset(&reset),
            Err(refusal) => Err(refusal),
        };
        match done {
            Ok(()) => outbox.put(&Answer::Done),
            Err((code, message)) => outbox.put(&Answer::Error { code, message }),
        }
        Next::Message
    }

    /// A sample. One that is refused leaves the controller as it was, and may be sent again.
    fn measure(&mut self, measure: &Measure) -> Result<(), Refusal> {
        let y = in_order(&measure.y, &self.measured, "measured quantity")?;
        match measure.t {
            Some(t) => self.controller.step_at(&y, t.value()),
            None => self.controller.step(&y),
        }
        .map_err(|e| refusal(&e))?;
        self.happened = Happened::Answered;
        Ok(())
    }

    /// Sends the input of a sample whose measurement is late.
    pub(super) fn lost(&mut self, outbox: &Outbox) -> Result<(), MpcError> {
        self.controller.lost()?;
        self.answer(false, outbox);
        self.controller.prepare()
    }

    /// Sends the input that has just been decided.
    fn answer(&mut self, predict: bool, outbox: &Outbox) {
        let prediction = predict.then(|| self.prediction());
        let LiveStep { sample, missed, step, .. } = self.controller.last();
        self.counts.add(step);
        self.late.add(step.timings.total(), self.controller.period_seconds());
        outbox.put(&Answer::Input {
            sample: *sample,
            t: *sample as f64 * self.controller.period(),
            u: &step.u,
            status: step.status.name(),
            reason: step.status.fallback_reason().map(FallbackReason::name),
            source: step.source.name(),
            missed: *missed,
            x: self.controller.estimate().map(|e| e.x.as_slice()),
            feedback_ms: 1e3 * step.timings.feedback(),
            prepare_ms: 1e3 * step.timings.linearize,
            prediction,
        });
    }

    pub(super) fn heartbeat(&self, outbox: &Outbox) {
        outbox.put(&Answer::Heartbeat { sample: self.counts.samples() });
    }

    /// Sends the last message. A peer that is lost gets the input of the policy with it, for whoever reads its pipe.
    pub(super) fn end(&mut self, reason: &'static str, outbox: &Outbox) -> Result<(), MpcError> {
        let last = if reason == "end" { self.controller.last() } else { self.controller.lost()? };
        let (samples, status, late) = (self.counts.samples(), self.counts, self.late);
        outbox.put(&Answer::End { reason, samples, u: &last.step.u, status, late });
        Ok(())
    }

    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    /// Samples that took longer than the sampling period.
    pub(super) fn late(&self) -> LateSamples {
        self.late
    }

    /// The samples, if the controller keeps them.
    pub(super) fn log(&self) -> Option<LoopLog> {
        self.controller.log().cloned()
    }

    pub(super) fn period(&self) -> f64 {
        self.controller.period_seconds()
    }

    fn prediction(&self) -> Prediction {
        let (plan, c) = (self.controller.prediction(), &self.controller);
        Prediction {
            t: c.prediction_times(),
            x: (0..=plan.steps()).map(|k| plan.x(k).to_vec()).collect(),
            u: (0..plan.steps()).map(|k| plan.u(k).to_vec()).collect(),
        }
    }

    /// All changes of a message, or none where one is refused.
    fn set(&mut self, set: &Set) -> Result<(), Refusal> {
        let ahead: BTreeMap<&str, Vec<f64>> = set
            .references
            .iter()
            .filter_map(|(name, value)| match value {
                OverTime::Constant(_) => None,
                OverTime::Ahead(values) => Some((name.as_str(), values.iter().map(|v| v.value()).collect())),
            })
            .collect();
        let mut changes: Vec<Change<'_>> =
            ahead.iter().map(|(&name, values)| Change::ReferenceAhead { name, values }).collect();
        for (name, value) in &set.references {
            if let OverTime::Constant(value) = value {
                changes.push(Change::Reference { name, value: value.value() });
            }
        }
        changes.extend(set.parameters.iter().map(|(name, v)| Change::Parameter { name, value: v.value() }));
        changes.extend(set.bounds.iter().map(|(name, Bounds::Both(min, max))| {
            let end = |given: &Option<Number>, none| given.map_or(none, Number::value);
            Change::Bounds { name, min: end(min, f64::NEG_INFINITY), max: end(max, f64::INFINITY) }
        }));
        changes.extend(set.targets.iter().map(|(name, v)| Change::Target { name, value: v.value() }));
        self.controller.change(&changes).map_err(|e| refusal(&e))
    }

    fn reset(&mut self, reset: &Reset) -> Result<(), Refusal> {
        let x0 = reset.x0.as_ref().map(|x0| in_order(x0, &self.controller.states(), "state")).transpose()?;
        match x0 {
            Some(x0) => self.controller.reset_to(&x0),
            None => self.controller.reset(),
        }
        .map_err(|e| refusal(&e))?;
        self.happened = Happened::StartedAgain;
        Ok(())
    }
}

/// The numbers in the order of `names`; what is not given is NaN.
fn in_order(numbers: &Numbers, names: &[String], what: &str) -> Result<Vec<f64>, Refusal> {
    let number = |v: &Option<Number>| v.map_or(f64::NAN, Number::value);
    match numbers {
        Numbers::InOrder(list) if list.len() == names.len() => Ok(list.iter().map(number).collect()),
        Numbers::InOrder(list) => {
            let expected = names.join(", ");
            Err(("length", format!("{} numbers were given, expected {}: {expected}", list.len(), names.len())))
        }
        Numbers::ByName(map) => {
            if let Some(name) = map.keys().find(|k| !names.contains(k)) {
                return Err(("name", format!("there is no {what} `{name}`: the names are {}", names.join(", "))));
            }
            Ok(names.iter().map(|n| map.get(n).map_or(f64::NAN, number)).collect())
        }
    }
}

/// The error as the peer is told it.
fn refusal(error: &MpcError) -> Refusal {
    let code = match error {
        MpcError::Length { .. } => "length",
        MpcError::Time { .. } => "time",
        MpcError::NoSuchName { .. } => "name",
        MpcError::Value { .. } | MpcError::EmptyBounds { .. } => "value",
        _ => "controller",
    };
    (code, error.to_string())
}
