//! First integrals of distributions, against functions known by hand.

use crate::common::{answered, ellipse, fields, ratio, system, texts};
use bracketry_lie::algebra::{Integrals, adjoint, integrals, involutive_closure};
use bracketry_lie::{AnalysisOptions, Answer, Evidence, Field, analyze_affine};
use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};

/// A distribution from text, with the states of the space.
struct Distribution {
    pool: Pool,
    states: Vec<Symbol>,
    fields: Vec<Field>,
}

fn distribution(states: &str, fields: &[&str]) -> Distribution {
    let mut pool = Pool::new();
    let states = states.split_whitespace().map(|s| pool.symbol(s)).collect();
    let fields = fields.iter().map(|f| f.split(',').map(|c| pool.parse(c.trim()).unwrap()).collect()).collect();
    Distribution { pool, states, fields }
}

impl Distribution {
    fn integrals(&mut self) -> Integrals {
        self.integrals_with(&Bindings::new())
    }

    fn integrals_with(&mut self, bindings: &Bindings) -> Integrals {
        let evidence = &mut Evidence::default();
        integrals(&mut self.pool, &self.states, &self.fields, &[], bindings, evidence).unwrap()
    }

    /// All of them, as text.
    fn all(&mut self) -> Vec<String> {
        let found = self.integrals();
        assert_eq!(found.missing, 0, "{:?}", texts(&self.pool, &found.functions));
        texts(&self.pool, &found.functions)
    }

    /// Whether `text` is a function of the integrals that were found.
    fn finds(&mut self, text: &str) -> bool {
        let found = self.integrals();
        let wanted = self.pool.parse(text).unwrap();
        for field in self.fields.clone() {
            let along = self.pool.lie_derivative(wanted, &self.states, &field);
            assert!(self.pool.zero_test(along, &Bindings::new()).is_zero(), "{text} is no integral");
        }
        let mut all: Vec<Vec<Expr>> =
            found.functions.iter().map(|&phi| self.pool.gradient(phi, &self.states)).collect();
        all.push(self.pool.gradient(wanted, &self.states));
        self.pool.rank(&all, &Bindings::new()).unwrap().rank == found.functions.len()
    }
}

#[test]
fn states_and_their_combinations_come_first() {
    assert_eq!(distribution("q1 v1 q2 v2", &["0,0,0,1", "0,0,1,0", "0,1,0,0"]).all(), ["q1"]);
    assert_eq!(distribution("q1 q2 q3", &["1,-1,0", "0,1,-1"]).all(), ["q1 + q2 + q3"]);
}

#[test]
fn parameters_stay_symbols() {
    // Centers of oscillation of a planar VTOL aircraft, a rolling car and a pendulum on a cart.
    assert_eq!(distribution("x y th", &["ep*cos(th),ep*sin(th),1"]).all(), ["x - ep*sin(th)", "ep*cos(th) + y"]);
    assert_eq!(distribution("x th", &["l*cos(th),-1"]).all(), ["l*sin(th) + x"]);
    let g = "0,0,1/(M + m*sin(th)^2),-cos(th)/(l*(M + m*sin(th)^2))";
    assert_eq!(distribution("x th v w", &[g]).all(), ["x", "th", "l*w + v*cos(th)"]);
    assert_eq!(distribution("x v", &["mu/2,1"]).all(), ["2*x - mu*v"]);
}

#[test]
fn a_given_value_does_not_replace_its_parameter() {
    let mut d = distribution("x v", &["mu/2,1"]);
    let mut bindings = Bindings::new();
    bindings.bind(d.pool.symbol("mu"), ratio(3, 10));
    let found = d.integrals_with(&bindings).functions;
    assert_eq!(texts(&d.pool, &found), ["2*x - mu*v"]);
}

#[test]
fn an_integral_that_exists_only_at_the_given_value_is_found_there() {
    // The bracket is (a − b) ∂z: for a = b the two fields commute.
    let mut d = distribution("x y z", &["1,0,a*y", "0,1,b*x"]);
    assert_eq!(d.all(), Vec::<String>::new());
    let mut bindings = Bindings::new();
    for name in ["a", "b"] {
        bindings.bind(d.pool.symbol(name), ratio(3, 2));
    }
    let found = d.integrals_with(&bindings);
    assert_eq!((texts(&d.pool, &found.functions), found.missing), (vec!["2*z - 3*x*y".to_owned()], 0));
}

