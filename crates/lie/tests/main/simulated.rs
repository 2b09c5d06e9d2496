//! Trajectories of a system and of its transformed form, compared.

use bracketry_lie::forms::{Form, NormalForm, TransformOptions, Transformation};
use bracketry_lie::transform;
use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::System;
use rand_like::Lcg;
use rustc_hash::FxHashMap;

/// A small generator of numbers, so that families of systems are the same in every run.
pub(crate) mod rand_like {
    pub(crate) struct Lcg(pub(crate) u64);

    impl Lcg {
        pub(crate) fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            self.0 >> 33
        }

        /// From −size to size.
        pub(crate) fn int(&mut self, size: i64) -> i64 {
            self.next() as i64 % (2 * size + 1) - size
        }

        pub(crate) fn below(&mut self, n: usize) -> usize {
            self.next() as usize % n
        }
    }
}

/// A model of the repository.
pub(crate) fn model(name: &str) -> System {
    System::read(format!("../../models/{name}.toml")).unwrap()
}

pub(crate) fn parsed(text: &str) -> System {
    System::parse("m", text).unwrap()
}

pub(crate) fn to(system: &System, form: Form) -> Transformation {
    transform(system, form, &TransformOptions::default()).unwrap()
}

pub(crate) fn found(system: &System, form: Form) -> NormalForm {
    let result = to(system, form);
    match result.found() {
        Some(found) => found.clone(),
        None => panic!("{:?} of {:?}: {:?}", form, system, result.outcome),
    }
}

/// A field with inputs as functions of time, integrated by the classical method of order four.
fn integrate(tape: &Tape, start: &[f64], inputs: impl Fn(f64) -> Vec<f64>, steps: usize, h: f64) -> Vec<Vec<f64>> {
    let n = start.len();
    let mut work = Vec::new();
    let mut rate = |x: &[f64], t: f64| {
        let mut out = vec![0.0; n];
        let arguments: Vec<f64> = x.iter().copied().chain(inputs(t)).collect();
        tape.eval(&arguments, &mut work, &mut out);
        out
    };
    let mut all = vec![start.to_vec()];
    for k in 0..steps {
        let (t, x) = (k as f64 * h, all[k].clone());
        let step = |x: &[f64], d: &[f64], h: f64| -> Vec<f64> { x.iter().zip(d).map(|(a, b)| a + h * b).collect() };
        let a = rate(&x, t);
        let b = rate(&step(&x, &a, h / 2.0), t + h / 2.0);
        let c = rate(&step(&x, &b, h / 2.0), t + h / 2.0);
        let d = rate(&step(&x, &c, h), t + h);
        all.push((0..n).map(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i])).collect());
    }
    all
}

fn evaluated(system: &System, arguments: &[Symbol], expressions: &[Expr], at: &[f64]) -> Vec<f64> {
    let tape = system.compile(arguments, expressions).unwrap();
    let mut out = vec![0.0; expressions.len()];
    tape.eval(at, &mut Vec::new(), &mut out);
    out
}

/// Inputs that excite every motion.
fn excitation(m: usize) -> impl Fn(f64) -> Vec<f64> {
    move |t| (0..m).map(|j| 0.4 * (3.1 * t + 1.3 * j as f64).sin() + 0.15 * (7.3 * t - j as f64).cos()).collect()
}

/// The original (with the feedback, if there is one) and the form, both from `x0` with the same inputs: z(t) = T(x(t)),
/// x(t) = S(z(t)), and the outputs of both are the same, within 1e-8. The form is read back from the text of its model file.
pub(crate) fn assert_same_motion(system: &System, form: &NormalForm, x0: &[f64]) {
    let mut old = system.clone();
    let new = System::parse("form", &form.system.to_toml().unwrap()).unwrap();
    let law: FxHashMap<Expr, Expr> =
        form.feedback.0.iter().map(|(u, e)| (old.pool.var(u), e.copied_into(&mut old.pool))).collect();
    let closed = old.pool.substitute_all(&old.dynamics.clone(), &law);
    let outputs: Vec<Expr> = old.outputs.iter().map(|o| o.1).collect();
    let outputs = old.pool.substitute_all(&outputs, &law);
    let inputs: Vec<Symbol> = new.input_names().iter().map(|u| old.pool.symbol(u)).collect();
    let coordinates: Vec<Expr> = form.coordinates.0.iter().map(|(_, t)| t.copied_into(&mut old.pool)).collect();
    let arguments: Vec<Symbol> = old.states.iter().chain(&inputs).copied().collect();
    let (steps, h) = (400, 1e-3);
    let v = excitation(inputs.len());
    let x = integrate(&old.compile(&arguments, &closed).unwrap(), x0, &v, steps, h);
    let z0 = evaluated(&old, &old.states.clone(), &coordinates, x0);
    let new_arguments: Vec<Symbol> = new.states.iter().chain(&new.inputs).copied().collect();
    let z = integrate(&new.compile(&new_arguments, &new.dynamics).unwrap(), &z0, &v, steps, h);
    for k in [steps / 2, steps] {
        let t = k as f64 * h;
        let image = evaluated(&old, &old.states.clone(), &coordinates, &x[k]);
        close(&image, &z[k], "z(t) = T(x(t))");
        if let Some(inverse) = &form.inverse {
            let mut made = new.clone();
            let back: Vec<Expr> = inverse.0.iter().map(|(_, s)| s.copied_into(&mut made.pool)).collect();
            close(&evaluated(&made, &new.states, &back, &z[k]), &x[k], "x(t) = S(z(t))");
        }
        let at_old: Vec<f64> = x[k].iter().copied().chain(v(t)).collect();
        let at_new: Vec<f64> = z[k].iter().copied().chain(v(t)).collect();
        let y_old = evaluated(&old, &arguments, &outputs, &at_old);
        for (name, e) in &new.outputs {
            let place = old.outputs.iter().position(|o| o.0 == *name).unwrap();
            close(&evaluated(&new, &new_arguments, &[*e], &at_new), &[y_old[place]], name);
        }
    }
}

