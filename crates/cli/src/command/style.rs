//! Errors and warnings on standard error, colored on terminals alone (`NO_COLOR` and `CLICOLOR_FORCE` are honored).

use std::fmt::Write as _;

use super::help::STYLES;

/// Says why a command ended without a result.
pub(crate) fn error(text: &str) {
    let red = STYLES.get_error();
    // In one piece: another thread may end the process at any time.
    let whole = format!("{red}error:{red:#} {}\n", colored(text));
    anstream::eprint!("{whole}");
}

/// Says what is missing beside a result.
pub(crate) fn warning(text: &str) {
    let yellow = STYLES.get_invalid();
    anstream::eprintln!("{yellow}warning:{yellow:#} {}", colored(text));
}

/// Marks below a source line in red, remedies in green.
fn colored(text: &str) -> String {
    let mut out = String::new();
    for (k, line) in text.split('\n').enumerate() {
        if k > 0 {
            out.push('\n');
        }
        let marks = line.strip_prefix("   | ").filter(|m| m.contains('^') && m.chars().all(|c| c == ' ' || c == '^'));
        let style = match (marks, line.starts_with("   = ")) {
            (Some(_), _) => STYLES.get_error(),
            (_, true) => STYLES.get_valid(),
            _ => {
                out.push_str(line);
                continue;
            }
        };
        let (bar, rest) = line.split_at(5);
        let _ = write!(out, "{bar}{style}{rest}{style:#}");
    }
    out
}
