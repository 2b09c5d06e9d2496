//! What a reader finds in the figures, and what happens with awkward data.

use std::f64::consts::FRAC_PI_2;

use bracketry_plot::{
    BarChart, Color, Dash, Drawing, Interval, IntervalChart, Outline, Panel, PlanView, PlotError, Pose, RecordedMotion,
    Scene, Series, TileChart, TileGrid, TimeSeries, XyChart,
};
use resvg::tiny_skia::Pixmap;

fn one_line(series: Series) -> TimeSeries {
    TimeSeries::new().panel(Panel::new("x [m]").series(series))
}

fn pixels(drawing: &Drawing) -> Pixmap {
    Pixmap::decode_png(&drawing.png().unwrap()).unwrap()
}

/// The values of all `attribute="…"` of lines that start with `tag`.
fn attributes<'a>(drawing: &'a Drawing, tag: &str, attribute: &str) -> Vec<&'a str> {
    let key = format!(" {attribute}=\"");
    let tagged = drawing.svg().lines().filter(|l| l.starts_with(&format!("<{tag} ")));
    tagged.filter_map(|l| l.split_once(&key)?.1.split('"').next()).collect()
}

/// Every polyline of a color, in back-end units.
fn polylines(drawing: &Drawing, color: &str) -> Vec<Vec<(f64, f64)>> {
    let of_color = format!("stroke=\"{color}\"");
    let lines = drawing.svg().lines().filter(|l| l.starts_with("<polyline") && l.contains(&of_color));
    lines
        .map(|l| {
            let points = l.split_once("points=\"").unwrap().1.split('"').next().unwrap();
            let point = |p: &str| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()));
            points.split_whitespace().filter_map(point).collect()
        })
        .collect()
}

const BLUE: &str = "#0072B2";

#[test]
fn names_units_and_categories_are_in_the_svg() {
    let t = vec![0.0, 1.0, 2.0];
    let drawing = TimeSeries::new()
        .title("Closed loop & <exact> plant")
        .panel(Panel::new("θ̇ [rad/s]").series(Series::new("plate", t.clone(), vec![0.0, 1.0, 0.5])).target(0.5))
        .panel(Panel::new("Ẍ [m/s²]").series(Series::new("Ẍ", t, vec![0.0, 1.0, 0.5]).step()).bound(1.5))
        .interval(Interval::new(0.0, 0.7, "slides +x"))
        .interval(Interval::new(0.7, 2.0, "sticks in x"))
        .draw()
        .unwrap();
    for text in ["θ̇ [rad/s]", "Ẍ [m/s²]", "plate", "target", "bound", "slides +x", "sticks in x", "time [s]"] {
        assert!(drawing.svg().contains(text), "{text} is missing");
    }
    assert!(drawing.svg().contains("Closed loop &amp; &lt;exact&gt; plant"));
    // Each name once, although two panels share the bands.
    assert_eq!(drawing.svg().matches("slides +x").count(), 1);
}

#[test]
fn png_has_twice_the_pixels_and_shows_the_colors() {
    let drawing = one_line(Series::new("x", [0.0, 1.0], [0.0, 1.0])).draw().unwrap();
    let image = pixels(&drawing);
    let (width, height) = drawing.size();
    assert_eq!((image.width(), image.height()), (1600, 2 * height));
    assert_eq!(width, 800);
    let count = |r, g, b| {
        let same = |p: &&resvg::tiny_skia::PremultipliedColorU8| (p.red(), p.green(), p.blue()) == (r, g, b);
        image.pixels().iter().filter(same).count()
    };
    // A line of 3.5 device pixels across the panel, and dark text.
    assert!(count(0, 114, 178) > 2000);
    assert!(count(38, 38, 38) > 1000);
    assert!(count(255, 255, 255) > image.pixels().len() / 2);
}

