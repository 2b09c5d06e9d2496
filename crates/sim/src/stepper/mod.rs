//! The integrator, as it is used.

use crate::Switched;
use crate::events::{Guard, Locator};
use crate::friction::{Filippov, FrictionMode, ZeroSet};
use crate::integrate::{Regime, Step, Stiffness};
use crate::outcome::{Outcome, Statistics};
use crate::sensitivity::Path;
use crate::settings::{SimError, SimulationSettings};
use crate::trajectory::Trajectory;

mod stepping;

/// A re-entrant integrator: keeps time, state, modes and step length from one call to the next.
///
/// ```
/// use bracketry_sim::{Closures, FrictionMode, SimulationSettings, Stepper};
/// let block = Closures {
///     dim: 1,
///     switches: 1,
///     rhs: |t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]| dx[0] = 2.0 * t.sin() - s[0],
///     switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
///     gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
/// };
/// let mut stepper = Stepper::new(block, 0.0, &[0.0], &SimulationSettings::default()).unwrap();
/// assert!(stepper.advance(0.5).is_finished()); // 2 sin 0.5 < 1: it holds
/// assert_eq!((stepper.state(), stepper.modes()), (&[0.0][..], &[FrictionMode::Sticking][..]));
/// assert!(stepper.advance(0.6).is_finished()); // breaks loose at asin(1/2) = 0.5236
/// assert_eq!(stepper.modes(), &[FrictionMode::Positive]);
/// ```
#[derive(Debug, Clone)]
pub struct Stepper<S: ?Sized> {
    settings: SimulationSettings,
    step: Step,
    /// Length of the next step to try; 0 where nothing is known of it.
    h: f64,
    segment_end: f64,
    stiffness: Stiffness,
    regime: Regime,
    locator: Locator,
    zero: ZeroSet,
    guard: Guard,
    statistics: Statistics,
    trajectory: Option<Trajectory>,
    path: Option<Path>,
    /// Last, as in [`Filippov`].
    field: Filippov<S>,
}

impl<S: Switched> Stepper<S> {
    /// Starts at time `t` in state `x` (length `n`); the modes follow from the switching functions there.
    ///
    /// # Errors
    /// [`SimError`] for a state of the wrong length, a time that is not finite, or settings without meaning.
    pub fn new(system: S, t: f64, x: &[f64], settings: &SimulationSettings) -> Result<Self, SimError> {
        settings.check()?;
        check_start(t, x, system.dim())?;
        let field = Filippov::new(system);
        let mut stepper = Self {
            settings: settings.clone(),
            step: Step::new(t, x, field.s.len()),
            h: 0.0,
            segment_end: f64::NEG_INFINITY,
            stiffness: Stiffness::new(),
            regime: Regime::new(),
            locator: Locator::new(x.len(), field.modes.len()),
            zero: ZeroSet::default(),
            guard: Guard::default(),
            statistics: Statistics::default(),
            trajectory: None,
            path: None,
            field,
        };
        stepper.any().guess_modes();
        Ok(stepper)
    }

    /// The same with the system behind a pointer.
    fn any(&mut self) -> &mut Stepper<dyn Switched + '_> {
        self
    }

    /// Current time in seconds.
    pub fn time(&self) -> f64 {
        self.step.t
    }

    /// Current state.
    pub fn state(&self) -> &[f64] {
        &self.step.x
    }

    /// Current modes, one per switch.
    pub fn modes(&self) -> &[FrictionMode] {
        &self.field.modes
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.field.system
    }

    /// The system, to change its inputs or parameters; the modes are made consistent at the next call of `advance`.
    pub fn system_mut(&mut self) -> &mut S {
        &mut self.field.system
    }

    /// Work done so far.
    pub fn statistics(&self) -> Statistics {
        Statistics { rhs: self.field.forces.evaluations, ..self.statistics }
    }

    /// Puts the system into another state at another time; the modes follow from the switching functions there.
    ///
    /// # Errors
    /// [`SimError`] for a state of the wrong length or a time that is not finite.
    pub fn set_state(&mut self, t: f64, x: &[f64]) -> Result<(), SimError> {
        check_start(t, x, self.step.x.len())?;
        let before = self.trajectory.is_some().then(|| self.field.modes.clone());
        self.step.t = t;
        self.step.x.copy_from_slice(x);
        self.guard.forget_events();
        self.any().guess_modes();
        if let (Some(trajectory), Some(before)) = (&mut self.trajectory, before) {
            trajectory.push_mode_changes(t, &before, &self.field.modes);
        }
        Ok(())
    }

    /// Integrates to `t_end`; does nothing if that lies in the past, and stops at once if it is not finite.
    pub fn advance(&mut self, t_end: f64) -> Outcome {
        self.any().run(t_end)
    }

    /// Integrates to `t_end` and records the trajectory.
    ///
    /// # Errors
    /// [`SimError::BadTimeSpan`] if `t_end` is not finite, or lies before the current time.
    pub fn record(&mut self, t_end: f64) -> Result<(Trajectory, Outcome), SimError> {
        if !t_end.is_finite() || t_end < self.step.t {
            return Err(SimError::BadTimeSpan { from: self.step.t, to: t_end });
        }
        self.start_recording();
        let outcome = self.advance(t_end);
        Ok((self.take_recording(), outcome))
    }

    /// Records the trajectory from here on, in place of one that is being recorded.
    pub fn start_recording(&mut self) {
        self.trajectory = Some(Trajectory::new(self.step.t, &self.step.x, &self.field.modes));
    }

    /// The trajectory since [`Stepper::start_recording`], which ends; without one, that of no time.
    pub fn take_recording(&mut self) -> Trajectory {
        let (t, x) = (self.step.t, &self.step.x);
        let mut trajectory = self.trajectory.take().unwrap_or_else(|| Trajectory::new(t, x, &self.field.modes));
        trajectory.finish(t, x);
        trajectory
    }

    /// Records the path from here on, in place of what `path` holds.
    pub fn follow(&mut self, mut path: Path) {
        path.clear();
        self.path = Some(path);
    }

    /// The number of pieces since [`Stepper::follow`].
    pub fn followed(&self) -> usize {
        self.path.as_ref().map_or(0, Path::len)
    }

    /// The path since [`Stepper::follow`], which ends.
    pub fn take_path(&mut self) -> Path {
        self.path.take().unwrap_or_default()
    }
}

/// Checks time and state of a start of a system with `n` states.
fn check_start(t: f64, x: &[f64], n: usize) -> Result<(), SimError> {
    if x.len() != n {
        return Err(SimError::WrongLength { what: "the state", expected: n, found: x.len() });
    }
    if t.is_finite() { Ok(()) } else { Err(SimError::BadTimeSpan { from: t, to: t }) }
}
