//! The table `[uncertainty]`: parameters whose values are not known, and when they are taken to change.

use super::reader::{Located, Parsed, Reader};
use super::tree::{Combination, Tree};
use bracketry_symbolic::Rational;
use bracketry_system::{Table, Value};

const KEYS: [&str; 6] = ["parameters", "scenarios", "weights", "robust_horizon", "noise", "confidence"];
/// Those that need a tree.
const OF_TREES: [&str; 2] = ["weights", "robust_horizon"];

/// Most branches of a tree: a program has as many copies of the model.
const MOST_BRANCHES: usize = 64;
/// Most states of all branches together.
const MOST_STATES: usize = 1000;

/// A parameter's value with its weight.
type Weighted = (Rational, f64);

impl Reader<'_> {
    /// The scenario tree of a problem file; none where no parameter is uncertain.
    pub(super) fn uncertainty(&self, table: &Table<'_>) -> Parsed<Option<Tree>> {
        let Some(t) = self.doc.sub_table(table, "uncertainty")? else { return Ok(None) };
        self.doc.only_keys(t, &KEYS, "[uncertainty]")?;
        let place = table.get("uncertainty").map_or(0..0, toml::Spanned::span);
        let combinations = match (t.get("parameters"), t.get("scenarios")) {
            (Some(_), Some(v)) => {
                let message = "`parameters` and `scenarios` both define the scenarios";
                return Err(self.doc.error(v.span(), message, "remove one of them").into());
            }
            (Some(v), None) => self.products(v, t)?,
            (None, Some(v)) => self.listed(v, t)?,
            (None, None) if t.contains_key("noise") || t.contains_key("confidence") => {
                if let Some((key, v)) = OF_TREES.into_iter().find_map(|key| Some((key, t.get(key)?))) {
                    let message = format!("`{key}` needs uncertain parameters");
                    return Err(self.doc.error(v.span(), message, "add `parameters`, or remove it").into());
                }
                return Ok(None);
            }
            (None, None) => {
                let remedy = "write parameters = { k = [0.9, 1.0, 1.1] }, or remove [uncertainty]";
                return Err(self.doc.error(place, "[uncertainty] names no parameters", remedy).into());
            }
        };
        let robust_horizon = self.count(t, "robust_horizon", Some(1))?;
        let branches = (0..robust_horizon).try_fold(1_usize, |n, _| n.checked_mul(combinations.len()));
        let branches = branches.unwrap_or(usize::MAX);
        let states = branches.saturating_mul(self.system.states.len());
        if branches > MOST_BRANCHES || states > MOST_STATES {
            let message = format!(
                "{} combinations over a robust horizon of {robust_horizon} make {branches} branches with {states} states",
                combinations.len()
            );
            let remedy = format!(
                "use at most {MOST_BRANCHES} branches with {MOST_STATES} states: fewer values, listed `scenarios`, or a \
                 shorter `robust_horizon`"
            );
            return Err(self.doc.error(place, message, remedy).into());
        }
        let total: f64 = combinations.iter().map(|c| c.weight).sum();
        if total <= 0.0 {
            let place = t.get("weights").map_or(place, toml::Spanned::span);
            return Err(self.doc.error(place, "all weights are zero", "give one of them a positive number").into());
        }
        let share = |c: Combination| Combination { weight: c.weight / total, ..c };
        Ok(Some(Tree::new(self.system, combinations.into_iter().map(share).collect(), robust_horizon)))
    }

    /// All combinations of the values of `parameters`; weights are those of the values, multiplied.
    fn products(&self, v: Located<'_, '_>, t: &Table<'_>) -> Parsed<Vec<Combination>> {
        let remedy = "write parameters = { k = [0.9, 1.0, 1.1] }";
        let Value::Table(parameters) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "`parameters` must be a table", remedy).into());
        };
        let weights = match t.get("weights").map(|w| (w, w.get_ref())) {
            None => None,
            Some((_, Value::Table(weights))) => Some(weights),
            Some((w, _)) => {
                let message = "with `parameters`, `weights` must be a table";
                let remedy = "write weights = { k = [0.25, 0.5, 0.25] }: one per value of each parameter";
                return Err(self.doc.error(w.span(), message, remedy).into());
            }
        };
        let without = |name: &str| !parameters.contains_key(name);
        if let Some((name, _)) = weights.into_iter().flatten().find(|(name, _)| without(name.get_ref())) {
            let message = format!("`{}` has weights but no values", name.get_ref());
            return Err(self.doc.error(name.span(), message, "add its values to `parameters`").into());
        }
        let mut combinations = vec![Combination { values: Vec::new(), weight: 1.0 }];
        for (key, v) in parameters {
            let name: &str = key.get_ref();
            self.uncertain_parameter(name, key.span())?;
            let values = self.weighted(name, v, weights.and_then(|w| w.get(name)))?;
            if combinations.len().saturating_mul(values.len()) > MOST_BRANCHES {
                let message = format!("the values up to those of `{name}` make more than {MOST_BRANCHES} combinations");
                let remedy = "give fewer values, or list the combinations that matter as `scenarios`";
                return Err(self.doc.error(v.span(), message, remedy).into());
            }
            let with = |c: &Combination, (value, weight): &Weighted| {
                let own = [(name.to_owned(), value.clone())];
                Combination { values: c.values.iter().cloned().chain(own).collect(), weight: c.weight * weight }
            };
            combinations = combinations.iter().flat_map(|c| values.iter().map(move |v| with(c, v))).collect();
        }
        if parameters.is_empty() {
            return Err(self.doc.error(v.span(), "`parameters` is empty", remedy).into());
        }
        Ok(combinations)
    }

    /// The values of one parameter, with their weights.
    fn weighted(&self, name: &str, v: Located<'_, '_>, weights: Option<Located<'_, '_>>) -> Parsed<Vec<Weighted>> {
        let remedy = format!("write {name} = [0.9, 1.0, 1.1]");
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), format!("the values of `{name}` must be a list"), remedy).into());
        };
        if list.is_empty() {
            return Err(self.doc.error(v.span(), format!("`{name}` has no values"), remedy).into());
        }
        let weights = self.scenario_weights(weights, list.len())?;
        list.iter().zip(weights).map(|(v, w)| Ok((self.exact(v, name)?, w))).collect()
    }

    /// The combinations of the list `scenarios`.
    fn listed(&self, v: Located<'_, '_>, t: &Table<'_>) -> Parsed<Vec<Combination>> {
        let remedy = "write scenarios = [{ k = 0.9, m = 1 }, { k = 1.1, m = 2 }]";
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "`scenarios` must be a list of tables", remedy).into());
        };
        let weights = self.scenario_weights(t.get("weights"), list.len())?;
        let mut combinations: Vec<Combination> = Vec::new();
        for (entry, weight) in list.iter().zip(weights) {
            let Value::Table(values) = entry.get_ref() else {
                return Err(self.doc.error(entry.span(), "a scenario must be a table", remedy).into());
            };
            let mut own = Vec::new();
            for (key, v) in values {
                self.uncertain_parameter(key.get_ref(), key.span())?;
                own.push((key.get_ref().to_string(), self.exact(v, key.get_ref())?));
            }
            own.sort_by(|a, b| a.0.cmp(&b.0));
            let names = |c: &[(String, Rational)]| c.iter().map(|v| v.0.clone()).collect::<Vec<_>>();
            if own.is_empty() || combinations.first().is_some_and(|first| names(&first.values) != names(&own)) {
                let message = "every scenario must give values to the same parameters";
                return Err(self.doc.error(entry.span(), message, remedy).into());
            }
            combinations.push(Combination { values: own, weight });
        }
        if combinations.is_empty() {
            return Err(self.doc.error(v.span(), "`scenarios` is empty", remedy).into());
        }
        Ok(combinations)
    }

    /// Refuses what is no parameter of the model.
    fn uncertain_parameter(&self, name: &str, span: std::ops::Range<usize>) -> Parsed<()> {
        let known = self.system.parameter_names();
        if known.iter().any(|k| k == name) { Ok(()) } else { Err(self.unknown(name, span, "parameter", &known)) }
    }

    /// `count` weights; all 1 where none are given.
    fn scenario_weights(&self, v: Option<Located<'_, '_>>, count: usize) -> Parsed<Vec<f64>> {
        let Some(v) = v else { return Ok(vec![1.0; count]) };
        let remedy = "write a list with one weight each, such as weights = [0.25, 0.5, 0.25]";
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "weights must be a list", remedy).into());
        };
        if list.len() != count {
            let message = format!("{} weights for {count} values", list.len());
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let mut weights = Vec::new();
        for w in list {
            let value = self.constant(w, "weights")?;
            if value < 0.0 {
                return Err(self.doc.error(w.span(), "a weight must not be negative", remedy).into());
            }
            weights.push(value);
        }
        Ok(weights)
    }
}
