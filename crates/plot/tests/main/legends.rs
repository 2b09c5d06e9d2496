//! What tells the parts of a figure apart: legends, marks, roles, and labels that do not lie over each other.

use bracketry_plot::{
    BarChart, Color, Dash, Drawing, Outline, Panel, PlanView, Pose, RecordedMotion, Role, Scene, Series, TileChart,
    TileGrid, TimeSeries, XyChart,
};

const ROLES: [Role; 5] = [Role::Given, Role::Refitted, Role::Extended, Role::Measured, Role::Promised];

fn line(name: &str) -> Series {
    Series::new(name, [0.0, 1.0, 2.0], [0.0, 1.0, 3.0])
}

/// A text of a drawing, in figure pixels.
struct Text {
    words: String,
    x: f64,
    y: f64,
    anchor: String,
    size: f64,
    upright: bool,
}

fn texts(drawing: &Drawing) -> Vec<Text> {
    let lines: Vec<&str> = drawing.svg().lines().collect();
    let texts = lines.windows(2).filter(|w| w[0].starts_with("<text"));
    texts
        .map(|w| {
            let of = |key: &str| w[0].split_once(&format!(" {key}=\"")).unwrap().1.split('"').next().unwrap();
            let pixels = |key: &str| of(key).parse::<f64>().unwrap() / 40.0;
            let upright = w[0].contains("rotate(270");
            let (words, anchor) = (w[1].trim().to_owned(), of("text-anchor").to_owned());
            Text { words, x: pixels("x"), y: pixels("y"), anchor, size: pixels("font-size"), upright }
        })
        .collect()
}

fn says(drawing: &Drawing, text: &str) -> usize {
    texts(drawing).iter().filter(|t| t.words == text).count()
}

/// Boxes of the texts, left, top, right, bottom: figures and capitals begin just below the place that the document names, and a
/// character of the font is hardly narrower than 0.52 em on average.
fn boxes(drawing: &Drawing) -> Vec<(String, [f64; 4])> {
    let boxed = texts(drawing).into_iter().map(|Text { words, x, y, anchor, size, upright }| {
        let length = 0.52 * size * words.chars().filter(|c| *c != '\u{307}' && *c != '\u{308}').count() as f64;
        let start = match anchor.as_str() {
            "middle" => -0.5 * length,
            "end" => -length,
            _ => 0.0,
        };
        let sides = if upright {
            [x + 0.03 * size, y - start - length, x + 0.76 * size, y - start]
        } else {
            [x + start, y + 0.03 * size, x + start + length, y + 0.76 * size]
        };
        (words, sides)
    });
    boxed.collect()
}

#[test]
fn every_named_series_is_in_the_legend_and_what_all_panels_share_is_there_once() {
    let panel = |label: &str| Panel::new(label).series(line("published")).series(line("extended").dash(Dash::Dashed));
    let drawing = TimeSeries::new().panel(panel("x [m]")).panel(panel("y [m]").target(1.0)).draw().unwrap();
    for name in ["published", "extended", "target"] {
        assert_eq!(says(&drawing, name), 1, "{name}");
    }
}

#[test]
fn a_look_that_means_different_things_in_two_panels_is_named_in_both() {
    // The first line of either panel is blue.
    let drawing = TimeSeries::new()
        .panel(Panel::new("force [N]").series(line("x")).series(line("y")))
        .panel(Panel::new("displacement [m]").series(line("x")).series(line("y")))
        .panel(Panel::new("angle [rad]").series(line("joint 1")))
        .draw()
        .unwrap();
    assert_eq!([says(&drawing, "x"), says(&drawing, "y"), says(&drawing, "joint 1")], [2, 1, 1]);
}

#[test]
fn roles_differ_in_color_and_the_models_in_their_lines_too() {
    for (k, a) in ROLES.iter().enumerate() {
        for b in &ROLES[k + 1..] {
            assert_ne!(a.color(), b.color(), "{a:?}, {b:?}");
        }
    }
    let models = [Role::Given, Role::Refitted, Role::Extended].map(Role::dash);
    assert!(models[0] != models[1] && models[1] != models[2] && models[0] != models[2]);
}

