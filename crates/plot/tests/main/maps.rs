//! What a reader finds in maps and vector fields, and what happens with awkward data.

use bracketry_plot::{Arrow, Color, ColorMap, Drawing, HeatMap, PlotError, RegimeMap, VectorField};

fn hex(c: Color) -> String {
    format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2)
}

/// The rectangles of a color as `[x, y, width, height]` in figure pixels.
fn rectangles(drawing: &Drawing, color: &str) -> Vec<[f64; 4]> {
    let number = |line: &str, key: &str| -> f64 {
        line.split_once(&format!(" {key}=\"")).unwrap().1.split('"').next().unwrap().parse::<f64>().unwrap() / 40.0
    };
    let lines = drawing.svg().lines().filter(|l| l.starts_with("<rect") && l.contains(&format!("fill=\"{color}\"")));
    lines.map(|l| ["x", "y", "width", "height"].map(|key| number(l, key))).collect()
}

#[test]
fn cells_reach_half_way_to_their_neighbors_with_the_first_row_at_the_bottom() {
    let rows = [vec![Some(0), Some(1), Some(1)], vec![Some(1), Some(1), Some(1)]];
    let map = RegimeMap::new("x", "y").category("sticks", Color::BLUE).category("slides", Color::ORANGE);
    let drawing = map.cells([0.0, 1.0, 3.0], [0.0, 1.0], rows).draw().unwrap();
    // The columns' borders are at −0.5, 0.5, 2, 4: the first column has 1 of 4.5.
    let cell = rectangles(&drawing, "#0072B2").into_iter().max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
    let upper = rectangles(&drawing, "#DE9400").into_iter().max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
    assert!((cell[2] - upper[2] / 4.5).abs() < 0.6, "{cell:?} {upper:?}");
    assert!((cell[3] - 200.0).abs() < 0.6 && (cell[1] - upper[1] - 200.0).abs() < 0.6);
    assert!((cell[0] - upper[0]).abs() < 0.1);
}

#[test]
fn values_have_the_colors_of_the_bar_and_gaps_are_hatched_and_explained() {
    let rows = vec![vec![0.0, 2.0], vec![f64::NAN, 4.0]];
    let map = HeatMap::new("μ [1]", "f [Hz]", "time [s]").values([0.1, 0.2], [1.0, 2.0], rows).missing("not reached");
    let drawing = map.draw().unwrap();
    for s in [0.0, 0.5, 1.0] {
        let color = hex(ColorMap::Sequential.color(s));
        let wide = rectangles(&drawing, &color).into_iter().filter(|r| r[2] > 200.0).count();
        assert_eq!(wide, 1, "{s}");
    }
    assert_eq!(rectangles(&drawing, "#E8E8E8").iter().filter(|r| r[2] > 200.0).count(), 1);
    for text in ["μ [1]", "f [Hz]", "time [s]", "not reached"] {
        assert!(drawing.svg().contains(text), "{text}");
    }
    let whole = HeatMap::new("x", "y", "z").values([0.0, 1.0], [0.0], [vec![1.0, 2.0]]).missing("gap").draw().unwrap();
    assert!(!whole.svg().contains("gap"));
}

#[test]
fn a_set_range_says_what_lies_beyond() {
    let map = HeatMap::new("x", "y", "z").values([0.0, 1.0, 2.0], [0.0], [vec![-1.0, 0.5, 7.0]]);
    let drawing = map.clone().range(0.0, 1.0).draw().unwrap();
    assert!(drawing.svg().contains("≥ 1.0") && drawing.svg().contains("≤ 0.0"));
    assert!(!map.draw().unwrap().svg().contains('≥'));
}

#[test]
fn a_diverging_map_is_white_at_zero() {
    let values = [vec![-1.0, 0.0, 4.0]];
    let map = HeatMap::new("x", "y", "z").values([0.0, 1.0, 2.0], [0.0], values).color_map(ColorMap::Diverging);
    let drawing = map.draw().unwrap();
    let middle = hex(ColorMap::Diverging.color(0.5));
    assert_eq!(rectangles(&drawing, &middle).iter().filter(|r| r[2] > 150.0).count(), 1);
}

#[test]
fn a_contour_runs_where_the_value_is_that_of_its_level() {
    let x: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.1).collect();
    let rows = vec![x.clone(); 11];
    let map = HeatMap::new("x", "y", "z").values(x.clone(), x, rows).contour("a quarter", 0.25);
    let drawing = map.draw().unwrap();
    assert!(drawing.svg().contains("a quarter"));
    // Of the lines of the contour's width the longest is the contour itself: upright, at 0.3/1.1 of the frame.
    let lines = drawing.svg().lines().filter(|l| l.starts_with("<polyline") && l.contains("stroke-width=\"70\""));
    let points = |l: &str| -> Vec<(f64, f64)> {
        let text = l.split_once("points=\"").unwrap().1.split('"').next().unwrap();
        text.split_whitespace()
            .filter_map(|p| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())))
            .collect()
    };
    let longest = lines.map(points).max_by_key(Vec::len).unwrap();
    assert_eq!(longest.len(), 11);
    assert!(longest.iter().all(|p| (p.0 - longest[0].0).abs() <= 1.0));
}

