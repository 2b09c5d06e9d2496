//! What measured columns show behind their filters and offsets.

use super::column_path::{ColumnPath, Filter};
use super::compiled::Target;
use super::runner::Runner;
use crate::effect::Path;

impl Runner<'_> {
    /// Changes of the columns, over their noise, behind their filters: what a filter shows at first is what suits the measurements best, so
    /// that the change is orthogonal to the transient that another start would add. Nothing where a measurement was lost.
    pub(super) fn through_filters(&self, columns: &[ColumnPath], values: &mut [f64]) {
        let m = self.samples();
        for (column, filter) in columns.iter().enumerate().filter_map(|(c, path)| Some((c, path.filter()?))) {
            self.filter(column, filter, &mut values[column * m..(column + 1) * m], |_| 0.0);
        }
        self.clear_lost(values);
    }

    /// What columns show behind filters and offsets, with what the filters show at first, over the noise.
    pub(super) fn through_paths(&self, columns: &[ColumnPath], values: &mut [f64]) -> Vec<f64> {
        let m = self.samples();
        let mut starts = vec![f64::NAN; columns.len()];
        for (column, path) in columns.iter().enumerate() {
            let offset = |sample: usize| path.offset_after(self.elapsed(sample)) * self.weights[column];
            let values = &mut values[column * m..(column + 1) * m];
            if let Some(filter) = path.filter() {
                self.filter(column, filter, values, |k| self.target[column * m + k] - offset(k));
                starts[column] = values[0];
            }
            values.iter_mut().enumerate().for_each(|(k, v)| *v += offset(k));
        }
        self.clear_lost(values);
        starts
    }

    /// A filter of one column, which begins as it was told, or so that it is nearest to `target`.
    fn filter(&self, column: usize, filter: Filter, values: &mut [f64], target: impl Fn(usize) -> f64) {
        let times = &self.record.times[self.window.from..self.window.to];
        let start = values[0];
        let behind = filter.applied(times, values);
        let change = if let Some(starts) = &self.filter_starts {
            starts[column] - start
        } else {
            // A filter is behind by what moves during its time constant: an outlier is no start.
            let most = filter.most_behind(times, values);
            self.transient_in(column, filter.lag, |k| target(k) - behind[k]).clamp(-most, most)
        };
        for (k, (value, behind)) in values.iter_mut().zip(behind).enumerate() {
            *value = behind + change * self.transient(filter.lag, k);
        }
    }

    /// How much of the start of a filter is left at a sample of the window.
    fn transient(&self, lag: f64, sample: usize) -> f64 {
        let times = &self.record.times[self.window.from..];
        ((times[0] - times[sample]) / lag).exp()
    }

    /// The multiple of the transient of a filter that is nearest to what was measured of a column.
    fn transient_in(&self, column: usize, lag: f64, values: impl Fn(usize) -> f64) -> f64 {
        let m = self.samples();
        let known = (0..m).filter(|k| self.present[column * m + k]);
        let (along, size) = known.fold((0.0, 0.0), |(along, size), k| {
            let e = self.transient(lag, k);
            (along + e * values(k), size + e * e)
        });
        if size > 0.0 { along / size } else { 0.0 }
    }

    /// The number of filters whose starts are fitted in this window.
    pub(super) fn fitted_starts(&self) -> usize {
        if self.filter_starts.is_some() {
            0
        } else {
            self.columns().iter().filter(|path| path.filter().is_some()).count()
        }
    }

    fn clear_lost(&self, values: &mut [f64]) {
        values.iter_mut().zip(&self.present).filter(|(_, present)| !**present).for_each(|(v, _)| *v = 0.0);
    }

    /// What the columns of the last trajectory show if a filter of some is slower by `lag`.
    pub(super) fn filtered_more(&self, path: Path, names: &[String], lag: f64) -> Vec<f64> {
        let mut columns = self.columns();
        for (column, measured) in columns.iter_mut().zip(&self.record.measured) {
            if names.contains(&measured.name) {
                column.add(path, lag);
            }
        }
        let mut values = self.trajectory.shown.clone();
        self.through_paths(&columns, &mut values);
        values
    }

    /// Adds to `out` what changes when an offset or a drift of columns changes by one, if the unknown is one.
    pub(super) fn offset_column(&self, unknown: usize, out: &mut [f64]) -> bool {
        let Target::Column(path @ (Path::SensorBias | Path::SensorDrift), names) = &self.compiled.targets[unknown]
        else {
            return false;
        };
        let m = self.samples();
        out.fill(0.0);
        for (column, measured) in self.record.measured.iter().enumerate() {
            if names.contains(&measured.name) {
                for sample in 0..m {
                    let at = column * m + sample;
                    let by = if *path == Path::SensorDrift { self.elapsed(sample) } else { 1.0 };
                    out[at] = if self.present[at] { by * self.weights[column] } else { 0.0 };
                }
                if let Some(Filter { lag, .. }) = self.columns().get(column).and_then(ColumnPath::filter) {
                    let change = self.transient_in(column, lag, |k| out[column * m + k]);
                    (0..m).for_each(|k| out[column * m + k] -= change * self.transient(lag, k));
                }
            }
        }
        self.clear_lost(out);
        true
    }

    /// Time of a sample of the window from the start of the record, s.
    fn elapsed(&self, sample: usize) -> f64 {
        self.record.times[self.window.from + sample] - self.record.times[0]
    }
}
