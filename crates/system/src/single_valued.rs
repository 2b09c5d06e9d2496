//! The equations with one value where they are set-valued, for code outside that knows functions only.

use bracketry_symbolic::{Expr, Func, Node};
use rustc_hash::FxHashMap;

use crate::directions::Directions;
use crate::system::System;

/// Equations and outputs in which `sign` and unit vectors are 0 where they are set-valued; see [`System::single_valued`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SingleValued {
    /// Time derivatives of the states.
    pub dynamics: Vec<Expr>,
    /// The outputs, in the order of the system.
    pub outputs: Vec<Expr>,
    /// The arguments of `sign`, in order of appearance, as they are written.
    pub signs: Vec<Expr>,
    /// The components of each unit vector, as they are written.
    pub unit_vectors: Vec<Vec<Expr>>,
    /// Whether there is an `abs`, `min`, or `max`, whose slope jumps.
    pub kinks: bool,
}

impl System {
    /// The equations with the value 0 for `sign(σ)` where σ = 0, and for a unit vector σ/|σ| where σ = 0, which is 0/0 as it
    /// is written. Their derivatives are 0 there, too. Everywhere else nothing changes. Quotients that are no friction, such as
    /// the direction of a spring, stay as they are written, without a value where σ = 0.
    ///
    /// The component `σ_i/√S`, S = σ², becomes `s·σ_i/√(S + (1 − s)²)` with `s = sign(S)`, which is the same number where
    /// S > 0, to the last bit.
    ///
    /// ```
    /// use bracketry_system::System;
    /// let text = "states = ['v', 'w']\ndynamics = { v = '-unit(v, w)', w = '-unit(w, v) - sign(w)' }\n";
    /// let mut block = System::parse("block.toml", text).unwrap();
    /// let at_rest = block.single_valued();
    /// let tape = block.compile(&block.states.clone(), &at_rest.dynamics).unwrap();
    /// let mut rates = [f64::NAN; 2];
    /// tape.eval(&[0.0, 0.0], &mut Vec::new(), &mut rates);
    /// assert_eq!((rates, at_rest.signs.len(), at_rest.unit_vectors.len()), ([0.0, 0.0], 1, 1));
    /// ```
    pub fn single_valued(&mut self) -> SingleValued {
        let rows: Vec<Expr> = self.dynamics.iter().copied().chain(self.outputs.iter().map(|(_, e)| *e)).collect();
        let (mut signs, mut kinks) = (Vec::new(), false);
        for e in self.pool.reachable(&rows) {
            match self.pool.node(e) {
                Node::Call(Func::Sign, a) => signs.push(a),
                node => kinks |= crate::switching::is_switch(node),
            }
        }
        let Directions { singular, continuous, .. } = self.directions(&rows);
        let singular: Vec<Expr> = singular.iter().map(|r| r.square).collect();
        let (rows, roots) = self.rewrite_unit_vectors(&rows, &singular, |_, _| true);
        let (mut values, mut unit_vectors) = (FxHashMap::default(), Vec::new());
        for root in &roots {
            let pool = &mut self.pool;
            let one = pool.int(1);
            let moves = pool.call(Func::Sign, root.square);
            let rests = pool.sub(one, moves);
            let rests = pool.powi(rests, 2);
            let positive = pool.add(root.square, rests);
            let size = pool.sqrt(positive);
            for (component, &direction) in root.components.iter().zip(&root.directions) {
                let along = pool.mul(component.scale, component.base);
                let along = pool.mul(moves, along);
                let (direction, value) = (pool.sym(direction), pool.div(along, size));
                values.insert(direction, value);
            }
            if !continuous.contains(&root.square) {
                unit_vectors.push(root.components.iter().map(|c| c.base).collect());
            }
        }
        let mut dynamics = self.pool.substitute_all(&rows, &values);
        let outputs = dynamics.split_off(self.dynamics.len());
        SingleValued { dynamics, outputs, signs, unit_vectors, kinks }
    }
}