#[test]
fn coefficients_are_rational_functions_of_the_parameters() {
    // The momentum conjugate to the joint without torque, with all of its inertias.
    let g = "0,0,-(I2 + m2*lc2^2 + m2*l1*lc2*cos(q2)),I1 + I2 + m2*l1^2 + 2*m2*l1*lc2*cos(q2)";
    let momentum = "(I1 + I2 + m2*l1^2 + 2*m2*l1*lc2*cos(q2))*w1 + (I2 + m2*lc2^2 + m2*l1*lc2*cos(q2))*w2";
    let mut d = distribution("q1 q2 w1 w2", &[g]);
    let found = d.all();
    assert_eq!(found[..2], ["q1", "q2"]);
    assert!(d.finds(momentum));
    let parsed = d.pool.parse(momentum).unwrap();
    let shown = d.pool.parse(&found[2]).unwrap();
    let difference = d.pool.sub(parsed, shown);
    assert!(d.pool.zero_test(difference, &Bindings::new()).is_zero(), "{}", found[2]);
}

#[test]
fn constants_of_motion_of_mechanics() {
    let rigid = "(I2-I3)/I1*w2*w3,(I3-I1)/I2*w3*w1,(I1-I2)/I3*w1*w2";
    let mut d = distribution("w1 w2 w3", &[rigid]);
    assert_eq!(d.integrals().missing, 0);
    assert!(d.finds("I1*w1^2 + I2*w2^2 + I3*w3^2") && d.finds("I1^2*w1^2 + I2^2*w2^2 + I3^2*w3^2"));
    assert_eq!(distribution("q w", &["w,-g/l*sin(q)"]).all(), ["2*g*cos(q) - l*w^2"]);
    let mut kepler = distribution("x y vx vy", &["vx,vy,-mu*x/(x^2+y^2)^(3/2),-mu*y/(x^2+y^2)^(3/2)"]);
    assert!(kepler.finds("x*vy - y*vx") && kepler.finds("(vx^2 + vy^2)/2 - mu/sqrt(x^2 + y^2)"));
}

#[test]
fn products_ratios_and_powers() {
    assert_eq!(distribution("x1 x2", &["x1,-x2"]).all(), ["x1*x2"]);
    assert_eq!(distribution("x1 x2", &["k*x1,x2"]).all(), ["log(x1) - k*log(x2)"]);
    assert_eq!(distribution("x y z", &["x,y,2*z"]).all(), ["x/y", "x^2/z"]);
    assert_eq!(distribution("x y", &["x + a,y + b"]).all(), ["(x + a)/(y + b)"]);
    assert_eq!(distribution("x y z", &["0,-z,y", "z,0,-x"]).all(), ["x^2 + y^2 + z^2"]);
    // Isidori 1995, example 4.2.5.
    assert_eq!(distribution("x1 x2 x3", &["0,1 + x2,-x3"]).all(), ["x1", "x2*x3 + x3"]);
}

#[test]
fn quadratures_and_integrating_factors() {
    assert_eq!(distribution("x y", &["1,tan(x)"]).all(), ["y + log(cos(x))"]);
    assert_eq!(distribution("x y", &["1,1/(1 + x^2)"]).all(), ["y - atan(x)"]);
    assert_eq!(distribution("x y", &["1,1/cos(x)^2"]).all(), ["sin(x)/cos(x) - y"]);
    assert_eq!(distribution("x y", &["1,x*y"]).all(), ["x^2 - 2*log(y)"]);
    let mut linear = distribution("t y", &["1,a*y + t"]);
    assert!(linear.finds("(a^2*y + a*t + 1)*exp(-a*t)"));
    let mut turning = distribution("x y th", &["-y,x,om"]);
    assert!(turning.finds("x^2 + y^2") && turning.finds("th - om*atan(y/x)"));
    let mut epidemic = distribution("S I R", &["-be*S*I,be*S*I - ga*I,ga*I"]);
    assert!(epidemic.finds("S + I + R") && epidemic.finds("S + I - ga/be*log(S)"));
    assert!(distribution("x y", &["x*(a - b*y),y*(c*x - d)"]).finds("c*x - d*log(x) + b*y - a*log(y)"));
}

#[test]
fn what_has_no_closed_form_is_counted() {
    let mut d = distribution("x1 x2 x3", &["x1*x2,x2*x3,x1*x3"]);
    let found = d.integrals();
    assert_eq!(found.functions.len() + found.missing, 2);
    assert!(found.missing > 0);
}

/// The arm with an elastic joint of Marino & Spong 1986: the link angle linearizes it.
#[test]
fn the_linearizing_output_of_a_flexible_joint() {
    let mut s = system(
        &["q1", "v1", "q2", "v2"],
        &["u"],
        &[],
        &["v1", "-(m*g*l*sin(q1) + k*(q1 - q2))/I", "v2", "(k*(q1 - q2) + u)/J"],
        &[],
        None,
    );
    let v = fields(&mut s);
    let d: Vec<Field> = (0..3).map(|k| adjoint(&mut s.pool, &v.states, &v.drift, &v.controls[0], k)).collect();
    let found = integrals(&mut s.pool, &v.states, &d, &v.drift, &v.bindings, &mut Evidence::default()).unwrap();
    assert_eq!(texts(&s.pool, &found.functions), ["q1"]);
}

