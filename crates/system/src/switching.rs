//! Switching functions, modes and smoothing of `sign`, `abs`, `min`, `max` and of unit vectors.

use std::ops::Range;

use bracketry_symbolic::{Bindings, Expr, Func, Func2, Node, Rational, Symbol};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::directions::Directions;
use crate::system::System;

/// Decimal places of the length that is added to |σ| where its quotients are continuous.
const CONTINUOUS_DIGITS: isize = 9;

/// How the equations behave across the surface of a switch.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SwitchKind {
    /// The right-hand side jumps (`sign`): the system may slide on the surface.
    Jump,
    /// Only its slope jumps (`abs`, `min`, `max`): the surface is merely crossed.
    Kink,
}

/// A switching function σ and the symbol s ∈ Sgn(σ) that stands for its sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Switch {
    /// Printed form of σ; names the switch.
    pub name: String,
    /// s, in the switched form of the equations.
    pub sign: Symbol,
    /// σ, itself free of switches unless they are nested.
    pub surface: Expr,
    /// Jump or kink.
    pub kind: SwitchKind,
}

/// A unit vector σ/|σ|, set-valued in the unit ball where σ = 0: coupled dry friction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitVector {
    /// The components as they are written, with commas; names the vector.
    pub name: String,
    /// The components as they are written; those of σ are positive multiples of them.
    pub components: Vec<Expr>,
    /// Which of the switches are its components.
    pub switches: Range<usize>,
    /// σ², as it stands under the root.
    pub square: Expr,
}

/// A quotient σ/|σ| that is no dry friction, as the direction of a spring: smooth but where σ = 0, which the motion may pass
/// but where it never stays. Where σ = 0, the equations have no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SingularQuotient {
    /// The components as they are written, with commas.
    pub name: String,
    /// The components as they are written; those of σ are positive multiples of them.
    pub components: Vec<Expr>,
    /// σ², as it stands under the root.
    pub square: Expr,
}

/// The equations with the sign of every switching function as an independent symbol.
///
/// `sign(σ)` becomes s, `abs(σ)` becomes s·σ, and `min`, `max` of (a, b) become
/// (a + b ∓ s·(a − b))/2 with σ = a − b.
#[derive(Clone, Debug)]
pub struct SwitchedForm {
    /// Time derivatives of the states.
    pub dynamics: Vec<Expr>,
    /// The outputs, in the order of the system.
    pub outputs: Vec<Expr>,
    /// The switches, in order of appearance; components of unit vectors come last.
    pub switches: Vec<Switch>,
    /// The unit vectors whose components are switches; only [`System::set_valued_form`] looks for them.
    pub unit_vectors: Vec<UnitVector>,
    /// Quotients σ/|σ| that are no dry friction and stay as they are written; looked for with the unit vectors.
    pub singular: Vec<SingularQuotient>,
}

impl SwitchedForm {
    /// The switches that are signs: all but the components of unit vectors.
    pub fn signs(&self) -> &[Switch] {
        let end = self.unit_vectors.first().map_or(self.switches.len(), |v| v.switches.start);
        &self.switches[..end]
    }
}

/// Whether a node is a switch: `sign`, `abs`, `min` or `max`.
pub(crate) fn is_switch(node: Node) -> bool {
    matches!(node, Node::Call(Func::Sign | Func::Abs, _) | Node::Call2(Func2::Min | Func2::Max, ..))
}

/// Fixed signs of all switching functions.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Switch name and its sign, ±1.
    pub signs: Vec<(String, i8)>,
    /// The smooth system that holds in this mode.
    pub system: System,
}

/// More switches than this are not enumerated.
pub const MAX_ENUMERATED_SWITCHES: usize = 10;

/// There are too many modes to enumerate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{switches} switching functions give 2^{switches} modes; at most {MAX_ENUMERATED_SWITCHES} are enumerated")]
pub struct TooManyModes {
    /// Number of switching functions.
    pub switches: usize,
}

