//! Text to tokens.

use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;

use crate::parse_error::{ParseError, error};

/// Beyond this a number would not be a finite f64.
const MAX_DECIMAL_EXPONENT: i64 = 300;
const MAX_LENGTH: usize = 1 << 20;

/// A part of a text that is read as a whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    Number(RBig),
    Name(String),
    Op(char),
    Power,
    End,
}

/// A token with its place: character offsets.
pub(crate) struct Lexed {
    pub(crate) token: Token,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

/// The tokens of a text.
pub(crate) fn lex(text: &str) -> Result<Vec<Lexed>, ParseError> {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() > MAX_LENGTH {
        return error(
            0,
            "",
            format!("the expression is longer than {MAX_LENGTH} characters"),
            "split it into definitions",
        );
    }
    let mut out = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let c = chars[i];
        let start = i;
        if c.is_whitespace() {
            i += 1;
            continue;
        }
        let token = if c.is_ascii_digit() || (c == '.' && chars.get(i + 1).is_some_and(char::is_ascii_digit)) {
            let (value, end) = lex_number(&chars, i)?;
            i = end;
            Token::Number(value)
        } else if c.is_alphabetic() || c == '_' {
            while i < chars.len() && (chars[i].is_alphanumeric() || chars[i] == '_') {
                i += 1;
            }
            Token::Name(chars[start..i].iter().collect())
        } else if c == '*' && chars.get(i + 1) == Some(&'*') {
            i += 2;
            Token::Power
        } else if c == '^' {
            i += 1;
            Token::Power
        } else if "+-*/(),".contains(c) {
            i += 1;
            Token::Op(c)
        } else if c == '−' {
            i += 1;
            Token::Op('-')
        } else {
            return error(
                i,
                c.to_string(),
                format!("`{c}` is not part of an expression"),
                "use + - * / ^ ( ) , numbers and names",
            );
        };
        out.push(Lexed { token, start, end: i });
    }
    out.push(Lexed { token: Token::End, start: chars.len(), end: chars.len() });
    Ok(out)
}

/// A decimal number, read exactly.
fn lex_number(chars: &[char], start: usize) -> Result<(RBig, usize), ParseError> {
    let mut i = start;
    let mut digits = String::new();
    let mut scale: i64 = 0;
    while i < chars.len() && chars[i].is_ascii_digit() {
        digits.push(chars[i]);
        i += 1;
    }
    if i < chars.len() && chars[i] == '.' {
        i += 1;
        while i < chars.len() && chars[i].is_ascii_digit() {
            digits.push(chars[i]);
            scale -= 1;
            i += 1;
        }
    }
    if i < chars.len() && (chars[i] == 'e' || chars[i] == 'E') {
        let mut j = i + 1;
        if j < chars.len() && (chars[j] == '+' || chars[j] == '-') {
            j += 1;
        }
        let first = j;
        while j < chars.len() && chars[j].is_ascii_digit() {
            j += 1;
        }
        if j > first {
            let text: String = chars[i + 1..j].iter().collect();
            let exponent = text.parse::<i64>().unwrap_or(i64::MAX);
            if exponent.abs() > MAX_DECIMAL_EXPONENT {
                let found: String = chars[start..j].iter().collect();
                return error(
                    start,
                    found,
                    "the decimal exponent is out of range",
                    format!("keep it within ±{MAX_DECIMAL_EXPONENT}"),
                );
            }
            scale += exponent;
            i = j;
        }
    }
    if i < chars.len() && (chars[i].is_alphabetic() || chars[i] == '_' || chars[i] == '.') {
        let found: String = chars[start..=i].iter().collect();
        return error(start, found, "a number is directly followed by a name", "write the product with `*`");
    }
    let mantissa: IBig = digits.parse().unwrap_or(IBig::ZERO);
    let power = UBig::from(10u8).pow(scale.unsigned_abs() as usize);
    let value = if scale < 0 { RBig::from_parts(mantissa, power) } else { RBig::from(mantissa * IBig::from(power)) };
    Ok((value, i))
}
