//! An analysis ends with an error once the flag of its system's pool is raised: what is undecided then has no reason of its own.
#![allow(clippy::unwrap_used)]

use bracketry_lie::{Error, Options, Undecided, analyze_affine};
use bracketry_system::System;

#[test]
fn a_raised_flag_stops_the_analysis() {
    let text = "states = ['x', 'y', 'th']\ninputs = ['u1', 'u2']\n\
                dynamics = { x = 'u1*cos(th)', y = 'u1*sin(th)', th = 'u2' }";
    let system = System::parse("unicycle", text).unwrap();
    assert!(analyze_affine(&system, &Options::default()).is_ok());
    system.pool.stop_flag().raise();
    assert_eq!(analyze_affine(&system, &Options::default()), Err(Error::Undecided(Undecided::Stopped)));
}
