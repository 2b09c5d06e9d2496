//! The reasons, notes and cautions of a diagnosis in words.

use bracketry_diagnose::{
    Caveat, Closeness, Flag, Mispredicted, NoMotion, Note, OtherHold, Outcome, Reason, Regime, Repetition, Rescaling,
    ScaledColumn, significant,
};
use bracketry_sim::Hold;

/// Why there may be no force residual.
const NO_FORCE: &str =
    "no equation has all its states measured, in an even stretch long enough for derivatives above their noise";

/// Why a diagnosis ended with its verdict, in a sentence.
pub(super) fn reason(reason: &Reason) -> String {
    let caveats = reason.caveats.iter().map(|caveat| match caveat {
        Caveat::OtherHold(other) => format!("; but {}", other_hold(other)),
        Caveat::Mispredicted(run) => format!("; but {}", mispredicted(run)),
    });
    std::iter::once(outcome(&reason.outcome)).chain(caveats).collect()
}

fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Noise { parameter_off: false } => {
            "with its parameters refitted, the model leaves no more than noise".to_owned()
        }
        Outcome::Noise { parameter_off: true } => {
            "a parameter is off by more than its tolerance; with it refitted, only noise is left".to_owned()
        }
        Outcome::Correlated { size, parameter_off: true } => format!(
            "a parameter is off by more than its tolerance; with it refitted, a correlated residual of {size:.2} times the noise \
             is left"
        ),
        Outcome::Correlated { size, parameter_off: false } => format!(
            "the residual is correlated ({size:.2} times the noise), but no effect explains it in all parts of the data"
        ),
        Outcome::Explained => "with the named causes the model leaves no more than noise".to_owned(),
        Outcome::PartlyExplained { share, size } => format!(
            "the named causes explain {} of what the refitted model leaves beyond noise; what they leave, {size:.2} times the \
             noise, is still structured",
            most(*share)
        ),
        Outcome::NotBorneOut { size, share } => format!(
            "the refitted model leaves {size:.2} times the noise; effects that explain {} of the excess in the data of \
             the fit predict the held-out data no better",
            most(*share)
        ),
        Outcome::Unexplained { size, share: None } => format!(
            "the refitted model leaves {size:.2} times the noise, and no effect tried explains it significantly"
        ),
        Outcome::Unexplained { size, share: Some(share) } => format!(
            "the refitted model leaves {size:.2} times the noise; the best effects tried explain {} of the excess",
            most(*share)
        ),
        Outcome::PredictsWorse(causes) => {
            let names: Vec<String> = causes.iter().map(ToString::to_string).collect();
            format!(
                "{} explains the data of the fit, but data held out are predicted worse with it at every horizon",
                names.join(" and ")
            )
        }
        Outcome::NoMotion(drive) => {
            let remedy = match drive {
                NoMotion::NoInputs => {
                    "record a run that begins away from rest, long enough for a motion above the noise"
                }
                NoMotion::StillInputs => {
                    "no input moves: drive the device, above its friction and above the noise of its sensors, and record that"
                }
                NoMotion::DrivenInputs => {
                    "the inputs move, but nothing that was measured does: if the device did move, a sensor is dead, or the columns \
                     are not those of its motion; if not, drive it above its friction and above the noise"
                }
            };
            format!(
                "no measured column stands out from its noise, so that the data cannot tell whether the model is right; {remedy}"
            )
        }
    }
}

/// A share as per cent, which is all only if it is.
fn most(share: f64) -> String {
    if (0.995..1.0).contains(&share) { "more than 99.5 %".to_owned() } else { format!("{:.0} %", 100.0 * share) }
}

fn other_hold(other: &OtherHold) -> String {
    let hold = match other.hold {
        Hold::Linear => "straight lines between the samples of the inputs (--hold linear)",
        Hold::Previous => "inputs held from each sample to the next (--hold previous)",
    };
    let left = other.stays.map_or_else(
        || "leaves no more than noise".to_owned(),
        |stays| format!("leaves {:.0} % of the excess", 100.0 * stays),
    );
    format!("with {hold} the model without any cause {left}")
}

