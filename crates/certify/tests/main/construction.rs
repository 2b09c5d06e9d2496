//! Random systems whose answers are known by construction: they are proved, or unknown; wrong systems are never proved.

use std::time::Duration;

use bracketry_certify::{CertificateReason, Certification, CertifyOptions, Claim, Conclusion, Find, Flaw, certify};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

fn found(dynamics: &[String], more: &str, find: &[Find]) -> Certification {
    let n = dynamics.len();
    let states: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
    let list: Vec<String> = dynamics.iter().enumerate().map(|(i, e)| format!("x{i} = '{e}'")).collect();
    let text = format!("states = [{}]\n{more}\ndynamics = {{ {} }}\n", states.join(", "), list.join(", "));
    let system = System::parse("m", &text).unwrap();
    certify(&system, &CertifyOptions { find: find.to_vec(), ..CertifyOptions::default() }).unwrap()
}

fn number(rng: &mut StdRng) -> i32 {
    rng.random_range(-3..=3)
}

/// V = (positive definite quadratic form in linear combinations) + fourth powers of these, as its gradient by state.
struct Energy {
    /// Rows of an integer matrix with determinant 1: ξ = T x.
    rows: Vec<Vec<i32>>,
}

impl Energy {
    fn random(n: usize, rng: &mut StdRng) -> Self {
        let mut rows: Vec<Vec<i32>> = (0..n).map(|i| (0..n).map(|j| i32::from(i == j)).collect()).collect();
        for _ in 0..2 {
            let (i, j) = (rng.random_range(0..n), rng.random_range(0..n));
            if i != j {
                let c = rng.random_range(-1..=1);
                for k in 0..n {
                    rows[i][k] += c * rows[j][k];
                }
            }
        }
        Energy { rows }
    }

    fn coordinate(&self, i: usize) -> String {
        let terms: Vec<String> = self.rows[i].iter().enumerate().map(|(k, c)| format!("({c})*x{k}")).collect();
        format!("({})", terms.join(" + "))
    }

    /// ∂V/∂x_k for V = Σ ξ_i²/2 + ξ_i⁴/4.
    fn gradient(&self, k: usize) -> String {
        let n = self.rows.len();
        let terms: Vec<String> = (0..n)
            .map(|i| {
                let z = self.coordinate(i);
                format!("({})*({z} + {z}^3)", self.rows[i][k])
            })
            .collect();
        format!("({})", terms.join(" + "))
    }
}

/// Skew entries above the diagonal.
fn skew(n: usize, rng: &mut StdRng) -> Vec<Vec<i32>> {
    let mut j = vec![vec![0; n]; n];
    for a in 0..n {
        for b in 0..a {
            j[a][b] = number(rng);
            j[b][a] = -j[a][b];
        }
    }
    j
}

fn product(matrix: &[Vec<i32>], energy: &Energy) -> Vec<String> {
    let n = matrix.len();
    let row =
        |i: usize| (0..n).map(|k| format!("({})*{}", matrix[i][k], energy.gradient(k))).collect::<Vec<_>>().join(" + ");
    (0..n).map(row).collect()
}

fn lyapunov(found: &Certification) -> Option<Conclusion> {
    found.lyapunov.as_ref().unwrap().proof().map(|p| p.conclusion)
}

/// x' = (J − R) ∇V with a skew J and R = 1.
#[test]
fn dissipative_hamiltonian_systems_are_proved_stable() {
    let mut rng = StdRng::seed_from_u64(1);
    let mut proved = 0;
    for case in 0..10 {
        let n = 2 + case % 2;
        let energy = Energy::random(n, &mut rng);
        let mut matrix = skew(n, &mut rng);
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] = -1;
        }
        let found = found(&product(&matrix, &energy), "", &[Find::Lyapunov]);
        proved += i32::from(lyapunov(&found) == Some(Conclusion::GloballyAsymptoticallyStable));
    }
    assert!(proved >= 9, "{proved} of 10");
}

