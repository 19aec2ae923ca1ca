//! How many samples a method takes, beside how many would do.

use glam::DVec2;
use macula::fovea::{AcuityModel, LpPoint, Mapping, sample_limit};
use macula::stats::LpStats;
use serde::Serialize;

/// What a rendered frame shaded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameSamples {
    /// LP texels that were shaded.
    pub shaded_texels: u64,
    /// Those of them whose centre lies on the display.
    pub on_display: u64,
    /// `on_display` over `shaded_texels`; `None` without an LP-buffer.
    pub share_on_display: Option<f64>,
    /// Texels and native pixels that were shaded.
    pub samples: u64,
}

impl FrameSamples {
    /// From a frame's figures.
    pub fn new(samples: u64, lp: Option<&LpStats>) -> Self {
        let [shaded_texels, on_display] = lp.map_or([0, 0], |lp| [lp.shaded, lp.shaded_on_display]);
        let share = on_display as f64 / shaded_texels as f64;
        let share_on_display = (shaded_texels > 0).then_some(share);
        Self { shaded_texels, on_display, share_on_display, samples }
    }
}

/// Samples of one method on one display at one gaze.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Totals {
    /// Pixels of the display.
    pub display_pixels: u64,
    /// Pixels that are shaded themselves.
    pub native_pixels: u64,
    /// Texels of the LP-buffer's columns.
    pub lp_texels: u64,
    /// Those of them whose centre lies on the display outside the native pixels.
    pub texels_of_use: u64,
    /// `texels_of_use` over `lp_texels`; `None` without an LP-buffer.
    pub share_of_use: Option<f64>,
    /// Native pixels and texels of use.
    pub samples: u64,
    /// Samples that acuity and display together call for.
    pub limit: f64,
    /// `samples` over `limit`.
    pub samples_over_limit: f64,
    /// Of a rendered frame, where there was one.
    pub frame: Option<FrameSamples>,
}

impl Totals {
    /// Counts pixel by pixel and texel by texel.
    pub fn of(mapping: &dyn Mapping, acuity: &AcuityModel, frame: Option<FrameSamples>) -> Self {
        let [width, height] = mapping.display().size_px;
        let native_pixels = native_pixels(mapping);
        let (lp_texels, texels_of_use) = (mapping.columns().texels(), texels_of_use(mapping));
        // As many samples per solid angle as the radial rate times the tangential one.
        let cpd = |ecc_deg: f64| acuity.cpd(ecc_deg) * acuity.delta(ecc_deg).sqrt();
        let limit = sample_limit(mapping.display(), mapping.gaze_px(), &cpd);
        let samples = native_pixels + texels_of_use;
        Self {
            display_pixels: u64::from(width) * u64::from(height),
            native_pixels,
            lp_texels,
            texels_of_use,
            share_of_use: (lp_texels > 0).then(|| texels_of_use as f64 / lp_texels as f64),
            samples,
            limit,
            samples_over_limit: samples as f64 / limit,
            frame,
        }
    }
}

fn native_pixels(mapping: &dyn Mapping) -> u64 {
    let [width, height] = mapping.display().size_px;
    let in_row = |y: u32| {
        let center = |x: u32| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (0..width).filter(|x| mapping.is_native(center(*x))).count() as u64
    };
    (0..height).map(in_row).sum()
}

fn texels_of_use(mapping: &dyn Mapping) -> u64 {
    let size = DVec2::from_array(mapping.display().size_px.map(f64::from));
    let of_use = |column: usize, height: u32, row: u32| {
        let v_share = (f64::from(row) + 0.5) / f64::from(height);
        let px = mapping.inverse(LpPoint { u: column as f64 + 0.5, v_share });
        px.is_some_and(|px| px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all() && !mapping.is_native(px))
    };
    let columns = mapping.columns().heights().iter().enumerate();
    let in_column = |(column, height): (usize, &u32)| {
        (0..*height).filter(|row| of_use(column, *height, *row)).count() as u64
    };
    columns.map(in_column).sum()
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::Constant;
    use super::*;
    use macula::fovea::DisplayGeometry;

    #[test]
    fn frames_tell_their_share_on_the_display() {
        let lp = LpStats { shaded: 200, shaded_on_display: 190, ..LpStats::default() };
        let frame = FrameSamples::new(250, Some(&lp));
        assert_eq!((frame.samples, frame.share_on_display), (250, Some(0.95)));
        assert_eq!(FrameSamples::new(64, None).share_on_display, None);
    }

    #[test]
    fn texels_on_the_display_outside_the_native_disc_are_of_use() {
        let display = DisplayGeometry::symmetric([1920, 1080], 100.0);
        let mapping = Constant::new(display, display.center_px(), [2.0, 2.0], 5.0, 30.0);
        let totals = Totals::of(&mapping, &AcuityModel::vafr_2025(), None);
        // Four columns in a degree: those from 5 to 30 degrees are shaded, all of them on the display.
        let heights = mapping.columns().heights();
        let texels = |heights: &[u32]| heights.iter().copied().map(u64::from).sum::<u64>();
        assert_eq!((totals.lp_texels, totals.texels_of_use), (texels(heights), texels(&heights[20..])));
        // A disc on the plane about the centre.
        let radius_px = 960.0 * 5f64.to_radians().tan() / 50f64.to_radians().tan();
        let area_px = std::f64::consts::PI * radius_px * radius_px;
        assert!((totals.native_pixels as f64 / area_px - 1.0).abs() < 0.01, "{}", totals.native_pixels);
        assert_eq!(totals.samples, totals.native_pixels + totals.texels_of_use);
        assert_eq!(totals.display_pixels, 1920 * 1080);
        assert!((totals.limit / 684e3 - 1.0).abs() < 2e-3, "{}", totals.limit);
    }

    #[test]
    fn half_of_the_lp_buffer_misses_a_display_that_is_gazed_at_on_its_edge() {
        let display = DisplayGeometry::symmetric([1000, 1000], 90.0);
        let mapping = Constant::new(display, DVec2::new(0.0, 500.0), [3.0, 3.0], 0.0, 30.0);
        let totals = Totals::of(&mapping, &AcuityModel::vafr_2025(), None);
        assert!(totals.share_of_use.is_some_and(|share| (share - 0.5).abs() < 0.01), "{totals:?}");
    }

    /// A tangential rate of a quarter calls for a quarter of the samples where acuity is the limit.
    #[test]
    fn delta_counts_in_the_limit() -> macula::error::Result<()> {
        let display = DisplayGeometry::symmetric([1000, 1000], 90.0);
        let mapping = Constant::new(display, display.center_px(), [1.0, 1.0], 0.0, 10.0);
        let round = AcuityModel::new(&[(0.0, 1.0)])?;
        let flat = round.clone().with_delta(&[(0.0, 0.25)])?;
        let [round, flat] = [round, flat].map(|acuity| Totals::of(&mapping, &acuity, None).limit);
        assert!((flat / round - 0.25).abs() < 1e-3);
        Ok(())
    }
}
