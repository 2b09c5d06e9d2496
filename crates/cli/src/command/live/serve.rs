//! A controller and its peer, from the first message to the last: threads and times.

use std::fmt;
use std::io::{Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use bracketry::mpc::closed_loop::{Counts, LateSamples};
use bracketry::mpc::live::LoopLog;
use bracketry::mpc::{LiveController, MpcError};

use super::lines::Lines;
use super::outbox::{NotRead, Outbox, Writing};
use super::session::{Happened, Next, Session};

/// Shortest time between two messages that nobody asked for.
const MIN_PERIOD: Duration = Duration::from_millis(1);
/// Time for what a peer sent before it closed its reading end, such as the message that ends the session.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// How long a peer may be silent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Longest time from one input to the next measurement; after it the failure policy decides. None: as long as it takes.
    pub(crate) deadline: Option<Duration>,
    /// Longest time without any message, and for a message that is not read; after it the session ends.
    pub(crate) timeout: Duration,
    /// Time between signs of life to a peer that is silent; none: no such signs.
    pub(crate) heartbeat: Option<Duration>,
}

/// How a session ended.
pub(crate) struct Ended {
    /// Why: `end` (the peer asked for it), `closed`, `timeout`, or `not_read`.
    reason: &'static str,
    /// Outcomes of the samples.
    counts: Counts,
    /// Samples that took longer than the sampling period.
    pub(crate) late: LateSamples,
    /// The samples, if the controller keeps them.
    pub(crate) log: Option<LoopLog>,
}

impl Ended {
    /// Whether the peer ended the session, and every sample had a solution.
    pub(crate) fn succeeded(&self) -> bool {
        self.reason == "end" && self.counts.infeasible + self.counts.fallback == 0
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let why = match self.reason {
            "end" => "the peer ended the session",
            "closed" => "the peer closed the connection without a message of type \"end\"",
            "timeout" => "the peer sent nothing within the time of --timeout",
            _ => "the peer does not read its messages",
        };
        let c = &self.counts;
        write!(
            f,
            "{why}; of {} samples, {} had no solution and {} could not keep the hard bounds",
            c.samples(),
            c.fallback,
            c.infeasible
        )
    }
}

/// Why a session ended; a panic is handed on.
type End = thread::Result<Result<&'static str, MpcError>>;

/// What the threads share.
struct Shared {
    watched: Mutex<Watched>,
    /// The session has ended, or the main thread has to wake earlier than it meant to.
    changed: Condvar,
    outbox: Outbox,
}

/// A session, and what the main thread has to know of its times.
struct Watched {
    session: Session,
    /// Whether a message is being answered, so that the peer is not the one that is waited for.
    busy: bool,
    /// When the last message had been answered.
    heard: Instant,
    /// When the last sign of life was sent.
    signed: Instant,
    /// When the next measurement is due; none before the first.
    due: Option<Instant>,
    /// When the main thread means to wake.
    waking: Instant,
    /// The end, once the peer has caused it.
    end: Option<End>,
    /// Whether the main thread has ended the session.
    over: bool,
}

