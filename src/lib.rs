//! Bracketry
