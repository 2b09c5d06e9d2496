//! Systems of the literature with known answers.

use bracketry_certify::{
    CertificateReason, Certification, CertifyOptions, Claim, Conclusion, Find, certify, with_feedback,
};
use bracketry_system::System;

fn found(model: &str, find: &[Find], degree: u32) -> Certification {
    let system = System::parse("m", model).unwrap();
    let found = certify(&system, &CertifyOptions { find: find.to_vec(), degree, ..CertifyOptions::default() }).unwrap();
    let all = [&found.lyapunov, &found.region, &found.passivity];
    for proof in all.into_iter().flatten().filter_map(|f| f.proof()) {
        assert_eq!(proof.certificate.verify(), Ok(proof.conclusion));
    }
    found
}

fn conclusion(found: &Certification) -> Option<Conclusion> {
    found.lyapunov.as_ref()?.proof().map(|p| p.conclusion)
}

/// Khalil 2002, example 8.9: V = 1.5 x² − x y + y² proves {V < 2.25} or somewhat more.
#[test]
fn the_reversed_van_der_pol_oscillator_has_the_known_quadratic_region() {
    let found = found(
        "states = ['x', 'y']\ndynamics = { x = '-y', y = 'x + (x^2 - 1)*y' }",
        &[Find::Region, Find::Lyapunov],
        2,
    );
    let proof = found.region.as_ref().unwrap().proof().unwrap();
    let level = proof.level.as_ref().unwrap().to_f64().value();
    assert!((2.2..2.35).contains(&level), "{level} {}", proof.function);
    assert!(found.lyapunov.unwrap().proof().is_none(), "the limit cycle excludes a global function");
}

/// x' = −x + x y, y' = −y has a global Lyapunov function, but no polynomial one (Ahmadi, Krstic, and Parrilo 2011).
#[test]
fn a_stable_system_without_polynomial_lyapunov_function_is_not_called_unstable() {
    let found =
        found("states = ['x', 'y']\ndynamics = { x = '-x + x*y', y = '-y' }", &[Find::Lyapunov, Find::Region], 4);
    assert_eq!(conclusion(&found), None);
    assert!(found.region.unwrap().proof().is_some());
}

#[test]
fn cubic_damping_is_decided_though_the_linearization_does_not() {
    let found = found("states = ['x']\ndynamics = { x = '-x^3' }", &[Find::Lyapunov], 2);
    assert_eq!(conclusion(&found), Some(Conclusion::GloballyAsymptoticallyStable));
}

#[test]
fn a_center_manifold_with_cubic_damping_is_globally_stable() {
    let found = found("states = ['x', 'y']\ndynamics = { x = '-x + y^2', y = '-y^3' }", &[Find::Lyapunov], 4);
    assert_eq!(conclusion(&found), Some(Conclusion::GloballyAsymptoticallyStable));
}

/// The rate of a quadratic form with y² has the cubic term y x², and none that bounds it.
#[test]
fn a_function_of_degree_four_is_found_where_none_of_degree_two_exists() {
    let model = "states = ['x', 'y']\ndynamics = { x = '-x', y = '-y + x^2' }";
    let two = found(model, &[Find::Lyapunov], 2);
    assert_eq!(conclusion(&two), None);
    let four = found(model, &[Find::Lyapunov], 4);
    assert_eq!(conclusion(&four), Some(Conclusion::GloballyAsymptoticallyStable));
}

#[test]
fn the_damped_duffing_oscillator_is_globally_stable_and_passive() {
    let found = found(
        "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - x - x^3 - v' }\noutputs = { y = 'v' }",
        &[Find::Lyapunov, Find::Passivity, Find::Conserved],
        4,
    );
    assert_eq!(conclusion(&found), Some(Conclusion::GloballyAsymptoticallyStable));
    let storage = found.passivity.as_ref().unwrap().proof().unwrap();
    assert_eq!(storage.conclusion, Conclusion::Passive);
    assert_eq!(storage.function.text(), "0.25*x^4 + 0.5*v^2 + 0.5*x^2");
    assert_eq!(found.conserved.unwrap().polynomials, []);
}

#[test]
fn a_spring_without_damping_conserves_energy_and_is_stable_and_lossless() {
    let found = found(
        "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - x - x^3' }\noutputs = { y = 'v' }",
        &[Find::Lyapunov, Find::Passivity, Find::Conserved],
        4,
    );
    assert_eq!(conclusion(&found), Some(Conclusion::Stable));
    assert_eq!(found.passivity.as_ref().unwrap().proof().unwrap().conclusion, Conclusion::Lossless);
    let [energy] = &found.conserved.as_ref().unwrap().polynomials[..] else { panic!("{:?}", found.conserved) };
    assert_eq!(energy.function.text(), "x^4 + 2*v^2 + 2*x^2");
}

/// Euler's equations of a free rigid body conserve the energy and the size of the angular momentum.
#[test]
fn a_free_rigid_body_has_two_conserved_quadratic_forms() {
    let found =
        found("states = ['x', 'y', 'z']\ndynamics = { x = '-y*z', y = '2*x*z', z = '-x*y' }", &[Find::Conserved], 4);
    let conserved = found.conserved.unwrap();
    assert_eq!((conserved.polynomials.len(), conserved.complete_to), (2, Some(4)));
    assert!(conserved.polynomials.iter().all(|p| p.certificate.verify() == Ok(Conclusion::Conserved)));
}

