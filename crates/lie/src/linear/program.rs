//! Linear programs in exact arithmetic.

use bracketry_symbolic::Rational;

/// Most exchanges of a basis, in each of the two phases.
const MAX_PIVOTS: usize = 2000;

/// The x with A x = b and lower_i ≤ x_i ≤ upper_i, where an absent bound is infinite.
pub(crate) struct Program {
    /// The rows of A, of one entry for each unknown, with their right sides.
    pub(crate) equations: Vec<(Vec<Rational>, Rational)>,
    /// The bounds of the unknowns.
    pub(crate) bounds: Vec<(Option<Rational>, Option<Rational>)>,
}

/// What the maximization of c·x came to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Optimum {
    /// An x where the maximum is attained.
    Found(Vec<Rational>),
    /// There is no x: for these λ, λ·(A x − b) is at least a positive number for all x within the bounds (Farkas' lemma).
    Infeasible(Vec<Rational>),
    /// c·x grows without bound.
    Unbounded,
}

/// How an unknown is made of unknowns p, q ≥ 0.
enum Substitution {
    /// x = shift + sign·p.
    One { column: usize, shift: Rational, sign: Rational },
    /// x = p − q.
    Two { column: usize },
}

impl Program {
    /// Maximizes c·x by the simplex method with Bland's rule (1977), which does not cycle; `None` where that takes too many
    /// exchanges.
    pub(crate) fn maximize(&self, c: &[Rational]) -> Option<Optimum> {
        let (mut columns, mut substitutions, mut widths) = (0, Vec::new(), Vec::new());
        for (lower, upper) in &self.bounds {
            let column = columns;
            columns += 1;
            substitutions.push(match (lower, upper) {
                (Some(l), _) => Substitution::One { column, shift: l.clone(), sign: Rational::ONE },
                (None, Some(h)) => Substitution::One { column, shift: h.clone(), sign: -Rational::ONE },
                (None, None) => {
                    columns += 1;
                    Substitution::Two { column }
                }
            });
            if let (Some(l), Some(h)) = (lower, upper) {
                widths.push((column, h - l));
            }
        }
        let slacks = columns;
        columns += widths.len();
        let mut rows: Vec<Vec<Rational>> = Vec::new();
        for (coefficients, right) in &self.equations {
            let (mut row, moved) = substituted(coefficients, &substitutions, columns);
            row.push(right - moved);
            rows.push(row);
        }
        for (k, (column, width)) in widths.into_iter().enumerate() {
            let mut row = vec![Rational::ZERO; columns + 1];
            row[column] = Rational::ONE;
            row[slacks + k] = Rational::ONE;
            row[columns] = width;
            rows.push(row);
        }
        let (costs, _) = substituted(c, &substitutions, columns);
        let mut tableau = match Tableau::feasible(rows, columns)? {
            Ok(tableau) => tableau,
            Err(mut y) => {
                y.truncate(self.equations.len());
                return Some(Optimum::Infeasible(y));
            }
        };
        if !tableau.maximize(&costs, columns)? {
            return Some(Optimum::Unbounded);
        }
        let p = tableau.solution(columns);
        let value = |s: &Substitution| match s {
            Substitution::One { column, shift, sign } => shift + sign * &p[*column],
            Substitution::Two { column } => &p[*column] - &p[column + 1],
        };
        Some(Optimum::Found(substitutions.iter().map(value).collect()))
    }
}

/// The coefficients of the new unknowns, and the constant that the shifts add.
fn substituted(coefficients: &[Rational], list: &[Substitution], columns: usize) -> (Vec<Rational>, Rational) {
    let (mut row, mut constant) = (vec![Rational::ZERO; columns], Rational::ZERO);
    for (a, s) in coefficients.iter().zip(list) {
        match s {
            Substitution::One { column, shift, sign } => {
                row[*column] = a * sign;
                constant += a * shift;
            }
            Substitution::Two { column } => {
                row[*column].clone_from(a);
                row[column + 1] = -a.clone();
            }
        }
    }
    (row, constant)
}

/// The rows of a basic solution, each with its right side last, and the column that is basic in each.
struct Tableau {
    rows: Vec<Vec<Rational>>,
    basis: Vec<usize>,
}

