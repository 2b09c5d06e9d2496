//! What was found, in pictures.

use bracketry_diagnose::{Cause, ForceResidual, HeldOut, Place, Predicted, Regime, Report, ResidualAcceleration};
use bracketry_plot::{BarChart, Color, IntervalChart, Panel, Role, Series, TimeSeries, XyChart};

use bracketry_system::{Quantities, with_unit};

use super::Diagnosis;
use super::sentences::brief;
use crate::html::Figure;

/// Names of the models in legends, and what they are.
const MODELS: [(&str, Role); 3] =
    [("as given", Role::Given), ("refitted", Role::Refitted), ("extended", Role::Extended)];
/// Measured columns that a figure has room for.
const MOST_COLUMNS: usize = 4;
/// Candidates that the ranking has room for.
const MOST_CANDIDATES: usize = 12;
/// Characters of a term that a row has room for.
const LONGEST_TERM: usize = 28;
/// Points of a cloud, per model.
const CLOUD: usize = 700;
/// Share of the values at each end that may lie outside the frame.
const OUTERMOST: f64 = 0.02;
/// Bins of a mean over the cloud.
const BINS: usize = 24;
/// Fewest points of a bin.
const FEWEST: usize = 5;

/// What candidates are in the ranking.
const NAMED: &str = "selected, alone";
const BESIDE: &str = "selected, with the other selected terms";
const RIVAL: &str = "confusable with a cause, alone";
const TRIED: &str = "not selected, alone";
/// Places that a figure has room for.
const MOST_PLACES: usize = 12;

impl Diagnosis {
    /// The figures that the findings allow.
    pub fn figures(&self) -> Vec<Figure> {
        let mut figures = Vec::new();
        if let Some(held_out) = &self.report.evidence.held_out {
            // Without causes, the model as given stands where the extended one would.
            let shown = if self.report.evidence.extended.is_some() { [1, 2] } else { [0, 1] };
            figures.extend(prediction(&self.report.quantities, held_out, shown));
            figures.extend(forces(&self.report.quantities, held_out, shown));
        }
        figures.extend(self.places());
        figures.extend(self.over_time());
        figures.extend(self.ranking());
        figures.extend(self.gain());
        figures
    }

    fn places(&self) -> Vec<Figure> {
        let Report { places, regimes, .. } = &self.report;
        let quantities = &self.report.quantities;
        let motion = of_places(quantities, places, "where", "Where the refitted model is wrong, by motion");
        let title = "Where the refitted model is wrong, by acceleration, position, and tilt";
        let others = of_places(quantities, regimes, "regimes", title);
        motion.into_iter().chain(others).collect()
    }

    /// What the equations miss over time, in the first stretch of each.
    fn over_time(&self) -> Option<Figure> {
        let mut shown: Vec<&ResidualAcceleration> = Vec::new();
        for r in &self.report.residual_acceleration {
            if shown.iter().all(|s| s.equation != r.equation) && shown.first().is_none_or(|s| s.record == r.record) {
                shown.push(r);
            }
        }
        let first = *shown.first()?;
        let title = "Residual of the refitted model's equations over time";
        let mut chart = TimeSeries::new().title(title).time_label(self.report.quantities.time_title("time"));
        for r in shown.iter().take(MOST_COLUMNS) {
            let missing =
                Series::new("measured − modeled", r.times.clone(), r.values.clone()).color(Role::Refitted.color());
            let quantities = &self.report.quantities;
            let unit = quantities.unit_of_derivative(&r.equation, 1);
            let unit = unit.unwrap_or_else(|| format!("unit of {}/{}", r.equation, quantities.time_unit.symbol()));
            let panel = Panel::new(format!("missing in {}′ [{unit}]", r.equation));
            chart = chart.panel(
                panel
                    .series(missing)
                    .named_bound("± 2 std of noise", 2.0 * r.std)
                    .named_bound("± 2 std of noise", -2.0 * r.std),
            );
        }
        let caption = format!(
            "{}: measured minus modeled rate, by smoothing splines of {:.3} {}; for a velocity, this is the missing force per mass. \
             Within the bounds, it may be sensor noise.",
            first.record,
            first.bandwidth_hz,
            self.report.quantities.time_unit.frequency()
        );
        Some(Figure { name: "missing".to_owned(), caption, drawing: chart.draw() })
    }

