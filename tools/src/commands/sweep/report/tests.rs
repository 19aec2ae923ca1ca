//! The page as text and as XML, with made-up records.

use super::fixture::{effects, figures, manifest, records, thumbnails};
use super::*;
use crate::commands::sweep::record::{Outcome, Spread};
use macula::knobs::KNOBS;
use roxmltree::{Document, Node};

/// The page as XML: without what only HTML has, the script's and the style's text.
fn xml(html: &str) -> String {
    let mut xml = html.strip_prefix("<!doctype html>").expect("a doctype").to_owned();
    for tag in ["style", "script"] {
        let (before, rest) = xml.split_once(&format!("<{tag}>\n")).expect("a beginning");
        let (_, after) = rest.split_once(&format!("</{tag}>")).expect("an end");
        xml = format!("{before}{after}");
    }
    xml
}

fn page(manifest: &Manifest, records: &[Record]) -> String {
    html(manifest, records, Some(&effects()), &thumbnails())
}

fn classed<'a>(document: &'a Document<'a>, class: &str) -> Vec<Node<'a, 'a>> {
    let has = |node: &Node<'_, '_>| {
        node.attribute("class").is_some_and(|classes| classes.split(' ').any(|one| one == class))
    };
    document.descendants().filter(has).collect()
}

/// What must hold for every page.
fn check(html: &str) {
    let xml = xml(html);
    let document = Document::parse(&xml).expect("well-formed");
    let mut ids: Vec<_> = document.descendants().filter_map(|node| node.attribute("id")).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "an id is there twice");
    for node in document.descendants() {
        for attribute in node.attributes().filter(|attribute| attribute.name() != "src") {
            let value = attribute.value();
            assert!(!value.contains("NaN") && !value.contains("inf,"), "{}={value}", attribute.name());
            if ["d", "transform", "viewBox", "cx", "cy", "x", "y", "r"].contains(&attribute.name()) {
                assert!(!value.contains("inf") && !value.is_empty(), "{}={value}", attribute.name());
            }
        }
        if let Some(key) = node.attribute("href") {
            assert!(key.strip_prefix('#').is_some_and(|key| ids.binary_search(&key).is_ok()), "{key}");
        }
        if node.has_tag_name("svg") && node.attribute("aria-hidden").is_none() {
            let names = node.attribute("aria-labelledby").expect("a name").split(' ');
            assert!(names.clone().count() == 2 && names.into_iter().all(|id| ids.binary_search(&id).is_ok()));
        }
        if node.has_tag_name("th") {
            assert!(matches!(node.attribute("scope"), Some("col" | "row")));
        }
    }
    assert!(!html.contains("{{") && !html.contains("}}"));
    for far in ["http:", "https:", "src=\"/", "url(", "@import", "<link", "fetch("] {
        assert!(!html.contains(far), "{far}");
    }
}

/// With the settings at these places, at the first size.
fn some(places: &[usize]) -> (Manifest, Vec<Record>) {
    let mut manifest = manifest();
    manifest.sizes.truncate(1);
    manifest.settings = places.iter().map(|&place| manifest.settings[place].clone()).collect();
    let size = manifest.sizes[0];
    let kept = records().into_iter().filter(|record| record.size == size && places.contains(&record.index));
    (manifest, kept.enumerate().map(|(index, record)| Record { index, ..record }).collect())
}

#[test]
fn the_page_is_well_formed_and_every_record_is_on_it() {
    let (manifest, records) = (manifest(), records());
    let html = page(&manifest, &records);
    check(&html);
    let xml = xml(&html);
    let document = Document::parse(&xml).expect("well-formed");
    // A card for each record and each size's reference; a point in each of six charts of two formats.
    assert_eq!(classed(&document, "card").len(), records.len() + 2);
    let measured = records.iter().filter(|record| matches!(record.outcome, Outcome::Measured(_))).count();
    let charts = classed(&document, "chart");
    assert_eq!(charts.len(), 2 * 6);
    let points = charts.iter().flat_map(|chart| chart.descendants());
    let points =
        points.filter(|node| node.attribute("class").is_some_and(|class| class.starts_with("point")));
    assert_eq!(points.count(), (measured + 2) * 6 * 2);
    let rows = classed(&document, "settings");
    let rows = rows
        .iter()
        .flat_map(|table| table.descendants())
        .filter(|node| node.attribute("scope") == Some("row"));
    assert_eq!(rows.count(), measured);
    let failed = classed(&document, "failed");
    assert_eq!(failed[0].descendants().filter(|node| node.attribute("scope") == Some("row")).count(), 2);
    assert!(html.contains("9.1 GiB &lt;more than there is&gt;; raise sigma"));
    assert_eq!(html.matches("data:image/png;base64,").count(), 2 * measured + 2);
    for knob in KNOBS {
        assert!(html.contains(&format!("<th scope=\"row\">{}</th>", knob.name)), "{}", knob.name);
    }
    assert!(html.contains("-o 'out/a sweep'"));
}

