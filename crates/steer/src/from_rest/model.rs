//! A model at rest: coordinates, velocities, what friction holds them, and the bounds of the inputs.

use bracketry_symbolic::{Bindings, Expr, Node, Rational, Symbol};
use bracketry_system::{SwitchKind, SwitchedForm, System};
use rustc_hash::FxHashMap;

use super::bounds::{Bound, End, Span, derivative_name};
use super::error::FromRestError;
use super::reason::FromRestReason;
use crate::integrators::own_inputs;

/// How far from the point a coordinate without bounds may move in a statement about a neighborhood.
const NEIGHBORHOOD: f64 = 0.01;

/// An input with its derivatives up to the highest one that the equations use, which is what is chosen.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    pub(crate) name: String,
    /// By order, the symbol of the derivative in the equations; `None` where it does not occur.
    pub(crate) symbols: Vec<Option<Symbol>>,
    /// By order, the values that are admissible.
    pub(crate) spans: Vec<Span>,
    /// The value at rest.
    pub(crate) home: End,
    /// The bounds of the first derivative without those that follow from others.
    given_speed: Span,
}

impl Channel {
    pub(crate) fn order(&self) -> usize {
        self.spans.len() - 1
    }

    /// At rest: the input has its value, its derivatives vanish.
    pub(crate) fn at_home(&self) -> Vec<Span> {
        let zero = End { value: 0.0, exact: Some(0.into()) };
        (0..self.spans.len()).map(|k| Span::point(if k == 0 { &self.home } else { &zero })).collect()
    }
}

/// Velocities that one friction force acts against.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// Places among the states.
    pub(crate) velocities: Vec<usize>,
    pub(crate) law: Law,
    /// Velocities that must be zero for the law to hold.
    pub(crate) given: Vec<usize>,
}

impl Group {
    pub(crate) fn new(velocities: Vec<usize>, law: Law) -> Self {
        Group { velocities, law, given: Vec::new() }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// `sign(v)`.
    Line,
    /// `unit(v1, …)`.
    Plane,
    /// No friction of its own.
    Driven,
    /// Friction on combinations of velocities.
    Coupled,
}

/// A model in which everything that is said about rest can be looked up.
#[derive(Clone)]
pub(crate) struct RestModel {
    /// The model with integrators in front of the inputs whose derivatives it uses.
    pub(crate) system: System,
    /// States of the given model; those of integrators follow.
    pub(crate) own_states: usize,
    /// Rates of the states with signs and unit vectors as symbols; parameters as symbols, and as numbers.
    pub(crate) rates: Vec<Expr>,
    pub(crate) valued: Vec<Expr>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) coordinates: Vec<usize>,
    pub(crate) velocities: Vec<usize>,
    pub(crate) groups: Vec<Group>,
    /// Symbols of signs by state for groups with friction.
    pub(crate) signs: FxHashMap<usize, Symbol>,
    /// All symbols that stand for set-valued signs, each between −1 and 1, and how they are written in a model file.
    pub(crate) all_signs: Vec<Symbol>,
    pub(crate) written: Vec<(Symbol, String)>,
    /// Values of the coordinates at the point.
    pub(crate) at: Vec<End>,
    /// Bounds of coordinates, where given.
    pub(crate) region: Vec<Option<Span>>,
}

impl RestModel {
    pub(crate) fn new(given: &System, bounds: &[Bound]) -> Result<Result<Self, FromRestReason>, FromRestError> {
        let mut system = own_inputs(given)?;
        system.check_denominators()?;
        if !system.input_delays.is_empty() {
            return Ok(Err(FromRestReason::Delays));
        }
        let Some(channels) = channels(given, &mut system) else { return Ok(Err(FromRestReason::Inputs)) };
        let own_states = given.states.len();
        let form = system.set_valued_form();
        let rates = form.dynamics[..own_states].to_vec();
        let valued = system.with_values(&rates);
        let all_signs = form.switches.iter().map(|s| s.sign).collect();
        let written = written(&form);
        let mut model = RestModel {
            own_states,
            rates,
            valued,
            channels,
            coordinates: Vec::new(),
            velocities: Vec::new(),
            groups: Vec::new(),
            signs: FxHashMap::default(),
            all_signs,
            written,
            at: Vec::new(),
            region: Vec::new(),
            system,
        };
        model.divide_states();
        if model.coordinates.is_empty() {
            return Ok(Err(FromRestReason::NoCoordinates));
        }
        model.read_point()?;
        model.read_bounds(bounds)?;
        if let Some(why) = model.group(&form) {
            return Ok(Err(why));
        }
        Ok(Ok(model))
    }

