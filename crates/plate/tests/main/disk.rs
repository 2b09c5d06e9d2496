//! The disk on its ellipsoidal limit surface (`models/plate_disk.toml`) against contact over the whole footprint.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::driven::Course;
use bracketry_plate::experiment::Experiment;
use bracketry_plate::{AreaObject, DrivenObject, Friction, ModelObject, Object, reduced};
use bracketry_sim::SimulationSettings;
use bracketry_system::System;

const START: [f64; 6] = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Greatest difference in position (m) and yaw (rad) over stretches of half a second that begin in the state of the plant.
fn apart(system: &System, experiment: &Experiment, duration: u32) -> [f64; 2] {
    let contact = AreaContact::new(&Object::REFERENCE, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default());
    let mut plant = AreaObject::new(contact.unwrap()).unwrap();
    plant.set_state(0.0, START).unwrap();
    let truth = experiment.run_on(&mut plant, f64::from(duration)).unwrap().trajectory;
    let mut model = ModelObject::new(system, START, &SimulationSettings::default()).unwrap();
    model.drive(&experiment.drive(0.0)).unwrap();
    let mut greatest = [0.0_f64; 2];
    for half in 0..2 * duration {
        let begin = 0.5 * f64::from(half);
        model.set_state(begin, truth.state_at(begin)).unwrap();
        let (course, outcome) = model.record(begin + 0.5).unwrap();
        assert!(outcome.is_finished(), "{outcome:?}");
        for k in 1..=50 {
            let t = begin + 0.01 * f64::from(k);
            let (a, b) = (course.state_at(t), truth.state_at(t));
            greatest[0] = greatest[0].max((a[0] - b[0]).hypot(a[1] - b[1]));
            greatest[1] = greatest[1].max((a[2] - b[2]).abs());
        }
    }
    greatest
}

#[test]
fn the_disk_moves_as_its_footprint_does() {
    let disk = System::parse("plate_disk.toml", include_str!("../../../../models/plate_disk.toml")).unwrap();
    let experiment = Experiment::orientation();
    let [way, turn] = apart(&disk, &experiment, 4);
    // A twentieth of 0.5 mm, a sixth of 0.3°: what a camera does not see in half a second.
    assert!(way < 2.5e-5 && turn < 0.05_f64.to_radians(), "{way} m, {}°", turn.to_degrees());
    // Friction that does not know of the spin is farther off.
    let without = reduced(&Object::REFERENCE, 0.3, bracketry_plate::model::Terms::default()).unwrap();
    assert!(apart(&without, &experiment, 4)[0] > 5.0 * way);
}
