use super::*;
use std::f64::consts::TAU;

/// Looks `deg` to the right.
fn at_deg(deg: f64) -> DVec3 {
    let angle = deg.to_radians();
    DVec3::new(angle.sin(), 0.0, -angle.cos())
}

fn deg_of(direction: DVec3) -> f64 {
    direction.x.atan2(-direction.z).to_degrees()
}

/// Jitter with a repeating pattern of RMS 0.1 deg at 120 Hz.
fn jitter_deg(index: i64) -> f64 {
    0.1 * [1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0][usize::try_from(index % 8).unwrap_or(0)]
}

fn rms_after(filter: &mut dyn Filter) -> f64 {
    let told: Vec<f64> = (0..240)
        .map(|index| {
            deg_of(filter.apply(index * 8_333_333, at_deg(5.0 + jitter_deg(index)), EyeState::Fixation))
        })
        .skip(120)
        .collect();
    (told.iter().map(|deg| (deg - 5.0).powi(2)).sum::<f64>() / told.len() as f64).sqrt()
}

#[test]
fn an_empty_chain_changes_and_delays_nothing() {
    let mut chain = FilterChain::default();
    assert_eq!(chain.apply(3, at_deg(7.0), EyeState::Fixation), at_deg(7.0));
    assert_eq!(chain.delay_ns(), 0);
}

#[test]
fn jitter_of_a_fixation_is_smoothed() {
    assert!(rms_after(&mut FilterChain::default()) > 0.099);
    assert!(rms_after(&mut SaccadeAware::default()) < 0.05);
    assert!(rms_after(&mut OneEuro::default()) < 0.07);
}

/// On a steady ramp a low pass lags by its delay times the speed: the delay it reports must be that lag.
#[test]
fn the_reported_delay_is_the_lag_on_a_ramp() {
    let filters: [Box<dyn Filter>; 2] = [Box::<OneEuro>::default(), Box::<SaccadeAware>::default()];
    for mut filter in filters {
        let (mut lag_deg, speed_deg_s) = (0.0, 10.0);
        for ms in 0..2000_i64 {
            let deg = ms as f64 * 1e-3 * speed_deg_s;
            lag_deg = deg - deg_of(filter.apply(ms * 1_000_000, at_deg(deg), EyeState::Fixation));
        }
        let lag_ns = lag_deg / speed_deg_s * 1e9;
        let told_ns = filter.delay_ns() as f64;
        assert!((lag_ns - told_ns).abs() < 0.02 * told_ns, "{filter:?}: lags {lag_ns}, says {told_ns}");
    }
}

#[test]
fn a_chain_delays_by_the_sum() {
    let mut chain = FilterChain::new(vec![Box::<SaccadeAware>::default(), Box::<SaccadeAware>::default()]);
    for ms in 0..500 {
        chain.apply(ms * 1_000_000, at_deg(1.0), EyeState::Fixation);
    }
    assert_eq!(chain.delay_ns(), 100_000_000);
}

#[test]
fn a_saccade_passes_untouched() {
    let mut filter = SaccadeAware::default();
    for ms in 0..300 {
        filter.apply(ms * 1_000_000, at_deg(0.0), EyeState::Fixation);
    }
    let told = filter.apply(300_000_000, at_deg(3.0), EyeState::Saccade);
    assert_eq!((told, filter.delay_ns()), (at_deg(3.0), 0));
    // The fixation after it starts where the saccade ended, not where the last fixation was.
    let told = filter.apply(301_000_000, at_deg(9.0), EyeState::Fixation);
    assert!(deg_of(told) > 8.9, "{}", deg_of(told));
}

/// The step response of a first-order low pass at rest, in closed form: 1 - (1 - share)^n.
#[test]
fn one_euro_without_beta_is_a_first_order_low_pass() {
    let settings = OneEuroSettings { min_cutoff_hz: 2.0, beta_hz_per_deg_s: 0.0, speed_cutoff_hz: 1.0 };
    let mut filter = OneEuro::new(settings);
    filter.apply(0, at_deg(0.0), EyeState::Fixation);
    let share = 0.001 / (0.001 + 1.0 / (TAU * 2.0));
    for n in 1..100 {
        let told = deg_of(filter.apply(i64::from(n) * 1_000_000, at_deg(1.0), EyeState::Fixation));
        assert!((told - (1.0 - (1.0 - share).powi(n))).abs() < 1e-4, "{n}: {told}");
    }
}

#[test]
fn a_gap_starts_anew() {
    let filters: [Box<dyn Filter>; 2] = [Box::<OneEuro>::default(), Box::<SaccadeAware>::default()];
    for mut filter in filters {
        filter.apply(0, at_deg(0.0), EyeState::Fixation);
        assert_eq!(filter.apply(3_000_000_000, at_deg(20.0), EyeState::Fixation), at_deg(20.0));
        assert_eq!(filter.apply(i64::MIN, at_deg(1.0), EyeState::Fixation), at_deg(1.0));
    }
}
