//! Ownership of machine code, and the one place that enters it.

use std::sync::Mutex;

use bracketry_symbolic::Tape;
use cranelift_codegen::ir::{AbiParam, types};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, ModuleError, default_libcall_names};

use crate::error::NativeError;
use crate::lower::{ChunkWriter, Plan};
use crate::math::CALLEES;

/// Longest list of registers or results whose byte offsets fit the instructions.
pub(crate) const MAX_LENGTH: usize = i32::MAX as usize / size_of::<f64>();

/// Instructions per compiled function. On unstructured tapes of 20,000 instructions, one function instead of
/// twenty takes twice as long to compile.
const CHUNK_LENGTH: usize = 1000;

/// A chunk: arguments, results, workspace.
type Entry = unsafe extern "C" fn(*const f64, *mut f64, *mut f64);

/// Compiled code of one tape.
pub(crate) struct Code {
    /// Owner of the memory behind `entries`; `None` only while being dropped.
    /// The lock is never contended: it stands in for `Sync`, which the module itself is not.
    module: Mutex<Option<JITModule>>,
    entries: Vec<Entry>,
    n_inputs: usize,
    n_outputs: usize,
    slots: usize,
}

fn module() -> Result<JITModule, NativeError> {
    let mut flags = settings::builder();
    for (name, value) in [
        // The tape has no common sub-expressions left; "speed" compiles a fifth longer for equally fast code.
        ("opt_level", "none"),
        ("use_colocated_libcalls", "false"),
        ("is_pic", "false"),
        // Frames of many spilled values may exceed the guard page.
        ("enable_probestack", "true"),
        ("probestack_strategy", "inline"),
        ("enable_verifier", if cfg!(debug_assertions) { "true" } else { "false" }),
    ] {
        flags.set(name, value).map_err(ModuleError::Flag)?;
    }
    let isa = cranelift_native::builder()
        .map_err(|reason| NativeError::Host { reason })?
        .finish(settings::Flags::new(flags))
        .map_err(ModuleError::Compilation)?;
    let mut builder = JITBuilder::with_isa(isa, default_libcall_names());
    for c in CALLEES {
        builder.symbol(c.symbol, (c.address)());
    }
    Ok(JITModule::new(builder))
}

impl Code {
    pub(crate) fn compile(tape: &Tape) -> Result<Code, NativeError> {
        let length = tape.registers().max(tape.n_outputs());
        if length > MAX_LENGTH {
            return Err(NativeError::TooLong { length, limit: MAX_LENGTH });
        }
        let plan = Plan::new(tape, CHUNK_LENGTH);
        let module = module()?;
        // From here on the memory is freed on every exit, because `code` owns the module.
        let mut code = Code {
            module: Mutex::new(Some(module)),
            entries: Vec::new(),
            n_inputs: tape.n_inputs(),
            n_outputs: tape.n_outputs(),
            slots: plan.slots,
        };
        let mut entries = Vec::with_capacity(plan.chunks.len());
        if let Some(module) = code.module_mut() {
            let ids = define(module, tape, &plan)?;
            module.finalize_definitions()?;
            for id in ids {
                let address = module.get_finalized_function(id);
                // SAFETY: the address is that of a finished function whose signature, set in
                // `define` under the host's C convention, is that of `Entry`.
                entries.push(unsafe { std::mem::transmute::<*const u8, Entry>(address) });
            }
        }
        code.entries = entries;
        Ok(code)
    }

    fn module_mut(&mut self) -> Option<&mut JITModule> {
        match self.module.get_mut() {
            Ok(m) => m.as_mut(),
            Err(poisoned) => poisoned.into_inner().as_mut(),
        }
    }

    /// Evaluates at `x` into `out`; `work` is resized on first use.
    pub(crate) fn run(&self, x: &[f64], work: &mut Vec<f64>, out: &mut [f64]) {
        assert_eq!(x.len(), self.n_inputs, "number of arguments");
        assert_eq!(out.len(), self.n_outputs, "number of results");
        if work.len() < self.slots {
            work.resize(self.slots, 0.0);
        }
        for entry in &self.entries {
            // SAFETY: the code reads `n_inputs` values of `x`, writes `n_outputs` values of `out`,
            // reads and writes `slots` values of `work` and nothing else; the lengths were checked
            // above, and the three slices are disjoint by their borrows. The code is alive because
            // `self` owns its module.
            unsafe { entry(x.as_ptr(), out.as_mut_ptr(), work.as_mut_ptr()) };
        }
    }
}

impl Drop for Code {
    fn drop(&mut self) {
        let module = match self.module.get_mut() {
            Ok(m) => m.take(),
            Err(poisoned) => poisoned.into_inner().take(),
        };
        if let Some(module) = module {
            // SAFETY: `entries` are private to `self`, which nobody else uses any more, so no function
            // of the module is running and none will be called.
            unsafe { module.free_memory() };
        }
    }
}

/// Compiles every chunk of the plan, in order.
fn define(module: &mut JITModule, tape: &Tape, plan: &Plan) -> Result<Vec<FuncId>, NativeError> {
    let config = module.target_config();
    let mut imports = Vec::with_capacity(CALLEES.len());
    for c in CALLEES {
        let mut signature = module.make_signature();
        signature.params.extend(vec![AbiParam::new(types::F64); c.arity]);
        signature.returns.push(AbiParam::new(types::F64));
        imports.push(module.declare_function(c.symbol, Linkage::Import, &signature)?);
    }
    let mut context = module.make_context();
    let mut scratch = FunctionBuilderContext::new();
    let mut ids = Vec::with_capacity(plan.chunks.len());
    for k in 0..plan.chunks.len() {
        // Arguments, results, workspace.
        context.func.signature.params.extend([AbiParam::new(config.pointer_type()); 3]);
        let id = module.declare_anonymous_function(&context.func.signature)?;
        let callees = imports.iter().map(|&f| module.declare_func_in_func(f, &mut context.func)).collect();
        let mut builder = FunctionBuilder::new(&mut context.func, &mut scratch);
        ChunkWriter::new(tape, plan, &mut builder, callees).write(k);
        builder.finalize(config);
        module.define_function(id, &mut context)?;
        module.clear_context(&mut context);
        ids.push(id);
    }
    Ok(ids)
}
