//! What a formula consists of.

/// A formula by what stands beside, above and below what. Whoever composes it sets the parentheses.
///
/// [`Pool::notation`](crate::Pool::notation) lays out an expression; anything else is composed by hand:
///
/// ```
/// use bracketry_symbolic::{Notation, Pool, Relation};
/// let mut p = Pool::new();
/// let rate = p.parse("u*cos(theta)").unwrap();
/// let equation = Notation::symbol("x").dotted(1).relation(Relation::Equal, p.notation(rate));
/// assert_eq!(equation.latex(), r"\dot{x} = u \cos\left(\theta\right)");
/// assert!(equation.mathml().starts_with("<math><mrow>"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Digits, with a decimal point or not.
    Number(String),
    /// A name of a model: Greek names become letters; digits at the end and what follows `_` become indices.
    Symbol(String),
    /// A name without indices: a Greek name as its letter, a single letter as it is, a longer one upright.
    Letters(String),
    /// Words between formulas.
    Text(String),
    /// The name of a function or operator: `sin`, `arctan`, `span`.
    Function(&'static str),
    /// A sign by its character: `/`, `:`, `…`.
    Sign(char),
    /// Parts side by side.
    Row(Vec<Notation>),
    /// Terms, of which [negative](Notation::Negative) ones are subtracted.
    Sum(Vec<Notation>),
    /// Factors, with a dot before one that starts with a digit.
    Product(Vec<Notation>),
    /// With a minus in front.
    Negative(Box<Notation>),
    /// Numerator over denominator.
    Fraction(Box<[Notation; 2]>),
    /// Base and exponent.
    Superscript(Box<[Notation; 2]>),
    /// Base and index.
    Subscript(Box<[Notation; 2]>),
    /// Square root.
    Root(Box<Notation>),
    /// Time derivative of an order from 1: that many dots, the order in parentheses beyond 2.
    Dotted(Box<Notation>, u32),
    /// Between delimiters.
    Fenced(Fence, Box<Notation>),
    /// Items in a line with something between them.
    List(Joint, Vec<Notation>),
    /// Two sides with a relation between them.
    Relation(Box<[Notation; 2]>, Relation),
    /// Rows of entries, in parentheses.
    Matrix(Vec<Vec<Notation>>),
}

/// Delimiters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fence {
    /// ( ), as high as what they hold.
    Parentheses,
    /// [ ], as of Lie brackets.
    Brackets,
    /// { }, as of sets.
    Braces,
    /// | |, as high as what they hold.
    Bars,
    /// ⟨ ⟩.
    Angles,
}

/// What stands between the items of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// A comma without space, as between indices.
    Tight,
    /// A comma, as between arguments.
    Comma,
    /// A comma and a wider space, as between formulas.
    Wide,
    /// A comma and a quad, as between equations.
    Quad,
    /// The word "and".
    And,
    /// The word "or".
    Or,
}

/// A relation between two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// =
    Equal,
    /// ≠
    NotEqual,
    /// <
    Less,
    /// ≤
    LessOrEqual,
    /// \>
    Greater,
    /// ≥
    GreaterOrEqual,
}

impl Notation {
    /// The name of a state, input or parameter.
    pub fn symbol(name: impl Into<String>) -> Self {
        Notation::Symbol(name.into())
    }

    /// A number as it is displayed.
    pub fn number(value: impl std::fmt::Display + Copy) -> Self {
        let text = value.to_string();
        match text.strip_prefix('-') {
            Some(size) => Notation::Negative(Box::new(Notation::Number(size.to_owned()))),
            None => Notation::Number(text),
        }
    }

    /// Words.
    pub fn text(words: impl Into<String>) -> Self {
        Notation::Text(words.into())
    }

    /// This over `denominator`.
    #[must_use]
    pub fn over(self, denominator: Notation) -> Self {
        Notation::Fraction(Box::new([self, denominator]))
    }

    /// This with an exponent.
    #[must_use]
    pub fn superscript(self, exponent: Notation) -> Self {
        Notation::Superscript(Box::new([self, exponent]))
    }

    /// This with an index.
    #[must_use]
    pub fn subscript(self, index: Notation) -> Self {
        Notation::Subscript(Box::new([self, index]))
    }

    /// The square root of this.
    #[must_use]
    pub fn root(self) -> Self {
        Notation::Root(Box::new(self))
    }

    /// The time derivative of this, of an order from 1.
    #[must_use]
    pub fn dotted(self, order: u32) -> Self {
        Notation::Dotted(Box::new(self), order)
    }

    /// This between delimiters.
    #[must_use]
    pub fn fenced(self, fence: Fence) -> Self {
        Notation::Fenced(fence, Box::new(self))
    }

    /// This and another side.
    #[must_use]
    pub fn relation(self, relation: Relation, other: Notation) -> Self {
        Notation::Relation(Box::new([self, other]), relation)
    }

    /// Entries below each other.
    pub fn column(entries: impl IntoIterator<Item = Notation>) -> Self {
        Notation::Matrix(entries.into_iter().map(|e| vec![e]).collect())
    }

    /// This with other notations in place of some symbols: `replacement` gets each name.
    #[must_use]
    pub fn with_symbols(mut self, replacement: &impl Fn(&str) -> Option<Notation>) -> Self {
        self.replace_symbols(replacement);
        self
    }

    fn replace_symbols(&mut self, replacement: &impl Fn(&str) -> Option<Notation>) {
        let each = |list: &mut [Notation]| list.iter_mut().for_each(|n| n.replace_symbols(replacement));
        match self {
            Notation::Symbol(name) => {
                if let Some(new) = replacement(name) {
                    *self = new;
                }
            }
            Notation::Number(_)
            | Notation::Letters(_)
            | Notation::Text(_)
            | Notation::Function(_)
            | Notation::Sign(_) => {}
            Notation::Row(list) | Notation::Sum(list) | Notation::Product(list) | Notation::List(_, list) => each(list),
            Notation::Fraction(two)
            | Notation::Superscript(two)
            | Notation::Subscript(two)
            | Notation::Relation(two, _) => each(&mut two[..]),
            Notation::Negative(one) | Notation::Root(one) | Notation::Dotted(one, _) | Notation::Fenced(_, one) => {
                one.replace_symbols(replacement);
            }
            Notation::Matrix(rows) => rows.iter_mut().for_each(|r| each(r)),
        }
    }
}
