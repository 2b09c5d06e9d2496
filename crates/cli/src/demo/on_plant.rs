//! A controller on the plant with contact over the whole footprint.

use bracketry::mpc::problem::ControlRun;
use bracketry::mpc::{ControlProblem, Plant};
use bracketry::plate::area::AreaOutcome;
use bracketry::plate::control::{Arrival, move_with};
use bracketry::plate::recording::PlateMismatch;
use bracketry::system::System;
use serde::{Serialize, Serializer};

use super::loop_conditions::{measured, programs_of};
use super::settings::{StoryError, StorySettings};
use super::shortest::Shortest;

/// The reference move on the plant with contact over the whole footprint, planned and corrected with some model of it, in a time
/// that is little longer than the shortest. The controller sees what a camera measures, one sample late.
#[derive(Clone, Serialize)]
pub struct MoveOnPlant {
    /// The controller's model, in a few words.
    pub model: String,
    /// Shortest duration (s) in which a plan of this model arrives, and that of the move; the first is absent if none was found.
    pub shortest_s: Option<f64>,
    /// Duration of the move (s): the shortest and a reserve for feedback.
    pub duration_s: f64,
    /// Quadratic programs of the plan, the loop, and the search for the shortest move unless that was made before.
    pub programs: usize,
    /// What was to be done.
    #[serde(skip)]
    pub problem: ControlProblem,
    /// The closed loop, sample by sample.
    #[serde(skip)]
    pub run: ControlRun,
    /// States x, y, phi, vx, vy, w, X, Xd, theta, thetad at every millisecond, in closed loop.
    #[serde(skip)]
    pub closed_loop: Vec<[f64; 10]>,
    /// The same under the inputs of the plan, played without looking.
    #[serde(skip)]
    pub plan_alone: Vec<[f64; 10]>,
    /// How contact ended before the end of the closed loop, if it did; the states end there.
    #[serde(serialize_with = "in_words")]
    pub stopped: Option<AreaOutcome>,
    /// The same in open loop.
    #[serde(serialize_with = "in_words")]
    pub plan_stopped: Option<AreaOutcome>,
    /// What the closed loop achieved.
    pub arrival: Arrival,
    /// What the plan achieved in open loop.
    pub plan_arrival: Arrival,
}

impl MoveOnPlant {
    /// Plans the move with `model`, plays the plan without looking, and closes the loop. The estimator corrects the parameters that
    /// are named in `adjusted`.
    ///
    /// # Errors
    /// [`StoryError`] if the model cannot be controlled. An object that tips or lifts off is a result.
    pub fn run(name: &str, model: &System, adjusted: &[String], settings: &StorySettings) -> Result<Self, StoryError> {
        let problem = move_with(model)?;
        let shortest = Shortest::of(&problem)?;
        let moved = Self::within(name, problem, &shortest, adjusted, settings)?;
        Ok(Self { programs: shortest.programs + moved.programs, ..moved })
    }

    /// The move of a problem in a time that is little longer than the shortest, which was searched before.
    pub(super) fn within(
        name: &str,
        mut problem: ControlProblem,
        shortest: &Shortest,
        adjusted: &[String],
        settings: &StorySettings,
    ) -> Result<Self, StoryError> {
        shortest.set(&mut problem);
        let duration_s = problem.ocp.steps as f64 * problem.ocp.dt;
        measured(&mut problem, adjusted, &settings.plant, settings.seed)?;
        problem.samples += settings.rest_samples;
        let plant = || PlateMismatch::None.loop_plant(&settings.plant);
        let mut looped = plant()?;
        let run = problem.run(&mut looped)?;
        let stopped = looped.stopped().copied();
        let closed_loop = looped.states().to_vec();
        let mut played = plant()?;
        let mut x = problem.x0.clone();
        for k in 0..problem.samples {
            let plan = run.plan.as_ref().filter(|p| k < p.trajectory.steps());
            let u = plan.map_or([0.0; 2].as_slice(), |p| p.trajectory.u(k));
            let t = k as f64 * problem.ocp.dt;
            played
                .step(t, &mut x, u, problem.ocp.dt)
                .map_err(|source| bracketry::mpc::MpcError::Plant { time: t, source })?;
        }
        let plan_stopped = played.stopped().copied();
        let plan_alone = played.states().to_vec();
        let measured = |states: &[[f64; 10]]| {
            let end = states.last().map_or(problem.x0.as_slice(), |x| x.as_slice());
            Arrival::of_states(&problem, states, end)
        };
        let programs = programs_of(&run);
        let (arrival, plan_arrival) = (measured(&closed_loop), measured(&plan_alone));
        Ok(Self {
            model: name.to_owned(),
            shortest_s: shortest.seconds(),
            programs,
            duration_s,
            problem,
            run,
            closed_loop,
            plan_alone,
            stopped,
            plan_stopped,
            arrival,
            plan_arrival,
        })
    }

    /// Whether the object came to rest within 2 mm and 2° of its target, and stayed.
    pub fn reached(&self) -> bool {
        self.stopped.is_none() && self.arrival.settled_s.is_some()
    }
}

// The signature is serde's.
#[allow(clippy::ref_option)]
fn in_words<S: Serializer>(outcome: &Option<AreaOutcome>, serializer: S) -> Result<S::Ok, S::Error> {
    outcome.as_ref().map(ToString::to_string).serialize(serializer)
}
