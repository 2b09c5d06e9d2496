//! What friction holds, whatever the inputs within their bounds.

use bracketry_symbolic::{Expr, Symbol};
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::bounds::{Span, derivative_name};
use super::model::{Group, Law, RestModel};
use super::sign::{Holds, nonnegative};
use super::speed::{SpeedLimit, speed_limit};

/// How a coordinate may move from rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Not at all.
    Never,
    /// It never decreases.
    OnlyUp,
    /// It never increases.
    OnlyDown,
    /// Nothing was excluded.
    Open,
}

/// A friction force, and whether it balances all others at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cone {
    /// The velocities that it acts against.
    pub velocities: Vec<String>,
    /// The rates that the other forces would give them, as formulas.
    pub rates: Vec<String>,
    /// The greatest rate that friction balances; `None` for a velocity without friction.
    pub friction: Option<String>,
    /// Whether friction balances them for all admissible inputs.
    pub holds: Holds,
}

/// The cones of all friction forces, and what follows for the coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    pub(crate) cones: Vec<Cone>,
    /// By coordinate.
    pub(crate) motions: Vec<Motion>,
}

/// Inputs within intervals, by channel and order.
pub(crate) type Box<'a> = &'a [Vec<Span>];

/// Where coordinates that move may be.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Where {
    /// Within their bounds, or anywhere.
    Anywhere,
    /// Within their bounds, or near the point.
    Near,
}

/// Forces of one group: rates without friction, and how much friction balances.
struct Forces {
    rates: Vec<Expr>,
    friction: Option<Expr>,
}

pub(crate) struct Test<'a> {
    model: &'a mut RestModel,
    inputs: Box<'a>,
    place: Where,
    groups: Vec<Group>,
    /// Rates of the states, parameters at their values.
    rates: Vec<Expr>,
    speeds: Vec<SpeedLimit>,
}

impl<'a> Test<'a> {
    pub(crate) fn new(model: &'a mut RestModel, inputs: Box<'a>, place: Where) -> Self {
        let (groups, rates) = (model.groups.clone(), model.valued.clone());
        let pool = &mut model.system.pool;
        let channels = model.channels.iter().zip(inputs);
        let speeds = channels.filter_map(|(channel, spans)| speed_limit(pool, channel, spans)).collect();
        let mut test = Test { model, inputs, place, groups, rates, speeds };
        test.divide_planes();
        test
    }

    /// Where some velocities of a plane are not driven, whatever the others, friction acts along a line: the components of the
    /// slip that start at zero stay zero.
    fn divide_planes(&mut self) {
        for g in 0..self.groups.len() {
            if self.groups[g].law != Law::Plane {
                continue;
            }
            let quiet: Vec<usize> =
                self.groups[g].velocities.clone().into_iter().filter(|&k| self.is_not_driven(k)).collect();
            if quiet.len() + 1 != self.groups[g].velocities.len() {
                continue;
            }
            let quieted = self.quieted(&quiet);
            self.rates = self.model.system.pool.substitute_all(&self.rates, &quieted);
            self.groups[g].velocities.retain(|k| !quiet.contains(k));
            self.groups[g].law = Law::Line;
            self.groups.extend(quiet.into_iter().map(|k| Group::new(vec![k], Law::Driven)));
        }
    }

    /// These velocities, and their components of the direction of slip, at zero.
    fn quieted(&mut self, velocities: &[usize]) -> FxHashMap<Expr, Expr> {
        let pool = &mut self.model.system.pool;
        let zero = pool.int(0);
        let mut map = FxHashMap::default();
        for k in velocities {
            map.insert(pool.sym(self.model.system.states[*k]), zero);
            if let Some(&s) = self.model.signs.get(k) {
                map.insert(pool.sym(s), zero);
            }
        }
        map
    }

    /// Whether a velocity stays zero whatever all others are.
    fn is_not_driven(&mut self, k: usize) -> bool {
        let quieted = self.quieted(&[k]);
        let pool = &mut self.model.system.pool;
        let rate = pool.substitute(self.rates[k], &quieted);
        let opposite = pool.neg(rate);
        [rate, opposite].into_iter().all(|e| self.nonnegative(e, &[k]) == Holds::Always)
    }

