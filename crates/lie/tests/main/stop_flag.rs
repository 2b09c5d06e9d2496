//! How an analysis ends early: with an error once the flag of its system's pool is raised, since what is undecided then has no
//! reason of its own; with unknown answers after its time limit.

use std::time::{Duration, Instant};

use bracketry_lie::{AnalysisOptions, Error, analyze, analyze_affine};
use bracketry_symbolic::Undecided as Exact;
use bracketry_system::System;

#[test]
fn a_raised_flag_stops_the_analysis() {
    let text = "states = ['x', 'y', 'th']\ninputs = ['u1', 'u2']\n\
                dynamics = { x = 'u1*cos(th)', y = 'u1*sin(th)', th = 'u2' }";
    let system = System::parse("unicycle", text).unwrap();
    assert!(analyze_affine(&system, &AnalysisOptions::default()).is_ok());
    system.pool.stop_flag().raise();
    assert_eq!(analyze_affine(&system, &AnalysisOptions::default()), Err(Error::Undecided(Exact::Stopped.into())));
}

#[test]
fn after_the_time_limit_what_is_undecided_is_unknown() {
    let models = [
        "states = ['x', 'y', 'th']\ninputs = ['u1', 'u2']\npoint = { x = 0 }\n\
         dynamics = { x = 'u1*cos(th)', y = 'u1*sin(th)', th = 'u2' }\noutputs = { h = 'x' }",
        "states = ['x', 'v']\ninputs = ['u']\npoint = { v = 0 }\nparameters = { m = 2 }\n\
         dynamics = { x = 'v', v = 'u - m*sign(v)' }\noutputs = { h = 'x' }",
        "states = ['x', 'y']\ninputs = ['u']\npoint = { x = 1 }\ndynamics = { x = 'u', y = 'sin(x)' }",
    ];
    for text in models {
        let system = System::parse("m", text).unwrap();
        let options = AnalysisOptions { time_limit: Some(Duration::ZERO), ..AnalysisOptions::default() };
        let report = analyze_affine(&system, &options);
        assert!(report.is_ok_and(|r| !r.dimensions_decided()), "{text}");
        // A limit that is not reached changes nothing, nor does it stay with the model.
        let unlimited = AnalysisOptions { time_limit: None, ..AnalysisOptions::default() };
        let analysis = analyze(&system, &AnalysisOptions::default()).unwrap();
        assert_eq!(analysis.affinization.system.pool.deadline(), None);
        assert_eq!(analysis.report.modes, analyze(&system, &unlimited).unwrap().report.modes);
    }
}

/// A chain of rotations that are coupled by all their angles: its brackets grow without an end.
#[test]
fn a_large_system_ends_soon_after_its_time_limit() {
    let n = 14;
    let names: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
    let all = (0..n).map(|i| format!("sin(x{i})*x{}", (i + 1) % n)).collect::<Vec<_>>().join(" + ");
    let rates: Vec<String> =
        (0..n).map(|i| format!("x{i} = 'exp(x{})*({all})/(1 + x{i}^2) + u*x{i}*({all})'", (i + 3) % n)).collect();
    let text = format!("states = [{}]\ninputs = ['u']\n[dynamics]\n{}", names.join(", "), rates.join("\n"));
    let system = System::parse("m", &text).unwrap();
    let start = Instant::now();
    let options = AnalysisOptions { time_limit: Some(Duration::from_millis(300)), ..AnalysisOptions::default() };
    assert!(analyze_affine(&system, &options).is_ok());
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}
