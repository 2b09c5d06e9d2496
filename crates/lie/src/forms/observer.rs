//! The observer form of one output: linear up to functions of the output and the inputs.

use bracketry_symbolic::{Expr, Symbol, Undecided as Exact};
use rustc_hash::FxHashMap;

use crate::algebra::antiderivative::antiderivative;
use crate::algebra::matrix::{generic_rank, solve};
use crate::algebra::rational::readable::tidy;
use crate::budget::check_growth;
use crate::feedback::outputs::fed_through;
use crate::forms::change::Plan;
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, FormNote, NormalForm};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::forms::root::roots;
use crate::undecided::Undecided;

/// An output with its derivatives along the drift, and the fields ∂/∂ξ_k of these coordinates.
struct Derivatives {
    /// ξ_0 = h, ξ_1 = L_f h, …, ξ_n = L_f^n h.
    xi: Vec<Expr>,
    /// ∂/∂ξ_0, …, ∂/∂ξ_(n−1).
    fields: Vec<Vec<Expr>>,
}

impl Frame {
    /// `z_k' = z_(k+1) + γ_k(z_1) + Σ u_j φ_kj(z_1)`, `z_1 = ψ(y)` (Krener and Isidori 1983, Krener and Respondek 1985, Bestle
    /// and Zeitz 1983).
    ///
    /// With y^(n) = Φ(y, …, y^(n−1)) along the drift, the form needs Φ = Σ (d/dt)^(n−k) γ_k(y). So γ_1' = ∂Φ/∂y^(n−1), γ_2' =
    /// ∂(Φ − (d/dt)^(n−1) γ_1)/∂y^(n−2), …, each a function of y: this determines all γ_k but for constants. A new output ψ(y)
    /// adds −n ψ″/ψ′ y′ to the first of these, so that ψ is determined but for scale and offset. Each failure excludes the form.
    pub(crate) fn observer(&mut self) -> Result<NormalForm, Stop> {
        let outputs = self.output_functions();
        let [h] = outputs[..] else {
            let outputs = outputs.len();
            return Err(if outputs == 0 {
                Stop::No(Obstacle::NoOutputs)
            } else {
                Stop::Unknown(Obstacle::NotSingle { outputs })
            });
        };
        if fed_through(&self.system) {
            return Err(Stop::Unknown(Obstacle::FedThrough));
        }
        let first = self.along_drift(h)?;
        let h = self.output_change(h, &first)?;
        let d = if h == first.xi[0] { first } else { self.along_drift(h)? };
        let (coordinates, injections) = self.observer_coordinates(&d)?;
        let n = coordinates.len();
        let new = self.fresh("z", n);
        let mut known = Vec::new();
        for k in 0..n {
            let mut rate =
                self.of_output(injections[k], h, new[0])?.ok_or_else(|| self.no_closed_form(injections[k]))?;
            for j in 0..self.fields.controls.len() {
                let along =
                    self.system.pool.lie_derivative(coordinates[k], &self.fields.states, &self.fields.controls[j]);
                let along = tidy(&mut self.system.pool, along);
                if !self.depends_on_output_only(along, h)? {
                    let input = self.system.symbol_name(self.system.inputs[j]).to_owned();
                    return Err(Stop::No(Obstacle::InputInjection { input, coordinate: k + 1 }));
                }
                let gain = self.of_output(along, h, new[0])?.ok_or_else(|| self.no_closed_form(along))?;
                let u = self.system.pool.sym(self.system.inputs[j]);
                let term = self.system.pool.mul(gain, u);
                rate = self.system.pool.add(rate, term);
            }
            if k + 1 < n {
                let next = self.system.pool.sym(new[k + 1]);
                rate = self.system.pool.add(next, rate);
            }
            known.push(Some(self.system.pool.simplify(rate)));
        }
        let changed = h != outputs[0];
        let notes = if changed {
            let function = bracketry_symbolic::Function::new(&self.system.pool, h);
            vec![FormNote::OutputChanged { output: self.output_names()[0].clone(), function }]
        } else {
            Vec::new()
        };
        let plan = Plan {
            coordinates,
            new,
            feedback: None,
            known,
            inverse: None,
            regular: None,
            singular: None,
            blocks: vec![(BlockKind::Observer, (0..n).collect())],
            keep_names: false,
            suffix: "observer",
            notes,
        };
        Ok(self.change(plan)?.form)
    }

