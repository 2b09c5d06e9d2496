//! Small-time local controllability at an equilibrium: sufficient and necessary conditions.

use std::collections::BTreeMap;
use std::fmt;

use bracketry_symbolic::{Fp, Pool};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::answer::Answer;
use crate::echelon::Echelon;
use crate::error::Undecided;
use crate::evidence::Evidence;
use crate::fields::{Field, bracket, is_plain_zero};
use crate::linear::Linearisation;
use crate::local::{Frame, Limits, Words};

/// Whether the inputs reach a full neighbourhood in arbitrarily short time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// A sufficient condition holds.
    Yes,
    /// A necessary condition fails.
    No,
    /// Neither is known.
    Inconclusive,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Yes => "yes",
            Verdict::No => "no",
            Verdict::Inconclusive => "inconclusive",
        })
    }
}

/// Small-time local controllability (STLC) with inputs around their values at the point.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Stlc {
    /// The verdict.
    pub verdict: Verdict,
    /// The condition that holds or fails.
    pub reason: String,
    /// Weights of the drift and of the inputs for which Sussmann's condition holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<[u32; 2]>,
}

impl Stlc {
    fn new(verdict: Verdict, reason: impl Into<String>) -> Self {
        Stlc { verdict, reason: reason.into(), weights: None }
    }
}

/// Weights (drift, inputs) that are tried: Sussmann's θ is their quotient and must be at most 1.
const WEIGHTS: [[u32; 2]; 4] = [[1, 1], [1, 2], [2, 3], [1, 3]];

