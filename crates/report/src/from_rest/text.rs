//! The text of motion from rest to rest.

use bracketry_steer::from_rest::{Answer, Cone, FromRest, Grid, GridPoint, Holds, Motion, Proof, Shape, Stroke};
use bracketry_system::{Quantities, counted, readable};

/// What friction balances, as an inequality.
pub(super) fn cone_text(c: &Cone) -> String {
    match (&c.friction, &c.rates[..]) {
        (Some(b), [a]) => format!("|{a}| <= {b}"),
        (Some(b), list) => format!("|({})| <= {b}", list.join(", ")),
        (None, [a]) => format!("{a} = 0"),
        (None, _) => "friction on combinations of velocities".to_owned(),
    }
}

/// A loop in a few words.
pub(super) fn stroke_name(s: &Stroke) -> String {
    let inputs = s.inputs.join(", ");
    match &s.shape {
        Shape::FastSlow { fast, slow } => {
            format!(
                "{inputs} accelerates at {} and returns with an acceleration of at most {}",
                readable(*fast),
                readable(*slow)
            )
        }
        Shape::Together { accelerations: [a, b], twice } => {
            let both = format!(
                "{inputs} move away and back together, with accelerations {} and {}",
                readable(*a),
                readable(*b)
            );
            if *twice { format!("{both}, and again with the opposite sign of the second") } else { both }
        }
        Shape::Carried { peak, fast, slow, shaken } => {
            let there = if *shaken { ", shakes a little" } else { "" };
            let [first, second] = [0, 1].map(|k| s.inputs.get(k).map_or("", String::as_str));
            format!(
                "{second} moves away by {}{there}, {first} accelerates there at {} and returns with an acceleration of at most {}",
                readable(*peak),
                readable(*fast),
                readable(*slow)
            )
        }
        Shape::Diagonal { fast: [a, b], slow: [c, d] } => format!(
            "{inputs} accelerate together at {} and {} and return one after the other with accelerations of at most {} and {}",
            readable(*a),
            readable(*b),
            readable(*c),
            readable(*d)
        ),
        Shape::Lift { peak, shaken } => {
            let there = if *shaken { ", shakes a little," } else { "" };
            format!("{inputs} moves away by {}{there} and comes back", readable(*peak))
        }
    }
}

fn proof(p: Proof) -> &'static str {
    match p {
        Proof::Proven => "proven",
        Proof::Evidence => "numerical evidence",
    }
}

fn answer(a: Answer) -> String {
    match a {
        Answer::No => "no (proven)".to_owned(),
        Answer::Yes { proof: p } => format!("yes ({})", proof(p)),
        Answer::Unknown => "unknown".to_owned(),
    }
}

fn motion(m: Motion) -> &'static str {
    match m {
        Motion::Never => "never changes",
        Motion::OnlyUp => "never decreases",
        Motion::OnlyDown => "never increases",
        Motion::Open => "",
    }
}

