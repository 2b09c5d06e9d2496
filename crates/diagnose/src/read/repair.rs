//! Rows that are no samples, values that are no measurements: what is left out of a table before anything is concluded from it.

use bracketry_numerics::statistics::{extremes, median};

use super::roles::Roles;
use super::warning::Warning;
use crate::settings::RepairSettings;

/// Leaves out what is no sample, fills what is known well enough, and says what it did. Times that do not increase stay, for the clock to
/// refuse. The indices are those of rows before which nothing is known of the inputs.
pub(super) fn repair(roles: &mut Roles, settings: &RepairSettings) -> (Vec<Warning>, Vec<usize>) {
    let mut warnings = Vec::new();
    warnings.extend(drop_repeated(roles));
    warnings.extend(spread_times(roles));
    for (name, values) in roles.all_mut() {
        warnings.extend(sentinels(&name, values, settings));
    }
    for (name, _, values) in &mut roles.measured {
        warnings.extend(held_readings(name, values, settings));
    }
    let cuts = lost_inputs(roles, &mut warnings);
    let cuts = insert_rows(roles, cuts, settings, &mut warnings);
    (warnings, cuts)
}

/// Drops rows that repeat the one before, time and all.
fn drop_repeated(roles: &mut Roles) -> Option<Warning> {
    let n = roles.times.len();
    let same = |values: &[f64], k: usize| values[k] == values[k - 1] || values[k].is_nan() && values[k - 1].is_nan();
    let mut kept = vec![true; n];
    for k in 1..n {
        kept[k] = roles.times[k] != roles.times[k - 1] || !roles.all().all(|values| same(values, k));
    }
    let count = kept.iter().filter(|k| !**k).count();
    roles.keep(&kept);
    (count > 0).then_some(Warning::Repeated { count })
}

/// Rows of one time that differ are samples whose times were rounded: they are spread evenly until the next time.
fn spread_times(roles: &mut Roles) -> Option<Warning> {
    let times = &mut roles.times;
    let (mut from, mut count, mut usual) = (0, 0, 0.0);
    while from < times.len() {
        let to = from + times[from..].iter().take_while(|t| **t == times[from]).count().max(1);
        // The last ones have no next time: they are as far apart as those before.
        let next = times.get(to).map_or(times[from] + usual, |t| *t);
        usual = next - times[from];
        if to - from > 1 && usual > 0.0 {
            let step = usual / (to - from) as f64;
            for k in from + 1..to {
                times[k] = times[from] + step * (k - from) as f64;
            }
            count += to - from - 1;
        }
        from = to;
    }
    (count > 0).then_some(Warning::RoundedTimes { count })
}

/// Numbers by which programs mark that there is no measurement, without sign.
const SENTINELS: [f64; 13] = [
    99.0,
    999.0,
    9999.0,
    99_999.0,
    999_999.0,
    99.99,
    999.9,
    999.99,
    9999.9,
    32_767.0,
    32_768.0,
    65_535.0,
    2_147_483_647.0,
];

/// Marks as lost where a column shows a number that stands for a lost value: one of those in use, the largest or the smallest of the
/// column, and far from all others.
fn sentinels(name: &str, values: &mut [f64], settings: &RepairSettings) -> Vec<Warning> {
    let mut found = Vec::new();
    loop {
        let (low, high) = extremes(values.iter().copied().filter(|v| v.is_finite()));
        let is_sentinel = |v: f64| SENTINELS.contains(&v.abs()) || v.abs() >= settings.largest_value;
        let of = |end: f64| {
            let others = values.iter().copied().filter(|v| v.is_finite() && *v != end);
            let (low, high) = extremes(others);
            let distance = (low - end).max(end - high);
            (is_sentinel(end) && distance > settings.sentinel_distance * (high - low).max(low.abs().max(high.abs())))
                .then_some(end)
        };
        let Some(value) = of(low).or_else(|| of(high)) else { break };
        let count = values.iter().filter(|v| **v == value).count();
        values.iter_mut().filter(|v| **v == value).for_each(|v| *v = f64::NAN);
        found.push(Warning::Sentinel { name: name.to_owned(), value, count });
    }
    found
}

