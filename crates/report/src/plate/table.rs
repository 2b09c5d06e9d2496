//! A run on the plate as a table.

use bracketry_plate::run::PlateRow;

/// Names of the columns; that of the amplitude, which a logged motion does not have, is apart.
const NAMES: [&str; 13] = [
    "t",
    "plate_X",
    "plate_theta",
    "x_plate",
    "y_plate",
    "phi_plate",
    "vx",
    "vy",
    "w",
    "normal_force",
    "stick_fraction",
    "gap",
    "lean",
];
const AMPLITUDE: (usize, &str) = (9, "amp");

fn has_amplitude(rows: &[PlateRow]) -> bool {
    rows.iter().all(|r| r.amplitude.is_finite())
}

/// Names of the columns of a run: SI units, radians.
pub fn csv_columns(rows: &[PlateRow]) -> Vec<String> {
    let mut names = NAMES.map(str::to_owned).to_vec();
    if has_amplitude(rows) {
        names.insert(AMPLITUDE.0, AMPLITUDE.1.to_owned());
    }
    names
}

/// The values of the columns of a run, a row for each sample.
pub fn csv_rows(rows: &[PlateRow]) -> Vec<Vec<f64>> {
    let amplitude = has_amplitude(rows);
    rows.iter()
        .map(|r| {
            let mut row = vec![r.t, r.plate.displacement, r.plate.tilt];
            row.extend(r.state);
            row.extend(amplitude.then_some(r.amplitude));
            row.extend([r.normal_force, r.stick_fraction, r.gap, r.lean]);
            row
        })
        .collect()
}
