//! `bracketry publication`: the publication behind the plate and the compensation of robots, equation by equation.

use bracketry::report::publication::{CITATION, Entry, entries, entry_text, found, list_text};
use clap::Args;
use serde_json::json as object;

use super::output::{json, line, print};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("List all equations, figures, and open points with their verdicts", "bracketry publication"),
    ("What is wrong with the motion of the object", "bracketry publication 3.16"),
    ("Everything, in narrow lines", "bracketry publication all --width 60"),
];

/// Arguments of `publication`.
#[derive(Args)]
pub(crate) struct PublicationArgs {
    /// Numbers, such as 3.16 or 3.2.3a, `figure 3.4`, or `all`; by default, a list
    #[arg(value_name = "NUMBER")]
    numbers: Vec<String>,
    /// Columns of the text
    #[arg(long, value_name = "COLUMNS", default_value_t = 100, value_parser = clap::value_parser!(u16).range(30..=1000))]
    width: u16,
}

/// Prints the entries.
pub(crate) fn run(args: &PublicationArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    anyhow::ensure!(output.out.is_none(), "--out: publication writes no files; omit it, or redirect what is printed");
    let width = usize::from(args.width);
    let chosen = chosen(&args.numbers)?;
    if output.json {
        print(&json(&object!({"publication": CITATION, "entries": chosen}))?)?;
    } else if args.numbers.is_empty() {
        print(&list_text(chosen, width))?;
        line("(`bracketry publication 3.16` shows an entry, `bracketry publication all` shows them all)")?;
    } else {
        let texts: Vec<String> = chosen.into_iter().map(|entry| entry_text(entry, width)).collect();
        print(&texts.join("\n"))?;
    }
    Ok(Outcome::Done)
}

/// The entries of numbers, without repetitions; all if there are none.
fn chosen(numbers: &[String]) -> anyhow::Result<Vec<&'static Entry>> {
    if numbers.is_empty() || numbers.iter().any(|number| number.eq_ignore_ascii_case("all")) {
        return Ok(entries().collect());
    }
    // `figure 3.4` comes as one word or as two.
    let words = numbers.join(" ");
    let mut words = words.split_whitespace().peekable();
    let mut list: Vec<&Entry> = Vec::new();
    while let Some(word) = words.next() {
        let is_kind = ["equation", "figure", "question"].iter().any(|kind| word.eq_ignore_ascii_case(kind));
        let wanted = match words.peek() {
            Some(number) if is_kind => format!("{word} {number}"),
            _ => word.to_owned(),
        };
        if wanted != word {
            words.next();
        }
        let of_number = found(&wanted);
        anyhow::ensure!(
            !of_number.is_empty(),
            "there is no {wanted}\n   = give a number from 3.1 to 3.23, `figure 3.1` to `figure 3.6`, or 3.2.3a to 3.2.3e; without a number, they are listed"
        );
        for entry in of_number {
            if !list.contains(&entry) {
                list.push(entry);
            }
        }
    }
    Ok(list)
}