/// Answers a peer until it is done or lost.
///
/// # Errors
/// Misuse of the controller that no message can cause.
pub(crate) fn serve(
    controller: LiveController,
    input: impl Read + Send + 'static,
    output: impl Write + Send + 'static,
    until_closed: impl FnOnce() + Send + 'static,
    limits: Limits,
) -> Result<Ended, MpcError> {
    let (outbox, session, now) = (Outbox::new(output), Session::new(controller), Instant::now());
    outbox.put(&session.hello());
    let watched =
        Watched { session, busy: true, heard: now, signed: now, due: None, waking: now, end: None, over: false };
    let shared = Arc::new(Shared { watched: Mutex::new(watched), changed: Condvar::new(), outbox });
    thread::spawn({
        let shared = Arc::clone(&shared);
        move || {
            let end = catch_unwind(AssertUnwindSafe(|| answer(Lines::new(input), &shared, limits)));
            shared.lock().end = Some(end);
            shared.changed.notify_all();
        }
    });
    thread::spawn({
        let shared = Arc::clone(&shared);
        move || {
            until_closed();
            thread::sleep(LAST_WORDS);
            shared.outbox.give_up();
            // Under the lock: the main thread is not just about to wait.
            let _watched = shared.lock();
            shared.changed.notify_all();
        }
    });
    // Writes what the main thread decides, which must not wait for the peer.
    let (unasked, decided) = sync_channel(1);
    thread::spawn({
        let shared = Arc::clone(&shared);
        move || decided.iter().try_for_each(|()| shared.outbox.write())
    });
    watch(&shared, &unasked, limits)
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Watched> {
        // A session that is spoiled by a panic stays `busy`, and its end hands the panic on.
        self.watched.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Answers the lines of the peer until the session ends; the reason for it.
fn answer(mut lines: Lines<impl Read>, shared: &Shared, limits: Limits) -> Result<&'static str, MpcError> {
    loop {
        // The answer first, then what can be done before the next message.
        let unread = shared.outbox.write();
        let mut w = shared.lock();
        if unread == Err(NotRead) {
            return Ok("not_read");
        }
        let happened = w.session.prepare()?;
        (w.busy, w.heard) = (false, Instant::now());
        match happened {
            Happened::Nothing => {}
            Happened::Answered => w.due = limits.deadline.map(|d| w.heard + d),
            Happened::StartedAgain => w.due = None,
        }
        if w.next(&shared.outbox, limits) < w.waking {
            shared.changed.notify_all();
        }
        drop(w);
        let Some(line) = lines.next() else { return Ok("closed") };
        let mut w = shared.lock();
        if w.over {
            return Ok("closed");
        }
        w.busy = true;
        if w.session.handle(line, &shared.outbox) == Next::End {
            return Ok("end");
        }
    }
}

/// Watches the time until the session ends, and ends it.
fn watch(shared: &Shared, unasked: &SyncSender<()>, limits: Limits) -> Result<Ended, MpcError> {
    let mut w = shared.lock();
    let reason = loop {
        if let Some(end) = w.end.take() {
            break end.unwrap_or_else(|panic| resume_unwind(panic))?;
        }
        if let Some(reason) = w.lost(&shared.outbox, limits) {
            break reason;
        }
        if w.remind(&shared.outbox, limits)? {
            // A full channel has a reminder in it already.
            let _full = unasked.try_send(());
        }
        w.waking = w.next(&shared.outbox, limits);
        let wait = w.waking.saturating_duration_since(Instant::now());
        w = shared.changed.wait_timeout(w, wait).unwrap_or_else(PoisonError::into_inner).0;
    };
    w.over = true;
    if reason != "not_read" {
        w.session.end(reason, &shared.outbox)?;
        let _full = unasked.try_send(());
    }
    let ended = Ended { reason, counts: w.session.counts(), late: w.session.late(), log: w.session.log() };
    drop(w);
    if reason != "not_read" {
        shared.outbox.wait(limits.timeout);
    }
    Ok(ended)
}

impl Watched {
    /// Why the peer is lost, if it is.
    fn lost(&self, outbox: &Outbox, limits: Limits) -> Option<&'static str> {
        let over = |since: Instant| since.elapsed() >= limits.timeout;
        match outbox.writing() {
            Writing::Broken => Some("not_read"),
            Writing::Since(since) => over(since).then_some("not_read"),
            Writing::Nothing => (!self.busy && over(self.heard)).then_some("timeout"),
        }
    }

    /// Sends what is due: the input of the policy, or a sign of life. Whether there is something to write.
    fn remind(&mut self, outbox: &Outbox, limits: Limits) -> Result<bool, MpcError> {
        if self.busy {
            return Ok(false);
        }
        let now = Instant::now();
        if let Some(due) = self.due.filter(|due| now >= *due) {
            self.session.lost(outbox)?;
            // A period that is no time to wait for is as good as none.
            let period = Duration::try_from_secs_f64(self.session.period()).unwrap_or(Duration::MAX);
            self.due = due.checked_add(period.max(MIN_PERIOD));
            return Ok(true);
        }
        let silent = self.sign(limits).is_some_and(|at| now >= at);
        if silent {
            self.session.heartbeat(outbox);
            self.signed = now;
        }
        Ok(silent)
    }

    /// When a silent peer gets a sign of life.
    fn sign(&self, limits: Limits) -> Option<Instant> {
        limits.heartbeat.map(|h| self.heard.max(self.signed) + h.max(MIN_PERIOD))
    }

    /// When there may be something to do.
    fn next(&self, outbox: &Outbox, limits: Limits) -> Instant {
        let since = match outbox.writing() {
            Writing::Since(since) => since,
            Writing::Nothing | Writing::Broken if self.busy => Instant::now(),
            Writing::Nothing | Writing::Broken => self.heard,
        };
        let waited = if self.busy { [None, None] } else { [self.due, self.sign(limits)] };
        waited.into_iter().flatten().fold(since + limits.timeout, Instant::min)
    }
}
