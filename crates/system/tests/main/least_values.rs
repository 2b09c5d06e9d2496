//! Least values on boxes, which no value on the box is below.

use bracketry_system::LeastValue;
use bracketry_system::symbolic::{Pool, Tape};

/// On boxes around a point, the value at the point lies between the least value of the function and that of its negative.
#[test]
fn values_lie_between_the_least_and_the_greatest() {
    let mut pool = Pool::new();
    let (u, w) = (pool.symbol("u"), pool.symbol("w"));
    for text in [
        "u^3 - 2*u*w + w^2",
        "exp(-u)*sin(3*w)",
        "sqrt(1 + u^2)/(2 + cos(w))",
        "tanh(u*w) - atan(u)",
        "log(2 + sin(u)) + abs(w)^1.5",
        "max(u, w)*min(u, 0.3)",
        "tan(u/4) + cosh(w) - sinh(u)",
        "2^w + asin(u/9)",
    ] {
        let e = pool.parse(text).unwrap();
        let opposite = pool.neg(e);
        let tape = Tape::compile(&pool, &[u, w], &[e]).unwrap();
        let mut found = 0;
        for k in 0..500 {
            let at = [(f64::from(k) * 0.7).sin() * 3.0, (f64::from(k) * 1.3).cos() * 3.0];
            let half = (f64::from(k) * 0.37).sin().powi(4);
            let region = at.map(|x| [x - half, x + 0.5 * half]);
            let [least, greatest] = [e, opposite].map(|e| LeastValue::on_box(&mut pool, e, &[u, w], &region));
            let mut value = [0.0];
            tape.eval(&at, &mut Vec::new(), &mut value);
            for (least, value) in [(&least, value[0]), (&greatest, -value[0])] {
                assert!(least.as_ref().is_none_or(|l| l.value <= value), "{text} at {at:?}: {value} below {least:?}");
                found += usize::from(least.is_some());
            }
        }
        assert!(found > 980, "{text}: {found} of 1000");
    }
}