    /// Velocities are the least set of states such that the rates of all others vanish where they do, whatever the inputs.
    fn divide_states(&mut self) {
        let moved: Vec<Symbol> = self.channels.iter().flat_map(|c| c.symbols.iter().flatten().copied()).collect();
        let acts = |s: &Symbol| moved.contains(s) || self.all_signs.contains(s);
        let mut fast: Vec<bool> =
            self.valued.iter().map(|&e| self.system.pool.symbols_of(&[e]).iter().any(acts)).collect();
        loop {
            let zero = self.system.pool.int(0);
            let mut at_rest: FxHashMap<Expr, Expr> = FxHashMap::default();
            for (k, _) in fast.iter().enumerate().filter(|(_, f)| **f) {
                let v = self.system.pool.sym(self.system.states[k]);
                at_rest.insert(v, zero);
            }
            let next = (0..self.own_states).find(|&k| {
                let rate = self.system.pool.substitute(self.valued[k], &at_rest);
                !fast[k] && !self.is_zero(rate)
            });
            match next {
                Some(k) => fast[k] = true,
                None => break,
            }
        }
        self.velocities = (0..self.own_states).filter(|&k| fast[k]).collect();
        self.coordinates = (0..self.own_states).filter(|&k| !fast[k]).collect();
    }

    pub(crate) fn is_zero(&mut self, e: Expr) -> bool {
        self.system.pool.zero_test(e, &Bindings::new()).is_zero()
    }

    fn read_point(&mut self) -> Result<(), FromRestError> {
        let zero = self.system.pool.int(0);
        let point = self.system.point.as_ref().map(|p| p.states.clone());
        for &k in &self.coordinates {
            let e = point.as_ref().map_or(zero, |p| p[k]);
            let e = self.system.with_values(&[e])[0];
            let value = self.system.value(e).filter(|v| v.is_finite());
            let value = value.ok_or_else(|| FromRestError::Point { name: self.state_name(k) })?;
            self.at.push(End { value, exact: self.system.pool.number(e).cloned() });
        }
        Ok(())
    }

    fn read_bounds(&mut self, bounds: &[Bound]) -> Result<(), FromRestError> {
        self.region = vec![None; self.coordinates.len()];
        for (k, bound) in bounds.iter().enumerate() {
            if bounds[..k].iter().any(|b| b.name == bound.name) {
                return Err(FromRestError::Twice { name: bound.name.clone() });
            }
            let orders = self.channels.iter().enumerate().flat_map(|(j, c)| (0..=c.order()).map(move |o| (j, o)));
            let is_it = |&(j, order): &(usize, usize)| derivative_name(&self.channels[j].name, order) == bound.name;
            if let Some((j, order)) = orders.clone().find(is_it) {
                self.channels[j].spans[order] = bound.span();
            } else if let Some(c) = self.coordinates.iter().position(|&k| self.state_name(k) == bound.name) {
                self.region[c] = Some(bound.span());
            } else {
                let mut known: Vec<String> =
                    orders.map(|(j, order)| derivative_name(&self.channels[j].name, order)).collect();
                known.extend(self.coordinates.iter().map(|&k| self.state_name(k)));
                return Err(FromRestError::Unknown { name: bound.name.clone(), known });
            }
        }
        for channel in &mut self.channels {
            let top = channel.order();
            if !channel.spans[top].is_finite() {
                return Err(FromRestError::Unbounded { name: derivative_name(&channel.name, top) });
            }
            let (home, zero) = (channel.home.value, 0.0);
            for (order, span) in channel.spans.iter().enumerate() {
                let rest = if order == 0 { home } else { zero };
                if !(span.ends[0] <= rest && rest <= span.ends[1]) {
                    return Err(FromRestError::RestOutside { name: derivative_name(&channel.name, order), rest });
                }
            }
            channel.given_speed = channel.spans.get(1).cloned().unwrap_or(Span::FREE);
            bound_speed(channel);
        }
        for ((&k, at), region) in self.coordinates.iter().zip(&self.at).zip(&self.region) {
            if region.as_ref().is_some_and(|r| !(r.ends[0] <= at.value && at.value <= r.ends[1])) {
                return Err(FromRestError::RestOutside { name: self.state_name(k), rest: at.value });
            }
        }
        Ok(())
    }

