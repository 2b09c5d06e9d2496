//! A tape together with the means by which it is evaluated.

use std::fmt;
use std::sync::Arc;

use bracketry_symbolic::Tape;

use crate::code::Code;
use crate::error::NativeError;

/// Below this number of instructions the tape is evaluated as it is.
const MIN_COMPILED: usize = 8;

/// Above this number of instructions compiling takes longer than it is likely to save.
const MAX_COMPILED: usize = 20_000;

/// The means by which a [`Function`] is evaluated.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Backend {
    /// The tape's interpreter, in safe Rust, on every host.
    Tape,
    /// Machine code for the host.
    Native,
}

/// Scratch memory of [`Function::call`]; one per thread, shared by any number of functions.
#[derive(Clone, Default, Debug)]
pub struct Workspace {
    registers: Vec<f64>,
}

/// A compiled list of expressions, ℝⁿ → ℝᵐ. Cloning shares the code.
#[derive(Clone)]
pub struct Function {
    shared: Arc<Shared>,
}

struct Shared {
    tape: Tape,
    code: Option<Code>,
}

impl Function {
    /// Compiles `tape` to machine code where that pays and the host allows it, and keeps the tape otherwise.
    /// [`Function::backend`] tells which.
    pub fn new(tape: Tape) -> Function {
        let code =
            if (MIN_COMPILED..=MAX_COMPILED).contains(&tape.code().len()) { Code::compile(&tape).ok() } else { None };
        Function { shared: Arc::new(Shared { tape, code }) }
    }

    /// Evaluates by the given means, whatever the length of the tape.
    ///
    /// # Errors
    /// [`NativeError`] if machine code is asked for and cannot be made.
    pub fn with_backend(tape: Tape, backend: Backend) -> Result<Function, NativeError> {
        let code = match backend {
            Backend::Tape => None,
            Backend::Native => Some(Code::compile(&tape)?),
        };
        Ok(Function { shared: Arc::new(Shared { tape, code }) })
    }

    /// Which evaluator is in use.
    pub fn backend(&self) -> Backend {
        if self.shared.code.is_some() { Backend::Native } else { Backend::Tape }
    }

    /// Number of arguments.
    pub fn n_inputs(&self) -> usize {
        self.shared.tape.n_inputs()
    }

    /// Number of results.
    pub fn n_outputs(&self) -> usize {
        self.shared.tape.n_outputs()
    }

    /// The tape that the function evaluates.
    pub fn tape(&self) -> &Tape {
        &self.shared.tape
    }

    /// Evaluates at `x` (length [`Function::n_inputs`]) into `out` (length [`Function::n_outputs`]).
    /// Allocates nothing once `work` has served the same function.
    ///
    /// # Panics
    /// If `x` or `out` have the wrong length.
    #[inline]
    pub fn call(&self, x: &[f64], work: &mut Workspace, out: &mut [f64]) {
        match &self.shared.code {
            Some(code) => code.run(x, &mut work.registers, out),
            None => self.shared.tape.eval(x, &mut work.registers, out),
        }
    }
}

impl fmt::Debug for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function")
            .field("backend", &self.backend())
            .field("n_inputs", &self.n_inputs())
            .field("n_outputs", &self.n_outputs())
            .field("instructions", &self.tape().code().len())
            .finish()
    }
}
