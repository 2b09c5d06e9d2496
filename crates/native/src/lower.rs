//! Tape to Cranelift's intermediate representation.
//!
//! A tape is cut into chunks, each a function of its own, because the time of
//! register allocation grows faster than the length. A value that a later chunk
//! needs goes through a slot of the workspace.

use std::ops::Range;

use bracketry_symbolic::{Func, Func2, Instruction, Op, Tape};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::{FuncRef, InstBuilder, MemFlagsData, Value, types};
use cranelift_frontend::FunctionBuilder;
use rustc_hash::FxHashMap;

use crate::math;

/// How a tape is cut, and which values pass from chunk to chunk.
pub(crate) struct Plan {
    /// Ranges of instructions; at least one, possibly empty.
    pub(crate) chunks: Vec<Range<usize>>,
    /// By instruction: the slot of the workspace through which later chunks read it.
    slot: Vec<Option<u32>>,
    /// Slots used.
    pub(crate) slots: usize,
    /// By register: the results to which it is written.
    results: FxHashMap<u32, Vec<u32>>,
}

impl Plan {
    pub(crate) fn new(tape: &Tape, chunk_length: usize) -> Plan {
        let n = tape.code().len();
        let count = n.div_ceil(chunk_length).max(1);
        // Equal lengths instead of a short last chunk.
        let chunks: Vec<Range<usize>> = (0..count).map(|k| k * n / count..(k + 1) * n / count).collect();
        let first = tape.n_inputs() + tape.constants().len();
        let mut slot = vec![None; n];
        let mut slots = 0;
        for chunk in &chunks {
            for i in chunk.clone() {
                for r in operands(tape.code()[i]) {
                    if let Some(j) = (r as usize).checked_sub(first)
                        && j < chunk.start
                        && slot[j].is_none()
                    {
                        slot[j] = Some(slots as u32);
                        slots += 1;
                    }
                }
            }
        }
        let mut results: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (k, &r) in tape.outputs().iter().enumerate() {
            results.entry(r).or_default().push(k as u32);
        }
        Plan { chunks, slot, slots, results }
    }
}

fn operands(c: Instruction) -> impl Iterator<Item = u32> {
    let binary = matches!(c.op, Op::Add | Op::Sub | Op::Mul | Op::Div | Op::Pow | Op::Call2(_));
    std::iter::once(c.a).chain(binary.then_some(c.b))
}

/// Writes the instructions of one chunk into `builder`.
pub(crate) struct ChunkWriter<'a, 'b> {
    tape: &'a Tape,
    plan: &'a Plan,
    builder: &'a mut FunctionBuilder<'b>,
    /// By position in [`math::CALLEES`].
    callees: Vec<FuncRef>,
    arguments: Value,
    results: Value,
    work: Value,
    values: FxHashMap<u32, Value>,
}

impl<'a, 'b> ChunkWriter<'a, 'b> {
    pub(crate) fn new(
        tape: &'a Tape,
        plan: &'a Plan,
        builder: &'a mut FunctionBuilder<'b>,
        callees: Vec<FuncRef>,
    ) -> Self {
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        builder.seal_block(block);
        let p = builder.block_params(block);
        let (arguments, results, work) = (p[0], p[1], p[2]);
        ChunkWriter { tape, plan, builder, callees, arguments, results, work, values: FxHashMap::default() }
    }

    /// Writes chunk number `k` and its return.
    pub(crate) fn write(mut self, k: usize) {
        let first = (self.tape.n_inputs() + self.tape.constants().len()) as u32;
        if k == 0 {
            // Results that nothing computes: arguments and constants.
            let mut plain: Vec<u32> = self.plan.results.keys().copied().filter(|r| *r < first).collect();
            plain.sort_unstable();
            for r in plain {
                let v = self.value(r);
                self.store_results(r, v);
            }
        }
        for i in self.plan.chunks[k].clone() {
            let c = self.tape.code()[i];
            let a = self.value(c.a);
            let v = match operands(c).nth(1) {
                Some(b) => {
                    let b = self.value(b);
                    self.binary(c.op, a, b)
                }
                None => self.unary(c.op, a),
            };
            let register = first + i as u32;
            self.values.insert(register, v);
            self.store_results(register, v);
            if let Some(slot) = self.plan.slot[i] {
                self.store(v, self.work, slot);
            }
        }
        self.builder.ins().return_(&[]);
    }