    /// Bounds a derivative of an input by its difference from the value at rest; what follows for the speed follows anew.
    pub(crate) fn bound(&mut self, channel: usize, order: usize, size: f64) {
        let c = &mut self.channels[channel];
        let rest = if order == 0 { c.home.value } else { 0.0 };
        c.spans[order] = Span::between(rest - size, rest + size);
        if let [_, speed, _] = &mut c.spans[..]
            && order != 1
        {
            *speed = c.given_speed.clone();
        }
        bound_speed(c);
    }

    pub(crate) fn state_name(&self, k: usize) -> String {
        self.system.symbol_name(self.system.states[k]).to_owned()
    }

    pub(crate) fn coordinate_names(&self) -> Vec<String> {
        self.coordinates.iter().map(|&k| self.state_name(k)).collect()
    }

    /// Which velocities share a friction force.
    fn group(&mut self, form: &SwitchedForm) -> Option<FromRestReason> {
        let mut groups: Vec<Group> = Vec::new();
        let lone = |model: &mut Self, e: Expr| -> Option<(usize, Expr)> {
            let e = model.system.with_values(&[e])[0];
            let symbols = model.system.pool.symbols_of(&[e]);
            let k = model.velocities.iter().copied().find(|&k| symbols == [model.system.states[k]])?;
            let v = model.system.states[k];
            let slope = model.system.pool.diff(e, v);
            let at_rest = [(v, model.system.pool.int(0))];
            let offset = model.system.pool.at(e, &at_rest).ok()?;
            let rises = model.system.pool.constant_sign(slope, &Bindings::new()) == Some(std::cmp::Ordering::Greater);
            (rises && model.system.pool.is_zero(offset)).then_some((k, slope))
        };
        let coupled = |model: &Self, e: Expr| -> Vec<usize> {
            let symbols = model.system.pool.symbols_of(&[e]);
            model.velocities.iter().copied().filter(|&k| symbols.contains(&model.system.states[k])).collect()
        };
        let signs = form.signs().len();
        for switch in form.signs().iter().filter(|s| s.kind == SwitchKind::Jump) {
            let touched = coupled(self, switch.surface);
            if touched.is_empty() {
                return Some(FromRestReason::OtherSwitch { name: switch.name.clone() });
            }
            match lone(self, switch.surface) {
                Some((k, _)) => {
                    self.signs.insert(k, switch.sign);
                    join(&mut groups, vec![k], Law::Line);
                }
                None => join(&mut groups, touched, Law::Coupled),
            }
        }
        // What acts against velocities alone comes first, so that the others are seen to add a velocity.
        let mut later = Vec::new();
        for vector in &form.unit_vectors {
            let components = &form.switches[vector.switches.clone()];
            let own: Option<Vec<(usize, Expr)>> = components.iter().map(|c| lone(self, c.surface)).collect();
            match own {
                Some(list) if list.iter().all(|(_, slope)| *slope == list[0].1) => {
                    for (&(k, _), c) in list.iter().zip(components) {
                        self.signs.insert(k, c.sign);
                    }
                    join(&mut groups, list.into_iter().map(|(k, _)| k).collect(), Law::Plane);
                }
                own => later.push((components, own)),
            }
        }
        for (components, own) in later {
            let is_known = |k: usize| groups.iter().any(|g| g.law != Law::Coupled && g.velocities.contains(&k));
            let new: Vec<usize> =
                (0..components.len()).filter(|&c| own.as_ref().is_some_and(|list| !is_known(list[c].0))).collect();
            if let (Some(list), &[c]) = (own, &new[..]) {
                // A friction that, where the other velocities vanish, acts on one velocity alone.
                let (k, _) = list[c];
                self.signs.insert(k, components[c].sign);
                let given = list.iter().map(|(k, _)| *k).filter(|other| *other != k).collect();
                groups.push(Group { velocities: vec![k], law: Law::Line, given });
            } else {
                let all: Vec<usize> = components.iter().flat_map(|c| coupled(self, c.surface)).collect();
                join(&mut groups, all, Law::Coupled);
            }
        }
        if signs == 0 && form.unit_vectors.is_empty() {
            return Some(FromRestReason::NoFriction);
        }
        for &k in &self.velocities {
            if !groups.iter().any(|g| g.velocities.contains(&k)) {
                groups.push(Group::new(vec![k], Law::Driven));
            }
        }
        self.groups = groups;
        None
    }