    fn no_closed_form(&self, e: Expr) -> Stop {
        Stop::Unknown(Obstacle::NoClosedForm { function: bracketry_symbolic::Function::new(&self.system.pool, e) })
    }

    fn along_drift(&mut self, h: Expr) -> Result<Derivatives, Stop> {
        let n = self.fields.states.len();
        let pool = &mut self.system.pool;
        let mut xi = vec![tidy(pool, h)];
        let first = pool.len();
        for k in 0..n {
            check_growth(pool, first, [&xi[k..=k], &self.fields.drift], n)?;
            let next = pool.lie_derivative(xi[k], &self.fields.states, &self.fields.drift);
            xi.push(tidy(pool, next));
        }
        let jacobian = pool.jacobian(&xi[..n], &self.fields.states);
        let rank = generic_rank(pool, &jacobian, &self.fields.bindings, &mut self.evidence)?;
        if rank < n {
            return Err(Stop::No(Obstacle::NotObservable { rank, states: n }));
        }
        let (zero, one) = (pool.int(0), pool.int(1));
        let mut fields = Vec::new();
        for k in 0..n {
            let unit: Vec<Expr> = (0..n).map(|i| if i == k { one } else { zero }).collect();
            fields.push(solve(pool, &jacobian, &unit).ok_or(Undecided::TooLarge { nodes: pool.len() })?);
        }
        Ok(Derivatives { xi, fields })
    }

    /// ψ(h), where −n ψ″/ψ′ = ∂²Φ/∂y'∂y^(n−1).
    fn output_change(&mut self, h: Expr, d: &Derivatives) -> Result<Expr, Stop> {
        let n = d.fields.len();
        if n < 2 {
            return Ok(d.xi[0]);
        }
        let slope = self.derivative(d.xi[n], &d.fields[n - 1])?;
        let bend = self.derivative(slope, &d.fields[1])?;
        if self.is_zero(bend)?.is_some() {
            return Ok(d.xi[0]);
        }
        if !self.depends_on_output_only(bend, h)? {
            return Err(Stop::No(Obstacle::OutputInjection { order: n - 1 }));
        }
        let y = self.fresh("y", 1)[0];
        let bend = self.of_output(bend, h, y)?.ok_or_else(|| self.no_closed_form(bend))?;
        let minus = self.system.pool.ratio(-1, i64::try_from(n).unwrap_or(1));
        let exponent = self.system.pool.mul(minus, bend);
        let near = self.value_of_output(h);
        let pool = &mut self.system.pool;
        // ψ = ∫ exp ∫
        let psi = antiderivative(pool, exponent, y, near)
            .map(|a| exponential(pool, a))
            .and_then(|slope| antiderivative(pool, slope, y, near));
        let Some(psi) = psi else { return Err(self.no_closed_form(exponent)) };
        let place = pool.sym(y);
        Ok(pool.substitute(psi, &std::iter::once((place, h)).collect()))
    }

    /// The coordinates, and γ_1, …, γ_n as functions of the state.
    fn observer_coordinates(&mut self, d: &Derivatives) -> Result<(Vec<Expr>, Vec<Expr>), Stop> {
        let n = d.fields.len();
        let h = d.xi[0];
        let y = self.fresh("y", 1)[0];
        let near = self.value_of_output(h);
        let (mut z, mut gammas) = (vec![h], Vec::new());
        for k in 1..n {
            // What is left of Φ is d^(n−k+1)/dt^(n−k+1) of z_k along the drift.
            let mut left = z[k - 1];
            for _ in k..=n {
                left = self.derivative(left, &self.fields.drift.clone())?;
            }
            let slope = self.derivative(left, &d.fields[n - k])?;
            if !self.depends_on_output_only(slope, h)? {
                return Err(Stop::No(Obstacle::OutputInjection { order: n - k }));
            }
            let of_y = self.of_output(slope, h, y)?.ok_or_else(|| self.no_closed_form(slope))?;
            let pool = &mut self.system.pool;
            let Some(gamma) = antiderivative(pool, of_y, y, near) else { return Err(self.no_closed_form(of_y)) };
            let place = pool.sym(y);
            let gamma = pool.substitute(gamma, &std::iter::once((place, h)).collect());
            let along = self.derivative(z[k - 1], &self.fields.drift.clone())?;
            let next = self.system.pool.sub(along, gamma);
            z.push(tidy(&mut self.system.pool, next));
            gammas.push(gamma);
        }
        let last = self.derivative(z[n - 1], &self.fields.drift.clone())?;
        if !self.depends_on_output_only(last, h)? {
            return Err(Stop::No(Obstacle::OutputInjection { order: 0 }));
        }
        gammas.push(last);
        Ok((z, gammas))
    }