#[test]
fn text_is_drawn_with_the_embedded_font() {
    let ink = |label: &str| {
        let chart = XyChart::new(label, Panel::new("")).draw().unwrap();
        pixels(&chart).pixels().iter().filter(|p| p.red() < 128).count()
    };
    let nothing = ink("");
    // A character that the font lacks leaves nothing or a box.
    let missing = ink("\u{4e2d}");
    for label in ["θ", "μ", "°", "φ", "ẍ", "Σ", "∞", "→", "−", "≤", "x₁", "m²"] {
        let drawn = ink(label);
        assert!(drawn > nothing && drawn != missing, "{label} is missing");
    }
    // The combining dot adds to the letter.
    assert!(ink("θ\u{307}") > ink("θ"));
}

#[test]
fn long_lines_stay_small_and_keep_their_extremes() {
    let n = 200_000;
    let t: Vec<f64> = (0..n).map(|k| k as f64 * 1e-4).collect();
    let mut y: Vec<f64> = t.iter().map(|t| (300.0 * t).sin()).collect();
    y[123_457] = 9.0;
    y[23_457] = -7.0;
    let figure = one_line(Series::new("", t, y));
    let drawing = figure.draw().unwrap();
    assert!(drawing.svg().len() < 150_000, "{} bytes", drawing.svg().len());
    let line = &polylines(&drawing, BLUE)[0];
    let top = line.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let bottom = line.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    // 120 pixels of 40 units show 16 + 2 · 7 % of 16 data units.
    let expected = 120.0 * 40.0 * 16.0 / (16.0 * 1.14);
    assert!((bottom - top - expected).abs() < 2.0, "{} instead of {expected}", bottom - top);
}

#[test]
fn a_step_line_holds_each_value() {
    let drawing = one_line(Series::new("", [0.0, 1.0, 2.0], [0.0, 1.0, 3.0]).step()).draw().unwrap();
    let line = &polylines(&drawing, BLUE)[0];
    assert_eq!(line.len(), 5);
    assert!(line.windows(2).all(|w| w[0].0 == w[1].0 || w[0].1 == w[1].1));
    // Higher values are higher on the page, and the last one starts at the right border.
    assert!(line[4].1 < line[2].1 && line[2].1 < line[0].1);
    assert_eq!(line[4].0, line[3].0);
}

#[test]
fn limits_cut_the_line_at_the_frame() {
    let series = Series::new("", [0.0, 1.0, 2.0], [0.0, 100.0, 0.0]);
    let figure = TimeSeries::new().panel(Panel::new("x").series(series).limits(-1.0, 1.0));
    let drawing = figure.draw().unwrap();
    let parts = polylines(&drawing, BLUE);
    assert_eq!(parts.len(), 2);
    assert_eq!(parts[0].last().unwrap().1, parts[1][0].1);
}

#[test]
fn values_that_cannot_be_drawn_are_named() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e301] {
        let error = one_line(Series::new("tilt", [0.0, 1.0, 2.0], [0.0, 1.0, bad])).draw().unwrap_err();
        assert!(matches!(&error, PlotError::NotFinite { series, index: 2, .. } if series == "tilt"), "{error}");
        assert!(error.to_string().contains("`tilt`") && error.to_string().contains("index 2"));
    }
    let time = one_line(Series::new("tilt", [0.0, f64::NAN], [0.0, 1.0])).draw();
    assert!(matches!(time, Err(PlotError::NotFinite { index: 1, .. })));
    let target = TimeSeries::new().panel(Panel::new("x").target(f64::NAN)).draw();
    assert!(matches!(target, Err(PlotError::NotFinite { .. })));
    let shape = Scene::new("", Outline::Ellipse { a: f64::NAN, b: 1.0 });
    assert!(matches!(PlanView::new().scene(shape).draw(), Err(PlotError::NotFinite { .. })));
    let bar = BarChart::new("", ["a"]).series("s", [f64::NAN]).draw();
    assert!(matches!(bar, Err(PlotError::NotFinite { index: 0, .. })));
    let estimate = IntervalChart::new("").row("a", f64::INFINITY, None, "").draw();
    assert!(matches!(estimate, Err(PlotError::NotFinite { .. })));
}