    fn ranking(&self) -> Option<Figure> {
        let candidates = &self.report.candidates;
        if candidates.iter().all(|c| c.share.is_none()) {
            return None;
        }
        let rivals: Vec<_> = self.report.causes.iter().flat_map(|c| &c.rivals).collect();
        let mut chart = IntervalChart::new("excess removed [%]").categories([NAMED, BESIDE, RIVAL, TRIED]);
        // One cause alone takes the same away beside the others.
        let several = self.report.causes.len() > 1;
        let causes = &self.report.causes;
        for c in causes.iter().filter(|_| several) {
            if let Some(share) = c.share {
                let alike = causes.iter().filter(|o| o.name == c.name && o.equation == c.equation).count() > 1;
                // A cause whose name is withheld is called here as it is among the candidates.
                let candidate = candidates.iter().find(|o| o.chosen && o.equation == c.equation && o.term == c.term);
                let name = candidate.map_or(c.name, |o| o.name);
                chart = chart.row(row_name(name, &c.equation, c.term.text(), alike), 100.0 * share, None, BESIDE);
            }
        }
        for c in candidates.iter().take(MOST_CANDIDATES) {
            let Some(share) = c.share else { continue };
            let rival = rivals.iter().any(|r| r.name == c.name && r.equation == c.equation && r.term == c.term);
            let category = if c.chosen {
                NAMED
            } else if rival {
                RIVAL
            } else {
                TRIED
            };
            let alike = c.name == Cause::UnknownTerm
                || candidates.iter().filter(|o| o.name == c.name && o.equation == c.equation).count() > 1;
            chart = chart.row(
                row_name(c.name, &c.equation, c.term.text(), alike),
                100.0 * share,
                c.interval.map(|[a, b]| (100.0 * a, 100.0 * b)),
                category,
            );
        }
        Some(Figure {
            name: "candidates".to_owned(),
            caption: format!(
                "Candidates, each alone with all parameters refitted, and the 95 % interval.{}",
                if several {
                    " For several causes, also what each removes on held-out data from the model with all the others: an \
                     effect that is small or masked alone may be large in combination."
                } else {
                    ""
                }
            ),
            drawing: chart.title("How much of the error each cause explains").draw(),
        })
    }

    fn gain(&self) -> Option<Figure> {
        let time = self.report.quantities.time_unit;
        let gain = self.report.gain.as_ref().filter(|g| !g.horizons_s.is_empty())?;
        let percent = |list: &[f64]| list.iter().map(|v| 100.0 * v).collect::<Vec<_>>();
        let names = gain.horizons_s.iter().map(|h| time.text(h));
        let refitted = if gain.before == gain.as_given { None } else { Some(percent(&gain.before)) };
        let mut chart = BarChart::new("NRMSE [% of the column's standard deviation]", names)
            .series(MODELS[0].0, percent(&gain.as_given))
            .role(MODELS[0].1);
        if let Some(refitted) = refitted {
            chart = chart.series(MODELS[1].0, refitted).role(MODELS[1].1);
        }
        let chart =
            chart.series(MODELS[2].0, percent(&gain.after)).role(MODELS[2].1).category_label("prediction horizon");
        Some(Figure {
            name: "gain".to_owned(),
            caption: "Error of predictions on held-out data: the state is estimated from the past, then the model runs in open loop."
                .to_owned(),
            drawing: chart.title("Prediction error on held-out data").draw(),
        })
    }
}

