//! The results as they are printed.

use super::summary::{DEVIATION_FROM_DEG, Deviation, Rate, Row, Summary};
use super::totals::Totals;
use crate::output::{grouped, table};
use glam::{DVec2, DVec3};
use macula::fovea::DisplayGeometry;
use serde::Serialize;
use std::fmt::Write;

/// Eccentricities of which the text has a line, degrees; JSON has all.
const SHOWN_DEG: [f64; 17] =
    [0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0];

/// Everything that was asked for.
#[derive(Debug, Serialize)]
pub struct Results {
    /// The acuity model's name or file.
    pub acuity: String,
    /// Distance of the eccentricities, degrees.
    pub step_deg: f64,
    /// Deviations count from this eccentricity on, degrees.
    pub deviation_from_deg: f64,
    /// What mapped the points of the counted rates.
    pub counted_on: &'static str,
    /// A method on a display at a gaze each; those of a gaze stand together.
    pub curves: Vec<Curve>,
}

/// A display in reports.
#[derive(Clone, Debug, Serialize)]
pub struct DisplayNote {
    /// What tells it from others in a few words.
    pub label: String,
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Tangents of the half angles to the left, right, upper and lower edge.
    pub tangents: [f64; 4],
}

impl DisplayNote {
    /// Of a display.
    pub fn new(label: &str, display: &DisplayGeometry) -> Self {
        let &DisplayGeometry { size_px, tan_left, tan_right, tan_up, tan_down } = display;
        Self { label: label.to_owned(), size_px, tangents: [tan_left, tan_right, tan_up, tan_down] }
    }
}

/// A gaze in reports.
#[derive(Clone, Debug, Serialize)]
pub struct GazeNote {
    /// What tells it from others in a few words.
    pub label: String,
    /// On the display, px.
    pub px: [f64; 2],
    /// From the view axis, degrees.
    pub off_axis_deg: f64,
}

impl GazeNote {
    /// Of a gaze on a display, px.
    pub fn new(label: &str, display: &DisplayGeometry, px: DVec2) -> Self {
        let off_axis_deg = display.ray_of_px(px).angle_between(DVec3::NEG_Z).to_degrees();
        Self { label: label.to_owned(), px: px.to_array(), off_axis_deg }
    }
}

/// One method on one display at one gaze.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// The method's name.
    pub method: &'static str,
    /// The display.
    pub display: DisplayNote,
    /// The gaze.
    pub gaze: GazeNote,
    /// Rates from the Jacobian.
    pub analytic: Summary,
    /// Rates by counting.
    pub counted: Summary,
    /// How many samples.
    pub totals: Totals,
}

/// The report.
pub fn text(results: &Results) -> String {
    let mut text = format!(
        "Shading rates in cycles per degree; acuity {}; counted on the {}\n\
         A rate's target is the lower of acuity and half the display's pixels per degree.\n",
        results.acuity, results.counted_on
    );
    for curve in &results.curves {
        let Curve { method, display, gaze, .. } = curve;
        _ = write!(text, "\n{method}, {}, {}\n{}", display.label, gaze.label, rates(curve));
    }
    _ = write!(text, "\nSamples\n{}", samples(&results.curves));
    _ = write!(
        text,
        "\nRates over the acuity and over their targets at {DEVIATION_FROM_DEG} degrees and beyond\n{}",
        deviations(&results.curves)
    );
    text + "LP: outside the native pixels. Off both: the greatest miss of acuity and of the display's limit alike.\n"
}

fn shown(rows: &[Row]) -> Vec<&Row> {
    let mut shown: Vec<&Row> = vec![];
    for deg in SHOWN_DEG {
        let off = |row: &&Row| (row.ecc_deg - deg).abs();
        let nearest = rows.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        // Off by more than a quarter it is another place.
        shown.extend(nearest.filter(|row| off(row) <= deg / 4.0));
    }
    shown.dedup_by(|a, b| a.ecc_deg == b.ecc_deg);
    shown
}

fn rates(curve: &Curve) -> String {
    let counted = |ecc_deg: f64| curve.counted.rows.iter().find(|row| row.ecc_deg == ecc_deg);
    let cells = shown(&curve.analytic.rows).into_iter().map(|row| {
        let counted = counted(row.ecc_deg);
        let limits = row.radial.or(row.tangential).map(|rate| rate.limits);
        let mut cells = vec![
            format!("{}", (row.ecc_deg * 1e4).round() / 1e4),
            limits.map_or("-".into(), |limits| format!("{:.2}", limits.acuity_cpd)),
        ];
        for (rate, counted) in [
            (row.radial, counted.and_then(|row| row.radial)),
            (row.tangential, counted.and_then(|row| row.tangential)),
        ] {
            cells.push(mean(rate.as_ref().map(|rate| rate.limits.display_cpd)));
            cells.push(mean(rate.as_ref().map(|rate| rate.cpd.mean)));
            cells.push(rate.as_ref().map_or("-".into(), spread));
            cells.push(mean(counted.as_ref().map(|rate| rate.cpd.mean)));
        }
        cells.push(format!("{:.0} %", row.native_share * 100.0));
        cells
    });
    let header = [
        "deg",
        "acuity",
        "display",
        "radial",
        "least..greatest",
        "counted",
        "display",
        "tangential",
        "least..greatest",
        "counted",
        "native",
    ];
    table(&header, &cells.collect::<Vec<_>>())
}

fn mean(cpd: Option<f64>) -> String {
    cpd.map_or("-".into(), |cpd| format!("{cpd:.2}"))
}

fn spread(rate: &Rate) -> String {
    format!("{:.2}..{:.2}", rate.cpd.min, rate.cpd.max)
}

fn percent(share: Option<f64>) -> String {
    share.map_or("-".into(), |share| format!("{:.1} %", share * 100.0))
}

