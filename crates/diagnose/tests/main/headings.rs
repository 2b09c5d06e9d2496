//! Columns as loggers call them: with units, and with other names of the time.

use std::path::PathBuf;

use bracketry_diagnose::{Record, RecordSettings, read_record};
use bracketry_system::System;

/// A mass whose position is in meters, and whose angle has no stated unit.
const MODEL: &str = "states = ['x', 'v', 'th']\ninputs = ['F']\ndynamics = { x = 'v', v = 'F', th = 'v' }\n\
                     units = { x = 'm', v = 'm/s', F = 'N' }\n";

fn read_with(model: &str, name: &str, header: &str, rows: &[&str], rename: &[(&str, &str)]) -> Result<Record, String> {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("heading_{name}.csv"));
    std::fs::write(&path, format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    let rename = rename.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    let settings = RecordSettings { rename, ..RecordSettings::default() };
    read_record(&path, &System::parse("mass.toml", model).unwrap(), &settings).map_err(|e| e.to_string())
}

fn read(name: &str, header: &str, rows: &[&str]) -> Result<Record, String> {
    read_with(MODEL, name, header, rows, &[])
}

fn said(record: &Record) -> String {
    record.audit.as_ref().unwrap().to_string()
}

/// Values of a measured column.
fn values<'r>(record: &'r Record, name: &str) -> &'r [f64] {
    &record.measured.iter().find(|m| m.name == name).unwrap().values
}

const ROWS: [&str; 4] = ["0,1,0", "1000,2,1500", "2000,1,3500", "3000,2,7000"];

#[test]
fn units_of_columns_become_those_of_the_model() {
    for (name, header, rows) in [
        ("brackets", "t [ms],F [N],x [mm]", ROWS.to_vec()),
        ("parentheses", "Time (ms),F (N),x (mm)", ROWS.to_vec()),
        ("underscore", "time_ms,F,x [mm]", ROWS.to_vec()),
        ("row", "t,F,x", [&["ms,N,mm"], ROWS.as_slice()].concat()),
        ("row_in_brackets", "t,F,x", [&["[ms],[N],[mm]"], ROWS.as_slice()].concat()),
        ("powers", "t [ms],F [kg*m/s^2],x [mm]", ROWS.to_vec()),
    ] {
        let record = read(name, header, &rows).unwrap();
        assert_eq!(record.times, [0.0, 1.0, 2.0, 3.0], "{name}");
        assert_eq!(values(&record, "x"), [0.0, 1.5, 3.5, 7.0], "{name}");
        assert_eq!(record.inputs[0].values, [1.0, 2.0, 1.0, 2.0], "{name}");
        let said = said(&record);
        assert!(said.contains("converted from mm to m") && said.contains("converted from ms to s"), "{said}");
    }
    // In the model's own units, nothing is converted and nothing is said.
    let record = read("own", "t [s],F [N],x [m]", &ROWS).unwrap();
    assert_eq!((record.times[3], values(&record, "x")[3]), (3000.0, 7000.0));
    assert!(!said(&record).contains("is read as"), "{}", said(&record));
}

#[test]
fn the_time_is_found_by_its_usual_names() {
    for (name, header) in [("word", "time,F,x"), ("capital", "Time [s],F,x"), ("seconds", "t_s,F,x")] {
        let record = read(name, header, &ROWS).unwrap();
        assert_eq!(record.times, [0.0, 1000.0, 2000.0, 3000.0], "{header}");
        let column = header.split(',').next().unwrap();
        assert!(said(&record).contains(&format!("`{column}` is read as `t`")), "{}", said(&record));
    }
    // A column with exactly the name wins, and the other one is ignored.
    let record = read("both", "t,time,F,x", &["0,7,1,0", "1,7,2,1", "2,7,1,2"]).unwrap();
    assert_eq!(record.times, [0.0, 1.0, 2.0]);
    assert!(said(&record).contains("time"), "{}", said(&record));
}

#[test]
fn a_model_in_minutes_converts_the_time_of_the_log() {
    let model = format!("time_unit = 'min'\n{MODEL}");
    let record = read_with(&model, "minutes", "t [s],F,x", &ROWS, &[]).unwrap();
    assert!((record.times[3] - 50.0).abs() < 1e-12, "{:?}", record.times);
    let renamed = read_with(&model, "renamed", "clock [s],F,x", &ROWS, &[("clock [s]", "t")]).unwrap();
    assert_eq!(renamed.times, record.times);
}

#[test]
fn units_that_cannot_be_converted_are_refused_with_the_remedy() {
    for (header, message, remedy) in [
        (
            "t,F [m],x",
            "the column `F [m]` is in m, and `F` of the model in N",
            "correct the unit that one of them states",
        ),
        (
            "t,F,th [deg]",
            "the column `th [deg]` is in deg, and the model does not state the unit of `th`",
            "[units] th = \"deg\"",
        ),
    ] {
        let error = read("refused", header, &ROWS).unwrap_err();
        assert!(error.contains(message) && error.contains(remedy), "{error}");
    }
    // A coherent unit is what a model in consistent units expects.
    assert!(read("coherent", "t,F,th [rad]", &ROWS).is_ok());
    let error = read("no_time", "clock,F,x", &ROWS).unwrap_err();
    assert!(error.contains("--rename \"clock=t\""), "{error}");
    let error = read("no_measurement", "t,F,X_encoder", &ROWS).unwrap_err();
    assert!(error.contains("--rename \"X_encoder=x\""), "{error}");
}