    /// Where a coordinate may be: at the point, within its bounds, or near the point.
    pub(crate) fn neighborhood(&self, coordinate: usize) -> Span {
        let at = self.at[coordinate].value;
        let near = || Span::between(at - NEIGHBORHOOD, at + NEIGHBORHOOD);
        self.region[coordinate].clone().unwrap_or_else(near)
    }
}

/// Signs and directions as they are written in a model file.
fn written(form: &SwitchedForm) -> Vec<(Symbol, String)> {
    let mut list: Vec<(Symbol, String)> = form.signs().iter().map(|s| (s.sign, format!("sign({})", s.name))).collect();
    for vector in &form.unit_vectors {
        let components = &form.switches[vector.switches.clone()];
        for own in components {
            let others = components.iter().filter(|c| c.sign != own.sign).map(|c| c.name.as_str());
            let names: Vec<&str> = std::iter::once(own.name.as_str()).chain(others).collect();
            list.push((own.sign, format!("unit({})", names.join(", "))));
        }
    }
    list
}

/// Adds a group; groups that share velocities become one.
fn join(groups: &mut Vec<Group>, mut velocities: Vec<usize>, mut law: Law) {
    groups.retain(|g| {
        let meets = g.velocities.iter().any(|k| velocities.contains(k));
        if meets {
            velocities.extend(&g.velocities);
            law = Law::Coupled;
        }
        !meets
    });
    velocities.sort_unstable();
    velocities.dedup();
    groups.push(Group::new(velocities, law));
}

/// A motion of an input from rest to rest within an interval of length L, with a second derivative between −β and α, is never
/// faster than √(2 L α β/(α + β)).
fn bound_speed(channel: &mut Channel) {
    let [place, speed, acceleration] = &mut channel.spans[..] else { return };
    let [low, high] = acceleration.ends;
    if place.is_finite() {
        let both = high - low;
        let limit = if both > 0.0 { (2.0 * place.width() * -low * high / both).sqrt() } else { 0.0 };
        let limit = (limit * (1.0 + 1e-12)).next_up();
        if limit.is_finite() && speed.ends[0] < -limit {
            (speed.ends[0], speed.exact[0]) = (-limit, Rational::try_from(-limit).ok());
        }
        if limit.is_finite() && speed.ends[1] > limit {
            (speed.ends[1], speed.exact[1]) = (limit, Rational::try_from(limit).ok());
        }
    }
}

/// The inputs of the given model in the one with integrators; `None` where that one has other inputs.
fn channels(given: &System, system: &mut System) -> Option<Vec<Channel>> {
    let mut list = Vec::new();
    for (j, &u) in given.inputs.iter().enumerate() {
        let of = given.input_derivatives.iter().filter(|d| d.input == j);
        let order = of.map(|d| d.order as usize).max().unwrap_or(0);
        let mut symbols = vec![None; order + 1];
        let top = *system.inputs.get(j)?;
        symbols[order] = Some(top);
        if system.states.contains(&u) {
            let mut here = u;
            for symbol in symbols.iter_mut().take(order) {
                *symbol = Some(here);
                let k = system.states.iter().position(|&s| s == here)?;
                let rate = system.dynamics[k];
                let Node::Sym(next) = system.pool.node(rate) else { return None };
                here = next;
            }
            if here != top {
                return None;
            }
        } else if order == 0 && top != u {
            return None;
        }
        let range = given.input_ranges.iter().find(|r| r.input == u);
        let ends = range.map_or([None, None], |r| [r.min.clone(), r.max.clone()]);
        let mut spans = vec![Span::FREE; order + 1];
        for (side, end) in ends.into_iter().enumerate() {
            if let Some(end) = end {
                spans[0].ends[side] = end.to_f64().value();
                spans[0].exact[side] = Some(end);
            }
        }
        let home = match &given.point {
            Some(p) => End { value: given.value(p.inputs[j])?, exact: given.pool.number(p.inputs[j]).cloned() },
            None => End { value: 0.0, exact: Some(Rational::from(0)) },
        };
        list.push(Channel { name: given.symbol_name(u).to_owned(), symbols, spans, home, given_speed: Span::FREE });
    }
    Some(list)
}