    /// The largest set of groups that hold each other: where all of them are at rest, friction balances each.
    pub(crate) fn run(&mut self) -> Held {
        let holds = self.holds();
        let still = self.still(&holds);
        let cones = (0..holds.len()).map(|g| self.cone(g, &holds, &still)).collect();
        let motions = (0..self.model.coordinates.len()).map(|c| self.motion(c, &still, &holds)).collect();
        Held { cones, motions }
    }

    fn holds(&mut self) -> Vec<Holds> {
        let mut holds = vec![Holds::Always; self.groups.len()];
        loop {
            let still = self.still(&holds);
            let failing = (0..holds.len()).find_map(|g| {
                (holds[g] == Holds::Always)
                    .then(|| (g, self.balanced(g, &still, &holds)))
                    .filter(|(_, found)| *found != Holds::Always)
            });
            match failing {
                Some((g, found)) => holds[g] = found,
                None => return holds,
            }
        }
    }

    /// The rate of a coordinate's velocity that has no friction, where friction holds what it can.
    pub(crate) fn driven_rate(&mut self, coordinate: usize, velocity: usize) -> Option<Expr> {
        let holds = self.holds();
        self.driven(coordinate, velocity, &holds)
    }

    fn driven(&mut self, coordinate: usize, velocity: usize, holds: &[Holds]) -> Option<Expr> {
        let pool = &mut self.model.system.pool;
        let name = pool.sym(self.model.system.states[velocity]);
        let group = self.groups.iter().position(|g| g.velocities == [velocity] && g.law == Law::Driven)?;
        if self.rates[self.model.coordinates[coordinate]] != name {
            return None;
        }
        let still = self.still(holds);
        let rates = self.rates.clone();
        let forces = self.forces(group, &rates, &still)?;
        self.with_static_friction(&forces.rates, &still, holds).first().copied()
    }

    /// Whether that rate has a sign, or vanishes, for all inputs.
    pub(crate) fn driven_sign(&mut self, coordinate: usize, velocity: usize, sign: f64) -> Holds {
        let holds = self.holds();
        let Some(rate) = self.driven(coordinate, velocity, &holds) else { return Holds::Undecided };
        let rate = if sign > 0.0 { rate } else { self.model.system.pool.neg(rate) };
        let still = self.still(&holds);
        self.nonnegative(rate, &still)
    }

    /// The velocities that stay zero.
    fn still(&self, holds: &[Holds]) -> Vec<usize> {
        let groups = self.groups.iter().zip(holds).filter(|(_, h)| **h == Holds::Always);
        groups.flat_map(|(g, _)| g.velocities.clone()).collect()
    }

    /// With these velocities zero.
    fn at_rest(&mut self, list: &[Expr], still: &[usize]) -> Vec<Expr> {
        let pool = &mut self.model.system.pool;
        let zero = pool.int(0);
        let map: FxHashMap<Expr, Expr> = still.iter().map(|&k| (pool.sym(self.model.system.states[k]), zero)).collect();
        pool.substitute_all(list, &map)
    }

    /// Rates of a group where it and `still` are at rest; `None` where friction does not have the form of its law.
    fn forces(&mut self, group: usize, rates: &[Expr], still: &[usize]) -> Option<Forces> {
        let group = self.groups[group].clone();
        let rest: Vec<usize> = still.iter().chain(&group.velocities).copied().collect();
        let own: Vec<Expr> = group.velocities.iter().map(|&k| rates[k]).collect();
        let own = self.at_rest(&own, &rest);
        match group.law {
            Law::Coupled => None,
            Law::Driven => Some(Forces { rates: own, friction: None }),
            Law::Line | Law::Plane => {
                let signs: Vec<Symbol> =
                    group.velocities.iter().map(|k| self.model.signs.get(k).copied()).collect::<Option<_>>()?;
                let mut friction: Option<Expr> = None;
                for (i, &rate) in own.iter().enumerate() {
                    for (j, &s) in signs.iter().enumerate() {
                        let slope = self.model.system.pool.diff(rate, s);
                        let part = self.model.system.pool.neg(slope);
                        let expected = if i == j { friction } else { Some(self.model.system.pool.int(0)) };
                        let difference = expected.map(|e| self.model.system.pool.sub(part, e));
                        if difference.is_some_and(|d| !self.model.is_zero(d)) {
                            return None;
                        }
                        if i == j {
                            friction = Some(part);
                        }
                    }
                }
                let b = friction?;
                if self.model.system.pool.symbols_of(&[b]).iter().any(|s| signs.contains(s)) {
                    return None;
                }
                let pool = &mut self.model.system.pool;
                let zero = pool.int(0);
                let map: FxHashMap<Expr, Expr> = signs.iter().map(|&s| (pool.sym(s), zero)).collect();
                let rates = pool.substitute_all(&own, &map);
                Some(Forces { rates, friction })
            }
        }
    }

