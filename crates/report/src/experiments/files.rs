//! Tables of an experiment: the inputs, which `simulate --inputs` reads, and the expected outputs.

use bracketry_experiment::{Design, Discrimination, Identification};

/// A header with its rows.
type Table = (Vec<String>, Vec<Vec<f64>>);

/// The inputs as a table: a column t and one per input.
pub fn experiment_inputs(design: &Design) -> Table {
    let signals = &design.signals;
    let header = std::iter::once("t".to_owned()).chain(signals.names.iter().cloned()).collect();
    let row = |(t, u): (&f64, &Vec<f64>)| std::iter::once(*t).chain(u.iter().copied()).collect();
    (header, signals.times.iter().zip(&signals.values).map(row).collect())
}

/// The inputs with outputs beside them: lists of columns, each with what its names end with.
fn with_outputs(design: &Design, lists: &[(String, &[Vec<f64>])]) -> Table {
    let (mut header, mut rows) = experiment_inputs(design);
    for (end, outputs) in lists {
        header.extend(design.noise.iter().map(|n| format!("{}{end}", n.column)));
        rows.iter_mut().zip(*outputs).for_each(|(row, y)| row.extend(y));
    }
    (header, rows)
}

/// Inputs and the expected outputs of both explanations.
pub fn discrimination_table(d: &Discrimination) -> Table {
    let refitted = format!("[{} refitted]", d.weaker().refitted);
    let [a, b] = [0, 1].map(|k| (format!("[{}]", d.names[k]), d.outputs[k].as_slice()));
    with_outputs(&d.design, &[a, b, (refitted, d.refitted.as_slice())])
}

/// Inputs and the expected outputs.
pub fn identification_table(d: &Identification) -> Table {
    with_outputs(&d.design, &[(String::new(), d.outputs.as_slice())])
}
