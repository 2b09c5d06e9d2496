//! A sampled position loop around a plant, and its log.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use bracketry::sim::{ExactPlant, SimulationSettings};
use bracketry::system::System;
use rand::rngs::StdRng;

use super::measure::{Colored, Encoder, Table, between, sign};

/// One axis: position and speed are states `i` and `i + axes` of the plant, the force is its input `i`.
pub(super) struct Axis {
    /// Inertia, for the gains.
    pub(super) inertia: f64,
    /// Bandwidth of the loop in Hz.
    pub(super) bandwidth: f64,
    /// Half the travel.
    pub(super) travel: f64,
    /// Durations of moves in s, shortest and longest.
    pub(super) durations: [f64; 2],
    /// Step of the encoder.
    pub(super) step: f64,
    /// Standard deviation of the force that the log does not contain.
    pub(super) unlogged: f64,
}

/// The loop.
pub(super) struct Servo<'a> {
    /// The true plant.
    pub(super) plant: &'a System,
    /// Its axes.
    pub(super) axes: &'a [Axis],
    /// Header of the log: `t`, positions, forces.
    pub(super) header: &'a str,
    /// Time of a sample, s.
    pub(super) dt: f64,
    /// Duration, s.
    pub(super) duration: f64,
    /// Delay of the force behind its logged value, s; at most a few samples.
    pub(super) delay: f64,
}

/// A smooth move from one place to another (minimum jerk), with rests between: position and speed over time.
struct Moves {
    from: f64,
    to: f64,
    begin: f64,
    end: f64,
}

impl Moves {
    fn at(&mut self, t: f64, axis: &Axis, random: &mut StdRng) -> (f64, f64) {
        if t > self.end + 0.05 {
            let [shortest, longest] = axis.durations;
            let way = sign(random) * between(random, 0.3, 1.0) * axis.travel;
            let to = if (self.to + way).abs() > axis.travel { self.to - way } else { self.to + way };
            *self = Self {
                from: self.to,
                to: to.clamp(-axis.travel, axis.travel),
                begin: t,
                end: t + between(random, shortest, longest),
            };
        }
        let duration = self.end - self.begin;
        let s = ((t - self.begin) / duration).clamp(0.0, 1.0);
        let way = self.to - self.from;
        (
            self.from + way * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
            way * 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration,
        )
    }
}

impl Servo<'_> {
    /// Runs and returns the log.
    pub(super) fn run(&self, random: &mut StdRng) -> String {
        let axes = self.axes.len();
        let mut plant = ExactPlant::new(self.plant, &vec![0.0; 2 * axes], &SimulationSettings::default()).unwrap();
        let mut moves: Vec<Moves> =
            self.axes.iter().map(|_| Moves { from: 0.0, to: 0.0, begin: -1.0, end: -0.5 }).collect();
        let mut encoders: Vec<Encoder> = self.axes.iter().map(|a| Encoder::new(a.step, self.dt)).collect();
        let mut unlogged: Vec<Colored> = self.axes.iter().map(|a| Colored::new(a.unlogged, 50.0, self.dt)).collect();
        let (mut last, mut speed) = (vec![0.0; axes], vec![0.0; axes]);
        let whole = (self.delay / self.dt).floor();
        let part = self.delay - whole * self.dt;
        let mut waiting: VecDeque<Vec<f64>> = (0..=whole as usize).map(|_| vec![0.0; axes]).collect();
        let mut table = Table::new(self.header);
        for k in 0..(self.duration / self.dt).round() as usize {
            let t = k as f64 * self.dt;
            let (mut measured, mut force) = (vec![0.0; axes], vec![0.0; axes]);
            for (i, axis) in self.axes.iter().enumerate() {
                measured[i] = encoders[i].read(plant.state()[i], random);
                let smooth = (-TAU * 60.0 * self.dt).exp();
                speed[i] = smooth * speed[i] + (1.0 - smooth) * (measured[i] - last[i]) / self.dt;
                let (q, v) = moves[i].at(t, axis, random);
                let w = TAU * axis.bandwidth;
                force[i] = axis.inertia * (w * w * (q - measured[i]) + 1.6 * w * (v - speed[i]));
            }
            last.clone_from(&measured);
            table.row(&[&[t], &measured[..], &force[..]].concat());
            waiting.push_back(force);
            let disturbance: Vec<f64> = unlogged.iter_mut().map(|n| n.next(random)).collect();
            let acts = |f: &[f64]| f.iter().zip(&disturbance).map(|(f, d)| f + d).collect::<Vec<f64>>();
            if part > 0.0 {
                assert!(plant.hold(&acts(&waiting[0]), part).unwrap().is_finished());
            }
            waiting.pop_front();
            assert!(plant.hold(&acts(&waiting[0]), self.dt - part).unwrap().is_finished());
        }
        table.text()
    }
}
