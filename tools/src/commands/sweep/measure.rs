//! Measures settings beside the reference: times in alternating pairs, errors, change over time.

use super::record::{Errors, Figures, Pass, Path, Ring, Spread, Temporal, TemporalRing, Times, View};
use super::views::frame_input;
use crate::failure::Failure;
use crate::measure::{PairCount, PassMedian, gpu_times, measure_pairs, median, pass_medians};
use glam::{DMat4, DVec2};
use macula::fovea::{AcuityModel, DisplayGeometry};
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::knobs::Setting;
use macula::quality::acuity_error::{AcuityError, AcuityLowPass};
use macula::quality::compare::{Comparison, RING_STARTS_DEG, compare, rgb_of_rgba};
use macula::quality::picture::Picture;
use macula::quality::temporal::{self, RingVariance, TemporalVariance};
use macula::settings::{Method, RenderSettings, VafrSettings};
use macula::stats::FrameStats;

/// What is measured in and with.
pub struct Subject<'a> {
    /// The device.
    pub device: &'a HeadlessDevice,
    /// The scene.
    pub content: &'a GpuContent,
    /// The display.
    pub display: DisplayGeometry,
    /// The eye's pose where the moves begin.
    pub world_from_view: DMat4,
    /// The views, at least one of which is a gaze by itself.
    pub views: &'a [View],
    /// How often each is rendered.
    pub runs: u32,
    /// The acuity that methods follow and that the error survives.
    pub acuity: &'a AcuityModel,
}

/// The reference of one size, with everything that the settings are compared to.
pub struct Bench<'a> {
    subject: Subject<'a>,
    inputs: Vec<FrameInput>,
    renderer: OffscreenRenderer,
    /// RGBA, of each view.
    pictures: Vec<Vec<u8>>,
    /// Of each gaze by itself.
    low_passes: Vec<AcuityLowPass>,
    camera: Vec<RingVariance>,
    gaze: Vec<RingVariance>,
}

/// A setting's figures, with its picture of the first view.
pub struct Measured {
    /// The figures.
    pub figures: Figures,
    /// RGBA.
    pub picture: Vec<u8>,
}