    fn derivative(&mut self, e: Expr, field: &[Expr]) -> Result<Expr, Undecided> {
        let pool = &mut self.system.pool;
        check_growth(pool, pool.len(), [&[e], field], self.fields.states.len())?;
        let d = pool.lie_derivative(e, &self.fields.states, field);
        Ok(tidy(pool, d))
    }

    /// Whether de is a multiple of dh.
    fn depends_on_output_only(&mut self, e: Expr, h: Expr) -> Result<bool, Undecided> {
        let pool = &mut self.system.pool;
        let rows = pool.jacobian(&[h, e], &self.fields.states);
        Ok(generic_rank(pool, &rows, &self.fields.bindings, &mut self.evidence)? <= 1)
    }

    /// A value that the output takes near the point.
    fn value_of_output(&self, h: Expr) -> f64 {
        let at = self.base(&[h]);
        at.and_then(|at| self.numbers(&[h], &self.fields.states, &at)).map_or(1.0, |list| list[0])
    }

    /// A function of the state that depends on h only, as a function of the symbol y = h; `None` where that has no closed form.
    fn of_output(&mut self, e: Expr, h: Expr, y: Symbol) -> Result<Option<Expr>, Stop> {
        let states = self.fields.states.clone();
        let place = self.system.pool.sym(y);
        let Some(base) = self.base(&[e, h]) else { return Ok(None) };
        let Some(value) = self.numbers(&[h], &states, &base) else { return Ok(None) };
        let equation = self.system.pool.sub(h, place);
        for (i, &s) in states.iter().enumerate() {
            for root in roots(&mut self.system.pool, equation, s, &states) {
                let arguments: Vec<Symbol> = states.iter().copied().chain([y]).collect();
                let at: Vec<f64> = base.iter().copied().chain([value[0]]).collect();
                let Some(there) = self.numbers(&[root.value], &arguments, &at) else { continue };
                if (there[0] - base[i]).abs() > 1e-9 * (1.0 + base[i].abs()) {
                    continue;
                }
                if let Some(found) = self.on_level(e, s, root.value, h, place)? {
                    return Ok(Some(found));
                }
            }
        }
        Ok(None)
    }

    /// e with s = value put in and any values for the other states; checked by putting h back.
    fn on_level(&mut self, e: Expr, s: Symbol, value: Expr, h: Expr, y: Expr) -> Result<Option<Expr>, Stop> {
        let states = self.fields.states.clone();
        for k in 0..3 {
            let pool = &mut self.system.pool;
            let fixed: FxHashMap<Expr, Expr> =
                states.iter().filter(|&&t| t != s).map(|&t| (pool.sym(t), pool.int(k))).collect();
            let value = pool.substitute(value, &fixed);
            let mut map = fixed;
            map.insert(pool.sym(s), value);
            let there = pool.substitute(e, &map);
            let there = crate::forms::root::fold(pool, there);
            let there = tidy(pool, there);
            let back = pool.substitute(there, &std::iter::once((y, h)).collect());
            let difference = pool.sub(back, e);
            match self.is_zero(difference) {
                Ok(Some(_)) => return Ok(Some(there)),
                Err(why @ Undecided::Exact(Exact::Stopped)) => return Err(why.into()),
                Ok(None) | Err(_) => {}
            }
        }
        Ok(None)
    }
}

/// exp of a sum, with exp(c log q) = q^c.
fn exponential(pool: &mut bracketry_symbolic::Pool, e: Expr) -> Expr {
    use bracketry_symbolic::{Func, Node};
    match pool.node(e) {
        Node::Add(a, b) => {
            let (a, b) = (exponential(pool, a), exponential(pool, b));
            pool.mul(a, b)
        }
        Node::Mul(c, l) if pool.number(c).is_some() => match pool.node(l) {
            Node::Call(Func::Log, q) => pool.pow(q, c),
            _ => pool.call(Func::Exp, e),
        },
        Node::Mul(l, c) if pool.number(c).is_some() => match pool.node(l) {
            Node::Call(Func::Log, q) => pool.pow(q, c),
            _ => pool.call(Func::Exp, e),
        },
        _ => pool.call(Func::Exp, e),
    }
}
