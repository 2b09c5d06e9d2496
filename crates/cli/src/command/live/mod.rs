//! A controller at the end of a pipe: JSON lines in, JSON lines out. docs/live.md describes the protocol.
//!
//! One thread reads, decides, and writes: handing a message to another thread costs more than the message. The main thread watches
//! the time, so that a peer that neither writes nor reads stops nobody.

mod lines;
mod outbox;
mod protocol;
mod reader;
mod serve;
mod session;

pub(crate) use reader::wait_until_closed;
pub(crate) use serve::{Limits, serve};
