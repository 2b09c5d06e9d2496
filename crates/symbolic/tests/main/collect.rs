//! What collecting keeps and what it frees.

use bracketry_symbolic::{Expr, Pool};

const WANTED: [&str; 4] =
    ["x^2*sin(y) + 3/7", "exp(x + 1/2)/(1 + tanh(z)^2)", "(x + 12345678901234567890)^(1/3)", "max(x, pi)*y"];

/// Derivatives of every order up to the fourth of something with many distinct ones.
fn scratch(p: &mut Pool) {
    let e = p.parse("exp(x*y)*sin(x + y^2)/(2 + cos(z*x))").unwrap();
    let variables = ["x", "y", "z"].map(|s| p.symbol(s));
    let mut level = vec![e];
    for _ in 0..4 {
        level = level.into_iter().flat_map(|e| p.gradient(e, &variables)).collect();
    }
}

#[test]
fn what_is_kept_stays_the_same_and_the_rest_is_freed() {
    let mut p = Pool::new();
    scratch(&mut p);
    let mut roots: Vec<Expr> = WANTED.iter().map(|t| p.parse(t).unwrap()).collect();
    let texts: Vec<String> = roots.iter().map(|&e| p.text(e)).collect();
    scratch(&mut p);
    let (all, reached) = (p.len(), p.reachable(&roots).len());
    p.collect(0, &mut roots);
    assert_eq!(p.len(), reached);
    assert!(p.len() * 20 < all);
    assert_eq!(p.made(), all);
    assert_eq!(roots.iter().map(|&e| p.text(e)).collect::<Vec<_>>(), texts);
    // Equal expressions still have equal ids.
    for (text, &e) in WANTED.iter().zip(&roots) {
        assert_eq!(p.parse(text).unwrap(), e, "{text}");
    }
}

#[test]
fn what_is_older_than_the_mark_keeps_its_id_and_its_derivatives() {
    let mut p = Pool::new();
    let (x, old) = (p.symbol("x"), p.parse("x^3*exp(-x*y)").unwrap());
    let slope = p.diff(old, x);
    let (mark, text) = (p.len(), p.text(slope));
    scratch(&mut p);
    let mut kept = [p.parse("y*sin(x)^2").unwrap()];
    p.collect(mark, &mut kept);
    assert_eq!(p.diff(old, x), slope);
    assert_eq!(p.text(slope), text);
    assert_eq!(p.text(kept[0]), "y*sin(x)^2");
    p.collect(mark, &mut []);
    assert_eq!(p.len(), mark);
}

#[test]
fn derivatives_are_found_again_after_collecting() {
    let mut p = Pool::new();
    let x = p.symbol("x");
    let mut roots = vec![p.parse("sin(x^2)*exp(3*x)").unwrap()];
    let third = |p: &mut Pool, e: Expr| (0..3).fold(e, |e, _| p.diff(e, x));
    let before = third(&mut p, roots[0]);
    let text = p.text(before);
    for _ in 0..3 {
        p.collect(0, &mut roots);
        let again = third(&mut p, roots[0]);
        assert_eq!(p.text(again), text);
    }
}

#[test]
fn a_pool_in_which_questions_come_and_go_does_not_grow() {
    let mut p = Pool::new();
    let mut roots = [p.parse("x*y").unwrap()];
    let mut sizes = Vec::new();
    for _ in 0..5 {
        scratch(&mut p);
        sizes.push(p.len());
        p.collect(0, &mut roots);
    }
    assert!(sizes.iter().all(|s| *s == sizes[0]));
    assert_eq!(p.text(roots[0]), "x*y");
}

#[test]
fn nothing_is_done_where_there_is_nothing_to_free() {
    let mut p = Pool::new();
    let mut roots = [p.parse("x + 1").unwrap()];
    let (before, len) = (roots, p.len());
    p.collect(0, &mut roots);
    p.collect(len + 5, &mut []);
    assert_eq!((roots, p.len(), p.made()), (before, len, len));
    Pool::new().collect(0, &mut []);
}