fn name(curve: &Curve) -> Vec<String> {
    vec![curve.method.to_owned(), curve.display.label.clone(), curve.gaze.label.clone()]
}

fn samples(curves: &[Curve]) -> String {
    let cells = curves.iter().map(|curve| {
        let totals = &curve.totals;
        let frame = totals.frame;
        let mut cells = name(curve);
        cells.extend([
            grouped(totals.display_pixels),
            grouped(totals.lp_texels),
            percent(totals.share_of_use),
            grouped(totals.native_pixels),
            grouped(totals.samples),
            grouped(totals.limit.round() as u64),
            format!("{:.2}", totals.samples_over_limit),
            frame.map_or("-".into(), |frame| grouped(frame.samples)),
            percent(frame.and_then(|frame| frame.share_on_display)),
        ]);
        cells
    });
    let header = [
        "method",
        "display",
        "gaze",
        "pixels",
        "LP texels",
        "of use",
        "native",
        "samples",
        "limit",
        "ratio",
        "shaded",
        "on display",
    ];
    table(&header, &cells.collect::<Vec<_>>())
}

fn deviations(curves: &[Curve]) -> String {
    let ratios = |deviation: &Option<Deviation>| {
        let told =
            |deviation: &Deviation| format!("{:.3}..{:.3}", deviation.lowest.ratio, deviation.highest.ratio);
        deviation.as_ref().map_or("-".into(), told)
    };
    let both = |deviation: &Option<Deviation>| {
        deviation.as_ref().map_or("-".into(), |deviation| format!("{:.2} %", deviation.off_both * 100.0))
    };
    let cells = curves.iter().map(|curve| {
        let Curve { analytic, counted, .. } = curve;
        let of_acuity = analytic.deviation_outside_native.map(|deviation| deviation.over_acuity);
        let mut cells = name(curve);
        cells.extend([
            of_acuity.map_or("-".into(), |[low, high]| format!("{low:.3}..{high:.3}")),
            ratios(&analytic.deviation),
            ratios(&analytic.deviation_outside_native),
            both(&analytic.deviation),
            ratios(&counted.deviation),
            both(&counted.deviation),
        ]);
        cells
    });
    let header = [
        "method",
        "display",
        "gaze",
        "LP over acuity",
        "over target",
        "LP over target",
        "off both",
        "counted",
        "off both",
    ];
    table(&header, &cells.collect::<Vec<_>>())
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::summary::{Direction, Sample};
    use super::super::target::Limits;
    use super::*;

    /// 20 and 10 cpd radially and a quarter more tangentially at 10 and 20 degrees, where acuity asks for
    /// 16 and 10 and the display has 30; counted a tenth lower.
    pub fn curve(method: &'static str, display: &str, gaze: &str) -> Curve {
        let summary = |factor: f64| {
            let samples = [(10.0, 20.0, 16.0), (20.0, 10.0, 10.0)].into_iter().flat_map(
                |(ecc_deg, cpd, acuity_cpd)| {
                    [(Direction::Radial, 1.0), (Direction::Tangential, 1.25)].map(|(direction, ratio)| {
                        Sample {
                            ecc_deg,
                            azimuth_deg: 45.0,
                            direction,
                            cpd: cpd * ratio * factor,
                            limits: Limits { acuity_cpd, display_cpd: 30.0, target_cpd: acuity_cpd },
                            is_native: false,
                        }
                    })
                },
            );
            Summary::of(samples.collect())
        };
        Curve {
            method,
            display: DisplayNote {
                label: display.into(),
                size_px: [1920, 1080],
                tangents: [-1.0, 1.0, 0.5, -0.5],
            },
            gaze: GazeNote { label: gaze.into(), px: [960.0, 540.0], off_axis_deg: 0.0 },
            analytic: summary(1.0),
            counted: summary(0.9),
            totals: Totals {
                display_pixels: 2_073_600,
                native_pixels: 500_000,
                lp_texels: 1_000_000,
                texels_of_use: 400_000,
                share_of_use: Some(0.4),
                samples: 900_000,
                limit: 750_000.0,
                samples_over_limit: 1.2,
                frame: None,
            },
        }
    }

    pub fn results(curves: Vec<Curve>) -> Results {
        Results {
            acuity: "vafr-2025".into(),
            step_deg: 10.0,
            deviation_from_deg: DEVIATION_FROM_DEG,
            counted_on: "CPU",
            curves,
        }
    }

    #[test]
    fn the_text_has_a_line_for_each_eccentricity_and_curve() {
        let text =
            text(&results(vec![curve("kfr", "1920x1080", "centre"), curve("vafr", "1920x1080", "centre")]));
        let line =
            |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap_or_default().to_owned();
        let cells = line("10 ").split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let expected = [
            "10",
            "16.00",
            "30.00",
            "20.00",
            "20.00..20.00",
            "18.00",
            "30.00",
            "25.00",
            "25.00..25.00",
            "22.50",
            "0",
            "%",
        ];
        assert_eq!(cells, expected);
        assert_eq!(text.lines().filter(|line| line.starts_with("20 ")).count(), 2);
        for told in ["40.0 %", "900 000", "750 000", "1.20", "0.900..1.406"] {
            assert_eq!(text.matches(told).count(), 2, "{told} in {text}");
        }
        // Nothing is native, and the acuity is the target.
        assert_eq!(text.matches("1.000..1.562").count(), 6, "{text}");
    }

    #[test]
    fn places_far_from_any_row_are_not_shown() {
        let rows = curve("kfr", "", "").analytic.rows;
        let shown: Vec<_> = shown(&rows).iter().map(|row| row.ecc_deg).collect();
        assert_eq!(shown, [10.0, 20.0]);
    }
}
