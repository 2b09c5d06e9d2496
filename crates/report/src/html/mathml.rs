//! Formulas as MathML, which browsers set by themselves, from the LaTeX that expressions are written in.

use bracketry_symbolic::Pool;

/// Letters by their LaTeX names.
const LETTERS: [(&str, char); 33] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("iota", 'ι'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("upsilon", 'υ'),
    ("phi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Lambda", 'Λ'),
    ("Xi", 'Ξ'),
    ("Sigma", 'Σ'),
    ("Upsilon", 'Υ'),
    ("Phi", 'Φ'),
    ("Psi", 'Ψ'),
    ("Omega", 'Ω'),
];

/// Text in which no sign has a meaning of its own in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A formula as it stands in model files, set; as code where it cannot be read.
pub fn formula(text: &str) -> String {
    let mut pool = Pool::new();
    match pool.parse(text) {
        Ok(e) => math(&pool.latex(e)),
        Err(_) => format!("<code>{}</code>", escaped(text)),
    }
}

/// A formula in the LaTeX of [`Pool::latex`], set.
pub fn math(latex: &str) -> String {
    let mut reader = Reader { rest: latex };
    format!("<math>{}</math>", reader.row(None))
}

struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    /// Everything up to `end`, which is read too, as one row.
    fn row(&mut self, end: Option<&str>) -> String {
        let mut items: Vec<String> = Vec::new();
        loop {
            self.rest = self.rest.trim_start();
            if let Some(end) = end
                && let Some(after) = self.rest.strip_prefix(end)
            {
                self.rest = after;
                break;
            }
            let Some(c) = self.rest.chars().next() else { break };
            if c == '^' || c == '_' {
                self.rest = &self.rest[1..];
                let base = items.pop().unwrap_or_default();
                let script = self.argument();
                items.push(scripted(&base, c, &script));
            } else {
                items.push(self.item(c));
            }
        }
        format!("<mrow>{}</mrow>", items.concat())
    }

    /// What stands between braces, or a single item.
    fn argument(&mut self) -> String {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix('{') {
            Some(after) => {
                self.rest = after;
                self.row(Some("}"))
            }
            None => self.rest.chars().next().map_or_else(String::new, |c| self.item(c)),
        }
    }

    /// The text between braces as it stands.
    fn words(&mut self) -> String {
        let Some(after) = self.rest.strip_prefix('{') else { return String::new() };
        let end = after.find('}').unwrap_or(after.len());
        let words = after[..end].replace('\\', "");
        self.rest = after.get(end + 1..).unwrap_or("");
        words
    }

    fn item(&mut self, c: char) -> String {
        if c == '\\' {
            self.rest = &self.rest[1..];
            return self.command();
        }
        if c.is_ascii_digit() {
            let end = self.rest.find(|d: char| !d.is_ascii_digit() && d != '.').unwrap_or(self.rest.len());
            let (number, after) = self.rest.split_at(end);
            self.rest = after;
            return format!("<mn>{number}</mn>");
        }
        self.rest = &self.rest[c.len_utf8()..];
        match c {
            '{' => self.row(Some("}")),
            '-' => "<mo>−</mo>".to_owned(),
            _ if c.is_alphabetic() => format!("<mi>{c}</mi>"),
            _ => format!("<mo>{}</mo>", escaped(&c.to_string())),
        }
    }

    fn command(&mut self) -> String {
        let end = self.rest.find(|d: char| !d.is_ascii_alphabetic()).unwrap_or(self.rest.len());
        let (name, after) = self.rest.split_at(end);
        let name = name.to_owned();
        self.rest = after;
        match name.as_str() {
            "frac" => {
                let (above, below) = (self.argument(), self.argument());
                format!("<mfrac>{above}{below}</mfrac>")
            }
            "sqrt" => format!("<msqrt>{}</msqrt>", self.argument()),
            "left" | "right" => {
                let c = self.rest.chars().next().unwrap_or('(');
                self.rest = self.rest.get(c.len_utf8()..).unwrap_or("");
                format!("<mo>{c}</mo>")
            }
            "mathrm" | "text" | "operatorname" => {
                let words = self.words();
                derivative(&words).unwrap_or_else(|| format!("<mi mathvariant=\"normal\">{}</mi>", escaped(&words)))
            }
            "cdot" => "<mo>·</mo>".to_owned(),
            "" => {
                // An escaped sign.
                let c = self.rest.chars().next().unwrap_or(' ');
                self.rest = self.rest.get(c.len_utf8()..).unwrap_or("");
                format!("<mo>{}</mo>", escaped(&c.to_string()))
            }
            _ => match LETTERS.iter().find(|(n, _)| *n == name) {
                Some((_, letter)) => format!("<mi>{letter}</mi>"),
                None => format!("<mi mathvariant=\"normal\">{}</mi>", escaped(&name)),
            },
        }
    }
}

