//! Text to expressions: a precedence-climbing parser whose errors name the place and the remedy.

use crate::closest_name::closest_name;
use crate::foreign_name::{instead_of_function, instead_of_name};
use dashu_base::BitTest;
use dashu_ratio::RBig;

use crate::func::{Func, Func2};
use crate::lexer::{Lexed, Token, lex};
use crate::node::{Directed, Expr};
use crate::parse_error::{ParseError, error};
use crate::pool::Pool;

/// Where the names in a text come from.
pub trait Names {
    /// The expression that `name` stands for, `None` if it is not known.
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr>;
    /// The expression for `der(name, order)`, the time derivative of an input; `None` if `name` is not an input.
    fn derivative(&mut self, _pool: &mut Pool, _name: &str, _order: u32) -> Option<Expr> {
        None
    }
    /// The expression for `rate(name)`, the change of an input from one sample to the next over the period; `None` where there
    /// are no samples, or `name` is not an input.
    fn rate(&mut self, _pool: &mut Pool, _name: &str) -> Option<Expr> {
        None
    }
    /// All known names, for suggestions.
    fn known(&self) -> Vec<String>;
}

/// Every name is an indeterminate.
struct Free;

impl Names for Free {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        Some(pool.var(name))
    }
    fn known(&self) -> Vec<String> {
        Vec::new()
    }
}

const MAX_DEPTH: u32 = 200;
/// Constants are multiplied and added exactly, so that products of many would fill the memory.
const MAX_NUMBER_BITS: usize = 1 << 13;

struct Parser<'a, N: Names> {
    pool: &'a mut Pool,
    names: &'a mut N,
    chars: Vec<char>,
    tokens: Vec<Lexed>,
    at: usize,
    depth: u32,
    /// Numbers of the pool that are known to be short.
    short_numbers: usize,
}

