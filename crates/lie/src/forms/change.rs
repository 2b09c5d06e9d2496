//! From coordinates and feedback to the transformed system, confirmed by transforming back.

use bracketry_symbolic::{Expr, Function, Named, Symbol};
use bracketry_system::{Point, System};
use rustc_hash::FxHashMap;

use crate::algebra::matrix::{determinant, generic_rank};
use crate::algebra::rational::readable::{tidy, vanishing_factors};
use crate::condition::Condition;
use crate::feedback::relative_degree::divisors;
use crate::forms::frame::Frame;
use crate::forms::inverse::Inverse;
use crate::forms::normal_form::{Block, BlockKind, FormNote, NormalForm};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::forms::root::fold;
use crate::undecided::Undecided;

/// New inputs in place of the old ones.
pub(crate) struct Feedback {
    /// The new inputs.
    pub(crate) new: Vec<Symbol>,
    /// Each old input as a function of old states and new inputs.
    pub(crate) law: Vec<Expr>,
    /// Each new input as a function of old states and inputs.
    pub(crate) inverse: Vec<Expr>,
}

/// A change that is to be made.
pub(crate) struct Plan {
    /// z = T(x).
    pub(crate) coordinates: Vec<Expr>,
    /// z.
    pub(crate) new: Vec<Symbol>,
    pub(crate) feedback: Option<Feedback>,
    /// Rates in the new coordinates and inputs, where they are known without the inverse.
    pub(crate) known: Vec<Option<Expr>>,
    /// S, where it is known.
    pub(crate) inverse: Option<Vec<Expr>>,
    /// A matrix of functions of the old states that has full rank just where the change is regular; the Jacobian of T if
    /// there is none.
    pub(crate) regular: Option<Vec<Vec<Expr>>>,
    /// Functions of the old states of which one vanishes where the change is singular, if they are known.
    pub(crate) singular: Option<Vec<Expr>>,
    /// Groups of new states, by number.
    pub(crate) blocks: Vec<(BlockKind, Vec<usize>)>,
    /// Whether a coordinate that is an old state keeps its name.
    pub(crate) keep_names: bool,
    /// What is put behind the name of the model.
    pub(crate) suffix: &'static str,
    pub(crate) notes: Vec<FormNote>,
}

/// A transformed system, in the pool of its frame.
pub(crate) struct Changed {
    pub(crate) form: NormalForm,
    /// Rates in the new coordinates.
    pub(crate) rates: Vec<Expr>,
}

impl Frame {
    /// The derivatives of the coordinates along the closed loop, in old states and new inputs.
    fn closed_loop(&mut self, plan: &Plan) -> Vec<Expr> {
        let inputs = self.inputs();
        let pool = &mut self.system.pool;
        let mut rates = Vec::new();
        for &t in &plan.coordinates {
            let mut rate = pool.lie_derivative(t, &self.fields.states, &self.fields.drift);
            for (g, &u) in self.fields.controls.iter().zip(&inputs) {
                let along = pool.lie_derivative(t, &self.fields.states, g);
                let term = pool.mul(along, u);
                rate = pool.add(rate, term);
            }
            rates.push(rate);
        }
        match &plan.feedback {
            None => rates,
            Some(feedback) => {
                let law: FxHashMap<Expr, Expr> = inputs.iter().copied().zip(feedback.law.iter().copied()).collect();
                pool.substitute_all(&rates, &law)
            }
        }
    }

    /// Makes the change and confirms it.
    pub(crate) fn change(&mut self, plan: Plan) -> Result<Changed, Stop> {
        let along = self.closed_loop(&plan);
        let inverse = self.inverse_of(&plan, &along)?;
        let needs = plan.known.iter().any(Option::is_none);
        let Some(map) = self.inverse_map(inverse.as_ref()).map_or_else(|| (!needs).then(FxHashMap::default), Some)
        else {
            let coordinates = Function::list(&self.system.pool, &plan.coordinates);
            return Err(Stop::Unknown(Obstacle::NoInverse { coordinates }));
        };
        let mut rates = Vec::new();
        for (k, &e) in along.iter().enumerate() {
            rates.push(match plan.known[k] {
                Some(rate) => rate,
                None => self.in_new_coordinates(e, &map),
            });
        }
        let mut notes = plan.notes.clone();
        let general = self.confirm(&plan, &along, &rates, inverse.as_ref())?;
        if !general {
            notes.push(FormNote::ParameterValues);
        }
        let outputs = self.new_outputs(&plan, inverse.is_some().then_some(&map), &mut notes);
        let form = self.assembled(plan, &rates, inverse, outputs, notes);
        Ok(Changed { form, rates })
    }

