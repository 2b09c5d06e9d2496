//! Tables of an identification, for Markdown and pages.

use bracketry_stiffness::{CartesianEstimate, Identification, Identified, TWIST_COLUMNS, WRENCH_COLUMNS};

/// What is to be said of a matrix at the tool point.
pub(super) const MATRIX: &str = "Tool point, base axes; ± half of the 95 % interval.";

/// Every method with its figures, or why it does not apply.
pub(super) fn methods(found: &Identification) -> ([&'static str; 5], Vec<Vec<String>>) {
    let rows = found.methods.iter().map(|(method, figures)| {
        let numbers = match figures {
            Ok(f) => [f.held_out, f.condition, f.chi_square].map(|value| format!("{value:.3}")),
            Err(_) => Default::default(),
        };
        let failed = figures.as_ref().err().map(ToString::to_string).unwrap_or_default();
        [method.to_string()].into_iter().chain(numbers).chain([failed]).collect()
    });
    (["method", "error of prediction [σ]", "condition", "χ²/dof", "does not apply"], rows.collect())
}

/// The numbers of every joint with their intervals.
pub(super) fn springs(found: &Identification) -> ([&'static str; 4], Vec<Vec<String>>) {
    let rows = found.parameters.iter().map(|p| {
        let (value, interval) = match &p.identified {
            Identified::Yes { value, low, high } => (format!("{value:.4e}"), format!("{low:.4e} … {high:.4e}")),
            no @ Identified::No { .. } => ("not identified".to_owned(), no.why().unwrap_or_default()),
        };
        vec![p.joint.to_string(), p.name.to_owned(), value, interval]
    });
    (["joint", "number", "value", "95 % interval"], rows.collect())
}

/// A matrix of entries with their intervals.
pub(super) struct Matrix {
    pub(super) title: &'static str,
    pub(super) header: Vec<&'static str>,
    pub(super) rows: Vec<Vec<String>>,
}

pub(super) fn compliance(pose: &CartesianEstimate) -> Matrix {
    let entry = |i, j| (pose.compliance[(i, j)], pose.compliance_interval(i, j));
    matrix("Compliance [µm, µrad per N, N·m]", [TWIST_COLUMNS, WRENCH_COLUMNS], 1e6, entry)
}

pub(super) fn stiffness(pose: &CartesianEstimate) -> Matrix {
    let entry = |i, j| (pose.stiffness[(i, j)], pose.stiffness_interval(i, j));
    matrix("Stiffness [N, N·m per µm, µrad]", [WRENCH_COLUMNS, TWIST_COLUMNS], 1e-6, entry)
}

/// Names of its rows, then of its columns.
fn matrix(
    title: &'static str,
    [rows, columns]: [[&'static str; 6]; 2],
    scale: f64,
    entry: impl Fn(usize, usize) -> (f64, (f64, f64)),
) -> Matrix {
    let row = |i: usize| {
        let cell = |j: usize| {
            let (value, (low, high)) = entry(i, j);
            format!("{:.4} ± {:.4}", scale * value, 0.5 * scale * (high - low))
        };
        std::iter::once(rows[i].to_owned()).chain((0..6).map(cell)).collect()
    };
    let header = std::iter::once("").chain(columns).collect();
    Matrix { title, header, rows: (0..6).map(row).collect() }
}
