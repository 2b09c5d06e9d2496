//! Static levels of dry friction: the table `[static]` of model files, and which switch each is of.

use bracketry_symbolic::{Expr, Names, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::switching::{SwitchKind, SwitchedForm};
use crate::system::{StaticLevel, System};
use bracketry_files::{Document, FileError, Table};

/// Names that are known already, and the derivatives of inputs that the equations use.
struct Known<'a> {
    plain: &'a FxHashMap<String, Expr>,
    derivatives: Vec<(String, u32, Symbol)>,
}

impl Names for Known<'_> {
    fn lookup(&mut self, _pool: &mut Pool, name: &str) -> Option<Expr> {
        self.plain.get(name).copied()
    }

    fn derivative(&mut self, pool: &mut Pool, name: &str, order: u32) -> Option<Expr> {
        let found = self.derivatives.iter().find(|(input, k, _)| input == name && *k == order);
        found.map(|&(_, _, symbol)| pool.sym(symbol))
    }

    fn known(&self) -> Vec<String> {
        self.plain.keys().cloned().collect()
    }
}

/// Reads the table `[static]`: keys are switching functions as they are written, of unit vectors all components with
/// commas between them; values are ratios of at least 1.
pub(crate) fn read_static_levels(
    doc: &Document,
    table: &Table<'_>,
    plain: &FxHashMap<String, Expr>,
    system: &mut System,
) -> Result<(), FileError> {
    let inputs = system.input_names();
    let derivatives = system.input_derivatives.iter().map(|d| (inputs[d.input].clone(), d.order, d.symbol)).collect();
    let mut names = Known { plain, derivatives };
    for (key, value) in doc.sub_table(table, "static")?.into_iter().flatten() {
        let name: &str = key.get_ref();
        let mut components = Vec::new();
        for text in parts(name) {
            let read = system.pool.parse_with(text.trim(), &mut names);
            components.push(read.map_err(|e| doc.error(key.span(), format!("`{name}`: {}", e.message), e.remedy))?);
        }
        let ratio = doc.expression(value, name, &mut system.pool, &mut names)?;
        let level = StaticLevel { components, ratio };
        let form = system.set_valued_form();
        system.check_switch(name, &form, &level).map_err(|e| e.at(doc, key.span()))?;
        system.check_ratio(name, &level).map_err(|e| e.at(doc, value.span()))?;
        system.static_levels.push(level);
    }
    Ok(())
}

/// A list with commas, but for those within parentheses.
fn parts(list: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut from) = (Vec::new(), 0i32, 0);
    for (at, c) in list.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[from..]);
    parts
}

impl SwitchedForm {
    /// Names of all set-valued switches: signs, then unit vectors.
    pub fn set_valued_names(&self) -> Vec<String> {
        let signs = self.signs().iter().filter(|s| s.kind == SwitchKind::Jump).map(|s| s.name.clone());
        signs.chain(self.unit_vectors.iter().map(|v| v.name.clone())).collect()
    }
}

impl System {
    /// The switch that a static level is of: the index of a sign, or, after the signs, of a unit vector.
    pub fn switch_of(&self, form: &SwitchedForm, level: &StaticLevel) -> Option<usize> {
        let signs = form.signs().len();
        if let [surface] = level.components[..] {
            return (0..signs).find(|&i| {
                form.switches[i].kind == SwitchKind::Jump && self.equal_but_for_sign(form.switches[i].surface, surface)
            });
        }
        let vector = form.unit_vectors.iter().position(|v| {
            v.components.len() == level.components.len()
                && level.components.iter().all(|&a| v.components.iter().any(|&b| self.equal_but_for_sign(a, b)))
        });
        vector.map(|v| signs + v)
    }

    fn equal_but_for_sign(&self, a: Expr, b: Expr) -> bool {
        if a == b {
            return true;
        }
        let (mut pool, both) = self.pool.extract(&[a, b]);
        let (difference, sum) = (pool.sub(both[0], both[1]), pool.add(both[0], both[1]));
        [difference, sum].into_iter().any(|e| {
            let simple = pool.simplify(e);
            pool.is_zero(simple)
        })
    }
}
