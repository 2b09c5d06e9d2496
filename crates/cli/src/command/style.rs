//! Errors and warnings on standard error, colored on terminals alone (`NO_COLOR` and `CLICOLOR_FORCE` are honored).

use std::fmt::Write as _;

use super::help::STYLES;

/// Says why a command ended without a result.
pub(crate) fn error(text: &str) {
    let red = STYLES.get_error();
    anstream::eprintln!("{red}error:{red:#} {}", colored(text));
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

#[cfg(test)]
mod tests {
    use super::colored;

    #[test]
    fn marks_and_remedies_are_colored_and_nothing_else() {
        let text = "m.toml:1:2: unknown name `w`\n   | v = w\n   |     ^\n   = declare it";
        let shown = colored(text);
        assert_eq!(anstream::adapter::strip_str(&shown).to_string(), text);
        let lines: Vec<bool> = shown.lines().map(|l| l.contains('\u{1b}')).collect();
        assert_eq!(lines, [false, false, true, true]);
    }
}