/// The answer, with its reasons.
pub fn from_rest_text(quantities: &Quantities, found: &FromRest) -> String {
    let mut lines = vec![format!("{}: from rest to rest", found.model)];
    lines.push(format!("are all rest states near the point reachable from it: {}", answer(found.answer)));
    if let Some(reason) = &found.reason {
        lines.push(format!("  {reason}"));
    }
    if !found.bounds.is_empty() {
        lines.push("bounds:".to_owned());
        for b in &found.bounds {
            lines.push(format!("  {} from {} to {}", b.name, readable(b.low), readable(b.high)));
        }
    }
    if !found.coordinates.is_empty() {
        lines.push("coordinates, and whether they change in both directions:".to_owned());
        for c in &found.coordinates {
            let more = motion(c.motion);
            let more =
                if more.is_empty() { String::new() } else { format!(": {more}, for all inputs within their bounds") };
            lines.push(format!("  {} = {}: {}{more}", c.name, readable(c.at), answer(c.answer)));
        }
    }
    if !found.cones.is_empty() {
        lines.push("friction holds, if at rest:".to_owned());
        for c in &found.cones {
            let holds = match c.holds {
                Holds::Always => "for all admissible inputs",
                Holds::NotAlways => "not for all admissible inputs",
                Holds::Undecided => "not decided",
            };
            lines.push(format!("  {}: {}: {holds}", c.velocities.join(", "), cone_text(c)));
        }
    }
    if !found.strokes.is_empty() {
        lines.push("loops of the inputs, from rest to rest, and their displacements:".to_owned());
        for s in &found.strokes {
            lines.push(format!("  {} ({})", stroke_name(s), quantities.time_unit.text(readable(s.duration))));
            for d in s.displacements.iter().take(2) {
                let list: Vec<String> = found
                    .coordinates
                    .iter()
                    .zip(&d.change)
                    .filter(|(_, d)| d.abs() > 1e-12)
                    .map(|(c, d)| format!("{} changes by {}", c.name, readable(*d)))
                    .collect();
                let list = if list.is_empty() { "nothing changes".to_owned() } else { list.join(", ") };
                let when = if d.scale == 1.0 {
                    String::new()
                } else {
                    format!("with all durations times {}: ", readable(d.scale))
                };
                lines.push(format!("    {when}{list}"));
            }
            if let Some((c, sign)) = s.proven {
                let way = if sign > 0.0 { "in the positive direction" } else { "in the negative direction" };
                lines.push(format!("    proven: moves only {}, and only {way}", found.coordinates[c].name));
            }
        }
        let names: Vec<&str> = found.moving.iter().map(|&c| found.coordinates[c].name.as_str()).collect();
        lines.push(format!(
            "margin: a ball of radius {} lies in the hull of the directions of displacement over {}",
            readable(found.margin),
            names.join(", ")
        ));
    }
    if let Some(grid) = &found.grid {
        lines.extend(grid_lines(found, grid));
    }
    if let Some(back) = &found.back {
        lines.push(format!(
            "return: {} loops lead back to the point within {:.0e}; the derivative of the final state with respect to their durations has the smallest singular value {}, \
             so that to first order they reach a ball of radius {} in units of the largest displacements",
            back.loops.len(),
            back.error,
            short(back.singular),
            short(back.reach)
        ));
    }
    lines.join("\n") + "\n"
}

/// How far the margin carries.
fn grid_lines(found: &FromRest, grid: &Grid) -> Vec<String> {
    let least = |of: fn(&GridPoint) -> f64| grid.points.iter().map(of).fold(f64::INFINITY, f64::min);
    let most = |of: fn(&GridPoint) -> f64| grid.points.iter().map(of).fold(0.0, f64::max);
    let reach = least(|p| p.reach);
    let mut line = format!(
        "margin for shorter loops: {} loops have a margin of at least {} at {}; directions change by at most {} for shorter loops",
        grid.loops.len(),
        readable(least(|p| p.margin)),
        counted(grid.points.len(), "point", "points"),
        readable(most(|p| p.variation))
    );
    if reach == 0.0 {
        line += ", more than the margin: the return below shows what is reached";
    } else if reach.is_finite() {
        let within =
            found.moving.iter().map(|&c| format!("{} ± {}", found.coordinates[c].name, short(reach * found.sizes[c])));
        line = format!("{line}, and stay positively spanning within {}", within.collect::<Vec<_>>().join(", "));
    } else {
        line += ", and do not depend on the position";
    }
    let mut lines = vec![line];
    if grid.points.len() > 1 {
        let covered = if grid.is_covered() { "covers" } else { "does not cover" };
        lines.push(format!("  this {covered} the bounds of the coordinates between the points of the grid"));
    }
    lines
}

/// Three significant digits.
pub(super) fn short(x: f64) -> String {
    readable(format!("{x:.2e}").parse().unwrap_or(x))
}
