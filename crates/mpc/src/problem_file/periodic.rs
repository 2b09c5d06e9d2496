//! States that end where they start.

use super::constraints::Vector;
use super::free::start_name;
use super::reader::{Parsed, Reader};
use crate::ocp::{Bounds, CostKind, CostNames, Ocp, PathConstraint, Softness};
use crate::problem::ProblemError;
use bracketry_symbolic::{Expr, Pool, Rational};
use bracketry_system::{Table, Value};

const REMEDY: &str = "write periodic = [\"x\", \"v\"]";

impl Reader<'_> {
    /// For every state that `periodic` lists, (x(T) − x(0))/scale = 0 at the end. `names` are the references.
    pub(super) fn periodic(
        &self,
        table: &Table<'_>,
        x0: &[f64],
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        for state in self.periodic_states(table)? {
            let name = self.system.symbol_name(self.system.states[state]);
            let (_, mut pool) = CostNames::new(self.system, CostKind::Stage, names);
            let start = if ocp.free_starts.iter().any(|(free, _)| *free == state) {
                pool.var(&start_name(self.system, state))
            } else {
                number(&mut pool, x0[state])
            };
            let (x, scale) = (pool.sym(self.system.states[state]), number(&mut pool, ocp.state_scale[state]));
            let difference = pool.sub(x, start);
            let components = vec![pool.div(difference, scale)];
            let g = Vector { pool, components, uses_states: true, uses_inputs: false };
            ocp.path_constraints.push(PathConstraint {
                name: format!("periodic {name}"),
                function: self.compiled(g, names)?,
                bounds: Bounds { min: 0.0, max: 0.0, softness: Softness::Hard },
                at_end: true,
            });
        }
        Ok(())
    }

    fn periodic_states(&self, table: &Table<'_>) -> Parsed<Vec<usize>> {
        let Some(v) = table.get("periodic") else { return Ok(Vec::new()) };
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "`periodic` must be a list of states", REMEDY).into());
        };
        let targets = self.doc.sub_table(table, "target")?;
        let mut states = Vec::new();
        for entry in list {
            let Value::String(name) = entry.get_ref() else {
                return Err(self.doc.error(entry.span(), "a name must be in quotes", REMEDY).into());
            };
            let state = self.state(name, entry.span())?;
            if states.contains(&state) {
                return Err(self.doc.error(entry.span(), format!("`{name}` is listed twice"), "remove one").into());
            }
            if targets.is_some_and(|t| t.contains_key(name.as_ref())) {
                let message = format!("`{name}` has a target and is periodic: both say where it ends");
                return Err(self.doc.error(entry.span(), message, "remove one of them").into());
            }
            states.push(state);
        }
        Ok(states)
    }
}

fn number(pool: &mut Pool, value: f64) -> Expr {
    pool.rational(Rational::simplest_from_f64(value).unwrap_or_default())
}