/// Decides STLC as far as the conditions below go.
///
/// - not an equilibrium and f(x0) outside span g(x0): no (bounded inputs cannot hold the state);
/// - dimension at x0 not full: no (the orbit is a lower-dimensional manifold, Nagano–Sussmann);
/// - controllable linearisation: yes;
/// - no drift and full dimension: yes (Chow–Rashevskii);
/// - Sussmann's general condition: yes;
/// - one input: no where Stefani's necessary condition fails (see [`stefani`]).
pub(crate) fn decide(
    pool: &mut Pool,
    frame: &Frame,
    equilibrium: bool,
    dimension: &Answer<usize>,
    linearisation: Option<&Linearisation>,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Undecided> {
    let n = frame.fields.states.len();
    let Some(linearisation) = linearisation.filter(|_| equilibrium) else {
        let mut span = Echelon::of(&frame.evaluate(pool, &frame.fields.controls, evidence)?);
        let drift = frame.evaluate(pool, std::slice::from_ref(&frame.fields.drift), evidence)?;
        return Ok(if drift.into_iter().any(|f| span.insert(f)) {
            Stlc::new(Verdict::No, "the drift does not vanish at the point and no input balances it")
        } else {
            Stlc::new(Verdict::Inconclusive, "the point is no equilibrium for the inputs given with it")
        });
    };
    match dimension {
        Answer::Known(d) if *d < n => {
            return Ok(Stlc::new(
                Verdict::No,
                format!("the accessibility algebra has dimension {d} < {n} at the point"),
            ));
        }
        Answer::Unknown(why) => {
            return Ok(Stlc::new(Verdict::Inconclusive, format!("the accessible dimension is not decided: {why}")));
        }
        Answer::Known(_) => {}
    }
    let controllable = linearisation.controllable();
    if controllable.rank() == n {
        return Ok(Stlc::new(Verdict::Yes, "the linearisation is controllable"));
    }
    if is_plain_zero(pool, &frame.fields.drift) {
        return Ok(Stlc::new(Verdict::Yes, "no drift and full dimension (Chow–Rashevskii)"));
    }
    let mut obstructions = Vec::new();
    for weights in WEIGHTS {
        match Sussmann::new(weights).run(pool, frame, limits, evidence)? {
            Outcome::Holds => {
                let reason = format!("Sussmann's condition holds with weights {weights:?} of drift and inputs");
                return Ok(Stlc { verdict: Verdict::Yes, reason, weights: Some(weights) });
            }
            Outcome::Obstructed(degrees) => obstructions.push(format!("{weights:?}: degrees {degrees:?}")),
            Outcome::TooLarge => obstructions.push(format!("{weights:?}: too many brackets")),
        }
    }
    if let [g] = frame.fields.controls.as_slice()
        && let Some(k) = stefani(pool, frame, g, &controllable, limits, evidence)?
    {
        return Ok(Stlc::new(
            Verdict::No,
            format!(
                "ad_g^{k} f at the point is no combination of brackets with fewer factors g (Stefani's necessary condition)"
            ),
        ));
    }
    Ok(Stlc::new(
        Verdict::Inconclusive,
        format!(
            "brackets that may obstruct are not neutralised (weights and degrees in f, g_1, …: {})",
            obstructions.join("; ")
        ),
    ))
}

/// The even k for which Stefani's necessary condition (1986; k = 2: Sussmann 1983) fails: STLC of
/// x' = f + u g at an equilibrium needs ad_g^k f(x0) in the span of all brackets with fewer than
/// k factors g there, for every even k. `None` if it was not seen to fail.
///
/// Those brackets are infinitely many. For k = 2 they are the ad_f^i g, and Kalman's matrix has
/// their span; above, the condition is used only where they are found to span a
/// finite-dimensional space of functions.
fn stefani(
    pool: &mut Pool,
    frame: &Frame,
    g: &Field,
    controllable: &Echelon,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Option<usize>, Undecided> {
    let (states, drift) = (&frame.fields.states, &frame.fields.drift);
    let first_node = pool.len();
    let mut power = bracket(pool, states, g, drift);
    power = bracket(pool, states, g, &power);
    let value = frame.evaluate(pool, std::slice::from_ref(&power), evidence)?;
    if !controllable.contains(&value[0]) {
        return Ok(Some(2));
    }
    let mut words = Words::default();
    let mut candidates = vec![g.clone()];
    for degree in 1..limits.length {
        // From all brackets with fewer than `degree` factors g to those with at most as many.
        let fewer = words.kept.len();
        let mut rounds = 0;
        loop {
            words.extend(pool, &frame.fields.bindings, candidates, evidence)?;
            if words.fresh.is_empty() {
                break;
            }
            rounds += 1;
            if rounds > limits.length {
                return Ok(None);
            }
            candidates = Vec::new();
            for y in &words.kept[words.fresh.clone()] {
                if pool.len() - first_node > limits.nodes {
                    return Ok(None);
                }
                candidates.push(bracket(pool, states, drift, y));
            }
        }
        if words.kept.len() == fewer {
            return Ok(None);
        }
        if degree >= 3 {
            power = bracket(pool, states, g, &power);
            if degree % 2 == 1 {
                let next = bracket(pool, states, g, &power);
                let value = frame.evaluate(pool, &[next], evidence)?;
                let span = Echelon::of(&frame.evaluate(pool, &words.kept, evidence)?);
                if !span.contains(&value[0]) {
                    return Ok(Some(degree + 1));
                }
            }
        }
        candidates = words.kept[fewer..].iter().map(|y| bracket(pool, states, g, y)).collect();
    }
    Ok(None)
}

enum Outcome {
    Holds,
    /// Degrees in f, g_1 … g_m of a bad bracket that is not neutralised.
    Obstructed(Vec<usize>),
    TooLarge,
}

/// A right-normed bracket [w_0, [w_1, … ]]; letter 0 is f, letter i is g_i.
type Word = Vec<u8>;

/// Sussmann's general condition (1987) for one choice of weights.
///
/// A bracket is bad if its degree in f is odd and that in every g_i even. Let β be the sum
/// over all permutations of the inputs. If for every bad bracket B the value of β(B) at the
/// equilibrium is a combination of values of brackets of smaller weight, the system is STLC.
/// Right-normed brackets span those of each multidegree and β is linear, so it is enough to
/// look at them, and only up to the weight from which the smaller ones span everything.
struct Sussmann {
    weights: [u32; 2],
    /// Brackets by weight; those that vanish structurally are left out.
    by_weight: BTreeMap<u32, Vec<(Word, Field)>>,
    /// Values at the point.
    values: FxHashMap<Word, Vec<Fp>>,
}

impl Sussmann {
    fn new(weights: [u32; 2]) -> Self {
        Sussmann { weights, by_weight: BTreeMap::new(), values: FxHashMap::default() }
    }

    fn weight(&self, letter: u8) -> u32 {
        self.weights[usize::from(letter != 0)]
    }

    fn run(
        mut self,
        pool: &mut Pool,
        frame: &Frame,
        limits: &Limits,
        evidence: &mut Evidence,
    ) -> Result<Outcome, Undecided> {
        let n = frame.fields.states.len();
        let mut letters = vec![frame.fields.drift.clone()];
        letters.extend(frame.fields.controls.iter().cloned());
        let first_node = pool.len();
        let mut smaller = Echelon::new();
        let mut count = 0;
        for weight in 1.. {
            let Some(words) = self.words(pool, &letters, weight, frame, first_node + limits.nodes) else {
                return Ok(Outcome::TooLarge);
            };
            count += words.len();
            if count > limits.brackets * 4 || weight as usize > limits.length * self.weights[1] as usize {
                return Ok(Outcome::TooLarge);
            }
            let fields: Vec<Field> = words.iter().map(|(_, f)| f.clone()).collect();
            let values = if fields.is_empty() { Vec::new() } else { frame.evaluate(pool, &fields, evidence)? };
            for ((w, _), v) in words.iter().zip(&values) {
                self.values.insert(w.clone(), v.clone());
            }
            for (w, _) in &words {
                let degrees = degrees(w, letters.len());
                if degrees[0] % 2 == 1 && degrees[1..].iter().all(|d| d % 2 == 0) {
                    let beta = self.symmetrised(w, letters.len() - 1, n);
                    if !smaller.contains(&beta) {
                        return Ok(Outcome::Obstructed(degrees));
                    }
                }
            }
            self.by_weight.insert(weight, words);
            for v in values {
                smaller.insert(v);
            }
            if smaller.rank() == n {
                return Ok(Outcome::Holds);
            }
        }
        Ok(Outcome::TooLarge)
    }

    /// All right-normed brackets of this weight that are not plainly zero; `None` if they make
    /// the pool larger than `most` nodes.
    fn words(
        &self,
        pool: &mut Pool,
        letters: &[Field],
        weight: u32,
        frame: &Frame,
        most: usize,
    ) -> Option<Vec<(Word, Field)>> {
        let mut out = Vec::new();
        for (i, letter) in letters.iter().enumerate() {
            let i = i as u8;
            let w = self.weight(i);
            if w == weight && !is_plain_zero(pool, letter) {
                out.push((vec![i], letter.clone()));
            }
            let Some(inner) = weight.checked_sub(w).and_then(|rest| self.by_weight.get(&rest)) else { continue };
            for (word, field) in inner {
                // [a, b] = −[b, a]: of the two only a < b is formed.
                if word.len() == 1 && i >= word[0] {
                    continue;
                }
                if pool.len() > most {
                    return None;
                }
                let z = bracket(pool, &frame.fields.states, letter, field);
                if !is_plain_zero(pool, &z) {
                    let mut longer = vec![i];
                    longer.extend(word);
                    out.push((longer, z));
                }
            }
        }
        Some(out)
    }

    /// Value of β(w): the sum over all permutations of the inputs. All words of the weight are known.
    fn symmetrised(&self, word: &[u8], inputs: usize, n: usize) -> Vec<Fp> {
        let mut sum = vec![Fp::ZERO; n];
        for permutation in permutations(inputs) {
            let mut image: Word =
                word.iter().map(|&l| if l == 0 { 0 } else { permutation[usize::from(l) - 1] + 1 }).collect();
            let k = image.len();
            let reversed = k >= 2 && image[k - 2] > image[k - 1];
            if reversed {
                image.swap(k - 2, k - 1);
            }
            // Brackets that are zero were not kept.
            if let Some(v) = self.values.get(&image) {
                for (s, &x) in sum.iter_mut().zip(v) {
                    *s = if reversed { *s - x } else { *s + x };
                }
            }
        }
        sum
    }
}

/// How often each letter occurs.
fn degrees(word: &[u8], letters: usize) -> Vec<usize> {
    let mut d = vec![0; letters];
    for &l in word {
        d[usize::from(l)] += 1;
    }
    d
}

/// Beyond this many inputs brackets are not symmetrised.
const MAX_SYMMETRISED: usize = 5;

/// All orders of 0 … m − 1. For many inputs only the order as it is: to neutralise every bad
/// bracket is enough, because β sums bad brackets of the same weight.
fn permutations(m: usize) -> Vec<Vec<u8>> {
    if m > MAX_SYMMETRISED {
        return vec![(0..m as u8).collect()];
    }
    (0..m as u8).fold(vec![Vec::new()], |all, next| {
        all.iter()
            .flat_map(|p: &Vec<u8>| {
                (0..=p.len()).map(|i| {
                    let mut q = p.clone();
                    q.insert(i, next);
                    q
                })
            })
            .collect()
    })
}
