//! Optimal control: costs of first plans. The published optima are for continuous time, or for finer control than ours.

use super::row::{Field, Ours, PRINTED, Row, Verdict};

const PUBLISHED: &str = "crates/mpc/tests/main/published_optima.rs::plans_cost_what_is_published";
const FINER: &str = "crates/mpc/tests/main/published_optima.rs::finer_problems_approach_what_is_published";

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "goddard-rocket",
        field: Field::OptimalControl,
        subject: "highest flight of a rocket",
        reference: "Dolan, Moré, and Munson 2004",
        claim: "Final height 1.01283 (COPS 3.0, scaled), reached at time 0.1989.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/goddard_rocket.toml",
            lines: &["-1.01283… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "The final time is fixed at 0.2; the cost is the negative height.",
    },
    Row {
        name: "catalyst-mixing",
        field: Field::OptimalControl,
        subject: "two catalysts along a reactor, a singular arc",
        reference: "Dolan, Moré, and Munson 2004",
        claim: "Lowest cost −0.0480556 (COPS 3.0).",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/catalyst_mixing.toml",
            lines: &["-0.048055… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "hang-glider",
        field: Field::OptimalControl,
        subject: "range of a hang glider in a thermal",
        reference: "Dolan, Moré, and Munson 2004",
        claim: "Range 1248.03 m (COPS 3.0), reached in 98.4 s.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/hang_glider.toml",
            lines: &["-12.476… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "1247.67 m at this fixed time, 0.03 % less, with 60 intervals of constant lift coefficient; the cost is \
                 the negative range in hundreds of meters. The command reports that the solver's tolerance is not \
                 reached, and final height and velocity have tolerances.",
    },
    Row {
        name: "brachistochrone",
        field: Field::OptimalControl,
        subject: "curve of fastest descent",
        reference: "Bryson and Ho 1975",
        claim: "The greatest distance within a time t is g t²/π: 3.12262 m in one second.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/brachistochrone.toml",
            lines: &["-3.122… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "",
    },
    Row {
        name: "bryson-denham",
        field: Field::OptimalControl,
        subject: "double integrator with a bound on the position",
        reference: "Bryson and Ho 1975",
        claim: "With the bound L of the position, the lowest cost is 4/(9 L) for L ≤ 1/6: 4 for L = 1/9.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/bryson_denham.toml",
            lines: &["4.002… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "0.06 % above, with 60 intervals of constant input.",
    },
    Row {
        name: "batch-reactor",
        field: Field::OptimalControl,
        subject: "temperature of a batch reactor",
        reference: "Logsdon and Biegler 1989",
        claim: "Greatest yield of the intermediate product 0.610775.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/batch_reactor.toml",
            lines: &["-0.6106… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "0.02 % less, with 40 intervals of constant temperature.",
    },
    Row {
        name: "two-optima",
        field: Field::OptimalControl,
        subject: "stirred-tank reactor with two local optima",
        reference: "Luus and Galli 1991",
        claim: "The better one of two local optima costs 0.133 (the other one 0.244).",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/luus_cstr.toml",
            lines: &["0.133… predicted"],
        },
        tests: &[PUBLISHED],
        verdict: Verdict::Same,
        remark: "Found from the default guess. The other optimum was not sought.",
    },
    Row {
        name: "orbit-transfer",
        field: Field::OptimalControl,
        subject: "largest circular orbit by low thrust",
        reference: "Bryson and Ho 1975",
        claim: "Radius 1.525 after 3.3207 units of time.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/orbit_transfer.toml",
            lines: &["-1.534… predicted"],
        },
        tests: &[FINER, PRINTED],
        verdict: Verdict::Differs,
        remark: "The problem file asks for a circular orbit by a cost instead of a constraint, which lets the orbit be a \
                 little too large. With a hundred times the weight the cost is −1.5255.",
    },
    Row {
        name: "fed-batch-protein",
        field: Field::OptimalControl,
        subject: "secreted protein of a fed-batch fermenter (Park and Ramirez 1988)",
        reference: "Luus 2000",
        claim: "Greatest amount 32.686.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/park_ramirez.toml",
            lines: &["-32.56… predicted"],
        },
        tests: &[FINER, PRINTED],
        verdict: Verdict::Differs,
        remark: "0.4 % less: the feed is constant over half an hour. With 150 intervals of 0.1 h the amount is 32.69.",
    },
    Row {
        name: "fishing",
        field: Field::OptimalControl,
        subject: "prey and predators that are fished, relaxed input",
        reference: "Sager, Bock, Diehl, Reinelt, and Schlöder 2006",
        claim: "Lowest deviation 1.34408.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/lotka_volterra_fishing.toml",
            lines: &["1.3802… predicted"],
        },
        tests: &[FINER, PRINTED],
        verdict: Verdict::Differs,
        remark: "2.7 % more: the cost is a sum over the starts of the intervals, not an integral. With intervals of 0.05 \
                 and 0.0125 it is 1.3527 and 1.3462, which extrapolates to 1.3440.",
    },
    Row {
        name: "container-crane",
        field: Field::OptimalControl,
        subject: "container crane with little swing (Sakawa and Shindo 1982)",
        reference: "Teo, Goh, and Wong 1991; Luus 2000",
        claim: "Lowest cost 0.00527 within 9 s.",
        ours: Ours::Printed {
            command: "bracketry control benches/peers/problems/smooth/container_crane.toml",
            lines: &["0.00518… predicted"],
        },
        tests: &[FINER, PRINTED],
        verdict: Verdict::Differs,
        remark: "1.7 % less. IPOPT finds 0.005183 for the same discretization (docs/records/known_systems.md), and finer \
                 grids give less still: 0.005153 with intervals of 0.05 s. We take the published cost to be that of a \
                 coarser control, but have not checked this. The command reports that the solver's tolerance is not reached.",
    },
];
