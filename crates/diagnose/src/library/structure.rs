//! What a model is made of mechanically: coordinates and their rates, kinds, forces, dry friction, gravity.

use bracketry_symbolic::{Expr, Func, Node, Symbol};
use bracketry_system::{SwitchKind, System, TimeUnit};
use rustc_hash::FxHashMap;

use super::probe::Probe;
use super::terms::{proportional, slope};

/// What a coordinate measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Translation,
    Angle,
}

impl Kind {
    /// Unit of the coordinate.
    pub(crate) fn unit(self) -> &'static str {
        match self {
            Kind::Translation => "m",
            Kind::Angle => "rad",
        }
    }
}

/// Dry friction against one rate: the part of the equations that is proportional to a sign or to a component of a unit
/// vector.
#[derive(Clone, Debug)]
pub(crate) struct DryFriction {
    /// The sign or the component, as it is written in the equations.
    pub(crate) direction: Expr,
    /// The square of the slip speed, if the direction is a component of a unit vector.
    pub(crate) square: Option<Expr>,
    /// What the equations lose where the direction is 1, by row.
    pub(crate) level: Vec<(usize, Expr)>,
    /// The parameter that the level is proportional to and that nothing else depends on.
    pub(crate) coefficient: Option<Symbol>,
}

/// A generalized coordinate with an equation of motion.
#[derive(Clone, Debug)]
pub(crate) struct Coordinate {
    /// Index of the state q; none for a rate without position.
    pub(crate) position: Option<usize>,
    /// Index of the state v whose equation is that of motion.
    pub(crate) rate: usize,
    /// What it measures.
    pub(crate) kind: Kind,
    /// What a unit of force against this coordinate adds to the equations, by row.
    pub(crate) force: Vec<(usize, Expr)>,
    /// The input that acts as this force.
    pub(crate) input: Option<usize>,
    /// Dry friction against exactly this rate.
    pub(crate) friction: Option<DryFriction>,
    /// Whether any switching function, steep function or unit vector of this rate acts in its equation.
    pub(crate) has_dry_friction: bool,
    /// Unit of the coordinate.
    pub(crate) length_unit: String,
    /// Symbol of the unit of time; empty for a time without unit.
    pub(crate) time_unit: &'static str,
    /// Unit of the force.
    pub(crate) force_unit: String,
}

impl Coordinate {
    /// Unit of a coefficient that multiplies the coordinate `q` times and its rate `v` times to give a force; empty if that
    /// of the force is not known.
    pub(crate) fn unit(&self, q: i32, v: i32) -> String {
        let (length, time) = (self.length_unit.as_str(), self.time_unit);
        let power = |base: &str, k: i32| match k {
            0 => String::new(),
            _ if base.is_empty() => String::new(),
            1 => base.to_owned(),
            _ => format!("{base}^{k}"),
        };
        let join = |parts: [String; 2]| parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join(" ");
        if self.force_unit.is_empty() {
            return String::new();
        }
        let degree = q + v;
        if self.input.is_none() {
            // m/s² over m^degree s^-v
            let above = power(length, 1 - degree.min(1));
            let below = join([power(length, (degree - 1).max(0)), power(time, 2 - v)]);
            return match (above.is_empty(), below.is_empty(), below.contains(' ')) {
                (_, true, _) if above.is_empty() => "1".to_owned(),
                (_, true, _) => above,
                (true, _, false) => format!("1/{below}"),
                (true, _, true) => format!("1/({below})"),
                (false, _, _) => format!("{above}/{below}"),
            };
        }
        let above = join([self.force_unit.clone(), power(time, v)]);
        let degree = if length.is_empty() { 0 } else { degree };
        if degree == 0 { above } else { format!("{above}/{}", power(length, degree)) }
    }
}

impl Coordinate {
    /// Unit of the rate.
    pub(crate) fn speed_unit(&self) -> String {
        if self.time_unit.is_empty() {
            self.length_unit.clone()
        } else {
            format!("{}/{}", self.length_unit, self.time_unit)
        }
    }

