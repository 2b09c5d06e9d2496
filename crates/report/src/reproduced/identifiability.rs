//! Identifiability and observability.

use super::row::{Field, Ours, Row, Verdict};

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "two-compartments",
        field: Field::Identifiability,
        subject: "two compartments, input and output in the first",
        reference: "Bellman and Åström 1970",
        claim: "With a loss from the first compartment only, the three rates are identifiable; with losses from both, the \
                four rates are not.",
        ours: Ours::Asserted(
            "three of three rates locally identifiable; with both losses none of four, and one more known rate suffices",
        ),
        tests: &[
            "crates/lie/tests/main/observability.rs::compartments",
            "crates/lie/tests/main/full_identifiability.rs::two_compartments",
        ],
        verdict: Verdict::Same,
        remark: "The second test adds that the three rates are globally identifiable, and which three combinations of the \
                 four are.",
    },
    Row {
        name: "consecutive-reactions",
        field: Field::Identifiability,
        subject: "slow and fast reaction in a row",
        reference: "Vajda and Rabitz 1988",
        claim: "With only the intermediate product of A → B → C measured, the slow and the fast rate may be exchanged.",
        ours: Ours::Asserted("two values for each rate; the other solution exchanges them"),
        tests: &["crates/lie/tests/main/full_identifiability.rs::slow_and_fast_rates_may_be_exchanged"],
        verdict: Verdict::Same,
        remark: "With known initial amounts, both rates are globally identifiable.",
    },
    Row {
        name: "quadratic-system",
        field: Field::Identifiability,
        subject: "homogeneous system of second order",
        reference: "Vajda, Godfrey, and Rabitz 1989",
        claim: "In x₁' = p₁ x₁² + p₂ x₁ x₂ + u, x₂' = p₃ x₁² + p₄ x₁ x₂ with x₁ measured, p₁, p₄, and the product p₂ p₃ are \
                identifiable.",
        ours: Ours::Asserted("p₁, p₄, and p₂ p₃ are identifiable; x₂, p₂, and p₃ may be scaled"),
        tests: &["crates/lie/tests/main/observability.rs::vajdas_quadratic_system"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "epidemic-scale",
        field: Field::Identifiability,
        subject: "epidemic (SIR) measured up to scale",
        reference: "Evans, White, Chapman, Godfrey, and Chappell 2005",
        claim: "With an unknown share of the infectious measured, the rate of infection and the share are not identifiable \
                separately.",
        ours: Ours::Asserted(
            "the rate of recovery is globally identifiable; of the rate of infection and the share, only the quotient",
        ),
        tests: &["crates/lie/tests/main/full_identifiability.rs::an_epidemic_observed_up_to_scale"],
        verdict: Verdict::Same,
        remark: "The publication is about seasonal forcing; here the rate is constant.",
    },
    Row {
        name: "incubation-and-recovery",
        field: Field::Identifiability,
        subject: "epidemic with latency (SEIR)",
        reference: "Dankwa, Brouwer, and Donnelly 2022",
        claim: "With the infectious measured, the rates of incubation and recovery may be exchanged.",
        ours: Ours::Asserted("the rate of infection is globally identifiable; the other two have two values each"),
        tests: &["crates/lie/tests/main/full_identifiability.rs::incubation_and_recovery_may_be_exchanged"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "saturated-elimination",
        field: Field::Identifiability,
        subject: "Michaelis–Menten elimination with unknown volume",
        reference: "Godfrey 1983",
        claim: "With a known dose, the greatest rate, the Michaelis constant, and the volume are globally identifiable.",
        ours: Ours::Asserted("all three globally identifiable; without a dose none is, and two combinations are"),
        tests: &["crates/lie/tests/main/full_identifiability.rs::michaelis_menten_elimination"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "viral-load",
        field: Field::Identifiability,
        subject: "HIV dynamics",
        reference: "Xia and Moog 2003",
        claim: "From the viral load alone, the production rates of healthy cells and of virus are identifiable only as a \
                product.",
        ours: Ours::Asserted(
            "of six parameters two are not identifiable, their product is; with the healthy cells measured too, all are",
        ),
        tests: &[
            "crates/lie/tests/main/observability.rs::the_viral_load_alone_leaves_production_rates_open",
            "crates/lie/tests/main/full_identifiability.rs::hiv_with_the_virus_observed",
        ],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "glucose-and-insulin",
        field: Field::Identifiability,
        subject: "model of glucose and insulin (Bolie 1961)",
        reference: "Massonis and Villaverde 2020",
        claim: "A scaling of the unmeasured state and two parameters changes no output of Bolie's model.",
        ours: Ours::Asserted("scaling of q₂ by s, p₂ by 1/s, and p₄ by s; knowing p₂ suffices"),
        tests: &["crates/lie/tests/main/observability.rs::the_scaling_symmetry_of_bolies_model_is_named"],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "bearings-only",
        field: Field::Identifiability,
        subject: "target seen by its bearing",
        reference: "Nardone and Aidala 1981",
        claim: "The range of a target at constant velocity is not observable from bearings unless the observer accelerates.",
        ours: Ours::Asserted(
            "rank 3 of 4, with the scaling of position and velocity left open; rank 4 with acceleration",
        ),
        tests: &[
            "crates/lie/tests/main/observability.rs::bearings_alone_leave_the_scale_open_unless_the_observer_accelerates",
        ],
        verdict: Verdict::Same,
        remark: "Rank 4 is for generic accelerations.",
    },
];
