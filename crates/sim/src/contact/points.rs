//! Contact points with dry friction, stored lane by lane.

/// Points treated at once; the arithmetic of a chunk vectorizes.
pub(super) const LANES: usize = 4;
/// One number of each point of a chunk.
pub(super) type Chunk = [f64; LANES];

/// Contact points of a body with `N` velocity coordinates: two rows `J_i` that give the slip velocity `J_i v`, and the
/// greatest friction impulse `c_i`.
///
/// Friction whose limit surface is an ellipse has the norm `|D J_i v|`: pass the rows `D J_i`.
#[derive(Debug, Clone, Default)]
pub struct FrictionPoints<const N: usize> {
    /// `rows[k][j]`: entry `j` of row 0 (`k = 0`) or 1 of every point.
    chunks: Vec<PointChunk<N>>,
    len: usize,
}

/// Rows and bounds of [`LANES`] points. What is beyond the last point is zero and takes part in nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointChunk<const N: usize> {
    pub(super) rows: [[Chunk; N]; 2],
    pub(super) bound: Chunk,
}

/// Value, gradient and Hessian of `Σ c_i sqrt(|J_i v|² + eps²)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smoothed<const N: usize> {
    pub(super) value: f64,
    pub(super) gradient: [f64; N],
    pub(super) hessian: [[f64; N]; N],
}

impl<const N: usize> FrictionPoints<N> {
    /// No points yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Removes all points; the memory is kept.
    pub fn clear(&mut self) {
        self.chunks.clear();
        self.len = 0;
    }

    /// Adds a point with the rows of `J_i` and the greatest impulse `c_i`.
    pub fn push(&mut self, rows: [[f64; N]; 2], bound: f64) {
        if self.len.is_multiple_of(LANES) {
            self.chunks.push(PointChunk { rows: [[[0.0; LANES]; N]; 2], bound: [0.0; LANES] });
        }
        self.len += 1;
        self.set(self.len - 1, rows, bound);
    }

