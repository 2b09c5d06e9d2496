//! Limits on time and memory.
//!
//! The work looks at its limits itself and then reports what is undecided as unknown. A thread that watches memory and time tells it,
//! and ends the process where the work does not look in time.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use bracketry::symbolic::StopFlag;
use bracketry::system::{FileError, System};
use clap::Args;
use sysinfo::{MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, System as Machine, get_current_pid};

use super::ending::give_up;

/// Share of the machine's memory that a command may take unless another limit is given.
const DEFAULT_SHARE: f64 = 0.5;
/// Share of the memory limit at which the work is asked to end; the rest is for its report.
const ASKED_AT: f64 = 0.75;
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(20);
/// How long the work may go on after its time limit, at least, and as a share of the limit.
const GRACE: (Duration, f64) = (Duration::from_secs(5), 0.5);
/// Longest time limit, s, which is no limit in practice and fits every clock.
const LONGEST: f64 = 1e9;

/// The time limit of a command.
#[derive(Args, Clone, Copy)]
pub(crate) struct TimeLimit {
    /// Stop after this many seconds; what is undecided by then is reported as unknown
    #[arg(long = "time-limit", value_name = "SECONDS", default_value = "120", allow_negative_numbers = true, value_parser = seconds)]
    limit: Duration,
}

impl TimeLimit {
    pub(crate) fn of(limit: Duration) -> Self {
        Self { limit }
    }

    pub(crate) fn get(self) -> Duration {
        self.limit
    }
}

/// A positive number of seconds.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let given: Option<f64> = text.parse().ok().filter(|s| *s > 0.0);
    let given = given.ok_or("give a positive number of seconds")?;
    Ok(Duration::from_secs_f64(given.min(LONGEST)))
}

/// A number of bytes, such as 4GB or 500 MB.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "give a number with a unit, such as 4GB or 500MB".to_owned();
    let text = text.trim();
    let unit = text.find(|c: char| c.is_ascii_alphabetic()).ok_or_else(wrong)?;
    let size: f64 = text[..unit].trim().parse().map_err(|_| wrong())?;
    let factor = match text[unit..].to_ascii_uppercase().as_str() {
        "MB" => 1e6,
        "GB" => 1e9,
        "MIB" => 1024f64.powi(2),
        "GIB" => 1024f64.powi(3),
        _ => return Err(wrong()),
    };
    let bytes = size * factor;
    if bytes.is_finite() && bytes >= 1e6 { Ok(bytes as u64) } else { Err("give at least 1MB".to_owned()) }
}

/// What is watched from the start of a command on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    stop: StopFlag,
    deadline: Option<Instant>,
}

impl Limits {
    /// Watches the memory of this process, by default half of the machine's, and the time of a command that has a limit.
    pub(crate) fn watch(memory: Option<u64>, time: Option<TimeLimit>) -> Self {
        let start = Instant::now();
        let limits = Limits { stop: StopFlag::default(), deadline: time.and_then(|t| start.checked_add(t.limit)) };
        let stop = limits.stop.clone();
        let last = time.and_then(|t| {
            let grace = GRACE.0.max(t.limit.mul_f64(GRACE.1));
            start.checked_add(t.limit.saturating_add(grace)).map(|end| (end, t.limit))
        });
        // Without a thread, the work still looks at its time.
        let _ = thread::Builder::new().name("limits".to_owned()).spawn(move || watch(&stop, memory, last));
        limits
    }

    /// When the command is to end.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Reads a model; the work on it looks at the memory.
    pub(crate) fn read(&self, path: &Path) -> Result<System, FileError> {
        let mut system = System::read(path)?;
        system.pool.set_stop_flag(self.stop.clone());
        Ok(system)
    }
}

fn watch(stop: &StopFlag, memory: Option<u64>, last: Option<(Instant, Duration)>) {
    let mut machine = Machine::new().ok().zip(get_current_pid().ok());
    let limit = memory.or_else(|| machine.as_mut().map(|(machine, _)| default_limit(machine))).unwrap_or(0);
    // A machine that does not say what it has sets no limit.
    let limit = (limit > 0).then_some(limit);
    loop {
        if let (Some(limit), Some((machine, pid))) = (limit, &mut machine) {
            let taken = taken(machine, *pid);
            if taken as f64 > limit as f64 * ASKED_AT {
                stop.memory_runs_out();
            }
            if taken > limit {
                let gigabytes = limit as f64 / 1e9;
                let more = (2.0 * gigabytes).max(1.0);
                give_up(
                    &format!("stopped at the memory limit of {gigabytes:.3} GB"),
                    " without a result",
                    &format!(
                        "give more with --memory-limit, such as --memory-limit {more:.0}GB, or use a smaller model"
                    ),
                );
            }
        }
        if let Some((_, limit)) = last.filter(|(end, _)| Instant::now() >= *end) {
            give_up(
                &format!("a step of the work did not end within the time limit of {} s: stopped", limit.as_secs_f64()),
                " without a result",
                "give more time with --time-limit, or use a smaller model",
            );
        }
        thread::sleep(LOOK);
    }
}

/// The share of the memory that the machine has, or that its container allows.
fn default_limit(machine: &mut Machine) -> u64 {
    machine.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    let total = machine.total_memory();
    let total = machine.cgroup_limits().map_or(total, |c| c.total_memory.min(total));
    (total as f64 * DEFAULT_SHARE) as u64
}

/// Resident memory of this process, in bytes.
fn taken(machine: &mut Machine, pid: Pid) -> u64 {
    let what = ProcessRefreshKind::nothing().with_memory().without_tasks();
    machine.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), false, what);
    machine.process(pid).map_or(0, sysinfo::Process::memory)
}
