//! Why a tape is not compiled.

#[cfg(feature = "cranelift")]
use cranelift_module::ModuleError;

/// A tape that cannot be compiled to machine code. [`Backend::Tape`](crate::Backend::Tape) evaluates it all the same.
#[derive(Debug, thiserror::Error)]
pub enum NativeError {
    /// No code can be generated for this processor.
    #[error("machine code is not supported on this host: {reason}")]
    Host {
        /// What is missing.
        reason: &'static str,
    },
    /// The tape has more registers or results than machine code can address.
    #[error("a tape with {length} registers or results is beyond the limit of {limit} for machine code")]
    TooLong {
        /// Registers or results of the tape, whichever is more.
        length: usize,
        /// The most that can be addressed.
        limit: usize,
    },
    #[cfg(feature = "cranelift")]
    /// Code generation or the allocation of its memory failed.
    #[error("code generation failed")]
    Codegen(#[from] Box<ModuleError>),
}

#[cfg(feature = "cranelift")]
impl From<ModuleError> for NativeError {
    fn from(e: ModuleError) -> Self {
        NativeError::Codegen(Box::new(e))
    }
}
