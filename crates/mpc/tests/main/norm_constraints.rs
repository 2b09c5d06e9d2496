//! Bounds on norms in converged solutions.

use crate::common::noise::Noise;
use crate::common::reports::run;
use bracketry_mpc::problem::ClosedLoopReport;

/// A permanent-magnet motor: currents, and the speed.
const MOTOR: &str = "states = [\"id\", \"iq\", \"w\"]\ninputs = [\"ud\", \"uq\"]\n\
    parameters = { R = 0.5, L = 0.005, psi = 0.1, p = 3, J = 0.005, B = 0.001 }\n\
    dynamics = { id = \"(ud - R*id + p*w*L*iq)/L\", iq = \"(uq - R*iq - p*w*L*id - p*w*psi)/L\", w = \"(1.5*p*psi*iq - B*w)/J\" }";

/// A craft in the plane that is pushed in two directions, with drag.
const CRAFT: &str = "states = [\"x\", \"y\", \"vx\", \"vy\"]\ninputs = [\"fx\", \"fy\", \"n\"]\n\
    dynamics = { x = \"vx\", y = \"vy\", vx = \"fx - 0.2*vx*abs2\", vy = \"fy - 0.2*vy*abs2\" }\n\
    definitions = { abs2 = \"vx^2 + vy^2\" }";

fn close(norm: &ClosedLoopReport, squared: &ClosedLoopReport, share: f64) {
    assert!(norm.succeeded && squared.succeeded, "{norm:?} {squared:?}");
    for (a, b) in [(norm.open_loop_cost, squared.open_loop_cost), (norm.closed_loop_cost, squared.closed_loop_cost)] {
        assert!((a / b - 1.0).abs() < share, "{a} {b}");
    }
}

/// ‖u‖ ≤ h and ‖u‖² ≤ h² have the same solutions.
#[test]
fn a_norm_is_as_good_as_its_square() {
    let mut noise = Noise::new(9);
    for _ in 0..3 {
        let (most, speed) = (25.0 + 10.0 * noise.uniform(), 60.0 + 60.0 * noise.uniform());
        let of = |constraint: &str| {
            let text = format!(
                "horizon = {{ steps = 40, dt = 0.001 }}\n\
                 cost = {{ stage = \"(w - {speed:?})^2/100 + 0.001*(id^2 + iq^2)\", terminal = \"(w - {speed:?})^2/100\" }}\n\
                 run = {{ steps = 40 }}\nconstraints = {{ voltage = {constraint} }}"
            );
            run(MOTOR, &text)
        };
        let norm = of(&format!("{{ norm = [\"ud\", \"uq\"], max = {most:?} }}"));
        let squared = of(&format!("{{ expression = \"ud^2 + uq^2\", max = {:?} }}", most * most));
        close(&norm, &squared, 1e-3);
        assert_eq!(norm.method, "sqp", "{norm:?}");
        assert_eq!(norm.status.inaccurate, 0);
        assert!(norm.constraint_violation_max < 1e-6 * most, "{norm:?}");
    }
}

/// A limit that depends on an input, a limit of a state, and a norm that vanishes on the way.
#[test]
fn norms_with_limits_of_any_kind_are_kept() {
    let mut noise = Noise::new(4);
    for _ in 0..3 {
        let (friction, fast) = (0.3 + 0.5 * noise.uniform(), 0.5 + 0.5 * noise.uniform());
        let (a, b) = (1.0 + noise.uniform(), -1.0 + noise.uniform());
        let of = |cone: &str, speed: &str| {
            let text = format!(
                "horizon = {{ steps = 40, dt = 0.1 }}\n\
                 cost = {{ stage = \"(x - {a:?})^2 + (y - {b:?})^2 + 0.1*(vx^2 + vy^2) + 0.01*n^2\" }}\n\
                 constraints = {{ n = {{ min = 0, max = 3 }}, cone = {cone}, speed = {speed} }}\nrun = {{ steps = 60 }}"
            );
            run(CRAFT, &text)
        };
        let norm = of(
            &format!("{{ norm = [\"fx\", \"fy\"], max = \"{friction:?}*n\" }}"),
            &format!("{{ norm = [\"vx\", \"vy\"], max = {fast:?}, hard = true }}"),
        );
        let squared = of(
            &format!("{{ expression = \"fx^2 + fy^2 - {:?}*n^2\", max = 0 }}", friction * friction),
            &format!("{{ expression = \"vx^2 + vy^2\", max = {:?}, hard = true }}", fast * fast),
        );
        close(&norm, &squared, 2e-3);
        assert!(norm.constraint_violation_max < 1e-4, "{norm:?}");
    }
}
