//! The library of causes: effects instantiated on a model from its structure alone.

mod apply;
mod builder;
mod dictionary;
mod forces;
mod friction;
mod inertia;
mod joints;
mod paths;
mod probe;
mod reference;
mod replace;
mod separate;
mod structure;
mod terms;

pub use apply::TIME_INPUT;
pub(crate) use apply::{ModelNames, apply_all, decimal, parameter};
pub use dictionary::dictionary;
pub use reference::reference_candidates;
pub use separate::separating_experiment;
pub(crate) use structure::{Kind, Structure, is_angle};

use bracketry_system::System;

use crate::effect::Effect;
use crate::error::DiagnoseError;
use crate::record::Record;
use builder::Builder;
use probe::Probe;

/// The effects that may be missing in a model: the causes of the library, each instantiated where the structure of the
/// equations has a place for it.
///
/// The equations say which states are coordinates with their rates, which of them are angles, through which entries a
/// force acts, what dry friction there is. The records give typical sizes: scales of amplitudes, velocities at which
/// friction may change, delays to be tried. Coefficients have names that differ from each other and from all names of the
/// model, so that any selection of effects can be applied together.
///
/// What refitting one parameter would do as well is left out.
///
/// # Errors
/// [`DiagnoseError`] if an effect cannot be written in the names of the model, which the names of a valid model exclude.
pub fn candidates(system: &System, records: &[Record]) -> Result<Vec<Effect>, DiagnoseError> {
    let mut builder = builder_for(system, records);
    builder.add_friction()?;
    builder.add_forces()?;
    builder.add_first_order()?;
    builder.add_paths(records)?;
    builder.add_inertia()?;
    builder.add_joints()?;
    Ok(builder.effects)
}

fn builder_for(system: &System, records: &[Record]) -> Builder {
    let mut system = system.clone();
    let pairs = structure::pairs(&mut system);
    let data = Probe::of_records(&system, records, &pairs);
    let structure = Structure::of(&mut system, &pairs);
    Builder::new(system, structure, data)
}

/// What the coordinates of a model are like.
pub(crate) fn mechanics(system: &mut System) -> Structure {
    let pairs = structure::pairs(system);
    Structure::of(system, &pairs)
}
