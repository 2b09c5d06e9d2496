//! Machine code for expression tapes, through Cranelift.
