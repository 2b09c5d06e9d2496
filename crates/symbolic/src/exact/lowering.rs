//! A field program under construction, with the values of its registers at trial points.

use std::cell::OnceCell;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::Undecided;
use super::character::Character;
use super::combinations::LinearRelations;
use super::field::Residue;
use super::kernels::{Circle, ExpLog, Roots};
use super::program::{Generator, Program, Reg, Step, draw};
use crate::node::Expr;
use crate::pool::Pool;
use crate::random::SplitMix64;

/// Fractions in linear relations have numerators and denominators up to this.
pub(super) const FRACTION_BOUND: u64 = 1 << 20;
/// Trial points are not increased for more roots.
const MAX_CONDITIONS: u32 = 8;
/// Characters of an expression that a reason names.
const MAX_TEXT: usize = 120;
const TRIAL_SEED: u64 = 0x7269_616c;

/// Why lowering stopped.
pub(super) enum Stop {
    /// A generator must be a power of a finer one, which is noted; the lowering is restarted.
    Restart,
    /// The field lacks a constant; another prime may have it.
    OtherPrime(Undecided),
    /// No verdict.
    Undecided(Undecided),
}

impl From<Undecided> for Stop {
    fn from(u: Undecided) -> Self {
        Stop::Undecided(u)
    }
}

/// Values of a register at the trial points; none where a root or quotient does not exist.
type Column<const C: u64> = Vec<Option<Residue<C>>>;

/// What earlier attempts found out about generators.
#[derive(Default)]
pub(super) struct Requirements {
    /// Angle number j is D_j times its generator.
    pub(super) angles: FxHashMap<usize, u64>,
    /// Exponent number j is D_j times its generator.
    pub(super) exponents: FxHashMap<usize, u64>,
    /// Radicands of which 2^K-th roots are needed, by register of the radicand.
    pub(super) levels: FxHashMap<Expr, u32>,
    /// Trial points, if more than usual.
    pub(super) trials: usize,
}

/// Program under construction.
pub(super) struct Lowering<'a, const C: u64> {
    pub(super) pool: &'a Pool,
    pub(super) exact: FxHashMap<Expr, RBig>,
    pub(super) program: Program<C>,
    pub(super) registers: FxHashMap<Expr, Reg>,
    rng: SplitMix64,
    points: Vec<Vec<Residue<C>>>,
    columns: Vec<Option<Column<C>>>,
    /// Registers that depend on the root of a square, whose sign is open.
    open: Vec<bool>,
    pub(super) watching: bool,
    pub(super) requirements: &'a mut Requirements,
    pi: Option<Reg>,
    pub(super) circle: Circle,
    pub(super) explog: ExpLog,
    pub(super) roots: Roots,
    pub(super) relations: LinearRelations<C>,
    pub(super) character: OnceCell<Character<C>>,
    /// Large factors of integer constants met so far.
    pub(super) found: Vec<u64>,
}

impl<'a, const C: u64> Lowering<'a, C> {
    /// An empty program, followed at that many trial points.
    pub(super) fn new(
        pool: &'a Pool,
        exact: FxHashMap<Expr, RBig>,
        trials: usize,
        requirements: &'a mut Requirements,
    ) -> Self {
        Lowering {
            pool,
            exact,
            program: Program::default(),
            registers: FxHashMap::default(),
            rng: SplitMix64::new(TRIAL_SEED),
            points: vec![Vec::new(); trials],
            columns: Vec::new(),
            open: Vec::new(),
            watching: false,
            requirements,
            pi: None,
            circle: Circle::default(),
            explog: ExpLog::default(),
            roots: Roots::default(),
            relations: LinearRelations::default(),
            character: OnceCell::new(),
            found: Vec::new(),
        }
    }
}

