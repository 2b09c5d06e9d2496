//! Switching functions, modes and smoothing of `sign`, `abs`, `min` and `max`.

use bracketry_symbolic::{Expr, Func, Func2, Node, Symbol};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::system::System;

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
    /// The switches, in order of appearance.
    pub switches: Vec<Switch>,
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
    /// The equations with every switch as a symbol of its own.
    pub fn switched_form(&mut self) -> SwitchedForm {
        let mut roots = self.dynamics.clone();
        roots.extend(self.outputs.iter().map(|(_, e)| *e));
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
        let n = self.dynamics.len();
        let all: Vec<Expr> = roots.iter().map(|e| image[e]).collect();
        SwitchedForm { dynamics: all[..n].to_vec(), outputs: all[n..].to_vec(), switches }
    }

    /// The expression for the sign of `surface`. A surface and its negative share one switch.
    fn switch(&mut self, switches: &mut Vec<Switch>, surface: Expr, kind: SwitchKind) -> Expr {
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

    /// This system with the signs of a switched form replaced.
    fn with_signs(&mut self, form: &SwitchedForm, signs: &FxHashMap<Expr, Expr>) -> System {
        let mut system = self.clone();
        system.dynamics = system.pool.substitute_all(&form.dynamics, signs);
        let outputs = system.pool.substitute_all(&form.outputs, signs);
        for (o, e) in system.outputs.iter_mut().zip(outputs) {
            o.1 = e;
        }
        system
    }

    /// Every combination of fixed signs; one mode without signs if there is no switch.
    ///
    /// # Errors
    /// [`TooManyModes`] beyond [`MAX_ENUMERATED_SWITCHES`] switches.
    pub fn modes(&mut self) -> Result<Vec<Mode>, TooManyModes> {
        let form = self.switched_form();
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
                .map(|(switch, &s)| (self.pool.sym(switch.sign), self.pool.int(i64::from(s))));
            let fixed = fixed.collect();
            let system = self.with_signs(&form, &fixed);
            let signs = form.switches.iter().map(|s| s.name.clone()).zip(signs).collect();
            modes.push(Mode { signs, system });
        }
        Ok(modes)
    }

    /// The smooth signs of a switched form: s ↦ tanh(σ/width) for every switch, to be substituted in its expressions.
    /// `width` is any expression: a number, or a symbol that gets its value when the expressions are compiled.
    pub fn smooth_signs(&mut self, form: &SwitchedForm, width: Expr) -> FxHashMap<Expr, Expr> {
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        for s in &form.switches {
            // The surface of a nested switch holds the signs of inner ones, which come first.
            let surface = self.pool.substitute(s.surface, &map);
            let ratio = self.pool.div(surface, width);
            let (sign, smooth) = (self.pool.sym(s.sign), self.pool.call(Func::Tanh, ratio));
            map.insert(sign, smooth);
        }
        map
    }

    /// The smooth system in which the sign of every σ is tanh(σ/width); see [`System::smooth_signs`].
    #[must_use]
    pub fn smoothed(&mut self, width: Expr) -> System {
        let form = self.switched_form();
        let signs = self.smooth_signs(&form, width);
        self.with_signs(&form, &signs)
    }
}
