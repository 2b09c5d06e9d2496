//! What an animation shows, and what happens with awkward data.

use bracketry_plot::{Animation, Color, Outline, PlotError, Pose, Snapshot};

fn at(time: f64, displacement: f64, tilt: f64, pose: Pose) -> Snapshot {
    Snapshot { time, displacement, tilt, pose, gap: 0.0, lean: 0.0, category: 0 }
}

fn disk() -> Animation {
    Animation::new(Outline::Ellipse { a: 0.1, b: 0.1 }, 0.005).category("slides", Color::BLUE)
}

/// Centers of the circles of an image that are of the text's color, in figure pixels: tip of the heading, center of
/// the object, axis of rotation.
fn dots(animation: &Animation, index: usize) -> Vec<(f64, f64)> {
    let image = animation.image(index).unwrap();
    let number = |line: &str, key: &str| -> f64 {
        line.split_once(&format!(" {key}=\"")).unwrap().1.split('"').next().unwrap().parse::<f64>().unwrap() / 40.0
    };
    let lines = image.svg().lines().filter(|l| l.starts_with("<circle"));
    // The first is the sample of the legend.
    lines.skip(1).map(|l| (number(l, "cx"), number(l, "cy"))).collect()
}

#[test]
fn the_object_moves_with_the_plate_and_turns_counterclockwise() {
    let still = at(0.0, 0.0, 0.0, Pose::new(0.3, 0.0, 0.0));
    let carried = at(0.1, 0.05, 0.0, Pose::new(0.3, 0.0, 0.0));
    let turned = at(0.2, 0.0, 0.0, Pose::new(0.3, 0.0, std::f64::consts::FRAC_PI_2));
    let animation = disk().snapshots([still, carried, turned]);
    let [first, second, third] = [0, 1, 2].map(|k| dots(&animation, k));
    assert!(second[1].0 > first[1].0 + 10.0 && second[1].1 == first[1].1);
    // Half the radius of shaking is half the length of the heading.
    assert!((second[1].0 - first[1].0 - 0.5 * (first[0].0 - first[1].0)).abs() < 0.1);
    assert!(first[0].0 > first[1].0 && (first[0].1 - first[1].1).abs() < 0.1);
    assert!(third[0].1 < third[1].1 - 10.0 && (third[0].0 - third[1].0).abs() < 0.1);
}

#[test]
fn positive_tilt_raises_positive_y() {
    let animation = disk().snapshots([at(0.0, 0.0, 0.2, Pose::new(0.0, 0.1, 0.0))]);
    let image = animation.image(0).unwrap();
    // The plate in the view from the side: the only line of its width in the text's color.
    let line = image.svg().lines().find(|l| l.contains("stroke-width=\"80\"") && l.contains("#262626")).unwrap();
    let points: Vec<f64> = line
        .split_once("points=\"")
        .unwrap()
        .1
        .split('"')
        .next()
        .unwrap()
        .split([' ', ','])
        .filter_map(|v| v.parse().ok())
        .collect();
    let slope = (points[1] - points[3]) / (points[2] - points[0]);
    assert!((slope - 0.2f64.tan()).abs() < 1e-2, "{points:?}");
    assert!(image.svg().contains("θ = 11.5°"));
}

#[test]
fn the_gif_lasts_as_long_as_the_motion_and_stays_at_its_end() {
    let snapshots = (0..7).map(|k| at(0.05 * f64::from(k), 0.0, 0.0, Pose::new(0.0, 0.0, 0.1 * f64::from(k))));
    let bytes = disk().snapshots(snapshots).gif().unwrap();
    let mut decoder = gif::DecodeOptions::new().read_info(bytes.as_slice()).unwrap();
    assert_eq!((decoder.width(), decoder.repeat()), (800, gif::Repeat::Infinite));
    let (mut images, mut hundredths) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        images += 1;
        hundredths += frame.delay;
    }
    assert_eq!((images, hundredths), (7, 35 + 150));
}

#[test]
fn what_happens_at_the_end_is_said_there_only() {
    let still = |time: f64| at(time, 0.0, 0.0, Pose::new(0.0, 0.0, 0.0));
    let animation = disk().snapshots([still(0.0), still(0.1)]).end("the object tips");
    let says = |index: usize| animation.image(index).unwrap().svg().contains("s: the object tips");
    assert!(!says(0) && says(1));
}

#[test]
fn motions_that_cannot_be_shown_name_the_reason() {
    assert!(matches!(disk().gif(), Err(PlotError::NoContent { missing: "snapshot" })));
    let here = Pose::new(0.0, 0.0, 0.0);
    let unordered = disk().snapshots([at(0.1, 0.0, 0.0, here), at(0.1, 0.0, 0.0, here)]).gif();
    assert!(matches!(unordered, Err(PlotError::Unordered { index: 1, .. })));
    let nan = disk().snapshots([at(0.0, f64::NAN, 0.0, here)]).image(0);
    assert!(matches!(nan, Err(PlotError::NotFinite { .. })));
    let unknown = Animation::new(Outline::Polygon(vec![]), 0.0).snapshots([at(0.0, 0.0, 0.0, here)]).image(0);
    assert!(matches!(unknown, Err(PlotError::UnknownCategory { .. })));
}

#[test]
fn awkward_motions_still_give_images() {
    let far = at(0.0, 1e6, 1.5, Pose::new(-1e6, 3e5, 1e9));
    let point = Animation::new(Outline::Polygon(vec![]), 0.0).category("", Color::BLUE);
    let triangle = Outline::Polygon(vec![(-0.1, -0.1), (0.2, 0.0), (-0.1, 0.1)]);
    let lifted = Snapshot { gap: 0.05, lean: 0.3, ..at(0.0, 0.0, -0.3, Pose::new(0.0, -0.1, 2.0)) };
    for (k, animation) in [
        disk().snapshots([far]),
        point.snapshots([at(0.0, 0.0, 0.0, Pose::new(0.0, 0.0, 0.0))]),
        Animation::new(triangle, 0.05).category("flies", Color::PURPLE).snapshots([lifted]),
    ]
    .into_iter()
    .enumerate()
    {
        let image = animation.image(9).unwrap();
        assert!(!image.svg().contains("NaN") && image.png().is_ok(), "motion {k}");
    }
}