impl<N: Names> Parser<'_, N> {
    fn peek(&self) -> &Token {
        &self.tokens[self.at].token
    }

    fn found(&self) -> String {
        let t = &self.tokens[self.at];
        if t.token == Token::End { "end of expression".into() } else { self.chars[t.start..t.end].iter().collect() }
    }

    fn fail<T>(&self, message: impl Into<String>, remedy: impl Into<String>) -> Result<T, ParseError> {
        error(self.tokens[self.at].start, self.found(), message, remedy)
    }

    fn take(&mut self, op: char) -> bool {
        let hit = *self.peek() == Token::Op(op);
        self.at += usize::from(hit);
        hit
    }

    fn expect(&mut self, op: char, context: &str) -> Result<(), ParseError> {
        if self.take(op) { Ok(()) } else { self.fail(format!("expected `{op}` {context}"), format!("add `{op}`")) }
    }

    fn deeper<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T, ParseError>) -> Result<T, ParseError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return self.fail(format!("nested more than {MAX_DEPTH} deep"), "split it into definitions");
        }
        let r = f(self);
        self.depth -= 1;
        r
    }

    /// Passes an expression on unless its numbers have grown beyond all use.
    fn short(&mut self, e: Expr) -> Result<Expr, ParseError> {
        let long = |x: &RBig| x.numerator().bit_len().max(x.denominator().bit_len()) > MAX_NUMBER_BITS;
        if self.pool.numbers.iter().skip(self.short_numbers).any(long) {
            return self
                .fail(format!("a constant has more than {MAX_NUMBER_BITS} binary digits"), "round the numbers in it");
        }
        self.short_numbers = self.pool.numbers.len();
        Ok(e)
    }

    fn sum(&mut self) -> Result<Expr, ParseError> {
        let mut left = self.product()?;
        loop {
            if self.take('+') {
                let right = self.product()?;
                let sum = self.pool.add(left, right);
                left = self.short(sum)?;
            } else if self.take('-') {
                let right = self.product()?;
                let difference = self.pool.sub(left, right);
                left = self.short(difference)?;
            } else {
                return Ok(left);
            }
        }
    }

    fn product(&mut self) -> Result<Expr, ParseError> {
        let mut left = self.unary()?;
        loop {
            if self.take('*') {
                let right = self.unary()?;
                let product = self.pool.mul(left, right);
                left = self.short(product)?;
            } else if *self.peek() == Token::Op('/') {
                self.at += 1;
                let start = self.at;
                let right = self.unary()?;
                if self.pool.is_zero(right) {
                    self.at = start;
                    return self.fail("division by zero", "divide by something that is not zero");
                }
                let quotient = self.pool.div(left, right);
                left = self.short(quotient)?;
            } else {
                return Ok(left);
            }
        }
    }

    /// A sign binds weaker than `^`: −x² is −(x²).
    fn unary(&mut self) -> Result<Expr, ParseError> {
        if self.take('-') {
            let e = self.deeper(Self::unary)?;
            Ok(self.pool.neg(e))
        } else if self.take('+') {
            self.deeper(Self::unary)
        } else {
            self.power()
        }
    }

    fn power(&mut self) -> Result<Expr, ParseError> {
        let base = self.atom()?;
        if *self.peek() != Token::Power {
            return Ok(base);
        }
        self.at += 1;
        let start = self.at;
        let exponent = self.deeper(Self::unary)?;
        if self.pool.is_zero(base) && self.pool.number(exponent).is_some_and(|k| *k < RBig::ZERO) {
            self.at = start;
            return self.fail("zero to a negative power", "divide by something that is not zero");
        }
        let power = self.pool.pow(base, exponent);
        self.short(power)
    }

    fn atom(&mut self) -> Result<Expr, ParseError> {
        match self.peek().clone() {
            Token::Number(x) => {
                let number = self.pool.rational(x);
                let number = self.short(number)?;
                self.at += 1;
                Ok(number)
            }
            Token::Op('(') => {
                self.at += 1;
                let e = self.deeper(Self::sum)?;
                self.expect(')', "to close the parenthesis")?;
                Ok(e)
            }
            Token::Name(name) => {
                let is_call = self.tokens[self.at + 1].token == Token::Op('(');
                if is_call { self.call(&name) } else { self.name(&name) }
            }
            Token::End => self.fail("the expression ends too early", "an operand is missing here"),
            _ => self.fail("an operand is missing", "put a number, a name, or a parenthesis here"),
        }
    }

    fn name(&mut self, name: &str) -> Result<Expr, ParseError> {
        if name == "pi" {
            self.at += 1;
            return Ok(self.pool.pi());
        }
        if is_function(name) {
            return self.fail(format!("`{name}` is a function"), format!("write `{name}(…)`"));
        }
        match self.names.lookup(self.pool, name) {
            Some(e) => {
                self.at += 1;
                Ok(e)
            }
            None => self.unknown(name),
        }
    }

    fn unknown<T>(&self, name: &str) -> Result<T, ParseError> {
        let known = self.names.known();
        let same = known.iter().find(|k| k.to_lowercase() == name.to_lowercase());
        let near = closest_name(name, known.iter().map(String::as_str));
        let remedy = match (near, instead_of_name(name)) {
            (_, Some(foreign)) if same.is_none() => foreign.into(),
            (_, Some(foreign)) => format!("did you mean `{}`? Otherwise: {foreign}", same.map_or("", String::as_str)),
            (Some(near), _) => format!("did you mean `{near}`?"),
            (None, _) => "declare it as a state, an input, a parameter, or a definition".into(),
        };
        self.fail(format!("unknown name `{name}`"), remedy)
    }

    fn call(&mut self, name: &str) -> Result<Expr, ParseError> {
        let start = self.at;
        if name == "der" {
            return self.input_derivative();
        }
        if name == "rate"
            && let Some(e) = self.input_rate()?
        {
            return Ok(e);
        }
        if !is_function(name) {
            let known: Vec<&str> = function_names().collect();
            let foreign = instead_of_function(name);
            let remedy = match closest_name(name, known.iter().copied()) {
                _ if foreign.is_some() => foreign.unwrap_or_default().into(),
                Some(near) => format!("did you mean `{near}`?"),
                None if self.names.known().iter().any(|n| n == name) => "write the product with `*`".into(),
                None => format!("the functions are {}", known.join(" ")),
            };
            return self.fail(format!("unknown function `{name}`"), remedy);
        }
        self.at += 2;
        let mut arguments = vec![self.deeper(Self::sum)?];
        while self.take(',') {
            arguments.push(self.deeper(Self::sum)?);
        }
        self.expect(')', &format!("after the arguments of `{name}`"))?;
        if name == "unit" {
            return Ok(self.unit_component(&arguments));
        }
        let wanted = if Func2::ALL.iter().any(|(_, n)| *n == name) { 2 } else { 1 };
        if arguments.len() != wanted {
            self.at = start;
            return self.fail(
                format!(
                    "`{name}` takes {wanted} argument{}, not {}",
                    if wanted == 1 { "" } else { "s" },
                    arguments.len()
                ),
                "correct the number of arguments",
            );
        }
        let (a, b) = (arguments[0], arguments[arguments.len() - 1]);
        if name == "sqrt" {
            return Ok(self.pool.sqrt(a));
        }
        if let Some((f, _)) = Func::ALL.iter().find(|(_, n)| *n == name) {
            return Ok(self.pool.call(*f, a));
        }
        match Func2::ALL.iter().find(|(_, n)| *n == name) {
            Some((f, _)) => Ok(self.pool.call2(*f, a, b)),
            None => self.unknown(name),
        }
    }

    /// `unit(a, b, …)`, the first component of the unit vector along its arguments: `a/√(a² + b² + …)`.
    fn unit_component(&mut self, arguments: &[Expr]) -> Expr {
        if let [only] = arguments {
            return self.pool.call(Func::Sign, *only);
        }
        let squares: Vec<Expr> = arguments.iter().map(|&a| self.pool.powi(a, 2)).collect();
        let square = self.pool.sum(squares);
        self.pool.set_directed(square, Directed::Written);
        let size = self.pool.sqrt(square);
        self.pool.div(arguments[0], size)
    }

    /// `rate(u)`, where names have rates.
    fn input_rate(&mut self) -> Result<Option<Expr>, ParseError> {
        let Token::Name(input) = self.tokens[self.at + 2].token.clone() else { return Ok(None) };
        let Some(e) = self.names.rate(self.pool, &input) else { return Ok(None) };
        self.at += 3;
        self.expect(')', "after the argument of `rate`")?;
        Ok(Some(e))
    }

    /// `der(u)` or `der(u, k)`
    fn input_derivative(&mut self) -> Result<Expr, ParseError> {
        self.at += 2;
        let at_name = self.at;
        let Token::Name(input) = self.peek().clone() else {
            return self.fail("`der` needs the name of an input", "write `der(u)` or `der(u, 2)`");
        };
        self.at += 1;
        let mut order = 1;
        if self.take(',') {
            let k = match self.peek() {
                Token::Number(x) if x.is_int() => u32::try_from(x.numerator()).ok().filter(|k| (1..=20).contains(k)),
                _ => None,
            };
            let Some(k) = k else {
                return self.fail("the order of a derivative is an integer from 1 to 20", "write `der(u, 2)`");
            };
            order = k;
            self.at += 1;
        }
        self.expect(')', "after the arguments of `der`")?;
        if let Some(e) = self.names.derivative(self.pool, &input, order) {
            return Ok(e);
        }
        self.at = at_name;
        if self.names.known().contains(&input) {
            return self.fail(
                format!("`{input}` is not an input"),
                "only inputs have `der(…)`; use the state's own equation instead",
            );
        }
        self.unknown(&input)
    }
}

