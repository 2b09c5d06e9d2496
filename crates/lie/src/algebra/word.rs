//! Iterated brackets as formal words, read and written as text.

use std::fmt;
use std::sync::Arc;

use bracketry_symbolic::{Pool, Symbol, closest_name};
use rustc_hash::FxHashMap;

use std::fmt::Write as _;

use crate::algebra::field::{Field, VectorFields, bracket};
use crate::as_text::serialized_as_text;
use crate::budget::check_growth;
use crate::error::{WordError, WordProblem};
use crate::undecided::Undecided;

/// Most letters of a word that is read from text.
const MAX_LETTERS: usize = 64;

/// An iterated bracket of generators, not evaluated: an element of the free magma on the numbers 0, 1, …
///
/// The generators of a system are its drift f (number 0) and its input fields g_1 … g_m.
///
/// ```
/// use bracketry_lie::algebra::Word;
/// let names = ["f", "g1", "g2"];
/// let word = Word::parse("[g2,[f,g1]]", |name| names.iter().position(|n| *n == name)).unwrap();
/// assert_eq!((word.length(), word.degrees(3)), (3, vec![1, 1, 1]));
/// assert_eq!(word.name(&names), "[g2,[f,g1]]");
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Word {
    /// A single generator.
    Generator(usize),
    /// The bracket of two words.
    Bracket(Arc<[Word; 2]>),
}

impl Word {
    /// `[a, b]`
    pub fn bracket(a: Word, b: Word) -> Word {
        Word::Bracket(Arc::new([a, b]))
    }

    /// Number of letters.
    pub fn length(&self) -> usize {
        match self {
            Word::Generator(_) => 1,
            Word::Bracket(ab) => ab[0].length() + ab[1].length(),
        }
    }

    /// How often each of the generators 0 … `generators` − 1 occurs.
    pub fn degrees(&self, generators: usize) -> Vec<usize> {
        let mut degrees = vec![0; generators];
        self.count(&mut degrees);
        degrees
    }

    fn count(&self, degrees: &mut [usize]) {
        match self {
            Word::Generator(i) => {
                if let Some(d) = degrees.get_mut(*i) {
                    *d += 1;
                }
            }
            Word::Bracket(ab) => ab.iter().for_each(|w| w.count(degrees)),
        }
    }

    /// The word with the given names of the generators, such as `[g1,[f,g1]]`.
    pub fn name(&self, names: &[impl AsRef<str>]) -> String {
        let mut text = String::new();
        self.write(names, &mut text);
        text
    }

    fn write(&self, names: &[impl AsRef<str>], text: &mut String) {
        match self {
            Word::Generator(i) => match names.get(*i) {
                Some(name) => text.push_str(name.as_ref()),
                None => {
                    let _ = write!(text, "#{i}");
                }
            },
            Word::Bracket(ab) => {
                text.push('[');
                ab[0].write(names, text);
                text.push(',');
                ab[1].write(names, text);
                text.push(']');
            }
        }
    }

    /// Reads a word such as `[g2,[f,g1]]`; `generator` gives the number of a name.
    ///
    /// # Errors
    /// [`WordError`] with place and remedy.
    pub fn parse(text: &str, generator: impl Fn(&str) -> Option<usize>) -> Result<Word, WordError> {
        parse(text, |name| {
            generator(name).ok_or_else(|| WordProblem::UnknownName { name: name.to_owned(), remedy: String::new() })
        })
    }
}

/// A generator of the Lie algebra of a system or of several modes together; modes have the numbers 1, 2, …
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Generator {
    /// The drift, of one mode where it is not the same in all.
    Drift {
        /// The mode.
        mode: Option<usize>,
    },
    /// The field of an input, of one mode where it is not the same in all.
    Input {
        /// The input, from 1.
        input: usize,
        /// The mode.
        mode: Option<usize>,
    },
    /// The drift of a mode less that of the first.
    DriftDifference {
        /// The mode.
        mode: usize,
    },
}