    /// Sets rows and bound of the point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn set(&mut self, index: usize, rows: [[f64; N]; 2], bound: f64) {
        let lane = index % LANES;
        let chunk = &mut self.chunks[index / LANES];
        for (to, from) in chunk.rows.iter_mut().zip(rows) {
            for (to, from) in to.iter_mut().zip(from) {
                to[lane] = from;
            }
        }
        chunk.bound[lane] = bound;
    }

    /// Sets the greatest impulse of the point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn set_bound(&mut self, index: usize, bound: f64) {
        self.chunks[index / LANES].bound[index % LANES] = bound;
    }

    /// Greatest impulse of the point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn bound(&self, index: usize) -> f64 {
        self.chunks[index / LANES].bound[index % LANES]
    }

    /// Rows of the point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn rows(&self, index: usize) -> [[f64; N]; 2] {
        let chunk = &self.chunks[index / LANES];
        chunk.rows.map(|row| row.map(|entry| entry[index % LANES]))
    }

    /// Slip velocity `J_i v` of the point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn slip(&self, index: usize, v: &[f64; N]) -> [f64; 2] {
        self.rows(index).map(|row| row.iter().zip(v).map(|(j, v)| j * v).sum())
    }

    /// What friction dissipates in a step that ends with the velocity `v`, `Σ c_i |J_i v|`.
    pub fn dissipation(&self, v: &[f64; N]) -> f64 {
        self.chunks.iter().map(|chunk| chunk.dissipation(v)).sum()
    }

    pub(super) fn chunks_mut(&mut self) -> &mut [PointChunk<N>] {
        &mut self.chunks
    }

    /// The first point with an entry that is not finite, or a bound that is not finite or negative; none if all are valid.
    pub(super) fn invalid(&self) -> Option<usize> {
        let bad = |chunk: &PointChunk<N>| {
            let mut worst = true;
            for row in chunk.rows.iter().flatten().flatten() {
                worst &= row.is_finite();
            }
            for bound in chunk.bound {
                worst &= bound.is_finite() && bound >= 0.0;
            }
            !worst
        };
        let chunk = self.chunks.iter().position(bad)?;
        (chunk * LANES..self.len).find(|&i| {
            let finite = self.rows(i).iter().flatten().all(|j| j.is_finite());
            !(finite && self.bound(i).is_finite() && self.bound(i) >= 0.0)
        })
    }

    /// Greatest and least slip speed of the points with a positive bound; `(0, ∞)` if there is none.
    pub(super) fn speeds(&self, v: &[f64; N]) -> (f64, f64) {
        let mut range = (0.0f64, f64::INFINITY);
        for chunk in &self.chunks {
            let speed = chunk.speed(v);
            for lane in 0..LANES {
                if chunk.bound[lane] > 0.0 {
                    range = (range.0.max(speed[lane]), range.1.min(speed[lane]));
                }
            }
        }
        range
    }

    /// With `λ_i = c_i J_i v/sqrt(|J_i v|² + eps²)`: what is dissipated less than with the bounds,
    /// `Σ c_i |J_i v| − λ_i · J_i v`, and the impulse `Σ J_iᵀ λ_i`.
    pub(super) fn impulse(&self, v: &[f64; N], eps: f64) -> (f64, [f64; N]) {
        let mut loss = [0.0; LANES];
        let mut impulse = [[0.0; LANES]; N];
        for chunk in &self.chunks {
            let [jx, jy] = &chunk.rows;
            let [ux, uy] = chunk.slips(v);
            let mut factor = [0.0; LANES];
            for l in 0..LANES {
                let squared = ux[l] * ux[l] + uy[l] * uy[l];
                let norm = (squared + eps * eps).sqrt() + f64::MIN_POSITIVE;
                factor[l] = chunk.bound[l] / norm;
                loss[l] += chunk.bound[l] * squared.sqrt() - factor[l] * squared;
            }
            for i in 0..N {
                for l in 0..LANES {
                    impulse[i][l] += factor[l] * (jx[i][l] * ux[l] + jy[i][l] * uy[l]);
                }
            }
        }
        (total(loss).max(0.0), impulse.map(total))
    }

    /// Value, gradient and Hessian of `Σ c_i sqrt(|J_i v|² + eps²)`. Without smoothing a point at rest has no part in the
    /// derivatives.
    pub(super) fn smoothed(&self, v: &[f64; N], eps: f64) -> Smoothed<N> {
        let mut value = [0.0; LANES];
        let mut gradient = [[0.0; LANES]; N];
        let mut hessian = [[[0.0; LANES]; N]; N];
        let squared = eps * eps;
        for chunk in &self.chunks {
            let [jx, jy] = &chunk.rows;
            let [ux, uy] = chunk.slips(v);
            let mut factor = [0.0; LANES];
            let (mut xx, mut xy, mut yy) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let norm2 = ux[l] * ux[l] + uy[l] * uy[l] + squared;
                let norm = norm2.sqrt();
                // Only a point at rest without smoothing has norm 0; adding the least positive number changes no other.
                let inverse = 1.0 / (norm + f64::MIN_POSITIVE);
                value[l] += chunk.bound[l] * norm;
                factor[l] = chunk.bound[l] * inverse;
                let (ex, ey, rest) = (ux[l] * inverse, uy[l] * inverse, eps * inverse);
                let rest2 = rest * rest;
                xx[l] = factor[l] * (ey * ey + rest2);
                xy[l] = -factor[l] * ex * ey;
                yy[l] = factor[l] * (ex * ex + rest2);
            }
            for i in 0..N {
                let (mut px, mut py) = ([0.0; LANES], [0.0; LANES]);
                for l in 0..LANES {
                    gradient[i][l] += factor[l] * (jx[i][l] * ux[l] + jy[i][l] * uy[l]);
                    px[l] = xx[l] * jx[i][l] + xy[l] * jy[i][l];
                    py[l] = xy[l] * jx[i][l] + yy[l] * jy[i][l];
                }
                for j in 0..=i {
                    for l in 0..LANES {
                        hessian[i][j][l] += jx[j][l] * px[l] + jy[j][l] * py[l];
                    }
                }
            }
        }
        let mut result = Smoothed { value: total(value), gradient: gradient.map(total), hessian: [[0.0; N]; N] };
        for i in 0..N {
            for j in 0..=i {
                result.hessian[i][j] = total(hessian[i][j]);
                result.hessian[j][i] = result.hessian[i][j];
            }
        }
        result
    }
}

fn total(chunk: Chunk) -> f64 {
    (chunk[0] + chunk[1]) + (chunk[2] + chunk[3])
}

impl<const N: usize> PointChunk<N> {
    pub(super) fn slips(&self, v: &[f64; N]) -> [Chunk; 2] {
        let mut slips = [[0.0; LANES]; 2];
        for (slip, row) in slips.iter_mut().zip(&self.rows) {
            for (entry, v) in row.iter().zip(v) {
                for l in 0..LANES {
                    slip[l] += entry[l] * v;
                }
            }
        }
        slips
    }

    pub(super) fn speed(&self, v: &[f64; N]) -> Chunk {
        let [ux, uy] = self.slips(v);
        std::array::from_fn(|l| (ux[l] * ux[l] + uy[l] * uy[l]).sqrt())
    }

    fn dissipation(&self, v: &[f64; N]) -> f64 {
        self.speed(v).iter().zip(self.bound).map(|(speed, bound)| speed * bound).sum()
    }
}
