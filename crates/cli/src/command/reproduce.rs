//! `bracketry reproduce`: results of the literature that are reproduced here.

use bracketry::report::reproduced::{Row, found, list_text, row_text, rows};
use clap::Args;
use serde_json::{Value, json as object};

use super::output::{json, line, print};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("List all results with their references and verdicts", "bracketry reproduce"),
    ("Claim, command, our figure, and tests of one", "bracketry reproduce goddard-rocket"),
    ("All results of an author", "bracketry reproduce Kawski"),
];

/// Arguments of `reproduce`.
#[derive(Args)]
pub(crate) struct ReproduceArgs {
    /// Names, authors, or years of results, or `all`; by default, a list
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Columns of the text
    #[arg(long, value_name = "COLUMNS", default_value_t = 100, value_parser = clap::value_parser!(u16).range(30..=1000))]
    width: u16,
}

/// Prints the rows.
pub(crate) fn run(args: &ReproduceArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    anyhow::ensure!(output.out.is_none(), "--out: reproduce writes no files; omit it, or redirect what is printed");
    let width = usize::from(args.width);
    let chosen = chosen(&args.names)?;
    if output.json {
        let rows = chosen.into_iter().map(with_command).collect::<anyhow::Result<Vec<Value>>>()?;
        print(&json(&object!({"results": rows}))?)?;
    } else if args.names.is_empty() {
        print(&list_text(chosen, width))?;
        line("(`bracketry reproduce NAME` shows a result, `bracketry reproduce all` shows them all)")?;
    } else {
        let texts: Vec<String> = chosen.into_iter().map(|row| row_text(row, width)).collect();
        print(&texts.join("\n"))?;
    }
    Ok(Outcome::Done)
}

/// A row as data, with its command.
fn with_command(row: &Row) -> anyhow::Result<Value> {
    let mut value = serde_json::to_value(row)?;
    value["command"] = row.command().into();
    Ok(value)
}

/// The rows of names, without repetitions; all if there are none.
fn chosen(names: &[String]) -> anyhow::Result<Vec<&'static Row>> {
    if names.is_empty() || names.iter().any(|name| name.eq_ignore_ascii_case("all")) {
        return Ok(rows().collect());
    }
    let mut list: Vec<&Row> = Vec::new();
    for name in names {
        let of_name = found(name);
        anyhow::ensure!(
            !of_name.is_empty(),
            "there is no result {name}\n   = `bracketry reproduce` lists the names; an author or a year is accepted, too"
        );
        for row in of_name {
            if !list.contains(&row) {
                list.push(row);
            }
        }
    }
    Ok(list)
}
