//! Section 3.2.3: what the publication leaves open, point by point.

use super::entry::{Entry, Kind, Place, Verdict};

const MODEL: Place = Place { name: "model file", file: "models/plate_published.toml" };

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        kind: Kind::Question,
        number: "3.2.3a",
        title: "affine form",
        statement: "Is there a change of coordinates that makes the equations affine in the inputs?",
        places: &[Place { name: "bracketry_system::System::affinize", file: "crates/system/src/affine.rs" }, MODEL],
        tests: &[
            "crates/system/tests/main/affine.rs::the_plate_needs_four_integrators_and_becomes_a_model_file",
            "tests/main/analysis.rs::over_all_modes_smoothed_and_at_rest_the_shape_does_not_matter",
        ],
        commands: &[
            "bracketry affinize models/plate_published.toml",
            "bracketry analyze models/plate_published.toml",
            "bracketry affinize models/plate_published.toml --candidate 1",
        ],
        verdict: Verdict::Answered,
        remark: "No change of coordinates is needed. Two integrators in front of each input make X'' and θ'' the \
                 inputs of an affine system with ten states, x, y, φ, x', y', φ', X, X', θ, θ'. Fewer integrators \
                 alone do not suffice. Since X enters by X'' only, X'' itself can be the input, which leaves eight \
                 states (the third command). The state x' + X' in place of x' does not save integrators, and a new \
                 state that absorbs θ'' is rejected, because the coefficient of θ'' jumps with the signs of x' and \
                 y'. Each mode of friction has smooth equations of its own.",
    },
    Entry {
        kind: Kind::Question,
        number: "3.2.3b",
        title: "a rigorous method",
        statement: "Is there a rigorous analysis of controllability for such systems?",
        places: &[Place { name: "bracketry_lie::analysis::Family", file: "crates/lie/src/analysis/family.rs" }],
        tests: &[
            "crates/lie/tests/main/family.rs::the_published_plate_agrees_with_its_family_in_every_mode",
            "tests/main/analysis.rs::the_affine_form_reaches_as_much_as_the_original_with_constant_inputs",
        ],
        commands: &["bracketry analyze models/plate_published.toml"],
        verdict: Verdict::Answered,
        remark: "Yes: the orbit theorem and the rank condition hold for any family of vector fields f(·, u), affine \
                 in u or not (Sussmann and Jurdjevic 1972, Sussmann 1973). The analysis compares both ways: the \
                 family of constant inputs gives the same dimensions, 9 and 8, as the affine form, in every mode of \
                 friction.",
    },
    Entry {
        kind: Kind::Question,
        number: "3.2.3c",
        title: "accessibility per mode and over modes",
        statement: "Is the system controllable, by the rank of Lie brackets?",
        places: &[
            Place { name: "bracketry_lie::analyze", file: "crates/lie/src/analysis/analyze.rs" },
            Place {
                name: "bracketry_lie::controllability::SwitchingTheorem",
                file: "crates/lie/src/controllability/orbit.rs",
            },
        ],
        tests: &[
            "crates/lie/tests/main/plate.rs::an_ellipse_is_not_accessible_in_any_mode_and_two_sums_are_out_of_reach",
            "crates/lie/tests/main/plate.rs::a_disk_also_turns_with_the_plate",
            "crates/lie/tests/main/plate.rs::switching_between_modes_reaches_everything",
            "crates/lie/tests/main/plate.rs::the_smoothed_plate_is_accessible",
        ],
        commands: &[
            "bracketry analyze models/plate_published.toml",
            "bracketry analyze models/plate_published_disk.toml",
            "bracketry analyze models/plate_reduced.toml",
        ],
        verdict: Verdict::Answered,
        remark: "Not in one mode: while x' and y' keep their signs, the set reached at a time has dimension 8 of 10 \
                 for an ellipse, because x + X and x' + X' evolve as if there were no input, and 6 of 10 for a disk, \
                 whose yaw also follows the tilt. Over all modes the dimension is 10 of 10: reversals of the slip \
                 reach what one mode does not. With friction smoothed, and for the model with friction over the \
                 footprint, it is 10 as well. Accessibility is not controllability: at rest, friction balances small \
                 forces (3.2.3d).",
    },
    Entry {
        kind: Kind::Question,
        number: "3.2.3d",
        title: "motion from rest to rest",
        statement: "Which rest states do bounded inputs reach from rest?",
        places: &[Place {
            name: "bracketry_steer::from_rest::from_rest",
            file: "crates/steer/src/from_rest/decide.rs",
        }],
        tests: &[
            "crates/steer/tests/main/from_rest.rs::the_published_plate_turns_what_it_cannot_shift",
            "crates/steer/tests/main/from_rest.rs::with_contact_over_the_footprint_all_three_coordinates_change",
            "crates/steer/tests/main/from_rest.rs::loops_steer_the_plate",
        ],
        commands: &[
            "bracketry analyze models/plate_published.toml --from-rest --bounds \"der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20\"",
            "bracketry analyze models/plate_published.toml --from-rest --bounds \"der(X,2)=-2..2,theta=-0.2..0.2,der(theta,2)=-20..20\"",
            "bracketry analyze models/plate_reduced.toml --from-rest --bounds \"der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20\"",
        ],
        verdict: Verdict::Answered,
        remark: "At rest, small-time local controllability is not the right notion, because friction holds the \
                 object against all small forces. With |X''| ≤ 5 m/s², |θ| ≤ 0.4 rad, and |θ''| ≤ 20 rad/s², all \
                 rest states near the point are reachable in the published model (proven). With 2 m/s² and 0.2 rad, \
                 x and y never change (proven), but the yaw does, because it has no friction in this model. With \
                 friction over the footprint, the first bounds suffice as well (numerical evidence). \
                 docs/from_rest.md defines the notion.",
    },
    Entry {
        kind: Kind::Question,
        number: "3.2.3e",
        title: "position and orientation at the same time",
        statement: "Can a controller move position and orientation simultaneously, instead of in two steps?",
        places: &[
            Place { name: "problem file", file: "models/plate_move.toml" },
            Place {
                name: "bracketry_plate::control::PoseController",
                file: "crates/plate/src/control/pose_controller.rs",
            },
        ],
        tests: &[
            "tests/main/plate_move.rs::position_and_orientation_arrive_together_and_stay",
            "crates/cli/tests/main/story.rs::the_controller_of_the_published_model_fails_on_the_true_plant",
            "crates/cli/tests/main/story.rs::the_same_controller_reaches_the_target_with_a_model_from_first_principles",
            "crates/plate/tests/main/experiments.rs::the_two_step_way_reaches_x_and_y_but_keeps_spinning",
        ],
        commands: &["bracketry control models/plate_move.toml", "bracketry demo"],
        verdict: Verdict::Answered,
        remark: "Yes. On the published equations, a plan of 2.4 s moves the object by 60 mm and 30 mm and turns it \
                 by 90°, from rest to rest, with errors below 2 mm and 2° (the first command). In two steps, the \
                 published inputs reach x and y, but the yaw turns on. On a plant with contact over the footprint, \
                 the controller with the published model fails; with the model extended from data, it arrives within \
                 2 mm and 2° in less than 1.5 s in 21 of 21 runs of the second command with different noise \
                 (docs/records/main_job.md).",
    },
];
