//! Philip Hall bases, brackets as words, and the names of what a rank counts.

use std::collections::BTreeMap;

use crate::common::{fields, ratio, shown, system};
use bracketry_lie::algebra::{HallBasis, HallTooLarge, Word, WordProblem, witt, witt_degrees};
use bracketry_lie::{AnalysisOptions, Answer, Error, Evidence, VectorFields, analyze_affine, bracket};
use bracketry_symbolic::{Bindings, Echelon, Fp, Pool, ZeroTest};

/// An element of the free associative algebra: words of letters with coefficients.
type Polynomial = BTreeMap<Vec<usize>, i64>;

fn product(a: &Polynomial, b: &Polynomial, sign: i64, into: &mut Polynomial) {
    for (u, x) in a {
        for (v, y) in b {
            *into.entry(u.iter().chain(v).copied().collect()).or_default() += sign * x * y;
        }
    }
}

fn commutator(word: &Word) -> Polynomial {
    match word {
        Word::Generator(i) => BTreeMap::from([(vec![*i], 1)]),
        Word::Bracket(ab) => {
            let (a, b) = (commutator(&ab[0]), commutator(&ab[1]));
            let mut sum = Polynomial::new();
            product(&a, &b, 1, &mut sum);
            product(&b, &a, -1, &mut sum);
            sum
        }
    }
}

fn rank(list: &[Polynomial]) -> usize {
    let mut columns: Vec<&Vec<usize>> = list.iter().flat_map(BTreeMap::keys).collect();
    columns.sort();
    columns.dedup();
    let rows: Vec<Vec<Fp>> =
        list.iter().map(|p| columns.iter().map(|c| Fp::from_i64(p.get(*c).copied().unwrap_or(0))).collect()).collect();
    Echelon::new(&rows, columns.len()).rank()
}

#[test]
fn there_are_as_many_elements_as_witt_says() {
    for (m, length) in [(1, 5), (2, 10), (3, 7), (4, 5), (7, 3)] {
        let basis = HallBasis::new(m, length).unwrap();
        for l in 1..=length {
            assert_eq!(basis.of_length(l).len() as u128, witt(m, l).unwrap(), "{m} generators, length {l}");
        }
        assert_eq!(basis.of_length(length + 1), basis.len()..basis.len());
    }
}

#[test]
fn degrees_are_counted_and_bounded() {
    let bound = [2, 3, 1];
    let basis = HallBasis::with_degrees(&bound).unwrap();
    for i in 0..=bound[0] {
        for j in 0..=bound[1] {
            for k in 0..=bound[2] {
                let found = basis.elements().iter().filter(|e| e.degrees == [i, j, k]).count();
                assert_eq!(found as u128, witt_degrees(&[i, j, k]).unwrap(), "degrees {i} {j} {k}");
            }
        }
    }
    assert!(basis.elements().iter().all(|e| e.degrees.iter().zip(bound).all(|(d, b)| *d <= b)));
    for (i, e) in basis.elements().iter().enumerate() {
        assert_eq!(basis.word(i).degrees(3), e.degrees);
        assert_eq!(basis.word(i).length(), e.length());
    }
    // A generator that may not occur takes part in nothing.
    let without = HallBasis::with_degrees(&[1, 0, 2]).unwrap();
    let names: Vec<String> = (0..without.len()).map(|i| without.name(i, &["a", "b", "c"])).collect();
    assert_eq!(names, ["a", "c", "[a,c]", "[c,[a,c]]"]);
}

#[test]
fn numbers_by_degrees_add_up_to_numbers_by_length() {
    for n in 1..=8 {
        let sum: u128 =
            (0..=n).flat_map(|i| (0..=n - i).map(move |j| [i, j, n - i - j])).map(|d| witt_degrees(&d).unwrap()).sum();
        assert_eq!(sum, witt(3, n).unwrap());
    }
}

/// The elements are independent in the free Lie algebra, and every right-normed bracket is a combination of them.
#[test]
fn the_elements_are_a_basis_of_the_free_lie_algebra() {
    for (m, length) in [(2, 7), (3, 5)] {
        let basis = HallBasis::new(m, length).unwrap();
        for l in 1..=length {
            let mut list: Vec<Polynomial> = basis.of_length(l).map(|i| commutator(&basis.word(i))).collect();
            assert_eq!(rank(&list), list.len());
            let dimension = list.len();
            let mut right_normed = vec![Word::Generator(0), Word::Generator(1)];
            for k in 2..=l {
                right_normed = right_normed.iter().map(|w| Word::bracket(Word::Generator(k % m), w.clone())).collect();
            }
            if l > 1 {
                list.extend(right_normed.iter().map(commutator));
            }
            assert_eq!(rank(&list), dimension);
        }
    }
}