impl Tableau {
    /// A basic solution p ≥ 0 of the rows, each with its right side last (first phase). Where there is none, y with
    /// yᵀ A ≥ 0 and y·b < 0.
    fn feasible(rows: Vec<Vec<Rational>>, columns: usize) -> Option<Result<Tableau, Vec<Rational>>> {
        let count = rows.len();
        let negative: Vec<bool> = rows.iter().map(|r| r[columns] < Rational::ZERO).collect();
        let with_artificial = |(i, mut row): (usize, Vec<Rational>)| {
            if negative[i] {
                for x in &mut row {
                    *x = -std::mem::take(x);
                }
            }
            let right = row.remove(columns);
            row.extend((0..count).map(|k| if k == i { Rational::ONE } else { Rational::ZERO }));
            row.push(right);
            row
        };
        let rows = rows.into_iter().enumerate().map(with_artificial).collect();
        let mut tableau = Tableau { rows, basis: (columns..columns + count).collect() };
        let mut costs = vec![Rational::ZERO; columns + count];
        costs[columns..].fill(-Rational::ONE);
        tableau.maximize(&costs, columns + count)?;
        let artificial = |basis: usize| basis >= columns;
        let rest = tableau.rows.iter().zip(&tableau.basis).filter(|(_, b)| artificial(**b));
        if rest.fold(Rational::ZERO, |s, (r, _)| s + &r[columns + count]) > Rational::ZERO {
            // The reduced costs of the artificial unknowns hold the multipliers of the rows.
            let y = (0..count).map(|i| {
                let y = -(Rational::ONE + tableau.reduced(&costs, columns + i));
                if negative[i] { -y } else { y }
            });
            return Some(Err(y.collect()));
        }
        // Artificial unknowns of value 0 leave the basis; a row of zeros follows from the others.
        let mut i = 0;
        while i < tableau.rows.len() {
            if artificial(tableau.basis[i]) {
                let Some(column) = (0..columns).find(|&j| tableau.rows[i][j] != Rational::ZERO) else {
                    tableau.rows.remove(i);
                    tableau.basis.remove(i);
                    continue;
                };
                tableau.exchange(i, column);
            }
            i += 1;
        }
        for row in &mut tableau.rows {
            row.drain(columns..columns + count);
        }
        Some(Ok(tableau))
    }

    /// c_j − c_B B⁻¹ a_j.
    fn reduced(&self, costs: &[Rational], column: usize) -> Rational {
        let basic = self.rows.iter().zip(&self.basis);
        basic.fold(costs[column].clone(), |s, (row, &b)| s - &costs[b] * &row[column])
    }

    /// Goes on to the maximum over the first `columns` unknowns; whether there is one.
    fn maximize(&mut self, costs: &[Rational], columns: usize) -> Option<bool> {
        for _ in 0..MAX_PIVOTS {
            let enters = (0..columns).find(|&j| !self.basis.contains(&j) && self.reduced(costs, j) > Rational::ZERO);
            let Some(column) = enters else { return Some(true) };
            let mut leaves: Option<(Rational, usize)> = None;
            for (i, row) in self.rows.iter().enumerate().filter(|(_, r)| r[column] > Rational::ZERO) {
                let step = &row[row.len() - 1] / &row[column];
                let better = leaves
                    .as_ref()
                    .is_none_or(|(least, k)| step < *least || step == *least && self.basis[i] < self.basis[*k]);
                if better {
                    leaves = Some((step, i));
                }
            }
            let Some((_, row)) = leaves else { return Some(false) };
            self.exchange(row, column);
        }
        None
    }

    /// Makes the column basic in the row.
    fn exchange(&mut self, i: usize, column: usize) {
        let head = self.rows[i][column].clone();
        self.rows[i].iter_mut().for_each(|x| *x /= &head);
        let pivot = self.rows[i].clone();
        for (k, row) in self.rows.iter_mut().enumerate() {
            if k != i && row[column] != Rational::ZERO {
                let factor = row[column].clone();
                for (x, y) in row.iter_mut().zip(&pivot).filter(|(_, y)| **y != Rational::ZERO) {
                    *x -= &factor * y;
                }
            }
        }
        self.basis[i] = column;
    }

