//! Which brackets of the generators a simplified basis stands for.

use bracketry_symbolic::{Bindings, Pool};

use crate::algebra::field::Field;
use crate::algebra::word::Word;
use crate::evidence::Evidence;
use crate::residues::{Echelon, Fp, OFFSET, Span, unit_row};

/// Seed and number of the points that are tried.
const SEED: u64 = 0x6272_6163_6b65_7406;
const POINTS: usize = 3;

/// What one round of a closure worked with.
pub(crate) struct Round {
    /// z: with Δ_{k−1} they span Δ_k.
    pub(crate) fresh: Vec<Field>,
    /// (m, l, [G_m, z_l]), without those that are plainly zero.
    pub(crate) brackets: Vec<(usize, usize, Field)>,
}

/// How a closure was found.
pub(crate) struct History {
    /// X: the generators, the first of them independent and spanning Δ_0.
    pub(crate) generators: Vec<Field>,
    /// Their words.
    pub(crate) words: Vec<Word>,
    /// G: fields of which the X are combinations, modulo Δ_0 those that are not in Δ_0 themselves.
    pub(crate) simplified: Vec<Field>,
    pub(crate) rounds: Vec<Round>,
}

impl History {
    /// Words, in order of the rounds, whose brackets are a basis.
    ///
    /// With X_i = Σ α_im G_m and words w_j ≡ Σ β_jl z_l modulo Δ_{k−1}, over the field of functions,
    /// [X_i, w_j] ≡ Σ α_im β_jl [G_m, z_l] modulo Δ_k. The right-hand side is known at a random point, where the
    /// words of the next round are chosen greedily and their own β solved for.
    ///
    /// What is independent at one point is so at almost all. None if the point is not generic enough
    /// or the fields have no values together.
    pub(crate) fn name(&self, pool: &mut Pool, bindings: &Bindings, evidence: &mut Evidence) -> Option<Vec<Word>> {
        let n = self.generators.first()?.len();
        let brackets = || self.rounds.iter().flat_map(|r| r.fresh.iter().chain(r.brackets.iter().map(|b| &b.2)));
        let fields = || self.generators.iter().chain(&self.simplified).chain(brackets());
        let roots: Vec<_> = fields().flatten().copied().collect();
        let samples = pool.sample_in::<OFFSET>(&roots, bindings, POINTS, SEED).ok()?;
        if samples.ambiguous_signs > 0 {
            return None;
        }
        samples.values.iter().find_map(|values| self.name_at(&mut values.chunks(n), evidence))
    }

    fn name_at<'a>(&self, values: &mut impl Iterator<Item = &'a [Fp]>, evidence: &mut Evidence) -> Option<Vec<Word>> {
        let generators: Vec<&[Fp]> = values.take(self.generators.len()).collect();
        let simplified: Vec<&[Fp]> = values.take(self.simplified.len()).collect();
        let n = generators.first()?.len();
        let mut span = Span::empty(n);
        let mut basis = Coordinates::in_basis(&mut span, &simplified);
        let alpha: Vec<Vec<Fp>> = generators.iter().map(|x| basis.of(x)).collect::<Option<_>>()?;
        let mut names = Vec::new();
        // The words of this round with their values modulo Δ_{k−1}.
        let first = self.rounds.first()?.fresh.len();
        let mut words: Vec<(Word, Vec<Fp>)> =
            self.words.iter().zip(&generators).take(first).map(|(w, x)| (w.clone(), x.to_vec())).collect();
        for round in &self.rounds {
            let fresh: Vec<&[Fp]> = values.take(round.fresh.len()).collect();
            if words.len() != fresh.len() {
                return None;
            }
            let mut basis = Coordinates::in_basis(&mut span, &fresh);
            let beta: Vec<Vec<Fp>> = words.iter().map(|(_, w)| basis.of(w)).collect::<Option<_>>()?;
            for z in &fresh {
                span.insert(z.to_vec());
            }
            let brackets: Vec<&[Fp]> = values.take(round.brackets.len()).collect();
            names.extend(words.iter().map(|w| w.0.clone()));
            let mut grown = span.clone();
            let mut next = Vec::new();
            for (x, alpha) in self.words.iter().zip(&alpha) {
                for ((w, _), beta) in words.iter().zip(&beta) {
                    let mut value = vec![Fp::ZERO; n];
                    for ((m, l, _), z) in round.brackets.iter().zip(&brackets) {
                        let c = alpha[*m] * beta[*l];
                        value.iter_mut().zip(*z).for_each(|(v, &z)| *v += c * z);
                    }
                    if grown.insert(value.clone()) {
                        next.push((Word::bracket(x.clone(), w.clone()), value));
                    }
                }
            }
            words = next;
            evidence.spend(grown.products).ok()?;
            span.products = 0.0;
        }
        words.is_empty().then_some(names)
    }
}

/// Coordinates in a basis modulo a span.
struct Coordinates<'a> {
    span: &'a mut Span,
    /// The basis modulo the span, each vector followed by a row of the unit matrix.
    tagged: Echelon,
    /// Entries of a vector, and vectors of the basis.
    size: (usize, usize),
}

impl<'a> Coordinates<'a> {
    fn in_basis(span: &'a mut Span, basis: &[&[Fp]]) -> Self {
        let size = (span.units.len(), basis.len());
        let mut found = Coordinates { span, tagged: Echelon::empty(size.0 + size.1), size };
        for (l, z) in basis.iter().enumerate() {
            let row = found.tagged(z, unit_row(l, basis.len()));
            found.tagged.insert(row);
        }
        found
    }

    /// `vector` modulo the span with a tag, the elimination of which is counted.
    fn tagged(&mut self, vector: &[Fp], tag: Vec<Fp>) -> Vec<Fp> {
        self.span.products += 2.0 * (self.tagged.rank() * (self.size.0 + self.size.1)) as f64;
        [self.span.reduce(vector.to_vec()), tag].concat()
    }

    /// c with `vector` = Σ c_l `basis`_l modulo the span, if there is one.
    fn of(&mut self, vector: &[Fp]) -> Option<Vec<Fp>> {
        let row = self.tagged(vector, vec![Fp::ZERO; self.size.1]);
        let rest = self.tagged.reduce(row);
        let (left, right) = rest.split_at(self.size.0);
        left.iter().all(|x| *x == Fp::ZERO).then(|| right.iter().map(|c| -*c).collect())
    }
}
