//! Sussmann's general sufficient condition for small-time local controllability.

use bracketry_symbolic::{Named, Pool};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::algebra::field::{Field, bracket, is_plain_zero};
use crate::algebra::word::{Bracket, Word, generators};
use crate::controllability::local_accessibility::Frame;
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// A right-normed bracket [w_0, [w_1, … ]]; letter 0 is f, letter i is g_i.
type Letters = Vec<u8>;
/// How often each letter occurs in a bracket.
type Degrees = Vec<u8>;

/// A bad bracket that brackets of smaller weight do not neutralize.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Obstruction {
    /// The bracket.
    pub bracket: Bracket,
    /// How often the drift f and each input field g_i occur in it.
    pub degrees: Named<usize>,
    /// The weights for which it obstructs, of f and of the inputs (one number if they are all equal).
    pub weights: Vec<u32>,
}

/// What the condition says for one choice of weights.
pub(crate) enum Outcome {
    Holds,
    Obstructed(Obstruction),
    TooLarge,
}

struct Entry {
    word: Letters,
    field: Field,
    /// At the point.
    value: Vec<Fp>,
}

/// Brackets of f and the inputs by multidegree, with their values at the point; formed once for
/// all weights.
///
/// The part of a free Lie algebra with given degrees is spanned by the right-normed brackets that
/// end in one fixed letter that occurs. Here that is f where f occurs, so that permutations of the
/// inputs map the list to itself, and else the first input that occurs.
pub(crate) struct Brackets<'a> {
    frame: &'a Frame,
    letters: Vec<Field>,
    /// Positive factors of the inputs, see [`Inputs`].
    scales: Vec<Fp>,
    entries: FxHashMap<Degrees, Vec<Entry>>,
    limits: Limits,
    first_node: usize,
    count: usize,
    exhausted: bool,
}

/// Inputs in which the condition is tested: x' = f + Σ v_i √s_i h_i. A bracket of even degree in
/// every input takes only the s_i, which are rational.
pub(crate) struct Inputs {
    pub(crate) fields: Vec<Field>,
    pub(crate) scales: Vec<Fp>,
}

impl Inputs {
    pub(crate) fn given(frame: &Frame) -> Self {
        let fields = frame.fields.controls.clone();
        Inputs { scales: vec![Fp::ONE; fields.len()], fields }
    }
}

/// Seed of the points at which vanishing brackets are recognized.
const ZERO_SEED: u64 = 0x6272_6163_6b65_7405;

impl<'a> Brackets<'a> {
    pub(crate) fn new(pool: &Pool, frame: &'a Frame, inputs: Inputs, limits: &Limits) -> Self {
        let mut letters = vec![frame.fields.drift.clone()];
        letters.extend(inputs.fields);
        Brackets {
            frame,
            letters,
            scales: inputs.scales,
            entries: FxHashMap::default(),
            limits: *limits,
            first_node: pool.len(),
            count: 0,
            exhausted: false,
        }
    }

    fn is_empty(&self, degrees: &[u8]) -> bool {
        self.entries.get(degrees).is_none_or(Vec::is_empty)
    }

    /// Forms all brackets of these degrees, whose shorter ones are known; false if there are too many.
    fn form(&mut self, pool: &mut Pool, wanted: &[Degrees], evidence: &mut Evidence) -> Result<bool, Undecided> {
        let mut formed: Vec<(Degrees, Letters, Field)> = Vec::new();
        for degrees in wanted {
            if self.entries.contains_key(degrees) {
                continue;
            }
            let length: usize = degrees.iter().map(|&d| usize::from(d)).sum();
            if length == 1 {
                let i = degrees.iter().position(|&d| d == 1).unwrap_or(0);
                formed.push((degrees.clone(), vec![i as u8], self.letters[i].clone()));
                continue;
            }
            for i in 0..self.letters.len() {
                let Some(rest) = without(degrees, i) else { continue };
                if self.is_empty(&rest) {
                    continue;
                }
                if self.exhausted || length > self.limits.length {
                    return Ok(false);
                }
                let last = degrees.iter().position(|&d| d > 0).unwrap_or(0);
                for inner in &self.entries[&rest] {
                    if inner.word.last().is_none_or(|&l| usize::from(l) != last) {
                        continue;
                    }
                    if pool.len() - self.first_node > self.limits.nodes {
                        self.exhausted = true;
                        return Ok(false);
                    }
                    let field = bracket(pool, &self.frame.fields.states, &self.letters[i], &inner.field);
                    let mut word = vec![i as u8];
                    word.extend(&inner.word);
                    formed.push((degrees.clone(), word, field));
                    self.count += 1;
                }
                if self.count > self.limits.brackets * 4 {
                    self.exhausted = true;
                    return Ok(false);
                }
            }
        }
        formed.retain(|(_, _, field)| !is_plain_zero(pool, field));
        if !formed.is_empty() {
            let fields: Vec<Field> = formed.iter().map(|e| e.2.clone()).collect();
            let n = fields[0].len();
            let samples = pool.sample_in::<OFFSET>(&fields.concat(), &self.frame.fields.bindings, 1, ZERO_SEED)?;
            evidence.add_equalities(&samples, formed.len())?;
            let mut nonzero = samples.values[0].chunks(n).map(|v| v.iter().any(|x| *x != Fp::ZERO));
            formed.retain(|_| nonzero.next().unwrap_or(true));
        }
        for degrees in wanted {
            self.entries.entry(degrees.clone()).or_default();
        }
        if formed.is_empty() {
            return Ok(true);
        }
        let fields: Vec<Field> = formed.iter().map(|e| e.2.clone()).collect();
        let values = self.frame.evaluate(pool, &fields, evidence)?;
        for ((degrees, word, field), value) in formed.into_iter().zip(values) {
            self.entries.entry(degrees).or_default().push(Entry { word, field, value });
        }
        Ok(true)
    }