fn mispredicted(run: &Mispredicted) -> String {
    let Mispredicted { record, size } = run;
    format!("{record}, which no fit has seen, is mispredicted: the residual there is {size:.3} times the noise")
}

/// What else the reader should know, in a sentence.
pub(super) fn note(note: &Note) -> String {
    match note {
        Note::Repeated { record, first, place } => match place {
            Repetition::InFit => {
                format!(
                    "{record} holds the same data as {first}: it is left out, for repeated data are no further evidence"
                )
            }
            Repetition::FitAndValidation => format!(
                "{record} for validation holds the same data as {first}, which the fit has seen: it does not count as held out"
            ),
            Repetition::InValidation => {
                format!("{record} for validation holds the same data as {first}: it is left out")
            }
        },
        Note::NoiseOfColumn { column, std, factor } => format!(
            "the noise of `{column}` is {std:.2e}, as the residual says, {factor:.2} times what the column alone shows: fitted \
             again with it"
        ),
        Note::Curves(stays) => {
            let stays = if *stays < 1e-3 { "less than 0.1 %".to_owned() } else { format!("{:.1} %", 100.0 * stays) };
            format!(
                "smooth curves through the samples of the inputs leave {stays} of the excess that straight lines do, and take \
                 their place"
            )
        }
        Note::MostCauses { causes, allowed } => format!(
            "the search ended with the {causes} causes that were allowed; more may be there: --max-causes {}",
            2 * allowed
        ),
        Note::NoPlaces => format!("where the model is wrong is not shown: {NO_FORCE}"),
        Note::NoForceError => format!("no force error: {NO_FORCE}"),
        Note::AtLimit { name, value, without_causes } => format!(
            "{name}{} stopped at its limit, {}: the best value lies there or beyond; a wider min or max in the model file, or a \
             value nearer to the truth, lets it move on",
            if *without_causes { " of the model without causes" } else { "" },
            significant(*value, 4)
        ),
        Note::HardlyIdentifiable(names) => format!("the data hardly determine {}: no interval", names.join(", ")),
        Note::NoInterval(names) => format!(
            "no interval of {}: the model misses all parts of the data in the same way, so that resampling them says nothing",
            names.join(", ")
        ),
        Note::ExtendedModel(delay) => format!("extended model: {delay}"),
        Note::OnlyParameters => "gain: only parameters are wrong, so that `before` is the model as given".to_owned(),
        Note::TooShortForGain => "the data are too short to measure the gain on a part of their own".to_owned(),
        Note::StillColumns(names) => format!(
            "{} does not stand out from its noise and carries no information: leave outliers empty, or remove the column",
            names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        ),
        Note::OtherHold(other) => {
            format!("{}: find out how the inputs go on before believing a cause", other_hold(other))
        }
        Note::OtherUnits { columns, size } => {
            let columns: Vec<String> = columns.iter().map(|(column, by)| rescaled(column, *by)).collect();
            format!(
                "units or sign? With {} the model without any cause leaves {size:.1} times the noise: check this column",
                columns.join(", or ")
            )
        }
        Note::Mispredicted(run) => format!(
            "{}: something is there that the data of the fit do not show; diagnose it as data of the fit",
            mispredicted(run)
        ),
    }
}

fn rescaled(column: &ScaledColumn, by: Rescaling) -> String {
    let name = match column {
        ScaledColumn::Column(name) => format!("`{name}`"),
        ScaledColumn::AllMeasured => "everything measured".to_owned(),
    };
    let meaning = match by {
        Rescaling::Sign => "the other sign",
        Rescaling::Thousandths => "thousandths, as mm or mN",
        Rescaling::Thousands => "thousands, as km or kN",
        Rescaling::Degrees => "degrees",
        Rescaling::Radians => "radians where the model wants degrees",
    };
    let factor = format!("{:.4}", by.factor());
    format!("{name} times {} ({meaning})", factor.trim_end_matches('0').trim_end_matches('.'))
}

