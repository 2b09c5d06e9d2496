//! Formulas in LaTeX.

use std::fmt::Write as _;

use super::name::{greek, is_single, spelled, starts_with_digit};
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
        Notation::Letters(name) if greek(name).is_some() => out.extend(["\\", name]),
        Notation::Letters(name) if is_single(name) => out.push_str(name),
        Notation::Letters(name) => wrapped("\\mathrm", name, out),
        Notation::Text(words) => wrapped("\\text", words, out),
        Notation::Function(name) => match *name {
            "sin" | "cos" | "tan" | "arcsin" | "arccos" | "arctan" | "sinh" | "cosh" | "tanh" | "exp" | "ln"
            | "min" | "max" | "det" | "dim" | "ker" => out.extend(["\\", name]),
            _ => wrapped("\\operatorname", name, out),
        },
        Notation::Sign('π') => out.push_str("\\pi"),
        Notation::Sign('→') => out.push_str("\\to "),
        Notation::Sign('…') => out.push_str("\\dots"),
        Notation::Sign(c) => out.push(*c),
        Notation::Row(parts) => joined(parts, "", out),
        Notation::Sum(terms) => sum(terms, out),
        Notation::Product(factors) => product(factors, out),
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
            match two[0] {
                Notation::Dotted(_, 3..) | Notation::Superscript(_) => group(&two[0], out),
                _ => set(&two[0], out),
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
        Notation::Dotted(inside, order) => dotted(inside, *order, out),
        Notation::Fenced(fence, inside) => {
            let (open, close) = delimiters(*fence);
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

fn sum(terms: &[Notation], out: &mut String) {
    for (i, term) in terms.iter().enumerate() {
        let (sign, size) = match term {
            _ if i == 0 => ("", term),
            Notation::Negative(size) => (" - ", &**size),
            _ => (" + ", term),
        };
        out.push_str(sign);
        set(size, out);
    }
}

fn product(factors: &[Notation], out: &mut String) {
    for (i, factor) in factors.iter().enumerate() {
        // Two numbers side by side would read as one.
        out.push_str(match i {
            0 => "",
            _ if starts_with_digit(factor) => " \\cdot ",
            _ => " ",
        });
        set(factor, out);
    }
}

fn dotted(inside: &Notation, order: u32, out: &mut String) {
    out.push_str(match order {
        1 => "\\dot",
        2 => "\\ddot",
        _ => "",
    });
    group(inside, out);
    if order > 2 {
        let _ = write!(out, "^{{({order})}}");
    }
}

fn delimiters(fence: Fence) -> (&'static str, &'static str) {
    match fence {
        Fence::Parentheses => ("\\left(", "\\right)"),
        Fence::Brackets => ("[", "]"),
        Fence::Braces => ("\\{", "\\}"),
        Fence::Bars => ("\\left|", "\\right|"),
        Fence::Angles => ("\\langle", "\\rangle"),
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
