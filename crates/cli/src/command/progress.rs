//! What long work is doing, on standard error: a turning mark on a terminal, else a line every ten seconds.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Time between two lines where standard error is no terminal.
const EVERY: Duration = Duration::from_secs(10);

/// Says what is being done until it is dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
    lines: Option<Lines>,
}

/// Lines from a thread of its own.
struct Lines {
    message: Arc<Mutex<String>>,
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Work that begins.
pub(crate) fn spinner(message: &str) -> Progress {
    let progress = Progress {
        bar: ProgressBar::new_spinner(),
        lines: (!std::io::stderr().is_terminal()).then(|| Lines::every(EVERY)),
    };
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} [{elapsed}]") {
        progress.bar.set_style(style);
    }
    progress.bar.enable_steady_tick(Duration::from_millis(100));
    progress.set_message(message);
    progress
}

impl Progress {
    pub(crate) fn set_message(&self, message: impl Into<String>) {
        let message = message.into();
        if let Some(lines) = &self.lines {
            lines.message.lock().unwrap_or_else(PoisonError::into_inner).clone_from(&message);
        }
        self.bar.set_message(message);
    }

    /// Takes the mark away while something else is printed.
    pub(crate) fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    pub(crate) fn finish_and_clear(&self) {
        self.set_message("");
        self.bar.finish_and_clear();
    }
}

impl Lines {
    fn every(period: Duration) -> Self {
        let message = Arc::new(Mutex::new(String::new()));
        let (end, ended) = channel::<()>();
        let shown = Arc::clone(&message);
        let thread = std::thread::spawn(move || {
            let start = Instant::now();
            while ended.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
                let message = shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
                if message.is_empty() {
                    continue;
                }
                // Nobody reads what cannot be written.
                let _ = writeln!(std::io::stderr(), "{message} [{:.0} s]", start.elapsed().as_secs_f64());
            }
        });
        Self { message, end: Some(end), thread: Some(thread) }
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        self.end.take();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
