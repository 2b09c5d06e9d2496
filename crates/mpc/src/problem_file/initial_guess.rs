//! The inputs of the first guess from a table, such as one that another search has found.

use super::reader::{Parsed, Reader};
use crate::ocp::Ocp;
use bracketry_sim::{Hold, Samples};
use bracketry_system::{Columns, Entries, Table};

impl Reader<'_> {
    /// Puts the columns of the table that `[initial_guess]` names into the guess: the mean over every interval. After the last
    /// row its values stay. Inputs without a column keep their guess.
    pub(super) fn initial_guess(&self, table: &Table<'_>, ocp: &Ocp, guess: &mut [Vec<f64>]) -> Parsed<()> {
        let Some(t) = self.doc.sub_table(table, "initial_guess")? else { return Ok(()) };
        self.doc.only_keys(t, &["file", "hold"], "[initial_guess]")?;
        let Some(name) = self.doc.string(t, "file")? else {
            let remedy = "add file = \"inputs.csv\": columns t and inputs";
            return Err(self.doc.missing("[initial_guess] names no table", remedy).into());
        };
        let hold = Hold::read(self.doc, t)?;
        let doc = Columns::document(&self.folder.join(name), "name a CSV file: a table with a column t and inputs")?;
        let Columns { columns, .. } = Columns::parse(&doc, |_| Entries::Finite)?;
        let Some(times) = columns.get("t") else {
            return Err(doc.missing("there is no column `t`", "add a column t with the time").into());
        };
        let mut found = false;
        for (j, input) in self.system.input_names().iter().enumerate() {
            let Some(values) = columns.get(input) else { continue };
            found = true;
            let samples = Samples::new(times.clone(), values.clone(), hold)
                .map_err(|e| doc.missing(e.to_string(), "sort the rows by time and remove repeated ones"))?;
            for (k, row) in guess.iter_mut().enumerate() {
                row[j] = samples.mean(ocp.offset(k), ocp.offset(k + 1));
            }
        }
        if !found {
            let names = self.system.input_names().join(", ");
            let remedy = format!("name the columns after the inputs: {names}");
            return Err(doc.missing("no column has the name of an input of the model", remedy).into());
        }
        Ok(())
    }
}
