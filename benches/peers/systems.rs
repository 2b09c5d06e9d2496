//! The systems that are compared.

use bracketry::lie::VectorFields;
use bracketry::symbolic::{Bindings, Pool};

fn field(pool: &mut Pool, components: &[String]) -> Vec<bracketry::symbolic::Expr> {
    components.iter().map(|c| pool.parse(c).expect("an expression")).collect()
}

fn text(components: &[&str]) -> Vec<String> {
    components.iter().map(|c| (*c).to_owned()).collect()
}

/// The published plate, an ellipse, with double integrators on X and theta: while vx, vy > 0, or with
/// tanh(100 v) for the sign of v.
pub(crate) fn plate(pool: &mut Pool, smooth: bool) -> VectorFields {
    let states = ["x", "y", "phi", "vx", "vy", "w", "X", "Xd", "theta", "thetad"].map(|s| pool.symbol(s)).to_vec();
    let (sx, sy) = if smooth { ("tanh(100*vx)", "tanh(100*vy)") } else { ("1", "1") };
    let mut drift = text(&["vx", "vy", "w", "", "", "0", "Xd", "0", "thetad", "0"]);
    drift[3] = format!("-{sx}*0.3*9.81");
    drift[4] = format!("-9.81*sin(theta) - {sy}*0.3*9.81*cos(theta)");
    let slide = text(&["0", "0", "0", "-1", "0", "0", "0", "1", "0", "0"]);
    let mut tilt = text(&["0", "0", "0", "0", "", "", "0", "0", "0", "1"]);
    tilt[4] = format!("-{sy}*0.3*y");
    tilt[5] = format!("-{sx}*0.3*(sin(phi)^2*0.15^2/4 + cos(phi)^2*0.1^2/4)/(0.15^2/4 + 0.1^2/4)");
    let drift = field(pool, &drift);
    let controls = vec![field(pool, &slide), field(pool, &tilt)];
    VectorFields::new(states, drift, controls, Bindings::new()).expect("fields of one length")
}

/// A car that turns on the spot with n trailers, the i-th at the distance i + 1.
pub(crate) fn trailers(pool: &mut Pool, n: usize) -> VectorFields {
    let mut names = text(&["x", "y"]);
    names.extend((0..=n).map(|i| format!("t{i}")));
    let states = names.iter().map(|s| pool.symbol(s)).collect();
    let mut speed = "1".to_owned();
    let mut rates = text(&["0"]);
    for i in 1..=n {
        rates.push(format!("{speed}*sin(t{} - t{i})/{}", i - 1, i + 1));
        speed = format!("{speed}*cos(t{} - t{i})", i - 1);
    }
    let mut drive = vec![format!("{speed}*cos(t{n})"), format!("{speed}*sin(t{n})")];
    drive.extend(rates);
    let mut turn = vec!["0".to_owned(); n + 3];
    "1".clone_into(&mut turn[2]);
    let controls = vec![field(pool, &drive), field(pool, &turn)];
    let drift = vec![pool.int(0); n + 3];
    VectorFields::new(states, drift, controls, Bindings::new()).expect("fields of one length")
}
