//! Signs and values of constants, whatever cancels.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Pool, Rational, Tape};

/// A number that is found by comparisons alone to 200 binary digits is the value of floating-point numbers, and every number near it is
/// on the right side of it: the intervals of each precision hold the value.
#[test]
fn intervals_hold_the_values_of_floating_point_numbers() {
    let half = Rational::ONE / Rational::from(2);
    for text in [
        "sin(17/5)*exp(-2/3) + cos(100)",
        "atan(3/7) - asin(1/5)*acos(2/9)",
        "tan(11/10)/sqrt(7) - log(5/3)^3",
        "2^(3/7)*(sinh(1/2) - cosh(3/2)*tanh(1/9))",
        "atan2(-1, -2) + atan2(3, 5)*min(pi, 3) - max(abs(-2), sign(-pi))",
        "pi^sqrt(2) - (-3)^5/7^3",
    ] {
        let mut pool = Pool::new();
        let e = pool.parse(text).unwrap();
        let mut value = [0.0];
        Tape::compile(&pool, &[], &[e]).unwrap().eval(&[], &mut Vec::new(), &mut value);
        let rounding = 1e-13 * value[0].abs().max(1.0);
        assert!((pool.constant_value(e, &Bindings::new()).unwrap() - value[0]).abs() <= rounding, "{text}");
        let mut side = |than: &Rational| {
            let than = pool.rational(than.clone());
            let difference = pool.sub(e, than);
            pool.constant_sign(difference, &Bindings::new()).unwrap()
        };
        // Nested intervals from one of the width of rounding.
        let exact = |v: f64| Rational::try_from(v).unwrap();
        let (mut low, mut high) = (exact(value[0] - rounding), exact(value[0] + rounding));
        assert_eq!((side(&low), side(&high)), (Ordering::Greater, Ordering::Less), "{text}");
        for _ in 0..160 {
            let middle = (&low + &high) * &half;
            if side(&middle) == Ordering::Greater {
                low = middle;
            } else {
                high = middle;
            }
        }
        let mut distance = exact(rounding);
        for bits in 44..200 {
            distance *= &half;
            if bits % 4 > 0 {
                continue;
            }
            assert_eq!(side(&(&low - &distance)), Ordering::Greater, "{text}: less by 2^-{bits}");
            assert_eq!(side(&(&high + &distance)), Ordering::Less, "{text}: more by 2^-{bits}");
        }
    }
}

/// The same of the longest intervals: two forms of a number differ by what is added to one of them, however little it is.
#[test]
fn intervals_of_the_highest_precision_hold_the_values_of_two_forms() {
    let mut pool = Pool::new();
    for (one, other) in [
        ("tan(11/10)*cos(11/10)", "sin(11/10)"),
        ("sin(17/5)", "2*sin(17/10)*cos(17/10)"),
        ("sinh(1/2) + cosh(1/2)", "exp(1/2)"),
        ("tanh(1/9)", "(exp(2/9) - 1)/(exp(2/9) + 1)"),
        ("log(5/3)", "log(5) - log(3)"),
        ("asin(1/5)", "pi/2 - acos(1/5)"),
        ("atan(3/7)", "atan2(3, 7)"),
        ("atan2(-1, -2)", "atan(1/2) - pi"),
        ("atan(1/5)", "pi/16 + atan(1/239)/4"),
        ("2^(3/7)", "exp(3*log(2)/7)"),
        ("pi^sqrt(2)", "exp(sqrt(2)*log(pi))"),
        ("min(pi, 3)/sqrt(7)", "3*sqrt(7)/7"),
        ("max(abs(-2), sign(-pi))*exp(-2/3)", "2*exp(1/3)/exp(1)"),
    ] {
        for digits in [25, 60, 120, 250] {
            for (sign, found) in [("+", Ordering::Greater), ("-", Ordering::Less)] {
                let text = format!("{one} - ({other}) {sign} 10^(-{digits})");
                let e = pool.parse(&text).unwrap();
                assert_eq!(pool.constant_sign(e, &Bindings::new()), Some(found), "{text}");
            }
        }
    }
}

#[test]
fn values_are_right_to_the_last_digit_whatever_cancels() {
    let mut pool = Pool::new();
    for (text, value) in [
        ("sin(pi/2)", 1.0),
        ("2*cos(pi/3) + tan(pi/4)", 2.0),
        ("(1 + 10^(-40))^(1/3) - 1", 1e-40 / 3.0),
        ("(exp(10^(-30)) - 1)*10^30", 1.0),
        ("sqrt(2)*sqrt(3) - sqrt(6)", 0.0),
        ("abs(sqrt(8) - 2*sqrt(2)) - 5", -5.0),
        ("log(10^16 + 1) - log(10^16)", 1e-16),
    ] {
        let e = pool.parse(text).unwrap();
        let found = pool.constant_value(e, &Bindings::new()).unwrap();
        assert!((found - value).abs() <= 3e-16 * value.abs(), "{text}: {found:e} {value:e}");
    }
    for text in ["log(-1)", "1/(sqrt(2)*sqrt(3) - sqrt(6))", "x", "exp(exp(exp(10)))"] {
        let e = pool.parse(text).unwrap();
        assert_eq!(pool.constant_value(e, &Bindings::new()), None, "{text}");
    }
}

#[test]
fn signs_of_differences_far_below_rounding_are_found() {
    let mut pool = Pool::new();
    for (text, sign) in [
        ("sqrt(2) + sqrt(3) - sqrt(5 + 2*sqrt(6))", Some(Ordering::Equal)),
        ("sin(1)^2 + cos(1)^2 - 1 + 10^(-200)", Some(Ordering::Greater)),
        ("exp(1/3)*exp(1/6) - exp(1/2)", Some(Ordering::Equal)),
        ("(1 + 10^(-40))^(1/3) - 1 - 10^(-40)/3", Some(Ordering::Less)),
        ("log(-1)", None),
        ("1/(sqrt(2)*sqrt(3) - sqrt(6))", None),
    ] {
        let e = pool.parse(text).unwrap();
        assert_eq!(pool.constant_sign(e, &Bindings::new()), sign, "{text}");
    }
}
