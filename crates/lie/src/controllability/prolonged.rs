//! Local controllability with integrals of free inputs in place of the inputs.

use bracketry_symbolic::{Func, Node, Pool, Undecided as Exact};

use crate::algebra::field::VectorFields;
use crate::algebra::span::vanishes;
use crate::controllability::input_values::Side;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::search::general;
use crate::controllability::stlc::{Stlc, Verdict};
use crate::error::Error;
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;
use crate::undecided::Undecided;

/// Most integrators in front of an input, most choices of them that are tried, and most states with them.
const MAX_INTEGRATORS: usize = 3;
const MAX_CHOICES: usize = 8;
const MAX_STATES: usize = 10;
/// Longest bracket and most new nodes of one choice.
const LIMITS: (usize, usize) = (9, 20_000);

/// Small-time local controllability from that of a system with integrators in front of inputs.
///
/// If the system with states x and w, in which w_1 (w_1' = w_2, …, w_d' = ω) stands in the place of an input, and the square
/// ±w_1² in that of an input that moves from its value at the point to one side only, is STLC at (x0, 0) with bounded ω, so is
/// the given system at x0: its trajectories from (x0, 0) are trajectories of the given system with small inputs that are
/// allowed, and a neighborhood of (x0, 0) projects to one of x0. Integrators bring forms of chains of different depths to one
/// weight, where they cancel (compare Bianchini and Stefani 1993). `None` where no choice of integrators shows it.
pub(crate) fn with_integrators(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Option<Stlc>, Undecided> {
    let n = frame.fields.states.len();
    let limits = Limits { length: limits.length.min(LIMITS.0), nodes: limits.nodes.min(LIMITS.1), ..*limits };
    for counts in choices(sides) {
        if n + counts.iter().sum::<usize>() > MAX_STATES {
            continue;
        }
        let Ok(longer) = prolonged(pool, frame, sides, &counts) else { return Ok(None) };
        let stlc = match general(pool, &longer, &limits, evidence) {
            Ok(stlc) => stlc,
            Err(why @ Undecided::Exact(Exact::Stopped)) => return Err(why),
            Err(_) => continue,
        };
        if stlc.verdict == Verdict::Yes {
            let squared = sides.iter().map(Option::is_some).collect();
            let reason = StlcReason::Integrals { reason: Box::new(stlc.reason), integrators: counts, squared };
            return Ok(Some(Stlc { weights: None, weights_tried: Vec::new(), reason, ..stlc }));
        }
    }
    Ok(None)
}

/// Numbers of integrators, few first: at least one for each one-sided input, and for some but not for all free ones.
fn choices(sides: &[Option<Side>]) -> Vec<Vec<usize>> {
    let one_sided = sides.iter().any(Option::is_some);
    let mut all: Vec<Vec<usize>> = Vec::new();
    for total in 1..=sides.len() * MAX_INTEGRATORS {
        let mut lists = vec![(Vec::new(), total)];
        for (i, side) in sides.iter().enumerate() {
            let (least, last) = (usize::from(side.is_some()), i + 1 == sides.len());
            let longer = |(list, rest): (Vec<usize>, usize)| {
                let from = if last { rest.max(least) } else { least };
                (from..=rest.min(MAX_INTEGRATORS)).map(move |k| {
                    let mut list = list.clone();
                    list.push(k);
                    (list, rest - k)
                })
            };
            lists = lists.into_iter().flat_map(longer).collect();
        }
        let fits = |c: &Vec<usize>| one_sided || c.contains(&0);
        all.extend(lists.into_iter().map(|l| l.0).filter(fits));
        if all.len() >= MAX_CHOICES {
            break;
        }
    }
    all.truncate(MAX_CHOICES);
    all
}

/// The system with these numbers of integrators, at the point.
fn prolonged(pool: &mut Pool, frame: &Frame, sides: &[Option<Side>], counts: &[usize]) -> Result<Frame, Error> {
    let (zero, one) = (pool.int(0), pool.int(1));
    let (mut states, mut point) = (frame.fields.states.clone(), frame.point().to_vec());
    let mut drift = frame.fields.drift.clone();
    let mut controls = frame.fields.controls.clone();
    for (i, (&count, side)) in counts.iter().zip(sides).enumerate() {
        for k in 0..count {
            let state = pool.symbol(&format!("integral {k} in place of input {i}"));
            let w = pool.sym(state);
            // The first takes the place of the input.
            let factor = match side {
                Some(side) if k == 0 => {
                    let (square, sign) = (pool.mul(w, w), pool.int(side.sign()));
                    pool.mul(sign, square)
                }
                _ => w,
            };
            let g = std::mem::take(&mut controls[i]);
            for (f, &h) in drift.iter_mut().zip(&g) {
                let term = pool.mul(factor, h);
                *f = pool.add(*f, term);
            }
            states.push(state);
            point.push(zero);
            drift.push(zero);
            let n = states.len();
            controls[i] = vec![zero; n];
            controls[i][n - 1] = one;
            for field in &mut controls {
                field.resize(n, zero);
            }
        }
    }
    let zeros = vec![zero; controls.len()];
    let fields = VectorFields::new(states, drift, controls, frame.fields.bindings.clone())?;
    Frame::new(pool, &fields, &point, &zeros)
}

/// Whether f is odd and every g_i even about the point, both smooth. Brackets of f and an even number of g_i vanish there,
/// so that no bad bracket is left (Brunovský 1974; Sussmann 1987).
pub(crate) fn is_odd(pool: &mut Pool, frame: &Frame) -> bool {
    let fields = &frame.fields;
    let mut all = fields.drift.clone();
    all.extend(fields.controls.iter().flatten());
    let kink = |n: Node| matches!(n, Node::Call(Func::Abs | Func::Sign, _) | Node::Call2(..));
    if pool.reachable(&all).into_iter().any(|n| kink(pool.node(n))) {
        return false;
    }
    let (variables, offsets) = frame.deviations(pool);
    let mut opposite = offsets.clone();
    for ((&s, &x0), &y) in fields.states.iter().zip(frame.point()).zip(&variables) {
        let y = pool.sym(y);
        let moved = pool.sub(x0, y);
        opposite.insert(pool.sym(s), moved);
    }
    let there = pool.substitute_all(&all, &offsets);
    let across = pool.substitute_all(&all, &opposite);
    there.into_iter().zip(across).enumerate().all(|(k, (a, b))| {
        let e = if k < fields.states.len() { pool.add(a, b) } else { pool.sub(a, b) };
        vanishes(pool, e, &fields.bindings)
    })
}

#[cfg(test)]
mod tests {
    use super::{MAX_CHOICES, choices};
    use crate::controllability::input_values::Side;

    #[test]
    fn one_sided_inputs_have_integrators() {
        assert_eq!(choices(&[None, Some(Side::Above)])[..3], [vec![0, 1], vec![0, 2], vec![1, 1]]);
        assert_eq!(choices(&[None, None])[..2], [vec![0, 1], vec![1, 0]]);
        assert!(choices(&[None]).is_empty());
        assert!(choices(&[None; 9]).len() <= MAX_CHOICES);
        assert!(choices(&[Some(Side::Below); 3]).iter().all(|c| !c.contains(&0)));
    }
}
