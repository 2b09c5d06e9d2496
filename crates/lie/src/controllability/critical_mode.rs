//! Feedback at an equilibrium with uncontrollable modes on the imaginary axis, or in the plane.

use std::cmp::Ordering;

use bracketry_symbolic::{Expr, FieldElement, Function, OrderedField, Pool, Rational, Real, Symbol};

use crate::algebra::combination::{real_combination, symbols};
use crate::algebra::rational::readable::tidy;
use crate::controllability::descent::Curve;
use crate::controllability::linearization::exact_matrices;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::monotone::candidates;
use crate::controllability::region::solved;
use crate::controllability::slow_equilibria::{SLOW_DEGREE, SlowEquilibria};
use crate::evidence::Evidence;
use crate::feedback::center_pair::CenterPair;
use crate::linear::matrix::quotient_by_reachable;
use crate::linear::polynomial::{RealPolynomial, unit};
use crate::linear::spectrum::Spectrum;
use crate::linear::taylor::Terms;
use crate::reason::{MinimumPhaseReason, StabilizableReason};
use crate::undecided::Undecided;

/// Degree of the expansions with one input and with more; most states and inputs.
const DEGREE: [u32; 2] = [7, 5];
const MAX_STATES: usize = 8;
const MAX_INPUTS: usize = 3;

