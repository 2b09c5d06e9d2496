//! Formulas in MathML, which browsers set by themselves.

use super::name::{greek, is_single, spelled, starts_with_digit};
use super::tree::{Fence, Joint, Notation, Relation};

impl Notation {
    /// The formula as a `<math>` element of HTML.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("x/y^2").unwrap();
    /// assert_eq!(p.notation(e).mathml(), "<math><mfrac><mi>x</mi><msup><mi>y</mi><mn>2</mn></msup></mfrac></math>");
    /// ```
    pub fn mathml(&self) -> String {
        format!("<math>{}</math>", set(self))
    }
}

fn set(formula: &Notation) -> String {
    match formula {
        Notation::Number(digits) => format!("<mn>{}</mn>", escaped(digits)),
        Notation::Symbol(name) => match derivative(name) {
            Some((input, order)) => dotted(&spelled(input), order),
            None => set(&spelled(name)),
        },
        Notation::Letters(name) => letters(name, ""),
        Notation::Text(words) => format!("<mtext>{}</mtext>", escaped(words)),
        Notation::Function(name) => upright(name),
        Notation::Sign('π') => "<mi>π</mi>".to_owned(),
        Notation::Sign(c) => operator(&c.to_string()),
        Notation::Row(parts) => row(parts.iter().map(set)),
        Notation::Sum(terms) => row(terms.iter().enumerate().map(|(i, term)| match (i, term) {
            (0, _) => set(term),
            (_, Notation::Negative(size)) => operator("−") + &set(size),
            _ => operator("+") + &set(term),
        })),
        Notation::Product(factors) => row(factors.iter().enumerate().map(|(i, factor)| {
            let dot = if i > 0 && starts_with_digit(factor) { operator("·") } else { String::new() };
            dot + &set(factor)
        })),
        Notation::Negative(size) => row([operator("−"), set(size)]),
        Notation::Fraction(two) => element("mfrac", [set(&two[0]), set(&two[1])]),
        Notation::Superscript(two) => superscript(&two[0], &two[1]),
        Notation::Subscript(two) => element("msub", [set(&two[0]), set(&two[1])]),
        Notation::Root(inside) => element("msqrt", [set(inside)]),
        Notation::Dotted(inside, order) => dotted(inside, *order),
        Notation::Fenced(fence, inside) => {
            let (open, close) = match fence {
                Fence::Parentheses => ("(", ")"),
                Fence::Brackets => ("[", "]"),
                Fence::Braces => ("{", "}"),
                Fence::Bars => ("|", "|"),
                Fence::Angles => ("⟨", "⟩"),
            };
            row([operator(open), set(inside), operator(close)])
        }
        Notation::List(joint, items) => {
            let between = between(*joint);
            row(items.iter().enumerate().map(|(i, item)| if i > 0 { between.clone() + &set(item) } else { set(item) }))
        }
        Notation::Relation(two, relation) => row([set(&two[0]), operator(sign(*relation)), set(&two[1])]),
        Notation::Matrix(rows) => {
            let cell = |e: &Notation| element("mtd", [set(e)]);
            let table = element("mtable", rows.iter().map(|r| element("mtr", r.iter().map(cell))));
            row([operator("("), table, operator(")")])
        }
    }
}

fn element(tag: &str, parts: impl IntoIterator<Item = String>) -> String {
    format!("<{tag}>{}</{tag}>", parts.into_iter().collect::<String>())
}

fn row(parts: impl IntoIterator<Item = String>) -> String {
    element("mrow", parts)
}

fn operator(sign: &str) -> String {
    format!("<mo>{}</mo>", escaped(sign))
}

fn upright(name: &str) -> String {
    format!("<mi mathvariant=\"normal\">{}</mi>", escaped(name))
}

/// Text in which no character has a meaning of its own in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A name without indices, with a combining mark where it is a single letter.
fn letters(name: &str, mark: &str) -> String {
    match greek(name) {
        Some(letter) if mark.is_empty() => format!("<mi>{letter}</mi>"),
        Some(letter) => marked(&letter.to_string(), mark),
        None if !is_single(name) => upright(name),
        None if name.starts_with(|c: char| c.is_ascii_digit()) => format!("<mn>{name}</mn>"),
        None if mark.is_empty() => format!("<mi>{name}</mi>"),
        None => marked(name, mark),
    }
}

fn marked(letter: &str, mark: &str) -> String {
    format!("<mi style=\"font-style:italic\">{letter}{mark}</mi>")
}

/// An index and an exponent stand above each other.
fn superscript(base: &Notation, exponent: &Notation) -> String {
    let spelled = match base {
        Notation::Symbol(name) if derivative(name).is_none() => spelled(name),
        _ => base.clone(),
    };
    match spelled {
        Notation::Subscript(two) => element("msubsup", [set(&two[0]), set(&two[1]), set(exponent)]),
        _ => element("msup", [set(base), set(exponent)]),
    }
}

/// A time derivative: the dots stand on the letter, not on its index.
fn dotted(formula: &Notation, order: u32) -> String {
    let (mark, dots) = match order {
        1 => ("\u{307}", "˙"),
        2 => ("\u{308}", "¨"),
        3 => ("\u{20db}", "⃛"),
        _ => return format!("<msup>{}<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow></msup>", set(formula)),
    };
    match formula {
        Notation::Symbol(name) => dotted(&spelled(name), order),
        Notation::Subscript(two) => element("msub", [dotted(&two[0], order), set(&two[1])]),
        // Dots of the letter's own: without a mathematical font browsers set those of a <mover> into the letter.
        Notation::Letters(name) if greek(name).is_some() || is_single(name) => letters(name, mark),
        _ => format!("<mover accent=\"true\">{}<mo>{dots}</mo></mover>", set(formula)),
    }
}

/// Name and order of a derivative of an input as it is called in a pool.
fn derivative(name: &str) -> Option<(&str, u32)> {
    let inside = name.strip_prefix("der(")?.strip_suffix(')')?;
    let (input, order) = inside.split_once(',').unwrap_or((inside, "1"));
    Some((input, order.trim().parse().ok().filter(|k| *k > 0)?))
}

fn between(joint: Joint) -> String {
    let spaced = |width: &str| format!("{}<mspace width=\"{width}\"/>", operator(","));
    let word = |word: &str| format!("<mspace width=\"0.5em\"/><mtext>{word}</mtext><mspace width=\"0.5em\"/>");
    match joint {
        Joint::Tight | Joint::Comma => operator(","),
        Joint::Wide => spaced("0.3em"),
        Joint::Quad => spaced("1em"),
        Joint::And => word("and"),
        Joint::Or => word("or"),
    }
}

fn sign(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::NotEqual => "≠",
        Relation::Less => "<",
        Relation::LessOrEqual => "≤",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => "≥",
    }
}
