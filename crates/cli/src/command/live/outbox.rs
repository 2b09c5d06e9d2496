//! Messages to a peer, in the order in which they were decided.

use std::collections::VecDeque;
use std::io::Write;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

/// The peer does not read what it is sent, or has gone.
#[derive(Debug, PartialEq)]
pub(super) struct NotRead;

/// What becomes of messages at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Writing {
    /// No message is being written.
    Nothing,
    /// One has been being written since then.
    Since(Instant),
    /// None can be: the peer has gone.
    Broken,
}

/// Messages that wait to be written. Putting one in never waits for the peer; writing does.
pub(super) struct Outbox {
    state: Mutex<State>,
    /// Everything has been written, or nothing can be.
    done: Condvar,
}

struct State {
    waiting: VecDeque<Vec<u8>>,
    /// The stream to the peer; none while a thread writes to it, and once it is broken.
    stream: Option<Box<dyn Write + Send>>,
    /// Since when the message at hand is being written.
    since: Option<Instant>,
    broken: bool,
}

impl Outbox {
    pub(super) fn new(stream: impl Write + Send + 'static) -> Self {
        let state = State { waiting: VecDeque::new(), stream: Some(Box::new(stream)), since: None, broken: false };
        Self { state: Mutex::new(state), done: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing is done under the lock that could panic halfway.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message.
    pub(super) fn put(&self, message: &impl Serialize) {
        // Messages hold numbers, lists and names only, which all have a form in JSON.
        if let Ok(mut text) = serde_json::to_vec(message) {
            text.push(b'\n');
            self.lock().waiting.push_back(text);
        }
    }

    /// Writes what waits. Where another thread is at it, this waits for it, so that a peer that does not read is not listened to.
    pub(super) fn write(&self) -> Result<(), NotRead> {
        let writing = |s: &mut State| s.stream.is_none() && !s.broken;
        let mut state = self.done.wait_while(self.lock(), writing).unwrap_or_else(PoisonError::into_inner);
        let Some(mut stream) = state.stream.take() else { return Err(NotRead) };
        while let Some(text) = state.waiting.pop_front() {
            state.since = Some(Instant::now());
            drop(state);
            let written = stream.write_all(&text).and_then(|()| stream.flush());
            state = self.lock();
            state.since = None;
            if written.is_err() {
                state.broken = true;
                state.waiting.clear();
                self.done.notify_all();
                return Err(NotRead);
            }
        }
        state.stream = Some(stream);
        self.done.notify_all();
        Ok(())
    }

    /// Gives the peer up: nothing is written any more.
    pub(super) fn give_up(&self) {
        let mut state = self.lock();
        state.broken = true;
        state.waiting.clear();
        self.done.notify_all();
    }

    /// What becomes of the messages.
    pub(super) fn writing(&self) -> Writing {
        let state = self.lock();
        if state.broken { Writing::Broken } else { state.since.map_or(Writing::Nothing, Writing::Since) }
    }

    /// Waits until everything has been written or cannot be, `longest` at most.
    pub(super) fn wait(&self, longest: Duration) {
        let going_on = |s: &mut State| !s.broken && (s.stream.is_none() || !s.waiting.is_empty());
        drop(self.done.wait_timeout_while(self.lock(), longest, going_on));
    }
}
