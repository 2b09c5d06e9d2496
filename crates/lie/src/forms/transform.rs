//! A model in another form.

use std::time::{Duration, Instant};

use bracketry_symbolic::closest_name;
use bracketry_system::System;

use crate::evidence::Evidence;
use crate::forms::frame::Frame;
use crate::forms::kalman::kalman;
use crate::forms::normal_form::{Form, FormOutcome, NormalForm, TransformError, Transformation};
use crate::forms::obstacle::Stop;

/// Time limit unless another is asked for.
const TIME_LIMIT: Duration = Duration::from_mins(2);

/// Choices of a transformation.
#[derive(Clone, Debug)]
pub struct TransformOptions {
    /// The outputs of the model that the form is about, by name; all where none are given.
    pub outputs: Vec<String>,
    /// Wall-clock time after which the search ends; `None` for no limit.
    pub time_limit: Option<Duration>,
}

impl Default for TransformOptions {
    fn default() -> Self {
        TransformOptions { outputs: Vec::new(), time_limit: Some(TIME_LIMIT) }
    }
}

/// Brings a model into a normal form or decomposition, near a generic point (near the model's point where branches are to be
/// chosen).
///
/// ```
/// use bracketry_lie::transform;
/// use bracketry_lie::forms::{Form, TransformOptions};
/// use bracketry_system::System;
/// let text = "states = ['q', 'w']\ninputs = ['u']\ndynamics = { q = 'w', w = 'u - sin(q)' }";
/// let pendulum = System::parse("pendulum", text).unwrap();
/// let result = transform(&pendulum, Form::Brunovsky, &TransformOptions::default()).unwrap();
/// let form = result.found().unwrap();
/// assert_eq!(form.feedback.get("u").unwrap().text(), "v1 + sin(q)");
/// assert_eq!(form.system.to_toml().unwrap().matches("v1").count(), 2);
/// ```
///
/// # Errors
/// [`TransformError`] for an output that the model does not have, and for a model that cannot be analyzed.
pub fn transform(system: &System, form: Form, options: &TransformOptions) -> Result<Transformation, TransformError> {
    let start = Instant::now();
    let outputs = chosen(system, &options.outputs)?;
    let deadline = options.time_limit.and_then(|limit| start.checked_add(limit));
    let mut given = system.clone();
    given.pool.set_deadline(deadline.into_iter().chain(system.pool.deadline()).min());
    given.check_denominators()?;
    let mut certificate = Evidence::default();
    let found = match form {
        Form::Kalman => kalman(&given, outputs)?.map(|(form, frame)| {
            certificate = frame.evidence;
            form
        }),
        _ => Frame::new(given, outputs)?.and_then(|mut frame| {
            let found = frame.form(form);
            certificate = frame.evidence;
            found
        }),
    };
    let outcome = match found {
        Ok(mut found) => {
            let parts = found.parts.iter_mut().map(|p| &mut p.system);
            for made in parts.chain([&mut found.system]) {
                made.pool.set_deadline(system.pool.deadline());
            }
            FormOutcome::Found(Box::new(found))
        }
        Err(Stop::No(why)) => FormOutcome::Impossible(why),
        Err(Stop::Unknown(why)) => FormOutcome::NotFound(why),
    };
    let seconds = start.elapsed().as_secs_f64();
    Ok(Transformation { model: system.name.clone(), form, outcome, certificate, seconds })
}

impl Frame {
    fn form(&mut self, form: Form) -> Result<NormalForm, Stop> {
        match form {
            Form::Brunovsky => self.brunovsky(),
            Form::ByrnesIsidori => self.byrnes_isidori(),
            Form::Accessible => self.accessible(),
            Form::Observable => self.observable(),
            Form::Observer => self.observer(),
            Form::Flat => self.flat(),
            Form::Chained => self.chained(),
            // Made before, of the linear approximation.
            Form::Kalman => Err(Stop::Unknown(crate::forms::obstacle::Obstacle::Irrational)),
        }
    }
}

/// The numbers of the outputs with these names.
fn chosen(system: &System, names: &[String]) -> Result<Vec<usize>, TransformError> {
    if names.is_empty() {
        return Ok((0..system.outputs.len()).collect());
    }
    let known: Vec<&str> = system.outputs.iter().map(|o| o.0.as_str()).collect();
    let mut list = Vec::new();
    for name in names {
        let Some(k) = known.iter().position(|k| k == name) else {
            let remedy = match (closest_name(name, known.iter().copied()), known.is_empty()) {
                (_, true) => "add a table [outputs]".to_owned(),
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, _) => format!("it has {}", known.join(", ")),
            };
            return Err(TransformError::UnknownOutput { name: name.clone(), remedy });
        };
        if list.contains(&k) {
            return Err(TransformError::Twice { name: name.clone() });
        }
        list.push(k);
    }
    Ok(list)
}