    /// Whether friction balances a group for all admissible inputs while `still` are at rest.
    fn balanced(&mut self, group: usize, still: &[usize], holds: &[Holds]) -> Holds {
        let valued = self.rates.clone();
        let Some(mut forces) = self.forces(group, &valued, still) else { return Holds::Undecided };
        if !self.groups[group].given.iter().all(|k| still.contains(k)) {
            return Holds::Undecided;
        }
        forces.rates = self.with_static_friction(&forces.rates, still, holds);
        forces.friction = forces.friction.map(|b| self.with_static_friction(&[b], still, holds)[0]);
        let conditions = match forces.friction {
            None => forces.rates.iter().flat_map(|&e| [e, self.model.system.pool.neg(e)]).collect::<Vec<Expr>>(),
            Some(b) => {
                let pool = &mut self.model.system.pool;
                if let [a] = forces.rates[..] {
                    vec![pool.sub(b, a), pool.add(b, a)]
                } else {
                    let squares: Vec<Expr> = forces.rates.iter().map(|&a| pool.powi(a, 2)).collect();
                    let (sum, square) = (pool.sum(squares), pool.powi(b, 2));
                    vec![b, pool.sub(square, sum)]
                }
            }
        };
        let answers: Vec<Holds> = conditions.into_iter().map(|e| self.nonnegative(e, still)).collect();
        if answers.contains(&Holds::NotAlways) {
            Holds::NotAlways
        } else if answers.contains(&Holds::Undecided) {
            Holds::Undecided
        } else {
            Holds::Always
        }
    }

    /// Signs of groups that are at rest by the balance of forces there.
    fn with_static_friction(&mut self, list: &[Expr], still: &[usize], holds: &[Holds]) -> Vec<Expr> {
        let valued = self.rates.clone();
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        for g in (0..holds.len()).filter(|&g| holds[g] == Holds::Always) {
            let Some(Forces { rates, friction: Some(b) }) = self.forces(g, &valued, still) else { continue };
            for (k, a) in self.groups[g].velocities.clone().into_iter().zip(rates) {
                if let Some(&s) = self.model.signs.get(&k) {
                    let value = self.model.system.pool.div(a, b);
                    map.insert(self.model.system.pool.sym(s), value);
                }
            }
        }
        self.model.system.pool.substitute_all(list, &map)
    }

    /// Coordinates that do not move while `still` are at rest.
    fn fixed(&mut self, still: &[usize]) -> Vec<bool> {
        let rates: Vec<Expr> = self.model.coordinates.iter().map(|&k| self.rates[k]).collect();
        let rates = self.at_rest(&rates, still);
        rates.into_iter().map(|e| self.model.is_zero(e)).collect()
    }

    /// The interval of every symbol that a condition may have.
    fn span_of(&mut self, s: Symbol, fixed: &[bool]) -> Span {
        for (channel, spans) in self.model.channels.iter().zip(self.inputs) {
            if let Some(order) = channel.symbols.iter().position(|x| *x == Some(s)) {
                return spans[order].clone();
            }
        }
        if self.model.all_signs.contains(&s) || self.speeds.iter().any(|limit| limit.ratio == s) {
            return Span::between(-1.0, 1.0);
        }
        let coordinate = self.model.coordinates.iter().position(|&k| self.model.system.states[k] == s);
        match coordinate {
            Some(c) if fixed[c] && self.model.region[c].is_none() => Span::point(&self.model.at[c]),
            Some(c) if self.place == Where::Near => self.model.neighborhood(c),
            Some(c) => self.model.region[c].clone().unwrap_or(Span::FREE),
            None => Span::FREE,
        }
    }

