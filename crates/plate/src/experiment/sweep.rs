//! Many independent runs in parallel.

use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Runs `run` on every case, on all threads of the current rayon pool, and gives the results in the order of the cases.
///
/// After each run, `progress` is told how many are done; if it breaks, no further run is started and the missing results
/// are `None`. What can go wrong in a run belongs in its result. As no run knows of another, the results do not depend on
/// the number of threads.
///
/// ```
/// use bracketry_plate::experiment::sweep;
/// use std::ops::ControlFlow;
/// let squares = sweep(&[1.0, 2.0, 3.0], |x: &f64| x * x, |_| ControlFlow::Continue(()));
/// assert_eq!(squares, [Some(1.0), Some(4.0), Some(9.0)]);
/// ```
pub fn sweep<C: Sync, R: Send>(
    cases: &[C],
    run: impl Fn(&C) -> R + Sync,
    progress: impl Fn(usize) -> ControlFlow<()> + Sync,
) -> Vec<Option<R>> {
    let (done, canceled) = (AtomicUsize::new(0), AtomicBool::new(false));
    cases
        .par_iter()
        .with_max_len(1)
        .map(|case| {
            if canceled.load(Ordering::Relaxed) {
                return None;
            }
            let result = run(case);
            if progress(done.fetch_add(1, Ordering::Relaxed) + 1).is_break() {
                canceled.store(true, Ordering::Relaxed);
            }
            Some(result)
        })
        .collect()
}
