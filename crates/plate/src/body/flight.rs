//! Free flight: a parabola and a torque-free rotation.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::frame::RigidState;

/// Largest rotation in one step of the rotation, in rad. With it the sixth-order method errs by less than 1e-12 a step.
const LARGEST_ROTATION: f64 = 0.1;

/// Positions of the stages of the three-stage Gauss method.
fn gauss() -> [[f64; 3]; 3] {
    let r = 15.0_f64.sqrt();
    [
        [5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0],
        [5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0],
        [5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0],
    ]
}

/// The state in the world a time `dt` later, in free flight under gravity `-gravity` along z.
///
/// The center of mass follows its parabola exactly. Euler's equations `L' = L × J⁻¹L` for the angular momentum in the axes
/// of the body are integrated by the three-stage Gauss method (order 6), which keeps the quadratic invariants `|L|²` and
/// `L·J⁻¹L`; the orientation follows by the sixth-order Magnus expansion on the same stages (Blanes, Casas, and Ros 2000),
/// and is rotated by the last rounding error so that the angular momentum in the world is preserved.
pub(super) fn fly(
    start: &RigidState,
    dt: f64,
    gravity: f64,
    inertia: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
) -> RigidState {
    let fall = Vector3::new(0.0, 0.0, -gravity * dt);
    let position = start.position + (start.velocity + 0.5 * fall) * dt;
    let velocity = start.velocity + fall;
    let mut orientation = start.orientation;
    let mut spin = orientation.inverse() * start.angular_velocity;
    let mut momentum = inertia * spin;
    let in_world = orientation * momentum;
    let steps = (spin.norm() * dt.abs() / LARGEST_ROTATION).ceil().max(1.0);
    let h = dt / steps;
    for _ in 0..steps as usize {
        (momentum, orientation) = rotate(momentum, orientation, h, inverse);
        let now = orientation * momentum;
        let squared = now.norm_squared();
        if squared > 0.0 {
            orientation = UnitQuaternion::from_scaled_axis(now.cross(&in_world) / squared) * orientation;
            orientation.renormalize();
        }
    }
    spin = inverse * momentum;
    RigidState { position, orientation, velocity, angular_velocity: orientation * spin }
}

/// One step of the torque-free rotation: momentum in the axes of the body, orientation.
fn rotate(
    momentum: Vector3<f64>,
    orientation: UnitQuaternion<f64>,
    h: f64,
    inverse: &Matrix3<f64>,
) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let rate = |l: &Vector3<f64>| l.cross(&(inverse * l));
    let weights = gauss();
    let mut slopes = [rate(&momentum); 3];
    let mut stages = [momentum; 3];
    for _ in 0..50 {
        let mut change = 0.0_f64;
        for i in 0..3 {
            let next = momentum + h * (0..3).map(|j| weights[i][j] * slopes[j]).sum::<Vector3<f64>>();
            change = change.max((next - stages[i]).amax());
            stages[i] = next;
        }
        slopes = [rate(&stages[0]), rate(&stages[1]), rate(&stages[2])];
        if change <= 1e-16 * momentum.amax() {
            break;
        }
    }
    let next = momentum + h * (5.0 * slopes[0] + 8.0 * slopes[1] + 5.0 * slopes[2]) / 18.0;
    // R' = R ω̂, so Rᵀ' = -ω̂ Rᵀ: the expansion for Y' = A Y with A = -ω̂, commutators being cross products.
    let [a1, a2, a3] = stages.map(|l| -(inverse * l));
    let first = h * a2;
    let second = (h * 15.0_f64.sqrt() / 3.0) * (a3 - a1);
    let third = (h * 10.0 / 3.0) * (a3 - 2.0 * a2 + a1);
    let c1 = first.cross(&second);
    let c2 = -first.cross(&(2.0 * third + c1)) / 60.0;
    let rotation = first + third / 12.0 + (-20.0 * first - third + c1).cross(&(second + c2)) / 240.0;
    (next, orientation * UnitQuaternion::from_scaled_axis(-rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_and_angular_momentum_are_kept_for_a_minute_of_tumbling() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0e-3, 2.0e-3, 2.9e-3));
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0e3, 0.5e3, 1.0 / 2.9e-3));
        let mut state = RigidState::at_rest(0.0);
        state.angular_velocity = Vector3::new(0.1, 20.0, 0.2);
        state.velocity = Vector3::new(1.0, -2.0, 300.0);
        let of = |s: &RigidState| {
            let body = s.orientation.inverse() * s.angular_velocity;
            let l = inertia * body;
            (s.orientation * l, 0.5 * l.dot(&body))
        };
        let (before, energy) = of(&state);
        for _ in 0..60 {
            state = fly(&state, 1.0, 9.81, &inertia, &inverse);
        }
        let (after, later) = of(&state);
        assert!((after - before).norm() < 1e-12 * before.norm());
        assert!((later - energy).abs() < 1e-11 * energy, "{}", (later - energy) / energy);
        assert!((state.position - Vector3::new(60.0, -120.0, 300.0 * 60.0 - 0.5 * 9.81 * 3600.0)).norm() < 1e-8);
    }

    #[test]
    fn a_symmetric_top_precesses_as_its_closed_form_says() {
        // J = diag(A, A, C): in the body ω turns about z at (C - A)/A ω_z; in the world the axis turns about L at |L|/A.
        let (a, c) = (2.0e-3, 3.5e-3);
        let inertia = Matrix3::from_diagonal(&Vector3::new(a, a, c));
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0 / a, 1.0 / a, 1.0 / c));
        let mut state = RigidState::at_rest(0.0);
        state.angular_velocity = Vector3::new(3.0, 0.0, 11.0);
        let momentum = inertia * state.angular_velocity;
        let dt = 2.7;
        let end = fly(&state, dt, 0.0, &inertia, &inverse);
        let precession = UnitQuaternion::from_scaled_axis(momentum * (dt / a));
        let spin = UnitQuaternion::from_scaled_axis(Vector3::z() * (state.angular_velocity.z * (1.0 - c / a) * dt));
        assert!(
            end.orientation.angle_to(&(precession * spin)) < 1e-9,
            "{}",
            end.orientation.angle_to(&(precession * spin))
        );
    }
}