impl System {
    /// The equations with the sign of every switching function as a symbol of its own. Unit vectors stay as they are
    /// written: they are smooth but at one point.
    pub fn switched_form(&mut self) -> SwitchedForm {
        let roots = self.rows();
        self.with_sign_symbols(&roots, &[])
    }

    /// The equations with every set-valued part as a symbol of its own: the signs as in [`System::switched_form`], and
    /// the components of unit vectors σ/|σ|, which take any value in the unit ball where σ = 0.
    ///
    /// Set-valued is what is written `unit(vx, vy)`. A quotient over the root of a sum of squares with positive coefficients
    /// whose numerator vanishes with the squares, as in `vx/sqrt(vx^2 + vy^2)` or `w/sqrt(vx^2 + vy^2 + c*w^2)`, is it where
    /// it acts against the rate of its own vector, with a force that does not vanish at rest: as friction acts against a
    /// velocity. Others are smooth and stay: springs along the line between two points, drag.
    ///
    /// ```
    /// use bracketry_system::System;
    /// let text = r#"
    ///     states = ["vx", "vy"]
    ///     parameters = { f = 3 }
    ///     definitions = { rho = "sqrt(vx^2 + vy^2)" }
    ///     dynamics = { vx = "1 - f*vx/rho", vy = "-f*unit(vy, vx)" }
    /// "#;
    /// let form = System::parse("block.toml", text).unwrap().set_valued_form();
    /// assert_eq!(form.unit_vectors.len(), 1);
    /// assert_eq!(form.unit_vectors[0].name, "vx, vy");
    /// ```
    pub fn set_valued_form(&mut self) -> SwitchedForm {
        let mut rows = self.rows();
        let n = self.dynamics.len();
        let lengths = self.lengths(&rows[..n]);
        self.round_at_zero(&mut rows[..n], &lengths);
        self.set_valued_form_of(&rows)
    }

    /// As [`System::set_valued_form`], of other expressions than the equations, such as derivatives of them: as many as there
    /// are equations count as dynamics, the others as outputs. What is set-valued is decided in the equations.
    pub fn set_valued_form_of(&mut self, rows: &[Expr]) -> SwitchedForm {
        let Directions { rewritten: mut roots, roots: vectors, singular, continuous } = self.directions(rows);
        self.round_at_zero(&mut roots, &continuous);
        let last = roots.len();
        for vector in &vectors {
            roots.push(vector.square);
            for c in &vector.components {
                roots.push(self.pool.mul(c.scale, c.base));
            }
        }
        let (rows, extra) = roots.split_at(last);
        let (rows, extra) = (rows.to_vec(), extra.to_vec());
        let mut form = self.with_sign_symbols(&rows, &extra);
        let mut more = form.outputs.split_off(last - form.dynamics.len()).into_iter();
        for vector in vectors {
            let (Some(square), first) = (more.next(), form.switches.len()) else { break };
            let mut names = Vec::new();
            for ((component, &sign), surface) in vector.components.iter().zip(&vector.directions).zip(&mut more) {
                let name = self.pool.text(component.base);
                names.push(name.clone());
                form.switches.push(Switch { name, sign, surface, kind: SwitchKind::Jump });
            }
            let switches = first..form.switches.len();
            let components = vector.components.iter().map(|c| c.base).collect();
            form.unit_vectors.push(UnitVector { name: names.join(", "), components, switches, square });
        }
        for root in singular {
            let components: Vec<Expr> = root.components.iter().map(|c| c.base).collect();
            let names: Vec<String> = components.iter().map(|&c| self.pool.text(c)).collect();
            form.singular.push(SingularQuotient { name: names.join(", "), components, square: root.square });
        }
        form
    }

