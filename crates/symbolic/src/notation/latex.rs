//! Formulas in LaTeX.

use std::fmt::Write as _;

use super::name::{begins_with_digit, greek, is_single, spelled};
use super::tree::{Fence, Joint, Notation, Relation};

impl Notation {
    /// The formula in LaTeX, to be put between `$`.
    pub fn latex(&self) -> String {
        let mut out = String::new();
        set(self, &mut out);
        out
    }

    /// A relation as a row of LaTeX's `align`, which is aligned at its sign; anything else as [`Notation::latex`].
    pub fn latex_aligned(&self) -> String {
        match self {
            Notation::Relation(two, relation) => format!("{} &{} {}", two[0].latex(), sign(*relation), two[1].latex()),
            _ => self.latex(),
        }
    }
}

fn set(formula: &Notation, out: &mut String) {
    match formula {
        Notation::Number(digits) => out.push_str(digits),
        Notation::Symbol(name) => set(&spelled(name), out),
        Notation::Letters(name) => match greek(name) {
            Some(_) => out.extend(["\\", name]),
            None if is_single(name) => out.push_str(name),
            None => wrapped("\\mathrm", name, out),
        },
        Notation::Text(words) => wrapped("\\text", words, out),
        Notation::Function(name) => match *name {
            "sin" | "cos" | "tan" | "arcsin" | "arccos" | "arctan" | "sinh" | "cosh" | "tanh" | "exp" | "ln"
            | "min" | "max" | "det" | "dim" | "ker" => out.extend(["\\", name]),
            _ => wrapped("\\operatorname", name, out),
        },
        Notation::Sign(c) => match c {
            'π' => out.push_str("\\pi"),
            '…' => out.push_str("\\dots"),
            _ => out.push(*c),
        },
        Notation::Row(parts) => parts.iter().for_each(|p| set(p, out)),
        Notation::Sum(terms) => {
            for (i, term) in terms.iter().enumerate() {
                match (i, term) {
                    (0, _) => set(term, out),
                    (_, Notation::Negative(size)) => {
                        out.push_str(" - ");
                        set(size, out);
                    }
                    _ => {
                        out.push_str(" + ");
                        set(term, out);
                    }
                }
            }
        }
        Notation::Product(factors) => {
            for (i, factor) in factors.iter().enumerate() {
                if i > 0 {
                    // Two numbers side by side would read as one.
                    out.push_str(if begins_with_digit(factor) { " \\cdot " } else { " " });
                }
                set(factor, out);
            }
        }
        Notation::Negative(size) => {
            out.push('-');
            set(size, out);
        }
        Notation::Fraction(two) => {
            out.push_str("\\frac");
            group(&two[0], out);
            group(&two[1], out);
        }
        Notation::Superscript(two) => {
            // A base with a superscript of its own would have two of them.
            if matches!(two[0], Notation::Dotted(_, 3..) | Notation::Superscript(_)) {
                group(&two[0], out);
            } else {
                set(&two[0], out);
            }
            out.push('^');
            group(&two[1], out);
        }
        Notation::Subscript(two) => {
            set(&two[0], out);
            out.push('_');
            group(&two[1], out);
        }
        Notation::Root(inside) => {
            out.push_str("\\sqrt");
            group(inside, out);
        }
        Notation::Dotted(inside, order) => {
            out.push_str(match order {
                1 => "\\dot",
                2 => "\\ddot",
                _ => "",
            });
            group(inside, out);
            if *order > 2 {
                let _ = write!(out, "^{{({order})}}");
            }
        }
        Notation::Fenced(fence, inside) => {
            let (open, close) = match fence {
                Fence::Parentheses => ("\\left(", "\\right)"),
                Fence::Brackets => ("[", "]"),
                Fence::Braces => ("\\{", "\\}"),
                Fence::Bars => ("\\left|", "\\right|"),
                Fence::Angles => ("\\langle", "\\rangle"),
            };
            out.push_str(open);
            set(inside, out);
            out.push_str(close);
        }
        Notation::List(joint, items) => joined(items, between(*joint), out),
        Notation::Relation(two, relation) => {
            set(&two[0], out);
            out.extend([" ", sign(*relation), " "]);
            set(&two[1], out);
        }
        Notation::Matrix(rows) => {
            out.push_str("\\begin{pmatrix}");
            for (i, row) in rows.iter().enumerate() {
                out.push_str(if i > 0 { "\\\\ " } else { "" });
                joined(row, " & ", out);
            }
            out.push_str("\\end{pmatrix}");
        }
    }
}

fn joined(items: &[Notation], between: &str, out: &mut String) {
    for (i, item) in items.iter().enumerate() {
        out.push_str(if i > 0 { between } else { "" });
        set(item, out);
    }
}

fn group(formula: &Notation, out: &mut String) {
    out.push('{');
    set(formula, out);
    out.push('}');
}

/// A command with text in which no character has a meaning of its own.
fn wrapped(command: &str, text: &str, out: &mut String) {
    out.push_str(command);
    out.push('{');
    for c in text.chars() {
        match c {
            '_' | '%' | '#' | '&' | '$' | '{' | '}' => out.extend(['\\', c]),
            '\\' => out.push_str("\\backslash "),
            '^' | '~' => out.extend(['\\', c, '{', '}']),
            _ => out.push(c),
        }
    }
    out.push('}');
}

fn between(joint: Joint) -> &'static str {
    match joint {
        Joint::Tight => ",",
        Joint::Comma => ", ",
        Joint::Wide => ",\\ ",
        Joint::Quad => ",\\quad ",
        Joint::And => "\\ \\text{and}\\ ",
        Joint::Or => "\\ \\text{or}\\ ",
    }
}

fn sign(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::NotEqual => "\\ne",
        Relation::Less => "<",
        Relation::LessOrEqual => "\\le",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => "\\ge",
    }
}
