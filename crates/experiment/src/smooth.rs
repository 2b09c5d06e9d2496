//! A model as it is planned with: smooth, and without delays. What is reported comes from exact simulations.

use crate::setup::start;
use bracketry_symbolic::{Expr, Rational};
use bracketry_system::System;

/// Lags in the place of a delay: their step response rises where the delay ends.
const LAGS: usize = 3;
/// Width of a smoothed sign, as a share of what its argument typically is. A quarter of it makes no plan fail, and of narrower ones many; what
/// is reported is exact.
const WIDTH: f64 = 0.25;
/// The width where nothing is known of the argument.
const UNKNOWN_WIDTH: f64 = 0.01;

/// A smooth model with its state at the start.
#[derive(Clone)]
pub(crate) struct Smooth {
    pub(crate) system: System,
    pub(crate) x0: Vec<f64>,
}

impl Smooth {
    /// The model with lags for delays and with smoothed signs; `typical` are states that a run passes through.
    pub(crate) fn new(system: &System, rest: &[f64], typical: &[Vec<f64>]) -> Self {
        let mut system = system.clone();
        let mut x0 = start(&system);
        if !system.is_smooth() {
            let width = width(&system, rest, typical);
            // A width is a positive number.
            let width = system.pool.rational(Rational::try_from(width).unwrap_or(Rational::ONE));
            system = system.smoothed(width);
        }
        lag(&mut system, &mut x0, rest);
        Self { system, x0 }
    }
}

/// The width of smoothed signs: a share of the least of the sizes of their arguments over the states given.
fn width(system: &System, rest: &[f64], typical: &[Vec<f64>]) -> f64 {
    let mut system = system.clone();
    let form = system.set_valued_form();
    // Signs within the argument of another one count as zero.
    let signs: Vec<_> = form.signs().iter().map(|s| s.sign).collect();
    let surfaces: Vec<Expr> = form.signs().iter().map(|s| s.surface).collect();
    let arguments: Vec<_> = system.states.iter().chain(&system.inputs).copied().chain(signs.iter().copied()).collect();
    let Ok(tape) = system.compile(&arguments, &surfaces) else { return UNKNOWN_WIDTH };
    let mut squares = vec![0.0; surfaces.len()];
    let (mut work, mut out) = (Vec::new(), vec![0.0; surfaces.len()]);
    for x in typical {
        let at: Vec<f64> = x.iter().chain(rest).copied().chain(signs.iter().map(|_| 0.0)).collect();
        tape.eval(&at, &mut work, &mut out);
        squares.iter_mut().zip(&out).for_each(|(s, v)| *s += v * v / typical.len() as f64);
    }
    let sizes = squares.into_iter().map(f64::sqrt).filter(|s| s.is_finite() && *s > 0.0);
    let least = sizes.fold(f64::INFINITY, f64::min);
    if least.is_finite() { WIDTH * least } else { UNKNOWN_WIDTH }
}

/// Puts lags in the place of the delays of inputs.
fn lag(system: &mut System, x0: &mut Vec<f64>, rest: &[f64]) {
    for delay in std::mem::take(&mut system.input_delays) {
        let Some(j) = system.inputs.iter().position(|u| *u == delay.input) else { continue };
        if system.value(delay.delay).is_none_or(|d| d <= 0.0) {
            continue;
        }
        let name = system.symbol_name(delay.input).to_owned();
        let (input, count) = (system.pool.sym(delay.input), system.pool.int(LAGS as i64));
        let rate = system.pool.div(count, delay.delay);
        let mut before = input;
        let mut rates = Vec::new();
        for k in 1..=LAGS {
            let state = system.pool.symbol(&format!("{name}#lag{k}"));
            let own = system.pool.sym(state);
            let gap = system.pool.sub(before, own);
            rates.push(system.pool.mul(rate, gap));
            system.states.push(state);
            x0.push(rest[j]);
            before = own;
        }
        let map = [(input, before)].into_iter().collect();
        let dynamics = system.pool.substitute_all(&system.dynamics.clone(), &map);
        system.dynamics = dynamics;
        system.dynamics.extend(rates);
        let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
        let outputs = system.pool.substitute_all(&outputs, &map);
        system.outputs.iter_mut().zip(outputs).for_each(|(o, e)| o.1 = e);
    }
}
