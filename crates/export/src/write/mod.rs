//! The text of the files, language by language.

mod body;
mod c;
mod casadi;
mod description;
mod julia;
mod layout;
mod python;
mod rust;

use crate::equations::Compiled;
use crate::exported::Export;
use crate::options::Target;

/// Fills in the files.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    match made.target {
        Target::C => c::write(made, functions),
        Target::Rust => rust::write(made, functions),
        Target::Python => python::write(made, functions),
        Target::Casadi => casadi::write(made, functions),
        Target::Julia => julia::write(made, functions),
    }
}
