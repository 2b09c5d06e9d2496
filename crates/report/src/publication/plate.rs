//! Section 3.2: the object on the vibrating plate.

use super::entry::{Entry, Kind, Place, Verdict};

const PROTOCOL: &str = "crates/plate/src/experiment/protocol.rs";
const DERIVATION: &str = "crates/plate/src/model/derivation.rs";
const SHAPE: &str = "crates/plate/src/object/shape.rs";

const PUBLISHED: Place = Place { name: "bracketry_plate::published", file: "crates/plate/src/model/published.rs" };
const MODEL: Place = Place { name: "model file", file: "models/plate_published.toml" };
const AFFINIZE: Place = Place { name: "bracketry_system::System::affinize", file: "crates/system/src/affine.rs" };
const PERIODS: &str =
    "crates/plate/tests/main/publication.rs::amplitudes_that_follow_the_error_at_once_would_make_the_plate_jump";
const WRONG_SIGN: &str =
    "crates/plate/tests/main/experiments.rs::with_the_wrong_sign_of_the_error_the_object_moves_away";

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        kind: Kind::Equation,
        number: "3.16",
        title: "motion of the object",
        statement: "x'' = −X'' − sgn(x') μ g, y'' = −g sin θ − sgn(y') μ (g cos θ + y θ''), and the torque about the \
                    normal n = −sgn(x') μ Iₓ(φ) θ''.",
        places: &[
            PUBLISHED,
            MODEL,
            Place { name: "bracketry_plate::model::flat_contact", file: DERIVATION },
            Place { name: "bracketry_plate::reduced", file: "crates/plate/src/model/reduced.rs" },
            Place { name: "bracketry_plate::area::AreaContact", file: "crates/plate/src/area/contact.rs" },
        ],
        tests: &[
            "crates/plate/tests/main/publication.rs::coulomb_friction_over_a_sliding_body_turns_it_against_the_published_sign",
            "crates/plate/tests/main/derivation.rs::the_torque_of_uniform_slip_along_x_has_the_sign_opposite_to_the_published_one",
            "crates/plate/tests/main/derivation.rs::motion_in_the_plane",
            "crates/plate/tests/main/derivation.rs::load_of_the_contact",
            "crates/plate/tests/main/first_principles.rs::with_the_published_terms_the_reduced_model_is_the_published_one_with_the_torque_turned_round",
            "crates/plate/tests/main/area.rs::friction_of_each_axis_on_its_own_hardly_turns_the_object",
            "crates/plate/tests/main/experiments.rs::experiment_1_turns_an_object_that_sticks",
            "crates/plate/tests/main/reduced.rs::each_of_the_neglected_terms_shows",
        ],
        commands: &[
            "bracketry plate 1 --model published",
            "bracketry plate 1",
            "bracketry plate 1 --model published --mu 0.5",
        ],
        verdict: Verdict::Wrong,
        remark: "The torque has the wrong sign: Coulomb friction, integrated over a body that slides along x, gives \
                 n = +sgn(x') μ Iₓ θ'', unless the yaw is counted clockwise, seen from above. Friction against the \
                 spin is missing: in experiment 1, the disk turns by −20172° in 15 s, and by +121° with contact over \
                 the whole footprint. Friction acts along each axis by itself: with contact over the footprint, this \
                 turns the disk by less than 7°, friction against the slip by 118° (without thickness). Also missing \
                 are the centrifugal term y θ'² in y'', 2 y' θ' in the load, the varying load along x, the torque \
                 −sgn(y') μ Sxy θ'' of slip along y, and the torque Sxy θ'² of bodies that are not round; \
                 docs/records/plate_terms.md shows where each matters. For x' = 0 the equation has no value: \
                 friction is set-valued here, and at μ = 0.5 the printed torque then spins an object that never \
                 slips, by −21929°. The bracket of the load is not closed; with y θ'' as its last term, the units \
                 agree. The yaw inertia is not given: Sxx + Syy here.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.17",
        title: "moment of inertia about x",
        statement: "Iₓ(φ) = ∫ (yᵣ − y)² dm, about the axis through the center of mass parallel to x.",
        places: &[Place { name: "bracketry_plate::Shape::second_moments_at", file: SHAPE }],
        tests: &[
            "crates/plate/tests/main/publication.rs::the_thickness_adds_little_to_the_moment_of_inertia_about_x",
            "crates/plate/tests/main/experiments.rs::shapes_have_the_moments_of_their_area",
            "crates/plate/tests/main/derivation.rs::thickness_gives_uniform_slip_no_torque_of_friction",
        ],
        commands: &[],
        verdict: Verdict::Right,
        remark: "Right for a flat body. The moment of inertia about x of a body with thickness also contains ∫ z² \
                 dm. The torque of friction contains the same sum: 0.06 % more for the disk of 0.12 m and 5 mm. The \
                 integral depends on the yaw for all shapes whose principal moments differ.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.18",
        title: "inputs",
        statement: "X = α sin(ωπt), θ = β sin(ωπt).",
        places: &[Place { name: "bracketry_plate::experiment::Experiment", file: PROTOCOL }],
        tests: &["crates/plate/tests/main/publication.rs::with_the_frequency_of_3_18_the_inputs_of_3_20_move_nothing"],
        commands: &["bracketry plate 2 --omega 4 --model published"],
        verdict: Verdict::Ambiguous,
        remark: "ω is not an angular frequency here: equation 3.19 has sin(4πt), that is ω = 4. Equation 3.20 has \
                 cos(2ωt) without π. With ω = 4 rad/s there, |X''| stays below 1.91 m/s², less than μ g = 2.94 m/s² \
                 at μ = 0.3, and the object never moves. Here ω is in rad/s everywhere, and --omega is in units of \
                 π.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.19",
        title: "experiment 1, orientation",
        statement: "X = 0.025 sin(4πt) ξ, θ = −15 sin(4πt) ξ, ξ = 1 − exp(−t/τ), τ = 1; goal: yaw from 0° to 90°.",
        places: &[Place { name: "bracketry_plate::experiment::Experiment::orientation", file: PROTOCOL }],
        tests: &[
            "crates/plate/tests/main/publication.rs::tilts_in_radians_would_turn_the_plate_over",
            "crates/plate/tests/main/experiments.rs::experiment_1_turns_without_end_and_to_the_side_of_the_published_sign",
            "crates/plate/tests/main/area.rs::experiment_1_gives_the_reference_results",
        ],
        commands: &["bracketry plate 1 --model published", "bracketry plate 1"],
        verdict: Verdict::Ambiguous,
        remark: "θ is in degrees: in radians, the plate would pass the vertical after 0.11 s. θ'' in equation 3.16 \
                 needs radians. ξ is written with exp as a base; it fades the inputs in and damps nothing. Together with \
                 the printed torque, these inputs turn the object away from the goal, to −90°, whichever sense of \
                 the yaw is positive: one of the two signs is wrong. With the derived torque and the yaw from x to y, \
                 they turn it toward the goal.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.20",
        title: "experiment 2, position along x",
        statement: "X = sgn(e) (0.015 + 0.3 |e|) (0.51 − 0.5 cos 2ωt − 0.1 cos 4ωt) ξ, θ = 0; goal: x from 0.48 m to \
                    0.54 m.",
        places: &[
            Place { name: "bracketry_plate::experiment::Experiment::translation_x", file: PROTOCOL },
            Place { name: "bracketry_plate::experiment::AmplitudeStep", file: PROTOCOL },
        ],
        tests: &[
            WRONG_SIGN,
            PERIODS,
            "crates/plate/tests/main/publication.rs::experiment_2_starts_with_a_jump_of_the_velocity",
            "crates/plate/tests/main/experiments.rs::the_jump_of_the_plate_at_a_new_amplitude_matters_little",
            "crates/plate/tests/main/experiments.rs::experiment_2_covers_98_per_cent_of_the_way_at_the_reference_times",
            "crates/plate/tests/main/experiments.rs::experiment_2_ends_in_a_limit_cycle_around_the_target",
        ],
        commands: &["bracketry plate 2 --model published", "bracketry plate 2 --omega 4 --model published"],
        verdict: Verdict::Ambiguous,
        remark: "The sign of e is not defined: with e = x − x_d the object reaches the goal, with the other sign it \
                 moves away. At e = 0 the quotient e/|e| has no value; here the amplitude is 0 there. ω is not \
                 given: 3π and 4π reach the goal. If e is read at all times, X jumps by up to 27 mm where e changes \
                 its sign, and X'' contains x'', so that equation 3.16 is implicit in x'' (solvable, because the \
                 factor of x'' is at least 0.97). Here e is read at the start of each period: X then jumps by at \
                 most 2.7 mm where only the sign changes. With 0.51 instead of 0.6, X' starts with a jump of 3 mm/s. \
                 The amplitude does not vanish with e, so that a cycle around the goal remains.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.21",
        title: "experiment 3, position along y",
        statement: "X = 0, θ = sgn(e) (20 + 200 |e|) (1 − cos 6πt)/2 ξ; goal: y from −0.03 m to 0.",
        places: &[Place { name: "bracketry_plate::experiment::Experiment::translation_y", file: PROTOCOL }],
        tests: &[
            WRONG_SIGN,
            PERIODS,
            "crates/plate/tests/main/experiments.rs::experiment_3_reaches_the_target_or_stalls_as_in_the_reference",
        ],
        commands: &["bracketry plate 3 --model published", "bracketry plate 3 --model published --mu 0.4"],
        verdict: Verdict::Ambiguous,
        remark: "Degrees and e = y − y_d, as in equations 3.19 and 3.20. If e is read at all times, θ jumps by up to \
                 40° where e changes its sign; read at the start of each period, θ does not jump, because it is 0 \
                 there.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.22",
        title: "system that is not affine in its inputs",
        statement: "ẋ = f(x, u, t).",
        places: &[AFFINIZE, MODEL],
        tests: &[
            "crates/system/tests/main/affine.rs::the_plate_needs_four_integrators_and_becomes_a_model_file",
            "crates/system/tests/main/affine.rs::affine_models_are_left_alone",
        ],
        commands: &["bracketry affinize models/plate_published.toml"],
        verdict: Verdict::Ambiguous,
        remark: "This form includes affine systems; not affine means that f(x, u) ≠ f₀(x) + Σ gᵢ(x) uᵢ. The plate \
                 does not have this form with inputs X and θ: their derivatives enter up to order 2. It is \
                 discontinuous where x' or y' vanishes; there it is a differential inclusion.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.23",
        title: "underactuated system",
        statement: "q̈ = f(q, q̇, u, t) with fewer inputs than coordinates, m < n.",
        places: &[MODEL],
        tests: &["crates/cli/tests/main/command.rs::analyze_gives_the_documented_object"],
        commands: &["bracketry analyze models/plate_published.toml"],
        verdict: Verdict::Right,
        remark: "The object has three coordinates, the plate two inputs.",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.3",
        title: "plate with two degrees of freedom",
        statement: "The plate translates by X along x and tilts by θ about x; the object moves in x, y, and yaw.",
        places: &[
            Place { name: "bracketry_plate::PlateKinematics", file: "crates/plate/src/motion/kinematics.rs" },
            Place { name: "bracketry_plate::Object", file: "crates/plate/src/object/prism.rs" },
        ],
        tests: &["crates/plate/tests/main/derivation.rs::motion_in_the_plane"],
        commands: &["bracketry plate 1 --gif --out out"],
        verdict: Verdict::Ambiguous,
        remark: "The object is called deformable, but the equations are those of a rigid body. Its shape, the \
                 friction coefficient, and the sense of the yaw are not given. Here it is a disk of 0.12 m or an \
                 ellipse of 0.15 m × 0.10 m (semi-axes), μ = 0.3 unless stated, and the yaw is positive from x to y.",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.4",
        title: "simulation of experiment 1",
        statement: "Inputs and outputs of equation 3.19; goal: yaw from 0° to 90°.",
        places: &[Place { name: "bracketry_plate::PlateExperiment", file: "crates/plate/src/run/experiment.rs" }],
        tests: &[
            "crates/plate/tests/main/experiments.rs::experiment_1_turns_without_end_and_to_the_side_of_the_published_sign",
            "crates/plate/tests/main/area.rs::experiment_1_gives_the_reference_results",
            "crates/plate/tests/main/experiments.rs::the_two_step_way_reaches_x_and_y_but_keeps_spinning",
        ],
        commands: &["bracketry plate 1 --model published --out out", "bracketry plate 1 --out out"],
        verdict: Verdict::Wrong,
        remark: "The printed equations do not give it: the yaw passes −90° and ends at −20172° after 15 s. With the \
                 sign of the tilt changed, it passes +90° after 2.0 s with a growing spin. With contact over the \
                 whole footprint, the printed inputs turn the disk to 98 % of 90° in 11.6 s and to 121° in 15 s; \
                 they have to be stopped there.",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.5",
        title: "simulation of experiment 2",
        statement: "Inputs and outputs of equation 3.20; goal: x from 0.48 m to 0.54 m.",
        places: &[Place { name: "bracketry_plate::PlateExperiment", file: "crates/plate/src/run/experiment.rs" }],
        tests: &[
            "crates/plate/tests/main/experiments.rs::experiment_2_covers_98_per_cent_of_the_way_at_the_reference_times",
            "crates/plate/tests/main/experiments.rs::experiment_2_ends_in_a_limit_cycle_around_the_target",
            "crates/plate/tests/main/reduced.rs::experiment_2_needs_no_more_than_a_point",
        ],
        commands: &["bracketry plate 2 --model published --out out", "bracketry plate 2 --out out"],
        verdict: Verdict::Right,
        remark: "98 % of the way is covered after 2.37 s with ω = 3π and after 1.50 s with ω = 4π. Then x oscillates \
                 about the goal, by less than 10 mm peak to peak with ω = 3π. Contact over the footprint gives the \
                 same time.",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.6",
        title: "simulation of experiment 3",
        statement: "Inputs and outputs of equation 3.21; goal: y from −0.03 m to 0.",
        places: &[Place { name: "bracketry_plate::PlateExperiment", file: "crates/plate/src/run/experiment.rs" }],
        tests: &[
            "crates/plate/tests/main/experiments.rs::experiment_3_reaches_the_target_or_stalls_as_in_the_reference",
            "crates/plate/tests/main/experiments.rs::the_coriolis_term_of_the_load_gives_the_reference_peak_to_peak",
        ],
        commands: &["bracketry plate 3 --model published --out out", "bracketry plate 3 --out out"],
        verdict: Verdict::Right,
        remark: "98 % of the way is covered after 3.21 s, and after 2.91 s with contact over the footprint. Then y \
                 oscillates by 3.4 mm peak to peak. At μ = 0.4 the object stalls 6.3 mm before the goal.",
    },
];
