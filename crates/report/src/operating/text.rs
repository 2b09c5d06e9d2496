//! The text of operating points and linear systems.

use bracketry_lie::linear::Distance;
use bracketry_lie::operating::{
    Gain, LinearAnalysis, LinearMatrix, LinearModel, NoGain, Pole, Rank, Rest, Trim, TrimNote, TrimRole, TrimStatus,
    TrimValue,
};
use bracketry_system::readable;
use nalgebra::DMatrix;

/// What is located to this accuracy, relative to its size, is located to rounding.
const ROUNDING: f64 = 1e-12;

/// A note as a sentence.
pub(super) fn note(n: &TrimNote) -> String {
    match n {
        TrimNote::Underdetermined { dimensions } => format!(
            "the solutions form a set of dimension {dimensions}; this is the one nearest to the model's point (least \
             norm); fix more variables to get another"
        ),
        TrimNote::Degenerate { accuracy } => {
            let how = if *accuracy <= ROUNDING {
                "; the signs of the equations in exact arithmetic locate the solution".to_owned()
            } else {
                format!(", and no exact sign locates the solution: it is accurate to about {accuracy:.0e}; more digits mean nothing")
            };
            format!(
                "in floating point, the Jacobian does not have full rank here: this is a multiple root, or coefficients differ \
                 much in size{how}"
            )
        }
        TrimNote::NotConfirmed => "the equations vanish there to rounding, but none changes its sign, and no exact values confirm it: \
                                   this may be a multiple solution, or a point where they only come near zero; to use it, write it \
                                   into [point]"
            .to_owned(),
        TrimNote::WithinRounding { distance } => format!(
            "the model's point differs from this one by at most {distance:.1e}, which is rounding: it is accepted as \
             this operating point"
        ),
        TrimNote::OutOfRange { input, value } => {
            format!("{input} = {} is outside its range in the model", readable(*value))
        }
        TrimNote::Switching { name } => format!(
            "{name} is 0 here, where the equations jump or have a kink: sign(0) is taken as 0; with dry friction, \
             nearby points are at rest too"
        ),
        TrimNote::Limit { tried, starts } => {
            format!(
                "time or memory limit reached: {tried} of {starts} starts were tried (--time-limit, --memory-limit)"
            )
        }
        TrimNote::Derivative { input } => format!("derivatives of {input} are 0 here"),
    }
}

fn value(v: &TrimValue) -> String {
    let exact = match &v.exact {
        Some(e) if e.text().parse::<f64>().is_err() => format!(" = {e}"),
        _ => String::new(),
    };
    let role = match v.role {
        TrimRole::Free => "",
        TrimRole::Fixed => "   (fixed)",
        TrimRole::Held => "   (held at the model's point; use --free to search for it)",
    };
    format!("  {:>10} = {}{exact}{role}", v.name, readable(v.value))
}

/// An operating point in text.
pub fn trim_text(model: &str, trim: &Trim) -> String {
    let heading = match (trim.status, trim.exact) {
        (TrimStatus::Found, true) => "operating point, confirmed exactly".to_owned(),
        (TrimStatus::Found, false) => format!("operating point, residual {:.1e}", trim.residual),
        (TrimStatus::OutOfRange, _) => {
            "no operating point with all inputs within their ranges; this one violates them".to_owned()
        }
        (TrimStatus::NotFound, _) => {
            format!("no operating point found; the best point has the residual {}", readable(trim.residual))
        }
    };
    let mut lines = vec![format!("{model}: {heading}")];
    lines.extend(trim.states.iter().chain(&trim.inputs).map(value));
    let moving = trim.derivatives.iter().filter(|(_, d)| d.abs() > 1e-9);
    lines.extend(moving.map(|(name, d)| format!("  {name:>10}' = {}", readable(*d))));
    lines.extend(trim.notes.iter().map(|n| format!("  note: {}", note(n))));
    if trim.status == TrimStatus::NotFound {
        lines.push(
            "  next: free an input (--free), fix other values (--fix), or let a state move (--moving)".to_owned(),
        );
    }
    for other in &trim.others {
        let names = trim.states.iter().chain(&trim.inputs).zip(other);
        let free = names.filter(|(v, _)| v.role == TrimRole::Free);
        let values: Vec<String> = free.map(|(v, x)| format!("{} = {}", v.name, readable(*x))).collect();
        lines.push(format!("  another: {}", values.join(", ")));
    }
    lines.join("\n") + "\n"
}

