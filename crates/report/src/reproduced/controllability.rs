//! Controllability, stabilization, and static feedback.

use super::row::{Field, Ours, PRINTED, Row, Verdict};

const KNOWN: &str = "tests/main/classic_models.rs::analyze_says_what_the_literature_says";
const NO_FEEDBACK: &str =
    "tests/main/classic_models.rs::what_continuous_feedback_cannot_stabilize_is_what_brockett_says";
const LOCAL: &str = "crates/lie/tests/main/stlc.rs::verdicts_agree_with_the_literature";

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "brockett-integrator",
        field: Field::Controllability,
        subject: "nonholonomic integrator",
        reference: "Brockett 1983",
        claim: "x' = u, y' = v, z' = x v − y u is controllable, but no smooth state feedback stabilizes it.",
        ours: Ours::Printed {
            command: "bracketry analyze models/brockett_integrator.toml",
            lines: &[
                "Brockett's condition fails: no continuous state feedback stabilizes",
                "small-time control yes: no drift and full dimension (Chow–Rashevskii)",
            ],
        },
        tests: &[KNOWN, NO_FEEDBACK],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "trailers-controllable",
        field: Field::Controllability,
        subject: "tractor with two trailers",
        reference: "Laumond 1993",
        claim: "A tractor with trailers is controllable, although its wheels do not slip.",
        ours: Ours::Printed {
            command: "bracketry analyze models/car_with_trailers.toml",
            lines: &[
                "accessible 5 (growth 2, 3, 4, 5)",
                "small-time control yes: no drift and full dimension (Chow–Rashevskii)",
            ],
        },
        tests: &[KNOWN, "tests/main/classic_dynamics.rs::wheels_roll_without_slipping_sideways"],
        verdict: Verdict::Same,
        remark: "Shown for two trailers, each hitched at the middle of the axle in front of it.",
    },
    Row {
        name: "satellite-two-torques",
        field: Field::Controllability,
        subject: "satellite with two torques",
        reference: "Crouch 1984",
        claim: "Torques about two principal axes control attitude and rates locally, although the linearization is not \
                controllable.",
        ours: Ours::Printed {
            command: "bracketry analyze models/spacecraft.toml",
            lines: &[
                "linear rank 4",
                "small-time control yes: Sussmann's condition holds with weights [1, 1] of drift and inputs",
            ],
        },
        tests: &[KNOWN, LOCAL],
        verdict: Verdict::Same,
        remark: "The two inertias differ in this model.",
    },
    Row {
        name: "satellite-feedback",
        field: Field::Controllability,
        subject: "satellite with two torques",
        reference: "Byrnes and Isidori 1991",
        claim: "No smooth state feedback stabilizes attitude and rates with two torques.",
        ours: Ours::Printed {
            command: "bracketry analyze models/spacecraft.toml",
            lines: &["Brockett's condition fails: no continuous state feedback stabilizes"],
        },
        tests: &[NO_FEEDBACK],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "satellite-inertias",
        field: Field::Controllability,
        subject: "rigid body with two torques",
        reference: "Baillieul 1981",
        claim: "The rates of a rigid body with torques about two principal axes are accessible if and only if the \
                inertias about these axes differ.",
        ours: Ours::Printed {
            command: "bracketry analyze models/spacecraft.toml --parameters J1,J2,J3",
            lines: &[
                "strongly accessible dimension: 6 of 6 for generic parameters",
                "J1 - J2 = 0: 5 of 6",
                "these are all the cases (proven)",
            ],
        },
        tests: &[
            "crates/lie/tests/main/parameter_cases.rs::a_rigid_body_with_two_torques_is_accessible_unless_their_inertias_are_equal",
        ],
        verdict: Verdict::Same,
        remark: "The model of the command also has the attitude; the test has the rates alone.",
    },
    Row {
        name: "cubic-against-square",
        field: Field::Controllability,
        subject: "third power of velocity against square of position",
        reference: "Sussmann 1983",
        claim: "x' = u, y' = x, z' = x³ + y² with bounded input is small-time locally controllable at 0.",
        ours: Ours::Asserted("small-time locally controllable"),
        tests: &[LOCAL],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "cubic-times-position",
        field: Field::Controllability,
        subject: "third power of velocity times position",
        reference: "Kawski 1990",
        claim: "x' = u, y' = x, z' = x³ y with bounded input is small-time locally controllable at 0.",
        ours: Ours::Asserted("small-time locally controllable"),
        tests: &[LOCAL],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "increasing-switchings",
        field: Field::Controllability,
        subject: "more and more switchings",
        reference: "Kawski 1990",
        claim: "x' = u, y' = x, z' = x³/6, w' = y z is small-time locally controllable at 0, although Sussmann's \
                condition is obstructed.",
        ours: Ours::Asserted("inconclusive"),
        tests: &[LOCAL],
        verdict: Verdict::Differs,
        remark: "The conditions that are implemented do not decide it: controls with more and more switchings are \
                 outside of them. The report names the obstruction and does not say \"no\".",
    },
    Row {
        name: "fourth-power",
        field: Field::Controllability,
        subject: "even power of a state",
        reference: "Stefani 1986",
        claim: "x' = u, y' = x⁴ is not small-time locally controllable: the bracket of even order in the input \
                obstructs.",
        ours: Ours::Asserted("the obstruction is a bracket with the drift once and the input four times"),
        tests: &["crates/lie/tests/main/stlc.rs::the_obstructing_bracket_is_named", LOCAL],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "cubic-in-the-plane",
        field: Field::Controllability,
        subject: "unstable mode out of reach of smooth feedback",
        reference: "Kawski 1989",
        claim: "x' = x − y³, y' = u is stabilized by a feedback that is continuous, but by none that is differentiable.",
        ours: Ours::Asserted("stabilizable, although the linearization has an unstable uncontrollable mode"),
        tests: &[
            "tests/main/verdicts.rs::an_unstable_mode_out_of_reach_of_smooth_feedback_does_not_exclude_other_feedback",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "ball-and-beam",
        field: Field::Controllability,
        subject: "ball on a beam",
        reference: "Hauser, Sastry, and Kokotović 1992",
        claim: "The position of the ball has no relative degree where position or turning rate is 0, so that exact \
                linearization fails where the ball is to be kept.",
        ours: Ours::Printed {
            command: "bracketry analyze models/ball_and_beam.toml",
            lines: &[
                "relative degree 3 of position",
                "zero where r = 0 or w = 0",
                "linearizable by static feedback near a generic point: no",
            ],
        },
        tests: &["tests/main/classic_models.rs::the_relative_degree_of_the_ball_is_lost_where_it_is_to_be_kept", KNOWN],
        verdict: Verdict::Same,
        remark: "The model has the mass of the beam and the torque as its input.",
    },
    Row {
        name: "aircraft-zero-dynamics",
        field: Field::Controllability,
        subject: "aircraft that takes off vertically (VTOL)",
        reference: "Hauser, Sastry, and Meyer 1992",
        claim: "Held in place by its inputs, the aircraft rolls with θ'' = sin(θ)/ε: it is not minimum phase.",
        ours: Ours::Printed {
            command: "bracketry analyze models/pvtol.toml",
            lines: &["zero dynamics th' = w, w' = sin(th)/eps", "minimum phase no"],
        },
        tests: &[
            "tests/main/classic_models.rs::the_aircraft_is_flat_with_its_center_of_oscillation_and_not_minimum_phase",
            "crates/lie/tests/main/input_output.rs::a_vtol_aircraft_held_in_place_rolls_over",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "motor-decoupling",
        field: Field::Controllability,
        subject: "induction motor",
        reference: "Marino, Peresada, and Valigi 1993",
        claim: "Speed and squared flux have relative degrees 2 and 2 and are decoupled by static feedback where the flux \
                is not 0.",
        ours: Ours::Printed {
            command: "bracketry analyze models/induction_motor.toml",
            lines: &["relative degree 2 of w 2 of flux", "zero where fa^2 + fb^2 = 0"],
        },
        tests: &[PRINTED],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "four-tanks",
        field: Field::Controllability,
        subject: "four tanks and two pumps",
        reference: "Johansson 2000",
        claim: "In the minimum-phase setting, the zeros are −0.060 and −0.018 1/s.",
        ours: Ours::Printed {
            command: "bracketry linearize models/quadruple_tank.toml",
            lines: &["zeros: -0.01747…", "-0.05969…"],
        },
        tests: &["tests/main/classic_models.rs::the_zeros_of_the_tanks_are_those_published", PRINTED],
        verdict: Verdict::Differs,
        remark: "−0.060 agrees. The other zero is 3 % smaller in magnitude and rounds to −0.017. The parameters are published \
                 with two or three digits, too. Both are in the left half-plane, as published.",
    },
    Row {
        name: "acrobot",
        field: Field::Controllability,
        subject: "two links with a motor at the elbow",
        reference: "Murray and Hauser 1991",
        claim: "The acrobot is not linearizable by static feedback.",
        ours: Ours::Printed {
            command: "bracketry analyze models/acrobot.toml",
            lines: &["linearizable by static feedback near a generic point: no", "linear rank 4"],
        },
        tests: &[KNOWN],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "elastic-joint",
        field: Field::Controllability,
        subject: "link on an elastic joint",
        reference: "Spong 1987",
        claim: "A robot with elastic joints, modeled by springs between motors and links, is linearizable by static \
                feedback; its outputs are the angles of the links.",
        ours: Ours::Printed {
            command: "bracketry analyze models/flexible_joint.toml",
            lines: &[
                "linearizable by static feedback near a generic point: yes",
                "linearizing outputs q1 (chain of 4)",
            ],
        },
        tests: &[KNOWN, "crates/lie/tests/main/integrals.rs::the_linearizing_output_of_a_flexible_joint"],
        verdict: Verdict::Same,
        remark: "Shown for one link.",
    },
    Row {
        name: "reaction-wheel",
        field: Field::Controllability,
        subject: "pendulum with a wheel",
        reference: "Spong, Corke, and Lozano 2001",
        claim: "The pendulum with a reaction wheel is linearizable by static feedback.",
        ours: Ours::Printed {
            command: "bracketry analyze models/reaction_wheel_pendulum.toml",
            lines: &[
                "linearizable by static feedback near a generic point: yes",
                "linearizing outputs J1*w + J2*v + J2*w (chain of 3)",
                "singular where cos(th) = 0",
            ],
        },
        tests: &[KNOWN, "crates/lie/tests/main/flatness.rs::with_one_input_flat_means_linearizable"],
        verdict: Verdict::Same,
        remark: "The output is the angular momentum; the feedback is singular where the pendulum is horizontal.",
    },
];
