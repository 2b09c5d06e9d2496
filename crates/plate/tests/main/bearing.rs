//! Objects that do not press on the plate with their whole footprint, or whose mass is off their middle.

use bracketry_mpc::Dynamics;
use bracketry_plate::area::{AreaContact, AreaOutcome, AreaSettings, Footprint, Load, Support};
use bracketry_plate::body::{BodyOnPlate, BodySettings};
use bracketry_plate::control::RoundedContact;
use bracketry_plate::model::Terms;
use bracketry_plate::object::Bearing;
use bracketry_plate::{Friction, Object, PlateError, PlateKinematics, Shape, reduced};
use proptest::prelude::*;

const DISK: Object = Object { height: 0.0, ..Object::REFERENCE };
const RADIUS: f64 = 0.12;

fn bearings() -> Vec<Bearing> {
    vec![
        Bearing::Footprint,
        Bearing::Scaled(0.5),
        Bearing::Ring(1.0),
        Bearing::Feet(vec![[0.12, 0.03], [-0.06, 0.1], [-0.05, -0.09]]),
        Bearing::Map(vec![[0.07, 0.05, 1.0], [-0.08, 0.06, 2.0], [-0.07, -0.05, 1.5], [0.06, -0.06, 0.5]]),
    ]
}

/// Objects on all bearings, with the mass in the middle and off it.
fn objects() -> impl Iterator<Item = Object> {
    bearings().into_iter().flat_map(|bearing| {
        let shape = Shape::polygon(&[[0.0, 0.0], [0.3, 0.0], [0.32, 0.2], [0.05, 0.25]]).unwrap();
        [Shape::REFERENCE_ELLIPSE, shape].into_iter().flat_map(move |shape| {
            [[0.0; 2], [0.012, -0.007]].map(|center_of_mass| Object {
                shape: shape.clone(),
                bearing: bearing.clone(),
                center_of_mass,
                ..DISK
            })
        })
    })
}

#[test]
fn the_pressure_balances_normal_force_and_moments_about_the_center_of_mass() {
    for object in objects() {
        let mut footprint = Footprint::new(&object, 48).unwrap();
        for moments in [[0.0, 0.0], [0.05, -0.03], [-0.1, 0.06], [0.25, 0.1]] {
            let load = Load { normal: 9.0, moments };
            let support = footprint.carry(&load).unwrap();
            assert!(matches!(support, Support::Full { .. } | Support::Partial { .. }), "{object:?} {support:?}");
            let points = || footprint.points().iter().zip(footprint.loads());
            let normal: f64 = points().map(|(_, load)| load).sum();
            assert!((normal - 9.0).abs() < 1e-11 && points().all(|(_, load)| *load >= 0.0));
            for (i, moment) in moments.iter().enumerate() {
                assert!((points().map(|(p, load)| p[i] * load).sum::<f64>() - moment).abs() < 1e-11, "{object:?}");
            }
        }
    }
}

/// The object's state after a motion with displacement and tilt.
fn shaken(object: &Object, state: [f64; 6]) -> [f64; 6] {
    let mut contact = AreaContact::new(object, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default()).unwrap();
    contact.set_state(state).unwrap();
    let mut motion = |t: f64| PlateKinematics {
        acceleration: 6.0 * (15.0 * t).sin(),
        tilt: 0.1 * (12.0 * t).sin(),
        tilt_rate: 1.2 * (12.0 * t).cos(),
        tilt_acceleration: -14.4 * (12.0 * t).sin(),
        ..PlateKinematics::default()
    };
    assert!(contact.advance(&mut motion, 0.4).unwrap().is_finished());
    contact.state()
}

#[test]
fn a_footprint_scaled_by_one_is_the_whole_footprint() {
    let whole = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
    let scaled = Object { bearing: Bearing::Footprint.scaled(1.0), ..whole.clone() };
    let start = [0.01, 0.02, 0.3, 0.1, -0.05, 1.0];
    for (a, b) in shaken(&whole, start).iter().zip(shaken(&scaled, start)) {
        assert!((a - b).abs() < 1e-9);
    }
}

