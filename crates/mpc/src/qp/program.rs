//! The quadratic program stage by stage, before anything is eliminated and in no solver's format.

/// An entry that stands nowhere: x_0 does not change.
pub(super) const NOWHERE: usize = usize::MAX;

/// What a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// A bound of something, the only one or the first.
    First,
    /// The bound of the same from the other side: entries of the other sign but for the slack.
    OppositeOf(usize),
    /// That of a slack.
    SlackBound,
}

/// The quadratic program of one iteration.
///
/// Variables are the changes dx_k (1 ≤ k ≤ N; dx_0 = 0) and du_k (0 ≤ k < N), and slacks s:
///
/// ```text
/// min  ½ zᵀHz + gᵀz                    z = (du_0, dx_1, s_1, du_1, …, dx_N, s_N)
/// s.t. dx_{k+1} = A_k dx_k + B_k du_k + c_k
///      du_k = du_{b(k)} + o_k           input by input, for intervals k that share that of the first of their block, b(k) < k,
///                                       and for inputs that share that of another branch of a scenario tree
///      r − Rz ∈ K                       K a product of a nonnegative orthant and second-order cones
/// ```
///
/// The blocks A_k, B_k stand in the `flow` that comes with it: N blocks of n rows of n + m entries (A_k, B_k), row by row.
#[derive(Clone, Debug, Default)]
pub struct StageProgram {
    pub(crate) states: usize,
    pub(crate) inputs: usize,
    pub(crate) steps: usize,
    /// Entries of a flow block that can differ from zero.
    pub(crate) flow_pattern: Vec<bool>,
    /// Number of the first variable of every grid point 0 … N, and the number of variables.
    pub(crate) first: Vec<usize>,
    /// Number of slacks at every grid point.
    pub(crate) slacks: Vec<usize>,
    /// c_k, N rows of n.
    pub(crate) defect: Vec<f64>,
    /// b(k) of every interval, N rows of m.
    pub(crate) block_start: Vec<usize>,
    /// Input of the same interval that each input is equal to, itself where it is free, N rows of m.
    pub(crate) shared_with: Vec<usize>,
    /// o_k, N rows of m.
    pub(crate) offset: Vec<f64>,
    /// Places (i ≤ j) of H: the whole diagonal first.
    pub(crate) hessian_places: Vec<(usize, usize)>,
    pub(crate) hessian: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
    /// Places (row, variable) of R.
    pub(crate) row_places: Vec<(usize, usize)>,
    pub(crate) rows: Vec<f64>,
    pub(crate) right: Vec<f64>,
    /// Typical size of every variable and of the residual of every row; rows of one cone share one.
    pub(crate) scale: Vec<f64>,
    pub(crate) row_scale: Vec<f64>,
    /// Typical size of what the step changes in the objective.
    pub(crate) objective_scale: f64,
    /// Grid point of every row, and what it is.
    pub(crate) row_stage: Vec<usize>,
    pub(crate) sides: Vec<Side>,
    /// Rows of the orthant, which come first.
    pub(crate) nonnegative: usize,
    /// Dimensions of the second-order cones, in order.
    pub(crate) second_order: Vec<usize>,
}

impl StageProgram {
    /// Number of states n.
    pub fn states(&self) -> usize {
        self.states
    }
    /// Number of inputs m.
    pub fn inputs(&self) -> usize {
        self.inputs
    }
    /// Number of intervals N.
    pub fn steps(&self) -> usize {
        self.steps
    }
    /// Number of variables z.
    pub fn variables(&self) -> usize {
        self.gradient.len()
    }
    /// Number of state i in dx_k, 1 ≤ k ≤ N.
    pub fn state(&self, k: usize, i: usize) -> usize {
        self.first[k] + i
    }
    /// Number of a slack of grid point k.
    pub fn slack(&self, k: usize, place: usize) -> usize {
        self.first[k] + if k == 0 { 0 } else { self.states } + place
    }
    /// Number of input j in du_k, 0 ≤ k < N.
    pub fn input(&self, k: usize, j: usize) -> usize {
        self.slack(k, self.slacks[k]) + j
    }
    /// Number of variable v of the list (x, u) at grid point k; `None` for x_0, which is fixed.
    pub fn variable(&self, k: usize, v: usize) -> Option<usize> {
        if v >= self.states {
            Some(self.input(k, v - self.states))
        } else if k > 0 {
            Some(self.state(k, v))
        } else {
            None
        }
    }
    /// Grid point of a variable.
    pub(super) fn grid_point(&self, variable: usize) -> usize {
        self.first.partition_point(|&first| first <= variable) - 1
    }
    /// Number, in the list (x, u) at grid point k, of a variable there; `None` for a slack.
    pub(super) fn place_of(&self, k: usize, variable: usize) -> Option<usize> {
        let slacks = self.slack(k, 0)..self.slack(k, self.slacks[k]);
        (!slacks.contains(&variable)).then(|| self.place_at(k, variable))
    }
    /// Number, in the list (x, u) at grid point k < N, of a variable that is a state or input there.
    pub(super) fn place_at(&self, k: usize, variable: usize) -> usize {
        let input = self.input(k, 0);
        if variable >= input { self.states + variable - input } else { variable - self.first[k] }
    }
    /// Places (row, column), row ≤ column, and values of the upper triangle of H.
    pub fn hessian(&self) -> impl Iterator<Item = ((usize, usize), f64)> {
        self.hessian_places.iter().copied().zip(self.hessian.iter().copied())
    }
    /// g.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
    /// Places (row, column) and values of R.
    pub fn rows(&self) -> impl Iterator<Item = ((usize, usize), f64)> {
        self.row_places.iter().copied().zip(self.rows.iter().copied())
    }
    /// r.
    pub fn right_hand_side(&self) -> &[f64] {
        &self.right
    }
    /// Typical size of every variable.
    pub fn scales(&self) -> &[f64] {
        &self.scale
    }
    /// Typical size of what the step changes in the objective.
    pub fn objective_scale(&self) -> f64 {
        self.objective_scale
    }
    /// Typical size of the residual of every row; rows of one cone share one.
    pub fn row_scales(&self) -> &[f64] {
        &self.row_scale
    }
    /// Number of rows in the nonnegative orthant, which come first, and the dimensions of the second-order cones after it.
    pub fn cones(&self) -> (usize, &[usize]) {
        (self.nonnegative, &self.second_order)
    }
    /// c_k, N rows of n.
    pub fn defects(&self) -> &[f64] {
        &self.defect
    }
    /// First interval b(k) of the block of interval k for input j, and o_k: du_k = du_{b(k)} + o_k when b(k) < k.
    pub fn block(&self, k: usize, j: usize) -> (usize, f64) {
        (self.block_start[k * self.inputs + j], self.offset[k * self.inputs + j])
    }
    /// Number of the variable that input j in du_k is equal to but for o_k; none where it is free.
    pub(super) fn equal_input(&self, k: usize, j: usize) -> Option<usize> {
        let (start, shared) = (self.block_start[k * self.inputs + j], self.shared_with[k * self.inputs + j]);
        if start < k { Some(self.input(start, j)) } else { (shared != j).then(|| self.input(k, shared)) }
    }
    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let all = [&self.hessian, &self.gradient, &self.rows, &self.right, &self.defect, &self.offset];
        all.iter().all(|v| v.iter().all(|x| x.is_finite()))
    }
}
