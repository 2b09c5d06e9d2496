//! The reasons, notes and cautions of a diagnosis in words.

use bracketry_diagnose::{
    Caveat, Closeness, ColumnFault, Combination, Doubt, Flag, Mispredicted, NoMotion, Note, OtherHold, OtherUnit,
    Outcome, Regime, Repetition, Rescaling, ScaledColumn, SmallGain, TemperatureScale, VerdictReason, significant,
};
use bracketry_sim::Hold;
use bracketry_system::readable;

/// Why there may be no force residual.
const NO_FORCE: &str = "no equation has all its states measured over an evenly sampled section long enough for \
    derivatives above the noise";

/// Why a diagnosis ended with its verdict, in a sentence.
pub(super) fn reason(reason: &VerdictReason) -> String {
    let caveats = reason.caveats.iter().map(|caveat| match caveat {
        Caveat::OtherHold(other) => format!("; but {}", other_hold(other)),
        Caveat::Mispredicted(run) => format!("; but {}", mispredicted(run)),
        Caveat::SmallGain(gain) => format!(
            "; but {}: the terms keep no name; record runs in which the model fails more clearly, or repeat with --window {}",
            small_gain(gain),
            significant(0.25 * gain.horizon, 2)
        ),
        Caveat::Doubtful(doubt) => format!("; but {}: the terms keep no name", doubtful(doubt)),
    });
    std::iter::once(outcome(&reason.outcome)).chain(caveats).collect()
}

fn doubtful(doubt: &Doubt) -> String {
    match doubt {
        Doubt::Share(share) => format!(
            "terms that leave {:.0} % unexplained may stand for something that is not in the library",
            100.0 * (1.0 - share)
        ),
        Doubt::Noise { before, after } => {
            format!("the residual is {after:.2} times its noise with them and {before:.2} times without them")
        }
        Doubt::ForceError { before, after } => {
            format!("they raise the force error from {:.3} % to {:.3} %", 100.0 * before, 100.0 * after)
        }
        Doubt::AtLimit(name) => format!("{name} stopped at a limit"),
    }
}

fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Noise { parameter_off: false } => {
            "with refitted parameters, the residual is at noise level".to_owned()
        }
        Outcome::Noise { parameter_off: true } => {
            "a parameter is off by more than its tolerance; with it refitted, the residual is at noise level".to_owned()
        }
        Outcome::Correlated { size, parameter_off: true } => format!(
            "a parameter is off by more than its tolerance; with it refitted, a correlated residual of {size:.2} \
             times the noise remains"
        ),
        Outcome::Correlated { size, parameter_off: false } => format!(
            "the residual is correlated ({size:.2} times the noise), but no effect explains it in all parts of the data"
        ),
        Outcome::Explained => "with the causes found, the residual is at noise level".to_owned(),
        Outcome::PartlyExplained { share, size } => format!(
            "what was found explains {} of the excess of the refitted model (its squared residual above the noise); \
             the remaining residual, {size:.2} times the noise, is {}",
            most(*share),
            if *size < 1.05 { "as small as noise but still correlated" } else { "still structured" }
        ),
        Outcome::NotBorneOut { size, share } => format!(
            "the residual of the refitted model is {size:.2} times the noise; effects that explain {} of the excess \
             in the fitted data do not improve the predictions of held-out data",
            most(*share)
        ),
        Outcome::Unexplained { size, share: None } => format!(
            "the residual of the refitted model is {size:.2} times the noise, and no effect tried explains it \
             significantly"
        ),
        Outcome::Unexplained { size, share: Some(share) } => format!(
            "the residual of the refitted model is {size:.2} times the noise; the best effects tried explain {} of \
             the excess",
            most(*share)
        ),
        Outcome::NoGain { causes, gain } => {
            let names: Vec<String> = causes.iter().map(ToString::to_string).collect();
            let explain = if names.len() == 1 { "explains" } else { "explain" };
            format!(
                "{} {explain} the fitted data, but {}: not named; fit more runs, or runs that differ more",
                names.join(" and "),
                small_gain(gain)
            )
        }
        Outcome::WrongColumns { fault, size, corrected } => {
            let as_it_is = size.map_or_else(
                || "the model cannot be simulated over these data".to_owned(),
                |size| format!("the residual of the refitted model is {size:.2} times the noise"),
            );
            format!(
                "{as_it_is}; with {}, the residual is {corrected:.2} times the noise: correct the file, or the model, and repeat the diagnosis",
                read_as(fault)
            )
        }
        Outcome::NoMotion(drive) => {
            let remedy = match drive {
                NoMotion::NoInputs => {
                    "record a run that starts away from rest and is long enough for a motion above the noise"
                }
                NoMotion::StillInputs => {
                    "no input moves: drive the device above its friction and above the noise of its sensors, and \
                     record that run"
                }
                NoMotion::DrivenInputs => {
                    "the inputs move, but no measurement does: if the device moved, a sensor is dead or the columns \
                     belong to other signals; if not, drive it above its friction and above the noise"
                }
            };
            format!(
                "no measured column exceeds its noise, so the data cannot show whether the model is right; {remedy}"
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
        Hold::Linear => "linear interpolation between the samples of the inputs (--hold linear)",
        Hold::Previous => "inputs held from each sample to the next (--hold previous)",
    };
    let left = other.stays.map_or_else(
        || "has a residual at noise level".to_owned(),
        |stays| format!("leaves {:.0} % of the excess", 100.0 * stays),
    );
    format!("with {hold}, the model without causes {left}")
}

