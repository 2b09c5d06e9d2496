//! Loops of the inputs: from rest to rest, with constant highest derivatives in between.

use bracketry_sim::Hold;
use bracketry_symbolic::Symbol;
use serde::Serialize;

use super::bounds::Span;
use super::held::{Motion, Test, Where};
use super::model::{Channel, Law, RestModel};
use crate::signals::Signals;

/// Loops stay within this part of the bounds, so that corrections find room.
const ROOM: f64 = 0.999;
/// Length of the first piece of a loop that no bound limits, s.
const FIRST_PIECE: f64 = 0.1;
/// How far an input is shaken, as a part of its displacement, and how many times.
const SHAKEN: f64 = 1e-3;
const SHAKES: usize = 4;
/// A return is slower than the slowest one that moves anything by this factor.
const SLOW: f64 = 0.9;
/// The acceleration of the second input of a pair, as a part of its bound: what closes a loop may exceed it.
pub(crate) const CLOSING: f64 = 0.8;
/// The least acceleration of a return, as a part of its limit.
const LEAST_ACCELERATION: f64 = 1e-3;
/// Bisections of the acceleration of a return.
const BISECTIONS: usize = 20;

/// The shape of a loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "shape")]
pub enum Shape {
    /// The acceleration of an input is large first, then within what friction holds until the input is back.
    FastSlow {
        /// Acceleration of the first piece.
        fast: f64,
        /// Size of the acceleration on the way back.
        slow: f64,
    },
    /// An input goes to a value, stays there, and comes back.
    Lift {
        /// Difference of that value from the value at rest.
        peak: f64,
        /// Whether it is shaken a little while it stays there.
        shaken: bool,
    },
    /// The second input goes to a value; there the first one accelerates, and comes back when the second one is back.
    Carried {
        /// Difference of the second input from its value at rest.
        peak: f64,
        /// Acceleration of the first input.
        fast: f64,
        /// Size of its acceleration on the way back.
        slow: f64,
        /// Whether the second input is shaken a little meanwhile.
        shaken: bool,
    },
    /// Two inputs accelerate together, and come back one after the other.
    Diagonal {
        /// Their accelerations.
        fast: [f64; 2],
        /// Sizes of their accelerations on the way back.
        slow: [f64; 2],
    },
    /// Two inputs go off and back, together; a second time, with the opposite sign of the second input, if a velocity has no
    /// friction of its own.
    Together {
        /// Accelerations of the two inputs.
        accelerations: [f64; 2],
        /// Whether there is a second time.
        twice: bool,
    },
}

/// A loop of the inputs, from rest to rest.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub(crate) shape: Shape,
    /// The inputs that move.
    pub(crate) moved: Vec<usize>,
    /// Values of the highest derivatives, and how long they last, s.
    pub(crate) pieces: Vec<(Vec<f64>, f64)>,
    /// What brings a velocity without friction to rest.
    pub(crate) closing: Option<Closing>,
}

/// From one piece on, the values of an input are multiplied by a number near 1, so that a velocity without friction ends at zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closing {
    pub(crate) input: usize,
    pub(crate) from_piece: usize,
    /// Place of the velocity among the states.
    pub(crate) velocity: usize,
}

impl Loop {
    /// One input moves, the others rest.
    fn of_one(model: &RestModel, channel: usize, shape: Shape, pieces: &[(f64, f64)]) -> Self {
        let rest = rest_values(model);
        let row = |&(value, duration): &(f64, f64)| {
            let mut row = rest.clone();
            row[channel] += value;
            (row, duration)
        };
        Loop { shape, moved: vec![channel], pieces: pieces.iter().map(row).collect(), closing: None }
    }

    pub(crate) fn duration(&self) -> f64 {
        self.pieces.iter().map(|p| p.1).sum()
    }

    /// The loop with all durations times `scale`.
    pub(crate) fn scaled(&self, scale: f64) -> Self {
        let mut scaled = self.clone();
        scaled.pieces.iter_mut().for_each(|(_, duration)| *duration *= scale);
        scaled
    }

    /// The loop with all durations times `scale`, and a pause at the end.
    pub(crate) fn signals(&self, model: &RestModel, scale: f64, pause: f64) -> Signals {
        let (mut times, mut values, mut t) = (Vec::new(), Vec::new(), 0.0);
        for (row, duration) in &self.pieces {
            times.push(t);
            values.push(row.clone());
            t += scale * duration;
        }
        let rest = rest_values(model);
        times.extend([t, t + pause]);
        values.extend([rest.clone(), rest]);
        Signals { times, values, hold: Hold::Previous }
    }

