//! What a problem file makes of its references: which are used, and what follows them.

use super::reader::{Located, Parsed, Reader, identifiers};
use crate::ocp::{CostKind, CostNames};
use crate::problem::{ReferenceUse, Scheduled};
use bracketry_system::{Table, Value};

/// The costs of a problem file that may name a reference, with whether they are squared.
const COSTS: [(&str, CostKind, bool); 4] = [
    ("stage", CostKind::Stage, false),
    ("residuals", CostKind::Stage, true),
    ("terminal", CostKind::Terminal, false),
    ("terminal_residuals", CostKind::Terminal, true),
];

impl Reader<'_> {
    /// What becomes of the references. `names` are those that costs and constraints know.
    pub(super) fn reference_uses(
        &self,
        table: &Table<'_>,
        references: &[Scheduled],
        names: &[String],
    ) -> Parsed<Vec<ReferenceUse>> {
        if references.is_empty() {
            return Ok(Vec::new());
        }
        let texts = self.texts(table)?;
        let mut uses: Vec<ReferenceUse> = references
            .iter()
            .map(|r| {
                let used = r.is_derivative() || texts.iter().any(|text| identifiers(text).any(|word| word == r.name));
                ReferenceUse { name: r.name.clone(), used, tracked_by: None }
            })
            .collect();
        let Some(cost) = self.doc.sub_table(table, "cost")? else { return Ok(uses) };
        for (key, kind, squared) in COSTS {
            let Some(v) = cost.get(key) else { continue };
            let parts: Vec<Located<'_, '_>> = match v.get_ref() {
                Value::Array(list) => list.iter().collect(),
                Value::String(text) if key == "terminal" && text == "riccati" => continue,
                _ => vec![v],
            };
            for part in parts {
                self.tracked(part, key, (kind, squared), names, &mut uses)?;
            }
        }
        Ok(uses)
    }

    /// The texts of costs and constraints.
    fn texts<'t>(&self, table: &'t Table<'_>) -> Parsed<Vec<&'t str>> {
        let mut texts = Vec::new();
        for name in ["cost", "constraints"] {
            for v in self.doc.sub_table(table, name)?.into_iter().flat_map(Table::values) {
                collect_texts(v, &mut texts);
            }
        }
        Ok(texts)
    }

    /// The derivatives of references that costs and constraints use, each once: name and order.
    pub(super) fn derivatives_used(&self, table: &Table<'_>, references: &[Scheduled]) -> Parsed<Vec<(String, u32)>> {
        let mut used: Vec<(String, u32)> = Vec::new();
        for (name, order) in self.texts(table)?.into_iter().flat_map(derivatives) {
            if references.iter().any(|r| r.name == name) && !used.iter().any(|u| u.0 == name && u.1 == order) {
                used.push((name.to_owned(), order));
            }
        }
        Ok(used)
    }

    /// Finds the states and inputs z that a cost l draws to a reference r: ∂l/∂r depends on z and vanishes at z = r, whatever the rest is.
    fn tracked(
        &self,
        v: Located<'_, '_>,
        key: &str,
        (kind, squared): (CostKind, bool),
        names: &[String],
        uses: &mut [ReferenceUse],
    ) -> Parsed<()> {
        let (context, mut pool) = CostNames::new(self.system, kind, names);
        let mut context = context.with_remembered(self.remembered);
        let mut cost = self.doc.expression(v, key, &mut pool, &mut context)?;
        if squared {
            cost = pool.powi(cost, 2);
        }
        let inputs: &[_] = if kind == CostKind::Stage { &self.system.inputs } else { &[] };
        for found in uses.iter_mut().filter(|r| r.tracked_by.is_none()) {
            let symbol = pool.symbol(&found.name);
            if !pool.depends_on(cost, symbol) {
                continue;
            }
            let (slope, r) = (pool.diff(cost, symbol), pool.sym(symbol));
            for &z in self.system.states.iter().chain(inputs) {
                if pool.depends_on(slope, z) {
                    let from = pool.sym(z);
                    let met = pool.substitute_all(&[slope], &[(from, r)].into_iter().collect())[0];
                    if pool.is_zero(met) {
                        found.tracked_by = Some(self.system.symbol_name(z).to_owned());
                        break;
                    }
                }
            }
        }
        Ok(())
    }
}

/// All texts in a value.
fn collect_texts<'t>(v: Located<'t, '_>, texts: &mut Vec<&'t str>) {
    match v.get_ref() {
        Value::Array(list) => list.iter().for_each(|v| collect_texts(v, texts)),
        Value::Table(t) => t.values().for_each(|v| collect_texts(v, texts)),
        Value::String(text) => texts.push(text),
        _ => {}
    }
}

/// Names and orders of `der(name)` and `der(name, order)` in an expression.
fn derivatives(text: &str) -> impl Iterator<Item = (&str, u32)> {
    text.match_indices("der").filter_map(|(at, word)| {
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        if text[..at].ends_with(is_name) {
            return None;
        }
        let inner = text[at + word.len()..].trim_start().strip_prefix('(')?.split(')').next()?;
        match inner.split_once(',') {
            None => Some((inner.trim(), 1)),
            Some((name, order)) => Some((name.trim(), order.trim().parse().ok()?)),
        }
    })
}