#[test]
fn the_closure_of_two_fields_of_heisenberg_is_everything() {
    let mut d = distribution("x y z", &["1,0,-y/2", "0,1,x/2"]);
    let evidence = &mut Evidence::default();
    let closure = involutive_closure(&mut d.pool, &d.states, &d.fields, &Bindings::new(), evidence).unwrap();
    assert_eq!(closure.growth, [2, 3]);
    assert_eq!(d.integrals(), Integrals { functions: Vec::new(), missing: 0 });
    // Rotations about two axes generate those about the third, tangent to the same spheres.
    let mut d = distribution("x y z", &["0,-z,y", "z,0,-x"]);
    let closure = involutive_closure(&mut d.pool, &d.states, &d.fields, &Bindings::new(), evidence).unwrap();
    assert_eq!(closure.growth, [2, 2]);
}

#[test]
fn lenhart_leaves_a_product_to_itself() {
    let r = analyze_affine(
        &system(&["x1", "x2"], &["u"], &[], &["x1*u", "x2 - x2*u"], &[], None),
        &AnalysisOptions::default(),
    );
    assert_eq!(answered(&r.unwrap().modes[0].autonomous), Answer::Known(vec!["x1*x2".into()]));
}

/// Per mode the object's absolute position and velocity follow friction of constant direction; that direction changes.
#[test]
fn switching_of_friction_reaches_what_no_mode_reaches() {
    let s = analyze_affine(&ellipse(None), &AnalysisOptions::default()).unwrap().switched.unwrap();
    let list = s.only_by_switching.known().unwrap();
    let found: Vec<_> = list.iter().map(|f| (f.function.to_string(), f.modes.len())).collect();
    assert_eq!(found, [("x + X".to_owned(), 4), ("vx + Xd".to_owned(), 4)]);
    assert_eq!(list[1].reached_by.to_string(), "f(3)-f(1)");
    assert_eq!(list[0].reached_by.to_string(), "[f(1),f(3)-f(1)]");
    assert_eq!(answered(&s.autonomous), Answer::Known(Vec::new()));
}

/// Two masses that exchange momentum through a dry joint, which a third velocity switches: switching moves the difference,
/// never the sum. Where the masses themselves decide, nothing is chosen.
#[test]
fn what_all_modes_conserve_stays_conserved_by_switching() {
    let c = [("c", ratio(1, 2))];
    let model = system(&["p", "q", "r"], &["u"], &c, &["-c*sign(r)", "c*sign(r)", "u"], &[], None);
    let s = analyze_affine(&model, &AnalysisOptions::default()).unwrap().switched.unwrap();
    assert_eq!(answered(&s.autonomous), Answer::Known(vec!["p + q".into()]));
    let list = s.only_by_switching.known().unwrap();
    let reached: Vec<String> = list.iter().map(|f| f.function.to_string()).collect();
    assert_eq!(reached, ["p", "q"]);
    assert_eq!(list[0].reached_by.to_string(), "f(2)-f(1)");
    let model = system(&["p", "q"], &[], &c, &["-c*sign(p - q)", "c*sign(p - q)"], &[], None);
    let s = analyze_affine(&model, &AnalysisOptions::default()).unwrap().switched.unwrap();
    assert!(answered(&s.autonomous).known().unwrap().contains(&"p + q".to_owned()));
    assert_eq!(s.only_by_switching, Answer::Known(Vec::new()));
}

#[test]
fn the_closure_of_the_input_fields_is_reported() {
    let closure = |dynamics: &[&str]| {
        let r = analyze_affine(
            &system(&["x", "y", "z"], &["u", "v"], &[], dynamics, &[], None),
            &AnalysisOptions::default(),
        );
        r.unwrap().involutive_closure
    };
    let Answer::Known(unicycle) = closure(&["u*cos(z)", "u*sin(z)", "v"]) else { panic!("a closure") };
    assert_eq!((unicycle.dimension, unicycle.growth), (3, vec![2, 3]));
    assert_eq!(unicycle.basis.iter().map(ToString::to_string).collect::<Vec<_>>(), ["g1", "g2", "[g1,g2]"]);
    let Answer::Known(flat) = closure(&["u", "v + z", "u*y + v*x"]) else { panic!("a closure") };
    assert_eq!((flat.dimension, flat.integrals_not_found), (2, None));
    assert_eq!(flat.integrals, ["z - x*y"]);
}