/// Larger tables cannot be read.
const MAX_ENTRIES: usize = 30;

fn matrix(name: &str, m: &DMatrix<f64>) -> String {
    if m.ncols().max(m.nrows()) > MAX_ENTRIES {
        let filled = m.iter().filter(|v| **v != 0.0).count();
        return format!("  {name} is {} × {}, {filled} entries are not 0 (--json prints them)", m.nrows(), m.ncols());
    }
    let cells: Vec<Vec<String>> = m.row_iter().map(|r| r.iter().map(|x| readable(*x)).collect()).collect();
    table(name, &cells)
}

fn table(name: &str, cells: &[Vec<String>]) -> String {
    let width = cells.iter().flatten().map(|c| c.chars().count()).max().unwrap_or(0);
    let rows = cells.iter().enumerate().map(|(i, row)| {
        let start = if i == 0 { format!("{name} =") } else { String::new() };
        let row: Vec<String> = row.iter().map(|c| format!("{c:>width$}")).collect();
        format!("  {start:<5}[ {} ]", row.join("  "))
    });
    let rows: Vec<String> = rows.collect();
    if rows.is_empty() { format!("  {name} is empty") } else { rows.join("\n") }
}

/// Longer formulas are not worth a table.
const MAX_FORMULA: usize = 40;

fn formulas(name: &str, m: &LinearMatrix) -> Option<String> {
    let cells: Vec<Vec<String>> = m.formulas.iter().map(|r| r.iter().map(ToString::to_string).collect()).collect();
    let named = cells.iter().flatten().any(|c| c.parse::<f64>().is_err());
    let short = cells.iter().flatten().all(|c| c.chars().count() <= MAX_FORMULA);
    (named && short && m.values.ncols().max(m.values.nrows()) <= MAX_ENTRIES).then(|| table(name, &cells))
}

fn complex((re, im): (f64, f64)) -> String {
    match im {
        0.0 => readable(re),
        im => format!("{} {} {}i", readable(re), if im < 0.0 { "-" } else { "+" }, readable(im.abs())),
    }
}

fn list(name: &str, values: &[(f64, f64)]) -> String {
    let values: Vec<String> = values.iter().map(|z| complex(*z)).collect();
    format!("  {name}: {}", if values.is_empty() { "none".to_owned() } else { values.join(", ") })
}

fn rank(name: &str, r: Rank) -> String {
    format!("  {name}: rank {} of {}{}", r.rank, r.of, if r.exact { "" } else { " (up to rounding)" })
}

/// A minimizer is known to about the root of the rounding of the minimum; a smaller imaginary part is not shown.
const MINIMIZER: f64 = 1e-7;

/// The nearest mode, real where its imaginary part is within the accuracy of the search.
fn nearest(d: &Distance) -> (f64, f64) {
    if d.at.1.abs() < MINIMIZER * d.at.0.abs() { (d.at.0, 0.0) } else { d.at }
}

fn margin(name: &str, d: Option<&Distance>) -> String {
    match d {
        Some(d) if d.upper == 0.0 => format!("  {name}: 0; the mode is {}", complex(nearest(d))),
        Some(d) => format!(
            "  {name}: between {} and {} in the spectral norm; the nearest mode is {}",
            readable(d.lower),
            readable(d.upper),
            complex(nearest(d))
        ),
        None => format!("  {name}: not found, a singular value decomposition did not converge"),
    }
}

fn gain(name: &str, matrix_name: &str, closed: &str, gain: &Result<Gain, NoGain>) -> Vec<String> {
    match gain {
        Ok(g) => vec![
            format!("  {name}, residual of the Riccati equation {:.1e}", g.residual),
            matrix(matrix_name, &g.gain),
            list(closed, &g.poles),
        ],
        Err(why) => vec![format!("  {name}: none, {why}")],
    }
}

