//! The laws of the bracket, decided exactly on random fields, and independence of coordinates.

use bracketry_lie::algebra::adjoint;
use bracketry_lie::{Evidence, Field, VectorFields, bracket};
use bracketry_symbolic::{Bindings, Expr, Pool, Symbol, ZeroTest};
use proptest::prelude::*;

const STATES: [&str; 3] = ["x", "y", "z"];

/// A random polynomial with trigonometric factors.
fn function() -> impl Strategy<Value = String> {
    let atom = prop::sample::select(vec!["x", "y", "z", "sin(x)", "cos(y)", "sin(x - z)", "exp(y)", "x*y", "z^2"]);
    prop::collection::vec((-3..=3i64, atom.clone(), atom), 1..4)
        .prop_map(|terms| terms.iter().map(|(c, a, b)| format!("({c})*{a}*{b}")).collect::<Vec<_>>().join(" + "))
}

fn field() -> impl Strategy<Value = [String; 3]> {
    [function(), function(), function()]
}

fn setup() -> (Pool, Vec<Symbol>) {
    let mut p = Pool::new();
    let s = STATES.iter().map(|n| p.symbol(n)).collect();
    (p, s)
}

fn read(p: &mut Pool, f: &[String; 3]) -> Field {
    f.iter().map(|s| p.parse(s).unwrap()).collect()
}

fn vanishes(p: &mut Pool, e: Expr) -> bool {
    matches!(p.zero_test(e, &Bindings::new()), ZeroTest::Zero(_))
}

fn sum(p: &mut Pool, list: &[Field]) -> Field {
    (0..STATES.len()).map(|i| p.sum(list.iter().map(|f| f[i]).collect::<Vec<_>>())).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_bracket_is_antisymmetric(a in field(), b in field()) {
        let (mut p, s) = setup();
        let (a, b) = (read(&mut p, &a), read(&mut p, &b));
        let ab = bracket(&mut p, &s, &a, &b);
        let ba = bracket(&mut p, &s, &b, &a);
        for e in sum(&mut p, &[ab, ba]) {
            prop_assert!(vanishes(&mut p, e));
        }
    }

    #[test]
    fn the_jacobi_identity_holds(a in field(), b in field(), c in field()) {
        let (mut p, s) = setup();
        let (a, b, c) = (read(&mut p, &a), read(&mut p, &b), read(&mut p, &c));
        let cyclic: Vec<Field> = [(&a, &b, &c), (&b, &c, &a), (&c, &a, &b)]
            .into_iter()
            .map(|(u, v, w)| {
                let vw = bracket(&mut p, &s, v, w);
                bracket(&mut p, &s, u, &vw)
            })
            .collect();
        for e in sum(&mut p, &cyclic) {
            prop_assert!(vanishes(&mut p, e));
        }
    }

    /// [a, φb] = φ[a, b] + (a·φ) b
    #[test]
    fn the_bracket_is_a_derivation(a in field(), b in field(), phi in function()) {
        let (mut p, s) = setup();
        let (a, b) = (read(&mut p, &a), read(&mut p, &b));
        let phi = p.parse(&phi).unwrap();
        let scaled: Field = b.iter().map(|&e| p.mul(phi, e)).collect();
        let left = bracket(&mut p, &s, &a, &scaled);
        let ab = bracket(&mut p, &s, &a, &b);
        let slope = p.lie_derivative(phi, &s, &a);
        for i in 0..3 {
            let (u, v) = (p.mul(phi, ab[i]), p.mul(slope, b[i]));
            let right = p.add(u, v);
            let d = p.sub(left[i], right);
            prop_assert!(vanishes(&mut p, d));
        }
    }

    /// L_[a,b] h = L_a L_b h − L_b L_a h
    #[test]
    fn the_bracket_is_the_commutator_of_derivations(a in field(), b in field(), h in function()) {
        let (mut p, s) = setup();
        let (a, b) = (read(&mut p, &a), read(&mut p, &b));
        let h = p.parse(&h).unwrap();
        let ab = bracket(&mut p, &s, &a, &b);
        let left = p.lie_derivative(h, &s, &ab);
        let (ha, hb) = (p.lie_derivative(h, &s, &a), p.lie_derivative(h, &s, &b));
        let (u, v) = (p.lie_derivative(hb, &s, &a), p.lie_derivative(ha, &s, &b));
        let right = p.sub(u, v);
        let d = p.sub(left, right);
        prop_assert!(vanishes(&mut p, d));
    }

    /// Growth does not depend on coordinates: z = (x, y + q(x), z + r(x, y)) has a polynomial inverse.
    #[test]
    fn growth_is_invariant_under_a_change_of_coordinates(
        f in field(), g in field(), k in -3..=3i64, l in -3..=3i64, m in 1..=3i64,
    ) {
        let (mut p, s) = setup();
        let (f, g) = (read(&mut p, &f), read(&mut p, &g));
        let shear = [
            "x".to_owned(),
            format!("y + ({k})*x^2 + x"),
            format!("{m}*z + ({l})*x*y + y^2"),
        ];
        let map = read(&mut p, &shear);
        // The inverse, written in the old names.
        let old_y = p.parse(&format!("y - ({k})*x^2 - x")).unwrap();
        let x = p.var("x");
        let (y, z) = (p.var("y"), p.var("z"));
        let lxy = { let l = p.int(l); let t = p.mul(x, old_y); p.mul(l, t) };
        let square = p.powi(old_y, 2);
        let rest = p.add(lxy, square);
        let top = p.sub(z, rest);
        let m = p.int(m);
        let old_z = p.div(top, m);
        let back = [(y, old_y), (z, old_z)].into_iter().collect();
        let mut push = |v: &Field| -> Field {
            let image: Vec<Expr> = map.iter().map(|&c| p.lie_derivative(c, &s, v)).collect();
            p.substitute_all(&image, &back)
        };
        let (f2, g2) = (push(&f), push(&g));
        let mut evidence = Evidence::default();
        let before = VectorFields::new(s.clone(), f, vec![g], Bindings::new()).unwrap();
        let after = VectorFields::new(s, f2, vec![g2], Bindings::new()).unwrap();
        prop_assert_eq!(
            before.accessibility(&mut p, &mut evidence).unwrap().growth,
            after.accessibility(&mut p, &mut evidence).unwrap().growth
        );
        prop_assert_eq!(
            before.strong_accessibility(&mut p, &mut evidence).unwrap().growth,
            after.strong_accessibility(&mut p, &mut evidence).unwrap().growth
        );
    }
}

#[test]
fn repeated_adjoints_of_a_linear_system_are_powers_of_its_matrix() {
    // x' = Ax: ad_f^k b = (−A)^k b
    let (mut p, s) = setup();
    let f = read(&mut p, &["y".into(), "z".into(), "0".into()]);
    let b = read(&mut p, &["0".into(), "0".into(), "1".into()]);
    let y = adjoint(&mut p, &s, &f, &b, 2);
    assert_eq!(crate::common::texts(&p, &y), ["1", "0", "0"]);
}
