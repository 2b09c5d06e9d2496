//! Motion from rest to rest under dry friction.

use crate::common::model;
use bracketry_steer::from_rest::{Answer, Bound, FromRest, FromRestOptions, Motion, Proof, from_rest};
use bracketry_system::System;

fn within(system: &System, bounds: &str) -> FromRest {
    let options = FromRestOptions { bounds: Bound::list(bounds).unwrap(), ..FromRestOptions::default() };
    from_rest(system, &options).unwrap()
}

#[test]
fn debug() {
    for (name, bounds) in [
        ("shaken_table", "der(X,2)=-4..4"),
        ("shaken_table", "der(X,2)=-2.943..2.943"),
        ("shaken_table", "der(X,2)=-2..2.944"),
        ("vibrating_bowl", "der(X,2)=-4..4,der(Y,2)=-4..4"),
        ("cart_on_tilting_beam", "der(theta,2)=-20..20"),
        ("cart_on_tilting_beam", "der(theta,2)=-2..2,theta=-0.1..0.1"),
        ("plate_published", "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20"),
        ("plate_published", "der(X,2)=-2..2,theta=-0.2..0.2,der(theta,2)=-20..20"),
        ("plate_point", "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20"),
        ("plate_point", "der(X,2)=-2..2,theta=-0.1..0.1,der(theta,2)=-5..5"),
        ("plate_reduced", "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20"),
        ("spring_mass_friction", "u=-1..1"),
    ] {
        let start = std::time::Instant::now();
        let mut found = within(&model(name), bounds);
        for s in &mut found.strokes {
            s.signals.times.clear();
            s.signals.values.clear();
        }
        println!("== {name} {bounds} {:?}\n{found:#?}", start.elapsed());
    }
}
