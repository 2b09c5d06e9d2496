//! Expressions compiled to a single-assignment register tape.
//!
//! Registers are numbered: first the inputs, then the constants, then one per
//! instruction. Common sub-expressions are computed once because the pool has
//! already merged them.

use dashu_base::Abs;
use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use crate::func::{Func, Func2, sign};
use crate::node::{Expr, Node, Symbol};
use crate::pool::Pool;

/// What an [`Instruction`] computes from its operand registers.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Op {
    /// `a + b`
    Add,
    /// `a - b`
    Sub,
    /// `a · b`
    Mul,
    /// `a / b`
    Div,
    /// `-a`
    Neg,
    /// `√a`
    Sqrt,
    /// `a ^ b` by `powf`
    Pow,
    /// A function of one argument
    Call(Func),
    /// A function of two arguments
    Call2(Func2),
}

impl Op {
    /// Whether there are two operands.
    pub(crate) fn takes_two(self) -> bool {
        !matches!(self, Op::Neg | Op::Sqrt | Op::Call(_))
    }
}

/// One step: `register[n_inputs + n_constants + position] = op(register[a], register[b])`.
/// Operations of one argument ignore `b`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Instruction {
    /// Operation.
    pub op: Op,
    /// Register of the first operand.
    pub a: u32,
    /// Register of the second operand.
    pub b: u32,
}

/// An expression that cannot be compiled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompileError {
    /// A name that is not among the inputs of the tape.
    #[error("`{name}` has no value: it is not among the arguments of the compiled function")]
    Unbound {
        /// The name.
        name: String,
    },
}

/// Straight-line program that evaluates a list of expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    n_inputs: usize,
    constants: Vec<f64>,
    code: Vec<Instruction>,
    outputs: Vec<u32>,
}

struct Builder {
    n_inputs: usize,
    constants: Vec<f64>,
    constant_ids: FxHashMap<u64, u32>,
    code: Vec<Instruction>,
    code_ids: FxHashMap<Instruction, u32>,
}

/// While building, constants and instructions carry a tag; the numbering is fixed at the end.
const CONSTANT: u32 = 1 << 31;
const TEMPORARY: u32 = 1 << 30;

impl Builder {
    fn constant(&mut self, v: f64) -> u32 {
        let constants = &mut self.constants;
        *self.constant_ids.entry(v.to_bits()).or_insert_with(|| {
            constants.push(v);
            (constants.len() as u32 - 1) | CONSTANT
        })
    }

    fn emit(&mut self, op: Op, a: u32, b: u32) -> u32 {
        let b = if op.takes_two() { b } else { a };
        let instruction = Instruction { op, a, b };
        let code = &mut self.code;
        *self.code_ids.entry(instruction).or_insert_with(|| {
            code.push(instruction);
            (code.len() as u32 - 1) | TEMPORARY
        })
    }

    /// `base ^ k` for k ≥ 1 by repeated squaring, so that every backend rounds alike.
    fn integer_power(&mut self, base: u32, k: u64) -> u32 {
        let mut result: Option<u32> = None;
        let mut square = base;
        let mut k = k;
        loop {
            if k & 1 == 1 {
                result = Some(result.map_or(square, |r| self.emit(Op::Mul, r, square)));
            }
            k >>= 1;
            match result {
                Some(r) if k == 0 => return r,
                _ => square = self.emit(Op::Mul, square, square),
            }
        }
    }

    fn resolve(&self, r: u32) -> u32 {
        let (n, c) = (self.n_inputs as u32, self.constants.len() as u32);
        if r & CONSTANT != 0 {
            n + (r & !CONSTANT)
        } else if r & TEMPORARY != 0 {
            n + c + (r & !TEMPORARY)
        } else {
            r
        }
    }
}

fn to_f64(x: &RBig) -> f64 {
    x.to_f64().value()
}

impl Tape {
    /// Compiles `outputs` as functions of `inputs`.
    ///
    /// # Errors
    /// [`CompileError::Unbound`] if an expression uses a name that is not an input.
    pub fn compile(pool: &Pool, inputs: &[Symbol], outputs: &[Expr]) -> Result<Tape, CompileError> {
        let mut b = Builder {
            n_inputs: inputs.len(),
            constants: Vec::new(),
            constant_ids: FxHashMap::default(),
            code: Vec::new(),
            code_ids: FxHashMap::default(),
        };
        let arguments: FxHashMap<Symbol, u32> = inputs.iter().enumerate().map(|(i, &s)| (s, i as u32)).collect();
        let mut register: FxHashMap<Expr, u32> = FxHashMap::default();
        for e in pool.reachable(outputs) {
            let r = match pool.node(e) {
                Node::Num(_) => b.constant(pool.number(e).map_or(f64::NAN, to_f64)),
                Node::Pi => b.constant(std::f64::consts::PI),
                Node::Sym(s) => {
                    *arguments.get(&s).ok_or_else(|| CompileError::Unbound { name: pool.name(s).to_owned() })?
                }
                Node::Add(x, y) => lower_sum(pool, &mut b, &register, x, y),
                Node::Mul(x, y) => lower_product(pool, &mut b, &register, x, y),
                Node::Pow(x, k) => lower_power(pool, &mut b, &register, x, k),
                Node::Call(f, x) => b.emit(Op::Call(f), register[&x], 0),
                Node::Call2(f, x, y) => b.emit(Op::Call2(f), register[&x], register[&y]),
            };
            register.insert(e, r);
        }
        let roots: Vec<u32> = outputs.iter().map(|e| register[e]).collect();
        Ok(finish(b, &roots))
    }