    /// A joint: a rotation, or a translation with a drive of its own.
    pub(crate) fn is_joint(&self) -> bool {
        self.position.is_some() && (self.kind == Kind::Angle || self.input.is_some())
    }

    /// Unit of an inertia against this coordinate; empty if that of the force is not known.
    pub(crate) fn inertia_unit(&self) -> String {
        match (self.input, self.force_unit.as_str()) {
            (None, _) => "1".to_owned(),
            (_, "N") => "kg".to_owned(),
            (_, "N m") => "kg m^2".to_owned(),
            _ => String::new(),
        }
    }
}

/// The structure of a model.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    /// Generalized coordinates.
    pub(crate) coordinates: Vec<Coordinate>,
    /// States whose equations are of first order: neither rates of coordinates nor kinematics.
    pub(crate) others: Vec<usize>,
    /// The parameter that is gravity.
    pub(crate) gravity: Option<Symbol>,
}

impl Structure {
    pub(crate) fn of(system: &mut System, pairs: &[(usize, usize)]) -> Self {
        let probe = Probe::fixed(system);
        let rates = rates_without_position(system, pairs);
        let gravity = gravity(system);
        let mut taken = Vec::new();
        let list: Vec<(Option<usize>, usize)> =
            pairs.iter().map(|&(q, v)| (Some(q), v)).chain(rates.iter().map(|&v| (None, v))).collect();
        let joints = list.len() > 1;
        let mut coordinates = Vec::new();
        for &(position, rate) in &list {
            let kind = kind(system, position, rate, joints);
            let input = own_input(system, &probe, rate, &taken);
            taken.extend(input);
            let friction = dry_friction(system, rate);
            let force = match input {
                Some(u) => column(system, u, rate),
                None => vec![(rate, system.pool.int(1))],
            };
            let length_unit = length_unit(system, position, kind);
            let force_unit = force_unit(system, rate, (kind, &length_unit), input, friction.as_ref());
            let time_unit = system.quantities.time_unit.name();
            let has_dry_friction = friction.is_some() || resists(system, rate);
            coordinates.push(Coordinate {
                position,
                rate,
                kind,
                force,
                input,
                friction,
                has_dry_friction,
                length_unit,
                time_unit,
                force_unit,
            });
        }
        let known = |i: usize| list.iter().any(|&(q, v)| q == Some(i) || v == i);
        let others = (0..system.states.len()).filter(|&i| !known(i)).collect();
        Structure { coordinates, others, gravity }
    }

    /// The structure of a model by itself.
    pub(crate) fn of_model(system: &mut System) -> Self {
        let pairs = pairs(system);
        Self::of(system, &pairs)
    }

    /// The translations among the coordinates.
    pub(crate) fn translations(&self) -> impl Iterator<Item = &Coordinate> {
        self.coordinates.iter().filter(|c| c.kind == Kind::Translation)
    }
}

/// What is neither a state nor an input nor a derivative of one: parameters.
pub(crate) fn is_constant(system: &System, e: Expr) -> bool {
    system.pool.symbols_of(&[e]).iter().all(|s| system.parameters.iter().any(|p| p.symbol == *s))
}

/// Pairs (q, v) of states with q' = k v, k constant. Heads of chains come first, so that of q' = v, v' = a the state v is
/// a rate and a is none.
pub(crate) fn pairs(system: &mut System) -> Vec<(usize, usize)> {
    let states = system.states.clone();
    let moving = system.arguments();
    let mut edges = Vec::new();
    for q in 0..states.len() {
        let f = system.dynamics[q];
        let used: Vec<Symbol> = system.pool.symbols_of(&[f]).into_iter().filter(|s| moving.contains(s)).collect();
        let [only] = used[..] else { continue };
        let Some(v) = states.iter().position(|&s| s == only).filter(|&v| v != q) else { continue };
        if proportional(&mut system.pool, f, only).is_some_and(|slope| is_constant(system, slope)) {
            edges.push((q, v));
        }
    }
    let targets: Vec<usize> = edges.iter().map(|e| e.1).collect();
    edges.sort_by_key(|&(q, _)| (targets.contains(&q), q));
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (q, v) in edges {
        if pairs.iter().all(|&(a, b)| a != q && b != q && a != v && b != v) {
            pairs.push((q, v));
        }
    }
    pairs.sort_unstable();
    pairs
}