impl<const C: u64> Lowering<'_, C> {
    /// Appends a step and, where it matters, its values at the trial points.
    pub(super) fn push(&mut self, step: Step<C>) -> Reg {
        let column = self.watching.then(|| {
            (0..self.points.len())
                .map(|i| {
                    let operand = |r: Reg| self.columns[r].as_ref().and_then(|c| c[i]);
                    match step {
                        Step::Const(_) | Step::Slot(_) => {}
                        Step::Add(a, b) | Step::Mul(a, b) | Step::Turn { x: a, y: b, .. } => {
                            operand(a)?;
                            operand(b)?;
                        }
                        Step::Inverse(a) | Step::Power(a, _) | Step::Root(a, _) => {
                            operand(a)?;
                        }
                    }
                    Program::value(step, &self.points[i], |r| operand(r).unwrap_or_default()).ok()
                })
                .collect()
        });
        self.columns.push(column);
        self.open.push(match step {
            Step::Const(_) | Step::Slot(_) => false,
            Step::Add(a, b) | Step::Mul(a, b) | Step::Turn { x: a, y: b, .. } => self.open[a] || self.open[b],
            Step::Inverse(a) | Step::Power(a, _) | Step::Root(a, _) => self.open[a],
        });
        self.program.push(step)
    }

    pub(super) fn generator(&mut self, g: Generator) -> usize {
        for p in &mut self.points {
            draw(g, &mut self.rng, p);
        }
        self.program.generator(g)
    }

    pub(super) fn constant(&mut self, c: Residue<C>) -> Reg {
        self.push(Step::Const(c))
    }

    pub(super) fn scaled(&mut self, c: Residue<C>, r: Reg) -> Reg {
        if c == Residue::ONE {
            return r;
        }
        let k = self.constant(c);
        self.push(Step::Mul(k, r))
    }

    pub(super) fn quotient(&mut self, a: Reg, b: Reg) -> Reg {
        let i = self.push(Step::Inverse(b));
        self.push(Step::Mul(a, i))
    }

    /// π, a transcendental number, is a generator.
    pub(super) fn pi(&mut self) -> Reg {
        if let Some(r) = self.pi {
            return r;
        }
        let s = self.generator(Generator::Free);
        let r = self.watched(|l| l.push(Step::Slot(s)));
        self.pi = Some(r);
        r
    }

    /// Runs `f` with all registers evaluated at the trial points, because later kernels may use them.
    pub(super) fn watched<T>(&mut self, f: impl FnOnce(&mut Self) -> T) -> T {
        let watching = std::mem::replace(&mut self.watching, true);
        let r = f(self);
        self.watching = watching;
        r
    }

    /// Up to `n` trial points at which all `registers` have values.
    pub(super) fn trials(&self, registers: &[Reg], n: usize) -> Vec<usize> {
        let has = |i: usize| registers.iter().all(|&r| self.trial(r, i).is_some());
        (0..self.points.len()).filter(|&i| has(i)).take(n).collect()
    }

    /// What to do where too few of the trial points give values to the argument of `e`: each root exists at half of them.
    pub(super) fn few_trials(&mut self, e: Expr, needed: usize, reason: &'static str) -> Stop {
        let wanted = needed << self.roots.conditions.min(MAX_CONDITIONS);
        if wanted > self.points.len() {
            self.requirements.trials = wanted;
            return Stop::Restart;
        }
        self.kernel(e, reason)
    }

    /// Marks a register as the root of a square.
    pub(super) fn open_sign(&mut self, r: Reg) {
        self.open[r] = true;
    }

    /// Refuses the argument of a kernel if its sign is open: relations with other kernels would go unnoticed.
    pub(super) fn refuse_open_sign(&self, r: Reg) -> Result<(), Stop> {
        if self.open[r] { Err(Undecided::Sign.into()) } else { Ok(()) }
    }

    /// Value of a register at a trial point.
    pub(super) fn trial(&self, r: Reg, i: usize) -> Option<Residue<C>> {
        self.columns[r].as_ref().and_then(|c| c[i])
    }

    /// Values of a register at several trial points.
    pub(super) fn values(&self, r: Reg, at: &[usize]) -> Vec<Residue<C>> {
        at.iter().map(|&i| self.trial(r, i).unwrap_or_default()).collect()
    }

    pub(super) fn kernel(&self, e: Expr, reason: &'static str) -> Stop {
        Stop::Undecided(Undecided::Kernel { text: self.short_text(e), reason })
    }

    pub(super) fn other_prime(&self, e: Expr, reason: &'static str) -> Stop {
        Stop::OtherPrime(Undecided::OtherPrime { text: self.short_text(e), reason })
    }

    /// The beginning of a text that is too long to be read.
    fn short_text(&self, e: Expr) -> String {
        let text = self.pool.text(e);
        match text.char_indices().nth(MAX_TEXT) {
            None => text,
            Some((end, _)) => format!("{}…", &text[..end]),
        }
    }
}