    /// Number of arguments.
    pub fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    /// Number of results.
    pub fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Values of the registers that follow the inputs.
    pub fn constants(&self) -> &[f64] {
        &self.constants
    }

    /// The instructions, in order.
    pub fn code(&self) -> &[Instruction] {
        &self.code
    }

    /// The registers that hold the results.
    pub fn outputs(&self) -> &[u32] {
        &self.outputs
    }

    /// Number of registers that [`Tape::eval`] needs in `work`.
    pub fn registers(&self) -> usize {
        self.n_inputs + self.constants.len() + self.code.len()
    }

    /// Evaluates into `out` (length [`Tape::n_outputs`]); `work` is resized on first use and can be kept.
    ///
    /// # Panics
    /// If `x` or `out` have the wrong length.
    pub fn eval(&self, x: &[f64], work: &mut Vec<f64>, out: &mut [f64]) {
        assert_eq!(x.len(), self.n_inputs, "number of arguments");
        assert_eq!(out.len(), self.outputs.len(), "number of results");
        work.resize(self.registers(), 0.0);
        let first = self.n_inputs + self.constants.len();
        work[..self.n_inputs].copy_from_slice(x);
        work[self.n_inputs..first].copy_from_slice(&self.constants);
        for (i, c) in self.code.iter().enumerate() {
            let (a, b) = (work[c.a as usize], work[c.b as usize]);
            work[first + i] = apply(c.op, a, b);
        }
        for (o, &r) in out.iter_mut().zip(&self.outputs) {
            *o = work[r as usize];
        }
    }

    /// Evaluates at `LANES` points at once, lane by lane; the same roundings as [`Tape::eval`].
    ///
    /// # Panics
    /// If `x` or `out` have the wrong length.
    pub fn eval_batch<const LANES: usize>(
        &self,
        x: &[[f64; LANES]],
        work: &mut Vec<[f64; LANES]>,
        out: &mut [[f64; LANES]],
    ) {
        assert_eq!(x.len(), self.n_inputs, "number of arguments");
        assert_eq!(out.len(), self.outputs.len(), "number of results");
        work.resize(self.registers(), [0.0; LANES]);
        let first = self.n_inputs + self.constants.len();
        work[..self.n_inputs].copy_from_slice(x);
        for (w, c) in work[self.n_inputs..first].iter_mut().zip(&self.constants) {
            *w = [*c; LANES];
        }
        for (i, c) in self.code.iter().enumerate() {
            let (a, b) = (work[c.a as usize], work[c.b as usize]);
            work[first + i] = std::array::from_fn(|l| apply(c.op, a[l], b[l]));
        }
        for (o, &r) in out.iter_mut().zip(&self.outputs) {
            *o = work[r as usize];
        }
    }
}

#[inline]
fn apply(op: Op, a: f64, b: f64) -> f64 {
    match op {
        Op::Add => a + b,
        Op::Sub => a - b,
        Op::Mul => a * b,
        Op::Div => a / b,
        Op::Neg => -a,
        Op::Sqrt => a.sqrt(),
        Op::Pow => a.powf(b),
        Op::Call(Func::Sign) => sign(a),
        Op::Call(f) => f.eval(a),
        Op::Call2(f) => f.eval(a, b),
    }
}

/// `x + y`, where a negative coefficient becomes a subtraction.
fn lower_sum(pool: &Pool, b: &mut Builder, register: &FxHashMap<Expr, u32>, x: Expr, y: Expr) -> u32 {
    if let Some(p) = negated(pool, b, register, y) {
        return b.emit(Op::Sub, register[&x], p);
    }
    if let Some(p) = negated(pool, b, register, x) {
        return b.emit(Op::Sub, register[&y], p);
    }
    b.emit(Op::Add, register[&x], register[&y])
}