    fn inverse_of(&mut self, plan: &Plan, along: &[Expr]) -> Result<Option<Inverse>, Stop> {
        let states = self.system.states.clone();
        if let Some(values) = plan.inverse.clone() {
            return Ok(Some(Inverse { values, branch: false, base: Vec::new() }));
        }
        let inputs: Vec<Symbol> = match &plan.feedback {
            Some(feedback) => feedback.new.clone(),
            None => self.system.inputs.clone(),
        };
        // Where coordinates and rates are finite, at inputs zero.
        let pool = &mut self.system.pool;
        let zero = pool.int(0);
        let none: FxHashMap<Expr, Expr> = inputs.iter().map(|&u| (pool.sym(u), zero)).collect();
        let mut finite = pool.substitute_all(along, &none);
        finite.extend(&plan.coordinates);
        let Some(base) = self.base(&finite) else { return Ok(None) };
        match self.invert(&states, &plan.coordinates, &plan.new, base) {
            Err(Undecided::TooLarge { .. }) => Ok(None),
            found => Ok(found?),
        }
    }

    fn inverse_map(&mut self, inverse: Option<&Inverse>) -> Option<FxHashMap<Expr, Expr>> {
        let states = self.system.states.clone();
        let pool = &mut self.system.pool;
        Some(states.iter().zip(&inverse?.values).map(|(&s, &v)| (pool.sym(s), v)).collect())
    }

    /// A function of old states as one of new ones.
    pub(crate) fn in_new_coordinates(&mut self, e: Expr, map: &FxHashMap<Expr, Expr>) -> Expr {
        let pool = &mut self.system.pool;
        let e = pool.substitute(e, map);
        let e = fold(pool, e);
        tidy(pool, e)
    }

    /// Whether the new system is the old one: ∂T/∂x (f + Σ g_j u_j) = F(T(x), v), or else ∂S/∂z F = (f + Σ g_j u_j)(S(z)). True
    /// if for all parameters.
    fn confirm(
        &mut self,
        plan: &Plan,
        along: &[Expr],
        rates: &[Expr],
        inverse: Option<&Inverse>,
    ) -> Result<bool, Stop> {
        let pool = &mut self.system.pool;
        let forward: FxHashMap<Expr, Expr> =
            plan.new.iter().zip(&plan.coordinates).map(|(&z, &t)| (pool.sym(z), t)).collect();
        let images = pool.substitute_all(rates, &forward);
        let differences: Vec<Expr> = images.iter().zip(along).map(|(&a, &b)| pool.sub(a, b)).collect();
        let open = match self.all_zero(&differences)? {
            Ok(general) => return Ok(general),
            Err(open) => open,
        };
        let name = self.system.pool.name(plan.new[open]).to_owned();
        let Some(inverse) = inverse else { return Err(Stop::Unknown(Obstacle::Unconfirmed { name })) };
        let old_rates = self.old_rates(plan);
        let map = self.inverse_map(Some(inverse)).unwrap_or_default();
        let pool = &mut self.system.pool;
        let wanted = pool.substitute_all(&old_rates, &map);
        let mut differences = Vec::new();
        for (&s, &w) in inverse.values.iter().zip(&wanted) {
            let rate = pool.lie_derivative(s, &plan.new, rates);
            let difference = pool.sub(rate, w);
            differences.push(fold(pool, difference));
        }
        match self.all_zero(&differences)? {
            Ok(general) => Ok(general),
            Err(_) => Err(Stop::Unknown(Obstacle::Unconfirmed { name })),
        }
    }

    /// f + Σ g_j u_j with the feedback put in.
    fn old_rates(&mut self, plan: &Plan) -> Vec<Expr> {
        let inputs = self.inputs();
        let pool = &mut self.system.pool;
        let mut rates = self.fields.drift.clone();
        for (g, &u) in self.fields.controls.iter().zip(&inputs) {
            for (rate, &g) in rates.iter_mut().zip(g) {
                let term = pool.mul(g, u);
                *rate = pool.add(*rate, term);
            }
        }
        let Some(feedback) = &plan.feedback else { return rates };
        let law: FxHashMap<Expr, Expr> = inputs.iter().copied().zip(feedback.law.iter().copied()).collect();
        pool.substitute_all(&rates, &law)
    }

    /// Whether all vanish for all parameters (or for the given ones); else the number of one that is not seen to.
    fn all_zero(&mut self, list: &[Expr]) -> Result<Result<bool, usize>, Stop> {
        let mut general = true;
        for (k, &e) in list.iter().enumerate() {
            match self.is_zero(e) {
                Ok(Some(always)) => general &= always,
                Ok(None) | Err(Undecided::Exact(_)) => {
                    if let Some(limit) = self.system.pool.reached_limit() {
                        return Err(Undecided::from(limit).into());
                    }
                    return Ok(Err(k));
                }
                Err(why) => return Err(why.into()),
            }
        }
        Ok(Ok(general))
    }

