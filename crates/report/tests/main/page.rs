//! The frame of pages and what stands in them.

use bracketry_plot::{Panel, PlotError, Series, TimeSeries};
use bracketry_report::html::{self, Chapter, Figure, Page};
use bracketry_system::System;

/// What stands between two texts, each time.
fn between<'a>(page: &'a str, before: &str, after: &str) -> Vec<&'a str> {
    page.split(before).skip(1).map(|rest| rest.split_once(after).unwrap().0).collect()
}

fn figure(name: &str) -> Figure {
    let panel = Panel::new("x [m]").series(Series::new("a", [0.0, 1.0], [0.0, 1.0]));
    Figure::new(name, format!("Caption of <{name}>"), TimeSeries::new().panel(panel).draw())
}

#[test]
fn contents_are_the_headings_of_two_levels_each_with_an_id_of_its_own() {
    let part = |title: &str| Chapter::new(title, "").parts([Chapter::new("Deep", "")]);
    let chapters = [part("Results").parts([part("At the end: a < b")]), part("Results"), part("θ̇ and ω")];
    let page = Page::new("Title", "<p>lead</p>").chapters(chapters).html();
    let ids = between(&page, "<h2 id=\"", "\"").len() + between(&page, "<h3 id=\"", "\"").len();
    let mut links = between(&page, "<a href=\"#", "\"");
    assert_eq!((ids, links.len()), (7, 7));
    assert!(links.iter().all(|id| page.contains(&format!(" id=\"{id}\">"))), "{links:?}");
    links.sort_unstable();
    links.dedup();
    assert_eq!(links.len(), 7);
    assert!(page.contains("At the end: a &lt; b</a>") && page.contains("<h4 id=\"s-deep") && !page.contains("<h5"));
    // Contents, then the text with the lead in front of all chapters.
    let places = ["<nav", "<main>", "<h1>Title</h1>", "<p>lead</p>", "<h2"].map(|part| page.find(part).unwrap());
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn figures_have_names_and_those_that_cannot_be_drawn_are_left_out() {
    let missing = Figure::new("none", "nothing", Err(PlotError::NoContent { missing: "panel" }));
    let all = [figure("one"), missing, figure("two")];
    let shown = html::figures(&all);
    assert_eq!((shown.matches("<figure>").count(), shown.matches("role=\"img\"").count()), (2, 2));
    assert!(shown.contains("aria-label=\"Caption of &lt;one&gt;\"") && !shown.contains("nothing"));
    assert!(!shown.contains("<?xml") && shown.matches("tabindex=\"0\"").count() == 2);
    // The first is open, the others are folded.
    let gallery = html::gallery(&all);
    let folded = gallery.find("<details>").unwrap();
    assert!(gallery.find("<figure>").unwrap() < folded && gallery.matches("<details>").count() == 1);
}

#[test]
fn equations_cancel_and_write_integrators_as_derivatives() {
    let text = "states = ['X', 'Xd', 'w', 'd']\ninputs = ['Xdd']\n[parameters]\nr = 2\n[dynamics]\nX = 'Xd'\nXd = 'Xdd'\n\
                w = '-r^2*Xdd/(2*r^2)'\nd = '1 - d'\n";
    let page = html::equations(&System::parse("m.toml", text).unwrap());
    // X' = Xd and Xd' = Xdd are in the notation.
    assert_eq!(page.matches("<tr>").count(), 2, "{page}");
    assert!(page.contains("X\u{308}") && !page.contains("Xd") && !page.contains("<mi>r</mi>"), "{page}");
    // What does not cancel stays as it was written.
    let plain = System::parse("m.toml", "states = ['d']\n[dynamics]\nd = '5*(d^2 - sin(d) - 3*d)/7'").unwrap();
    assert!(html::equations(&plain).contains(&plain.pool.notation(plain.dynamics[0]).mathml()));
}

#[test]
fn many_figures_are_folded_among_the_files() {
    let list = |names: &[&str]| names.iter().map(|n| ((*n).to_owned(), "it".to_owned())).collect::<Vec<_>>();
    let page = |files: &[(String, String)]| Page::new("t", "").chapters([Chapter::files(files)]).html();
    let few = page(&list(&["a.csv", "a.svg", "a.png"]));
    assert!(few.contains("<a href=\"a.svg\">a.svg</a>") && few.matches("<details").count() == 1);
    let many = page(&list(&["a.csv", "a.svg", "a.png", "b.svg", "b.png", "c.svg"]));
    let folded = many.rfind("<details>").unwrap();
    assert!(many.find("a.csv").unwrap() < folded && many.find("a.svg").unwrap() > folded);
}