#[test]
fn mismatched_and_reversed_data_are_refused() {
    let short = one_line(Series::new("v", [0.0, 1.0], [0.0])).draw();
    assert!(matches!(short, Err(PlotError::LengthMismatch { expected: 2, found: 1, .. })));
    let pose = RecordedMotion::new("m", [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0]);
    let scene = Scene::new("", Outline::Polygon(vec![])).trajectory(pose);
    assert!(matches!(PlanView::new().scene(scene).draw(), Err(PlotError::LengthMismatch { found: 1, .. })));
    let bars = BarChart::new("", ["a", "b"]).series("s", [1.0]).draw();
    assert!(matches!(bars, Err(PlotError::LengthMismatch { expected: 2, found: 1, .. })));
    let reversed = TimeSeries::new().panel(Panel::new("x")).interval(Interval::new(1.0, 0.5, "sticks")).draw();
    assert!(matches!(reversed, Err(PlotError::ReversedInterval { name, .. }) if name == "sticks"));
    let exchanged = IntervalChart::new("").row("c", 0.5, Some((0.6, 0.4)), "").draw();
    assert!(matches!(exchanged, Err(PlotError::ReversedInterval { name, .. }) if name == "c"));
    assert!(matches!(TimeSeries::new().draw(), Err(PlotError::NoContent { missing: "panel" })));
    assert!(matches!(IntervalChart::new("").draw(), Err(PlotError::NoContent { missing: "row" })));
    assert!(matches!(PlanView::new().draw(), Err(PlotError::NoContent { .. })));
    let none: [&str; 0] = [];
    assert!(matches!(BarChart::new("", none).draw(), Err(PlotError::NoContent { .. })));
}

#[test]
fn awkward_data_still_give_a_figure() {
    let long = "a very long name that goes on and on ".repeat(40);
    let many = (0..60).fold(Panel::new("many"), |p, k| p.series(Series::new(format!("series {k}"), [0.0], [1.0])));
    let figures = [
        one_line(Series::new("empty", [], [])).draw(),
        one_line(Series::new("point", [1.0], [2.0])).draw(),
        one_line(Series::new("point", [1.0], [2.0]).step()).draw(),
        one_line(Series::new("constant", [0.0, 1.0], [3.0, 3.0])).draw(),
        one_line(Series::new("zero", [0.0, 1.0], [0.0, -0.0])).draw(),
        one_line(Series::new("subnormal", [0.0, 1.0], [0.0, 5e-324])).draw(),
        one_line(Series::new("huge", [-1e300, 1e300], [-1e300, 1e300])).draw(),
        one_line(Series::new("narrow", [0.0, 1.0], [1e9, 1e9 + 1e-6])).draw(),
        one_line(Series::new("back and forth", [0.0, 1.0, 0.5], [0.0, 1.0, 0.5]).dash(Dash::DashDot)).draw(),
        TimeSeries::new().title(&long).panel(Panel::new(&long).series(Series::new(&long, [0.0], [1.0]))).draw(),
        TimeSeries::new().panel(many).draw(),
        TimeSeries::new().panel(Panel::new("x").limits(1.0, 1.0).height(-5.0)).draw(),
        XyChart::new(&long, Panel::new("y")).integer().draw(),
        BarChart::new("v", [long.as_str(), "b"]).series(&long, [1.0, -2e9]).draw(),
        BarChart::new("v", ["a"]).series("zero", [0.0]).draw(),
        BarChart::new("v", ["a"]).draw(),
        PlanView::new().scene(Scene::new(&long, Outline::Polygon(vec![]))).draw(),
        PlanView::new()
            .scene(Scene::new("", Outline::Ellipse { a: 0.0, b: 0.0 }).target(Pose::new(1.0, 1.0, 0.0)))
            .draw(),
        PlanView::new()
            .stamps(0)
            .scene(
                Scene::new("", Outline::Polygon(vec![(1.0, 1.0)]))
                    .trajectory(RecordedMotion::new("", [1.0], [0.0], [0.0], [1e17]))
                    .trajectory(RecordedMotion::new("none", [], [], [], [])),
            )
            .draw(),
    ];
    for (k, figure) in figures.into_iter().enumerate() {
        let drawing = figure.unwrap_or_else(|e| panic!("figure {k}: {e}"));
        assert!(drawing.size().1 < 1500, "figure {k} is {} pixels high", drawing.size().1);
        assert!(!drawing.svg().contains("NaN"), "figure {k}");
        let image = pixels(&drawing);
        assert!(image.pixels().iter().any(|p| p.red() < 100), "figure {k} is blank");
    }
}

