//! Functions along a trajectory as steps for power series in time.
//!
//! The expressions are compiled once to steps, as the exact tests do. A function b = f(a) follows from b' = f'(a) a', so
//! the derivatives of all functions are among the steps.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, Symbol};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::algebra::field::VectorFields;
use crate::undecided::Undecided;

/// Number of a step, whose result later steps use.
pub(crate) type Reg = usize;

/// Larger integer powers are refused.
const MAX_POWER: u64 = 1 << 12;
/// Rounds in which derivatives of functions are added; each function has one of finitely many.
const MAX_ROUNDS: usize = 8;

/// How the coefficients of a series are found. `sample` is the number of an expression with a sampled value.
pub(crate) enum Step {
    Constant {
        sample: usize,
    },
    /// Constant in time, with a derivative by itself.
    Parameter {
        sample: usize,
        direction: usize,
    },
    /// The solution of the differential equation; without a direction where its initial value is known.
    State {
        sample: usize,
        state: usize,
        direction: Option<usize>,
    },
    /// A random series.
    Input,
    /// A random series that is not known: each coefficient is a variable, from this direction on.
    Unknown {
        first: usize,
    },
    Add(Reg, Reg),
    Mul(Reg, Reg),
    Inverse(Reg),
    /// The function b with b' = Σ D a' over these pairs (a, D), whose value at time zero is sampled.
    Chain {
        sample: usize,
        terms: Vec<(Reg, Reg)>,
    },
}

/// Steps for the series of outputs and of further functions.
pub(crate) struct SeriesProgram {
    pub(crate) steps: Vec<Step>,
    /// Results that are constant in time.
    pub(crate) still: Vec<bool>,
    /// Expressions whose values at time zero are sampled: first the variables, last the rates and outputs.
    pub(crate) sampled: Vec<Expr>,
    /// Rate of each state.
    pub(crate) rates: Vec<Reg>,
    pub(crate) outputs: Vec<Reg>,
    pub(crate) functions: Vec<Reg>,
    pub(crate) directions: usize,
}

/// Inputs that are unknown functions of time.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnknownInputs {
    /// Numbers of the control fields that they multiply.
    pub(crate) controls: Vec<usize>,
    /// Coefficients of each that are variables.
    pub(crate) orders: usize,
}

/// A program under construction.
struct Compiler<'a> {
    pool: &'a mut Pool,
    program: SeriesProgram,
    states: FxHashMap<Symbol, usize>,
    directions: FxHashMap<Symbol, usize>,
    registers: FxHashMap<Expr, Reg>,
    samples: FxHashMap<Expr, usize>,
    moving: FxHashSet<Expr>,
    /// Of functions: their arguments and the derivatives by these.
    slopes: FxHashMap<Expr, Vec<(Expr, Expr)>>,
}

impl SeriesProgram {
    /// Steps for `outputs` and `functions` along x' = f + Σ u_i g_i; derivatives are taken by the `variables`.
    ///
    /// # Errors
    /// [`Undecided`] for a power that is too large.
    pub(crate) fn compile(
        pool: &mut Pool,
        fields: &VectorFields,
        outputs: &[Expr],
        functions: &[Expr],
        variables: &[Symbol],
    ) -> Result<Self, Undecided> {
        Self::compile_with_unknown(pool, fields, outputs, functions, variables, &UnknownInputs::default())
    }

    /// The same where some inputs are not known: so many coefficients of each are further variables, in this order.
    ///
    /// # Errors
    /// [`Undecided`] for a power that is too large.
    pub(crate) fn compile_with_unknown(
        pool: &mut Pool,
        fields: &VectorFields,
        outputs: &[Expr],
        functions: &[Expr],
        variables: &[Symbol],
        unknown: &UnknownInputs,
    ) -> Result<Self, Undecided> {
        let mut roots = fields.drift.clone();
        roots.extend(fields.controls.concat());
        roots.extend(outputs);
        roots.extend(functions);
        let mut numbers = FxHashMap::default();
        for s in pool.symbols_of(&roots) {
            if let Some(v) = fields.bindings.get(s).filter(|_| !variables.contains(&s)).cloned() {
                let x = pool.sym(s);
                numbers.insert(x, pool.rational(v));
            }
        }
        let roots = pool.substitute_all(&roots, &numbers);
        let program = SeriesProgram {
            steps: Vec::new(),
            still: Vec::new(),
            sampled: Vec::new(),
            rates: Vec::new(),
            outputs: Vec::new(),
            functions: Vec::new(),
            directions: variables.len() + unknown.controls.len() * unknown.orders,
        };
        let mut compiler = Compiler {
            pool,
            program,
            states: fields.states.iter().copied().zip(0..).collect(),
            directions: variables.iter().copied().zip(0..).collect(),
            registers: FxHashMap::default(),
            samples: FxHashMap::default(),
            moving: FxHashSet::default(),
            slopes: FxHashMap::default(),
        };
        for &s in variables {
            let x = compiler.pool.sym(s);
            compiler.sample(x);
        }
        compiler.expressions(&roots)?;
        Ok(compiler.finish(&roots, fields, outputs.len(), unknown))
    }

