//! In place of machine code where the crate is built without its generator.

use bracketry_symbolic::Tape;

use crate::error::NativeError;

/// Never made.
pub(crate) enum Code {}

impl Code {
    pub(crate) fn compile(_: &Tape) -> Result<Self, NativeError> {
        Err(NativeError::Host { reason: "this build has no code generator: the feature `cranelift` is off" })
    }

    pub(crate) fn run(&self, _: &[f64], _: &mut Vec<f64>, _: &mut [f64]) {
        match *self {}
    }
}