    /// The outputs in the new coordinates; one that has no closed form there is left out.
    fn new_outputs(
        &mut self,
        plan: &Plan,
        map: Option<&FxHashMap<Expr, Expr>>,
        notes: &mut Vec<FormNote>,
    ) -> Vec<(String, Expr)> {
        let mut list = Vec::new();
        for (name, h) in self.system.outputs.clone() {
            let mut h = h;
            if let Some(feedback) = &plan.feedback {
                let inputs = self.inputs();
                let law: FxHashMap<Expr, Expr> = inputs.into_iter().zip(feedback.law.iter().copied()).collect();
                h = self.system.pool.substitute(h, &law);
            }
            let tidied = tidy(&mut self.system.pool, h);
            let place = plan.coordinates.iter().position(|&t| t == h || t == tidied);
            let new = match (place, map) {
                (Some(k), _) => Some(self.system.pool.sym(plan.new[k])),
                (None, Some(map)) => Some(self.in_new_coordinates(h, map)),
                (None, None) => {
                    let uses = self.system.pool.symbols_of(&[h]);
                    (!uses.iter().any(|s| self.system.states.contains(s))).then_some(h)
                }
            };
            match new {
                Some(e) => list.push((name, e)),
                None => notes.push(FormNote::OutputOmitted { output: name }),
            }
        }
        list
    }

    fn jacobian(&mut self, coordinates: &[Expr]) -> Vec<Vec<Expr>> {
        let states = self.fields.states.clone();
        self.system.pool.jacobian(coordinates, &states)
    }

    /// Rank of a matrix of functions at the model's point; `None` without a point, or where that is open.
    fn full_rank_at_point(&mut self, rows: &[Vec<Expr>]) -> Option<bool> {
        let point = self.system.point.clone()?;
        let size = rows.len();
        if size == 0 {
            return Some(true);
        }
        let mut bindings = self.fields.bindings.clone();
        let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (&s, &v) in self.fields.states.iter().zip(&point.states) {
            // A number is bound, so that a denominator that vanishes there is seen.
            if let Some(value) = self.system.pool.number(v) {
                bindings.bind(s, value.clone());
            } else {
                at.insert(self.system.pool.sym(s), v);
            }
        }
        let pool = &mut self.system.pool;
        let rows: Vec<Vec<Expr>> = rows.iter().map(|r| pool.substitute_all(r, &at)).collect();
        generic_rank(pool, &rows, &bindings, &mut self.evidence).ok().map(|rank| rank == size)
    }

    /// Where a divisor of the inverse vanishes, as conditions on the old states that differ from the singular set.
    fn validity(&mut self, plan: &Plan, divisors: &[Expr], singular: &[Expr]) -> Option<Condition> {
        let states = self.fields.states.clone();
        let pool = &mut self.system.pool;
        let forward: FxHashMap<Expr, Expr> =
            plan.new.iter().zip(&plan.coordinates).map(|(&z, &t)| (pool.sym(z), t)).collect();
        let mut list: Vec<Expr> = Vec::new();
        for &d in divisors {
            let d = pool.substitute(d, &forward);
            let d = tidy(pool, d);
            let factors = vanishing_factors(pool, d, &states, &self.fields.bindings).unwrap_or_else(|| vec![d]);
            for f in factors {
                if !list.contains(&f) && !singular.contains(&f) {
                    list.push(f);
                }
            }
        }
        let conditions: Vec<Condition> = list.into_iter().map(|e| Condition::Differs(Function::new(pool, e))).collect();
        (!conditions.is_empty()).then_some(Condition::All(conditions))
    }