    /// Number of variables by which derivatives are taken.
    pub(crate) fn directions(&self) -> usize {
        self.directions
    }

    /// Numbers that the coefficients take.
    pub(super) fn numbers(&self, orders: usize) -> usize {
        self.still.iter().filter(|s| !**s).count() * orders * (self.directions + 1)
    }
}

impl Compiler<'_> {
    fn sample(&mut self, e: Expr) -> usize {
        let list = &mut self.program.sampled;
        *self.samples.entry(e).or_insert_with(|| {
            list.push(e);
            list.len() - 1
        })
    }

    fn push(&mut self, step: Step) -> Reg {
        let still = &self.program.still;
        let constant = match &step {
            Step::Constant { .. } | Step::Parameter { .. } => true,
            Step::State { .. } | Step::Input | Step::Unknown { .. } => false,
            Step::Add(a, b) | Step::Mul(a, b) => still[*a] && still[*b],
            Step::Inverse(a) => still[*a],
            Step::Chain { terms, .. } => terms.iter().all(|(a, _)| still[*a]),
        };
        self.program.still.push(constant);
        self.program.steps.push(step);
        self.program.steps.len() - 1
    }

    /// Steps for all sub-expressions.
    fn expressions(&mut self, roots: &[Expr]) -> Result<(), Undecided> {
        let nodes = self.with_slopes(roots);
        for &e in &nodes {
            let r = self.node(e)?;
            self.registers.insert(e, r);
        }
        // The derivatives of functions stand behind them: coefficient k of a function needs those below k only.
        for &e in &nodes {
            let r = self.registers[&e];
            if !matches!(self.program.steps[r], Step::Chain { .. }) {
                continue;
            }
            let found = match (self.pool.node(e), self.slopes.get(&e)) {
                (Node::Pow(a, k), _) => self.slopes_of_power(r, a, k),
                (_, Some(slopes)) => slopes.iter().map(|(a, d)| (self.registers[a], self.registers[d])).collect(),
                (_, None) => return Err(bracketry_symbolic::Undecided::TooComplex.into()),
            };
            if let Step::Chain { terms, .. } = &mut self.program.steps[r] {
                *terms = found;
            }
        }
        Ok(())
    }

    /// The sub-expressions of `roots` and of the derivatives of the functions among them, operands first; notes which
    /// depend on states or variables.
    fn with_slopes(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let mut all = roots.to_vec();
        for _ in 0..MAX_ROUNDS {
            let before = all.len();
            for e in self.pool.reachable(&all) {
                self.note_moving(e);
                if !self.moving.contains(&e) || self.slopes.contains_key(&e) {
                    continue;
                }
                let slopes = match self.pool.node(e) {
                    Node::Call(f, a) => {
                        let s = self.pool.symbol("argument 1");
                        let x = self.pool.sym(s);
                        let call = self.pool.call(f, x);
                        self.partial(call, &[(s, a)])
                    }
                    Node::Call2(f, a, b) => {
                        let (s, t) = (self.pool.symbol("argument 1"), self.pool.symbol("argument 2"));
                        let (x, y) = (self.pool.sym(s), self.pool.sym(t));
                        let call = self.pool.call2(f, x, y);
                        self.partial(call, &[(s, a), (t, b)])
                    }
                    Node::Pow(a, k) if self.pool.number(k).is_none() => {
                        all.push(self.pool.call(Func::Log, a));
                        Vec::new()
                    }
                    _ => continue,
                };
                all.extend(slopes.iter().map(|s| s.1));
                self.slopes.insert(e, slopes);
            }
            if all.len() == before {
                break;
            }
        }
        let nodes = self.pool.reachable(&all);
        for &e in &nodes {
            self.note_moving(e);
        }
        nodes
    }

    fn note_moving(&mut self, e: Expr) {
        let moves = match self.pool.node(e) {
            Node::Sym(s) => self.states.contains_key(&s) || self.directions.contains_key(&s),
            node => node.operands().any(|o| self.moving.contains(&o)),
        };
        if moves {
            self.moving.insert(e);
        }
    }

    /// The arguments with the derivatives by them.
    fn partial(&mut self, call: Expr, arguments: &[(Symbol, Expr)]) -> Vec<(Expr, Expr)> {
        let values: FxHashMap<Expr, Expr> = arguments.iter().map(|&(s, a)| (self.pool.sym(s), a)).collect();
        arguments
            .iter()
            .filter(|(_, a)| self.moving.contains(a))
            .map(|&(s, a)| {
                let d = self.pool.diff(call, s);
                (a, self.pool.substitute(d, &values))
            })
            .collect()
    }

    fn node(&mut self, e: Expr) -> Result<Reg, Undecided> {
        if !self.moving.contains(&e) {
            let sample = self.sample(e);
            return Ok(self.push(Step::Constant { sample }));
        }
        Ok(match self.pool.node(e) {
            Node::Sym(s) => {
                let (sample, direction) = (self.sample(e), self.directions.get(&s).copied());
                match (self.states.get(&s), direction) {
                    (Some(&state), _) => self.push(Step::State { sample, state, direction }),
                    (None, Some(direction)) => self.push(Step::Parameter { sample, direction }),
                    (None, None) => self.push(Step::Constant { sample }),
                }
            }
            Node::Add(a, b) => self.push(Step::Add(self.registers[&a], self.registers[&b])),
            Node::Mul(a, b) => self.push(Step::Mul(self.registers[&a], self.registers[&b])),
            Node::Pow(a, k) => match self.pool.number(k).filter(|k| k.is_int()).cloned() {
                Some(k) => self.integer_power(e, self.registers[&a], &k)?,
                None => self.function(e),
            },
            _ => self.function(e),
        })
    }

    /// A function of other results; what it is chained to is filled in later.
    fn function(&mut self, e: Expr) -> Reg {
        let sample = self.sample(e);
        let arguments: Vec<Expr> = self.pool.node(e).operands().collect();
        let terms = arguments.iter().map(|a| (self.registers[a], self.registers[a])).collect();
        self.push(Step::Chain { sample, terms })
    }

    fn integer_power(&mut self, e: Expr, base: Reg, k: &Rational) -> Result<Reg, Undecided> {
        let n = i64::try_from(k.numerator()).ok().filter(|n| n.unsigned_abs() <= MAX_POWER);
        let Some(n) = n else {
            let reason = "its exponent is too large";
            return Err(bracketry_symbolic::Undecided::Kernel { text: self.pool.text(e), reason }.into());
        };
        let mut square = if n < 0 { self.push(Step::Inverse(base)) } else { base };
        let (mut rest, mut product) = (n.unsigned_abs(), None);
        while rest > 0 {
            if rest & 1 == 1 {
                product = Some(product.map_or(square, |p| self.push(Step::Mul(p, square))));
            }
            rest >>= 1;
            if rest > 0 {
                square = self.push(Step::Mul(square, square));
            }
        }
        let one = self.pool.int(1);
        Ok(product.unwrap_or_else(|| {
            let sample = self.sample(one);
            self.push(Step::Constant { sample })
        }))
    }

    /// (a^k)' = k a^k/a a' + a^k log(a) k'
    fn slopes_of_power(&mut self, power: Reg, a: Expr, k: Expr) -> Vec<(Reg, Reg)> {
        let mut terms = Vec::new();
        if self.moving.contains(&a) {
            let inverse = self.push(Step::Inverse(self.registers[&a]));
            let quotient = self.push(Step::Mul(power, inverse));
            terms.push((self.registers[&a], self.push(Step::Mul(self.registers[&k], quotient))));
        }
        if self.moving.contains(&k) {
            let log = self.pool.call(Func::Log, a);
            terms.push((self.registers[&k], self.push(Step::Mul(power, self.registers[&log]))));
        }
        terms
    }

    /// Adds the inputs to the rates.
    fn finish(
        mut self,
        roots: &[Expr],
        fields: &VectorFields,
        outputs: usize,
        unknown: &UnknownInputs,
    ) -> SeriesProgram {
        let n = fields.states.len();
        let at = |c: &Self, e: &Expr| c.registers[e];
        let mut rates: Vec<Reg> = roots[..n].iter().map(|e| at(&self, e)).collect();
        for (i, g) in roots[n..n * (1 + fields.controls.len())].chunks(n).enumerate() {
            let place = unknown.controls.iter().position(|&c| c == i);
            let u = self.push(match place {
                Some(k) => Step::Unknown { first: self.directions.len() + k * unknown.orders },
                None => Step::Input,
            });
            for (rate, e) in rates.iter_mut().zip(g) {
                if !self.pool.is_zero(*e) {
                    let term = self.push(Step::Mul(u, at(&self, e)));
                    *rate = self.push(Step::Add(*rate, term));
                }
            }
        }
        let (observed, asked) = roots[n * (1 + fields.controls.len())..].split_at(outputs);
        self.program.outputs = observed.iter().map(|e| at(&self, e)).collect();
        self.program.functions = asked.iter().map(|e| at(&self, e)).collect();
        self.program.rates = rates;
        // For the degree alone.
        self.program.sampled.extend(&roots[..n]);
        self.program.sampled.extend(observed);
        self.program
    }
}
