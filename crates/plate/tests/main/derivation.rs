//! Lagrange's equations of a rigid body on the moving plate, derived by code, against the equations as they are stated.

use bracketry_plate::model::{FlatContact, flat_contact};
use bracketry_system::symbolic::{Bindings, Expr};

/// The expression with symbols replaced by what texts say.
fn with(flat: &mut FlatContact, e: Expr, replaced: &[(&str, &str)]) -> Expr {
    let pool = &mut flat.pool;
    let map = replaced.iter().map(|(name, text)| (pool.var(name), pool.parse(text).unwrap())).collect();
    pool.substitute(e, &map)
}

/// Exact zero test of the difference.
fn equal(flat: &mut FlatContact, e: Expr, stated: &str) -> bool {
    let stated = flat.pool.parse(stated).unwrap();
    let difference = flat.pool.sub(e, stated);
    flat.pool.zero_test(difference, &Bindings::new()).is_zero()
}

/// `Sxx`, `Syy`, `Sxy` written out.
fn moments(text: &str) -> String {
    text.replace("Sxx", "(cos(phi)^2*Sa + sin(phi)^2*Sb)")
        .replace("Syy", "(sin(phi)^2*Sa + cos(phi)^2*Sb)")
        .replace("Sxy", "(sin(phi)*cos(phi)*(Sa - Sb))")
}

#[test]
fn motion_in_the_plane() {
    let mut flat = flat_contact();
    let [along, across, yaw] = flat.accelerations;
    assert!(equal(&mut flat, along, "-Xdd + fx"));
    assert!(equal(&mut flat, across, "-g*sin(theta) + y*thetad^2 + h*thetadd + fy"));
    assert!(equal(&mut flat, yaw, &moments("(Sxy*thetad^2 + n)/(Sa + Sb)")));
}

#[test]
fn load_of_the_contact() {
    let mut flat = flat_contact();
    let load = flat.load;
    assert!(equal(&mut flat, load, "g*cos(theta) + y*thetadd + 2*vy*thetad - h*thetad^2"));
    assert!(!equal(&mut flat, load, "g*cos(theta) + y*thetadd - h*thetad^2"));
}

#[test]
fn pressure_of_a_thin_body_is_its_normal_acceleration() {
    let mut flat = flat_contact();
    let pressure = flat.pressure;
    let thin = with(&mut flat, pressure, &[("h", "0"), ("Sc", "0")]);
    assert!(equal(&mut flat, thin, "g*cos(theta) + (y + ry)*thetadd + 2*thetad*(vy + w*rx)"));
}

#[test]
fn thickness_tips_the_pressure_by_friction_and_inertia() {
    // Friction acts at the bottom face: it presses the leading edge down. The thickness resists theta'' as Sc.
    let mut flat = flat_contact();
    let [about_y, about_x] = flat.pressure_moments;
    assert!(equal(&mut flat, about_y, &moments("Sxy*thetadd + 2*thetad*w*Sxx - h*fx")));
    assert!(equal(&mut flat, about_x, &moments("(Syy + Sc)*thetadd + 2*thetad*w*Sxy - h*fy")));
    // A disk: both second moments equal.
    let pressure = flat.pressure;
    let disk = with(&mut flat, pressure, &[("Sa", "S"), ("Sb", "S")]);
    let stated = "g*cos(theta) - h*thetad^2 + 2*thetad*vy + y*thetadd
        + rx*(2*thetad*w - h*fx/S) + ry*((1 + Sc/S)*thetadd - h*fy/S)";
    assert!(equal(&mut flat, disk, &stated.replace('\n', " ")));
}

#[test]
fn the_pressure_has_the_load_and_the_moments_it_was_made_of() {
    let mut flat = flat_contact();
    let (rx, ry) = (flat.pool.symbol("rx"), flat.pool.symbol("ry"));
    let slopes = [flat.pool.diff(flat.pressure, rx), flat.pool.diff(flat.pressure, ry)].map(|e| flat.pool.text(e));
    let [about_y, about_x] = flat.pressure_moments;
    for (moment, row) in [(about_y, "Sxx*({px}) + Sxy*({py})"), (about_x, "Sxy*({px}) + Syy*({py})")] {
        let stated = moments(row).replace("{px}", &slopes[0]).replace("{py}", &slopes[1]);
        assert!(equal(&mut flat, moment, &stated));
    }
}