/// The same with time reversed is unstable, and x' = J ∇V is stable, not asymptotically.
#[test]
fn what_is_not_asymptotically_stable_is_never_proved_to_be() {
    let mut rng = StdRng::seed_from_u64(2);
    let mut stable = 0;
    for _ in 0..6 {
        let energy = Energy::random(2, &mut rng);
        let matrix = skew(2, &mut rng);
        let conservative = product(&matrix, &energy);
        let mut outward = matrix.clone();
        for (i, row) in outward.iter_mut().enumerate() {
            row[i] = 1;
        }
        assert_eq!(lyapunov(&found(&product(&outward, &energy), "", &[Find::Lyapunov])), None);
        let found = found(&conservative, "", &[Find::Lyapunov, Find::Region]);
        assert_ne!(lyapunov(&found), Some(Conclusion::GloballyAsymptoticallyStable));
        assert!(found.region.as_ref().unwrap().proof().is_none());
        stable += i32::from(lyapunov(&found) == Some(Conclusion::Stable));
    }
    assert!(stable >= 5, "{stable} of 6");
}

/// The energy of x' = J ∇H with an invertible J of two states is the only generator.
#[test]
fn hamiltonian_systems_give_their_energy() {
    let mut rng = StdRng::seed_from_u64(3);
    for _ in 0..6 {
        let energy = Energy::random(2, &mut rng);
        let c = rng.random_range(1..=3);
        let found = found(&product(&[vec![0, c], vec![-c, 0]], &energy), "", &[Find::Conserved]);
        let conserved = found.conserved.unwrap();
        let [proof] = &conserved.polynomials[..] else { panic!("{conserved:?}") };
        let Claim::Conserved { function } = &proof.certificate.claim else { panic!() };
        assert_eq!((function.degree(), function.order()), (4, 2));
        assert_eq!(proof.certificate.verify(), Ok(Conclusion::Conserved));
    }
}

/// x' = (J − R) ∇H + g u, y = gᵀ ∇H is passive with the storage function H (port-Hamiltonian systems).
#[test]
fn port_hamiltonian_systems_are_passive() {
    let mut rng = StdRng::seed_from_u64(4);
    for case in 0..6 {
        let energy = Energy::random(2, &mut rng);
        let mut matrix = skew(2, &mut rng);
        let damped = case % 2 == 0;
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] = -i32::from(damped);
        }
        let g = [1, number(&mut rng)];
        let drift = product(&matrix, &energy);
        let dynamics: Vec<String> = drift.iter().zip(g).map(|(f, g)| format!("{f} + ({g})*u")).collect();
        let output = format!("({})*{} + ({})*{}", g[0], energy.gradient(0), g[1], energy.gradient(1));
        let ports = format!("inputs = ['u']\noutputs = {{ y = '{output}' }}");
        let passive = found(&dynamics, &ports, &[Find::Passivity]);
        let proof = passive.passivity.as_ref().unwrap().proof().unwrap_or_else(|| panic!("{case}: {passive:?}"));
        let Claim::Passive { storage, .. } = &proof.certificate.claim else { panic!() };
        assert_eq!(storage.order(), 2);
        // With the opposite output, the storage function would be negative.
        let ports = format!("inputs = ['u']\noutputs = {{ y = '-({output})' }}");
        assert!(found(&dynamics, &ports, &[Find::Passivity]).passivity.unwrap().proof().is_none());
    }
}

/// The same with damping along one direction only, y = gᵀ ∇H and R = g gᵀ: the rate is −y², whose Gram matrix is singular in all
/// coordinates.
#[test]
fn damping_of_the_output_alone_is_recognized() {
    let mut rng = StdRng::seed_from_u64(5);
    let mut proved = 0;
    for _ in 0..6 {
        let energy = Energy::random(2, &mut rng);
        let g = [1, rng.random_range(1..=3)];
        let j = number(&mut rng);
        let matrix = [vec![-1, j - g[1]], vec![-j - g[1], -g[1] * g[1]]];
        let drift = product(&matrix, &energy);
        let dynamics: Vec<String> = drift.iter().zip(g).map(|(f, g)| format!("{f} + ({g})*u")).collect();
        let output = format!("{} + ({})*{}", energy.gradient(0), g[1], energy.gradient(1));
        let found = found(&dynamics, &format!("inputs = ['u']\noutputs = {{ y = '{output}' }}"), &[Find::Passivity]);
        proved += i32::from(found.passivity.unwrap().proof().is_some());
    }
    assert!(proved >= 5, "{proved} of 6");
}