#[test]
fn tick_labels_of_the_time_axis_do_not_touch() {
    let start = 123_456.0;
    let t: Vec<f64> = (0..100).map(|k| start + 1e-5 * f64::from(k)).collect();
    let drawing = one_line(Series::new("", t.clone(), t)).draw().unwrap();
    let lines: Vec<&str> = drawing.svg().lines().collect();
    let labels = lines.windows(2).filter(|w| w[0].contains("\"middle\"") && w[1].starts_with("123"));
    let centers: Vec<(f64, usize)> = labels
        .map(|w| {
            let x = w[0].split_once(" x=\"").unwrap().1.split('"').next().unwrap();
            (x.parse::<f64>().unwrap() / 40.0, w[1].chars().count())
        })
        .collect();
    assert!(centers.len() >= 2);
    // A digit of the font is 0.636 em wide.
    assert!(centers.windows(2).all(|w| w[1].0 - w[0].0 > 0.6 * 15.0 * w[0].1 as f64), "{centers:?}");
}

#[test]
fn chattering_modes_stay_small() {
    let modes = ["slides +x", "slides −x"];
    let bands = (0..40_000).map(|k| Interval::new(k as f64 * 1e-4, (k + 1) as f64 * 1e-4, modes[k % 2]));
    let figure = bands.fold(TimeSeries::new().panel(Panel::new("x")), TimeSeries::interval);
    let drawing = figure.draw().unwrap();
    assert!(drawing.svg().len() < 500_000, "{} bytes", drawing.svg().len());
}