#[test]
fn a_spin_stops_the_sooner_the_farther_out_the_pressure_stands() {
    // I w/(μ g mean radius): mean radii 2R/3, R/3 and R.
    let (w, mu, g) = (10.0, 0.3, 9.81);
    for (bearing, mean) in
        [(Bearing::Footprint, 2.0 / 3.0), (Bearing::Scaled(0.5), 1.0 / 3.0), (Bearing::Ring(1.0), 1.0)]
    {
        let object = Object { bearing, ..DISK };
        let mut contact = AreaContact::new(&object, &Friction::Coulomb { mu }, &AreaSettings::default()).unwrap();
        contact.set_state([0.0, 0.0, 0.0, 0.0, 0.0, w]).unwrap();
        let expected = 0.5 * RADIUS * w / (mu * g * mean);
        let mut still = |_| PlateKinematics::default();
        contact.advance(&mut still, 0.995 * expected).unwrap();
        assert!(contact.state()[5] > 0.0);
        contact.advance(&mut still, 1.005 * expected).unwrap();
        assert_eq!(contact.state()[5], 0.0);
    }
}

#[test]
fn without_friction_the_middle_circles_about_the_center_of_mass() {
    let object = Object { center_of_mass: [0.01, 0.02], ..DISK };
    let mut contact = AreaContact::new(&object, &Friction::Coulomb { mu: 0.0 }, &AreaSettings::default()).unwrap();
    assert_eq!(contact.state(), [0.0; 6]);
    let w = 3.0;
    // The center of mass rests at (0.01, 0.02).
    contact.set_state([0.0, 0.0, 0.0, w * 0.02, -w * 0.01, w]).unwrap();
    contact.advance(&mut |_| PlateKinematics::default(), 0.5).unwrap();
    let ([x, y, phi, ..], (s, c)) = (contact.state(), (0.5 * w).sin_cos());
    assert!((phi - 0.5 * w).abs() < 1e-12);
    assert!((x + 0.01 * c - 0.02 * s - 0.01).abs() < 1e-12 && (y + 0.01 * s + 0.02 * c - 0.02).abs() < 1e-12);
}

/// A state of sliding and the accelerations of the plate.
const STATE: [f64; 10] = [0.02, -0.05, 0.7, 0.4, -0.3, 1.5, 0.01, 0.2, 0.15, -0.8];
const INPUT: [f64; 2] = [3.0, -9.0];

#[test]
fn the_optimizers_model_accelerates_sliding_objects_as_the_simulator_does() {
    for object in objects() {
        let mut model = RoundedContact::new(&object, 0.3, 48).unwrap();
        model.set_smoothing(1e-6);
        let mut rates = [0.0; 10];
        model.field(0.0, &STATE, &INPUT, &mut rates);
        let settings = AreaSettings::default().with_step(1e-6);
        let mut contact = AreaContact::new(&object, &Friction::Coulomb { mu: 0.3 }, &settings).unwrap();
        contact.set_state(std::array::from_fn(|i| STATE[i])).unwrap();
        let plate = PlateKinematics {
            displacement: STATE[6],
            velocity: STATE[7],
            acceleration: INPUT[0],
            tilt: STATE[8],
            tilt_rate: STATE[9],
            tilt_acceleration: INPUT[1],
        };
        contact.advance(&mut |t| plate.after(t), 1e-6).unwrap();
        for i in 3..6 {
            let simulated = (contact.state()[i] - STATE[i]) / 1e-6;
            assert!((simulated - rates[i]).abs() < 1e-3, "{object:?}: {simulated} {}", rates[i]);
        }
    }
}

#[test]
fn the_derivatives_of_the_optimizers_model_are_exact() {
    for object in objects() {
        let mut model = RoundedContact::new(&object, 0.3, 16).unwrap();
        let pattern = model.jacobian_pattern().to_vec();
        let (mut rates, mut entries) = ([0.0; 10], vec![0.0; pattern.len()]);
        model.field_and_jacobian(0.0, &STATE, &INPUT, &mut rates, &mut entries);
        for column in 0..12 {
            let mut at = |step: f64| {
                let (mut x, mut u, mut rates) = (STATE, INPUT, [0.0; 10]);
                if column < 10 {
                    x[column] += step;
                } else {
                    u[column - 10] += step;
                }
                model.field(0.0, &x, &u, &mut rates);
                rates
            };
            let (above, below) = (at(1e-6), at(-1e-6));
            for row in 0..10 {
                let entry = pattern.iter().position(|e| *e == (row, column)).map_or(0.0, |i| entries[i]);
                let difference = (above[row] - below[row]) / 2e-6;
                assert!((entry - difference).abs() < 1e-6 * (1.0 + difference.abs()), "{object:?}: {row} {column}");
            }
        }
    }
}