    /// Tests the condition for the weights of f and of each input.
    ///
    /// A bracket is bad if its degree in f is odd and that in every input even. Let β be the sum
    /// over a group of input symmetries that keep the weights; here those permutations of the
    /// inputs that map each to one of equal weight. If the algebra has full dimension at the
    /// equilibrium and for every bad bracket B the value of β(B) there is a combination of values
    /// of brackets of smaller weight, the system is STLC (Sussmann 1987, theorems 2.4 and 7.3,
    /// where all inputs weigh 1 and f θ ≤ 1; Bianchini and Stefani 1993, for weights
    /// 0 < l_0 ≤ l_i). From the weight on at which the smaller ones span everything, nothing is
    /// left to be tested.
    pub(crate) fn test(
        &mut self,
        pool: &mut Pool,
        weights: &[u32],
        evidence: &mut Evidence,
    ) -> Result<Outcome, Undecided> {
        let n = self.frame.fields.states.len();
        let permutations = permutations(&weights[1..]);
        let most = self.limits.length as u32 * weights.iter().max().copied().unwrap_or(1);
        let mut smaller = Echelon::empty(n);
        for weight in 1..=most {
            let wanted = of_weight(weights, weight);
            if !self.form(pool, &wanted, evidence)? {
                return Ok(Outcome::TooLarge);
            }
            for degrees in wanted.iter().filter(|d| is_bad(d)) {
                for entry in &self.entries[degrees] {
                    if !smaller.contains(&self.symmetrized(entry, degrees, &permutations, n)) {
                        return Ok(Outcome::Obstructed(obstruction(&entry.word, degrees, weights)));
                    }
                }
            }
            for entry in wanted.iter().flat_map(|d| &self.entries[d]) {
                smaller.insert(entry.value.clone());
            }
            if smaller.rank() == n {
                return Ok(Outcome::Holds);
            }
        }
        Ok(Outcome::TooLarge)
    }

    /// Value of β at the point.
    fn symmetrized(&self, entry: &Entry, degrees: &[u8], permutations: &[Vec<u8>], n: usize) -> Vec<Fp> {
        let mut sum = vec![Fp::ZERO; n];
        for p in permutations {
            let to = |l: u8| if l == 0 { 0 } else { p[usize::from(l) - 1] + 1 };
            let image: Letters = entry.word.iter().map(|&l| to(l)).collect();
            let mut of_image = vec![0; degrees.len()];
            let mut scale = Fp::ONE;
            for (l, &d) in degrees.iter().enumerate() {
                let l = to(l as u8);
                of_image[usize::from(l)] = d;
                if l > 0 {
                    scale *= self.scales[usize::from(l) - 1].pow(u64::from(d / 2));
                }
            }
            // Brackets that vanish were not kept.
            let found = self.entries.get(&of_image).and_then(|list| list.iter().find(|e| e.word == image));
            for (s, &x) in sum.iter_mut().zip(found.iter().flat_map(|e| &e.value)) {
                *s += scale * x;
            }
        }
        sum
    }
}

fn without(degrees: &[u8], letter: usize) -> Option<Degrees> {
    let mut rest = degrees.to_vec();
    rest[letter] = rest[letter].checked_sub(1)?;
    Some(rest)
}

fn is_bad(degrees: &[u8]) -> bool {
    degrees[0] % 2 == 1 && degrees[1..].iter().all(|d| d % 2 == 0)
}

/// All degrees with Σ weight · degree = `total`.
fn of_weight(weights: &[u32], total: u32) -> Vec<Degrees> {
    let Some((&first, others)) = weights.split_first() else {
        return if total == 0 { vec![Vec::new()] } else { Vec::new() };
    };
    (0..=total / first)
        .flat_map(|d| {
            of_weight(others, total - d * first).into_iter().map(move |rest| {
                let mut degrees = vec![d as u8];
                degrees.extend(rest);
                degrees
            })
        })
        .collect()
}