    /// The value of a register, read where it is first needed.
    fn value(&mut self, r: u32) -> Value {
        if let Some(&v) = self.values.get(&r) {
            return v;
        }
        let n = self.tape.n_inputs();
        let constants = self.tape.constants();
        let at = r as usize;
        let v = if at < n {
            self.load(self.arguments, r)
        } else if at < n + constants.len() {
            self.builder.ins().f64const(constants[at - n])
        } else {
            // Not of this chunk, so the plan gave it a slot.
            let slot = self.plan.slot[at - n - constants.len()].unwrap_or_default();
            self.load(self.work, slot)
        };
        self.values.insert(r, v);
        v
    }

    fn load(&mut self, base: Value, index: u32) -> Value {
        self.builder.ins().load(types::F64, MemFlagsData::trusted(), base, offset(index))
    }

    fn store(&mut self, v: Value, base: Value, index: u32) {
        self.builder.ins().store(MemFlagsData::trusted(), v, base, offset(index));
    }

    fn store_results(&mut self, register: u32, v: Value) {
        let plan = self.plan;
        for &k in plan.results.get(&register).into_iter().flatten() {
            self.store(v, self.results, k);
        }
    }

    fn call(&mut self, op: Op, arguments: &[Value]) -> Value {
        let k = math::callee(op).unwrap_or_default();
        let call = self.builder.ins().call(self.callees[k], arguments);
        self.builder.inst_results(call)[0]
    }

    fn unary(&mut self, op: Op, a: Value) -> Value {
        match op {
            Op::Neg => self.builder.ins().fneg(a),
            Op::Sqrt => self.builder.ins().sqrt(a),
            Op::Call(Func::Abs) => self.builder.ins().fabs(a),
            Op::Call(Func::Sign) => self.sign(a),
            _ => self.call(op, &[a]),
        }
    }

    fn binary(&mut self, op: Op, a: Value, b: Value) -> Value {
        match op {
            Op::Add => self.builder.ins().fadd(a, b),
            Op::Sub => self.builder.ins().fsub(a, b),
            Op::Mul => self.builder.ins().fmul(a, b),
            Op::Div => self.builder.ins().fdiv(a, b),
            Op::Call2(Func2::Min) => self.choose(FloatCC::LessThan, a, b),
            Op::Call2(Func2::Max) => self.choose(FloatCC::GreaterThan, a, b),
            _ => self.call(op, &[a, b]),
        }
    }

    /// `a` if the comparison holds or `a` is NaN, else `b`: what `Func2::eval` does.
    fn choose(&mut self, comparison: FloatCC, a: Value, b: Value) -> Value {
        let ins = self.builder.ins().fcmp(comparison, a, b);
        let nan = self.builder.ins().fcmp(FloatCC::Unordered, a, a);
        let take = self.builder.ins().bor(ins, nan);
        self.builder.ins().select(take, a, b)
    }

    /// 1, −1 or `a·0`, which keeps the sign of a zero and lets NaN through: what `Func::eval` does.
    fn sign(&mut self, a: Value) -> Value {
        let zero = self.builder.ins().f64const(0.0);
        let one = self.builder.ins().f64const(1.0);
        let minus_one = self.builder.ins().f64const(-1.0);
        let still = self.builder.ins().fmul(a, zero);
        let negative = self.builder.ins().fcmp(FloatCC::LessThan, a, zero);
        let rest = self.builder.ins().select(negative, minus_one, still);
        let positive = self.builder.ins().fcmp(FloatCC::GreaterThan, a, zero);
        self.builder.ins().select(positive, one, rest)
    }
}

/// Byte offset of the element `index` of an array of `f64`; [`crate::code::MAX_LENGTH`] bounds it.
fn offset(index: u32) -> i32 {
    (index * size_of::<f64>() as u32) as i32
}
