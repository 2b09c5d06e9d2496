//! The equations of the classic systems in `models/` against energy balances, constraints and laws they were not written from.

use crate::common::read;
use bracketry::symbolic::{Bindings, Expr, Pool};
use bracketry::system::System;

/// d/dt of an expression along the model's equations, the inputs as symbols.
fn rate(system: &mut System, e: Expr) -> Expr {
    let (states, dynamics) = (system.states.clone(), system.dynamics.clone());
    system.pool.lie_derivative(e, &states, &dynamics)
}

/// Decided exactly, as a rank.
fn is_zero(pool: &mut Pool, e: Expr) -> bool {
    pool.rank(&[vec![e]], &Bindings::new()).unwrap().rank == 0
}

/// Whether the rate of `quantity` is `expected`.
fn changes_by(file: &str, quantity: &str, expected: &str) {
    let mut system = read(file);
    let quantity = system.pool.parse(quantity).unwrap();
    let rate = rate(&mut system, quantity);
    let expected = system.pool.parse(expected).unwrap();
    let difference = system.pool.sub(rate, expected);
    assert!(is_zero(&mut system.pool, difference), "{file}: {}", system.pool.text(difference));
}

#[test]
fn energy_changes_by_the_power_of_the_inputs() {
    // Kinetic energy by the velocities of the centers of mass, not by the mass matrix that the equations were solved with.
    let links = "1/2*m1*(lc1*w1)^2 + 1/2*I1*w1^2 + 1/2*I2*(w1 + w2)^2 \
                 + 1/2*m2*((l1*w1*cos(th1) + lc2*(w1 + w2)*cos(th1 + th2))^2 + (l1*w1*sin(th1) + lc2*(w1 + w2)*sin(th1 + th2))^2) \
                 - m1*g*lc1*cos(th1) - m2*g*(l1*cos(th1) + lc2*cos(th1 + th2))";
    changes_by("acrobot", links, "tau*w2");
    changes_by("pendubot", links, "tau*w1");
    changes_by("two_link_arm", links, "tau1*w1 + tau2*w2");
    changes_by("ball_and_beam", "1/2*m*(v^2 + (r*w)^2) + 1/2*Jb*((v/R)^2 + w^2) + 1/2*J*w^2 + m*g*r*sin(th)", "tau*w");
    // The end of the arm is at (r cos phi, r sin phi), the mass l sin(th) beside it and l cos(th) above it.
    changes_by(
        "furuta_pendulum",
        "1/2*J*p^2 + 1/2*m*((r*p + l*cos(th)*q)^2 + (l*sin(th)*p)^2 + (l*sin(th)*q)^2) + m*g*l*cos(th)",
        "tau*p",
    );
    changes_by("reaction_wheel_pendulum", "1/2*J1*w^2 + 1/2*J2*(w + v)^2 + mgl*cos(th)", "tau*v");
    changes_by("flexible_joint", "1/2*I*w1^2 + 1/2*J*w2^2 - mgl*cos(q1) + 1/2*k*(q1 - q2)^2", "u*w2");
    changes_by("tora", "1/2*M*v^2 + 1/2*m*((v + e*w*cos(th))^2 + (e*w*sin(th))^2) + 1/2*I*w^2 + 1/2*k*x^2", "torque*w");
    changes_by("magnetic_levitation", "1/2*m*v^2 - m*g*z + 1/2*(L + 2*C/z)*i^2", "u*i - R*i^2");
    changes_by("spacecraft", "1/2*(J1*w1^2 + J2*w2^2 + J3*w3^2)", "u1*w1 + u2*w2");
    changes_by("duffing", "1/2*v^2 - 1/2*a*x^2 + 1/4*b*x^4", "u*v - d*v^2");
    // The middle of each rod moves with the joint before it; inertias about the middle as in the file.
    let rods = "1/2*m0*v^2 + 1/2*m1*((v + L1/2*w1*cos(th1))^2 + (L1/2*w1*sin(th1))^2) + 1/24*m1*L1^2*w1^2 \
                + 1/2*m2*((v + L1*w1*cos(th1) + L2/2*w2*cos(th2))^2 + (L1*w1*sin(th1) + L2/2*w2*sin(th2))^2) \
                + 1/24*m2*L2^2*w2^2 + m1*g*L1/2*cos(th1) + m2*g*(L1*cos(th1) + L2/2*cos(th2))";
    changes_by("double_pendulum_cart", rods, "u*v");
    changes_by("double_pendulum_cart_rates", rods, "u*v");
    changes_by("race_car", "1/2*m*v^2", "((Cm1 - Cm2*v)*D - Cr2*v^2 - Cr0*tanh(5*v))*v*cos(C1*delta)");
}

