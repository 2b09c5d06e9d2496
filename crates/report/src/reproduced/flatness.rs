//! Flatness, chained forms, and steering.

use super::row::{Field, Ours, PRINTED, Row, Verdict};

const KNOWN: &str = "tests/main/classic_models.rs::analyze_says_what_the_literature_says";

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "unicycle-dynamic-feedback",
        field: Field::Flatness,
        subject: "wheel that rolls and turns",
        reference: "d'Andréa-Novel, Bastin, and Campion 1992",
        claim: "Dynamic feedback linearizes a wheeled robot that static feedback does not linearize.",
        ours: Ours::Printed {
            command: "bracketry analyze models/unicycle.toml",
            lines: &[
                "linearizable by static feedback near a generic point: no",
                "flat outputs x, y",
                "with integrators 1 in front of s",
                "singular where s = 0",
            ],
        },
        tests: &["crates/lie/tests/main/flatness.rs::unicycle", KNOWN],
        verdict: Verdict::Same,
        remark: "The feedback is singular where the wheel stands.",
    },
    Row {
        name: "car-flat",
        field: Field::Flatness,
        subject: "car (bicycle model)",
        reference: "Fliess, Lévine, Martin, and Rouchon 1995",
        claim: "The car is flat with the middle of its rear axle.",
        ours: Ours::Printed {
            command: "bracketry analyze models/kinematic_car.toml",
            lines: &["differentially flat: yes", "flat outputs x, y", "singular where v = 0"],
        },
        tests: &[KNOWN, PRINTED],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "trailers-flat",
        field: Field::Flatness,
        subject: "tractor with two trailers",
        reference: "Rouchon, Fliess, Lévine, and Martin 1993",
        claim: "A tractor with trailers is flat with the middle of its last axle.",
        ours: Ours::Printed {
            command: "bracketry analyze models/car_with_trailers.toml",
            lines: &[
                "differentially flat: yes",
                "flat outputs x, y",
                "with integrators 3 in front of v",
                "relative degrees 4, 4",
            ],
        },
        tests: &["crates/lie/tests/main/flatness.rs::tractor_with_trailers_is_flat_by_the_last_axle"],
        verdict: Verdict::Same,
        remark: "Shown for two trailers.",
    },
    Row {
        name: "aircraft-flat",
        field: Field::Flatness,
        subject: "aircraft that takes off vertically (VTOL)",
        reference: "Martin, Devasia, and Paden 1996",
        claim: "The aircraft is flat with its center of oscillation, x − ε sin θ and y + ε cos θ.",
        ours: Ours::Printed {
            command: "bracketry analyze models/pvtol.toml",
            lines: &[
                "flat outputs x - eps*sin(th), eps*cos(th) + y",
                "with integrators 2 in front of u1",
                "relative degrees 4, 4",
            ],
        },
        tests: &[
            "crates/lie/tests/main/flatness.rs::huygens_center_of_oscillation_is_found_and_verified",
            "tests/main/classic_dynamics.rs::laws_that_the_equations_were_not_written_from_hold",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "motor-dynamic-feedback",
        field: Field::Flatness,
        subject: "induction motor",
        reference: "Chiasson 1993",
        claim: "Dynamic feedback linearizes the induction motor, which static feedback does not.",
        ours: Ours::Printed {
            command: "bracketry analyze models/induction_motor.toml",
            lines: &[
                "linearizable by static feedback near a generic point: no",
                "differentially flat: yes: dynamic feedback linearizes the system by these functions",
                "with integrators 1 in front of ub",
            ],
        },
        tests: &["crates/lie/tests/main/flatness.rs::induction_motor_becomes_linear_by_dynamic_feedback", KNOWN],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "quadrotor-flat",
        field: Field::Flatness,
        subject: "quadrotor with four thrusts",
        reference: "Mellinger and Kumar 2011",
        claim: "The quadrotor is flat with its position and yaw.",
        ours: Ours::Printed {
            command: "bracketry analyze models/quadrotor.toml",
            lines: &[
                "differentially flat: unknown: no flat outputs were found among the functions tried, and no criterion excludes them",
            ],
        },
        tests: &["crates/lie/tests/main/flatness.rs::quadrotor_in_space_by_position_and_yaw", PRINTED],
        verdict: Verdict::Differs,
        remark: "The search does not find the flat outputs by itself. With position and yaw as outputs of a model whose \
                 inputs are thrust and torques, they are confirmed: two integrators in front of the thrust, relative \
                 degrees 4, 4, 4, and 2 (first test).",
    },
    Row {
        name: "derived-flag",
        field: Field::Flatness,
        subject: "five states and two inputs without drift",
        reference: "Martin and Rouchon 1994",
        claim: "Such a system is flat if and only if its derived flag grows by one in each step. The flag 2, 3, 5 of \
                Cartan 1910 does not.",
        ours: Ours::Asserted(
            "the chained form of five states is flat with its first and last state; the growth 2, 3, 5 is not flat",
        ),
        tests: &[
            "crates/lie/tests/main/flatness.rs::without_drift_two_inputs_are_flat_just_when_the_derived_flag_grows_by_one",
            "crates/lie/tests/main/chained.rs::other_flags_drift_and_other_numbers_of_inputs_have_no_chained_form",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "car-chained-form",
        field: Field::Flatness,
        subject: "car with front steering",
        reference: "Murray and Sastry 1993",
        claim: "x, tan φ/(l cos³ θ), tan θ, and y are coordinates of a chained form of the car.",
        ours: Ours::Printed {
            command: "bracketry transform models/kinematic_car.toml --to chained",
            lines: &[
                "z1 = x",
                "z2 = tan(delta)/(L*cos(th)^3)",
                "z3 = sin(th)/cos(th)",
                "z4 = y",
                "confirmed by transforming back",
            ],
        },
        tests: &["crates/lie/tests/main/chained.rs::the_published_chained_form_of_the_car_is_among_those_found"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "nilpotent-steering",
        field: Field::Flatness,
        subject: "steering by piecewise constant inputs",
        reference: "Lafferriere and Sussmann 1991",
        claim: "Nilpotent systems without drift are steered exactly by piecewise constant inputs, in one round.",
        ours: Ours::Printed {
            command: "bracketry steer models/brockett_integrator.toml --from x=0,y=0,z=0 --to x=0,y=0,z=1 --method nilpotent",
            lines: &["all longer ones vanish, so one round is exact; rounds: 1, constant pieces: 4"],
        },
        tests: &["crates/steer/tests/main/nilpotent.rs::nilpotent_systems_are_steered_exactly_in_one_round"],
        verdict: Verdict::Same,
        remark: "The test has four systems, the longest with brackets up to length 4.",
    },
];