/// Area of {V ≤ c} in the plane, by counting cells of a grid.
fn area(proof: &bracketry_certify::Proof) -> f64 {
    let Claim::Region { function, level, .. } = &proof.certificate.claim else { panic!("{proof:?}") };
    let terms: Vec<(Vec<u32>, f64)> = function.terms().map(|(m, c)| (m.clone(), c.to_f64().value())).collect();
    let c = level.to_f64().value();
    let value = |x: f64, y: f64| terms.iter().map(|(m, c)| c * x.powi(m[0] as i32) * y.powi(m[1] as i32)).sum::<f64>();
    let at = |k: usize| -3.0 + 6.0 * (k as f64 + 0.5) / 400.0;
    let inside =
        (0..400).flat_map(|i| (0..400).map(move |j| (i, j))).filter(|&(i, j)| value(at(i), at(j)) <= c).count();
    inside as f64 * (6.0 / 400.0f64).powi(2)
}

/// The limit cycle of the reversed van der Pol oscillator encloses an area of about 11.5 (by simulation); every proved set is within.
#[test]
fn functions_of_degree_four_prove_a_larger_region() {
    let model = "states = ['x', 'y']\ndynamics = { x = '-y', y = 'x + (x^2 - 1)*y' }";
    let areas = [2, 4].map(|d| area(found(model, &[Find::Region], d).region.unwrap().proof().unwrap()));
    assert!(areas[0] > 6.4 && areas[1] > 1.2 * areas[0] && areas[1] < 11.6, "{areas:?}");
}

/// Two masses on springs, one damper: energy falls only while the first mass moves, and no motion but rest keeps it still.
#[test]
fn a_single_damper_stops_all_masses() {
    let model =
        "states = ['x', 'y', 'v', 'w']\ndynamics = { x = 'v', y = 'w', v = '-x - (x - y) - v', w = '-y - (y - x)' }";
    let damped = found(model, &[Find::Lyapunov], 2);
    assert_eq!(conclusion(&damped), Some(Conclusion::GloballyAsymptoticallyStable));
    let model = "states = ['x', 'y', 'v', 'w']\ndynamics = { x = 'v', y = 'w', v = '-x - x^3 - (x - y) - v^3', w = '-y - (y - x)' }";
    let cubic = found(model, &[Find::Lyapunov], 4);
    assert_eq!(conclusion(&cubic), Some(Conclusion::GloballyAsymptoticallyStable));
    // Masses without coupling: the second one swings on.
    let model = "states = ['x', 'y', 'v', 'w']\ndynamics = { x = 'v', y = 'w', v = '-x - v', w = '-y' }";
    assert_eq!(conclusion(&found(model, &[Find::Lyapunov], 2)), Some(Conclusion::Stable));
}

#[test]
fn unstable_systems_are_refuted() {
    let found = found("states = ['x', 'y']\ndynamics = { x = 'x + y', y = '-y' }", &[Find::Lyapunov, Find::Region], 4);
    for finding in [found.lyapunov.unwrap(), found.region.unwrap()] {
        assert!(matches!(
            finding,
            bracketry_certify::Finding::NotProved(CertificateReason::Unstable { eigenvalues: 1 })
        ));
    }
}

#[test]
fn feedback_closes_the_loop_at_a_shifted_point() {
    let model = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'x^2 + u' }\npoint = { x = 1, u = -1 }";
    let closed =
        with_feedback(&System::parse("m", model).unwrap(), &["u=-x^2 - (x - 1)^3 - (x - 1)".to_owned()]).unwrap();
    let found = certify(&closed, &CertifyOptions::default()).unwrap();
    assert_eq!(conclusion(&found), Some(Conclusion::GloballyAsymptoticallyStable));
    let proof = found.lyapunov.unwrap();
    assert!(matches!(proof.proof().unwrap().certificate.claim, Claim::Lyapunov { .. }));
}

/// A delayed feedback is another system, and a range is not silently forgotten.
#[test]
fn delays_and_ranges_of_a_feedback_are_respected() {
    let with = |more: &str| {
        let model = format!("states = ['x']\ninputs = ['u']\n{more}\ndynamics = {{ x = 'x + u' }}");
        let closed = with_feedback(&System::parse("m", &model).unwrap(), &["u=-2*x".to_owned()]).unwrap();
        certify(&closed, &CertifyOptions { find: vec![Find::Lyapunov], ..CertifyOptions::default() }).unwrap()
    };
    assert_eq!(conclusion(&with("")), Some(Conclusion::GloballyAsymptoticallyStable));
    let delayed = with("delays = { u = 0.1 }");
    assert!(matches!(delayed.not_polynomial, Some(CertificateReason::InputDelay { .. })), "{delayed:?}");
    assert_eq!(with("ranges = { u = { min = -1, max = 1 } }").ignored_ranges, ["u"]);
}

/// Thirty states are too many: said at once.
#[test]
fn large_models_are_answered_in_time() {
    let n = 30;
    let states: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
    let list: Vec<String> = (0..n).map(|i| format!("x{i} = '-x{i} - x{i}^3 + x{}^2'", (i + 1) % n)).collect();
    let start = std::time::Instant::now();
    let model = format!("states = [{}]\ndynamics = {{ {} }}", states.join(", "), list.join(", "));
    let found = found(&model, &[Find::Lyapunov, Find::Region, Find::Conserved], 2);
    assert!(found.lyapunov.unwrap().proof().is_none() && start.elapsed().as_secs() < 10);
}
