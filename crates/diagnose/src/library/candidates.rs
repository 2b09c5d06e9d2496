//! The causes of the library, instantiated on a model.

use bracketry_system::System;

use super::builder::Builder;
use crate::effect::Effect;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::LibrarySettings;

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
pub fn candidates(
    system: &System,
    records: &[Record],
    settings: &LibrarySettings,
) -> Result<Vec<Effect>, DiagnoseError> {
    let mut builder = Builder::new(system, records, settings);
    builder.add_friction()?;
    builder.add_forces()?;
    builder.add_first_order()?;
    builder.add_actuators(records)?;
    builder.add_paths(records);
    builder.add_inertia()?;
    builder.add_joints()?;
    Ok(builder.effects)
}