    /// The loop with what closes it multiplied by a number.
    pub(crate) fn closed(&self, factor: f64) -> Self {
        let mut closed = self.clone();
        if let Some(c) = self.closing {
            for (row, _) in &mut closed.pieces[c.from_piece..] {
                row[c.input] *= factor;
            }
        }
        closed
    }

    /// The values that inputs and derivatives take along the loop, however short.
    pub(crate) fn spans(&self, model: &RestModel) -> Vec<Vec<Span>> {
        let of = |(j, channel): (usize, &Channel)| {
            if !self.moved.contains(&j) {
                return channel.at_home();
            }
            let order = channel.order();
            let mut state: Vec<f64> = (0..=order).map(|k| if k == 0 { channel.home.value } else { 0.0 }).collect();
            let mut ends: Vec<[f64; 2]> = state.iter().map(|&x| [x, x]).collect();
            for (row, duration) in &self.pieces {
                state[order] = row[j];
                // Extremes inside a piece of derivatives below the highest but one lie where the next one changes sign.
                let mut instants = vec![*duration];
                if order == 2 && row[j] != 0.0 {
                    instants.push((-state[1] / row[j]).clamp(0.0, *duration));
                }
                instants.push(0.0);
                for t in instants {
                    for (k, x) in advanced(&state, t).into_iter().enumerate() {
                        ends[k] = [ends[k][0].min(x), ends[k][1].max(x)];
                    }
                }
                state = advanced(&state, *duration);
            }
            // Rounding of the sums above.
            let slack = |x: f64| 1e-12 * x.abs().max(1e-3);
            let spans = ends.iter().enumerate().map(|(k, &[low, high])| {
                if k == order { Span::between(low, high) } else { Span::between(low - slack(low), high + slack(high)) }
            });
            spans.collect()
        };
        model.channels.iter().enumerate().map(of).collect()
    }
}

/// An input and its derivatives after a time with a constant highest derivative.
fn advanced(state: &[f64], t: f64) -> Vec<f64> {
    let series = |k: usize| {
        let mut factor = 1.0;
        let mut sum = 0.0;
        for (i, x) in state[k..].iter().enumerate() {
            sum += factor * x;
            factor *= t / (i + 1) as f64;
        }
        sum
    };
    (0..state.len()).map(series).collect()
}

/// What the inputs of the model with integrators are at rest.
pub(crate) fn rest_values(model: &RestModel) -> Vec<f64> {
    model.channels.iter().map(|c| if c.order() == 0 { c.home.value } else { 0.0 }).collect()
}

/// Loops of single inputs.
pub(crate) fn single(model: &RestModel, slow: &[Option<f64>]) -> Vec<Loop> {
    let mut list = Vec::new();
    for channel in 0..model.channels.len() {
        for up in [true, false] {
            list.extend(lift(model, channel, up, false));
            list.extend(lift(model, channel, up, true));
            list.extend(fast_slow(model, channel, up, slow[channel]));
        }
    }
    list
}

/// Loops of two inputs.
pub(crate) fn pairs(model: &RestModel, slow: &[Option<f64>]) -> Vec<Loop> {
    let driven: Vec<usize> =
        model.groups.iter().filter(|g| g.law == Law::Driven).flat_map(|g| g.velocities.clone()).collect();
    let mut list = Vec::new();
    for i in 0..model.channels.len() {
        for j in 0..model.channels.len() {
            if i == j || model.channels[i].order() != 2 || model.channels[j].order() != 2 || driven.len() > 1 {
                continue;
            }
            if i < j {
                let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
                list.extend(signs.iter().filter_map(|&(a, b)| diagonal(model, [i, j], [a, b], slow)));
            }
            let limit = |c: &Channel| room(c, 2, true).min(room(c, 2, false));
            let (first, second) = (limit(&model.channels[i]), CLOSING * limit(&model.channels[j]));
            for a in [Some(first), slow[i]].into_iter().flatten().filter(|a| *a > 0.0 && second > 0.0) {
                for sign in [1.0, -1.0] {
                    for (up, shaken) in [(true, false), (true, true), (false, false), (false, true)] {
                        list.extend(carried(model, [i, j], sign * a, slow[i], (up, shaken)));
                    }
                    list.push(together(model, [i, j], [a, sign * second], driven.first().copied()));
                }
            }
        }
    }
    list
}

