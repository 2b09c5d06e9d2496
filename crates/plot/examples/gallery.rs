//! Draws one figure of each kind with synthetic data: `cargo run -p bracketry-plot --example gallery -- FOLDER`.

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use bracketry_plot::{
    Animation, Arrow, BarChart, Color, ColorMap, Dash, HeatMap, Interval, IntervalChart, Outline, Panel, PlanView,
    Pose, RecordedMotion, RegimeMap, Scene, Series, Snapshot, TimeSeries, VectorField, XyChart,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("give a folder to write into")?;
    let folder = Path::new(&folder);
    time_series().draw()?.save(folder.join("time_series"))?;
    plan_view().draw()?.save(folder.join("plan_view"))?;
    growth().draw()?.save(folder.join("growth"))?;
    convergence().draw()?.save(folder.join("convergence"))?;
    gain().draw()?.save(folder.join("gain"))?;
    ranking().draw()?.save(folder.join("ranking"))?;
    time_to_target().draw()?.save(folder.join("time_to_target"))?;
    drift().draw()?.save(folder.join("drift"))?;
    regimes().draw()?.save(folder.join("regimes"))?;
    velocity_field().draw()?.save(folder.join("velocity_field"))?;
    let animation = animation();
    animation.image(30)?.save(folder.join("animation_30"))?;
    animation.save(folder.join("animation.gif"))?;
    Ok(())
}

/// Samples of `f` at `n` times from 0 to `end`.
fn sample(end: f64, n: usize, f: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let t: Vec<f64> = (0..n).map(|k| end * k as f64 / (n - 1) as f64).collect();
    let y = t.iter().map(|t| f(*t)).collect();
    (t, y)
}