#[test]
fn the_headline_is_a_measured_setting_of_the_front() {
    // Of these three the middle one lies farthest below the line between the others.
    let (manifest, mut records) = some(&[0, 1, 2]);
    let told = [(0.2, 0.05), (0.4, 0.01), (0.9, 0.005)];
    for (record, (ratio, error)) in records.iter_mut().zip(told) {
        let Outcome::Measured(figures) = &mut record.outcome else { panic!("failed") };
        figures.times.ratio.median = ratio;
        figures.errors.acuity_rmse = error;
        figures.times.ratio_interval = [ratio - 0.01, ratio + 0.01];
    }
    let sentence = headline::sentence(&sheets(&manifest, &records));
    let text = sentence.replace("<strong>", "").replace("</strong>", "");
    assert_eq!(
        text,
        "At 1280×720 px kfr, sigma 1.4 takes 0.400 of the reference's time (0.390 to 0.410, 96\u{a0}% sure) at an \
         acuity-surviving error of 0.0100."
    );
}

#[test]
fn knobs_have_curves_where_all_else_is_equal() {
    let (manifest, records) = (manifest(), records());
    let sheets = sheets(&manifest, &records);
    let html = knob_curves::section(&sheets[0]);
    let titles: Vec<&str> =
        html.split("<h4>").skip(1).filter_map(|part| part.split("</h4>").next()).collect();
    // One value of visual-polar's and guenter3's makes no curve, and of rmfr's two one has failed. Methods: vafr
    // and vafr-planar have two acuity scales in common.
    let expected = ["method", "sigma", "alpha", "acuity-scale", "lafr-delta", "lp-filter", "shadow-map-size"];
    assert_eq!(titles, expected);
    // The base's alpha of 4 and sigma of 1.8 are in one line with those of the command line.
    let alpha =
        html.split("<h4>alpha</h4>").nth(1).and_then(|part| part.split("</section>").next()).expect("alpha");
    assert_eq!(alpha.matches("<a class=\"point\"").count(), 2 * 4);
}

#[test]
fn one_setting_none_and_failed_ones_make_a_page() {
    let (manifest, records) = some(&[2]);
    let one = page(&manifest, &records);
    check(&one);
    assert!(one.contains("No two settings differ in one knob only."));

    let none = html(&manifest, &[], None, &Thumbnails::default());
    check(&none);
    assert!(none.contains("No setting has been measured yet.") && none.contains("1 not yet run"));
    assert!(none.contains("The effects were not measured"));

    let failed: Vec<Record> = records
        .iter()
        .map(|record| Record { outcome: Outcome::Failed("lost <device>".into()), ..record.clone() })
        .collect();
    let failed = page(&manifest, &failed);
    check(&failed);
    assert!(failed.contains("All 1 settings failed") && failed.contains("lost &lt;device&gt;"));
}

#[test]
fn text_is_escaped() {
    let (mut manifest, mut records) = some(&[0, 1]);
    manifest.scene = "<b>{{script}}</b> & \"c\"".into();
    manifest.command.push("<b>'".into());
    for record in &mut records {
        record.machine.device = "<i>".into();
    }
    let html = page(&manifest, &records);
    check(&html.replace("{{script}}", ""));
    assert!(!html.contains("<b>{{") && !html.contains("<i>") && !html.contains("<b>'"));
    assert!(html.contains("&lt;b&gt;{{script}}&lt;/b&gt; &amp; &quot;c&quot;"));
}

#[test]
fn what_is_not_finite_is_never_drawn() {
    let (manifest, mut records) = some(&[0, 1, 2, 3]);
    let strange = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for (record, value) in records.iter_mut().skip(1).zip(strange) {
        let Outcome::Measured(figures) = &mut record.outcome else { panic!("failed") };
        figures.times.ratio = Spread { median: value, least: value, greatest: value };
        figures.times.ratio_interval = [value; 2];
        figures.errors.acuity_rmse = value;
        figures.times.passes[0].gpu_ms = value;
        figures.errors.rings[0].flip = Some(value);
    }
    check(&page(&manifest, &records));
}

#[test]
fn a_setting_slower_than_the_reference_is_not_praised() {
    let (manifest, mut records) = some(&[0]);
    let mut slow = figures([1280, 720], 0, 0.5, 1.0);
    slow.times.ratio.median = 1.2;
    records[0].outcome = Outcome::Measured(Box::new(slow));
    let html = page(&manifest, &records);
    check(&html);
    assert!(html.contains("No setting that was measured is faster than the reference."));
}

#[test]
fn a_change_by_leaving_out_is_told() {
    let mut effects = effects();
    effects.effects[3].most_changed = 3;
    let section = effects::section(Some(&effects));
    assert!(section.contains("<strong>Leaving out changed the picture: depth of field (by up to 3 of 255)"));
}

/// The page for a look with a browser: `MACULA_REPORT_PAGE=FILE cargo test --lib`.
#[test]
fn the_page_can_be_looked_at() {
    let html = page(&manifest(), &records());
    check(&html);
    if let Some(path) = std::env::var_os("MACULA_REPORT_PAGE") {
        std::fs::write(path, html).expect("a page");
    }
}
