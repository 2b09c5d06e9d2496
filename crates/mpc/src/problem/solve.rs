//! How a problem file wants to be solved.

use super::Method;
use super::reader::{Parsed, Reader};
use bracketry_system::{Table, Value};

pub(super) const KEYS: [&str; 9] = [
    "method",
    "initial_iterations",
    "max_iterations",
    "tolerance",
    "qp_tolerance",
    "smoothing",
    "margin",
    "proximal",
    "guarded",
];

impl Reader<'_> {
    pub(super) fn method(&self, solve: &Table<'_>) -> Parsed<Method> {
        match (self.doc.string(solve, "method")?.as_deref(), solve.get("method")) {
            (None | Some("rti"), _) | (_, None) => Ok(Method::Rti),
            (Some("sqp"), _) => Ok(Method::Sqp),
            (Some("plan"), _) => Ok(Method::Plan),
            (Some(other), Some(v)) => {
                let message = format!("there is no method `{other}`");
                Err(self.doc.error(v.span(), message, "write \"rti\", \"sqp\" or \"plan\"").into())
            }
        }
    }

    pub(super) fn smoothing(&self, solve: &Table<'_>, planned: bool) -> Parsed<Vec<f64>> {
        let Some(v) = solve.get("smoothing") else {
            return Ok(if planned { vec![0.1, 0.03, 0.01, 0.003] } else { vec![0.01] });
        };
        let mut widths = Vec::new();
        match v.get_ref() {
            Value::Array(list) => {
                for w in list {
                    widths.push(self.constant(w, "smoothing")?);
                }
            }
            _ => widths.push(self.constant(v, "smoothing")?),
        }
        if widths.is_empty() || widths.iter().any(|w| *w <= 0.0) {
            let remedy = "give a positive width, or a list of them from wide to narrow";
            return Err(self.doc.error(v.span(), "`smoothing` must be positive", remedy).into());
        }
        Ok(widths)
    }
}