/// Shares of the error beside shares of the time.
fn of_places(quantities: &Quantities, places: &[Place], name: &str, title: &str) -> Option<Figure> {
    if places.is_empty() {
        return None;
    }
    let several = places.iter().any(|p| p.equation != places[0].equation);
    let places = &places[..places.len().min(MOST_PLACES)];
    let label = |p: &Place| {
        let unit = match &p.regime {
            Regime::Rate { name, .. } => quantities.unit_of_derivative(name, 1),
            Regime::Third { name, .. } => quantities.unit(name).map(str::to_owned),
            _ => None,
        };
        let regime = brief(&p.regime) + &unit.map_or_else(String::new, |unit| format!(" {unit}"));
        if several { format!("{}: {regime}", p.equation) } else { regime }
    };
    let shares: Vec<f64> = places.iter().map(|p| 100.0 * p.share).collect();
    let mut chart = BarChart::new("share [%]", places.iter().map(label)).series("of the excess", shares);
    if let Some(times) = places.iter().map(|p| p.time.map(|t| 100.0 * t)).collect::<Option<Vec<f64>>>() {
        chart = chart.series("of the time", times);
    }
    let equations = if several { ", by equation" } else { "" };
    Some(Figure {
        name: name.to_owned(),
        caption: format!(
            "Where the model with refitted parameters is wrong{equations}: a uniform error has equal shares of error and time."
        ),
        drawing: chart.title(title).draw(),
    })
}

/// Name of a row of the ranking, with the term where others are called alike.
fn row_name(cause: Cause, equation: &str, term: &str, alike: bool) -> String {
    let term = if alike { format!(": {}", shortened(term)) } else { String::new() };
    format!("{} in {equation}{term}", cause.words())
}

/// A term as short as a row of a chart has room for.
fn shortened(term: &str) -> String {
    let term = term.replace('-', "−");
    if term.chars().count() <= LONGEST_TERM {
        return term;
    }
    let head: String = term.chars().take(LONGEST_TERM - 1).collect();
    format!("{head}…")
}

/// A typical prediction: the one whose error with the refitted model is the median.
fn prediction(quantities: &Quantities, held_out: &HeldOut, shown: [usize; 2]) -> Option<Figure> {
    let error = |p: &Predicted| {
        let record = &held_out.records[p.record];
        let of = |(c, column): (usize, &Vec<f64>)| {
            let measured = &record.measured[c].values[p.start..p.start + column.len()];
            let pairs = column.iter().zip(measured).filter(|(_, y)| y.is_finite());
            let squares: f64 = pairs.map(|(s, y)| (s - y).powi(2)).sum();
            squares / record.measured[c].noise.powi(2)
        };
        p.columns[1].iter().enumerate().map(of).sum::<f64>()
    };
    let longest = held_out.predicted.iter().filter_map(|p| p.columns[0].first().map(Vec::len)).max()?;
    let mut whole: Vec<(f64, &Predicted)> = held_out
        .predicted
        .iter()
        .filter(|p| p.columns[0].first().is_some_and(|c| c.len() == longest))
        .map(|p| (error(p), p))
        .collect();
    whole.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (_, p) = whole.get(whole.len() / 2)?;
    let record = &held_out.records[p.record];
    let times = &record.times[p.start..p.start + longest];
    let mut chart = TimeSeries::new()
        .title("A typical prediction on held-out data and its error")
        .time_label(quantities.time_title("time"));
    for (c, m) in record.measured.iter().take(MOST_COLUMNS).enumerate() {
        let known: Vec<usize> = (0..longest).filter(|k| m.values[p.start + k].is_finite()).collect();
        let at = |f: &dyn Fn(usize) -> f64| known.iter().map(|&k| f(k)).collect::<Vec<f64>>();
        let t = at(&|k| times[k]);
        let line = |model: usize, y: Vec<f64>| {
            let (name, role) = MODELS[model];
            Series::new(name, t.clone(), y).role(role)
        };
        let measured = Series::new("measured", t.clone(), at(&|k| m.values[p.start + k])).role(Role::Measured);
        let mut above = Panel::new(quantities.title(&m.name)).series(measured);
        let mut below = Panel::new(with_unit(&format!("{}: measured − predicted", m.name), quantities.unit(&m.name)));
        for model in shown {
            let predicted = &p.columns[model][c];
            above = above.series(line(model, at(&|k| predicted[k])));
            below = below.series(line(model, at(&|k| m.values[p.start + k] - predicted[k])));
        }
        chart = chart.panel(above).panel(below);
    }
    let drawing = chart.draw();
    let caption = format!(
        "{}: predicted from t = {:.3} on, the state there estimated from the samples before; the prediction with the \
         median error.",
        record.name, times[0]
    );
    Some(Figure { name: "prediction".to_owned(), caption, drawing })
}

