//! Minimum and zero of a function of one variable whose sign tells the side of an event.

/// Golden-section search for the least value on `[a, b]`, to 1e-7; ends at the first that is negative.
pub(super) fn minimum(mut f: impl FnMut(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let golden = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    while b - a > 1e-7 {
        if fc < 0.0 {
            return c;
        }
        if fd < 0.0 {
            return d;
        }
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - golden * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + golden * (b - a);
            fd = f(d);
        }
    }
    0.5 * (a + b)
}

/// The zero of a function that is positive at `a` and negative at `b`, from the right to `resolution` (regula falsi, Illinois
/// rule, safeguarded).
pub(super) fn root(mut f: impl FnMut(f64) -> f64, mut a: f64, mut b: f64, resolution: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    if fa <= 0.0 {
        return a;
    }
    let mut side = 0;
    for iteration in 0..100 {
        if b - a <= resolution || fb == 0.0 {
            break;
        }
        let mut m = if iteration % 8 == 7 { 0.5 * (a + b) } else { b - fb * (b - a) / (fb - fa) };
        if !(m > a && m < b) {
            m = 0.5 * (a + b);
        }
        let fm = f(m);
        if fm > 0.0 {
            (a, fa) = (m, fm);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        } else {
            if b - m <= resolution * 0.5 && m - a > resolution {
                // Creeping from the right: close in from the left as well.
                let probe = m - resolution;
                let fp = f(probe);
                if fp > 0.0 {
                    return m;
                }
                (b, fb) = (probe, fp);
                continue;
            }
            (b, fb) = (m, fm);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
        }
    }
    b
}
