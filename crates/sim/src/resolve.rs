//! The next modes of the switching functions that vanish together.

use crate::multipliers::Multipliers;
use crate::{Mode, StopReason, Switched};

/// The switching functions that vanish, with what is known of each.
#[derive(Debug, Clone, Default)]
pub(crate) struct ZeroSet {
    /// The switches.
    pub(crate) switches: Vec<usize>,
    /// For each, the sliding mode to try first: the side to which it passes or breaks loose.
    pub(crate) preferred: Vec<Mode>,
    /// For each, whether sticking is known to have ended.
    pub(crate) loose: Vec<bool>,
}

impl ZeroSet {
    pub(crate) fn clear(&mut self) {
        self.switches.clear();
        self.preferred.clear();
        self.loose.clear();
    }

    pub(crate) fn push(&mut self, switch: usize, preferred: Mode, loose: bool) {
        self.switches.push(switch);
        self.preferred.push(preferred);
        self.loose.push(loose);
    }
}

/// Finds consistent modes for the zero set at `(t, x)` and writes them into `modes`; the other modes stay.
///
/// All `3^|Z|` combinations are tried, those with most sticking switches first, then those which agree with the
/// direction of motion; first with switches that truly leave (`σ̇ ≠ 0`), then with those which leave tangentially. Modes in `failed` have been
/// tried at this instant and could not be kept.
pub(crate) fn resolve(
    system: &mut impl Switched,
    multipliers: &mut Multipliers,
    point: (f64, &[f64]),
    (zero, failed): (&ZeroSet, &[Vec<Mode>]),
    limit: usize,
    modes: &mut [Mode],
    dx: &mut [f64],
) -> Result<(), StopReason> {
    let z = zero.switches.len();
    if z == 0 {
        multipliers.set_modes(modes);
        return Ok(());
    }
    if z > limit {
        return active_set(system, multipliers, point, zero, limit, modes, dx);
    }
    let mut order: Vec<(u32, u32, u32)> = (0..3u32.pow(z as u32))
        .map(|code| {
            let digits = (0..z as u32).map(|a| code / 3u32.pow(a) % 3);
            let (sliding, turned) = digits.fold((0, 0), |(n, m), d| (n + u32::from(d > 0), m + u32::from(d == 2)));
            (sliding, turned, code)
        })
        .collect();
    order.sort_unstable();
    // A switch known to be loose sticks again only if nothing else is consistent.
    for (strict, restick) in [(true, false), (false, false), (true, true), (false, true)] {
        for &(_, _, code) in &order {
            let mut rest = code;
            let mut allowed = true;
            for (a, &i) in zero.switches.iter().enumerate() {
                modes[i] = match rest % 3 {
                    0 => Mode::Sticking,
                    1 => zero.preferred[a],
                    _ => zero.preferred[a].opposite(),
                };
                allowed &= rest % 3 != 2 || modes[i] != zero.preferred[a];
                if modes[i] == Mode::Sticking {
                    allowed &= system.sticks(i) && (restick || !zero.loose[a]);
                }
                rest /= 3;
            }
            allowed &= !failed.iter().any(|f| f == modes);
            if allowed && multipliers.consistent(system, point, modes, &zero.switches, strict, dx) {
                return Ok(());
            }
        }
    }
    Err(StopReason::NoConsistentMode { switches: zero.switches.clone() })
}

/// For zero sets too large to enumerate: starts with all sticking, lets go what needs more than the full sign, and
/// holds what would slide against its own direction.
fn active_set(
    system: &mut impl Switched,
    multipliers: &mut Multipliers,
    point: (f64, &[f64]),
    zero: &ZeroSet,
    limit: usize,
    modes: &mut [Mode],
    dx: &mut [f64],
) -> Result<(), StopReason> {
    let z = zero.switches.len();
    for (a, &i) in zero.switches.iter().enumerate() {
        modes[i] = if zero.loose[a] || !system.sticks(i) { zero.preferred[a] } else { Mode::Sticking };
    }
    for _ in 0..=2 * z {
        if multipliers.consistent(system, point, modes, &zero.switches, false, dx) {
            return Ok(());
        }
        let mut changed = false;
        for &i in &zero.switches {
            let next = match modes[i] {
                Mode::Sticking if multipliers.reserve(i, multipliers.size(i)) < 0.0 => multipliers.sliding_mode(i),
                Mode::Sliding if multipliers.radial_rate(i, dx) < 0.0 => Mode::Sticking,
                sliding if sliding.sign() * multipliers.rate(multipliers.parts[i].start, dx) < 0.0 => {
                    if system.sticks(i) { Mode::Sticking } else { sliding.opposite() }
                }
                same => same,
            };
            changed |= next != modes[i];
            modes[i] = next;
        }
        if !changed {
            break;
        }
    }
    Err(StopReason::TooManySimultaneous { count: z, limit })
}