/// States that are rates although no position is kept: dry friction or a name says so.
fn rates_without_position(system: &mut System, pairs: &[(usize, usize)]) -> Vec<usize> {
    let free: Vec<usize> =
        (0..system.states.len()).filter(|i| pairs.iter().all(|&(q, v)| q != *i && v != *i)).collect();
    free.into_iter()
        .filter(|&i| {
            let name = system.symbol_name(system.states[i]).to_lowercase();
            let rest = name.strip_prefix(['v', 'w', 'ω']).map(|r| r.chars().next().is_none_or(|c| !c.is_alphabetic()));
            let named =
                rest == Some(true) || ["vel", "omega", "speed", "vx", "vy", "vz"].iter().any(|n| name.starts_with(n));
            named || dry_friction(system, i).is_some()
        })
        .collect()
}

/// The parameter that is the acceleration of gravity: by its size and name or unit.
fn gravity(system: &System) -> Option<Symbol> {
    system
        .parameters
        .iter()
        .find(|p| {
            let name = system.symbol_name(p.symbol).to_lowercase();
            let size = p.value.to_f64().value();
            let unit = p.unit.as_deref().unwrap_or("").replace(' ', "");
            (9.7..9.9).contains(&size) && (name.starts_with('g') || unit == "m/s^2" || unit == "m/s2")
        })
        .map(|p| p.symbol)
}

/// Names by which angles usually go.
const ANGLES: [&str; 16] = [
    "th", "phi", "psi", "alpha", "beta", "gamma", "angle", "ang", "rot", "yaw", "pitch", "roll", "omega", "heading",
    "tilt", "varphi",
];

fn kind(system: &mut System, position: Option<usize>, rate: usize, joints: bool) -> Kind {
    if let Some(q) = position.map(|q| system.states[q])
        && is_angle(system, q)
    {
        return Kind::Angle;
    }
    let name = |i: usize| system.symbol_name(system.states[i]).to_lowercase();
    let named = |n: &str| ANGLES.iter().any(|a| n.starts_with(a));
    if named(&name(rate)) || name(rate).starts_with(['w', 'ω']) || position.is_some_and(|q| named(&name(q))) {
        return Kind::Angle;
    }
    // Torques and inertias about an axis, not forces and masses.
    let used = system.pool.symbols_of(&[system.dynamics[rate]]);
    let units: Vec<String> = system
        .parameters
        .iter()
        .filter(|p| used.contains(&p.symbol))
        .filter_map(|p| p.unit.as_deref().map(|u| u.replace([' ', '*', '·', '.'], "").to_lowercase()))
        .collect();
    if units.iter().any(|u| u.starts_with("nm") || u.starts_with("kgm") || u.contains("rad")) {
        return Kind::Angle;
    }
    // Several coordinates q1, q2, … are joints.
    let joint = position.is_some_and(|q| name(q).starts_with('q') || name(q).starts_with("joint"));
    if joint && joints && units.is_empty() { Kind::Angle } else { Kind::Translation }
}

