//! What an analysis leaves behind: nothing. A program of its own, because it measures the memory of the whole process.
#![allow(clippy::unwrap_used)]

#[path = "main/common/mod.rs"]
#[allow(dead_code)]
mod common;
#[path = "../../../tests/main/common/tier.rs"]
mod tier;

use bracketry_lie::{AnalysisOptions, Evidence, analyze_affine};
use common::{ellipse, fields, system};

/// The report without the time that it took.
fn told(system: &bracketry_system::System) -> serde_json::Value {
    let mut json = serde_json::to_value(analyze_affine(system, &AnalysisOptions::default()).unwrap()).unwrap();
    json.as_object_mut().unwrap().remove("seconds");
    json
}

#[test]
fn the_pool_of_a_system_is_the_same_after_an_analysis() {
    let plate = ellipse(Some(&[]));
    let (len, made) = (plate.pool.len(), plate.pool.made());
    let first = told(&plate);
    assert_eq!((plate.pool.len(), plate.pool.made()), (len, made));
    assert_eq!(told(&plate), first);
    assert_eq!((plate.pool.len(), plate.pool.made()), (len, made));
}

/// Generic position in four states: brackets of some ten thousand nodes.
const DENSE: [&str; 4] = [
    "sin(a + 2*b*c)*u + exp(b*d)*cos(c)",
    "cos(b - c*d)*u + sin(a*d + c)",
    "a*exp(c*b)*u + cos(a + d*b)*sin(d)",
    "sin(d*a)*b*u + exp(c)*a*cos(b*a)",
];

#[test]
fn a_closure_leaves_its_basis_and_no_intermediate_brackets() {
    let mut s = system(&["a", "b", "c", "d"], &["u"], &[], &DENSE, &[], None);
    let v = fields(&mut s);
    let (len, made) = (s.pool.len(), s.pool.made());
    let closure = v.accessibility(&mut s.pool, &mut Evidence::default()).unwrap();
    assert_eq!(closure.growth, [2, 3, 4]);
    let (kept, work) = (s.pool.len() - len, s.pool.made() - made);
    assert!(kept <= work);
    let basis = closure.basis.concat();
    assert!(basis.iter().all(|e| e.index() < s.pool.len()));
    // A second time it is the same, whatever was freed.
    let again = v.accessibility(&mut s.pool, &mut Evidence::default()).unwrap();
    assert_eq!(again.growth, closure.growth);
    assert_eq!(again.words, closure.words);
}

/// Resident memory of this process in bytes.
#[cfg(target_os = "linux")]
fn resident() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() * 1024
}

/// No cache outlives an analysis: many more of them take no more memory than the first few did.
#[cfg(target_os = "linux")]
#[test]
fn many_analyses_take_no_more_memory_than_a_few() {
    let plate = ellipse(Some(&[]));
    for _ in 0..2 {
        told(&plate);
    }
    let before = resident();
    for _ in 0..tier::cases(4, 30) {
        told(&plate);
    }
    // One analysis makes more than this.
    assert!(resident() < before + (4 << 20), "{} bytes more", resident() - before);
}