/// Both inputs accelerate together; then the first one comes back while the second one coasts, then the second one.
fn diagonal(model: &RestModel, inputs: [usize; 2], signs: [f64; 2], slow: &[Option<f64>]) -> Option<Loop> {
    let slow = [slow[inputs[0]]?, slow[inputs[1]]?];
    let fast: [f64; 2] = std::array::from_fn(|k| signs[k] * room(&model.channels[inputs[k]], 2, signs[k] > 0.0));
    let rest = rest_values(model);
    let mut both = rest.clone();
    inputs.iter().zip(fast).for_each(|(&i, a)| both[i] += a);
    let t = FIRST_PIECE;
    let mut pieces = vec![(both, t)];
    let mut coasting = 0.0;
    for k in 0..2 {
        let channel = &model.channels[inputs[k]];
        let (a, b) = (fast[k].abs(), slow[k]);
        let (speed, brake) = (a * t, a * t / b);
        let far = 0.5 * speed * t + speed * coasting + 0.5 * speed * brake;
        let back = (far / b).sqrt();
        let up = fast[k] > 0.0;
        if speed > room(channel, 1, up) || far > room(channel, 0, up) || b * back > room(channel, 1, !up) {
            return None;
        }
        for (value, duration) in [(-fast[k].signum() * b, brake + back), (fast[k].signum() * b, back)] {
            let mut row = rest.clone();
            row[inputs[k]] += value;
            pieces.push((row, duration));
        }
        coasting = brake + 2.0 * back;
    }
    Some(Loop { shape: Shape::Diagonal { fast, slow }, moved: inputs.to_vec(), pieces, closing: None })
}

/// Input j goes off, input i accelerates there, and comes back when j is back.
fn carried(
    model: &RestModel,
    [i, j]: [usize; 2],
    fast: f64,
    slow: Option<f64>,
    (up, shaken): (bool, bool),
) -> Option<Loop> {
    let slow = slow?;
    let under = lift(model, j, up, shaken)?;
    let Shape::Lift { peak, .. } = under.shape else { return None };
    let mut pieces = under.pieces;
    // The pieces in the middle are those in which j stays, or is shaken.
    let there = if shaken { 3 * SHAKES } else { 1 };
    let first = (pieces.len() - there) / 2;
    let t: f64 = pieces[first..first + there].iter().map(|p| p.1).sum();
    pieces[first..first + there].iter_mut().for_each(|(row, _)| row[i] += fast);
    let after: f64 = pieces[first + there..].iter().map(|p| p.1).sum();
    let (speed, brake) = (fast * t, fast.abs() * t / slow);
    let far = (0.5 * fast * t * t + speed * after + 0.5 * speed * brake).abs();
    let back = (far / slow).sqrt();
    let rest = rest_values(model);
    for (value, duration) in [(-fast.signum() * slow, brake + back), (fast.signum() * slow, back)] {
        let mut row = rest.clone();
        row[i] += value;
        pieces.push((row, duration));
    }
    let channel = &model.channels[i];
    let fits = speed.abs() <= room(channel, 1, fast > 0.0)
        && far <= room(channel, 0, fast > 0.0)
        && slow * back <= room(channel, 1, fast < 0.0);
    let shape = Shape::Carried { peak, fast, slow, shaken };
    fits.then(|| Loop { shape, moved: vec![i, j], pieces, closing: None })
}

/// Both inputs have accelerations +, −, −, + of equal duration, as long as the bounds allow.
fn together(model: &RestModel, [i, j]: [usize; 2], [a, b]: [f64; 2], driven: Option<usize>) -> Loop {
    let mut t = FIRST_PIECE;
    for (k, size) in [(i, a), (j, b.abs())] {
        let channel = &model.channels[k];
        for up in [true, false] {
            t = t.min(room(channel, 1, up) / size).min((room(channel, 0, up) / size).sqrt());
        }
    }
    let rest = rest_values(model);
    let mut pieces = Vec::new();
    for second in if driven.is_some() { vec![1.0, -1.0] } else { vec![1.0] } {
        for (sign, duration) in [(1.0, t), (-1.0, 2.0 * t), (1.0, t)] {
            let mut row = rest.clone();
            row[i] += sign * a;
            row[j] += sign * second * b;
            pieces.push((row, duration));
        }
    }
    let closing = driven.map(|velocity| Closing { input: j, from_piece: 3, velocity });
    let shape = Shape::Together { accelerations: [a, b], twice: driven.is_some() };
    Loop { shape, moved: vec![i, j], pieces, closing }
}

/// How far a derivative may go up or down from rest.
fn room(channel: &Channel, order: usize, up: bool) -> f64 {
    let rest = if order == 0 { channel.home.value } else { 0.0 };
    let [low, high] = channel.spans[order].ends;
    ROOM * (if up { high - rest } else { rest - low })
}

