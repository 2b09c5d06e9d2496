//! Turns systems of the case format into model files, one per case.
//!
//! `cargo run --example convert_cases -- CASES.json DIR [PARAMETER=VALUE …]`
//!
//! Parameters without a value get distinct values that are no special numbers, unless they are given here. A case whose
//! affine form was derived from other equations gives those too, in `NAME_original.toml`.
#![allow(clippy::print_stdout)]

#[path = "../tests/main/common/case_file.rs"]
mod case_file;

use std::path::PathBuf;

use serde_json::Value;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(cases), Some(dir)) = (arguments.next(), arguments.next()) else {
        return Err("give CASES.json and a folder for the model files".into());
    };
    let values: Vec<(String, String)> = arguments
        .map(|a| match a.split_once('=') {
            Some((name, value)) => Ok((name.to_owned(), value.to_owned())),
            None => Err(format!("`{a}` is no PARAMETER=VALUE")),
        })
        .collect::<Result<_, _>>()?;
    let all: Value = serde_json::from_str(&std::fs::read_to_string(cases)?)?;
    let list = all["cases"].as_array().ok_or("the file has no list `cases`")?;
    let dir = PathBuf::from(dir);
    std::fs::create_dir_all(&dir)?;
    for (k, case) in list.iter().enumerate() {
        let name = case["name"].as_str().map_or_else(|| format!("case_{}", k + 1), str::to_owned);
        let path = dir.join(format!("{name}.toml"));
        std::fs::write(&path, case_file::model_file(case, &case["x0"], &values)?)?;
        println!("{}", path.display());
        if case["expected"]["original"].is_object() {
            let path = dir.join(format!("{name}_original.toml"));
            std::fs::write(&path, case_file::original_model_file(case, &values)?)?;
            println!("{}", path.display());
        }
    }
    Ok(())
}