    /// Adds the square of a length that no result shows to those squares |σ|² whose roots are continuous at σ = 0, so that
    /// equations and derivatives have their values there instead of 0/0.
    fn round_at_zero(&mut self, rows: &mut [Expr], squares: &[Expr]) {
        if squares.is_empty() {
            return;
        }
        let tiny = self.pool.rational(Rational::ONE / Rational::from(10u8).pow(2 * CONTINUOUS_DIGITS));
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        for e in self.pool.reachable(rows) {
            if let Node::Pow(base, exponent) = self.pool.node(e)
                && squares.contains(&base)
                && self.pool.number(exponent).is_some_and(|k| !k.is_int())
            {
                let rounded = self.pool.add(base, tiny);
                let power = self.pool.pow(rounded, exponent);
                map.insert(e, power);
            }
        }
        let rounded = self.pool.substitute_all(rows, &map);
        rows.copy_from_slice(&rounded);
    }

    /// The equations, then the outputs.
    pub(crate) fn rows(&self) -> Vec<Expr> {
        self.dynamics.iter().copied().chain(self.outputs.iter().map(|(_, e)| *e)).collect()
    }

    /// The switched form of equations and outputs `rows`; `extra` expressions follow the outputs.
    fn with_sign_symbols(&mut self, rows: &[Expr], extra: &[Expr]) -> SwitchedForm {
        let roots = [rows, extra].concat();
        let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
        let mut switches: Vec<Switch> = Vec::new();
        for e in self.pool.reachable(&roots) {
            let node = self.pool.node(e);
            let new = match node {
                Node::Call(Func::Sign, a) => {
                    let surface = image[&a];
                    self.switch(&mut switches, surface, SwitchKind::Jump)
                }
                Node::Call(Func::Abs, a) => {
                    let surface = image[&a];
                    let s = self.switch(&mut switches, surface, SwitchKind::Kink);
                    self.pool.mul(s, surface)
                }
                Node::Call2(f @ (Func2::Min | Func2::Max), a, b) => {
                    let (a, b) = (image[&a], image[&b]);
                    let gap = self.pool.sub(a, b);
                    let s = self.switch(&mut switches, gap, SwitchKind::Kink);
                    let size = self.pool.mul(s, gap);
                    let size = if f == Func2::Min { self.pool.neg(size) } else { size };
                    let sum = self.pool.add(a, b);
                    let twice = self.pool.add(sum, size);
                    let half = self.pool.ratio(1, 2);
                    self.pool.mul(half, twice)
                }
                _ => self.pool.rebuild(e, |o| image[&o]),
            };
            image.insert(e, new);
        }
        let n = self.dynamics.len().min(rows.len());
        let all: Vec<Expr> = roots.iter().map(|e| image[e]).collect();
        SwitchedForm {
            dynamics: all[..n].to_vec(),
            outputs: all[n..].to_vec(),
            switches,
            unit_vectors: Vec::new(),
            singular: Vec::new(),
        }
    }

    /// The expression for the sign of `surface`: a number for a constant. A surface and its negative share one switch.
    fn switch(&mut self, switches: &mut Vec<Switch>, surface: Expr, kind: SwitchKind) -> Expr {
        if self.pool.symbols_of(&[surface]).is_empty()
            && let Some(sign) = self.pool.constant_sign(surface, &Bindings::new())
        {
            return self.pool.int(sign as i64);
        }
        let negative = self.pool.neg(surface);
        for s in switches.iter_mut() {
            if s.surface == surface || s.surface == negative {
                if kind == SwitchKind::Jump {
                    s.kind = kind;
                }
                let e = self.pool.sym(s.sign);
                return if s.surface == surface { e } else { self.pool.neg(e) };
            }
        }
        let name = self.pool.text(surface);
        let sign = self.pool.symbol(&format!("sgn({name})"));
        switches.push(Switch { name, sign, surface, kind });
        self.pool.sym(sign)
    }

    /// This system with the signs of its switched form replaced.
    fn with_signs(mut self, form: &SwitchedForm, signs: &FxHashMap<Expr, Expr>) -> System {
        self.dynamics = self.pool.substitute_all(&form.dynamics, signs);
        let outputs = self.pool.substitute_all(&form.outputs, signs);
        for (o, e) in self.outputs.iter_mut().zip(outputs) {
            o.1 = e;
        }
        self
    }