/// Every single entry of a certificate matters.
#[test]
fn a_certificate_that_was_changed_is_rejected() {
    let dynamics = ["-x1".to_owned(), "x0 + (x0^2 - 1)*x1".to_owned()];
    let proof = found(&dynamics, "", &[Find::Region]).region.unwrap().proof().unwrap().clone();
    let text = serde_json::to_string(&proof.certificate).unwrap();
    let read: bracketry_certify::Certificate = serde_json::from_str(&text).unwrap();
    assert_eq!(read, proof.certificate);
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    for part in ["positive", "decrease", "multiplier"] {
        let size = value["claim"][part]["matrix"].as_array().unwrap().len();
        for i in 0..size {
            let mut changed = value.clone();
            let entry = &mut changed["claim"][part]["matrix"][i][i];
            let old: bracketry_symbolic::Rational = entry.as_str().unwrap().parse().unwrap();
            *entry = serde_json::Value::String((old + bracketry_symbolic::Rational::ONE).to_string());
            let changed: bracketry_certify::Certificate = serde_json::from_value(changed).unwrap();
            assert!(changed.verify().is_err(), "{part} {i}");
        }
    }
    let mut larger = proof.certificate.clone();
    if let Claim::Region { level, .. } = &mut larger.claim {
        *level += bracketry_symbolic::Rational::ONE;
    }
    assert_eq!(larger.verify(), Err(Flaw::NotTheRate));
    let mut malformed = proof.certificate.clone();
    malformed.field.pop();
    assert_eq!(malformed.verify(), Err(Flaw::Malformed));
    let mut huge = value;
    huge["claim"]["decrease"]["monomials"][0][0] = serde_json::json!(u32::MAX);
    let huge: bracketry_certify::Certificate = serde_json::from_value(huge).unwrap();
    assert_eq!(huge.verify(), Err(Flaw::Malformed));
}

/// Of high degree or of many states: nothing is written out that no program could hold, and the reason is given.
#[test]
fn what_is_too_large_is_not_proved_and_takes_no_memory() {
    let many = |n: usize| (0..n).map(|i| format!("-x{i} + x{}^2", (i + 1) % n)).collect::<Vec<_>>();
    for dynamics in [vec!["-x0 + x0^1000000000".to_owned()], many(300)] {
        let r = found(&dynamics, "inputs = []", &[Find::Lyapunov, Find::Region, Find::Conserved]);
        assert!(r.lyapunov.unwrap().proof().is_none(), "{}", dynamics[0]);
        assert!(r.region.unwrap().proof().is_none(), "{}", dynamics[0]);
    }
}

/// Products that multiply out to 2^n terms: the limit of time holds while the equations are read.
#[test]
fn the_time_limit_holds_while_products_are_multiplied_out() {
    let n = 40;
    let factor = (1..n).map(|i| format!("(x{i} + x{}^2 + 1)", i - 1)).collect::<Vec<_>>().join("*");
    let dynamics: Vec<String> = (0..n).map(|i| format!("-x{i} + x{i}*{factor}")).collect();
    let states: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
    let list: Vec<String> = dynamics.iter().enumerate().map(|(i, e)| format!("x{i} = '{e}'")).collect();
    let text = format!("states = [{}]\ninputs = []\ndynamics = {{ {} }}\n", states.join(", "), list.join(", "));
    let system = System::parse("m", &text).unwrap();
    let options = CertifyOptions { time_limit: Some(Duration::ZERO), ..CertifyOptions::default() };
    let r = certify(&system, &options).unwrap();
    assert_eq!(r.not_polynomial, Some(CertificateReason::OutOfTime));
}