#[test]
fn plan_views_keep_circles_round() {
    let circle = Outline::Ellipse { a: 0.1, b: 0.1 };
    let motion = RecordedMotion::new("m", [0.0, 1.0], [0.0, 3.0], [0.0, 0.2], [0.0, FRAC_PI_2]);
    let drawing = PlanView::new().scene(Scene::new("wide", circle).trajectory(motion)).draw().unwrap();
    // The start outline is the dotted gray line.
    let outline = &polylines(&drawing, "#6E6E6E").into_iter().max_by_key(Vec::len).unwrap();
    let extent = |axis: fn(&(f64, f64)) -> f64| {
        let values = || outline.iter().map(axis);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    assert!((extent(|p| p.0) - extent(|p| p.1)).abs() <= 2.0);
    assert!(extent(|p| p.0) > 400.0);
}

#[test]
fn y_points_up_and_positive_turns_are_counterclockwise() {
    let motion = RecordedMotion::new("m", [0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, FRAC_PI_2]);
    let scene = Scene::new("", Outline::Ellipse { a: 0.2, b: 0.1 }).trajectory(motion);
    let drawing = PlanView::new().stamps(1).scene(scene).draw().unwrap();
    let (x, y) = (attributes(&drawing, "circle", "cx"), attributes(&drawing, "circle", "cy"));
    let at = |k: usize| (x[k].parse::<f64>().unwrap(), y[k].parse::<f64>().unwrap());
    // Disks in drawing order: legend, tip of the last pose, two path marks, tip of the first pose.
    let (end, center, start) = (at(1), at(2), at(4));
    assert!(start.0 > center.0 + 100.0 && (start.1 - center.1).abs() <= 1.0);
    assert!(end.1 < center.1 - 100.0 && (end.0 - center.0).abs() <= 1.0);
}

#[test]
fn files_are_written_and_failures_name_the_path() {
    let folder = std::env::temp_dir().join(format!("bracketry-plot-{}", std::process::id()));
    let drawing = one_line(Series::new("x", [0.0, 1.0], [0.0, 1.0])).draw().unwrap();
    let saved = drawing.save(folder.join("new/run.1")).unwrap();
    assert!(saved.svg.ends_with("run.1.svg") && saved.png.ends_with("run.1.png"));
    assert_eq!(std::fs::read_to_string(&saved.svg).unwrap(), drawing.svg());
    assert_eq!(std::fs::read(&saved.png).unwrap(), drawing.png().unwrap());
    // A file stands where a folder would have to be.
    let error = drawing.save(saved.svg.join("figure")).unwrap_err();
    assert!(matches!(&error, PlotError::Write { .. }) && error.to_string().contains("run.1.svg"), "{error}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn tiles_stand_in_their_cells_with_labels_that_fit() {
    let grid = |label: &str| TileGrid::new(["1", "2"], ["b", "a"]).tile(1, 0, "given", label).row_label("dimension");
    let drawing = TileChart::new().category("given", Color::BLUE).grid(grid("[f,g]")).draw().unwrap();
    assert!(drawing.svg().contains("[f,g]") && drawing.svg().contains("given") && drawing.svg().contains("dimension"));
    // Two columns of 190 pixels at most: the only blue tile lies in the right one, in the upper row.
    let blue: Vec<f64> = drawing
        .svg()
        .lines()
        .filter(|l| l.starts_with("<rect") && l.contains(BLUE))
        .map(|l| l.split_once(" width=\"").unwrap().1.split('"').next().unwrap().parse::<f64>().unwrap() / 40.0)
        .filter(|w| *w > 100.0)
        .collect();
    assert_eq!(blue, [188.0]);
    // A name too long for its tile is cut and says so.
    let long = TileChart::new().grid(grid(&"[f,".repeat(60))).draw().unwrap();
    assert!(long.svg().contains('…'));
    assert!(long.png().is_ok());
}

#[test]
fn a_tile_outside_its_grid_or_an_empty_grid_is_refused() {
    let grid = TileGrid::new(["1"], ["a"]).tile(0, 1, "given", "");
    assert!(matches!(TileChart::new().grid(grid).draw(), Err(PlotError::OutsideGrid { column: 0, row: 1 })));
    let empty = TileGrid::new(Vec::<String>::new(), ["a"]);
    assert!(matches!(TileChart::new().grid(empty).draw(), Err(PlotError::NoContent { .. })));
    assert!(matches!(TileChart::new().draw(), Err(PlotError::NoContent { missing: "grid" })));
}

#[test]
fn a_cloud_of_points_has_all_its_markers_in_any_order_and_no_line() {
    // Disks in the same column of pixels, out of order: a line through them would be thinned.
    let x: Vec<f64> = (0..40).map(|k| f64::from(k % 2)).collect();
    let y: Vec<f64> = (0..40).map(|k| f64::from(k * 7 % 40)).collect();
    let count = |series: Series| {
        let drawing = one_line(series).draw().unwrap();
        (drawing.svg().matches("<circle").count(), drawing.svg().matches(BLUE).count())
    };
    // One more in the legend.
    assert_eq!(count(Series::new("x", x.clone(), y.clone()).points()), (41, 41));
    let (disks, blue) = count(Series::new("x", x, y).markers());
    assert!(blue > disks, "a line is blue as well");
}

#[test]
fn known_categories_keep_their_color_whatever_the_rows_are() {
    let colors = |known: &[&str]| {
        let chart = IntervalChart::new("").categories(known.iter().copied()).row("x", 0.5, Some((0.4, 0.6)), "b");
        let drawing = chart.draw().unwrap();
        let says = |text: &str| drawing.svg().lines().any(|l| l.trim() == text);
        assert!(says("b") && !says("a"), "the legend shows what is there");
        attributes(&drawing, "polyline", "stroke").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(colors(&["b"]), colors(&[]));
    assert_eq!(colors(&["a", "b"]), colors(&["a", "b", "c"]));
    assert_ne!(colors(&["a", "b"]), colors(&[]));
}

#[test]
fn places_on_the_horizontal_axis_take_the_labels_given() {
    let panel = || Panel::new("y").series(Series::new("a", [1.0, 3.0], [0.0, 1.0]));
    let ticks = [(1.0, "ten"), (2.0, "hundred"), (9.0, "outside"), (f64::NAN, "nowhere")];
    let drawing = XyChart::new("x", panel()).x_ticks(ticks).draw().unwrap();
    for (label, shown) in [("ten", true), ("hundred", true), ("outside", false), ("nowhere", false), ("2.6", false)] {
        assert_eq!(drawing.svg().contains(label), shown, "{label}");
    }
    assert!(XyChart::new("x", panel()).draw().unwrap().svg().contains("2.6"));
}