/// The register of `-e` if `e` carries a negative coefficient.
fn negated(pool: &Pool, b: &mut Builder, register: &FxHashMap<Expr, u32>, e: Expr) -> Option<u32> {
    let Node::Mul(c, rest) = pool.node(e) else { return None };
    let c = pool.number(c)?;
    if *c >= RBig::ZERO {
        return None;
    }
    let size = c.clone().abs();
    if size == RBig::ONE {
        return Some(register[&rest]);
    }
    let k = b.constant(to_f64(&size));
    Some(b.emit(Op::Mul, k, register[&rest]))
}

/// `x · y`, where a negative power becomes a division.
fn lower_product(pool: &Pool, b: &mut Builder, register: &FxHashMap<Expr, u32>, x: Expr, y: Expr) -> u32 {
    if pool.integer(x) == Some(-1) {
        return b.emit(Op::Neg, register[&y], 0);
    }
    for (x, y) in [(x, y), (y, x)] {
        if let Some(d) = denominator(pool, b, register, y) {
            return b.emit(Op::Div, register[&x], d);
        }
    }
    b.emit(Op::Mul, register[&x], register[&y])
}

/// The register of `1/e` if `e` is a negative integer power or `a^(-1/2)`.
fn denominator(pool: &Pool, b: &mut Builder, register: &FxHashMap<Expr, u32>, e: Expr) -> Option<u32> {
    let Node::Pow(base, k) = pool.node(e) else { return None };
    let k = pool.number(k)?.clone();
    if k >= RBig::ZERO {
        return None;
    }
    positive_power(b, register[&base], &-k)
}

fn positive_power(b: &mut Builder, base: u32, k: &RBig) -> Option<u32> {
    let twice = k.clone() * RBig::from(2);
    if k.is_int() {
        let k = u64::try_from(k.numerator()).ok().filter(|k| *k <= 64)?;
        return Some(b.integer_power(base, k));
    }
    if twice.is_int() {
        let k = u64::try_from(twice.numerator()).ok().filter(|k| *k <= 64)?;
        let root = b.emit(Op::Sqrt, base, 0);
        return Some(b.integer_power(root, k));
    }
    None
}

fn lower_power(pool: &Pool, b: &mut Builder, register: &FxHashMap<Expr, u32>, x: Expr, k: Expr) -> u32 {
    if let Some(number) = pool.number(k).cloned() {
        if number > RBig::ZERO
            && let Some(r) = positive_power(b, register[&x], &number)
        {
            return r;
        }
        if number < RBig::ZERO
            && let Some(r) = positive_power(b, register[&x], &-number)
        {
            let one = b.constant(1.0);
            return b.emit(Op::Div, one, r);
        }
    }
    b.emit(Op::Pow, register[&x], register[&k])
}

/// Drops what no result needs and fixes the register numbers.
fn finish(mut b: Builder, roots: &[u32]) -> Tape {
    let mut used = vec![false; b.code.len()];
    let mut used_constants = vec![false; b.constants.len()];
    let mut mark = |r: u32, used: &mut Vec<bool>| {
        if r & CONSTANT != 0 {
            used_constants[(r & !CONSTANT) as usize] = true;
        } else if r & TEMPORARY != 0 {
            used[(r & !TEMPORARY) as usize] = true;
        }
    };
    for &r in roots {
        mark(r, &mut used);
    }
    for i in (0..b.code.len()).rev() {
        if used[i] {
            mark(b.code[i].a, &mut used);
            mark(b.code[i].b, &mut used);
        }
    }
    let renumber = |keep: &[bool]| -> Vec<u32> {
        keep.iter()
            .scan(0u32, |n, &k| {
                let at = *n;
                *n += u32::from(k);
                Some(at)
            })
            .collect()
    };
    let (code_at, constant_at) = (renumber(&used), renumber(&used_constants));
    let moved = |r: u32| {
        if r & CONSTANT != 0 {
            constant_at[(r & !CONSTANT) as usize] | CONSTANT
        } else if r & TEMPORARY != 0 {
            code_at[(r & !TEMPORARY) as usize] | TEMPORARY
        } else {
            r
        }
    };
    let mut keep = used_constants.iter();
    b.constants.retain(|_| *keep.next().unwrap_or(&false));
    let code: Vec<Instruction> = b
        .code
        .iter()
        .zip(&used)
        .filter(|(_, k)| **k)
        .map(|(c, _)| Instruction { op: c.op, a: moved(c.a), b: moved(c.b) })
        .collect();
    let code = code.into_iter().map(|c| Instruction { op: c.op, a: b.resolve(c.a), b: b.resolve(c.b) }).collect();
    let outputs = roots.iter().map(|&r| b.resolve(moved(r))).collect();
    Tape { n_inputs: b.n_inputs, constants: b.constants, code, outputs }
}
