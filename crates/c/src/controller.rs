//! Controllers: made, stepped, freed.

use std::ffi::{CString, c_char};

use bracketry_mpc::problem::ProblemError;
use bracketry_mpc::{ControlProblem, LiveController};
use bracketry_system::{Accepted, System};

use crate::codes::{BracketryCode, BracketryKind, BracketryStatus};
use crate::error::{Failure, guarded};
use crate::memory::{check_place, numbers, text, write};

/// A controller of a problem file. One thread at a time may use it.
pub struct BracketryController {
    pub(crate) live: LiveController,
    /// The lists of names, by `BracketryKind`.
    pub(crate) names: [Vec<CString>; 6],
    /// Whether work on it started and did not come to its end, so that nothing is known of it.
    broken: bool,
}

impl BracketryController {
    fn new(problem: &ControlProblem) -> Result<Self, Failure> {
        let live = problem.controller()?;
        let strings = |list: Vec<String>| -> Vec<CString> {
            // Names hold no zeros.
            list.into_iter().map(|n| CString::new(n).unwrap_or_default()).collect()
        };
        let names =
            [live.states(), live.inputs(), live.measured(), live.references(), live.parameters(), live.targets()]
                .map(strings);
        Ok(Self { live, names, broken: false })
    }

    pub(crate) fn count(&self, kind: BracketryKind) -> usize {
        self.names[kind as usize].len()
    }
}

/// Works on the controller behind a handle.
///
/// # Safety
/// The handle is null or comes from this library, has not been freed, and nobody else uses it.
pub(crate) unsafe fn with(
    handle: *mut BracketryController,
    work: impl FnOnce(&mut BracketryController) -> Result<(), Failure>,
) -> BracketryCode {
    guarded(|| {
        // SAFETY: the caller answers for the handle.
        let Some(controller) = (unsafe { handle.as_mut() }) else {
            return Err(Failure::new(BracketryCode::Null, "the controller is a null pointer"));
        };
        if controller.broken {
            let message = "the controller failed before and cannot go on; free it and make a new one";
            return Err(Failure::new(BracketryCode::Panic, message));
        }
        controller.broken = true;
        let result = work(controller);
        // Not where the work panicked.
        controller.broken = false;
        result
    })
}

/// Hands a new controller over to C; null where there is none.
///
/// # Safety
/// `error` is null or points to a place for a code.
unsafe fn handed_over(
    error: *mut BracketryCode,
    make: impl FnOnce() -> Result<BracketryController, Failure>,
) -> *mut BracketryController {
    let mut handle = std::ptr::null_mut();
    let code = guarded(|| {
        handle = Box::into_raw(Box::new(make()?));
        Ok(())
    });
    if !error.is_null() {
        // SAFETY: not null; the caller answers for the rest.
        unsafe { error.write_unaligned(code) };
    }
    handle
}

fn refused(e: ProblemError) -> Failure {
    match e {
        ProblemError::Mpc(e) => e.into(),
        e => Failure::new(BracketryCode::Problem, e.to_string()),
    }
}

/// The controller of a problem file, whose models are looked for beside it. Makes the first plan, which may take long.
///
/// `error`, unless it is null, gets the code. Returns null where it is not `BRACKETRY_CODE_OK`. To be freed by
/// `bracketry_controller_free`.
///
/// # Safety
/// `path` is null or a text that ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_new(
    path: *const c_char,
    error: *mut BracketryCode,
) -> *mut BracketryController {
    let make = || {
        // SAFETY: as said above.
        let path = unsafe { text(path, "the path") }?;
        BracketryController::new(&ControlProblem::read(path).map_err(refused)?)
    };
    // SAFETY: as said above.
    unsafe { handed_over(error, make) }
}

/// As `bracketry_controller_new`, from the text of a problem file and that of the model, whatever the problem calls it.
///
/// # Safety
/// The texts are null or end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_from_text(
    problem: *const c_char,
    model: *const c_char,
    error: *mut BracketryCode,
) -> *mut BracketryController {
    let make = || {
        // SAFETY: as said above.
        let (problem, model) = unsafe { (text(problem, "the problem")?, text(model, "the model")?) };
        let parsed = ControlProblem::parse("problem", problem, |name| {
            let accepted = Accepted { discrete: true, algebraic: true };
            System::parse_accepting(name, model, accepted).map_err(Box::new)
        });
        BracketryController::new(&parsed.map_err(refused)?)
    };
    // SAFETY: as said above.
    unsafe { handed_over(error, make) }
}

/// Frees a controller; null is nothing to free.
///
/// # Safety
/// The handle comes from this library and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_free(controller: *mut BracketryController) {
    if !controller.is_null() {
        guarded(|| {
            // SAFETY: as said above.
            drop(unsafe { Box::from_raw(controller) });
            Ok(())
        });
    }
}

/// Answers a measurement.
///
/// # Safety
/// Handle and places as [`with`] and [`crate::memory`] want them.
unsafe fn answer(
    controller: *mut BracketryController,
    (u, m): (*mut f64, usize),
    status: *mut BracketryStatus,
    step: impl FnOnce(&mut LiveController) -> Result<(), Failure>,
) -> BracketryCode {
    let work = |c: &mut BracketryController| {
        // Before the controller moves on to the sample.
        check_place(u, m, c.count(BracketryKind::Input), "u")?;
        step(&mut c.live)?;
        let last = c.live.last();
        // SAFETY: the place is good; the caller answers for the rest.
        unsafe { write(u, &last.step.u) };
        if !status.is_null() {
            // SAFETY: not null; the caller answers for the rest.
            unsafe { status.write_unaligned(BracketryStatus::of(last)) };
        }
        Ok(())
    };
    // SAFETY: the caller answers for the handle.
    unsafe { with(controller, work) }
}