fn small_gain(gain: &SmallGain) -> String {
    let SmallGain { horizon, before, after } = gain;
    let per_cent = |error: f64| significant(100.0 * error, 3);
    format!(
        "over a horizon of {}, held-out data are predicted with an error of {} % instead of {} %",
        significant(*horizon, 3),
        per_cent(*after),
        per_cent(*before)
    )
}

fn mispredicted(run: &Mispredicted) -> String {
    let Mispredicted { record, size } = run;
    format!("{record}, which was not fitted, is mispredicted: its residual is {size:.3} times the noise")
}

/// A combination of parameters that has left its tolerance, in sentences.
pub(super) fn combination(combination: &Combination) -> Vec<String> {
    let Combination { weights, change, std, tolerance, as_given, alone } = combination;
    let parts: Vec<String> =
        weights.iter().map(|(name, w)| format!("{} Δ{name}/{name}", significant(*w, 2).replace('-', "−"))).collect();
    let names: Vec<&str> = weights.iter().map(|(name, _)| name.as_str()).collect();
    let percent = |v: f64| significant(100.0 * v, 4);
    let mut lines = Vec::new();
    if names.len() > 1 {
        lines.push(format!(
            "base parameter: the data determine a combination of {}, not each of them",
            names.join(", ")
        ));
    }
    lines.push(format!(
        "its relative change {} = {} ± {} % (95 %: {} … {}); with every parameter within {tolerance} %, it is, too",
        parts.join(" + ").replace("+ −", "− "),
        percent(*change),
        significant(100.0 * std, 2),
        percent(change - 1.96 * std),
        percent(change + 1.96 * std),
        tolerance = readable(100.0 * tolerance)
    ));
    if let Some(size) = as_given {
        lines.push(format!("the model as given leaves {size:.2} times the noise"));
    }
    if alone.is_empty() {
        lines.push("no single one of them explains the data with the others as given".to_owned());
    } else {
        let values: Vec<String> = alone.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        lines.push(format!("with all others as given, the data are explained by {}", values.join(", or by ")));
    }
    lines
}

