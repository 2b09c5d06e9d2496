//! The main job's story: a controller that its own equations satisfy fails on the true plant, the logs say why, and the model
//! extended by what they say reaches the target; and the page that tells it stands alone. `.ci/main_job.py` runs all of it.

use crate::common::pages::assert_page;
use bracketry::plate::{Shape, published};
use bracketry::system::System;
use bracketry_cli::demo::{MoveOnPlant, Story, StorySettings};

const DISK: Shape = Shape::Disk { radius: 0.12 };

/// Short logs and one cause: every chapter in a few seconds.
fn thin() -> StorySettings {
    let mut settings = StorySettings { seconds: 1.0, rest_samples: 5, ..StorySettings::default() };
    settings.diagnosis.max_causes = 1;
    settings
}

/// What the estimator corrects: the friction coefficient.
fn mu() -> [String; 1] {
    ["mu".to_owned()]
}

#[test]
fn the_controller_of_the_published_model_fails_on_the_true_plant() {
    let model = published(&DISK, 0.3).unwrap();
    let moved = MoveOnPlant::run("published model", &model, &mu(), &StorySettings::default()).unwrap();
    let a = moved.arrival;
    assert!(!moved.reached(), "{a:?}");
    assert!(1e3 * a.x_m.hypot(a.y_m) > 10.0 || a.phi_deg.abs() > 10.0, "{a:?}");
}

#[test]
fn the_same_controller_reaches_the_target_with_a_model_from_first_principles() {
    let model = System::parse("plate_disk.toml", include_str!("../../../../models/plate_disk.toml")).unwrap();
    let moved = MoveOnPlant::run("plate_disk", &model, &mu(), &StorySettings::default()).unwrap();
    let a = moved.arrival;
    assert!(moved.reached() && a.x_m.abs() < 2e-3 && a.y_m.abs() < 2e-3 && a.phi_deg.abs() < 2.0, "{a:?}");
    assert_eq!((a.stroke_excess_m, a.tilt_excess_deg), (0.0, 0.0), "{a:?}");
    // From a camera, one sample late, and in little more than the shortest time.
    assert!(moved.shortest_s.is_some_and(|t| t < 1.3) && a.settled_s.is_some_and(|t| t <= 1.5), "{a:?}");
}

#[test]
fn the_page_is_well_formed_stands_alone_and_holds_every_figure() {
    let mut chapters = 0;
    let story = Story::tell(&thin(), &mut |event| {
        chapters += usize::from(
            matches!(event, bracketry_cli::demo::StoryEvent::Told(text) if text.starts_with(char::is_numeric)),
        );
    })
    .unwrap();
    assert_eq!(chapters, 6);
    let animations = story.animations().unwrap();
    let page = story.page(&animations, &[]);
    assert_page(&page, None);
    let figures = story.figures();
    for figure in &figures {
        assert!(figure.drawing.is_ok(), "{}: {:?}", figure.name, figure.drawing.as_ref().err());
    }
    assert_eq!(page.matches("<figure>").count(), figures.len() + animations.len());
    assert_eq!(page.matches("data:image/gif;base64,R0lGOD").count(), animations.len());
    assert!(page.matches("<math>").count() > 20);
}