impl fmt::Display for Generator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Generator::Drift { mode: None } => write!(f, "f"),
            Generator::Drift { mode: Some(k) } => write!(f, "f({k})"),
            Generator::Input { input, mode: None } => write!(f, "g{input}"),
            Generator::Input { input, mode: Some(k) } => write!(f, "g{input}({k})"),
            Generator::DriftDifference { mode } => write!(f, "f({mode})-f(1)"),
        }
    }
}

/// The generators f, g_1 … g_m of a system with that many inputs.
pub fn generators(inputs: usize) -> Arc<[Generator]> {
    let fields = (1..=inputs).map(|input| Generator::Input { input, mode: None });
    std::iter::once(Generator::Drift { mode: None }).chain(fields).collect()
}

/// A word with what its letters stand for. Its text is that of [`Word::name`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bracket {
    /// The word in the numbers of the generators.
    pub word: Word,
    /// The generators.
    pub generators: Arc<[Generator]>,
}

impl Bracket {
    pub(crate) fn list(words: &[Word], generators: &Arc<[Generator]>) -> Vec<Self> {
        words.iter().map(|word| Bracket { word: word.clone(), generators: generators.clone() }).collect()
    }

    /// The generators that occur, each once.
    pub fn letters(&self) -> Vec<Generator> {
        let degrees = self.word.degrees(self.generators.len());
        self.generators.iter().zip(degrees).filter(|x| x.1 > 0).map(|x| *x.0).collect()
    }
}

impl fmt::Display for Bracket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.generators.iter().map(ToString::to_string).collect();
        f.write_str(&self.word.name(&names))
    }
}

serialized_as_text!(Bracket);

/// What the reader waits for: the first factor of a bracket, or, with the first factor, the second.
enum Open {
    First,
    Second(Word),
}

fn parse(text: &str, generator: impl Fn(&str) -> Result<usize, WordProblem>) -> Result<Word, WordError> {
    let characters: Vec<char> = text.chars().collect();
    let fail = |at: usize, problem| WordError { text: text.to_owned(), column: at + 1, problem };
    let expected = |at: usize, expected: &'static str| {
        let found = characters.get(at).map_or("the end".to_owned(), |c| format!("`{c}`"));
        fail(at, WordProblem::Expected { expected, found })
    };
    let mut open: Vec<Open> = Vec::new();
    let (mut at, mut letters) = (0, 0);
    let skip = |at: &mut usize| {
        while characters.get(*at).is_some_and(|c| c.is_whitespace()) {
            *at += 1;
        }
    };
    loop {
        skip(&mut at);
        if characters.get(at) == Some(&'[') {
            // A word of that depth has more letters.
            if open.len() >= MAX_LETTERS {
                return Err(fail(at, WordProblem::TooLong { limit: MAX_LETTERS }));
            }
            open.push(Open::First);
            at += 1;
            continue;
        }
        let name: String = characters[at..].iter().take_while(|c| c.is_alphanumeric() || **c == '_').collect();
        if name.is_empty() {
            return Err(expected(at, "a generator or `[`"));
        }
        letters += 1;
        if letters > MAX_LETTERS {
            return Err(fail(at, WordProblem::TooLong { limit: MAX_LETTERS }));
        }
        let mut word = Word::Generator(generator(&name).map_err(|p| fail(at, p))?);
        at += name.chars().count();
        // Closes the brackets that end here, up to one that waits for its second factor.
        loop {
            skip(&mut at);
            let here = characters.get(at);
            match open.pop() {
                None if at == characters.len() => return Ok(word),
                None => return Err(expected(at, "the end")),
                Some(Open::First) if here == Some(&',') => {
                    open.push(Open::Second(word));
                    at += 1;
                    break;
                }
                Some(Open::First) => return Err(expected(at, "`,`")),
                Some(Open::Second(first)) if here == Some(&']') => {
                    word = Word::bracket(first, word);
                    at += 1;
                }
                Some(Open::Second(_)) => return Err(expected(at, "`]`")),
            }
        }
    }
}