/// What else the reader should know, in a sentence.
pub(super) fn note(note: &Note) -> String {
    match note {
        Note::Repeated { record, first, place } => match place {
            Repetition::InFit => {
                format!("{record} holds the same data as {first}: omitted, because repeated data add no evidence")
            }
            Repetition::FitAndValidation => format!(
                "{record} for validation holds the same data as {first}, which was fitted: it does not count as held \
                 out"
            ),
            Repetition::InValidation => {
                format!("{record} for validation holds the same data as {first}: omitted")
            }
        },
        Note::Outliers { record, warning } => format!("{record}: {}: {}", warning.message(), warning.remedy()),
        Note::NoiseOfColumn { column, std, factor } => format!(
            "the noise of `{column}` is {std:.2e} according to the residual, {factor:.2} times the estimate from the \
             column alone: refitted with this value"
        ),
        Note::Curves(stays) => {
            let stays = if *stays < 1e-3 { "less than 0.1 %".to_owned() } else { format!("{:.1} %", 100.0 * stays) };
            format!(
                "smooth curves through the samples of the inputs leave {stays} of the excess that straight lines \
                 leave, and replace them"
            )
        }
        Note::MostCauses { causes, allowed } => format!(
            "the search stopped at the limit of {causes} causes; there may be more: repeat `bracketry diagnose` with `--max-causes {}`",
            2 * allowed
        ),
        Note::NoPlaces => format!("the residual cannot be localized by regime: {NO_FORCE}"),
        Note::NoForceError => format!("no force error: {NO_FORCE}"),
        Note::AtLimit { name, value, without_causes } => format!(
            "{name}{} stopped at its limit, {}: the best value lies there or beyond; widen min or max in the model \
             file, or give a value closer to the true one",
            if *without_causes { " of the model without causes" } else { "" },
            significant(*value, 4)
        ),
        Note::HardlyIdentifiable(names) => format!("the data hardly determine {}: no interval", names.join(", ")),
        Note::OnlyInCombination(names) => format!(
            "the data determine {} only in combination with other parameters (base parameters): no interval; --fix, or \
             fixed = true in the model file, states what is known",
            names.join(", ")
        ),
        Note::HorizonsTooLong(horizons) => {
            let horizons: Vec<String> = horizons.iter().map(|h| significant(*h, 3)).collect();
            format!(
                "no predictions over horizons of {}: the held-out data are shorter; give shorter horizons (--horizon)",
                horizons.join(" and ")
            )
        }
        Note::Fixed(names) => format!("kept as given, not fitted: {}", names.join(", ")),
        Note::NoInterval(names) => format!(
            "no interval for {}: resampled windows agree more closely than the standard deviation allows",
            names.join(", ")
        ),
        Note::ExtendedModel(delay) => format!("extended model: {delay}"),
        Note::OnlyParameters => "gain: only parameters are wrong, so `before` is the model as given".to_owned(),
        Note::ShorterWindows { seconds, used } => format!(
            "found in windows with a length of {}: in windows of {}, the residual stays unexplained (--window)",
            significant(*seconds, 3),
            significant(*used, 3)
        ),
        Note::TimeLimit { seconds, left_out } => format!(
            "time limit of {} s reached: at least {left_out} fits were left out, and other causes, or rivals of these, may explain the data \
             better (--time-limit)",
            significant(*seconds, 3)
        ),
        Note::Interrupted { left_out } => format!(
            "interrupted: at least {left_out} fits were left out, and other causes, or rivals of these, may explain the data better"
        ),
        Note::TooShortForGain => "the data are too short to measure the gain on a separate part".to_owned(),
        Note::StillColumns(names) => format!(
            "{} {}",
            names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
            if names.len() == 1 {
                "does not exceed its noise and carries no information: leave outliers empty, or remove the column"
            } else {
                "do not exceed their noise and carry no information: leave outliers empty, or remove the columns"
            }
        ),
        Note::OtherHold(other) => {
            format!("{}: check how the inputs act between samples before accepting a cause", other_hold(other))
        }
        Note::Mispredicted(run) => format!(
            "{}: it contains an effect that the fitted data do not show; include it in the fit",
            mispredicted(run)
        ),
    }
}

/// How columns are to be read, as a clause after "with".
fn read_as(fault: &ColumnFault) -> String {
    match fault {
        ColumnFault::Scaled { columns, by } => rescaled(columns, *by),
        ColumnFault::Swapped { first, second } => format!("`{first}` and `{second}` exchanged"),
        ColumnFault::OtherQuantity { column, quantity } => {
            format!("`{column}` read as a measurement of {quantity}")
        }
    }
}

