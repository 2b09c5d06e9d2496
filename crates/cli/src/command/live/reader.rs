//! Whether the peer can still be written to.

/// Returns once the peer has closed its reading end of standard output; where that cannot be told, never.
#[cfg(unix)]
pub(crate) fn wait_until_closed() {
    use rustix::event::{PollFd, PollFlags, poll};
    use rustix::io::Errno;

    let output = std::io::stdout();
    let closed = PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL;
    loop {
        // What concerns the other end is reported without being asked for.
        let mut watched = [PollFd::new(&output, PollFlags::empty())];
        match poll(&mut watched, None) {
            Ok(_) if watched[0].revents().intersects(closed) => return,
            Ok(_) | Err(Errno::INTR) => {}
            Err(_) => break,
        }
    }
    wait_for_ever();
}

/// A pipe of this system tells nothing until it is written to.
#[cfg(not(unix))]
pub(crate) fn wait_until_closed() {
    wait_for_ever();
}

fn wait_for_ever() {
    loop {
        std::thread::park();
    }
}