#[test]
fn no_more_elements_are_formed_than_are_allowed() {
    assert_eq!(HallBasis::new(3, 40), Err(HallTooLarge { limit: 100_000 }));
    assert_eq!(HallBasis::with_degrees(&[30, 30]), Err(HallTooLarge { limit: 100_000 }));
    assert_eq!(HallBasis::new(1, usize::MAX).unwrap().len(), 1);
    assert!(HallBasis::new(3, 0).unwrap().is_empty());
    assert!(HallBasis::new(0, 9).unwrap().is_empty());
    assert_eq!(witt(1000, 60), None);
}

/// Three fields on R³ with brackets that do not vanish.
fn example(pool: &mut Pool) -> VectorFields {
    let states = ["x", "y", "z"].map(|s| pool.symbol(s)).to_vec();
    let mut field = |c: [&str; 3]| c.map(|s| pool.parse(s).unwrap()).to_vec();
    let f = field(["y", "x*z", "sin(x)"]);
    let g = vec![field(["1", "z^2", "0"]), field(["0", "x", "exp(y)"])];
    VectorFields::new(states, f, g, Bindings::new()).unwrap()
}

#[test]
fn elements_are_evaluated_as_their_words_say() {
    let mut p = Pool::new();
    let v = example(&mut p);
    let basis = HallBasis::new(3, 4).unwrap();
    let generators = v.generators();
    let found = basis.fields(&mut p, &v.states, &generators).unwrap();
    for i in 3..basis.len() {
        let (a, b) = basis.elements()[i].factors.unwrap();
        assert_eq!(found[i], bracket(&mut p, &v.states, &found[a], &found[b]), "{}", basis.name(i, &["f", "g1", "g2"]));
    }
    let words: Vec<Word> = (0..basis.len()).map(|i| basis.word(i)).collect();
    assert_eq!(v.brackets(&mut p, &words).unwrap(), found);
}

#[test]
fn a_name_is_read_as_the_bracket_it_stands_for() {
    let mut p = Pool::new();
    let v = example(&mut p);
    let inputs = ["thrust".to_owned(), "tau".to_owned()];
    let basis = HallBasis::new(3, 4).unwrap();
    for i in 0..basis.len() {
        let name = basis.name(i, &["f", "g1", "g2"]);
        assert_eq!(v.parse_word(&name, &inputs).unwrap(), basis.word(i), "{name}");
    }
    let by_input = v.parse_word(" [ tau , [f, thrust] ]", &inputs).unwrap();
    assert_eq!(by_input.name(&["f", "g1", "g2"]), "[g2,[f,g1]]");
}

#[test]
fn text_that_is_no_bracket_is_told_where_and_why() {
    let v = example(&mut Pool::new());
    let read = |text: &str| v.parse_word(text, &["thrust".to_owned(), "g1".to_owned()]).unwrap_err();
    for (text, message) in [
        (
            "[g2,[f,g3]]",
            "`[g2,[f,g3]]` is not a bracket: at character 8, `g3` is neither a generator nor an input; there are f, g1, g2, thrust, g1",
        ),
        (
            "[f,trust]",
            "`[f,trust]` is not a bracket: at character 4, `trust` is neither a generator nor an input; did you mean `thrust`?",
        ),
        ("", "`` is not a bracket: at character 1, expected a generator or `[`, found the end"),
        ("[f g2]", "`[f g2]` is not a bracket: at character 4, expected `,`, found `g`"),
        ("[f,g2", "`[f,g2` is not a bracket: at character 6, expected `]`, found the end"),
        ("[f,g2]]", "`[f,g2]]` is not a bracket: at character 7, expected the end, found `]`"),
        ("[f,g2,f]", "`[f,g2,f]` is not a bracket: at character 6, expected `]`, found `,`"),
        ("[f,]", "`[f,]` is not a bracket: at character 4, expected a generator or `[`, found `]`"),
        ("f g2", "`f g2` is not a bracket: at character 3, expected the end, found `g`"),
        ("[f,g1]", "`[f,g1]` is not a bracket: at character 4, `g1` names both an input and another input field"),
    ] {
        assert_eq!(read(text).to_string(), message);
    }
    for deep in ["[".repeat(100_000), "[f,".repeat(100_000)] {
        assert_eq!(read(&deep).problem, WordProblem::TooLong { limit: 64 });
    }
}

