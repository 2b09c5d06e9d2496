//! Section 3.1: the stiffness of a robot, and the compensation of its deformation.

use super::entry::{Entry, Kind, Place, Verdict};

const FRAME: &str = "crates/stiffness/src/robot/frame.rs";
const KINEMATICS: &str = "crates/stiffness/src/robot/kinematics.rs";
const DEFORMATION: &str = "crates/stiffness/src/compliance/deformation.rs";
const CARTESIAN: &str = "crates/stiffness/src/identify/cartesian.rs";

const DISPLACED: Place = Place { name: "bracketry_stiffness::displacement_between", file: FRAME };
const PUBLISHED_FIT: Place =
    Place { name: "bracketry_stiffness::CartesianEstimator::WrenchOnDisplacement", file: CARTESIAN };

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        kind: Kind::Equation,
        number: "3.1",
        title: "stiffness",
        statement: "W = K ΔX: wrench = stiffness × displacement of the tool point; K depends on the frame.",
        places: &[
            Place {
                name: "bracketry_stiffness::loaded_compliance",
                file: "crates/stiffness/src/compliance/tangent.rs",
            },
            Place { name: "bracketry_stiffness::CartesianEstimate", file: CARTESIAN },
        ],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::three_angles_are_a_rotation_vector_to_first_order",
            "crates/stiffness/tests/main/publication.rs::a_stiffness_belongs_to_its_pose",
            "crates/stiffness/tests/main/reference.rs::the_loaded_compliance_is_the_derivative_of_the_equilibrium",
            "crates/stiffness/tests/main/identities.rs::displacement_and_rotation_have_the_sign_of_the_load",
        ],
        commands: &[],
        verdict: Verdict::Ambiguous,
        remark: "The three angles and the sign of the wrench are not defined. Here the angles are a rotation vector \
                 about x, y, and z, and the wrench acts on the robot. In the reference pose of the KR 125, under \
                 300, −200, −500 N and 10, −20, 5 N·m, the tool point turns by 1.49 mrad, and roll, pitch, and yaw \
                 differ from the rotation vector by 0.03 % of it. K belongs to its pose: after joint 3 turns by 10°, \
                 it differs by 19 % (Frobenius norm, SI units). Without load K is symmetric, so that 21 of its 36 \
                 entries are independent.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.2",
        title: "wrench and displacement in another frame",
        statement: "W' = A W, ΔX' = a ΔX.",
        places: &[
            Place { name: "bracketry_stiffness::wrench_adjoint", file: FRAME },
            Place { name: "bracketry_stiffness::twist_adjoint", file: FRAME },
        ],
        tests: &[
            "crates/stiffness/tests/main/identities.rs::adjoints_of_twists_and_wrenches_are_dual",
            "crates/stiffness/tests/main/identities.rs::a_compliance_is_carried_to_another_frame_by_congruence",
        ],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The form is right. It gives K' = A K a⁻¹. The work of a wrench is the same in both frames if and \
                 only if aᵀ A = 1; then K' = A K Aᵀ is symmetric with K.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.3",
        title: "the two transport matrices",
        statement: "A = [R, 0; P × R, R] for wrenches, a = [R, 0; 0, R] for displacements, with rotation R and \
                    origin P of the old frame in the new one.",
        places: &[
            Place { name: "bracketry_stiffness::wrench_adjoint", file: FRAME },
            Place { name: "bracketry_stiffness::twist_adjoint", file: FRAME },
        ],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::a_stiffness_keeps_its_energy_only_with_the_lever_of_displacements",
            "crates/stiffness/tests/main/publication.rs::without_the_lever_a_quarter_of_the_displacement_is_missing",
            "crates/stiffness/tests/main/identities.rs::a_twist_adjoint_is_the_derivative_of_conjugation",
        ],
        commands: &[],
        verdict: Verdict::Wrong,
        remark: "A is right. a lacks the coupling of rotation and translation: the new origin also moves by the \
                 rotation times the lever, a = [R, P × R; 0, R]. For the KR 125 in the reference pose, with the load \
                 of equation 3.1 at a tool point 0.3 m in front of the flange, the missing term is 465 µm of 1726 \
                 µm. The stiffness carried from the flange to the tool point is wrong by 20 %, and its unsymmetric \
                 part K − Kᵀ is 25 % of it (Frobenius norm, SI units). The energy ½ ΔXᵀ K ΔX then depends on the \
                 frame. If ΔX' is read as the displacement of the old origin in the new axes, a is right, but W' and \
                 ΔX' then belong to different points, and W' = K' ΔX' does not hold.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.4",
        title: "wrench at each component",
        statement: "Fⱼ = R Fᵢ, Tⱼ = R (Fᵢ × P + Tᵢ), with the rotation R of frame i and the origin P of frame j in \
                    frame i.",
        places: &[
            Place { name: "bracketry_stiffness::Kinematics::wrench_at", file: KINEMATICS },
            Place { name: "bracketry_stiffness::Springs", file: "crates/stiffness/src/compliance/spring.rs" },
        ],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::the_wrench_of_a_component_is_the_transported_one",
            "crates/stiffness/tests/main/identities.rs::a_torque_is_the_load_s_power_per_rate_and_the_wrench_along_the_axis",
        ],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The order of the cross product is right, because the lever from frame j to the force is −P. The \
                 equation is A of equation 3.3. The displacement of each component follows from its wrench only if \
                 each component has a stiffness of its own. The stiffness of the tool point, equation 3.1, does not \
                 provide these. Here every joint has a spring and every link may have a compliance.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.5",
        title: "pose of the loaded robot",
        statement: "The pose of the end effector is the product of the six deformed transforms.",
        places: &[
            Place { name: "bracketry_stiffness::Deformation::product", file: DEFORMATION },
            Place { name: "bracketry_stiffness::Deformation::equilibrium", file: DEFORMATION },
        ],
        tests: &[
            "crates/stiffness/tests/main/reference.rs::the_three_deformations_have_the_computed_values",
            "crates/stiffness/tests/main/identities.rs::the_three_deformations_agree_to_first_order_in_the_load",
        ],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The wrenches of equation 3.4 are those of the unloaded pose. In equilibrium they are those of the \
                 loaded pose. In the reference pose of the KR 125, with the load of equation 3.1, the displacement \
                 along z is −1.25858 mm in equilibrium and −1.25969 mm by the product; the difference is of second \
                 order in the load.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.6",
        title: "displacement of the end effector",
        statement: "ΔP = P − P', ΔR = R⁻¹ R', with the primed pose under load.",
        places: &[DISPLACED],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::opposite_senses_of_position_and_rotation_make_an_indefinite_stiffness",
            "crates/stiffness/tests/main/identities.rs::displacements_lead_from_pose_to_pose",
        ],
        commands: &[],
        verdict: Verdict::Wrong,
        remark: "ΔP leads from the loaded pose to the unloaded one, ΔR from the unloaded to the loaded one. ΔR is \
                 also in the axes of the end effector, ΔP in those of the base. With exact data and translations of \
                 the opposite sense, equation 3.15 gives a stiffness of the KR 125 that is wrong by 163 % (Frobenius \
                 norm, SI units) and indefinite; with rotations in the axes of the end effector as well, wrong by \
                 175 %. As a correction that is added to the reference, ΔP has the right sense and ΔR the wrong one. \
                 Here both lead from the first pose to the second one, in the same axes.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.7",
        title: "displacement of each frame",
        statement: "The same as equation 3.6 for the frame of joint i.",
        places: &[Place { name: "bracketry_stiffness::Deformation", file: DEFORMATION }, DISPLACED],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::a_frame_moves_with_all_joints_before_it",
            "crates/stiffness/tests/main/publication.rs::opposite_senses_of_position_and_rotation_make_an_indefinite_stiffness",
        ],
        commands: &[],
        verdict: Verdict::Wrong,
        remark: "The senses and axes differ as in equation 3.6. Moreover, the result is not the deflection of joint \
                 i: the frame moves with all joints before it. In the reference pose of the KR 125, with the load of \
                 equation 3.1, frame 6 turns by 1.49 mrad and joint 6 by 0.03 mrad. Deformation has both, as frames \
                 and deflections.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.8",
        title: "measured wrench and displacement",
        statement: "W = (forces, moments), ΔX = (translations, angles), both complete and in the same frame.",
        places: &[Place {
            name: "bracketry_stiffness::Measurement",
            file: "crates/stiffness/src/identify/measurement.rs",
        }],
        tests: &[
            "crates/stiffness/tests/main/identify_refusals.rs::directions_that_were_never_loaded_are_named",
            "crates/stiffness/tests/main/identify_cartesian.rs::estimates_do_not_depend_on_units_or_axes",
        ],
        commands: &["bracketry stiffness identify measurements.csv models/kr125.toml --out out"],
        verdict: Verdict::Right,
        remark: "The frame includes the point: forces and moments refer to the point whose translation is measured. \
                 The entries have different units; the estimates here do not depend on them.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.9",
        title: "fitting error",
        statement: "e = Σ eᵢᵀ eᵢ = Σ Wᵢ Wᵢᵀ − (Σ ΔXᵢ Wᵢᵀ)ᵀ K.",
        places: &[Place { name: "bracketry_stiffness::CartesianEstimate", file: CARTESIAN }],
        tests: &["crates/stiffness/tests/main/publication.rs::the_fitting_error_has_the_transpose_of_the_stiffness"],
        commands: &[],
        verdict: Verdict::Wrong,
        remark: "The left side is a number, the right side a matrix. The matrix is Σ eᵢ eᵢᵀ, but only at the \
                 solution of equation 3.15, and only with Kᵀ for K; the number is its trace. The fitted K is not \
                 symmetric. With 200 noisy measurements of the KR 125, the trace with K as printed is more than ten \
                 times the sum of squares. Here the residuals are weighted with their noise, so that the error has \
                 no unit (chi_square).",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.10",
        title: "transposed stiffness equation",
        statement: "Wᵀ = ΔXᵀ Kᵀ.",
        places: &[PUBLISHED_FIT],
        tests: &["crates/stiffness/tests/main/publication.rs::the_gradient_of_the_sum_of_squares_is_the_published_one"],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The transpose of equation 3.1.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.11",
        title: "objective",
        statement: "S(K) = ‖Wᵀ − ΔXᵀ Kᵀ‖².",
        places: &[PUBLISHED_FIT],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::the_gradient_of_the_sum_of_squares_is_the_published_one",
            "crates/stiffness/tests/main/identify_cartesian.rs::estimates_do_not_depend_on_units_or_axes",
        ],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The sum of squares of one measurement, or of several as rows. It adds N² and (N·m)². Its minimum \
                 does not depend on the units: all entries of K are free, so that every row of W is fitted by \
                 itself.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.12",
        title: "objective, expanded",
        statement: "S(K) = (Wᵀ − ΔXᵀ Kᵀ)ᵀ (Wᵀ − ΔXᵀ Kᵀ) = W Wᵀ − W ΔXᵀ Kᵀ − K ΔX Wᵀ + K ΔX ΔXᵀ Kᵀ.",
        places: &[PUBLISHED_FIT],
        tests: &["crates/stiffness/tests/main/publication.rs::the_gradient_of_the_sum_of_squares_is_the_published_one"],
        commands: &[],
        verdict: Verdict::Ambiguous,
        remark: "The expansion is right, but the product is a 6 × 6 matrix. S is its trace.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.13",
        title: "gradient",
        statement: "−2 ΔX Wᵀ + 2 ΔX ΔXᵀ Kᵀ = 0.",
        places: &[PUBLISHED_FIT],
        tests: &["crates/stiffness/tests/main/publication.rs::the_gradient_of_the_sum_of_squares_is_the_published_one"],
        commands: &[],
        verdict: Verdict::Right,
        remark: "The gradient of the trace with respect to Kᵀ. With respect to K, it is transposed.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.14",
        title: "solution for one measurement",
        statement: "Kᵀ = (ΔX ΔXᵀ)⁻¹ ΔX Wᵀ.",
        places: &[PUBLISHED_FIT],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::one_displacement_has_no_inverse",
            "crates/stiffness/tests/main/identify_refusals.rs::too_few_measurements_and_several_poses_are_refused",
        ],
        commands: &[],
        verdict: Verdict::Ambiguous,
        remark: "For one measurement, ΔX ΔXᵀ has rank 1 and no inverse. If W and ΔX have a column for each of N ≥ 6 \
                 measurements with independent displacements, the equation is right, and the same as equation 3.15. \
                 identify_cartesian requires seven.",
    },
    Entry {
        kind: Kind::Equation,
        number: "3.15",
        title: "least-squares stiffness",
        statement: "Kᵀ = (Σ ΔXᵢ ΔXᵢᵀ)⁻¹ (Σ ΔXᵢ Wᵢᵀ).",
        places: &[
            PUBLISHED_FIT,
            Place { name: "bracketry_stiffness::identify_cartesian", file: CARTESIAN },
            Place { name: "bracketry_stiffness::compare", file: "crates/stiffness/src/identify/comparison.rs" },
        ],
        tests: &[
            "crates/stiffness/tests/main/publication.rs::the_noise_of_displacements_makes_the_published_stiffness_too_small",
            "crates/stiffness/tests/main/identify_cartesian.rs::the_published_estimator_is_biased_and_the_others_are_not",
            "crates/stiffness/tests/main/identify_cartesian.rs::the_comparison_distrusts_the_published_estimator_and_foresees_its_error",
        ],
        commands: &["bracketry stiffness identify measurements.csv models/kr125.toml --out out"],
        verdict: Verdict::Wrong,
        remark: "The algebra is right, the estimate is biased: W is regressed on ΔX, and the noise of ΔX makes K too \
                 small, however many measurements there are (errors in variables). For the KR 125 with loads to 1000 \
                 N and 60 N·m and noise of 20 µm and 50 µrad, the error of K tends to 73 % (Frobenius norm, SI \
                 units); in the direction that is least visible in ΔX, a share of 0.105 of K remains. With moments \
                 to 20 N·m, the stiffnesses about x and z are 94 % too small. The deformation that K predicts \
                 suffers less: under forces at the tool point it is right within 0.5 %, under the moments of \
                 equation 3.1 alone it is wrong by 13 % in position and 43 % in rotation. ΔX on W is nearly free of \
                 bias, because loads are measured well; the positive definite fit and the fit of joint springs are \
                 consistent (docs/records/stiffness_identification.md).",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.1",
        title: "compensation of the deformation",
        statement: "The filtered process wrench gives the deformation, by which the joint references are corrected.",
        places: &[
            Place { name: "bracketry_stiffness::Compensator", file: "crates/stiffness/src/compensate/compensator.rs" },
            Place { name: "bracketry_stiffness::stability", file: "crates/stiffness/src/compensate/stability.rs" },
        ],
        tests: &[
            "crates/stiffness/tests/main/compensate.rs::the_loaded_tool_stands_at_the_reference",
            "crates/stiffness/tests/main/compensate.rs::weight_and_bias_move_nothing",
            "crates/stiffness/tests/main/compensate.rs::the_loop_through_the_process_converges_where_its_gain_is_below_one",
        ],
        commands: &["bracketry stiffness compensate circle_log.csv models/kr125.toml --process-stiffness 5e4"],
        verdict: Verdict::Right,
        remark: "The correction of the references by the deflections is exact for joint springs if the deflections \
                 are those under the reference pose. The figure shows no loop, but there is one: the correction \
                 changes the cut and thus the force. The command states whether this loop is stable.",
    },
    Entry {
        kind: Kind::Figure,
        number: "3.2",
        title: "milled circle",
        statement: "A circle with a radius of 35 mm, milled with and without compensation; the compensation halves \
                    the error.",
        places: &[Place { name: "bracketry_stiffness::MillingCircle", file: "crates/stiffness/src/milling/circle.rs" }],
        tests: &[
            "crates/stiffness/tests/main/compensate_circle.rs::thirty_percent_of_stiffness_error_leave_half_of_the_gain",
            "crates/stiffness/tests/main/compensate_circle.rs::ten_percent_of_stiffness_error_leave_four_fifths_of_the_gain",
        ],
        commands: &[],
        verdict: Verdict::Ambiguous,
        remark: "The measured curves are not given as numbers, so that only their ratio can be compared, on a \
                 simulated circle. Half of the error is plausible: with stiffnesses wrong by up to 30 %, at least 50 \
                 % of the radial error is removed; by up to 10 %, at least 80 % (docs/records/stiffness_circle.md).",
    },
];
