//! How the columns of a table are meant.

use bracketry_sim::Hold;
use bracketry_system::{FileError, System};

use super::origin::Origin;
use super::roles::{known, role};
use crate::settings::ReadSettings;

/// How the columns of a table are meant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordSettings {
    /// How inputs go on between samples. `None`: each value is held until the next sample; an input whose derivatives the
    /// model uses, and these, follow straight lines, since that is a motion and not a command.
    pub hold: Option<Hold>,
    /// Pairs: the name of a column, the name in the model that it gets.
    pub rename: Vec<(String, String)>,
    /// What is accepted, and what deserves a warning.
    pub limits: ReadSettings,
}

impl RecordSettings {
    /// The name in the model of a column.
    pub(super) fn renamed<'a>(&'a self, column: &'a str) -> &'a str {
        self.rename.iter().find(|(from, _)| from == column).map_or(column, |(_, to)| to)
    }

    /// Refuses to rename columns that are not there, and to give names that mean nothing to the model; only a column whose own
    /// name another one gets may be called anything.
    pub(super) fn check(&self, origin: &Origin<'_>, header: &[String], system: &System) -> Result<(), FileError> {
        if let Some((from, _)) = self.rename.iter().find(|(from, _)| !header.contains(from)) {
            return Err(origin.whole(
                format!("there is no column `{from}` to rename; there are {}", header.join(", ")),
                "name a column of the table before the equals sign: --rename q=x",
            ));
        }
        let meaningless = |(from, to): &&(String, String)| {
            role(to, system).is_none() && !self.rename.iter().any(|(_, other)| other == from)
        };
        match self.rename.iter().find(meaningless) {
            None => Ok(()),
            Some((from, to)) => Err(origin.whole(
                format!("--rename {from}={to}: the model has no `{to}`"),
                format!("give a name of the model after the equals sign: {}", known(system).join(", ")),
            )),
        }
    }
}