#[test]
fn brackets_that_are_asked_for_are_reported_simplified() {
    let car = system(
        &["x", "y", "th", "ph"],
        &["speed", "steer"],
        &[("l", ratio(3, 10))],
        &["cos(th)*speed", "sin(th)*speed", "tan(ph)/l*speed", "steer"],
        &[],
        None,
    );
    let wanted = ["[g1,g2]", "[speed,[g1,g2]]", "f"].map(str::to_owned).to_vec();
    let report = analyze_affine(&car, &AnalysisOptions { brackets: wanted, ..AnalysisOptions::default() }).unwrap();
    let mut p = car.pool.clone();
    let expected = [
        ("[g1,g2]", ["0", "0", "-1/(l*cos(ph)^2)", "0"]),
        ("[speed,[g1,g2]]", ["-sin(th)/(l*cos(ph)^2)", "cos(th)/(l*cos(ph)^2)", "0", "0"]),
        ("f", ["0", "0", "0", "0"]),
    ];
    for (bracket, (key, components)) in report.brackets.iter().zip(expected) {
        assert_eq!(bracket.name, *key);
        for (text, wanted) in bracket.components.known().unwrap().iter().zip(components) {
            let (a, b) = (p.parse(&text.to_string()).unwrap(), p.parse(wanted).unwrap());
            let gap = p.sub(a, b);
            assert!(matches!(p.zero_test(gap, &Bindings::new()), ZeroTest::Zero(_)), "{key}: {text} is not {wanted}");
        }
    }
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["brackets"]["f"], serde_json::json!(["0", "0", "0", "0"]));
    assert_eq!(json["modes"][0]["basis"], serde_json::json!(["g1", "g2", "[g1,g2]", "[g1,[g1,g2]]"]));
    let bad = AnalysisOptions { brackets: vec!["[g1,steering]".to_owned()], ..AnalysisOptions::default() };
    assert!(matches!(analyze_affine(&car, &bad), Err(Error::Bracket(_))));
}

#[test]
fn with_switching_each_mode_has_its_brackets_and_its_generators_in_the_family() {
    let rubbing = system(&["x", "v"], &["u"], &[("mu", ratio(3, 10))], &["v", "-mu*sign(v)*v + u"], &[], None);
    let options = AnalysisOptions { brackets: vec!["[f,u]".to_owned()], ..AnalysisOptions::default() };
    let report = analyze_affine(&rubbing, &options).unwrap();
    let of_mode = |k: usize| shown(report.modes[k].brackets[0].components.known().unwrap()).join(" ");
    assert_eq!([of_mode(0), of_mode(1)], ["-1 mu", "-1 -mu"]);
    assert_eq!(shown(&report.switched.unwrap().dimensions.basis), ["f(1)", "g1"]);
}

/// The brackets that are named span a space of the dimension that is reported, in the order of the growth.
#[test]
fn the_named_brackets_have_the_rank_that_is_reported() {
    let mut p = Pool::new();
    let states = ["x", "y", "z", "p", "q"].map(|s| p.symbol(s)).to_vec();
    let mut field = |c: [&str; 5]| c.map(|s| p.parse(s).unwrap()).to_vec();
    let (f, g) = (field(["y*z", "p", "q^2", "0", "x*p"]), field(["0", "0", "0", "1", "cos(y)"]));
    let v = VectorFields::new(states, f, vec![g], Bindings::new()).unwrap();
    let mut evidence = Evidence::default();
    for closure in
        [v.accessibility(&mut p, &mut evidence).unwrap(), v.strong_accessibility(&mut p, &mut evidence).unwrap()]
    {
        assert_eq!(closure.words.len(), closure.dimension());
        let named = v.brackets(&mut p, &closure.words).unwrap();
        for &d in &closure.growth {
            assert_eq!(p.rank(&named[..d], &Bindings::new()).unwrap().rank, d);
        }
    }
}

#[test]
fn modes_name_what_spans_their_distributions() {
    let mut unicycle = system(&["x", "y", "th"], &["a", "b"], &[], &["a*cos(th)", "a*sin(th)", "b"], &[], None);
    let v = fields(&mut unicycle);
    let reach = v.accessibility(&mut unicycle.pool, &mut Evidence::default()).unwrap();
    assert_eq!(reach.words.iter().map(|w| w.name(&["f", "a", "b"])).collect::<Vec<_>>(), ["a", "b", "[a,b]"]);
    let report = analyze_affine(&unicycle, &AnalysisOptions::default()).unwrap();
    assert_eq!(shown(&report.modes[0].dimensions.basis), ["g1", "g2", "[g1,g2]"]);
    assert_eq!(shown(&report.modes[0].dimensions.strong_basis), ["g1", "g2", "[g1,g2]"]);
    assert_eq!(report.at_point.as_ref().and_then(Answer::known).map(|p| p.dimensions.basis.clone()), None);
}
