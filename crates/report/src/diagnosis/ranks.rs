//! What the extended model changes in what the inputs reach.

use std::fmt::Display;

use bracketry_lie::analysis::RankChange;

/// The dimensions of both models in lines.
pub fn rank_change_text(ranks: &RankChange) -> String {
    let (b, a) = (&ranks.before, &ranks.after);
    let row = |what: &str, before: &dyn Display, after: &dyn Display| format!("  {what}: {before} → {after}\n");
    [
        "What the inputs reach (bracketry analyze), given and extended model\n".to_owned(),
        row("states", &b.states, &a.states),
        row("accessible directions", &b.accessible_dimension, &a.accessible_dimension),
        row("strongly accessible directions", &b.strongly_accessible_dimension, &a.strongly_accessible_dimension),
        row("  in the mode with the smallest dimension", &b.least_in_a_mode, &a.least_in_a_mode),
    ]
    .concat()
}