    fn solution(&self, columns: usize) -> Vec<Rational> {
        let mut p = vec![Rational::ZERO; columns];
        for (row, &b) in self.rows.iter().zip(&self.basis) {
            p[b].clone_from(&row[columns]);
        }
        p
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn whole(x: i8) -> Rational {
        Rational::from(i64::from(x))
    }

    fn dot(a: &[Rational], b: &[Rational]) -> Rational {
        a.iter().zip(b).fold(Rational::ZERO, |s, (x, y)| s + x * y)
    }

    fn corners(m: usize) -> impl Iterator<Item = Vec<Rational>> {
        (0..1u32 << m).map(move |k| (0..m).map(|i| Rational::from(i64::from(k >> i & 1) * 2 - 1)).collect())
    }

    /// All vertices of {x : A x = b, −1 ≤ x ≤ 1}: for every choice of unknowns at an end, the solutions for the others.
    fn vertices(equations: &[(Vec<Rational>, Rational)], m: usize) -> Vec<Vec<Rational>> {
        let mut found = Vec::new();
        for code in 0..3usize.pow(m as u32) {
            let at = |i: usize| (code / 3usize.pow(i as u32) % 3) as i64 - 1;
            // 0 stands for an unknown that the equations determine.
            let mut rows: Vec<Vec<Rational>> =
                equations.iter().map(|(a, b)| a.iter().cloned().chain([b.clone()]).collect()).collect();
            for i in (0..m).filter(|&i| at(i) != 0) {
                let mut row = vec![Rational::ZERO; m + 1];
                row[i] = Rational::ONE;
                row[m] = Rational::from(at(i));
                rows.push(row);
            }
            let null = crate::linear::matrix::RationalMatrix::new(rows, m + 1).null_space();
            if let [v] = null.as_slice()
                && v[m] != Rational::ZERO
            {
                let x: Vec<Rational> = v[..m].iter().map(|x| -(x / &v[m])).collect();
                if x.iter().all(|x| *x <= Rational::ONE && *x >= -Rational::ONE) {
                    found.push(x);
                }
            }
        }
        found
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]

        /// The maximum is that over all vertices; where there are none, the certificate separates all corners.
        #[test]
        fn optima_agree_with_vertices(r in 1usize..4, m in 1usize..5, entries in prop::collection::vec(-3i8..4, 12), right in prop::collection::vec(-4i8..5, 3), c in prop::collection::vec(-3i8..4, 4)) {
            let equations: Vec<(Vec<Rational>, Rational)> =
                (0..r).map(|i| ((0..m).map(|j| whole(entries[i * m + j])).collect(), whole(right[i]))).collect();
            let c: Vec<Rational> = c[..m].iter().map(|&x| whole(x)).collect();
            let bounds = vec![(Some(-Rational::ONE), Some(Rational::ONE)); m];
            let all = vertices(&equations, m);
            match (Program { equations: equations.clone(), bounds }).maximize(&c).unwrap() {
                Optimum::Found(x) => {
                    prop_assert!(equations.iter().all(|(a, b)| dot(a, &x) == *b));
                    prop_assert!(x.iter().all(|x| *x <= Rational::ONE && *x >= -Rational::ONE));
                    let best = all.iter().map(|v| dot(&c, v)).max().unwrap();
                    prop_assert_eq!(dot(&c, &x), best);
                }
                Optimum::Infeasible(y) => {
                    prop_assert!(all.is_empty());
                    for x in corners(m) {
                        let value = equations.iter().zip(&y).fold(Rational::ZERO, |s, ((a, b), y)| s + y * (dot(a, &x) - b));
                        prop_assert!(value > Rational::ZERO);
                    }
                }
                Optimum::Unbounded => prop_assert!(false, "a box is bounded"),
            }
        }
    }

    /// Without bounds: 1 = 0·x has no solution, x − y = 1 has no greatest x, and with y ≤ 2 the greatest x is 3.
    #[test]
    fn missing_bounds() {
        let [zero, one] = [0, 1].map(whole);
        let free = vec![(None, None); 2];
        let empty = Program { equations: vec![(vec![zero.clone(), zero.clone()], one.clone())], bounds: free.clone() };
        assert!(matches!(empty.maximize(&[one.clone(), zero.clone()]), Some(Optimum::Infeasible(y)) if y[0] < zero));
        let line = vec![(vec![one.clone(), -one.clone()], one.clone())];
        let open = Program { equations: line.clone(), bounds: free };
        assert_eq!(open.maximize(&[one.clone(), zero.clone()]), Some(Optimum::Unbounded));
        let closed = Program { equations: line, bounds: vec![(None, None), (None, Some(whole(2)))] };
        assert_eq!(closed.maximize(&[one, zero]), Some(Optimum::Found(vec![whole(3), whole(2)])));
    }
}