#[test]
fn wheels_roll_without_slipping_sideways() {
    // Velocity of the point (x, y) across the direction th.
    let across = |file: &str, x: &str, y: &str, heading: &str| {
        let mut system = read(file);
        let [x, y, s, c] =
            [x, y, &format!("sin({heading})"), &format!("cos({heading})")].map(|t| system.pool.parse(t).unwrap());
        let (dx, dy) = (rate(&mut system, x), rate(&mut system, y));
        let (a, b) = (system.pool.mul(dx, s), system.pool.mul(dy, c));
        let slip = system.pool.sub(a, b);
        assert!(is_zero(&mut system.pool, slip), "{file}, {heading}: {}", system.pool.text(slip));
    };
    across("kinematic_car", "x", "y", "th");
    across("kinematic_car", "x + L*cos(th)", "y + L*sin(th)", "th + delta");
    across("car_with_trailers", "x", "y", "th2");
    across("car_with_trailers", "x + d2*cos(th2)", "y + d2*sin(th2)", "th1");
    across("car_with_trailers", "x + d2*cos(th2) + d1*cos(th1)", "y + d2*sin(th2) + d1*sin(th1)", "th0");
    across("rolling_disk", "x", "y", "th");
    // The rim moves as far as the disk.
    changes_by("rolling_disk", "R*phi", "roll*R");
}

#[test]
fn laws_that_the_equations_were_not_written_from_hold() {
    // Faraday: the flux of the stator changes by the voltage less the drop across the resistance.
    changes_by("induction_motor", "(Ls - M^2/Lr)*ia + M/Lr*fa", "ua - Rs*ia");
    changes_by("induction_motor", "(Ls - M^2/Lr)*ib + M/Lr*fb", "ub - Rs*ib");
    // Water is neither made nor lost but through the outlets of the lower tanks.
    changes_by("quadruple_tank", "A1*(h1 + h3) + A2*(h2 + h4)", "k1*v1 + k2*v2 - a1*sqrt(2*g*h1) - a2*sqrt(2*g*h2)");
    // The center of oscillation is pushed along the axis of the aircraft alone (Martin, Devasia and Paden 1996).
    changes_by("pvtol", "vx - eps*cos(th)*w", "-sin(th)*(u1 - eps*w^2)");
    changes_by("pvtol", "vy - eps*sin(th)*w", "cos(th)*(u1 - eps*w^2) - 1");
    changes_by("lorenz", "z - x^2/(2*s)", "(1 - 8/3/(2*s))*x^2 - 8/3*(z - x^2/(2*s))");
    // Half the tangent of half the angle: |r|² changes by (1 + |r|²) r·w.
    changes_by("spacecraft", "r1^2 + r2^2 + r3^2", "(1 + r1^2 + r2^2 + r3^2)*(r1*w1 + r2*w2 + r3*w3)");
    changes_by("spacecraft", "J3*w3", "(J1 - J2)*w1*w2");
    // What is fed is in the reactor; without cooling, all of the monomer would heat it.
    changes_by("polymerization", "mW + mA + mP", "(wW + wA)*f");
    changes_by("polymerization", "Tad - TR - H*mA/(cR*(mW + mA + mP))", "0");
    // The product does not leave the volume, of which the feed is the only source.
    changes_by("fed_batch_rates", "V*P", "v_p*X*V");
    // B and what becomes of it come from A alone.
    changes_by("klatt_engell_rates", "cB", "-F*cB + k1*exp(-E1/(T + 273.15))*(cA - cB)");
    // Momentum across the chain changes by the forces at its ends and the weight.
    let (first, last) =
        ("D*(1 - L/sqrt(x1^2 + y1^2 + z1^2))", "D*(1 - L/sqrt((x4 - x3)^2 + (y4 - y3)^2 + (z4 - z3)^2))");
    changes_by("chain_of_five_masses", "m*(vx1 + vx2 + vx3)", &format!("{last}*(x4 - x3) - {first}*x1"));
    changes_by("chain_of_five_masses", "m*(vz1 + vz2 + vz3)", &format!("{last}*(z4 - z3) - {first}*z1 - 3*m*g"));
}
