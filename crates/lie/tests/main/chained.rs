//! Chained forms: published systems, systems that are chained by construction, and systems that are not.

use crate::common::{ratio, system};
use bracketry_lie::analysis::mode_fields;
use bracketry_lie::forms::{ChainedForm, ChainedForms, NoChainedForm};
use bracketry_lie::{Evidence, VectorFields};
use bracketry_symbolic::{Expr, Pool};
use bracketry_system::System;
use rustc_hash::FxHashMap;

fn model(name: &str) -> System {
    System::read(format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn forms(s: &mut System) -> (VectorFields, ChainedForms) {
    let fields = mode_fields(s).unwrap().remove(0).fields;
    let known: Vec<Expr> = s.outputs.iter().map(|o| o.1).collect();
    let found = fields.chained_forms(&mut s.pool, &known, &mut Evidence::default()).unwrap();
    (fields, found)
}

fn is_zero(pool: &mut Pool, fields: &VectorFields, e: Expr) -> bool {
    pool.zero_test(e, &fields.bindings).is_zero()
}

/// z1' = v1, z2' = v2, zk' = z(k−1) v1 with v = B u, and T(x(z)) = z.
fn verify(pool: &mut Pool, fields: &VectorFields, form: &ChainedForm) {
    let n = fields.states.len();
    for (j, g) in fields.controls.iter().enumerate() {
        for k in 0..n {
            let rate = pool.lie_derivative(form.coordinates[k], &fields.states, g);
            let wanted = match k {
                0 | 1 => form.input_matrix[k][j],
                _ => pool.mul(form.coordinates[k - 1], form.input_matrix[0][j]),
            };
            let difference = pool.sub(rate, wanted);
            assert!(is_zero(pool, fields, difference), "z{} along g{}", k + 1, j + 1);
        }
    }
    if let Some(inverse) = &form.inverse {
        let map: FxHashMap<Expr, Expr> = fields.states.iter().zip(inverse).map(|(&s, &e)| (pool.sym(s), e)).collect();
        for (&z, &s) in form.coordinates.iter().zip(&form.symbols) {
            let (back, new) = (pool.substitute(z, &map), pool.sym(s));
            let difference = pool.sub(back, new);
            assert!(is_zero(pool, fields, difference));
        }
    }
}

#[test]
fn vehicles_and_the_rolling_disk_have_chained_forms_that_verify() {
    for name in ["unicycle", "kinematic_car", "car_with_trailers", "rolling_disk", "brockett_integrator"] {
        let mut s = model(name);
        let (fields, found) = forms(&mut s);
        assert_eq!(found.reason, None, "{name}");
        for form in &found.forms {
            verify(&mut s.pool, &fields, form);
        }
        assert!(found.forms[0].singular_factors.is_some(), "{name}");
        assert!(found.forms[0].inverse.is_some(), "{name} has no inverse in closed form");
    }
}

#[test]
fn the_chained_form_of_the_unicycle_with_its_heading_first_is_singular_nowhere() {
    let mut s = model("unicycle");
    let (_, found) = forms(&mut s);
    let best = &found.forms[0];
    assert!(best.singular_set(&s.pool).unwrap().is_nowhere());
    assert_eq!(s.pool.text(best.coordinates[0]), "th");
    assert!(best.inverse.is_some());
}

/// Murray and Sastry 1993, example 3: z = (x, sec³θ tanφ/l, tanθ, y) for the car with front steering.
#[test]
fn the_published_chained_form_of_the_car_is_among_those_found() {
    let mut s = system(
        &["x", "y", "phi", "th"],
        &["u1", "u2"],
        &[("l", ratio(2, 1))],
        &["u1*cos(th)", "u1*sin(th)", "u2", "u1*tan(phi)/l"],
        &[],
        None,
    );
    let (fields, found) = forms(&mut s);
    let published = ["x", "tan(phi)/(l*cos(th)^3)", "tan(th)", "y"].map(|e| s.pool.parse(e).unwrap());
    let same = |pool: &mut Pool, form: &ChainedForm| {
        form.coordinates.iter().zip(published).all(|(&a, b)| {
            let difference = pool.sub(a, b);
            is_zero(pool, &fields, difference)
        })
    };
    assert!(found.forms.iter().any(|form| same(&mut s.pool, form)));
}

/// Murray and Sastry 1993, section 4: the hopping robot in flight with zero angular momentum.
#[test]
fn the_hopping_robot_has_a_chained_form() {
    let mut s = system(
        &["psi", "l", "th"],
        &["u1", "u2"],
        &[("m", ratio(1, 2)), ("d", ratio(1, 1))],
        &["u1", "u2", "-m*(l + d)^2/(1 + m*(l + d)^2)*u1"],
        &[],
        None,
    );
    let (fields, found) = forms(&mut s);
    assert_eq!(found.reason, None);
    verify(&mut s.pool, &fields, &found.forms[0]);
}

/// x' = g1 u1 + g2 u2 made of the chain by a triangular change of coordinates and a triangular feedback with coefficients
/// from a linear congruence.
#[test]
fn chains_in_other_coordinates_and_inputs_are_found() {
    let mut seed = 7u64;
    let mut number = |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % most
    };
    for n in [3usize, 4, 5, 6] {
        // x1 = z1, x2 = z2, xk = zk + c z1 x(j), so that zk = xk − c x1 xj with j < k; v1 = u1, v2 = u2 + a xj u1.
        let mut z = vec!["x1".to_owned(), "x2".to_owned()];
        let mut rates = vec!["u1".to_owned(), format!("(u2 + {}*x{n}*u1)", 1 + number(3))];
        for k in 3..=n {
            let (c, j) = (1 + number(4), 1 + number(k as u64 - 1));
            z.push(format!("(x{k} - {c}*x1*x{j})"));
            let before = z[k - 2].clone();
            rates.push(format!("({before}*u1 + {c}*(u1*x{j} + x1*{}))", rates[j as usize - 1]));
        }
        let names: Vec<String> = (1..=n).map(|k| format!("x{k}")).collect();
        let states: Vec<&str> = names.iter().map(String::as_str).collect();
        let rates: Vec<&str> = rates.iter().map(String::as_str).collect();
        let mut s = system(&states, &["u1", "u2"], &[], &rates, &[], None);
        let (fields, found) = forms(&mut s);
        assert_eq!(found.reason, None, "{n}: {s:?}");
        for form in &found.forms {
            verify(&mut s.pool, &fields, form);
        }
    }
}

#[test]
fn other_flags_drift_and_other_numbers_of_inputs_have_no_chained_form() {
    // Growth 2, 3, 5 (Cartan 1910).
    let mut five = system(
        &["x1", "x2", "x3", "x4", "x5"],
        &["u1", "u2"],
        &[],
        &["u1", "u2", "x1*u2", "x1^2*u2", "x1*x2*u2"],
        &[],
        None,
    );
    let dimensions = vec![2, 3, 5];
    assert_eq!(forms(&mut five).1.reason, Some(NoChainedForm::DerivedFlag { dimensions }));
    let mut drift = system(&["x", "y"], &["u", "v"], &[], &["u + y", "v"], &[], None);
    assert_eq!(forms(&mut drift).1.reason, Some(NoChainedForm::Drift));
    let mut three = system(&["x", "y", "z"], &["u", "v", "w"], &[], &["u", "v", "w"], &[], None);
    assert_eq!(forms(&mut three).1.reason, Some(NoChainedForm::Inputs { independent: 3 }));
    let mut dependent = system(&["x", "y", "z"], &["u", "v"], &[], &["u + v", "x*(u + v)", "0"], &[], None);
    assert_eq!(forms(&mut dependent).1.reason, Some(NoChainedForm::Inputs { independent: 1 }));
}