/// What is odd about a cause or its values, as a clause.
pub(super) fn flag(flag: &Flag) -> String {
    match flag {
        Flag::NoFrictionAtRest(name) => {
            format!("{name} may take away all friction at rest: this is not dry friction")
        }
        Flag::RisingFriction(name) => format!("{name} is negative: friction rises from rest instead of falling"),
        Flag::Unphysical { name, above, nominal } => {
            format!("{name} is not {} {nominal}, as physics requires", if *above { "above" } else { "below" })
        }
        Flag::BeyondHold { half, all } => format!(
            "counted beyond the hold of inputs from sample to sample, which is half a sample, {half:.2e} s, on average: {all:.2e} s \
             in all where logged values are taken for those at their instants"
        ),
        Flag::ParameterAtLimit(name) => {
            format!("{name} stopped at a limit: beyond it, this cause may not be needed")
        }
        Flag::SmallerThanUnknown(cause) => {
            format!("smaller than what remains unnamed, of which {cause} may be the image")
        }
        Flag::OneOfSeveralKinds(cause) => format!(
            "small beside the other causes, and {cause} explains it no better than causes of another kind: its name would be a guess"
        ),
        Flag::HalfSample { lines } => {
            let remedy = if *lines {
                "inputs that are held between samples look like this when they are read as straight lines; try --hold previous"
            } else {
                "check at which moment of the sampling time the inputs were written down"
            };
            format!("the delay is half the sampling time: {remedy}")
        }
    }
}

/// Why a rival cannot be ruled out, as a clause.
pub(super) fn closeness(closeness: Closeness) -> String {
    match closeness {
        Closeness::Equal => "explains these data equally well".to_owned(),
        Closeness::Better(units) => format!("explains these data better by {units:.1} units, but less simply"),
        Closeness::Worse { by, margin } => {
            format!("explains these data worse by {by:.1} units only, where {margin} would rule it out")
        }
        Closeness::LittleMore => "leaves little more, compared with what no cause explains".to_owned(),
    }
}

/// A regime, as `sliding, v > 0`.
pub(super) fn regime(regime: &Regime) -> String {
    let sign = |positive: &bool| if *positive { '>' } else { '<' };
    match regime {
        Regime::Motion { name, sliding, positive } => {
            format!("{}, {name} {} 0", if *sliding { "sliding" } else { "moving" }, sign(positive))
        }
        Regime::Rest { .. } | Regime::Reversal { .. } => format!("{}{}", brief(regime), near_zero(regime)),
        Regime::Rate { name, above, typical } => format!("|{name}'| {} {}", sign(above), significant(*typical, 2)),
        Regime::Third { name, from, to } => match (from, to) {
            (None, Some(to)) => format!("{name} < {}", significant(*to, 2)),
            (Some(from), None) => format!("{name} > {}", significant(*from, 2)),
            (from, to) => {
                let end = |v: &Option<f64>| v.map_or_else(String::new, |v| significant(v, 2));
                format!("{name} {} … {}", end(from), end(to))
            }
        },
        Regime::Tilt { name, positive } => format!("{name} {} 0", sign(positive)),
    }
}

/// A regime as below a bar, where there is no room for the speed up to which a reversal counts as one.
pub(super) fn brief(at: &Regime) -> String {
    match at {
        Regime::Rest { .. } => "at rest".to_owned(),
        Regime::Reversal { .. } => "reversal".to_owned(),
        other => regime(other),
    }
}

fn near_zero(regime: &Regime) -> String {
    match regime {
        Regime::Rest { name, limit } | Regime::Reversal { name, limit } => {
            format!(", |{name}| < {}", significant(*limit, 2))
        }
        _ => String::new(),
    }
}
