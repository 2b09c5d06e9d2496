//! The next modes of the switching functions that vanish together.

use super::departure::depart;
use super::dependence::Span;
use super::filippov::Field;
use super::modes::FrictionMode;
use super::zero_set::ZeroSet;
use crate::outcome::StopReason;

/// Finds consistent modes for the zero set at `(t, x)`; the other modes stay.
///
/// All `3^|Z|` combinations are tried, those with most sticking switches first, then those which agree with the
/// direction of motion; first with switches that truly leave (`σ̇ ≠ 0`), then with those which leave tangentially. Where the
/// functions of the set depend on each other, a switch sticks if what sticks leaves its function no freedom. Modes in `failed`
/// have been tried at this instant and could not be kept. Of more than `limit` switches an active set is sought.
pub(crate) fn resolve(
    field: &mut Field<'_>,
    point: (f64, &[f64]),
    zero: &ZeroSet,
    failed: &[Vec<FrictionMode>],
    limit: usize,
) -> Result<(), StopReason> {
    let z = zero.entries.len();
    if z == 0 {
        field.apply_modes();
        return Ok(());
    }
    let mut dx = vec![0.0; point.1.len()];
    let mut dependence = Dependence::of(field, point, zero);
    if z > limit {
        return active_set(field, point, (zero, &mut dependence), limit, &mut dx);
    }
    let mut order: Vec<(u32, u32, u32)> = (0..3u32.pow(z as u32))
        .map(|code| {
            let digits = (0..z as u32).map(|a| code / 3u32.pow(a) % 3);
            let (sliding, opposite) = digits.fold((0, 0), |(n, m), d| (n + u32::from(d > 0), m + u32::from(d == 2)));
            (sliding, opposite, code)
        })
        .collect();
    order.sort_unstable();
    // A switch known to be loose sticks again only if nothing else is consistent.
    for (strict, restick) in [(true, false), (false, false), (true, true), (false, true)] {
        for &(_, _, code) in &order {
            let mut remaining = code;
            let mut allowed = true;
            for entry in &zero.entries {
                let mode = match remaining % 3 {
                    0 => FrictionMode::Sticking,
                    1 => entry.preferred,
                    _ => entry.preferred.opposite(),
                };
                allowed &= remaining % 3 != 2 || mode != entry.preferred;
                if mode == FrictionMode::Sticking {
                    allowed &= field.system.sticks(entry.switch) && (restick || !entry.loose);
                }
                field.modes[entry.switch] = mode;
                remaining /= 3;
            }
            allowed &= !failed.contains(&field.modes);
            if allowed && dependence.permits(field, point, zero) && is_consistent(field, point, zero, strict, &mut dx) {
                return Ok(());
            }
        }
    }
    Err(StopReason::NoConsistentMode { switches: zero.switches() })
}

/// What switches that depend on each other may do together: the rates of those that stick determine those of others.
struct Dependence {
    /// Whether any do.
    exists: bool,
    span: Span,
}

impl Dependence {
    fn of(field: &mut Field<'_>, (t, x): (f64, &[f64]), zero: &ZeroSet) -> Self {
        let mut span = Span::default();
        if zero.entries.len() == 1 {
            return Self { exists: false, span };
        }
        field.surfaces.differentiate(&mut field.system, t, x);
        let surfaces = &field.surfaces;
        let mut components = zero.entries.iter().flat_map(|entry| surfaces.parts[entry.switch].clone());
        let exists = !components.all(|c| span.add(surfaces, c));
        Self { exists, span }
    }