fn ease(t: f64) -> f64 {
    let s = (t / 2.0).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

fn time_series() -> TimeSeries {
    let line = |name: &str, f: &dyn Fn(f64) -> f64| {
        let (t, y) = sample(2.4, 4000, f);
        Series::new(name, t, y)
    };
    let wiggle = |t: f64| (6.0 * PI * t).sin() * (1.0 - ease(t));
    let mut figure = TimeSeries::new()
        .title("Position and orientation together, closed loop on the exact stick–slip plant")
        .panel(
            Panel::new("x [m]")
                .series(line("", &|t| 0.48 + 0.06 * ease(t) + 0.004 * wiggle(t)))
                .target(0.54)
                .target_band(0.5388, 0.5412),
        )
        .panel(Panel::new("y [m]").series(line("", &|t| -0.03 + 0.03 * ease(t) - 0.003 * wiggle(t))).target(0.0))
        .panel(
            Panel::new("φ [°]")
                .series(line("simultaneous", &|t| 90.0 * ease(t)))
                .series(line("two-step", &|t| 90.0 * ease(t / 1.2)).dash(Dash::Dashed))
                .target(90.0),
        )
        .panel(
            Panel::new("velocity [m/s]")
                .series(line("ẋ", &|t| 0.18 * (6.0 * PI * t).cos() * (1.0 - ease(t))))
                .series(line("ẏ", &|t| 0.09 * (6.0 * PI * t + 1.0).cos() * (1.0 - ease(t)))),
        )
        .panel(
            Panel::new("Ẍ [m/s²]")
                .series(Series::new("", sample(2.4, 121, wiggle).0, sample(2.4, 121, |t| 13.5 * wiggle(t)).1).step())
                .bound(15.0)
                .bound(-15.0),
        )
        .panel(
            Panel::new("plate tilt")
                .series(line("θ [rad]", &|t| 0.3 * (6.0 * PI * t + 0.7).sin() * (1.0 - ease(t))))
                .series(
                    line("0.1 θ̇ [rad/s]", &|t| 0.5 * (6.0 * PI * t + 0.7).cos() * (1.0 - ease(t))).color(Color::PURPLE),
                ),
        );
    let modes = ["slides +x", "sticks in x", "slides −x", "sticks in x"];
    let mut start = 0.0;
    for k in 0..30 {
        let end = if k % 2 == 0 { start + 0.13 } else { start + 0.035 };
        figure = figure.interval(Interval::new(start, f64::min(end, 2.4), modes[k % 4]));
        start = f64::min(end, 2.4);
    }
    figure.category_color("sticks in x", Color(222, 222, 222)).category_color("slides −x", Color::band(1))
}

fn plan_view() -> PlanView {
    let object = Outline::Ellipse { a: 0.15, b: 0.1 };
    let target = Pose::new(0.54, 0.0, FRAC_PI_2);
    let track = |name: &str, end: f64, s: &dyn Fn(f64) -> (f64, f64)| {
        let (t, x) = sample(end, 2000, |t| 0.48 + 0.06 * s(t).0 + 0.004 * (12.0 * t).sin() * (1.0 - t / end));
        let (_, y) = sample(end, 2000, |t| -0.03 + 0.03 * s(t).0 + 0.004 * ((12.0 * t).cos() - 1.0) * (1.0 - t / end));
        let (_, phi) = sample(end, 2000, |t| FRAC_PI_2 * s(t).1);
        RecordedMotion::new(name, t, x, y, phi)
    };
    let together = track("MPC", 2.0, &|t| (ease(t), ease(t)));
    let apart = track("published inputs", 15.0, &|t| (ease((t - 11.0) / 2.0), ease(t / 5.5)));
    PlanView::new()
        .title("60 mm, 30 mm and 90° from rest to rest")
        .scene(Scene::new("Simultaneous", object.clone()).trajectory(together).target(target))
        .scene(Scene::new("Two steps: first orientation, then position", object).trajectory(apart).target(target))
}

fn growth() -> XyChart {
    let series = |name: &str, growth: &[f64]| {
        let lengths: Vec<f64> = (1..=growth.len()).map(|k| k as f64).collect();
        Series::new(name, lengths, growth).markers()
    };
    XyChart::new(
        "bracket length",
        Panel::new("dimension of the span")
            .series(series("one mode", &[3.0, 5.0, 7.0, 9.0, 9.0]))
            .series(series("all modes together", &[6.0, 10.0]))
            .series(series("smoothed friction", &[3.0, 6.0, 10.0]))
            .series(series("at rest", &[2.0, 5.0, 8.0, 10.0]))
            .named_target("all states", 10.0),
    )
    .title("Growth of the Lie algebra")
    .integer()
}

fn convergence() -> XyChart {
    let (x, y) = sample(0.5, 200_000, |mu| 2e-5 * (1.0 - (-9.0 * mu).exp()) + 3e-7 * (4e4 * mu).sin());
    XyChart::new("friction coefficient μ", Panel::new("end error [m]").series(Series::new("end error", x, y)))
}

fn gain() -> BarChart {
    BarChart::new("multi-step NRMSE", ["0.1 s", "0.5 s", "1.0 s"])
        .series("before", [0.021, 0.118, 0.31])
        .series("after", [0.008, 0.031, 0.062])
        .category_label("prediction horizon")
        .title("Prediction error on held-out data")
}

fn ranking() -> IntervalChart {
    IntervalChart::new("share of the excess error that the candidate explains [%]")
        .row("viscous_friction in v: −c·v", 93.1, Some((90.2, 95.4)), "named")
        .row("quadratic_drag in v: −c·v·|v|", 88.0, Some((81.0, 94.9)), "cannot be told apart")
        .row("tilt in v: g·sin(α)", 4.1, Some((-3.0, 9.5)), "tried")
        .row("input_delay of u", -1.0, None, "tried")
        .title("Candidates on held-out data")
}

/// `n` numbers from `low` to `high`.
fn spread(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|k| low + (high - low) * k as f64 / (n - 1) as f64).collect()
}

/// `f` at each place, row by row.
fn rows<T>(x: &[f64], y: &[f64], f: impl Fn(f64, f64) -> T) -> Vec<Vec<T>> {
    y.iter().map(|y| x.iter().map(|x| f(*x, *y)).collect()).collect()
}

