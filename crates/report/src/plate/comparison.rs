//! How a run agrees with a log, in words.

use std::fmt::{self, Write as _};

use bracketry_plate::experiment::Coordinate;
use bracketry_plate::run::{
    Comparison, ErrorsAtStart, OppositeSigns, PoseDeviations, ScaledInput, SignComparison, SignSource,
};

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Differences between two runs (mm, degrees) below this are not worth a word.
const SMALLEST: f64 = 0.005;

/// The paragraph on a comparison.
pub(super) fn write_comparison(out: &mut String, c: &Comparison) -> fmt::Result {
    let whole = &c.whole;
    let (from, to) = (whole.from, whole.to);
    writeln!(out, "  compared    with {} from {from} to {to} s, {} rows (run − log):", c.log, whole.rows)?;
    let percent = whole.phi_percent.map_or(String::new(), |p| format!(" ({p:+.2} % of the rotation)"));
    for (name, unit, d, note) in
        [("x", "mm", &whole.x_mm, ""), ("y", "mm", &whole.y_mm, ""), ("φ", "°", &whole.phi_deg, percent.as_str())]
    {
        writeln!(
            out,
            "    {name}  rms {:.3} {unit}, largest {:+.3} {unit}, at the end {:+.3} {unit}{note}",
            d.rms, d.largest, d.at_end
        )?;
    }
    c.signs.as_ref().map_or(Ok(()), |s| signs(out, s))
}

fn signs(out: &mut String, s: &SignComparison) -> fmt::Result {
    let (unit, scale) = if s.coordinate == Coordinate::Phi { ("°", DEGREES) } else { (" mm", 1e3) };
    let size = |value: f64| format!("{}{unit}", three_digits(scale * value));
    let signed = |value: f64| format!("{:+}{unit}", three_digits(scale * value));
    let errors = |e: &ErrorsAtStart| format!("{} in the run, {} in the log", signed(e.run_error), signed(e.log_error));
    let input = match s.input {
        ScaledInput::X => "X",
        ScaledInput::Theta => "θ",
    };
    let name = match s.coordinate {
        Coordinate::X => "x",
        Coordinate::Y => "y",
        Coordinate::Phi => "φ",
    };
    let given = if s.noise_given { "given" } else { "estimated" };
    let noise = format!("noise of the log {} ({given})", size(s.noise));
    if let Some(first) = s.close.first() {
        let count = format!("{} of {} period starts", s.close.len(), s.starts);
        writeln!(
            out,
            "  signs       agree at {count} where noise or the difference of run and log could reverse them,"
        )?;
        writeln!(out, "    first at t = {:.3} s: error in {name} {}; {noise}", first.t, errors(first))?;
    }
    let Some(o) = &s.opposite else { return Ok(()) };
    let verdict = if o.is_chance() { "undecided" } else { "contradicted" };
    writeln!(
        out,
        "  signs       {verdict} from t = {:.3} s on: opposite signs of the amplitude of {input}",
        o.errors.t
    )?;
    writeln!(out, "    error in {name} then: {}; {noise}", errors(&o.errors))?;
    writeln!(out, "    {}", source(o.sign_of_log))?;
    let explained = format!("than the {} that noise and the previous deviation explain", size(o.explained));
    if o.is_chance() {
        writeln!(out, "    the errors differ by less {explained}: only the comparison before this time counts")?;
    } else {
        writeln!(out, "    the errors differ by more {explained}: the model moves the object differently")?;
    }
    let mut line = |label: &str, d: Option<&PoseDeviations>| match d {
        Some(d) => writeln!(
            out,
            "    {label:<32} x rms {:.3} mm, y rms {:.3} mm, φ rms {:.3}°",
            d.x_mm.rms, d.y_mm.rms, d.phi_deg.rms
        ),
        None => writeln!(out, "    {label:<32} no common time"),
    };
    line("before", o.before.as_ref())?;
    line("after", o.after.as_ref())?;
    line("after, with the signs of the log", o.after_with_signs_of_log.as_ref())?;
    let times: Vec<String> = o.given_signs.iter().map(|t| format!("{t:.3}")).collect();
    writeln!(out, "    {:<32} {} s", "signs taken from the log at", times.join(", "))?;
    writeln!(out, "    {:<32} {}", "affected by the sign", depending(o))
}

fn source(sign: SignSource) -> &'static str {
    match sign {
        SignSource::Run => "the log does not show its sign",
        SignSource::LoggedPlate => "the sign of the log is that of its plate motion",
        SignSource::LoggedError => "the sign of the log is that of its error",
        SignSource::LoggedMotion => "the sign of the log is the one for which the object would move as logged",
    }
}

/// The coordinates in which runs with either sign differ.
fn depending(o: &OppositeSigns) -> String {
    let d = &o.depending;
    let parts: Vec<String> = [("x", " mm", d.x_mm), ("y", " mm", d.y_mm), ("φ", "°", d.phi_deg)]
        .into_iter()
        .filter(|(_, _, d)| d.rms >= SMALLEST)
        .map(|(name, unit, d)| format!("{name} by {:.3}{unit} rms, up to {:.3}{unit}", d.rms, d.largest.abs()))
        .collect();
    if parts.is_empty() { "nothing: both signs give the same motion".to_owned() } else { parts.join("; ") }
}

/// A number with three significant digits.
fn three_digits(v: f64) -> f64 {
    format!("{v:.2e}").parse().unwrap_or(v)
}
