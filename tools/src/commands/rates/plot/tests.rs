//! The plot as XML, and its geometry.

use super::super::report::tests::{curve, results};
use super::*;
use roxmltree::{Document, Node};

fn classed<'a>(document: &'a Document<'a>, class: &'a str) -> Vec<Node<'a, 'a>> {
    let has = |node: &Node<'_, '_>| {
        node.attribute("class").is_some_and(|classes| classes.split(' ').any(|one| one == class))
    };
    document.descendants().filter(has).collect()
}

/// Corners of a path of `M` and `L`.
fn points(node: &Node<'_, '_>) -> Vec<(f64, f64)> {
    let path = node.attribute("d").unwrap_or_default();
    let pairs = path.split(['M', 'L']).filter(|pair| !pair.is_empty());
    let number = |text: &str| text.parse::<f64>().expect("a number");
    pairs
        .map(|pair| pair.split_once(' ').expect("two numbers"))
        .map(|(x, y)| (number(x), number(y)))
        .collect()
}

#[test]
fn the_plot_is_well_formed_and_whole() {
    let results = results(vec![
        curve("vafr", "a <b> & \"c\"", "left"),
        curve("kfr", "a <b> & \"c\"", "left"),
        curve("vafr", "a <b> & \"c\"", "right"),
        curve("kfr", "a <b> & \"c\"", "right"),
    ]);
    for scale in [Scale::Log, Scale::Linear] {
        let svg = svg(&results, scale);
        let document = Document::parse(&svg).expect("XML");
        assert_eq!(document.root_element().tag_name().name(), "svg");
        // Two panels with two curves each, and a sample of each curve in the legend.
        for (class, expected) in [
            ("title", 2),
            ("acuity", 3),
            ("limit", 3),
            ("radial", 6),
            ("tangential", 6),
            ("band", 8),
            ("c1", 6),
        ] {
            assert_eq!(classed(&document, class).len(), expected, "{class}");
        }
        assert!(!classed(&document, "dot").is_empty());
        let style =
            document.descendants().find(|node| node.has_tag_name("style")).and_then(|node| node.text());
        assert!(style.is_some_and(|style| style.contains("prefers-color-scheme:dark")));
        for strange in ["NaN", "inf", "http://", "url(h"] {
            let allowed = usize::from(strange == "http://");
            assert_eq!(svg.matches(strange).count(), allowed, "{strange}");
        }
    }
}

#[test]
fn equal_ratios_are_equally_far_apart_on_a_log_scale() {
    let axes = Axes::new(&[curve("vafr", "display", "gaze")], Scale::Log);
    let [first, second] = [axes.y(10.0) - axes.y(15.0), axes.y(15.0) - axes.y(22.5)];
    assert!(first > 10.0 && (first - second).abs() < 1e-9);
    let axes = Axes::new(&[curve("vafr", "display", "gaze")], Scale::Linear);
    assert!((axes.y(0.0) - (MARGIN[1] + axes.size[1])).abs() < 1e-9);
    let [first, second] = [axes.y(4.0) - axes.y(8.0), axes.y(8.0) - axes.y(12.0)];
    assert!(first > 10.0 && (first - second).abs() < 1e-9);
}

#[test]
fn curves_lie_at_their_values() {
    let curve = curve("vafr", "display", "gaze");
    let axes = Axes::new(std::slice::from_ref(&curve), Scale::Log);
    let svg = svg(&results(vec![curve]), Scale::Log);
    let document = Document::parse(&svg).expect("XML");
    let radial = points(&classed(&document, "radial")[0]);
    // 20 and 10 cpd at 10 and 20 degrees; see the sample results.
    for ((x, y), (deg, cpd)) in radial.iter().zip([(10.0, 20.0), (20.0, 10.0)]) {
        assert!((x - axes.x(deg)).abs() < 0.06 && (y - axes.y(cpd)).abs() < 0.06, "{x} {y}");
    }
    let last = radial.last().expect("a point");
    assert!((last.0 - (PANEL[0] - MARGIN[2])).abs() < 0.06, "the last eccentricity is at the right end");
}

#[test]
fn missing_and_strange_values_leave_gaps() {
    let mut broken = curve("vafr", "display", "gaze");
    broken.analytic.rows[0].radial = None;
    if let Some(rate) = &mut broken.analytic.rows[1].tangential {
        rate.cpd = Spread { min: f64::NAN, mean: f64::NAN, max: f64::INFINITY };
    }
    let mut empty = curve("kfr", "display", "gaze");
    empty.analytic.rows.clear();
    empty.counted.rows.clear();
    for curves in [vec![broken, empty], vec![]] {
        for scale in [Scale::Log, Scale::Linear] {
            let svg = svg(&results(curves.clone()), scale);
            assert!(Document::parse(&svg).is_ok());
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}

#[test]
fn steps_are_round_and_end_within() {
    assert_eq!(steps(53.0, 8.0), [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]);
    assert_eq!(steps(1.0, 8.0), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
    assert_eq!(steps(40.0, 8.0).len(), 9);
}