fn obstruction(word: &[u8], degrees: &[u8], weights: &[u32]) -> Obstruction {
    let mut letters: Vec<Word> = word.iter().map(|&l| Word::Generator(usize::from(l))).collect();
    // Up to sign; [f,g] is how the bracket is usually written.
    let k = letters.len();
    if k >= 2 && letters[k - 1] == Word::Generator(0) {
        letters.swap(k - 2, k - 1);
    }
    let innermost = letters.pop().unwrap_or(Word::Generator(0));
    let word = letters.into_iter().rev().fold(innermost, |inner, l| Word::bracket(l, inner));
    let generators = generators(degrees.len() - 1);
    let degrees = Named(generators.iter().zip(degrees).map(|(g, &d)| (g.to_string(), usize::from(d))).collect());
    let bracket = Bracket { word, generators };
    Obstruction { bracket, degrees, weights: shortened(weights) }
}

/// [drift, inputs] where all inputs weigh the same.
pub(crate) fn shortened(weights: &[u32]) -> Vec<u32> {
    if weights[1..].windows(2).all(|w| w[0] == w[1]) {
        weights.iter().take(2).copied().collect()
    } else {
        weights.to_vec()
    }
}

/// Beyond this many inputs brackets are not symmetrized.
const MAX_SYMMETRIZED: usize = 5;

/// All permutations of 0 … m − 1 that keep the weights. For many inputs only the identity: to
/// neutralize every bad bracket is enough, because β sums bad brackets of the same weight.
fn permutations(weights: &[u32]) -> Vec<Vec<u8>> {
    let m = weights.len();
    if m > MAX_SYMMETRIZED {
        return vec![(0..m as u8).collect()];
    }
    let all = (0..m as u8).fold(vec![Vec::new()], |all, next| {
        all.iter()
            .flat_map(|p: &Vec<u8>| {
                (0..=p.len()).map(|i| {
                    let mut q = p.clone();
                    q.insert(i, next);
                    q
                })
            })
            .collect()
    });
    all.into_iter().filter(|p| p.iter().enumerate().all(|(i, &j)| weights[i] == weights[usize::from(j)])).collect()
}

/// Largest weight, and most choices of weights, that are tried.
const MAX_WEIGHT: u32 = 8;
const MAX_CHOICES: usize = 80;

/// Weights 0 < l_0 ≤ l_i without common divisor: first equal ones of the inputs, then each input
/// its own, small weights first.
pub(crate) fn choices(inputs: usize) -> Vec<Vec<u32>> {
    let mut out: Vec<Vec<u32>> = Vec::new();
    for most in 1..=MAX_WEIGHT {
        for drift in 1..=most {
            if gcd(drift, most) == 1 {
                let mut weights = vec![most; inputs + 1];
                weights[0] = drift;
                out.push(weights);
            }
        }
    }
    if inputs < 2 {
        return out;
    }
    for most in 2..=MAX_WEIGHT {
        for drift in 1..=most {
            let mut lists: Vec<Vec<u32>> = vec![vec![drift]];
            for _ in 0..inputs {
                lists = lists
                    .iter()
                    .flat_map(|l| {
                        (drift..=most).map(move |w| {
                            let mut l = l.clone();
                            l.push(w);
                            l
                        })
                    })
                    .take(4 * MAX_CHOICES)
                    .collect();
            }
            for weights in lists {
                let mixed = weights[1..].windows(2).any(|w| w[0] != w[1]);
                if mixed && weights.contains(&most) && weights.iter().fold(0, |d, &w| gcd(d, w)) == 1 {
                    out.push(weights);
                }
                if out.len() >= MAX_CHOICES {
                    return out;
                }
            }
        }
    }
    out
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::{choices, of_weight, permutations};

    #[test]
    fn weights_respect_the_drift() {
        for m in 1..5 {
            let all = choices(m);
            assert_eq!(all[0], vec![1; m + 1]);
            assert!(all.iter().all(|w| w.len() == m + 1 && w[1..].iter().all(|l| *l >= w[0])));
        }
    }

    #[test]
    fn symmetries_keep_the_weights() {
        assert_eq!(permutations(&[1, 1, 1]).len(), 6);
        assert_eq!(
            permutations(&[2, 1, 2]),
            [[0, 1, 2], [2, 1, 0]].map(|p| p.to_vec()).to_vec().into_iter().rev().collect::<Vec<_>>()
        );
    }

    #[test]
    fn degrees_of_a_weight() {
        assert_eq!(of_weight(&[1, 2], 4), [[0, 2], [2, 1], [4, 0]]);
    }
}
