//! The same work as one writes it for one purpose.

use std::f64::consts::PI;

const GRAVITY: f64 = 9.81;
const MU: f64 = 0.3;

/// `X''`, `θ`, `θ''` of experiment 1.
fn plate(t: f64) -> (f64, f64, f64) {
    let rate = 4.0 * PI;
    let (s, c) = (rate * t).sin_cos();
    let e = (-t).exp();
    let turn = -(1.0 - e) * rate * rate * s + 2.0 * e * rate * c - e * s;
    let tilt = -15.0 * PI / 180.0;
    (0.025 * turn, tilt * (1.0 - e) * s, tilt * turn)
}

fn rates(t: f64, q: &[f64; 6]) -> [f64; 6] {
    let [_, y, phi, vx, vy, w] = *q;
    let (acceleration, theta, turn) = plate(t);
    let ((s, c), (st, ct)) = (phi.sin_cos(), theta.sin_cos());
    let (along, across) = (0.15f64.powi(2) / 4.0, 0.10f64.powi(2) / 4.0);
    let syy = s * s * along + c * c * across;
    let (sx, sy) = (vx.signum(), vy.signum());
    [
        vx,
        vy,
        w,
        -acceleration - sx * MU * GRAVITY,
        -GRAVITY * st - sy * MU * (GRAVITY * ct + y * turn),
        -sx * MU * syy * turn / (along + across),
    ]
}

/// The published plate by the stages of Dormand and Prince in equal steps, the signs by the velocities.
pub(crate) fn published(mut q: [f64; 6], duration: f64, steps: usize) -> [f64; 6] {
    const C: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
    const A: [[f64; 5]; 6] = [
        [0.0; 5],
        [0.2, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0],
        [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    ];
    const B: [f64; 6] = [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
    let h = duration / steps as f64;
    for step in 0..steps {
        let mut k = [[0.0; 6]; 6];
        for i in 0..6 {
            let point = std::array::from_fn(|j| q[j] + h * (0..i).map(|l| A[i][l] * k[l][j]).sum::<f64>());
            k[i] = rates(h * (step as f64 + C[i]), &point);
        }
        q = std::array::from_fn(|j| q[j] + h * (0..6).map(|i| B[i] * k[i][j]).sum::<f64>());
    }
    q
}

const RADIUS: f64 = 0.12;
const STEP: f64 = 1e-3;
/// Greatest friction impulse of a point, per mass.
pub(crate) const BOUND: f64 = MU * GRAVITY * STEP / 48.0;

/// Four rings of 12 cells of equal area.
pub(crate) fn cells() -> [[f64; 2]; 48] {
    std::array::from_fn(|i| {
        let (ring, place) = ((i / 12) as f64, (i % 12) as f64);
        let r = RADIUS * ((ring + 0.5) / 4.0).sqrt();
        let angle = 2.0 * PI * (place + 0.5 * ring) / 12.0;
        [r * angle.cos(), r * angle.sin()]
    })
}

/// Per mass.
pub(crate) fn mass() -> [[f64; 3]; 3] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5 * RADIUS * RADIUS]]
}

/// What the other forces alone would give.
pub(crate) fn free_velocity(way: &str) -> [f64; 3] {
    match way {
        "slides" => [0.05, -0.02, 0.3],
        "turns" => [0.0, 0.0, 0.8],
        _ => [1e-3, 5e-4, 2e-3],
    }
}

/// Newton steps on `½ (v − v*)ᵀ M (v − v*) + Σ c sqrt(|v_i|² + eps²)`.
pub(crate) fn contact(cells: &[[f64; 2]; 48], free: [f64; 3], guess: [f64; 3], iterations: usize) -> [f64; 3] {
    const EPS: f64 = 1e-5;
    let inertia = [1.0, 1.0, 0.5 * RADIUS * RADIUS];
    let mut v = guess;
    for _ in 0..iterations {
        let mut g: [f64; 3] = std::array::from_fn(|j| inertia[j] * (v[j] - free[j]));
        let [mut a, mut b, mut c] = inertia;
        let (mut ab, mut ac, mut bc) = (0.0, 0.0, 0.0);
        for [x, y] in cells {
            let (ux, uy) = (v[0] - v[2] * y, v[1] + v[2] * x);
            let inverse = 1.0 / (ux * ux + uy * uy + EPS * EPS).sqrt();
            let force = BOUND * inverse;
            let (ex, ey) = (ux * inverse, uy * inverse);
            g[0] += force * ux;
            g[1] += force * uy;
            g[2] += force * (uy * x - ux * y);
            let (xx, xy, yy) = (force * (1.0 - ex * ex), -force * ex * ey, force * (1.0 - ey * ey));
            a += xx;
            ab += xy;
            b += yy;
            ac += xy * x - xx * y;
            bc += yy * x - xy * y;
            c += xx * y * y - 2.0 * xy * x * y + yy * x * x;
        }
        // Cramer's rule.
        let (p, q, r) = (b * c - bc * bc, ac * bc - ab * c, ab * bc - ac * b);
        let determinant = a * p + ab * q + ac * r;
        let step = [
            p * g[0] + q * g[1] + r * g[2],
            q * g[0] + (a * c - ac * ac) * g[1] + (ab * ac - a * bc) * g[2],
            r * g[0] + (ab * ac - a * bc) * g[1] + (a * b - ab * ab) * g[2],
        ];
        (0..3).for_each(|j| v[j] -= step[j] / determinant);
    }
    v
}