fn lift(model: &RestModel, j: usize, up: bool, shaken: bool) -> Option<Loop> {
    let channel = &model.channels[j];
    // Where only the highest derivative acts, it does not matter where the input is.
    let acts = |s: &Option<Symbol>| s.is_some_and(|s| model.valued.iter().any(|&e| model.system.pool.depends_on(e, s)));
    let order = channel.order();
    if order > 0 && !channel.symbols[..order].iter().any(acts) {
        return None;
    }
    let sign = if up { 1.0 } else { -1.0 };
    let far = room(channel, 0, up);
    let (peak, pieces) = match channel.order() {
        _ if shaken && (channel.order() != 2 || far.is_infinite()) => return None,
        0 => (far, vec![(sign * far, FIRST_PIECE)]),
        1 => {
            let rate = room(channel, 1, true).min(room(channel, 1, false));
            let t = if far.is_finite() { far / rate } else { FIRST_PIECE };
            (rate * t, vec![(sign * rate, t), (0.0, t), (-sign * rate, t)])
        }
        2 => {
            let a = room(channel, 2, true).min(room(channel, 2, false));
            let speed = room(channel, 1, true).min(room(channel, 1, false));
            let far = if shaken { far * (1.0 - SHAKEN) } else { far };
            let mut t = if far.is_finite() { (far / a).sqrt() } else { FIRST_PIECE };
            // At the limit of speed, the input coasts.
            let coast = if a * t > speed { far / speed - speed / a } else { 0.0 };
            t = t.min(speed / a);
            let peak = a * t * (t + coast);
            let to = [(sign * a, t), (0.0, coast), (-sign * a, t)];
            let there = if shaken {
                let tau = (SHAKEN * peak / a).sqrt();
                [(sign * a, tau), (-sign * a, 2.0 * tau), (sign * a, tau)].repeat(SHAKES)
            } else {
                vec![(0.0, t)]
            };
            let back = [(-sign * a, t), (0.0, coast), (sign * a, t)];
            (peak, [&to[..], &there, &back].concat())
        }
        _ => return None,
    };
    let pieces: Vec<(f64, f64)> = pieces.into_iter().filter(|p| p.1 > 0.0).collect();
    let is_loop = peak.is_finite() && peak > 0.0 && pieces.iter().all(|p| p.0.is_finite() && p.1.is_finite());
    is_loop.then(|| Loop::of_one(model, j, Shape::Lift { peak: sign * peak, shaken }, &pieces))
}

fn fast_slow(model: &RestModel, j: usize, up: bool, slow: Option<f64>) -> Option<Loop> {
    let channel = &model.channels[j];
    if channel.order() != 2 {
        return None;
    }
    let sign = if up { 1.0 } else { -1.0 };
    let fast = room(channel, 2, up);
    let slow = slow?;
    let speed = room(channel, 1, up);
    let back_speed = room(channel, 1, !up);
    let far = room(channel, 0, up);
    // The input goes to fast t²/2 (1 + fast/slow), and is back with √(slow · that) as its highest speed.
    let reach = 0.5 * fast * (1.0 + fast / slow);
    let t = FIRST_PIECE.min(speed / fast).min((far / reach).sqrt()).min((back_speed.powi(2) / (slow * reach)).sqrt());
    let back = (reach / slow).sqrt() * t;
    let pieces = [(sign * fast, t), (-sign * slow, fast * t / slow + back), (sign * slow, back)];
    let is_loop = t > 0.0 && pieces.iter().all(|p| p.0.is_finite() && p.1.is_finite());
    is_loop.then(|| Loop::of_one(model, j, Shape::FastSlow { fast: sign * fast, slow }, &pieces))
}

/// By input, the acceleration of a return; `None` where there is none.
pub(crate) fn slow_accelerations(model: &mut RestModel) -> Vec<Option<f64>> {
    (0..model.channels.len())
        .map(|j| {
            let channel = &model.channels[j];
            let limit = (channel.order() == 2).then(|| room(channel, 2, true).min(room(channel, 2, false)))?;
            if limit > 0.0 { held_acceleration(model, j, limit) } else { None }
        })
        .collect()
}

/// The largest acceleration of an input, up to a limit, that moves no coordinate near the point, times [`SLOW`].
fn held_acceleration(model: &mut RestModel, j: usize, limit: f64) -> Option<f64> {
    let mut holds = |size: f64| {
        let mut inputs: Vec<Vec<Span>> = model.channels.iter().map(Channel::at_home).collect();
        inputs[j].clone_from(&model.channels[j].spans);
        let order = model.channels[j].order();
        inputs[j][order] = Span::between(-size, size);
        let held = Test::new(model, &inputs, Where::Near).run();
        held.motions.iter().all(|m| *m == Motion::Never)
    };
    if holds(limit) {
        return Some(limit * SLOW);
    }
    let (mut low, mut high) = (LEAST_ACCELERATION * limit, limit);
    if !holds(low) {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    Some(SLOW * low)
}