/// Whether a state or input stands in a sine or cosine with a plain number as factor; a ratio of lengths, as in the
/// cogging of a linear drive, has a parameter or π there.
pub(crate) fn is_angle(system: &mut System, s: Symbol) -> bool {
    let mut roots = system.dynamics.clone();
    roots.extend(system.outputs.iter().map(|o| o.1));
    system.pool.reachable(&roots).into_iter().any(|e| match system.pool.node(e) {
        Node::Call(Func::Sin | Func::Cos | Func::Tan, a) => {
            let slope = slope(&mut system.pool, a, s);
            system.pool.number(slope).is_some() && !system.pool.is_zero(slope)
        }
        _ => false,
    })
}

/// The column of an input in the equations, oriented so that it drives the rate forward.
fn column(system: &mut System, input: usize, rate: usize) -> Vec<(usize, Expr)> {
    let u = system.inputs[input];
    let mut rows = Vec::new();
    for row in 0..system.dynamics.len() {
        let d = slope(&mut system.pool, system.dynamics[row], u);
        if !system.pool.is_zero(d) {
            rows.push((row, d));
        }
    }
    let own = rows.iter().find(|r| r.0 == rate).map(|r| r.1);
    let backward = own.is_some_and(|e| Probe::fixed(system).values(system, &[e]).iter().all(|v| v[0] < 0.0));
    if backward {
        for r in &mut rows {
            r.1 = system.pool.neg(r.1);
        }
    }
    rows
}

/// The input that acts as a force on the coordinate: the equations are affine in it, and its part in the equation of
/// motion depends on no rate and never changes its sign, as a diagonal entry of an inverse mass matrix.
fn own_input(system: &mut System, probe: &Probe, rate: usize, taken: &[usize]) -> Option<usize> {
    let states = system.states.clone();
    let moving = system.arguments();
    for input in 0..system.inputs.len() {
        if taken.contains(&input) {
            continue;
        }
        let u = system.inputs[input];
        let d = slope(&mut system.pool, system.dynamics[rate], u);
        if system.pool.is_zero(d) {
            continue;
        }
        let used = system.pool.symbols_of(&[d]);
        let geometric = used.iter().all(|s| !moving.contains(s) || (states.contains(s) && *s != states[rate]));
        let values = probe.values(system, &[d]);
        let one_sign = values.iter().all(|v| v[0] > 0.0) || values.iter().all(|v| v[0] < 0.0);
        if geometric && one_sign {
            return Some(input);
        }
    }
    None
}

/// The dry friction against exactly the rate: a sign of it, or the component of a unit vector.
fn dry_friction(system: &mut System, rate: usize) -> Option<DryFriction> {
    let form = system.set_valued_form();
    let v = system.states[rate];
    let follows = |system: &mut System, e: Expr| {
        let factor = proportional(&mut system.pool, e, v);
        factor.is_some_and(|d| !system.pool.is_zero(d) && is_constant(system, d))
    };
    let mut directions: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (i, s) in form.switches.iter().enumerate() {
        let symbol = system.pool.sym(s.sign);
        let written = match form.unit_vectors.iter().find(|u| u.switches.contains(&i)) {
            Some(u) => {
                let size = system.pool.sqrt(u.square);
                system.pool.div(s.surface, size)
            }
            None => system.pool.call(Func::Sign, s.surface),
        };
        let written = system.pool.substitute(written, &directions);
        directions.insert(symbol, written);
    }
    for (i, s) in form.switches.iter().enumerate() {
        if s.kind != SwitchKind::Jump || !follows(system, s.surface) {
            continue;
        }
        let symbol = system.pool.sym(s.sign);
        let mut level = Vec::new();
        for (row, &f) in form.dynamics.iter().enumerate() {
            let d = system.pool.diff(f, s.sign);
            if system.pool.depends_on(d, s.sign) {
                continue;
            }
            let d = system.pool.substitute(d, &directions);
            let d = system.pool.neg(d);
            let d = system.pool.simplify(d);
            if !system.pool.is_zero(d) {
                level.push((row, d));
            }
        }
        if level.iter().all(|l| l.0 != rate) {
            continue;
        }
        let coefficient = friction_coefficient(system, &level, &form.dynamics, s.sign);
        return Some(DryFriction {
            direction: directions[&symbol],
            square: form.unit_vectors.iter().find(|u| u.switches.contains(&i)).map(|u| u.square),
            level,
            coefficient,
        });
    }
    None
}

