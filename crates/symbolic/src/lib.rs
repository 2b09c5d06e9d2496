//! Interned symbolic expressions: parse, print, differentiate, simplify, decide zero and rank exactly, compile.