/// That inputs act later than they are commanded; none where they do not.
pub(super) fn delayed(model: &LinearModel) -> Option<String> {
    let list: Vec<String> =
        model.input_delays.iter().map(|(name, delay)| format!("{name} by {}", readable(*delay))).collect();
    (!list.is_empty()).then(|| {
        format!(
            "inputs act later than they are commanded ({}): the matrices are those of the inputs as they arrive, without the delay",
            list.join(", ")
        )
    })
}

/// A linear system in text.
pub fn linear_text(r: &LinearAnalysis) -> String {
    let s = &r.system;
    let names = |list: &[String]| if list.is_empty() { "none".to_owned() } else { list.join(", ") };
    let mut lines = vec![
        format!("{}: x' = A x + B u, y = C x + D u around the point", s.model),
        format!("  states {}; inputs {}; outputs {}", names(&s.states), names(&s.inputs), names(&s.outputs)),
    ];
    if s.states_are_outputs {
        lines.push("  note: the model has no outputs: all states are treated as measured".to_owned());
    }
    if let Some(delays) = delayed(s) {
        lines.push(format!("  note: {delays}"));
    }
    let at = s.states.iter().chain(&s.inputs).zip(&s.point).map(|(n, v)| format!("{n} = {}", readable(*v)));
    lines.push(format!("  at {}", at.collect::<Vec<_>>().join(", ")));
    match s.rest {
        Rest::Equilibrium => lines.push("  the point is an equilibrium".to_owned()),
        Rest::WithinRounding { residual } => {
            lines
                .push(format!("  note: the point is an equilibrium up to rounding (derivatives up to {residual:.1e})"));
        }
        Rest::Moving { residual } => lines.push(format!(
            "  note: the point is not an equilibrium (derivatives up to {}): the matrices describe deviations from \
             the motion; use trim to find equilibria",
            readable(residual)
        )),
    }
    for (name, m) in [("A", &s.a), ("B", &s.b), ("C", &s.c), ("D", &s.d)] {
        lines.extend(formulas(name, m));
        lines.push(matrix(name, &m.values));
    }
    let pole = |p: &Pole| {
        let times = if p.multiplicity > 1 { format!(" ({} times)", p.multiplicity) } else { String::new() };
        format!("{}{times}", complex((p.re, p.im)))
    };
    lines.push(match &r.poles {
        Some(poles) => format!("  poles: {}", poles.iter().map(pole).collect::<Vec<_>>().join(", ")),
        None => "  poles: not found, the QR algorithm did not converge".to_owned(),
    });
    if let Some([left, axis, right]) = r.half_planes {
        lines.push(format!("  poles by half-plane (exact): {left} left, {axis} on the axis, {right} right"));
    }
    lines.push(match &r.zeros {
        Some(zeros) => list("zeros", zeros),
        None => "  zeros: not found, a decomposition did not converge".to_owned(),
    });
    lines.push(rank("controllability", r.controllability));
    lines.push(rank("observability", r.observability));
    lines.push(margin("distance to an uncontrollable pair", r.distance_to_uncontrollable.as_ref()));
    lines.push(margin("distance to an unobservable pair", r.distance_to_unobservable.as_ref()));
    match &r.gramians {
        Some(g) => {
            let over = g.horizon.map_or("all time".to_owned(), |t| {
                let unstable = r.poles.as_ref().is_some_and(|poles| poles.iter().any(|p| p.re >= 0.0));
                let why = if unstable { ", because the system is not stable" } else { "" };
                format!("the time from 0 to {}{why}", readable(t))
            });
            lines.push(format!("  Gramians over {over}"));
            lines.push(matrix("Wc", &g.controllability));
            lines.push(matrix("Wo", &g.observability));
        }
        None => lines.push("  Gramians: not found".to_owned()),
    }
    lines.extend(gain("linear-quadratic regulator u = -K x", "K", "poles of A - B K", &r.regulator));
    lines.extend(gain("steady-state Kalman filter", "L", "poles of A - L C", &r.estimator));
    lines.join("\n") + "\n"
}