/// The parameter that all levels are proportional to, and that the equations have nowhere but in dry friction.
fn friction_coefficient(
    system: &mut System,
    level: &[(usize, Expr)],
    dynamics: &[Expr],
    sign: Symbol,
) -> Option<Symbol> {
    let parameters: Vec<Symbol> = system.parameters.iter().map(|p| p.symbol).collect();
    let zero = system.pool.int(0);
    let s = system.pool.sym(sign);
    let frictionless: FxHashMap<Expr, Expr> = std::iter::once((s, zero)).collect();
    let without: Vec<Expr> = system.pool.substitute_all(dynamics, &frictionless);
    let mut best = None;
    for p in parameters {
        let is_factor =
            |&(_, e): &(usize, Expr)| proportional(&mut system.pool, e, p).is_some_and(|d| !system.pool.is_zero(d));
        if !level.iter().all(is_factor) {
            continue;
        }
        let elsewhere = level.iter().any(|&(row, _)| system.pool.depends_on(without[row], p));
        if !elsewhere {
            return Some(p);
        }
        // Two axes with one coefficient: it stands in the other equation, too.
        let name = system.symbol_name(p).to_lowercase();
        if name.starts_with("mu") {
            best = Some(p);
        }
    }
    best
}

/// Whether the equation of a rate contains a sign, a unit vector or a steep odd function of it.
fn resists(system: &mut System, rate: usize) -> bool {
    let v = system.states[rate];
    let f = system.dynamics[rate];
    let nodes = system.pool.reachable(&[f]);
    nodes.into_iter().any(|e| {
        let inner = match system.pool.node(e) {
            Node::Call(Func::Sign | Func::Tanh | Func::Atan, a) => a,
            Node::Pow(a, k) if system.pool.number(k).is_some_and(|k| !k.is_int() && k.to_f64().value() < 0.0) => a,
            _ => return false,
        };
        system.pool.depends_on(inner, v)
    })
}

/// The unit that the model states of a coordinate, else that of its kind; a model in scaled time has none.
fn length_unit(system: &System, position: Option<usize>, kind: Kind) -> String {
    let stated = position.and_then(|q| system.quantities.unit(system.symbol_name(system.states[q])));
    match system.quantities.time_unit {
        _ if stated.is_some() => stated.unwrap_or_default().to_owned(),
        TimeUnit::Dimensionless => String::new(),
        _ => kind.unit().to_owned(),
    }
}

fn force_unit(
    system: &System,
    rate: usize,
    (kind, length): (Kind, &str),
    input: Option<usize>,
    friction: Option<&DryFriction>,
) -> String {
    let Some(input) = input else {
        let time = system.quantities.time_unit.name();
        return if time.is_empty() { length.to_owned() } else { format!("{length}/{time}^2") };
    };
    if let Some(stated) = system.quantities.unit(system.symbol_name(system.inputs[input])) {
        return stated.to_owned();
    }
    let unit_of = |s: Symbol| system.parameters.iter().find(|p| p.symbol == s).and_then(|p| p.unit.clone());
    if let Some(unit) = friction.and_then(|f| f.coefficient).and_then(unit_of)
        && unit.trim_start().starts_with('N')
    {
        return unit;
    }
    let used = system.pool.symbols_of(&[system.dynamics[rate]]);
    let has_mass = system
        .parameters
        .iter()
        .any(|p| used.contains(&p.symbol) && p.unit.as_deref().is_some_and(|u| u.trim_start().starts_with("kg")));
    match (has_mass, kind) {
        (true, Kind::Translation) => "N".to_owned(),
        (true, Kind::Angle) => "N m".to_owned(),
        (false, _) => String::new(),
    }
}