/// Residuals of the equations, against the state, before and after.
fn forces(quantities: &Quantities, held_out: &HeldOut, shown: [usize; 2]) -> Vec<Figure> {
    let mut names: Vec<&str> = held_out.after.iter().map(|r| r.equation.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names
        .into_iter()
        .filter_map(|equation| {
            let of = |list: &'_ [ForceResidual]| -> Vec<(f64, f64)> {
                let mine = list.iter().filter(|r| r.equation == equation);
                mine.flat_map(|r| r.state.iter().copied().zip(r.values.iter().map(|v| -v))).collect()
            };
            let (before, after) = (of(&held_out.before), of(&held_out.after));
            let first = held_out.after.iter().find(|r| r.equation == equation)?;
            let what = match &first.input {
                Some(input) => {
                    let unit = quantities.unit(input).map_or_else(|| format!("unit of {input}"), str::to_owned);
                    format!("needed − applied [{unit}]")
                }
                None => with_unit(
                    &format!("measured − modeled rate of {equation}"),
                    quantities.unit_of_derivative(equation, 1).as_deref(),
                ),
            };
            let mut panel = Panel::new(what);
            for (model, points) in shown.into_iter().zip([&before, &after]) {
                let (name, role) = MODELS[model];
                let pale = role.color().mix(Color(255, 255, 255), 0.65);
                let (x, y) = thinned(points);
                panel = panel.series(Series::new(format!("{name}, samples"), x, y).points().color(pale));
            }
            let mut frame = bulk(&before, &after);
            for (model, points) in shown.into_iter().zip([&before, &after]) {
                let (x, y) = means(points);
                frame = frame.map(|range| y.iter().fold(range, |(low, high), v| (v.min(low), v.max(high))));
                let (name, role) = MODELS[model];
                panel = panel.series(Series::new(format!("{name}, mean"), x, y).role(role));
            }
            if let Some((low, high)) = frame {
                panel = panel.limits(low, high);
            }
            let title = format!("Residual of the equation of {equation} on held-out data");
            Some(Figure {
                name: format!("force_{equation}"),
                caption: format!(
                    "Measured minus modeled in the equation of {equation}, smoothed to {:.3} {}: points of the held-out data and \
                     their mean over {equation}; the outermost 2 % may lie outside the axes.",
                    first.bandwidth,
                    quantities.time_unit.frequency()
                ),
                drawing: XyChart::new(quantities.title(equation), panel).title(title).draw(),
            })
        })
        .collect()
}

/// The range that holds all but the outermost values: at rest, what dry friction holds back cannot be told from the data, and
/// single points lie far off.
fn bulk(before: &[(f64, f64)], after: &[(f64, f64)]) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = before.iter().chain(after).map(|p| p.1).collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get(((values.len().saturating_sub(1)) as f64 * share) as usize).copied();
    let (low, high) = (at(OUTERMOST)?, at(1.0 - OUTERMOST)?);
    let room = 0.3 * (high - low);
    (room > 0.0).then_some((low - room, high + room))
}

/// Every n-th point, [`CLOUD`] at most.
fn thinned(points: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    points.iter().step_by(points.len().div_ceil(CLOUD).max(1)).copied().unzip()
}

/// Means over bins of equal width.
fn means(points: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    let low = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    let mut bins = vec![(0.0, 0.0, 0_usize); BINS];
    for (x, y) in points {
        let at = ((x - low) / (high - low).max(f64::MIN_POSITIVE) * BINS as f64) as usize;
        let bin = &mut bins[at.min(BINS - 1)];
        *bin = (bin.0 + x, bin.1 + y, bin.2 + 1);
    }
    let full = bins.into_iter().filter(|b| b.2 >= FEWEST);
    full.map(|(x, y, n)| (x / n as f64, y / n as f64)).unzip()
}