/// Feedback that stabilizes through the critical modes: one or several with the eigenvalue 0, or an oscillating pair ±iω, while the
/// others decay or are controllable.
pub(crate) fn by_critical_modes(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Option<StabilizableReason> {
    let (n, m) = (frame.fields.states.len(), frame.fields.controls.len());
    if n > MAX_STATES || m == 0 || m > MAX_INPUTS {
        return None;
    }
    let (a, b) = exact_matrices(pool, frame, evidence)?;
    let spectrum = Spectrum::of_reals(&quotient_by_reachable(&a, &b))?;
    let oscillates = spectrum.roots.iter().any(|r| r.re == 0.0 && r.im != 0.0);
    match (spectrum.on_axis, spectrum.right) {
        (1, 0) => by_slow_mode(pool, frame, evidence),
        (2, 0) if oscillates => {
            let field = expanded(pool, frame, 3, evidence)?;
            let attracts = CenterPair::of(&field, m)?.attracts_by_feedback()?;
            attracts.then_some(StabilizableReason::OscillatingPair)
        }
        (on_axis, 0) if on_axis > 1 => {
            let field = expanded(pool, frame, SLOW_DEGREE, evidence)?;
            let found = SlowEquilibria::of(&field, m, SLOW_DEGREE)?;
            if found.modes.len() != on_axis || !found.attract(m) {
                return None;
            }
            let functions = found.modes.iter().map(|w| mode_function(pool, frame, w)).collect::<Option<_>>()?;
            Some(StabilizableReason::CriticalModes { functions })
        }
        _ => None,
    }
}

/// Feedback that stabilizes through one mode s on the imaginary axis, whose eigenvalue is 0, while the other modes decay or are
/// controllable.
///
/// With the parameters v of [`SlowEquilibria`] as functions φ(s) with a Lipschitz constant and s β(s, φ(s)) < 0 for s ≠ 0, the
/// feedback u = U(s, φ(s)) + K (x − X(s, φ(s))) stabilizes, where K stabilizes the modes that inputs reach. Proof. For
/// z = x − X, which is in the kernel of w, z' = H z + O(|β|) + O((|s| + |z|)|z|) with a Hurwitz H, and
/// s' = β + O((|s| + |z|)|z|). With a norm of z for which e^(H t) contracts, |s| + μ |z| decays for small μ > 0, near 0.
fn by_slow_mode(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Option<StabilizableReason> {
    let m = frame.fields.controls.len();
    let degree = DEGREE[usize::from(m > 1)];
    let field = expanded(pool, frame, degree, evidence)?;
    let found = SlowEquilibria::of(&field, m, degree)?;
    let ([mode], [rate]) = (&found.modes[..], &found.rates[..]) else { return None };
    let curves = [1, -1].map(|sign| Curve::of(rate, sign, degree, &Rational::ONE));
    let [Some(above), Some(below)] = curves else { return None };
    let function = mode_function(pool, frame, mode)?;
    Some(StabilizableReason::CriticalMode { function, orders: [above.order, below.order] })
}

/// Why one mode with the eigenvalue 0, or a pair ±iω, does not attract, where the dynamics of the uncontrollable modes do not depend on the
/// inputs and the other ones decay: they are those on the center manifold for any feedback that stabilizes what inputs reach.
pub(crate) fn critical_modes_do_not_attract(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Option<MinimumPhaseReason> {
    let (n, m) = (frame.fields.states.len(), frame.fields.controls.len());
    if n > MAX_STATES || m == 0 || m > MAX_INPUTS {
        return None;
    }
    let (a, b) = exact_matrices(pool, frame, evidence)?;
    let spectrum = Spectrum::of_reals(&quotient_by_reachable(&a, &b))?;
    let degree = DEGREE[1];
    let (on_axis, right) = (spectrum.on_axis, spectrum.right);
    let field = if right == 0 && on_axis <= 2 { expanded(pool, frame, degree, evidence)? } else { return None };
    if on_axis == 2 {
        let (order, l) = CenterPair::of(&field, m)?.focal_value(degree)?;
        return l.is_positive().then_some(MinimumPhaseReason::FocalValue { order, falls: false });
    }
    // With X(s, v), U(s, v) of `SlowEquilibria` at v = 0: the manifold, and the rate, are right up to O(|s β|).
    let found = SlowEquilibria::of(&field, m, degree)?;
    let [rate] = &found.rates[..] else { return None };
    let order = rate.order();
    let c = rate.coefficient(&unit(1 + m, 0).iter().map(|k| k * order).collect::<Vec<_>>());
    let falls = c.sign()? == Ordering::Less;
    if c.is_zero() || falls && order % 2 == 1 {
        return None;
    }
    Some(MinimumPhaseReason::CenterManifold { order: order as usize, falls })
}

/// The mode w·x; `None` where its coefficients are too long to be shown.
fn mode_function(pool: &mut Pool, frame: &Frame, w: &[Real]) -> Option<Function> {
    let states = symbols(pool, &frame.fields.states);
    let mode = real_combination(pool, &states, w)?;
    let mode = pool.simplify(mode);
    Some(Function::new(pool, mode))
}

/// Continuous feedback in the plane with one input that moves the state at the point: with a function y that it does not influence,
/// x' = u, y' = h(x, y) after feedback, which continuous feedback stabilizes if and only if h takes negative values where y > 0 and
/// positive ones where y < 0, arbitrarily near the point (Dayawansa, Martin, and Knowles 1990).
pub(crate) fn in_the_plane(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Result<Option<StabilizableReason>, Undecided> {
    let fields = &frame.fields;
    let (variables, offsets) = frame.deviations(pool);
    for function in candidates(pool, frame, &fields.controls, evidence)? {
        let at_point = frame.value_at_point(pool, function);
        let above = pool.sub(function, at_point);
        let above = pool.substitute(above, &offsets);
        // A coordinate at the point: analytic there, with a gradient. x + log(y) at y = 0 is none.
        let is_coordinate = polynomial(pool, frame, above, &variables, evidence)
            .is_some_and(|p| p.terms().any(|(m, _)| m.iter().sum::<u32>() == 1));
        if !is_coordinate {
            continue;
        }
        let Some((y, map)) = solved(pool, above, &variables, |_, y| y) else { continue };
        let rate = pool.lie_derivative(function, &fields.states, &fields.drift);
        let rate = tidy(pool, rate);
        let rate = pool.substitute(rate, &offsets);
        let rate = pool.substitute(rate, &map);
        let order: Vec<Symbol> = std::iter::once(y).chain(variables.iter().copied().filter(|s| *s != y)).collect();
        let Some(rate) = polynomial(pool, frame, rate, &order, evidence) else { continue };
        let curve = |sign| Curve::of(&rate, sign, DEGREE[0], &Rational::ZERO);
        if curve(1).is_some() && curve(-1).is_some() {
            let function = Function::new(pool, function);
            return Ok(Some(StabilizableReason::PlanarSigns { function }));
        }
    }
    Ok(None)
}

/// f + Σ u_i g_i in deviations from the point and of the inputs, up to a degree.
fn expanded(pool: &mut Pool, frame: &Frame, degree: u32, evidence: &mut Evidence) -> Option<Vec<RealPolynomial>> {
    let (mut variables, offsets) = frame.deviations(pool);
    let (n, m) = (variables.len(), frame.fields.controls.len());
    variables.extend((0..m).map(|k| pool.symbol(&format!("offset {k}"))));
    let mut all = Vec::new();
    for (k, list) in std::iter::once(&frame.fields.drift).chain(&frame.fields.controls).enumerate() {
        let degree = if k == 0 { degree } else { degree - 1 };
        for &e in list {
            let e = pool.substitute(e, &offsets);
            all.push(terms(pool, frame, e, &variables, degree)?);
        }
    }
    let mut field = Terms::with_values(pool, &all, evidence)?;
    let controls = field.split_off(n);
    for (k, g) in controls.chunks(n).enumerate() {
        let input = RealPolynomial::term(Real::ONE, unit(n + m, n + k));
        for (f, g) in field.iter_mut().zip(g) {
            *f = f.plus(&g.times_up_to(&input, degree), &Real::ONE);
        }
    }
    Some(field)
}

/// A function of deviations from the point as a polynomial, or its Taylor polynomial.
fn polynomial(
    pool: &mut Pool,
    frame: &Frame,
    e: Expr,
    variables: &[Symbol],
    evidence: &mut Evidence,
) -> Option<RealPolynomial> {
    let terms = terms(pool, frame, e, variables, DEGREE[0])?;
    Terms::with_values(pool, &[terms], evidence)?.pop()
}

fn terms(pool: &mut Pool, frame: &Frame, e: Expr, variables: &[Symbol], degree: u32) -> Option<Terms> {
    let e = frame.constants_in(pool, e);
    Terms::of_or_taylor(pool, e, variables, degree as usize)
}
