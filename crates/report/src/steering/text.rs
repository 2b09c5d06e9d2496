//! The text of a motion from one state to another.

use bracketry_lie::forms::NoChainedForm;
use bracketry_sim::Hold;
use bracketry_steer::{Plan, SteerMethod, SteerNote, SteerReason, SteerStatus, Steering};
use bracketry_system::readable;

/// A method with its source.
pub(super) fn method(method: SteerMethod) -> &'static str {
    match method {
        SteerMethod::Chained => {
            "sinusoids in the chained form (Murray and Sastry 1993; Tilbury, Murray, and Sastry 1995)"
        }
        SteerMethod::Nilpotent => {
            "piecewise constant inputs from Philip Hall coordinates (Lafferriere and Sussmann 1991)"
        }
        SteerMethod::Flat => "polynomials in flat outputs (Fliess, Lévine, Martin, and Rouchon 1995)",
        SteerMethod::Loops => "loops of the inputs from rest to rest",
        SteerMethod::Shooting => "shooting: sinusoids found by Levenberg–Marquardt iterations on the end error",
    }
}

/// Why a method did not reach the end.
pub(super) fn reason(reason: &SteerReason) -> String {
    match reason {
        SteerReason::Drift => "the model has drift: it can move while all inputs are zero".to_owned(),
        SteerReason::NotAffine => "the equations are not affine in the inputs; try `bracketry affinize`".to_owned(),
        SteerReason::Switches => "the equations switch (dry friction, absolute values)".to_owned(),
        SteerReason::Delays => {
            "inputs act with a delay: steer the model without it, and apply the inputs earlier".to_owned()
        }
        SteerReason::NoChainedForm(why) => match why {
            NoChainedForm::Inputs { independent } => {
                format!("the chained form has two independent inputs: the model has {independent}")
            }
            NoChainedForm::Drift => "the model has drift".to_owned(),
            NoChainedForm::DerivedFlag { dimensions } => {
                let list: Vec<String> = dimensions.iter().map(ToString::to_string).collect();
                format!("there is no chained form: the derived flag has dimensions {}, not 2, 3, …, n", list.join(", "))
            }
            NoChainedForm::NotFound => "a chained form exists, but none was found in closed form".to_owned(),
        },
        SteerReason::Singular => {
            "no path between the states was found along which the coordinates stay regular; try intermediate states"
                .to_owned()
        }
        SteerReason::Brackets { dimension, states, degree } => {
            format!("the brackets of length up to {degree} span {dimension} of {states} dimensions")
        }
        SteerReason::NoFlatOutputs => {
            "no flat outputs were found; name candidates under [outputs] of the model".to_owned()
        }
        SteerReason::OneSided { input } => {
            format!("{input} would need a sign that its range excludes")
        }
        SteerReason::NotAtRest => {
            "both ends must be at rest: velocities zero, inputs and their derivatives the same".to_owned()
        }
        SteerReason::Held { coordinate } => {
            format!("friction holds {coordinate} for all inputs within their bounds (proven)")
        }
        SteerReason::Bounds(error) => error.to_string(),
        SteerReason::FromRest(why) => why.to_string(),
        SteerReason::TooLong { needed } => {
            format!("the loops take a time of {}, longer than --duration", readable(*needed))
        }
        SteerReason::Ranges => "inputs leave their ranges; a longer --duration may help".to_owned(),
        SteerReason::EndError { error } if error.is_finite() => {
            format!("the best motion ends {} away; use it as a first guess, or try --duration", readable(*error))
        }
        SteerReason::EndError { .. } => "no motion was found that can be simulated to its end".to_owned(),
        SteerReason::Undecided(why) => why.to_string(),
        SteerReason::Stopped => "the time or memory limit was reached".to_owned(),
    }
}

/// A note as a sentence.
pub(super) fn note(n: &SteerNote) -> String {
    match n {
        SteerNote::Longer { asked } => {
            format!(
                "it takes longer than the requested time of {} to keep the inputs within their ranges",
                readable(*asked)
            )
        }
        SteerNote::OutOfRange { input } => format!("{input} leaves its range; a longer --duration may help"),
    }
}