fn rescaled(column: &ScaledColumn, by: Rescaling) -> String {
    let name = match column {
        ScaledColumn::Column(name) => format!("`{name}`"),
        ScaledColumn::AllMeasured => "all measured columns".to_owned(),
    };
    let meaning = match by {
        Rescaling::Sign => return format!("the other sign of {name}"),
        Rescaling::PowerOfTen(-3) => "thousandths, such as mm or mN".to_owned(),
        Rescaling::PowerOfTen(3) => "thousands, such as km or kN".to_owned(),
        Rescaling::PowerOfTen(-2) => "hundredths, such as cm or percent".to_owned(),
        Rescaling::PowerOfTen(2) => "the model is in hundredths, such as cm or percent".to_owned(),
        Rescaling::Unit(OtherUnit::Minutes) => "minutes, or the model is per minute".to_owned(),
        Rescaling::UnitOfModel(OtherUnit::Minutes) => "it is per minute, or the model is in minutes".to_owned(),
        Rescaling::PowerOfTen(n) => format!("10^{n} of the unit"),
        Rescaling::Unit(unit) => unit_words(unit).to_owned(),
        Rescaling::UnitOfModel(unit) => format!("the model is in {}", unit_words(unit)),
        Rescaling::Temperature { from, to } => {
            return format!("{name} read in {} and the model in {}", scale_words(from), scale_words(to));
        }
    };
    format!("{name} times {} ({meaning})", significant(by.factor(), 5))
}

fn scale_words(scale: TemperatureScale) -> &'static str {
    match scale {
        TemperatureScale::Kelvin => "kelvin",
        TemperatureScale::Celsius => "degrees Celsius",
        TemperatureScale::Fahrenheit => "degrees Fahrenheit",
    }
}

fn unit_words(unit: OtherUnit) -> &'static str {
    match unit {
        OtherUnit::Degrees => "degrees",
        OtherUnit::Revolutions => "revolutions",
        OtherUnit::RevolutionsPerMinute => "revolutions per minute",
        OtherUnit::Minutes => "minutes",
        OtherUnit::Inches => "inches",
        OtherUnit::KilometersPerHour => "kilometers per hour",
        OtherUnit::StandardGravity => "multiples of the standard gravity",
    }
}

/// What is odd about a cause or its values, as a clause.
pub(super) fn flag(flag: &Flag) -> String {
    match flag {
        Flag::NoFrictionAtRest(name) => {
            format!("{name} may remove all friction at rest: this is not dry friction")
        }
        Flag::RisingFriction(name) => format!("{name} is negative: friction rises from rest instead of falling"),
        Flag::Unphysical { name, above, nominal } => {
            format!("{name} is not {} {nominal}, as physics requires", if *above { "above" } else { "below" })
        }
        Flag::BeyondHold { half, all } => format!(
            "in addition to the mean delay of held inputs, half a sample ({half:.2e}): {all:.2e} in total if \
             logged values are taken as instantaneous"
        ),
        Flag::ParameterAtLimit(name) => {
            format!("{name} stopped at a limit; with a wider limit, this cause may not be needed")
        }
        Flag::SmallerThanUnknown(cause) => {
            format!("smaller than the unnamed remainder; {cause} may be an artifact of it")
        }
        Flag::OneOfSeveralKinds(cause) => format!(
            "small compared with the other causes, and {cause} explains it no better than causes of another kind: \
             naming it would be a guess"
        ),
        Flag::Jumped { name, from, to, at } => {
            format!(
                "{name} changes from {} to {} at t = {}",
                significant(*from, 4),
                significant(*to, 4),
                significant(*at, 4)
            )
        }
        Flag::HalfSample { lines } => {
            let remedy = if *lines {
                "held inputs look like this when they are interpolated linearly; try --hold previous"
            } else {
                "check at which instant of the sampling period the inputs were logged"
            };
            format!("the delay is half the sampling period: {remedy}")
        }
    }
}

/// Why a rival cannot be ruled out, as a clause.
pub(super) fn closeness(closeness: Closeness) -> String {
    match closeness {
        Closeness::Equal => "explains these data equally well".to_owned(),
        Closeness::Better(units) => format!("explains these data better by {units:.1} units, but less simply"),
        Closeness::Worse { by, margin } => {
            format!("explains these data worse by only {by:.1} units, where {margin} would rule it out")
        }
        Closeness::LittleMore => {
            "fits almost as well; the difference is small compared with the remaining residual".to_owned()
        }
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
            (Some(from), Some(to)) => format!("{} < {name} < {}", significant(*from, 2), significant(*to, 2)),
            (None, None) => name.clone(),
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