    /// Whether an expression is nowhere negative for all admissible inputs while `still` are at rest: over their box, or where
    /// this does not tell, with the limits of speeds by place.
    fn nonnegative(&mut self, e: Expr, still: &[usize]) -> Holds {
        let on_box = self.nonnegative_on_box(e, still);
        let limits: FxHashMap<Expr, Expr> =
            self.speeds.iter().map(|limit| (self.model.system.pool.sym(limit.speed), limit.limited)).collect();
        let limited = self.model.system.pool.substitute(e, &limits);
        if on_box == Holds::Always || limited == e {
            return on_box;
        }
        self.nonnegative_on_box(limited, still)
    }

    fn nonnegative_on_box(&mut self, e: Expr, still: &[usize]) -> Holds {
        let fixed = self.fixed(still);
        let symbols = self.model.system.pool.symbols_of(&[e]);
        let spans: Vec<Span> = symbols.iter().map(|&s| self.span_of(s, &fixed)).collect();
        let symbols: Vec<(Symbol, Span)> = symbols.into_iter().zip(spans).collect();
        nonnegative(&mut self.model.system.pool, e, &symbols)
    }

    /// How a coordinate may move: not where its rate vanishes, and one way only where its rate is a velocity that friction keeps
    /// from one sign.
    fn motion(&mut self, coordinate: usize, still: &[usize], holds: &[Holds]) -> Motion {
        if self.fixed(still)[coordinate] {
            return Motion::Never;
        }
        let rate = self.rates[self.model.coordinates[coordinate]];
        let pool = &mut self.model.system.pool;
        let velocity = self.model.velocities.iter().copied().find(|&k| pool.sym(self.model.system.states[k]) == rate);
        let Some(k) = velocity else { return Motion::Open };
        let rests = |list: &[usize]| list.iter().all(|k| still.contains(k));
        let group = (0..holds.len()).find(|&g| self.groups[g].velocities == [k] && rests(&self.groups[g].given));
        let Some(group) = group else { return Motion::Open };
        let valued = self.rates.clone();
        let Some(Forces { rates, friction: Some(b) }) = self.forces(group, &valued, still) else { return Motion::Open };
        let [a, b] = self.with_static_friction(&[rates[0], b], still, holds)[..] else { return Motion::Open };
        let pool = &mut self.model.system.pool;
        let (never_up, never_down) = (pool.sub(b, a), pool.add(b, a));
        if self.nonnegative(never_up, still) == Holds::Always {
            Motion::OnlyDown
        } else if self.nonnegative(never_down, still) == Holds::Always {
            Motion::OnlyUp
        } else {
            Motion::Open
        }
    }

    /// The cone as formulas of parameters, inputs, and coordinates.
    fn cone(&mut self, group: usize, holds: &[Holds], still: &[usize]) -> Cone {
        let velocities = self.groups[group].velocities.clone();
        let names = velocities.iter().map(|&k| self.model.state_name(k)).collect();
        let (symbolic, valued) = (self.model.rates.clone(), self.rates.clone());
        let mut list = Vec::new();
        let mut friction = None;
        // Friction that has the form of its law only for these values of parameters is shown with them.
        let forces = self.forces(group, &symbolic, still).or_else(|| self.forces(group, &valued, still));
        if let Some(forces) = forces {
            let named = self.written_names();
            let pool = &mut self.model.system.pool;
            list = pool.substitute_all(&forces.rates, &named).into_iter().map(|e| pool.text(e)).collect();
            friction = forces.friction.map(|b| {
                let b = pool.substitute(b, &named);
                pool.text(b)
            });
        }
        Cone { velocities: names, rates: list, friction, holds: holds[group] }
    }

    /// Symbols of derivatives of inputs, signs, and directions as they are written in a model file.
    fn written_names(&mut self) -> FxHashMap<Expr, Expr> {
        let pool = &mut self.model.system.pool;
        let mut map = FxHashMap::default();
        for channel in &self.model.channels {
            for (order, symbol) in channel.symbols.iter().enumerate().skip(1) {
                if let Some(s) = symbol {
                    let name = pool.symbol(&derivative_name(&channel.name, order));
                    map.insert(pool.sym(*s), pool.sym(name));
                }
            }
        }
        for (symbol, name) in &self.model.written {
            let shown = pool.symbol(name);
            map.insert(pool.sym(*symbol), pool.sym(shown));
        }
        map
    }
}