#[test]
fn an_object_tips_over_its_feet_not_over_its_rim() {
    let (half, h) = (0.05, 0.04);
    let feet = Bearing::Feet(vec![[half, half], [-half, half], [-half, -half], [half, -half]]);
    let object = Object { bearing: feet, height: h, ..DISK };
    // Pulled along with the acceleration a it tips at a h = g half, well before the rim of the disk.
    for (share, tips) in [(0.99, false), (1.01, true)] {
        let mut contact = AreaContact::new(&object, &Friction::Coulomb { mu: 10.0 }, &AreaSettings::default()).unwrap();
        let acceleration = share * 9.81 * half / h;
        let mut motion = |_| PlateKinematics { acceleration, ..PlateKinematics::default() };
        let outcome = contact.advance(&mut motion, 0.01).unwrap();
        assert_eq!(
            matches!(outcome, AreaOutcome::Tipping { at, .. } if (at[0] + half).abs() < 1e-9),
            tips,
            "{outcome}"
        );
    }
}

#[test]
fn a_bearing_without_meaning_or_unknown_to_a_model_is_refused() {
    let on = |bearing| Object { bearing, ..DISK };
    let line = vec![[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]];
    for bearing in [Bearing::Scaled(0.0), Bearing::Ring(f64::NAN), Bearing::Feet(line), Bearing::Feet(Vec::new())] {
        assert!(Footprint::new(&on(bearing), 16).is_err());
    }
    assert!(Footprint::new(&on(Bearing::Map(vec![[0.1, 0.0, 1.0], [0.0, 0.1, 1.0], [0.0, 0.0, -1.0]])), 16).is_err());
    let inner = on(Bearing::Scaled(0.5));
    assert_eq!(reduced(&inner, 0.3, Terms::default()).err(), Some(PlateError::UnevenBearing));
    let body = BodyOnPlate::new(&inner, &Friction::Coulomb { mu: 0.3 }, &BodySettings::default());
    assert_eq!(body.err(), Some(PlateError::UnevenBearing));
}

proptest! {
    /// Any mean of the points with positive weights is the center of a pressure that does not pull. Where few points carry, as two
    /// opposite feet of four, they do, not a point between them.
    #[test]
    fn a_center_inside_the_points_is_carried_by_points(
        bearing in prop::sample::select(bearings()),
        count in 1usize..4,
        picked in prop::collection::vec((any::<prop::sample::Index>(), 0.05f64..1.0), 3),
        normal in 0.1f64..20.0,
    ) {
        let object = Object { shape: Shape::REFERENCE_ELLIPSE, bearing, ..DISK };
        let mut footprint = Footprint::new(&object, 48).unwrap();
        let points = footprint.points().to_vec();
        // Most at a few of the points, and a little everywhere.
        let mut weights = vec![1e-3 / points.len() as f64; points.len()];
        for (index, weight) in &picked[..count] {
            weights[index.index(points.len())] += weight;
        }
        let all: f64 = weights.iter().sum();
        let moments = [0, 1].map(|i| points.iter().zip(&weights).map(|(p, w)| normal * w * p[i]).sum::<f64>() / all);
        let support = footprint.carry(&Load { normal, moments }).unwrap();
        prop_assert!(matches!(support, Support::Full { .. } | Support::Partial { .. }), "{support:?}");
        let sum = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().zip(footprint.loads()).map(|(p, l)| l * f(p)).sum::<f64>();
        prop_assert!((sum(&|_| 1.0) - normal).abs() < 1e-8 * normal);
        prop_assert!((sum(&|p| p[0]) - moments[0]).abs() < 1e-9 * normal && (sum(&|p| p[1]) - moments[1]).abs() < 1e-9 * normal);
        prop_assert!(footprint.loads().iter().all(|l| *l >= 0.0));
    }
}