/// Reads a word in the generators `f`, `g1` … `gm`, where an input field also goes by the name of its input.
///
/// # Errors
/// [`WordError`] with place and remedy; an input called `f` or `g2` that is another generator is ambiguous.
pub(crate) fn parse_named(text: &str, inputs: &[String]) -> Result<Word, WordError> {
    let names: Vec<String> = generators(inputs.len()).iter().map(ToString::to_string).collect();
    parse(text, |name| {
        let generator = names.iter().position(|n| n == name);
        let input = inputs.iter().position(|n| n == name).map(|i| i + 1);
        match (generator, input) {
            (Some(a), Some(b)) if a != b => Err(WordProblem::Ambiguous { name: name.to_owned() }),
            (Some(i), _) | (None, Some(i)) => Ok(i),
            (None, None) => {
                let known: Vec<&str> = names.iter().chain(inputs).map(String::as_str).collect();
                let remedy = match closest_name(name, known.iter().copied()) {
                    Some(near) => format!("; did you mean `{near}`?"),
                    None => format!("; there are {}", known.join(", ")),
                };
                Err(WordProblem::UnknownName { name: name.to_owned(), remedy })
            }
        }
    })
}

/// The fields of words in `generators`, sharing what they have in common.
///
/// # Errors
/// [`Undecided::TooLarge`] where the brackets take too many nodes.
pub(crate) fn evaluate(
    pool: &mut Pool,
    states: &[Symbol],
    generators: &[Field],
    words: &[Word],
) -> Result<Vec<Field>, Undecided> {
    let first = pool.len();
    let mut known = FxHashMap::default();
    words.iter().map(|w| evaluate_one(pool, states, generators, w, first, &mut known)).collect()
}

fn evaluate_one(
    pool: &mut Pool,
    states: &[Symbol],
    generators: &[Field],
    word: &Word,
    first: usize,
    known: &mut FxHashMap<Word, Field>,
) -> Result<Field, Undecided> {
    let ab = match word {
        // A generator that does not exist is the zero field.
        Word::Generator(i) => {
            return Ok(generators.get(*i).cloned().unwrap_or_else(|| vec![pool.int(0); states.len()]));
        }
        Word::Bracket(ab) => ab,
    };
    if let Some(field) = known.get(word) {
        return Ok(field.clone());
    }
    let a = evaluate_one(pool, states, generators, &ab[0], first, known)?;
    let b = evaluate_one(pool, states, generators, &ab[1], first, known)?;
    check_growth(pool, first, [&a, &b], 1)?;
    let field = bracket(pool, states, &a, &b);
    known.insert(word.clone(), field.clone());
    Ok(field)
}

impl VectorFields {
    /// f, g_1 … g_m: the generators that the numbers in a [`Word`] stand for.
    pub fn generators(&self) -> Vec<Field> {
        std::iter::once(&self.drift).chain(&self.controls).cloned().collect()
    }

    /// The vector fields that words in f (number 0) and g_1 … g_m stand for.
    ///
    /// # Errors
    /// [`Undecided::TooLarge`] where the brackets take too many nodes.
    pub fn brackets(&self, pool: &mut Pool, words: &[Word]) -> Result<Vec<Field>, Undecided> {
        evaluate(pool, &self.states, &self.generators(), words)
    }

    /// Reads a word such as `[g2,[f,g1]]` in the generators `f`, `g1` … `gm`; `inputs` are other names of g_1 … g_m.
    ///
    /// # Errors
    /// [`WordError`] with place and remedy.
    pub fn parse_word(&self, text: &str, inputs: &[String]) -> Result<Word, WordError> {
        let inputs: Vec<String> =
            (0..self.controls.len()).map(|i| inputs.get(i).cloned().unwrap_or_else(|| format!("g{}", i + 1))).collect();
        parse_named(text, &inputs)
    }
}
