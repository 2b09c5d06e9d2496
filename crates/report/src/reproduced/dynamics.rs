//! Dynamics, friction, contact, stiffness, and stability.

use super::row::{Field, Ours, Row, Verdict};

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "robertson",
        field: Field::Dynamics,
        subject: "stiff chemical reaction",
        reference: "Mazzia and Magherini 2008",
        claim: "Reference solution of Robertson's problem (Hairer and Wanner 1996) at t = 40: 0.7158270687194135, \
                9.185534764557338e-6, 0.2841637457458291.",
        ours: Ours::Asserted(
            "equal within 1e-8 of each value plus 1e-10, in fewer than 1000 steps; the sum stays 1 within 1e-11",
        ),
        tests: &["crates/sim/tests/main/stiff.rs::the_reaction_of_robertson_ends_where_it_should_and_loses_nothing"],
        verdict: Verdict::Same,
        remark: "The second value therefore agrees to about 1e-5. At t = 1e11 the values agree within 1e-10.",
    },
    Row {
        name: "van-der-pol-stiff",
        field: Field::Dynamics,
        subject: "relaxation oscillations of Van der Pol",
        reference: "Mazzia and Magherini 2008",
        claim: "Reference solution for the factor 1000 at t = 2000: 1.706167732170483 and −8.928097010247975e-4.",
        ours: Ours::Asserted("equal within 1e-7 and 1e-9, in fewer than 5000 steps"),
        tests: &["crates/sim/tests/main/stiff.rs::relaxation_oscillations_take_some_thousand_steps"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "order-five",
        field: Field::Dynamics,
        subject: "embedded Runge–Kutta pair",
        reference: "Dormand and Prince 1980",
        claim: "The solution converges with order 5.",
        ours: Ours::Asserted(
            "orders observed on a pendulum are within 0.5 of 5; above 4.4 across stops and breakaways of dry friction",
        ),
        tests: &[
            "crates/sim/tests/main/convergence.rs::smooth_motion_converges_with_order_five",
            "crates/sim/tests/main/convergence.rs::the_order_holds_across_stops_and_breakaways",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "diode-and-resistor",
        field: Field::Dynamics,
        subject: "diode with a resistor in series",
        reference: "Banwell and Jayakumar 2000",
        claim: "The current has a closed form with Lambert's function W.",
        ours: Ours::Asserted("the current of the model with an algebraic equation equals the closed form to 1e-8"),
        tests: &["crates/sim/tests/main/implicit.rs::a_diode_with_a_resistor_has_the_current_of_lambert_w"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "sliding-and-spinning",
        field: Field::Dynamics,
        subject: "disk that slides and spins with dry friction",
        reference: "Farkas, Bartels, Unger, and Wolf 2003",
        claim: "Sliding and spinning of a uniform disk end together, and the ratio of speed to rate times radius tends to 0.653, \
                whatever the start.",
        ours: Ours::Asserted(
            "both end together; from 0.4, 0.653, and 0.9 the ratio tends to 0.653 until the last milliseconds",
        ),
        tests: &["crates/plate/tests/main/area.rs::sliding_and_spinning_end_together_at_the_known_ratio"],
        verdict: Verdict::Same,
        remark: "Four fifths of the deviation from 0.653 are gone a few steps of 1 ms before the stop (or it is below 0.01).",
    },
    Row {
        name: "rocking-block",
        field: Field::Dynamics,
        subject: "block that rocks on its edges",
        reference: "Housner 1963",
        claim: "At each impact the rate falls by the factor 1 − (3/2) sin² α, tan α = width/height, if the block neither slips nor \
                bounces.",
        ours: Ours::Asserted(
            "the energy lost at the first impact agrees within 1 %, its fall from the first to the second within 2 %",
        ),
        tests: &[
            "crates/plate/tests/main/body.rs::a_rocking_block_loses_at_each_impact_what_angular_momentum_about_the_new_edge_says",
        ],
        verdict: Verdict::Same,
        remark: "Within the tolerances of the test, which are wider than 0.1 %.",
    },
    Row {
        name: "friction-by-direction",
        field: Field::Dynamics,
        subject: "electro-mechanical positioning system (EMPS)",
        reference: "Janot, Gautier, and Brunot 2019",
        claim: "Viscous friction is 240.42 N s/m in one direction and 166.71 N s/m in the other: half the difference is 36.9 N s/m.",
        ours: Ours::Asserted("half the difference is 37 ± 4 N s/m, from a model that is 30 % to 50 % off"),
        tests: &[
            "crates/cli/tests/main/diagnose_real.rs::friction_by_direction_a_delay_and_a_concave_law_are_found_in_measured_data",
        ],
        verdict: Verdict::Same,
        remark: "The command of docs/records/diagnose_real.md gives 36.5 ± 0.9 N s/m. The measured data are not part of the \
                 repository; without them the test passes without a check.",
    },
    Row {
        name: "stiffness-under-load",
        field: Field::Dynamics,
        subject: "stiffness of a loaded robot",
        reference: "Chen and Kao 2000",
        claim: "The stiffness of the joints and that of the tool point belong together only with a term of the load, from the change \
                of the Jacobian (conservative congruence transformation).",
        ours: Ours::Asserted(
            "with this term, the compliance of the KR 125 is the derivative of its loaded equilibrium, to 1e-6",
        ),
        tests: &[
            "crates/stiffness/tests/main/reference.rs::the_loaded_compliance_is_the_derivative_of_the_equilibrium",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "reversed-van-der-pol",
        field: Field::Dynamics,
        subject: "region of attraction of the reversed Van der Pol oscillator",
        reference: "Khalil 2002",
        claim: "V = 1.5 x² − x y + y² proves that V < 2.25 is a region of attraction (example 8.9).",
        ours: Ours::Asserted("a quadratic function proves V < c with c between 2.2 and 2.35, in exact arithmetic"),
        tests: &[
            "crates/certify/tests/main/literature.rs::the_reversed_van_der_pol_oscillator_has_the_known_quadratic_region",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "no-polynomial-function",
        field: Field::Dynamics,
        subject: "stable system without a polynomial Lyapunov function",
        reference: "Ahmadi, Krstic, and Parrilo 2011",
        claim: "x' = −x + x y, y' = −y is globally asymptotically stable, but has no polynomial Lyapunov function.",
        ours: Ours::Asserted("no function up to degree 4 is found, and a region of attraction is proved"),
        tests: &[
            "crates/certify/tests/main/literature.rs::a_stable_system_without_polynomial_lyapunov_function_is_not_called_unstable",
        ],
        verdict: Verdict::Same,
        remark: "The command does not decide global stability of this system.",
    },
];