/// `der(theta, 2)` as a letter with dots.
fn derivative(words: &str) -> Option<String> {
    let (name, order) = words.strip_prefix("der(")?.strip_suffix(')')?.split_once(',')?;
    let order = order.trim().parse::<usize>().ok()?.checked_sub(1)?;
    let letter = match LETTERS.iter().find(|(n, _)| *n == name) {
        Some((_, letter)) => letter.to_string(),
        None => escaped(name),
    };
    if letter.chars().count() > 1 {
        return Some(format!("<mover><mi>{letter}</mi><mo>{}</mo></mover>", ["˙", "¨", "⃛"].get(order)?));
    }
    // Dots of the letter's own: without a mathematical font browsers set those of a <mover> into the letter.
    let dots = ['\u{307}', '\u{308}', '\u{20db}'].get(order)?;
    Some(format!("<mi style=\"font-style:italic\">{letter}{dots}</mi>"))
}

/// A base with an index or an exponent; an exponent on an index makes both.
fn scripted(base: &str, sign: char, script: &str) -> String {
    match (sign, base.strip_prefix("<msub>").and_then(|b| b.strip_suffix("</msub>"))) {
        ('^', Some(inside)) => format!("<msubsup>{inside}{script}</msubsup>"),
        ('^', None) => format!("<msup>{base}{script}</msup>"),
        _ => format!("<msub>{base}{script}</msub>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_powers_and_indices_are_set() {
        assert_eq!(
            math(r"\frac{\mu x_{1}^{2}}{\sqrt{2 \theta}}"),
            "<math><mrow><mfrac><mrow><mi>μ</mi><msubsup><mi>x</mi><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></msubsup></mrow>\
             <mrow><msqrt><mrow><mn>2</mn><mi>θ</mi></mrow></msqrt></mrow></mfrac></mrow></math>"
        );
    }

    #[test]
    fn derivatives_of_inputs_have_dots() {
        let set = math(r"\mathrm{der(theta, 2)}");
        assert_eq!(set, "<math><mrow><mi style=\"font-style:italic\">θ\u{308}</mi></mrow></math>");
        assert!(math(r"\mathrm{der(load, 1)}").contains("<mover><mi>load</mi><mo>˙</mo></mover>"));
        assert!(math(r"\mathrm{der(x)}").contains("der(x)"));
    }

    #[test]
    fn every_tag_that_is_opened_is_closed() {
        for text in ["-c*v*abs(v)", "F_c*sign(v)*exp(-(v/v_s)^2)", "sin(theta1)^2/(m*L^2)", "atan2(a, b) - min(a, 2.5)"]
        {
            let set = formula(text);
            for tag in ["math", "mrow", "mfrac", "msup", "msub", "mi", "mn", "mo"] {
                let (open, close) =
                    (set.matches(&format!("<{tag}>")).count(), set.matches(&format!("</{tag}>")).count());
                let attributed = set.matches(&format!("<{tag} ")).count();
                assert_eq!(open + attributed, close, "{tag} in {set}");
            }
            assert!(!set.contains('\\'), "{set}");
        }
    }

    #[test]
    fn what_cannot_be_read_stays_as_it_is_written() {
        assert_eq!(formula("a <- b"), "<code>a &lt;- b</code>");
    }
}
