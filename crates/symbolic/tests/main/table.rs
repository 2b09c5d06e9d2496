//! Expressions stored and read again.

use crate::common::{Kind, cases, generator, random};
use bracketry_symbolic::{Bindings, Entry, ExprTable, Pool, TableError};
use proptest::prelude::*;

fn stored(table: &ExprTable) -> ExprTable {
    serde_json::from_str(&serde_json::to_string(table).unwrap()).unwrap()
}

proptest! {
    #![proptest_config(cases(300))]

    /// In the pool it comes from, the same expression; in another one, one that prints and is stored the same.
    #[test]
    fn import_after_export_is_the_identity(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let f = p.simplify(e);
        let table = stored(&p.export(&[e, f, e]));
        prop_assert_eq!(p.import(&table).unwrap(), vec![e, f, e]);
        let mut q = Pool::new();
        let other = q.import(&table).unwrap();
        prop_assert_eq!(p.text(e), q.text(other[0]));
        prop_assert_eq!(p.text(f), q.text(other[1]));
        prop_assert_eq!(q.export(&other), table);
    }
}

#[test]
fn sharing_is_stored_once() {
    let mut p = Pool::new();
    let mut e = p.parse("x + 1").unwrap();
    for _ in 0..1000 {
        let c = p.cos(e);
        let square = p.mul(e, c);
        e = p.add(square, e);
    }
    let table = p.export(&[e]);
    assert!(table.entries.len() < 5000, "{}", table.entries.len());
    assert_eq!(Pool::new().import(&table).unwrap().len(), 1);
}

/// What no pool would hold is simplified on the way in.
#[test]
fn tables_written_by_hand_get_the_local_rules() {
    let entries = vec![
        Entry::Symbol("x".into()),
        Entry::Number("0".into()),
        Entry::Add(0, 1),
        Entry::Number("6/4".into()),
        Entry::Mul(2, 3),
        Entry::Mul(4, 1),
    ];
    let mut p = Pool::new();
    let e = p.import(&ExprTable { entries, roots: vec![2, 4, 5] }).unwrap();
    assert_eq!([p.text(e[0]), p.text(e[1]), p.text(e[2])], ["x", "1.5*x", "0"]);
}

#[test]
fn bad_tables_are_refused_with_the_entry_at_fault() {
    let x = || Entry::Symbol("x".into());
    let number = |t: &str| Entry::Number(t.into());
    let refused = |entries: Vec<Entry>, roots: Vec<u32>| Pool::new().import(&ExprTable { entries, roots }).unwrap_err();
    assert_eq!(refused(vec![x(), Entry::Add(0, 1)], vec![1]), TableError::Order { entry: 1, operand: 1 });
    assert_eq!(refused(vec![Entry::Pow(u32::MAX, 0)], vec![]), TableError::Order { entry: 0, operand: u32::MAX });
    assert_eq!(refused(vec![x()], vec![0, 7]), TableError::Root { root: 7, entries: 1 });
    assert_eq!(refused(vec![Entry::Symbol(String::new())], vec![0]), TableError::Name { entry: 0 });
    for text in ["", "1/0", "1.5", "a", "1/-2", "--1", "1/2/3", " 1", "+1", "1e9", "-", "1/"] {
        assert_eq!(refused(vec![x(), number(text)], vec![1]), TableError::Number { entry: 1, text: text.into() });
    }
    assert!(matches!(refused(vec![number(&"9".repeat(20_000))], vec![0]), TableError::Number { entry: 0, .. }));
    for (name, arguments) in
        [("sin", vec![0, 0]), ("atan2", vec![0]), ("sinn", vec![0]), ("sqrt", vec![0]), ("min", vec![])]
    {
        let n = arguments.len();
        let e = refused(vec![x(), Entry::Call(name.into(), arguments)], vec![1]);
        assert_eq!(e, TableError::Function { entry: 1, name: name.into(), arguments: n });
        assert!(e.to_string().contains(name));
    }
    assert!(serde_json::from_str::<ExprTable>(r#"{"entries": [{"add": [0]}], "roots": []}"#).is_err());
    assert!(serde_json::from_str::<ExprTable>(r#"{"entries": [{"plus": [0, 0]}], "roots": []}"#).is_err());
}

#[test]
fn a_table_carries_exact_numbers() {
    let mut p = Pool::new();
    let e = p.parse("x - 123456789012345678901234567890/7").unwrap();
    let mut q = Pool::new();
    let f = q.import(&stored(&p.export(&[e]))).unwrap()[0];
    let g = q.parse("x - 123456789012345678901234567890/7").unwrap();
    assert_eq!(f, g);
    let d = q.sub(f, g);
    assert!(q.zero_test(d, &Bindings::new()).is_zero());
}
