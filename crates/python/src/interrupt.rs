//! Long work in a thread of its own, while the calling thread looks out for Ctrl-C.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use bracketry::symbolic::StopFlag;
use pyo3::prelude::*;

use crate::error::Failure;

/// Time between two looks at signals.
const LOOK: Duration = Duration::from_millis(20);
/// Time that work gets to end after it was asked to; what takes longer is left to itself.
const GRACE: Duration = Duration::from_secs(5);
/// Stack of the thread: expressions are trees.
const STACK: usize = 64 << 20;

/// Runs `work` without holding the interpreter. An interrupt asks it to stop and is raised once it has, or at the latest after
/// [`GRACE`].
pub(crate) fn watched<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&StopFlag) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let stop = StopFlag::default();
    let asked = stop.clone();
    let (sender, receiver) = channel();
    let thread = thread::Builder::new().name("bracketry".to_owned()).stack_size(STACK).spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(|| work(&asked)));
        // Nobody listens any more after an interrupt.
        let _ = sender.send(outcome);
    });
    thread.map_err(Failure::from)?;
    let receiver = Mutex::new(receiver);
    let wait = |time: Duration| {
        py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(time),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        })
    };
    loop {
        match wait(LOOK) {
            Ok(outcome) => return Ok(outcome.map_err(|panic| broken(panic.as_ref()))??),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupt) = py.check_signals() {
                    stop.raise();
                    let _ = wait(GRACE);
                    return Err(interrupt);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::new("the computation ended without a result").into());
            }
        }
    }
}

/// The time limit of a computation, in seconds.
///
/// # Errors
/// For what is no positive number.
pub(crate) fn seconds(limit: f64) -> Result<Duration, Failure> {
    if limit.is_finite() && limit > 0.0 {
        return Ok(Duration::from_secs_f64(limit.min(1e6)));
    }
    Err(Failure::new(format!("time_limit is {limit}; give a positive number of seconds")))
}

/// A panic is a fault of the library, whatever was asked of it.
fn broken(panic: &(dyn Any + Send)) -> Failure {
    let message = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    Failure::new(format!("internal error: {}; please report how it occurred", message.unwrap_or("unknown")))
}