fn function_names() -> impl Iterator<Item = &'static str> {
    Func::ALL.iter().map(|(_, n)| *n).chain(Func2::ALL.iter().map(|(_, n)| *n)).chain(["sqrt", "unit", "der"])
}

fn is_function(name: &str) -> bool {
    function_names().any(|n| n == name)
}

impl Pool {
    /// Reads an expression in which every name is an indeterminate.
    ///
    /// # Errors
    /// [`ParseError`] with the place, the offending text and the remedy.
    pub fn parse(&mut self, text: &str) -> Result<Expr, ParseError> {
        self.parse_with(text, &mut Free)
    }

    /// Reads an expression whose names come from `names`.
    ///
    /// # Errors
    /// [`ParseError`] with the place, the offending text and the remedy.
    pub fn parse_with<N: Names>(&mut self, text: &str, names: &mut N) -> Result<Expr, ParseError> {
        let tokens = lex(text)?;
        let short_numbers = self.numbers.len();
        let mut p = Parser { pool: self, names, chars: text.chars().collect(), tokens, at: 0, depth: 0, short_numbers };
        if *p.peek() == Token::End {
            return p.fail("the expression is empty", "write an expression, for instance 0");
        }
        let e = p.sum()?;
        match p.peek() {
            Token::End => Ok(e),
            Token::Op(')') => p.fail("a parenthesis is closed that was not opened", "remove it or add `(`"),
            Token::Number(_) | Token::Name(_) | Token::Op('(') => {
                p.fail("an operator is missing", "write the product with `*`")
            }
            _ => p.fail("unexpected text here", "remove it"),
        }
    }
}