fn close(a: &[f64], b: &[f64], what: &str) {
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= 1e-8 * (1.0 + x.abs()), "{what}: {a:?} and {b:?}");
    }
}

/// A system in new coordinates x = Φ(z) that are triangular polynomials of the given ones, with new inputs v = a(z) + b u:
/// its model text, with the states x1, x2, … in another order. `dynamics` and `outputs` are of z1, z2, …, v1, v2, …
pub(crate) fn disguised(
    dynamics: &[&str],
    inputs: usize,
    outputs: &[(&str, &str)],
    feedback: bool,
    seed: u64,
) -> System {
    let mut lcg = Lcg(seed.wrapping_mul(0x9E37_79B9).wrapping_add(7));
    let n = dynamics.len();
    let mut pool = bracketry_symbolic::Pool::new();
    let z: Vec<Symbol> = (1..=n).map(|i| pool.symbol(&format!("z{i}"))).collect();
    let x: Vec<Expr> = (1..=n).map(|i| pool.var(&format!("x{i}"))).collect();
    let mut order: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        order.swap(i, lcg.below(i + 1));
    }
    // x_i = z_i + p_i(z that come before i in the order), and back.
    let (mut phi, mut back) = (vec![x[0]; n], FxHashMap::default());
    for (place, &i) in order.iter().enumerate() {
        let mut p = pool.int(0);
        if place > 0 {
            for _ in 0..2 {
                let (a, b) = (order[lcg.below(place)], order[lcg.below(place)]);
                let c = pool.int(lcg.int(2));
                let (za, zb) = (pool.sym(z[a]), pool.sym(z[b]));
                let product = if lcg.below(2) == 0 { pool.mul(za, zb) } else { za };
                let term = pool.mul(c, product);
                p = pool.add(p, term);
            }
        }
        let zi = pool.sym(z[i]);
        phi[i] = pool.add(zi, p);
        let at_x = pool.substitute(p, &back);
        let value = pool.sub(x[i], at_x);
        back.insert(zi, value);
    }
    let rates: Vec<Expr> = dynamics.iter().map(|e| pool.parse(e).unwrap()).collect();
    let law: FxHashMap<Expr, Expr> = (1..=inputs)
        .map(|j| {
            let (v, u) = (pool.var(&format!("v{j}")), pool.var(&format!("u{j}")));
            let a = pool.sym(z[lcg.below(n)]);
            let square = pool.powi(a, 2);
            let two = pool.int(2);
            let gain = pool.add(square, two);
            let product = pool.mul(gain, u);
            let other = pool.sym(z[lcg.below(n)]);
            let product = if feedback { pool.add(product, other) } else { u };
            (v, product)
        })
        .collect();
    let rates = pool.substitute_all(&rates, &law);
    let list = |items: Vec<String>| items.join(", ");
    let mut lines = Vec::new();
    for (i, &e) in phi.iter().enumerate() {
        let rate = pool.lie_derivative(e, &z, &rates);
        let rate = pool.substitute(rate, &back);
        lines.push(format!("x{} = '{}'", i + 1, pool.text(rate)));
    }
    let mut out = Vec::new();
    for (name, h) in outputs {
        let h = pool.parse(h).unwrap();
        let h = pool.substitute(h, &back);
        out.push(format!("{name} = '{}'", pool.text(h)));
    }
    parsed(&format!(
        "states = [{}]\ninputs = [{}]\n[dynamics]\n{}\n[outputs]\n{}\n",
        list((1..=n).map(|i| format!("'x{i}'")).collect()),
        list((1..=inputs).map(|j| format!("'u{j}'")).collect()),
        lines.join("\n"),
        out.join("\n")
    ))
}