fn time_to_target() -> HeatMap {
    let (mu, omega) = (spread(0.05, 0.6, 45), spread(1.0, 4.0, 31));
    let time = |mu: f64, omega: f64| {
        let t = 1.2 / (mu * (omega * omega / 9.0) * (0.75 - mu)).max(1e-3) * 0.25;
        if mu > 0.14 * omega || t > 15.0 { f64::NAN } else { t }
    };
    HeatMap::new("friction coefficient μ", "frequency ω/π [rad/s]", "time to target [s]")
        .title("Experiment 2: time to reach 98 % of the distance")
        .values(mu.clone(), omega.clone(), rows(&mu, &omega, time))
        .missing("not reached within 15 s")
        .range(0.0, 10.0)
        .contour("2.4 s", 2.4)
        .contour("5 s", 5.0)
        .mark("published", 0.3, 3.0)
        .mark("reference", 0.3, 4.0)
}

fn drift() -> HeatMap {
    let (mu, f) = (spread(0.05, 0.6, 23), spread(0.5, 3.5, 16));
    let y = |mu: f64, f: f64| 4e-5 * (40.0 * (mu - 0.3) * f - 5.0 * f);
    HeatMap::new("friction coefficient μ", "frequency [Hz]", "drift of y [m]")
        .values(mu.clone(), f.clone(), rows(&mu, &f, y))
        .color_map(ColorMap::Diverging)
        .contour("no drift", 0.0)
}

fn regimes() -> RegimeMap {
    let (mu, f) = (spread(0.05, 0.6, 12), spread(0.5, 3.5, 13));
    let regime = |mu: f64, f: f64| match mu / f {
        q if q > 0.35 => Some(0),
        q if q > 0.1 => Some(1),
        q if q > 0.03 => Some(2),
        _ => None,
    };
    RegimeMap::new("friction coefficient μ", "frequency [Hz]")
        .title("What the object does")
        .category("sticks", Color::band(2))
        .category("turns and stays", Color::SKY)
        .category("runs off the plate", Color::VERMILLION)
        .category("lifts off", Color::PURPLE)
        .cells(mu.clone(), f.clone(), rows(&mu, &f, regime))
        .missing("refused")
        .mark("published", 0.3, 2.0)
}

fn velocity_field() -> VectorField {
    let (phase, amplitude) = (spread(0.0, 2.0 * PI, 17), spread(0.0, 0.05, 11));
    let arrows = rows(&phase, &amplitude, |p, a| {
        let (s, c) = p.sin_cos();
        let u = if a > 0.041 && p < 1.0 { f64::NAN } else { 1.3 * a * c };
        Arrow::new((p, a), (u, 0.8 * a * s), 40.0 * a * (2.0 * p).sin())
    });
    VectorField::new("phase between X and θ [rad]", "amplitude of X [m]", "mean velocity (ẋ, ẏ)", "m/s")
        .title("Cycle-averaged velocity of a disk at x = 0.3 m, y = 0")
        .arrows(arrows.into_iter().flatten())
        .color_label("mean yaw rate [rad/s]")
        .missing("leaves the plate")
}

fn animation() -> Animation {
    let snapshot = |k: u32| {
        let t = 0.05 * f64::from(k);
        let wave = (4.0 * PI * t).sin();
        Snapshot {
            time: t,
            displacement: 0.05 * wave,
            tilt: -0.26 * wave,
            pose: Pose::new(0.3 + 0.02 * t + 0.004 * (4.0 * PI * t).cos(), 0.02 * wave, 0.3 * t),
            gap: 0.0,
            lean: 0.0,
            category: usize::from(wave.abs() < 0.4),
        }
    };
    Animation::new(Outline::Ellipse { a: 0.15, b: 0.1 }, 0.005)
        .title("Experiment 1: orientation")
        .category("slides", Color::ORANGE)
        .category("sticks", Color::GRAY)
        .target(Pose::new(0.3, 0.0, FRAC_PI_2))
        .snapshots((0..60).map(snapshot))
}