impl<'a> Bench<'a> {
    /// Renders the reference.
    ///
    /// # Errors
    /// What rendering reports.
    pub fn new(subject: Subject<'a>, reference: &Setting) -> Result<Self, Failure> {
        let display = subject.display;
        let inputs: Vec<_> =
            subject.views.iter().map(|view| frame_input(view, subject.world_from_view, &display)).collect();
        let settings = settings_of(reference, &display, subject.acuity)?;
        let mut renderer = OffscreenRenderer::new(subject.device, subject.content, &settings)?;
        let pictures = inputs.iter().map(|input| {
            renderer.render(input)?;
            Ok(renderer.read_rgba8()?)
        });
        let pictures = pictures.collect::<Result<Vec<_>, Failure>>()?;
        let gazes = inputs.iter().zip(subject.views).filter(|(_, view)| view.path == Path::Gaze);
        let low_passes = gazes
            .map(|(input, _)| {
                AcuityLowPass::new(&display, input.gaze_px, |ecc_deg| subject.acuity.cpd(ecc_deg))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut bench =
            Self { subject, inputs, renderer, pictures, low_passes, camera: Vec::new(), gaze: Vec::new() };
        bench.camera = bench.variance(Path::Camera, &bench.pictures)?;
        bench.gaze = bench.variance(Path::GazeMove, &bench.pictures)?;
        Ok(bench)
    }

    /// The reference's picture of the first view, RGBA.
    pub fn picture(&self) -> &[u8] {
        &self.pictures[0]
    }

    /// Whether the device still renders.
    ///
    /// # Errors
    /// What rendering reports.
    pub fn check_device(&mut self) -> Result<(), Failure> {
        self.renderer.render(&self.inputs[0])?;
        Ok(())
    }

    /// Measures a setting.
    ///
    /// # Errors
    /// What rendering reports, and what the metrics refuse.
    pub fn measure(&mut self, setting: &Setting, progress: impl FnMut(f64)) -> Result<Measured, Failure> {
        let settings = settings_of(setting, &self.subject.display, self.subject.acuity)?;
        let before = self.subject.device.memory_bytes();
        let mut renderer = OffscreenRenderer::new(self.subject.device, self.subject.content, &settings)?;
        let memory_bytes = self.subject.device.memory_bytes().saturating_sub(before);
        // The first frame's time holds what the driver compiles when it first runs a pass.
        renderer.render(&self.inputs[0])?;
        let mut pictures = Vec::new();
        let views = self.inputs.len();
        let mut done = 0;
        let measure = |second: bool| -> Result<FrameStats, Failure> {
            let index = done / 2;
            done += 1;
            let input = &self.inputs[index % views];
            if !second {
                return Ok(self.renderer.render(input)?);
            }
            let frame = renderer.render(input)?;
            if index < views {
                pictures.push(renderer.read_rgba8()?);
            }
            Ok(frame)
        };
        let pairs = measure_pairs(PairCount::Fixed(self.subject.runs * views as u32), measure, progress)?;
        let figures = Figures {
            times: times(&pairs.first, &pairs.second)?,
            errors: self.errors(&pictures)?,
            temporal: Temporal {
                camera: over(&self.variance(Path::Camera, &pictures)?, &self.camera)?,
                gaze: over(&self.variance(Path::GazeMove, &pictures)?, &self.gaze)?,
            },
            samples_shaded: mean_samples(&pairs.second),
            memory_bytes,
            non_finite: pairs.second.iter().filter_map(|frame| frame.non_finite).sum(),
            jod: None,
        };
        Ok(Measured { figures, picture: pictures.swap_remove(0) })
    }

    fn views_of(&self, path: Path) -> impl Iterator<Item = usize> {
        let views = self.subject.views;
        (0..views.len()).filter(move |&index| views[index].path == path)
    }

    fn errors(&self, pictures: &[Vec<u8>]) -> Result<Errors, Failure> {
        let mut sums = Sums::default();
        for (low_pass, index) in self.low_passes.iter().zip(self.views_of(Path::Gaze)) {
            let [reference, of_setting] =
                [&self.pictures[index], &pictures[index]].map(|rgba| rgb_of_rgba(rgba));
            let gaze_px = self.inputs[index].gaze_px;
            let comparison = compare(&reference, &of_setting, &self.subject.display, gaze_px)?;
            let surviving = low_pass.error(Picture::Srgb8(&reference), Picture::Srgb8(&of_setting))?;
            sums.add(&comparison, &surviving);
        }
        Ok(sums.errors())
    }

    /// Of the pictures of a move, in rings about where the gaze is in its middle; nothing without a move.
    fn variance(&self, path: Path, pictures: &[Vec<u8>]) -> Result<Vec<RingVariance>, Failure> {
        let views: Vec<_> = self.views_of(path).collect();
        if views.is_empty() {
            return Ok(Vec::new());
        }
        let display = &self.subject.display;
        let mut variance = TemporalVariance::new(display.size_px)?;
        for &index in &views {
            variance.add(Picture::Srgb8(&rgb_of_rgba(&pictures[index])))?;
        }
        let gaze_px =
            views.iter().map(|&index| self.inputs[index].gaze_px).sum::<DVec2>() / views.len() as f64;
        Ok(variance.rings(display, gaze_px)?)
    }
}

/// A setting over the defaults, with an acuity model.
///
/// # Errors
/// A setting that makes no sense.
pub fn settings_of(
    setting: &Setting,
    display: &DisplayGeometry,
    acuity: &AcuityModel,
) -> Result<RenderSettings, Failure> {
    let of_acuity = Method::Vafr(VafrSettings { acuity: acuity.clone(), ..VafrSettings::default() });
    let mut settings = RenderSettings::new(*display, of_acuity);
    settings.check_finite = true;
    setting.apply(&mut settings)?;
    Ok(settings)
}

fn mean_samples(frames: &[FrameStats]) -> u64 {
    let sum: u64 = frames.iter().map(|frame| frame.samples_shaded).sum();
    sum / frames.len().max(1) as u64
}

fn times(reference: &[FrameStats], setting: &[FrameStats]) -> Result<Times, Failure> {
    let [reference_ms, setting_ms] = [reference, setting].map(gpu_times);
    let mut ratios: Vec<_> =
        setting_ms.iter().zip(&reference_ms).map(|(setting, full)| setting / full).collect();
    if ratios.iter().any(|ratio| !ratio.is_finite() || *ratio <= 0.0) {
        return Err(Failure::environment(
            "the device's timestamps do not rise, so that nothing can be timed; try another driver",
        ));
    }
    ratios.sort_by(f64::total_cmp);
    let (ratio_interval, ratio_confidence) = median_interval(&ratios);
    let passes = |frames: &[FrameStats]| {
        let medians = pass_medians(frames).into_iter();
        medians.map(|PassMedian { name, gpu_ms }| Pass { name: name.to_owned(), gpu_ms }).collect()
    };
    Ok(Times {
        pairs: ratios.len() as u32,
        setting_ms: spread(&setting_ms),
        reference_ms: spread(&reference_ms),
        ratio: spread(&ratios),
        ratio_interval,
        ratio_confidence,
        passes: passes(setting),
        reference_passes: passes(reference),
    })
}

/// Of values without NaN.
pub fn spread(values: &[f64]) -> Spread {
    Spread {
        median: median(values).unwrap_or_default(),
        least: values.iter().copied().reduce(f64::min).unwrap_or_default(),
        greatest: values.iter().copied().reduce(f64::max).unwrap_or_default(),
    }
}

/// The narrowest pair of order statistics, equally far from both ends, that holds the median with a
/// probability of at least 0.95, and that probability; the least and the greatest value where even they do
/// not. The number of values below the median is binomial with p = 1/2, whatever the distribution.
fn median_interval(sorted: &[f64]) -> ([f64; 2], f64) {
    let count = sorted.len();
    // P(fewer than k values lie below the median), from the binomial distribution.
    let mut tail = 0.0;
    let mut term = 0.5_f64.powi(count as i32);
    let mut best = (0, 1.0 - 2.0 * term);
    for k in 0..count / 2 {
        tail += term;
        let confidence = 1.0 - 2.0 * tail;
        if confidence < 0.95 {
            break;
        }
        best = (k, confidence);
        term *= (count - k) as f64 / (k + 1) as f64;
    }
    let (k, confidence) = best;
    ([sorted[k], sorted[count - 1 - k]], confidence.max(0.0))
}

fn over(rings: &[RingVariance], reference: &[RingVariance]) -> Result<Vec<TemporalRing>, Failure> {
    let ratios = temporal::ratio(rings, reference)?;
    let both = rings.iter().zip(ratios);
    Ok(both
        .map(|(ring, ratio)| TemporalRing {
            from_deg: ring.from_deg,
            to_deg: ring.to_deg.is_finite().then_some(ring.to_deg),
            variance: ring.variance,
            ratio: ratio.variance.filter(|ratio| ratio.is_finite()),
        })
        .collect())
}

/// Sums over pixels of squared errors and of FLIP, from which means over several pictures follow.
#[derive(Clone, Copy, Default)]
struct RingSums {
    pixels: f64,
    squares: f64,
    flip: f64,
    surviving: f64,
}

#[derive(Default)]
struct Sums([RingSums; RING_STARTS_DEG.len()]);

impl Sums {
    fn add(&mut self, comparison: &Comparison, surviving: &AcuityError) {
        for ((sums, ring), survivor) in self.0.iter_mut().zip(&comparison.rings).zip(&surviving.rings) {
            let pixels = ring.pixels as f64;
            // Infinite where equal, which is an error of 0.
            let mean_square = |psnr_db: f64| 10.0_f64.powf(-psnr_db / 10.0);
            sums.pixels += pixels;
            sums.squares += ring.psnr_db.map_or(0.0, mean_square) * pixels;
            sums.flip += ring.flip.unwrap_or_default() * pixels;
            sums.surviving += survivor.rmse.unwrap_or_default().powi(2) * pixels;
        }
    }

    fn errors(&self) -> Errors {
        let whole = self.0.iter().fold(RingSums::default(), |sum, ring| RingSums {
            pixels: sum.pixels + ring.pixels,
            squares: sum.squares + ring.squares,
            flip: sum.flip + ring.flip,
            surviving: sum.surviving + ring.surviving,
        });
        let ring = |(index, sums): (usize, &RingSums)| {
            let mean = |sum: f64| (sums.pixels > 0.0).then(|| sum / sums.pixels);
            Ring {
                from_deg: RING_STARTS_DEG[index],
                to_deg: RING_STARTS_DEG.get(index + 1).copied(),
                rmse: mean(sums.squares).map(f64::sqrt),
                flip: mean(sums.flip),
                acuity_rmse: mean(sums.surviving).map(f64::sqrt),
            }
        };
        Errors {
            rmse: (whole.squares / whole.pixels).sqrt(),
            flip: whole.flip / whole.pixels,
            acuity_rmse: (whole.surviving / whole.pixels).sqrt(),
            seam_residual: None,
            rings: self.0.iter().enumerate().map(ring).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_holds_the_median_as_often_as_it_says() {
        let sorted = |count: u32| (0..count).map(f64::from).collect::<Vec<_>>();
        // Published: the 2nd and the 9th of 10 (97.9 %), the 6th and 15th of 20 (95.9 %), the least and the
        // greatest of 6 (96.9 %) and of 5 (93.75 %).
        for (count, ends, confidence) in [
            (10, [1.0, 8.0], 0.978_515_625),
            (20, [5.0, 14.0], 0.958_610_534_667_968_8),
            (6, [0.0, 5.0], 0.968_75),
            (5, [0.0, 4.0], 0.9375),
            (1, [0.0, 0.0], 0.0),
        ] {
            let (found, of) = median_interval(&sorted(count));
            assert_eq!(found, ends, "{count}");
            assert!((of - confidence).abs() < 1e-12, "{count}: {of}");
        }
    }

    #[test]
    fn an_interval_of_many_values_is_narrow() {
        let sorted: Vec<f64> = (0..1001).map(f64::from).collect();
        let ([low, high], confidence) = median_interval(&sorted);
        assert!(low > 460.0 && high < 540.0 && confidence >= 0.95, "{low} {high} {confidence}");
    }

    fn frame(gpu_ms: f64) -> FrameStats {
        FrameStats { gpu_ms, samples_shaded: 100, ..FrameStats::default() }
    }

    #[test]
    fn ratios_are_taken_within_pairs() {
        let [reference, setting] = [[10.0, 20.0, 40.0], [5.0, 12.0, 16.0]].map(|times| times.map(frame));
        let times = times(&reference, &setting).unwrap();
        assert_eq!(times.ratio, Spread { median: 0.5, least: 0.4, greatest: 0.6 });
        assert_eq!((times.pairs, times.ratio_interval), (3, [0.4, 0.6]));
        assert!(super::times(&[frame(0.0)], &[frame(1.0)]).is_err());
    }

    #[test]
    fn errors_of_several_pictures_are_added_by_pixels() {
        let ring = |pixels, psnr_db, flip| macula::quality::compare::Ring {
            from_deg: 0.0,
            to_deg: 2.0,
            pixels,
            psnr_db,
            flip,
        };
        let picture = |pixels, psnr_db, flip, rmse| {
            let comparison = Comparison {
                psnr_db: 0.0,
                flip: 0.0,
                psnr_within_5_deg_db: None,
                rings: vec![ring(pixels, Some(psnr_db), Some(flip))],
            };
            let of = macula::quality::acuity_error::AcuityRing {
                from_deg: 0.0,
                to_deg: 2.0,
                pixels,
                rmse: Some(rmse),
                psnr_db: None,
            };
            (comparison, AcuityError { rmse: 0.0, psnr_db: 0.0, rings: vec![of] })
        };
        let mut sums = Sums::default();
        for (comparison, surviving) in [picture(30, 20.0, 0.2, 0.1), picture(10, f64::INFINITY, 0.0, 0.0)] {
            sums.add(&comparison, &surviving);
        }
        let errors = sums.errors();
        // Three quarters of the pixels have a mean square of 0.01.
        assert!((errors.rmse - 0.0075_f64.sqrt()).abs() < 1e-12);
        assert!((errors.flip - 0.15).abs() < 1e-12 && (errors.acuity_rmse - 0.0075_f64.sqrt()).abs() < 1e-12);
        assert_eq!((errors.rings[0].to_deg, errors.rings[1].rmse), (Some(2.0), None));
    }
}