#[test]
fn an_end_before_its_time_has_a_cross_and_a_name() {
    let cross = |drawing: &Drawing| {
        // The stroke of a mark of 5 pixels over its white rim.
        let strokes = drawing.svg().lines().filter(|l| l.starts_with("<polyline") && l.contains("#262626"));
        strokes.filter(|l| l.contains("stroke-width=\"100\"")).count()
    };
    let series = TimeSeries::new().panel(Panel::new("x [m]").series(line("")));
    let ends = TimeSeries::new().panel(Panel::new("x [m]").series(line("").end("tips")));
    let [plain, marked] = [series, ends].map(|c| c.draw().unwrap());
    assert_eq!([says(&plain, "tips"), says(&marked, "tips")], [0, 1]);
    // Two strokes in the legend, two on the line.
    assert_eq!(cross(&marked) - cross(&plain), 4);

    let motion = RecordedMotion::new("", [0.0, 1.0], [0.0, 0.1], [0.0, 0.2], [0.0, 1.0]).end("tips");
    let scene = Scene::new("", Outline::Ellipse { a: 0.1, b: 0.1 }).target(Pose::new(0.2, 0.2, 0.0));
    let view = PlanView::new().scene(scene.trajectory(motion)).draw().unwrap();
    for name in ["start", "end", "target", "heading", "tips"] {
        assert_eq!(says(&view, name), 1, "{name}");
    }
    assert_eq!(cross(&view), 4);
}

#[test]
fn a_line_that_leaves_its_frame_says_where_it_ends() {
    let chart =
        |high: f64| XyChart::new("t [s]", Panel::new("φ [°]").series(line("")).limits(0.0, high)).draw().unwrap();
    assert_eq!(says(&chart(2.0), "off scale (ends at 3°)"), 1);
    assert_eq!(says(&chart(3.0), "off scale (ends at 3°)"), 0);
}

#[test]
fn rounding_gets_no_axis_and_a_factor_stands_before_the_unit() {
    let tiny = |panel: Panel| {
        let series = Series::new("", [0.0, 1.0], [0.0, 3e-18]);
        TimeSeries::new().panel(panel.series(series)).draw().unwrap()
    };
    assert_eq!(says(&tiny(Panel::new("y [mm]")), "y [10⁻¹⁸\u{a0}mm]"), 1);
    let flat = tiny(Panel::new("y [mm]").rounding(1e-9));
    assert_eq!([says(&flat, "y [mm]"), says(&flat, "−1.0")], [1, 1]);
}

#[test]
fn grids_of_tiles_have_columns_of_one_width() {
    let grid = |columns: usize| {
        let names: Vec<String> = (1..=columns).map(|k| format!("column {k}")).collect();
        TileGrid::new(names, ["a"]).tile(0, 0, "given", "f")
    };
    let drawing = TileChart::new().grid(grid(2)).grid(grid(6)).draw().unwrap();
    let places: Vec<f64> = texts(&drawing).iter().filter(|t| t.words == "column 2").map(|t| t.x).collect();
    assert_eq!(places.len(), 2);
    assert!((places[0] - places[1]).abs() < 1.0 / 40.0, "{places:?}");
}

#[test]
fn no_text_lies_over_another() {
    let named = |label: &str, factor: f64| {
        let series = ROLES.map(|role| {
            let y: Vec<f64> = (0..3).map(|k| factor * f64::from(k)).collect();
            Series::new(format!("{role:?} model"), [0.0, 1.0, 2.0], y).role(role)
        });
        series.into_iter().fold(Panel::new(label).target(0.0), Panel::series)
    };
    let disk = Outline::Ellipse { a: 0.1, b: 0.1 };
    let motion = |name: &str| RecordedMotion::new(name, [0.0, 1.0], [0.0, 0.1], [0.0, 0.2], [0.0, 1.0]).end("tips");
    let scene = |title: &str| Scene::new(title, disk.clone()).trajectory(motion("model")).trajectory(motion("log"));
    let flat = TimeSeries::new().panel(Panel::new("a [m]").series(Series::new("", [0.0, 1.0], [0.0, 0.0])));
    let drawings = [
        TimeSeries::new().title("Models").panel(named("x [m]", 1e-6)).panel(named("y [m]", 1.0)).draw(),
        flat.panel(Panel::new("b [m]").series(Series::new("", [0.0, 1.0], [0.0, 0.0]))).draw(),
        BarChart::new("share [%]", ["0.1 s", "0.5 s", "1 s"])
            .series("as given", [64.2, 190.0, 416.0])
            .series("extended", [5.6, 11.3, 16.8])
            .category_label("horizon")
            .draw(),
        PlanView::new().title("Views").scene(scene("Closed loop")).scene(scene("Plan alone")).draw(),
        TileChart::new()
            .title("Directions")
            .category("given", Color::band(0))
            .grid(
                TileGrid::new(["1", "2"], ["2", "1"]).title("one mode").tile(0, 1, "given", "f").row_label("dimension"),
            )
            .draw(),
    ];
    for (k, drawing) in drawings.into_iter().enumerate() {
        let boxes = boxes(&drawing.unwrap());
        assert!(boxes.len() > 4, "figure {k}");
        for (i, (a, p)) in boxes.iter().enumerate() {
            for (b, q) in &boxes[i + 1..] {
                let apart = p[2] <= q[0] || q[2] <= p[0] || p[3] <= q[1] || q[3] <= p[1];
                assert!(apart, "figure {k}: `{a}` at {p:?} and `{b}` at {q:?}");
            }
        }
    }
}
