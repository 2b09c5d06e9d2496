//! Formulas of model files as MathML.

use bracketry_symbolic::Pool;

/// Text in which no sign has a meaning of its own in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A formula as it stands in model files, set; as code where it cannot be read.
pub fn formula(text: &str) -> String {
    let mut pool = Pool::new();
    match pool.parse(text) {
        Ok(e) => pool.notation(e).mathml(),
        Err(_) => format!("<code>{}</code>", escaped(text)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
