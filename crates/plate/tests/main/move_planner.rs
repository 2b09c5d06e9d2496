//! Moves planned beforehand, played on the object with exact friction.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::control::{Command, MovePlanner, PlannedMove, PlanningBudget, PlateLimits};
use bracketry_plate::{Friction, Object, PlateKinematics, Shape};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::TAU;

const ELLIPSE: Object = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
const MU: f64 = 0.3;

fn budget(programs: usize) -> PlanningBudget {
    PlanningBudget { programs, seconds: f64::INFINITY }
}

/// Where the object lies after the move, on a plant with more contact points and smaller steps than the planner's, and whether the plate kept
/// its bounds.
fn played(object: &Object, start: [f64; 3], planned: &PlannedMove, limits: &PlateLimits) -> [f64; 3] {
    let settings = AreaSettings::default().with_step(1e-3).with_points(48);
    let mut contact = AreaContact::new(object, &Friction::Coulomb { mu: MU }, &settings).unwrap();
    let [x, y, phi] = start;
    contact.set_state([x, y, phi, 0.0, 0.0, 0.0]).unwrap();
    let mut plate = PlateKinematics::default();
    let interval = planned.duration / planned.accelerations.len() as f64;
    for &[along, turning] in &planned.accelerations {
        assert!(along.abs() <= limits.displacement_acceleration && turning.abs() <= limits.tilt_acceleration);
        let command = Command { displacement_acceleration: along, tilt_acceleration: turning };
        let (from, before) = (contact.time(), command.applied_to(&plate));
        assert!(contact.advance(&mut |t| before.after(t - from), from + interval).unwrap().is_finished());
        plate = before.after(interval);
        assert!(plate.displacement.abs() <= limits.stroke && plate.tilt.abs() <= limits.tilt);
    }
    assert!(plate.velocity.abs() < 2e-3 && plate.tilt.abs() < 2e-3 && plate.tilt_rate.abs() < 2e-2, "{plate:?}");
    // What still slides comes to rest.
    let still = PlateKinematics { displacement: plate.displacement, ..PlateKinematics::default() };
    let from = contact.time();
    contact.advance(&mut |_| still, from + 0.3).unwrap();
    let [x, y, phi, ..] = contact.state();
    [x, y, phi]
}

#[test]
fn plans_of_random_short_moves_arrive_on_a_finer_plant_within_the_bounds() {
    let limits = PlateLimits::default();
    let mut random = StdRng::seed_from_u64(17);
    for object in [ELLIPSE, Object { shape: Shape::Rectangle { a: 0.14, b: 0.07 }, ..Object::REFERENCE }] {
        let planner = MovePlanner::new(&object, MU, &limits).unwrap();
        for _ in 0..2 {
            let start = [0.05, 0.05, 3.0].map(|limit: f64| random.random_range(-limit..limit));
            let way = [0.04, 0.04, 0.3].map(|limit: f64| random.random_range(-limit..limit));
            let target: [f64; 3] = std::array::from_fn(|i| start[i] + way[i]);
            let planned = planner.plan(start, target, &budget(100)).unwrap().unwrap();
            assert!(planned.arrives, "{planned:?}");
            let end = played(&object, start, &planned, &limits);
            let error: [f64; 3] = std::array::from_fn(|i| (end[i] - planned.target[i]).abs());
            assert!(error[0] < 1e-3 && error[1] < 1e-3 && error[2] < 0.02, "{error:?}");
        }
    }
}

#[test]
fn a_target_a_whole_turn_away_is_the_same_target() {
    let planner = MovePlanner::new(&ELLIPSE, MU, &PlateLimits::default()).unwrap();
    let near = planner.plan([0.0; 3], [0.02, 0.0, 0.1], &budget(60)).unwrap().unwrap();
    let far = planner.plan([0.0; 3], [0.02, 0.0, 0.1 - TAU], &budget(60)).unwrap().unwrap();
    assert!((near.target[2] - far.target[2]).abs() < 1e-12 && near.target[2].abs() < 0.2);
    assert_eq!(near.accelerations.len(), far.accelerations.len());
}

#[test]
fn a_budget_that_is_used_up_ends_the_search_but_not_without_a_plan() {
    let planner = MovePlanner::new(&ELLIPSE, MU, &PlateLimits::default()).unwrap();
    let target = [0.03, -0.02, 0.2];
    let none = planner.plan([0.0; 3], target, &budget(0)).unwrap().unwrap();
    let late = PlanningBudget { seconds: 0.0, ..budget(1000) };
    let clock = planner.plan([0.0; 3], target, &late).unwrap().unwrap();
    assert_eq!(none.accelerations, clock.accelerations);
    assert!(none.miss.iter().all(|e| e.abs() < 0.02), "{:?}", none.miss);
    let more = planner.plan([0.0; 3], target, &budget(300)).unwrap().unwrap();
    assert!(more.arrives && more.duration <= none.duration);
}

#[test]
fn a_pose_that_is_no_number_is_refused() {
    let planner = MovePlanner::new(&ELLIPSE, MU, &PlateLimits::default()).unwrap();
    for (start, target) in [([f64::NAN, 0.0, 0.0], [0.0; 3]), ([0.0; 3], [0.0, f64::INFINITY, 0.0])] {
        assert!(planner.plan(start, target, &budget(10)).is_err());
    }
    let limits = PlateLimits { stroke: -0.1, ..PlateLimits::default() };
    assert!(MovePlanner::new(&ELLIPSE, MU, &limits).is_err());
    assert!(MovePlanner::new(&ELLIPSE, f64::NAN, &PlateLimits::default()).is_err());
}