#[test]
fn contact_forces_alone_change_the_energy() {
    let mut flat = flat_contact();
    let rates = [
        ("x", "vx"),
        ("y", "vy"),
        ("phi", "w"),
        ("X", "Xd"),
        ("Xd", "Xdd"),
        ("theta", "thetad"),
        ("thetad", "thetadd"),
    ];
    let mut variables: Vec<_> = rates.iter().map(|(s, _)| flat.pool.symbol(s)).collect();
    let mut field: Vec<_> = rates.iter().map(|(_, r)| flat.pool.var(r)).collect();
    variables.extend(["vx", "vy", "w"].map(|s| flat.pool.symbol(s)));
    field.extend(flat.accelerations);
    let rate = flat.pool.lie_derivative(flat.energy, &variables, &field);
    let power = flat.pool.text(flat.contact_power);
    assert!(equal(&mut flat, rate, &power));
}

/// Torque of friction on a body that slides along the unit vector (ex, ey) without spin: f = −mu p e everywhere.
fn torque_of_uniform_slip(flat: &mut FlatContact, ex: &str, ey: &str) -> Expr {
    let [about_y, about_x] = flat.pressure_moments.map(|e| flat.pool.text(e));
    flat.pool.parse(&format!("-mu*(({ey})*({about_y}) - ({ex})*({about_x}))")).unwrap()
}

#[test]
fn the_torque_of_uniform_slip_along_x_has_the_sign_opposite_to_the_published_one() {
    let mut flat = flat_contact();
    let torque = torque_of_uniform_slip(&mut flat, "sgn", "0");
    let thin = with(&mut flat, torque, &[("h", "0"), ("Sc", "0")]);
    assert!(equal(&mut flat, thin, &moments("sgn*mu*(Syy*thetadd + (Sa - Sb)*sin(2*phi)*w*thetad)")));
    // Without spin it is the published torque −sgn(x') mu Syy θ'' with the yaw counted clockwise.
    let at_rest = with(&mut flat, thin, &[("w", "0")]);
    assert!(equal(&mut flat, at_rest, &moments("-(-sgn*mu*Syy*thetadd)")));
}

#[test]
fn the_published_torque_is_that_of_a_pressure_falling_where_the_plate_accelerates_upwards() {
    // The published sign would need a pressure whose θ'' part is −ry θ'': a body pressed less where the plate pushes it up.
    let mut flat = flat_contact();
    let thin = {
        let pressure = flat.pressure;
        with(&mut flat, pressure, &[("h", "0"), ("Sc", "0")])
    };
    let (ry, thetadd) = (flat.pool.symbol("ry"), flat.pool.symbol("thetadd"));
    let slope = flat.pool.diff(thin, ry);
    let gain = flat.pool.diff(slope, thetadd);
    assert!(equal(&mut flat, gain, "1"));
}

#[test]
fn thickness_gives_uniform_slip_no_torque_of_friction() {
    // h f is along the slip: the tipped pressure is symmetric about the line of slip. Only Sc θ'' adds to Syy θ''.
    let mut flat = flat_contact();
    let torque = torque_of_uniform_slip(&mut flat, "ex", "ey");
    let sliding = with(&mut flat, torque, &[("fx", "-mu*N*ex"), ("fy", "-mu*N*ey")]);
    let stated = moments("-mu*(ey*(Sxy*thetadd + 2*thetad*w*Sxx) - ex*((Syy + Sc)*thetadd + 2*thetad*w*Sxy))");
    assert!(equal(&mut flat, sliding, &stated));
}

#[test]
fn small_spin_is_damped_by_the_second_moment_along_the_slip() {
    // ∫ (rx fy − ry fx) of f = −mu g cos(theta) v_r/|v_r|, to first order in w, by the second moments of rx, ry.
    let mut flat = flat_contact();
    let pool = &mut flat.pool;
    let speed = "sqrt((vx - w*ry)^2 + (vy + w*rx)^2)";
    let torque = format!("-mu*g*cos(theta)*(rx*(vy + w*rx) - ry*(vx - w*ry))/{speed}");
    let torque = pool.parse(&torque).unwrap();
    let (w, rx, ry) = (pool.symbol("w"), pool.symbol("rx"), pool.symbol("ry"));
    let slope = pool.diff(torque, w);
    let zero = pool.int(0);
    let at_rest = [(pool.sym(w), zero)].into_iter().collect();
    let slope = pool.substitute(slope, &at_rest);
    let mut total = zero;
    for (a, b, moment) in [(rx, rx, "Sxx/2"), (rx, ry, "Sxy"), (ry, ry, "Syy/2")] {
        let first = pool.diff(slope, a);
        let second = pool.diff(first, b);
        let moment = pool.parse(moment).unwrap();
        let term = pool.mul(second, moment);
        total = pool.add(total, term);
    }
    let stated = "-mu*g*cos(theta)*(vx^2*Sxx + 2*vx*vy*Sxy + vy^2*Syy)/sqrt(vx^2 + vy^2)^3";
    assert!(equal(&mut flat, total, stated));
}