    /// Whether everything that stays on its surface, because of what sticks, sticks itself.
    fn permits(&mut self, field: &mut Field<'_>, (t, x): (f64, &[f64]), zero: &ZeroSet) -> bool {
        if !self.exists {
            return true;
        }
        field.surfaces.differentiate(&mut field.system, t, x);
        let surfaces = &field.surfaces;
        self.span.clear();
        let switches = || zero.entries.iter().map(|entry| entry.switch);
        for i in switches().filter(|&i| field.modes[i] == FrictionMode::Sticking) {
            surfaces.parts[i].clone().for_each(|c| _ = self.span.add(surfaces, c));
        }
        let mut sliding = switches().filter(|&i| field.modes[i] != FrictionMode::Sticking && field.system.sticks(i));
        !sliding.any(|i| self.span.contains_switch(surfaces, i))
    }
}

/// For zero sets too large to enumerate: starts with all sticking, lets go what needs more than the full sign, and
/// holds what would slide against its own direction.
fn active_set(
    field: &mut Field<'_>,
    point: (f64, &[f64]),
    (zero, dependence): (&ZeroSet, &mut Dependence),
    limit: usize,
    dx: &mut [f64],
) -> Result<(), StopReason> {
    let z = zero.entries.len();
    for entry in &zero.entries {
        let slides = entry.loose || !field.system.sticks(entry.switch);
        field.modes[entry.switch] = if slides { entry.preferred } else { FrictionMode::Sticking };
    }
    for _ in 0..=2 * z {
        if is_consistent(field, point, zero, false, dx) && dependence.permits(field, point, zero) {
            return Ok(());
        }
        let mut changed = false;
        for i in zero.entries.iter().map(|entry| entry.switch) {
            let rate = |c: usize| field.surfaces.rate(c, dx);
            let next = match field.modes[i] {
                FrictionMode::Sticking if field.is_overloaded(i) => field.sliding_mode(i),
                FrictionMode::Sliding if field.radial_rate(i, dx) < 0.0 => FrictionMode::Sticking,
                sliding if sliding.sign() * rate(field.surfaces.parts[i].start) < 0.0 => {
                    if field.system.sticks(i) {
                        FrictionMode::Sticking
                    } else {
                        sliding.opposite()
                    }
                }
                same => same,
            };
            changed |= next != field.modes[i];
            field.modes[i] = next;
        }
        if !changed {
            break;
        }
    }
    Err(StopReason::TooManySimultaneous { count: z, limit })
}

/// Solves at a point for the present modes and tells whether they are consistent there: sticking signs within
/// `[−1, 1]` and directions in the unit ball, sliding switches of the zero set moving off to their own side
/// (`strict`) or not to the other.
fn is_consistent(field: &mut Field<'_>, (t, x): (f64, &[f64]), zero: &ZeroSet, strict: bool, dx: &mut [f64]) -> bool {
    field.apply_modes();
    let switches = zero.entries.iter().map(|entry| entry.switch);
    let leaving: Vec<usize> = switches.clone().filter(|&i| field.modes[i] == FrictionMode::Sliding).collect();
    field.hold_directions(leaving.iter().copied());
    let solved = if leaving.is_empty() { field.evaluate((t, x), dx) } else { depart(field, (t, x), &leaving, dx) };
    field.release_directions();
    if !solved {
        return false;
    }
    if field.forces.sticking.is_empty() {
        field.surfaces.differentiate(&mut field.system, t, x);
    }
    // What hangs on a sticking switch has the rounding of its force as rate.
    let rounding = 1e-12 * field.forces.largest_influence();
    let surfaces = &field.surfaces;
    switches.into_iter().all(|i| {
        let part = surfaces.parts[i].clone();
        let slack = || {
            let (rates, spread) = part.clone().fold((0.0f64, 0.0f64), |(r, s), c| {
                (r.max(surfaces.rate_scale(c, dx)), s.max(surfaces.spread(c, rounding)))
            });
            1e-9 * rates + spread
        };
        let away = match field.modes[i] {
            FrictionMode::Sticking => return !field.is_overloaded(i),
            FrictionMode::Sliding => field.radial_rate(i, dx),
            sliding => sliding.sign() * surfaces.rate(part.start, dx),
        };
        if strict { away > 0.0 } else { away >= -slack() }
    })
}