/// Marks as lost what a sensor that is slower than the table repeats: all changes are a whole number of rows apart.
fn held_readings(name: &str, values: &mut [f64], settings: &RepairSettings) -> Option<Warning> {
    let changes: Vec<usize> = (1..values.len()).filter(|&k| values[k] != values[k - 1]).collect();
    if changes.len() < settings.fewest_readings || changes.len() * 2 > values.len() {
        return None;
    }
    let every = changes.windows(2).map(|w| w[1] - w[0]).min().filter(|k| *k > 1)?;
    let first = changes[0] % every;
    let regular = changes.iter().filter(|k| **k % every == first).count();
    let often = changes.windows(2).filter(|w| w[1] - w[0] == every).count();
    let share = |count: usize| count as f64 / changes.len() as f64;
    if share(regular) < 1.0 || share(often) < settings.regular_readings {
        return None;
    }
    for (k, value) in values.iter_mut().enumerate() {
        if k % every != first {
            *value = f64::NAN;
        }
    }
    Some(Warning::HeldReadings { name: name.to_owned(), every })
}

/// A single lost entry of an input is the mean of its neighbors; where more are lost in a row, the rows are left out. The rows after
/// those.
fn lost_inputs(roles: &mut Roles, warnings: &mut Vec<Warning>) -> Vec<usize> {
    let n = roles.times.len();
    let mut kept = vec![true; n];
    let mut filled = 0;
    for values in roles.driving_mut() {
        for k in 0..n {
            if values[k].is_finite() {
                continue;
            }
            let neighbors = k.checked_sub(1).map(|b| values[b]).zip(values.get(k + 1).copied());
            match neighbors.filter(|(a, b)| a.is_finite() && b.is_finite()) {
                // An interpolated value is no neighbor for another: two in a row are left out.
                Some((a, b)) => {
                    values[k] = 0.5 * (a + b);
                    filled += 1;
                }
                None => kept[k] = false,
            }
        }
    }
    let left_out = kept.iter().filter(|k| !**k).count();
    if left_out + filled > 0 {
        warnings.push(Warning::LostInputs { filled, left_out });
    }
    let mut cuts = Vec::new();
    let mut place = 0;
    for k in 0..n {
        if kept[k] {
            if k > 0 && !kept[k - 1] && place > 0 {
                cuts.push(place);
            }
            place += 1;
        }
    }
    roles.keep(&kept);
    cuts
}

/// Puts a row where a single one is missing from a regular clock, with inputs between their neighbors and nothing measured: held over two
/// intervals, an input would be wrong in the second.
fn insert_rows(
    roles: &mut Roles,
    mut cuts: Vec<usize>,
    settings: &RepairSettings,
    warnings: &mut Vec<Warning>,
) -> Vec<usize> {
    let steps: Vec<f64> = roles.times.windows(2).map(|w| w[1] - w[0]).collect();
    let Some(usual) = median(steps.clone()).filter(|s| *s > 0.0) else { return cuts };
    let near = |step: f64, of: f64| (step - of * usual).abs() < settings.regular_step * usual;
    let regular = steps.iter().filter(|s| near(**s, 1.0)).count();
    if (regular as f64) < settings.regular_clock * steps.len() as f64 {
        return cuts;
    }
    let missing: Vec<usize> =
        (0..steps.len()).filter(|&k| near(steps[k], 2.0) && cuts.binary_search(&(k + 1)).is_err()).collect();
    if missing.is_empty() {
        return cuts;
    }
    roles.insert_after(&missing);
    for cut in &mut cuts {
        *cut += missing.partition_point(|k| k < cut);
    }
    warnings.push(Warning::MissingRows { count: missing.len() });
    cuts
}