#[test]
fn arrows_point_along_their_components_and_are_measured_by_the_reference() {
    let arrows = [Arrow::new((0.0, 0.0), (3.0, 0.0), 0.0), Arrow::new((0.0, 1.0), (0.0, -1.5), 0.0)];
    let drawing = VectorField::new("x", "y", "velocity", "m/s").arrows(arrows).draw().unwrap();
    assert!(drawing.svg().contains("velocity 2 m/s"));
    let shafts: Vec<Vec<f64>> = drawing
        .svg()
        .lines()
        .filter(|l| l.starts_with("<polyline") && l.contains("stroke=\"#0072B2\""))
        .map(|l| {
            let text = l.split_once("points=\"").unwrap().1.split('"').next().unwrap();
            text.split([' ', ',']).filter(|p| !p.is_empty()).map(|v| v.parse().unwrap()).collect()
        })
        .collect();
    let (right, down) = (&shafts[0], &shafts[1]);
    assert!(right[2] > right[0] && right[3] == right[1]);
    assert!(down[3] > down[1] && down[2] == down[0]);
    // Shaft and head of 8 pixels together are twice as long for twice the vector.
    let length = |s: &[f64]| (s[2] - s[0]).hypot(s[3] - s[1]) / 40.0 + 8.0;
    assert!((length(right) / length(down) - 2.0).abs() < 0.01);
}

#[test]
fn maps_that_cannot_be_drawn_name_the_reason() {
    let map = || HeatMap::new("x", "y", "z");
    assert!(matches!(map().draw(), Err(PlotError::NoContent { .. })));
    let unordered = map().values([0.0, 2.0, 1.0], [0.0], [vec![0.0; 3]]).draw();
    assert!(matches!(unordered, Err(PlotError::Unordered { axis, index: 2, .. }) if axis == "x"));
    let short = map().values([0.0, 1.0], [0.0, 1.0], [vec![0.0; 2], vec![0.0]]).draw();
    assert!(matches!(short, Err(PlotError::LengthMismatch { expected: 2, found: 1, .. })));
    let infinite = map().values([0.0], [0.0], [vec![f64::INFINITY]]).draw();
    assert!(matches!(infinite, Err(PlotError::NotFinite { .. })));
    let unknown = RegimeMap::new("x", "y").category("a", Color::BLUE).cells([0.0], [0.0], [vec![Some(1)]]).draw();
    assert!(matches!(unknown, Err(PlotError::UnknownCategory { category: 1, known: 1 })));
    assert!(matches!(VectorField::new("x", "y", "v", "m").draw(), Err(PlotError::NoContent { .. })));
    let nowhere = VectorField::new("x", "y", "v", "m").arrows([Arrow::new((f64::NAN, 0.0), (1.0, 0.0), 0.0)]).draw();
    assert!(matches!(nowhere, Err(PlotError::NotFinite { .. })));
}

#[test]
fn awkward_maps_still_give_a_figure() {
    let one = |v: f64| HeatMap::new("x", "y", "z").values([3.0], [0.0], [vec![v]]);
    let long = "a very long name that goes on and on ".repeat(20);
    let figures = [
        one(1.0).draw(),
        one(f64::NAN).draw(),
        one(1e-200).title(&long).missing(&long).draw(),
        one(1e299).range(2.0, 2.0).contour(&long, 1.0).mark(&long, 3.0, 0.0).draw(),
        one(f64::NAN).color_map(ColorMap::Diverging).draw(),
        HeatMap::new(&long, &long, &long).values([0.0, 1e-9], [-1e9, 1e9], [vec![1e-7, 2e-7], vec![0.0, 5e-7]]).draw(),
        VectorField::new("x", "y", "v", "m").arrows([Arrow::new((0.0, 0.0), (0.0, 0.0), 0.0)]).draw(),
        VectorField::new("x", "y", "v", "m")
            .arrows([Arrow::new((0.0, 0.0), (f64::NAN, 0.0), 0.0)])
            .color_label(&long)
            .draw(),
        VectorField::new("x", "y", "v", "m").arrows([Arrow::new((0.0, 0.0), (1e-9, 2e300), 0.0)]).longest(1.0).draw(),
    ];
    for (k, figure) in figures.into_iter().enumerate() {
        match figure {
            Ok(drawing) => {
                assert!(!drawing.svg().contains("NaN") && drawing.size().1 < 1500, "figure {k}");
                assert!(drawing.png().is_ok(), "figure {k}");
            }
            Err(e) => assert!(matches!(e, PlotError::NotFinite { .. }) && k == 8, "figure {k}: {e}"),
        }
    }
}