fn state(names: &[String], values: &[f64]) -> String {
    let list: Vec<String> = names.iter().zip(values).map(|(n, v)| format!("{n} = {}", readable(*v))).collect();
    list.join(", ")
}

fn plan_lines(s: &Steering, plan: &Plan) -> Vec<String> {
    let names = s.system.state_names();
    match plan {
        Plan::Chained { coordinates, way_points } => {
            let mut lines = Vec::new();
            for (k, leg) in coordinates.iter().enumerate() {
                let heading = if coordinates.len() > 1 { format!("  leg {}: ", k + 1) } else { "  ".to_owned() };
                let list: Vec<String> = leg.iter().enumerate().map(|(i, z)| format!("z{} = {z}", i + 1)).collect();
                lines.push(format!("{heading}{}", list.join(", ")));
                if let Some(x) = way_points.get(k) {
                    lines.push(format!("  via {}", state(&names, x)));
                }
            }
            lines
        }
        Plan::Nilpotent { degree, is_nilpotent, rounds, pieces } => {
            let exact = if *is_nilpotent {
                "all longer ones vanish, so one round is exact"
            } else {
                "longer ones do not vanish, so each round comes closer"
            };
            vec![format!("  brackets up to length {degree}: {exact}; rounds: {rounds}, constant pieces: {pieces}")]
        }
        Plan::Flat { outputs, integrators, degrees } => {
            let names: Vec<String> = outputs.iter().map(ToString::to_string).collect();
            let degrees: Vec<String> = degrees.iter().map(ToString::to_string).collect();
            vec![format!(
                "  flat outputs: {}; integrators in front of inputs: {integrators}; degrees of the polynomials: {}",
                names.join(", "),
                degrees.join(", ")
            )]
        }
        Plan::Loops { loops, shapes } => vec![format!("  loops: {loops}, of {shapes} shapes")],
        Plan::Shooting { harmonics, starts } => {
            vec![format!("  sinusoids per input: {harmonics}, starts: {starts}")]
        }
    }
}

/// A motion from one state to another, in text.
pub fn steering_text(s: &Steering) -> String {
    let names = s.system.state_names();
    let mut lines = vec![format!("{}: from {}", s.system.name, state(&names, &s.from))];
    lines.push(format!("  to {}", state(&names, &s.to)));
    lines.push(match s.status {
        SteerStatus::Reached => {
            format!(
                "reached: the simulated motion ends within {:.1e} of the target in every state",
                s.end_error.max(1e-16)
            )
        }
        SteerStatus::FirstGuess => {
            format!(
                "first guess only: the simulated motion ends within {} of the target in every state",
                readable(s.end_error)
            )
        }
        SteerStatus::NotFound => "not found".to_owned(),
    });
    if let (Some(plan), Some(signals)) = (&s.plan, &s.signals) {
        lines.push(format!("method: {}", method(plan.method())));
        lines.extend(plan_lines(s, plan));
        if s.corrections > 0 {
            lines.push(format!("  Newton corrections on the simulated motion: {}", s.corrections));
        }
        let hold = match signals.hold {
            Hold::Previous => "constant between rows",
            Hold::Linear => "linear between rows",
        };
        let (rows, time) = (signals.times.len(), s.system.quantities.time_unit);
        lines.push(format!("inputs over {}, {rows} rows, {hold}", time.text(readable(signals.duration()))));
        for (j, input) in s.system.input_names().iter().enumerate() {
            let values = signals.values.iter().map(|row| row[j]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            lines.push(format!("  {input:>10} from {} to {}", readable(low), readable(high)));
        }
    }
    lines.extend(s.notes.iter().map(|n| format!("note: {}", note(n))));
    for attempt in &s.attempts {
        let name = match attempt.method {
            SteerMethod::Chained => "chained form",
            SteerMethod::Nilpotent => "Philip Hall coordinates",
            SteerMethod::Flat => "flat outputs",
            SteerMethod::Loops => "loops",
            SteerMethod::Shooting => "shooting",
        };
        lines.push(format!("unsuccessful: {name}: {}", reason(&attempt.reason)));
    }
    lines.join("\n") + "\n"
}