    /// Every combination of fixed signs; one mode without signs if there is no switch.
    ///
    /// # Errors
    /// [`TooManyModes`] beyond [`MAX_ENUMERATED_SWITCHES`] switches.
    pub fn modes(&self) -> Result<Vec<Mode>, TooManyModes> {
        let mut base = self.clone();
        let form = base.switched_form();
        let k = form.switches.len();
        if k > MAX_ENUMERATED_SWITCHES {
            return Err(TooManyModes { switches: k });
        }
        let mut modes = Vec::with_capacity(1 << k);
        for bits in 0..1usize << k {
            let signs: Vec<i8> = (0..k).map(|i| if bits >> (k - 1 - i) & 1 == 0 { 1 } else { -1 }).collect();
            let fixed = form
                .switches
                .iter()
                .zip(&signs)
                .map(|(switch, &s)| (base.pool.sym(switch.sign), base.pool.int(i64::from(s))));
            let fixed = fixed.collect();
            let system = base.clone().with_signs(&form, &fixed);
            let signs = form.switches.iter().map(|s| s.name.clone()).zip(signs).collect();
            modes.push(Mode { signs, system });
        }
        Ok(modes)
    }

    /// The smooth signs of a switched form, to be substituted in its expressions: s ↦ tanh(σ/width) for every sign,
    /// σ/√(σ² + width²) for a unit vector, whose root |σ| is rounded likewise wherever it stands.
    /// `width` is any expression: a number, or a symbol that gets its value when the expressions are compiled.
    pub fn smooth_signs(&mut self, form: &SwitchedForm, width: Expr) -> FxHashMap<Expr, Expr> {
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        for s in form.signs() {
            // The surface of a nested switch holds the signs of inner ones, which come first.
            let surface = self.pool.substitute(s.surface, &map);
            let ratio = self.pool.div(surface, width);
            let (sign, smooth) = (self.pool.sym(s.sign), self.pool.call(Func::Tanh, ratio));
            map.insert(sign, smooth);
        }
        if form.unit_vectors.is_empty() {
            return map;
        }
        let everything: Vec<Expr> =
            form.dynamics.iter().chain(&form.outputs).copied().chain(form.switches.iter().map(|s| s.surface)).collect();
        let nodes = self.pool.reachable(&everything);
        for vector in &form.unit_vectors {
            let square = self.pool.substitute(vector.square, &map);
            let width_squared = self.pool.powi(width, 2);
            let rounded = self.pool.add(square, width_squared);
            for &e in &nodes {
                if let Node::Pow(base, exponent) = self.pool.node(e)
                    && base == vector.square
                    && self.pool.number(exponent).is_some_and(|k| !k.is_int())
                {
                    let power = self.pool.pow(rounded, exponent);
                    map.insert(e, power);
                }
            }
            let size = self.pool.sqrt(rounded);
            for s in &form.switches[vector.switches.clone()] {
                let surface = self.pool.substitute(s.surface, &map);
                let (sign, smooth) = (self.pool.sym(s.sign), self.pool.div(surface, size));
                map.insert(sign, smooth);
            }
        }
        map
    }

    /// The smooth system in which the sign of every σ is tanh(σ/width), and every unit vector σ/√(σ² + width²); see
    /// [`System::smooth_signs`].
    #[must_use]
    pub fn smoothed(&self, width: Expr) -> System {
        let mut system = self.clone();
        let form = system.set_valued_form();
        let signs = system.smooth_signs(&form, width);
        system.with_signs(&form, &signs)
    }

    /// Whether the equations and outputs have no set-valued part and no kink: no `sign`, `abs`, `min`, `max` and no unit
    /// vector, which is what [`System::set_valued_form`] finds.
    pub fn is_smooth(&self) -> bool {
        self.clone().set_valued_form().switches.is_empty()
    }
}