/// The input `u` (length `m`, one entry per input) for the measurement `y` (length `n`, one entry per measured quantity) taken at the
/// time `t` in seconds. It is to be held for one period.
///
/// The clock is the caller's; its first time is that of the first sample, and times are rounded to samples. Samples that have
/// passed without a measurement are compensated. An entry of `y` is NaN where nothing was measured; the input is then that of the
/// failure policy, which `status` tells. `status` may be null. Where the code is not `BRACKETRY_CODE_OK`, the controller is as
/// it was, and `u` and `status` are not written.
///
/// # Safety
/// `y` and `u` have room for `n` and `m` numbers; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_step(
    controller: *mut BracketryController,
    t: f64,
    y: *const f64,
    n: usize,
    u: *mut f64,
    m: usize,
    status: *mut BracketryStatus,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe {
        answer(controller, (u, m), status, |live| {
            live.step_at(numbers(y, n, "y")?, t)?;
            Ok(())
        })
    }
}

/// Does everything for the next sample that does not need its measurement.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_prepare(controller: *mut BracketryController) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.prepare()?)) }
}

/// As `bracketry_controller_step` for the next sample, without a clock, and as fast as possible after `bracketry_controller_prepare`.
///
/// # Safety
/// As for `bracketry_controller_step`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_feedback(
    controller: *mut BracketryController,
    y: *const f64,
    n: usize,
    u: *mut f64,
    m: usize,
    status: *mut BracketryStatus,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe {
        answer(controller, (u, m), status, |live| {
            live.feedback(numbers(y, n, "y")?)?;
            Ok(())
        })
    }
}

/// The input of the next sample, whose measurement has not come in time: that of the failure policy.
///
/// # Safety
/// As for `bracketry_controller_step`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_lost(
    controller: *mut BracketryController,
    u: *mut f64,
    m: usize,
    status: *mut BracketryStatus,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe {
        answer(controller, (u, m), status, |live| {
            live.lost()?;
            Ok(())
        })
    }
}

/// Starts again from the initial state of the problem, at sample 0. Changes of references, parameters, bounds, and targets stay.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_reset(controller: *mut BracketryController) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.reset()?)) }
}

/// As `bracketry_controller_reset`, from the state `x0` (length `n`, one entry per state).
///
/// # Safety
/// `x0` has `n` numbers; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_reset_to(
    controller: *mut BracketryController,
    x0: *const f64,
    n: usize,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.reset_to(numbers(x0, n, "x0")?)?)) }
}

/// The states and inputs that the last sample's program predicts: `x` gets the states at the N + 1 grid points of the horizon, one
/// point after the other (`nx` = (N + 1) · number of states), `u` the inputs of the N intervals (`nu` = N · number of inputs). N is
/// `bracketry_controller_horizon`.
///
/// # Safety
/// `x` and `u` have room for `nx` and `nu` numbers; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_predict(
    controller: *mut BracketryController,
    x: *mut f64,
    nx: usize,
    u: *mut f64,
    nu: usize,
) -> BracketryCode {
    let work = |c: &mut BracketryController| {
        let prediction = c.live.prediction();
        let steps = prediction.steps();
        check_place(x, nx, (steps + 1) * prediction.states(), "x")?;
        check_place(u, nu, steps * prediction.inputs(), "u")?;
        for k in 0..=steps {
            // SAFETY: within the place that was checked; the caller answers for the rest.
            unsafe { write(x.add(k * prediction.states()), prediction.x(k)) };
        }
        for k in 0..steps {
            // SAFETY: as above.
            unsafe { write(u.add(k * prediction.inputs()), prediction.u(k)) };
        }
        Ok(())
    };
    // SAFETY: as said above.
    unsafe { with(controller, work) }
}

#[cfg(test)]
mod tests {
    use bracketry_mpc::MpcError;

    use super::*;

    #[test]
    fn a_controller_that_panicked_is_only_freed() {
        let model = c"states = ['x']\ninputs = ['a']\ndynamics = { x = 'a' }\n";
        let problem = c"model = 'm.toml'\nhorizon = { steps = 5, dt = 0.1 }\ncost = { stage = 'x^2 + a^2' }\n\
            run = { x0 = { x = 1 } }\n";
        let mut code = BracketryCode::Panic;
        // SAFETY: texts that end with a zero, and a handle of this library.
        unsafe {
            let handle = bracketry_controller_from_text(problem.as_ptr(), model.as_ptr(), &raw mut code);
            assert_eq!(code, BracketryCode::Ok);
            assert_eq!(bracketry_controller_prepare(handle), BracketryCode::Ok);
            assert_eq!(with(handle, |_| panic!("in the middle of it")), BracketryCode::Panic);
            assert_eq!(bracketry_controller_prepare(handle), BracketryCode::Panic);
            assert_eq!(bracketry_controller_reset(handle), BracketryCode::Panic);
            bracketry_controller_free(handle);
        }
    }

    /// What takes a controller to another thread, one at a time.
    #[test]
    fn controllers_can_move_between_threads() {
        fn movable<T: Send>() {}
        movable::<BracketryController>();
        let misuse = MpcError::Length { what: "y", found: 1, expected: 2 };
        assert_eq!(Failure::from(misuse).code, BracketryCode::Length);
    }
}
