//! Runs read from tables: which column is what, and what is refused.

use std::collections::BTreeMap;
use std::path::PathBuf;

use bracketry_diagnose::{DiagnoseError, Quantity, Record, RecordSettings, read_record};
use bracketry_sim::Hold;
use bracketry_system::System;

const SLIDER: &str = r#"
name = "slider"
states = ["x", "v"]
inputs = ["F"]
parameters = { m = 1, mu = 0.1, g = 9.81 }
dynamics = { x = "v", v = "F/m - mu*g*sign(v)" }
outputs = { x = "x", power = "F*v" }
"#;

const CART: &str = r#"
name = "cart"
states = ["x", "v"]
inputs = ["X", "w"]
dynamics = { x = "v", v = "-v - der(X,2)" }
"#;

fn system(text: &str) -> System {
    System::parse("model.toml", text).unwrap()
}

fn file(name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = std::env::temp_dir().join(format!("bracketry-records-{}-{name}", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path
}

fn read(name: &str, text: &str, model: &str, settings: &RecordSettings) -> Result<Record, DiagnoseError> {
    read_record(&file(name, text), &system(model), settings)
}

fn renamed(pairs: &[(&str, &str)]) -> RecordSettings {
    let rename = pairs.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    RecordSettings { rename, ..RecordSettings::default() }
}

#[test]
fn columns_are_taken_by_name() {
    let text = "\u{feff}# made by hand\nt, v, F, x, power, note\n0,1,2,3,4,hello\n0.1,,5,nan,7,\n0.2,8,9,10,11,-\n";
    let record = read("by_name.csv", text, SLIDER, &RecordSettings::default()).unwrap();
    let audit = record.audit.clone().unwrap();
    assert_eq!(record.times, [0.0, 0.1, 0.2]);
    assert_eq!(record.inputs[0].values, [2.0, 5.0, 9.0]);
    assert_eq!(record.inputs[0].hold, Hold::Previous);
    let quantity = |name: &str| record.measured.iter().find(|m| m.name == name).unwrap().quantity;
    assert_eq!(quantity("x"), Quantity::State(0), "an output that is a state is that state");
    assert_eq!(quantity("v"), Quantity::State(1));
    assert_eq!(quantity("power"), Quantity::Output(1));
    let v = record.measured.iter().find(|m| m.name == "v").unwrap();
    assert!(v.values[0] == 1.0 && v.values[1].is_nan() && v.values[2] == 8.0 && v.noise > 0.0);
    assert_eq!(audit.ignored, ["note"]);
    assert!(audit.to_string().contains("note"), "{audit}");
}

#[test]
fn columns_are_renamed() {
    let text = "time,q,force,F\n0,1,2,0\n1,2,3,0\n2,3,4,0\n";
    let settings = renamed(&[("time", "t"), ("q", "x"), ("force", "F"), ("F", "old")]);
    let record = read("renamed.csv", text, SLIDER, &settings).unwrap();
    let audit = record.audit.clone().unwrap();
    assert_eq!(record.measured[0].name, "x");
    assert_eq!(record.inputs[0].values, [2.0, 3.0, 4.0]);
    assert_eq!(audit.ignored, ["F"]);
}

#[test]
fn columns_and_files_give_the_same_record() {
    let text = "t,F,x\n0,1,2\n0.5,3,4\n1,5,7\n";
    let from_file = read("same.csv", text, SLIDER, &RecordSettings::default()).unwrap();
    let columns = BTreeMap::from([("F".into(), vec![1.0, 3.0, 5.0]), ("x".into(), vec![2.0, 4.0, 7.0])]);
    let times = vec![0.0, 0.5, 1.0];
    let from_columns =
        Record::from_columns(&from_file.name, times, columns, &system(SLIDER), &RecordSettings::default()).unwrap();
    assert_eq!(from_file, from_columns);
}

#[test]
fn a_gap_in_time_splits_the_run() {
    let times = (0..40).map(|k| f64::from(k) * 0.01 + if k < 25 { 0.0 } else { 1.0 });
    let rows = times.map(|t| format!("{t},0.5,{t}")).collect::<Vec<_>>().join("\n");
    let record = read("gap.csv", &format!("t,F,x\n{rows}"), SLIDER, &RecordSettings::default()).unwrap();
    let audit = record.audit.clone().unwrap();
    assert_eq!(record.gaps, [25]);
    assert_eq!(audit.gaps, 1);
    assert!((audit.step - 0.01).abs() < 1e-9 && audit.jitter < 1e-9);
}

#[test]
fn what_is_wrong_is_named_with_place_and_remedy() {
    let refused = |name: &str, text: &str, model: &str, settings: &RecordSettings, parts: &[&str]| {
        let message = read(name, text, model, settings).unwrap_err().to_string();
        for part in parts.iter().chain(&[name]) {
            assert!(message.contains(part), "no `{part}` in: {message}");
        }
    };
    let plain = RecordSettings::default();
    refused("no_t.csv", "clock,F,x\n0,1,2\n", SLIDER, &plain, &["`t`", "clock", "--rename \"clock=t\""]);
    let measured = ["no measurement", "q", "x, v, power", "--rename \"q=x\""];
    refused("unmeasured.csv", "t,F,q\n0,1,2\n1,1,2\n", SLIDER, &plain, &measured);
    refused("no_input.csv", "t,x,u\n0,1,2\n1,1,2\n", SLIDER, &plain, &["uses `F`", "u", "--rename column=F"]);
    refused("no_der.csv", "t,x\n0,1\n1,1\n", CART, &plain, &["der(X,2)"]);
    refused("order.csv", "t,F,x\n0,1,2\n1,1,2\n\n0.5,3,4\n", SLIDER, &plain, &["line 5", "column `t`", "sort"]);
    refused("text.csv", "t,F,x\n0,1,2\n1,1,two\n", SLIDER, &plain, &["line 3", "column `x`", "two", "nan"]);
    refused(
        "lost_input.csv",
        "t,F,x\n0,1,2\n1,,2\n",
        SLIDER,
        &plain,
        &["fewer than two rows have all inputs", "same rows"],
    );
    refused("lost_time.csv", "t,F,x\n0,1,2\nnan,1,2\n", SLIDER, &plain, &["line 3", "column `t`"]);
    refused("lost.csv", "t,F,x\n0,1,2\n1,1,\n2,1,\n", SLIDER, &plain, &["column `x`", "2 of 3", "remove"]);
    refused("one.csv", "t,F,x\n0,1,2\n", SLIDER, &plain, &["two rows"]);
    refused("ragged.csv", "t,F,x\n0,1,2\n1,1\n", SLIDER, &plain, &["line"]);
    refused("twice.csv", "t,F,x,x\n0,1,2,3\n", SLIDER, &plain, &["`x`", "rename"]);
    let q_as_x = renamed(&[("q", "x")]);
    refused("both.csv", "t,F,x,q\n0,1,2,3\n1,1,2,3\n", SLIDER, &q_as_x, &["two columns", "`x`", "`q`"]);
    refused("absent.csv", "t,F,x\n0,1,2\n1,1,2\n", SLIDER, &q_as_x, &["`q`", "t, F, x"]);
    let unknown = ["--rename x=bar", "no `bar`", "t, F, x, v, power"];
    refused("unknown.csv", "t,F,x\n0,1,2\n1,1,2\n", SLIDER, &renamed(&[("x", "bar")]), &unknown);
    refused("semicolons.csv", "t;F;x\n0;1,5;2\n", SLIDER, &plain, &["semicolons", "commas"]);
    refused("array.npy", "", SLIDER, &plain, &["numpy.savez", ".npz"]);
    let message = read_record(&std::env::temp_dir(), &system(SLIDER), &plain).unwrap_err().to_string();
    assert!(message.contains("is not a file"), "{message}");
}

#[test]
fn a_column_whose_name_another_gets_may_be_called_anything() {
    let swapped = renamed(&[("q", "x"), ("x", "bar")]);
    let record = read("other.csv", "t,F,x,q\n0,1,2,3\n1,1,2,3\n", SLIDER, &swapped).unwrap();
    assert_eq!(record.measured[0].values, [3.0, 3.0]);
}

#[test]
fn a_quantity_may_stand_there_twice_with_the_same_numbers() {
    let model = SLIDER.replace("power = ", "q = \"x\", power = ");
    let record = read("same.csv", "t,F,x,q\n0,1,2,2\n1,1,3,3\n", &model, &RecordSettings::default()).unwrap();
    assert_eq!(record.measured.len(), 1);
    let other = read("other.csv", "t,F,x,q\n0,1,2,2\n1,1,3,4\n", &model, &RecordSettings::default());
    let message = other.unwrap_err().to_string();
    assert!(message.contains("different numbers") && message.contains("remove one"), "{message}");
}

#[test]
fn an_input_that_no_equation_uses_needs_no_column() {
    let record = read("unused.csv", "t,x,\"der(X,2)\"\n0,1,5\n1,1,6\n", CART, &RecordSettings::default()).unwrap();
    assert_eq!(record.inputs.len(), 2);
    assert_eq!(record.input_derivatives[0].values, [5.0, 6.0]);
}

#[test]
fn a_derivative_without_a_column_comes_from_a_spline() {
    let t: Vec<f64> = (0..1200).map(|k| f64::from(k) * 5e-3 + if k < 700 { 0.0 } else { 2.0 }).collect();
    let column = |f: &dyn Fn(f64) -> f64| t.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    let given = |columns: Vec<(&str, Vec<f64>)>| {
        let columns = columns.into_iter().map(|(name, values)| (name.to_owned(), values)).collect();
        Record::from_columns("run", t.clone(), columns, &system(CART), &RecordSettings::default()).unwrap()
    };
    let x = column(&|t| 0.01 * (9.0 * t).sin());
    let second = column(&|t| -0.81 * (9.0 * t).sin());
    let by_spline = given(vec![("X", x.clone()), ("x", x.clone())]);
    let audit = by_spline.audit.clone().unwrap();
    let by_column = given(vec![("X", x.clone()), ("der(X,2)", second.clone()), ("x", x)]);
    assert_eq!(by_column.input_derivatives[0].values, second);
    // A motion, not a command.
    assert!(
        [&by_column.inputs[0], &by_column.input_derivatives[0], &by_spline.input_derivatives[0]]
            .iter()
            .all(|signal| signal.hold == Hold::Linear)
    );
    assert_eq!(by_column.inputs[1].hold, Hold::Previous);
    // The third derivative vanishes at the ends of a spline: a few samples feel it.
    for k in (5..695).chain(705..1195) {
        let found = by_spline.input_derivatives[0].values[k];
        assert!((found - second[k]).abs() < 1e-3, "{k}: {found} {}", second[k]);
    }
    let bandwidth = audit.columns.iter().find(|c| c.name == "der(X,2)").unwrap().bandwidth.unwrap();
    assert!(bandwidth > 9.0 / std::f64::consts::TAU, "{bandwidth} Hz");
    assert_eq!(by_spline.differentiated_input(0, 2).unwrap(), by_spline.input_derivatives[0]);
}