    fn assembled(
        &mut self,
        plan: Plan,
        rates: &[Expr],
        inverse: Option<Inverse>,
        outputs: Vec<(String, Expr)>,
        mut notes: Vec<FormNote>,
    ) -> NormalForm {
        let states = self.fields.states.clone();
        let jacobian = self.jacobian(&plan.coordinates);
        let singular = plan.singular.clone().or_else(|| {
            let pool = &mut self.system.pool;
            let d = determinant(pool, &jacobian)?;
            vanishing_factors(pool, d, &states, &self.fields.bindings)
        });
        let divided = inverse.as_ref().map(|i| divisors(&self.system.pool, &i.values)).unwrap_or_default();
        let inverse_valid = self.validity(&plan, &divided, singular.as_deref().unwrap_or_default());
        let regular = self.full_rank_at_point(plan.regular.as_ref().unwrap_or(&jacobian));
        if let Some(i) = inverse.as_ref().filter(|i| i.branch) {
            let through = self.system.state_names().into_iter().zip(i.base.iter().copied()).collect();
            notes.push(FormNote::Branch { through });
        }
        if plan.feedback.is_some() && !self.system.input_ranges.is_empty() {
            notes.push(FormNote::RangesLost);
        }
        let names = self.final_symbols(&plan);
        let system = self.new_system(&plan, &names, rates, outputs);
        let pool = &mut self.system.pool;
        let rename: FxHashMap<Expr, Expr> =
            plan.new.iter().zip(&names).map(|(&z, &s)| (pool.sym(z), pool.sym(s))).collect();
        let name = |pool: &bracketry_symbolic::Pool, s: Symbol| pool.name(s).to_owned();
        let coordinates = names.iter().zip(&plan.coordinates);
        let coordinates = Named(coordinates.map(|(&s, &t)| (name(pool, s), Function::new(pool, t))).collect());
        let inverse = inverse.map(|i| {
            let values = pool.substitute_all(&i.values, &rename);
            Named(states.iter().zip(values).map(|(&s, v)| (name(pool, s), Function::new(pool, v))).collect())
        });
        let (mut feedback, mut new_inputs) = (Vec::new(), Vec::new());
        if let Some(f) = &plan.feedback {
            feedback =
                self.system.inputs.iter().zip(&f.law).map(|(&u, &e)| (name(pool, u), Function::new(pool, e))).collect();
            new_inputs = f.new.iter().zip(&f.inverse).map(|(&v, &e)| (name(pool, v), Function::new(pool, e))).collect();
        }
        let blocks = plan
            .blocks
            .into_iter()
            .filter(|b| !b.1.is_empty())
            .map(|(kind, list)| Block { kind, states: list.iter().map(|&k| name(pool, names[k])).collect() })
            .collect();
        NormalForm {
            system,
            coordinates,
            inverse,
            feedback: Named(feedback),
            linearizing_feedback: Named(Vec::new()),
            new_inputs: Named(new_inputs),
            singular_set: singular.map(|list| Condition::any_vanishes(pool, &list)),
            inverse_valid,
            regular_at_point: regular,
            blocks,
            parts: Vec::new(),
            notes,
        }
    }

    /// The symbols of the new states: that of the old state where a coordinate is one and names are kept.
    pub(crate) fn final_symbols(&mut self, plan: &Plan) -> Vec<Symbol> {
        let states = self.system.states.clone();
        let pool = &mut self.system.pool;
        let own = |pool: &mut bracketry_symbolic::Pool, t: Expr| {
            states.iter().copied().find(|&s| plan.keep_names && pool.sym(s) == t)
        };
        plan.coordinates.iter().zip(&plan.new).map(|(&t, &z)| own(pool, t).unwrap_or(z)).collect()
    }

    fn new_system(&mut self, plan: &Plan, names: &[Symbol], rates: &[Expr], outputs: Vec<(String, Expr)>) -> System {
        let point = self.new_point(plan);
        let mut system = self.system.clone();
        let pool = &mut system.pool;
        let rename: FxHashMap<Expr, Expr> =
            plan.new.iter().zip(names).map(|(&z, &s)| (pool.sym(z), pool.sym(s))).collect();
        system.name = format!("{}_{}", system.name, plan.suffix);
        system.dynamics = pool.substitute_all(rates, &rename);
        system.outputs = outputs.into_iter().map(|(n, e)| (n, pool.substitute(e, &rename))).collect();
        system.states = names.to_vec();
        if let Some(feedback) = &plan.feedback {
            system.inputs.clone_from(&feedback.new);
            system.input_ranges.clear();
            system.input_delays.clear();
        }
        system.definitions.clear();
        system.static_levels.clear();
        system.point = point;
        system
    }

    /// The point in the new coordinates, where its values are finite.
    fn new_point(&mut self, plan: &Plan) -> Option<Point> {
        let point = self.system.point.clone()?;
        let values = self.system.states.clone().into_iter().zip(point.states.iter().copied());
        let values = values.chain(self.system.inputs.clone().into_iter().zip(point.inputs.iter().copied()));
        let at: FxHashMap<Expr, Expr> = values.map(|(s, v)| (self.system.pool.sym(s), v)).collect();
        let mut image = |list: &[Expr]| -> Option<Vec<Expr>> {
            let list = self.system.with_values(list);
            let list = self.system.pool.substitute_all(&list, &at);
            let list: Vec<Expr> = list.into_iter().map(|e| self.system.pool.simplify(e)).collect();
            list.iter().all(|&e| self.system.value(e).is_some_and(f64::is_finite)).then_some(list)
        };
        let states = image(&plan.coordinates)?;
        let inputs = match &plan.feedback {
            Some(feedback) => image(&feedback.inverse)?,
            None => point.inputs,
        };
        Some(Point { states, inputs })
    }
}
