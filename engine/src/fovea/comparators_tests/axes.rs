//! The two methods by axes.

use super::*;

// --- RMFR ----------------------------------------------------------------------------------------

#[test]
fn rmfr_is_the_authors_demonstration() {
    let size_px = DVec2::new(1440.0, 1600.0);
    let display = DisplayGeometry::symmetric([1440, 1600], 110.0);
    for gaze_share in [DVec2::splat(0.5), DVec2::new(0.1, 0.7), DVec2::new(0.93, 0.02)] {
        let mapping = RmfrMapping::new(display, gaze_share * size_px, RmfrParams::default());
        let size = DVec2::new(554.0, 615.0);
        assert_eq!(mapping.columns().size(), [554, 615]);
        // The demonstration, in shares of the display: where a texel of the LP-buffer looks.
        let display_share = |share: f64, gaze: f64| {
            let reach = if share >= gaze { 1.0 - gaze } else { gaze };
            let scaled = (share - gaze).abs() / reach * (0.2 * reach / (0.2 + reach));
            gaze + (share - gaze).signum() * 0.2 * scaled / (0.2 - scaled)
        };
        for index in 0..2000_u32 {
            let share = DVec2::new(f64::from(index * 37 % 2003), f64::from(index * 101 % 2011)) / 2011.0;
            let px = size_px
                * DVec2::new(display_share(share.x, gaze_share.x), display_share(share.y, gaze_share.y));
            let point = LpPoint { u: share.x * size.x, v_share: share.y };
            let looked_at = mapping.inverse(point).expect("rectangular");
            assert!((looked_at - px).length() < 1e-9, "{share}: {looked_at} {px}");
        }
        // Texels per px at the gaze, towards the right: (f + D)/(f delta).
        let slope = mapping.jacobian(mapping.gaze_px()).expect("everywhere").du_dx;
        assert!((slope * 1440.0 / 554.0 - (1.2 - gaze_share.x) / 0.2).abs() < 1e-9);
        // What a shader needs: where the sides part, and their focal lengths.
        assert!((mapping.split_px() - gaze_share * size_px).length() < 1e-9);
        assert!((mapping.focal_px() - 0.2 * size_px).length() < 1e-9);
        let at_gaze = mapping.forward(mapping.gaze_px()).expect("texels");
        assert!((at_gaze.u / size.x - gaze_share.x).abs() < 1e-12 && !mapping.is_native(mapping.gaze_px()));
    }
}

#[test]
fn rmfr_covers_the_display_evenly_rising_for_any_gaze() {
    let display = DisplayGeometry::symmetric([1440, 1600], 110.0);
    for gaze_px in hard_gazes(display.size_px) {
        let mapping = RmfrMapping::new(display, gaze_px, RmfrParams::default());
        let at = |share: f64| mapping.forward(share * DVec2::new(1440.0, 1600.0)).expect("texels");
        assert_eq!((at(0.0).u, at(0.0).v_share, at(1.0).u), (0.0, 0.0, 554.0));
        assert!(at(1.0).v_share > 1.0 - 1e-15);
        for step in 1..=3000 {
            let (before, after) = (at(f64::from(step - 1) / 3000.0), at(f64::from(step) / 3000.0));
            let rise = DVec2::new((after.u - before.u) / 554.0, after.v_share - before.v_share) * 3000.0;
            // The steepest slope is (f + D)/f = 6, at a gaze on an edge; far away all is even.
            assert!(rise.min_element() > 0.1 && rise.max_element() < 6.0, "{gaze_px}: {rise}");
        }
    }
    let aside = RmfrMapping::new(display, DVec2::new(2440.0, -7.0), RmfrParams::default());
    assert!((aside.split_px() - DVec2::new(1440.0, 0.0)).length() < 1e-9);
    assert!((aside.focal_px() - DVec2::new(1288.0, 327.0)).length() < 1e-9);
    // From afar the lens is flat.
    let far = RmfrMapping::new(display, DVec2::new(-1e7, 800.0), RmfrParams::default());
    assert!((far.forward(DVec2::new(360.0, 1.0)).expect("texels").u / 554.0 - 0.25).abs() < 1e-4);
}

#[test]
fn rmfr_lies_below_acuity_along_the_x_axis() {
    let display = DisplayGeometry::symmetric([1440, 1600], 110.0);
    let mapping = RmfrMapping::new(display, display.center_px(), RmfrParams::default());
    for eccentricity_deg in 1..55 {
        let eccentricity_deg = f64::from(eccentricity_deg);
        let rates = rates_at(&mapping, eccentricity_deg);
        assert!(rates.radial_cpd < 0.6 * acuity_cpd(eccentricity_deg).min(11.0), "{rates:?}");
        assert!(eccentricity_deg > 18.0 || rates.tangential_cpd < acuity_cpd(eccentricity_deg));
    }
}

// --- Guenter's layers ----------------------------------------------------------------------------

/// Samples of the three layers, as drawn: inner, middle, outer.
fn layer_samples(mapping: &GuenterMapping) -> [f64; 3] {
    let [low, high] = mapping.native_rect_px();
    let native = (high - low).x * (high - low).y;
    let [middle, outer] = mapping.layers().map(|layer| f64::from(layer.size[0]) * f64::from(layer.size[1]));
    [native, middle, outer]
}

#[test]
fn guenter_saves_what_its_authors_report() {
    // Their display: 1920x1080, 51 cm wide, seen from 59 cm.
    let display = DisplayGeometry::symmetric([1920, 1080], 2.0 * (25.5_f64 / 59.0).atan().to_degrees());
    for slope_arcmin_per_deg in [1.32, 1.65] {
        let params = GuenterParams { slope_arcmin_per_deg, ..GuenterParams::default() };
        let mapping = GuenterMapping::new(display, display.center_px(), params);
        let [native, middle, outer] = layer_samples(&mapping);
        // The middle and the outer layer take turns.
        let reduction = 1920.0 * 1080.0 / (native + (middle + outer) / 2.0);
        assert!((9.9..15.0).contains(&reduction), "{slope_arcmin_per_deg}: {reduction}");
    }
}

#[test]
fn guenter_borders_need_the_fewest_samples() {
    for (size_px, hfov_deg) in [([1920, 1080], 47.0), ([2560, 1440], 100.0), ([11520, 6480], 120.0)] {
        let display = DisplayGeometry::symmetric(size_px, hfov_deg);
        let mapping = GuenterMapping::new(display, display.center_px(), GuenterParams::default());
        let [width, height] = size_px.map(f64::from);
        let focal_px = width / 2.0 / (hfov_deg / 2.0).to_radians().tan();
        let count = |inner_deg: f64, middle_deg: f64| {
            let area = |deg: f64| {
                let side = 2.0 * focal_px * deg.to_radians().tan();
                side.min(width) * side.min(height)
            };
            let factor =
                |deg: f64| ((1.32 / 60.0 * deg + 1.0 / 48.0) / (2.0 / focal_px).atan().to_degrees()).max(1.0);
            area(inner_deg)
                + area(middle_deg) / factor(inner_deg).powi(2)
                + width * height / factor(middle_deg).powi(2)
        };
        let [inner_deg, middle_deg] = mapping.borders_deg();
        let found = count(inner_deg, middle_deg);
        for step in 0..200_u32 * 200 {
            let (inner, middle) = (f64::from(step / 200) * 0.25, f64::from(step % 200) * 0.25);
            assert!(inner > middle || count(inner, middle) >= 0.9999 * found, "{inner} {middle}");
        }
        let drawn: f64 = layer_samples(&mapping).iter().sum();
        assert!((drawn / found - 1.0).abs() < 0.01, "{drawn} {found}");
        let [middle, outer] = mapping.layers();
        let coarse = |layer: GuenterLayer| layer.px_per_texel.max_element();
        assert!(1.0 < coarse(middle) && coarse(middle) < coarse(outer));
    }
}

#[test]
fn guenter_resolves_its_mar_everywhere() {
    let anisotropic =
        DisplayGeometry { size_px: [2000, 3000], ..DisplayGeometry::symmetric([2560, 1440], 90.0) };
    for display in [DisplayGeometry::symmetric([2560, 1440], 100.0), anisotropic] {
        let params = GuenterParams::default();
        let mapping = GuenterMapping::new(display, display.center_px(), params);
        let size_px = 2.0 * display.center_px();
        for step in 0..5000_u32 {
            let share = DVec2::new(f64::from(step * 61 % 5003), f64::from(step * 709 % 5009)) / 5009.0;
            let px = share * size_px;
            let eccentricity_deg = display.eccentricity_rad(mapping.gaze_px(), px).to_degrees();
            let Some(rates) = mapping.rates(px) else { continue };
            // The display's own rate where that is lower, as in the inner layer.
            let needed = 0.999 / params.mar_deg(eccentricity_deg);
            let enough = rates.radial_cpd >= needed && rates.tangential_cpd >= needed;
            assert!(enough || mapping.is_native(px), "{eccentricity_deg}: {rates:?} {needed}");
        }
    }
}

#[test]
fn guenter_layers_follow_the_gaze_and_end_at_the_edge() {
    let display = DisplayGeometry::symmetric([2560, 1440], 100.0);
    let size_px = DVec2::new(2560.0, 1440.0);
    for gaze_px in hard_gazes(display.size_px) {
        let mapping = GuenterMapping::new(display, gaze_px, GuenterParams::default());
        let [middle, outer] = mapping.layers();
        let heights = mapping.columns().heights();
        assert_eq!(heights.len(), (middle.size[0] + outer.size[0]) as usize);
        assert_eq!((outer.first_column, outer.origin_px), (middle.size[0], DVec2::ZERO));
        assert!((outer.extent_px() - size_px).length() < 1e-9);
        let [low, high] = mapping.native_rect_px();
        assert!(low.cmpge(DVec2::ZERO).all() && high.cmple(size_px).all());
        for step in 0..4000_u32 {
            let px = DVec2::new(f64::from(step * 7919 % 2560), f64::from(step * 104_729 % 1440)) + 0.5;
            let point = mapping.forward(px).expect("texels");
            let in_middle = middle.covers(px);
            assert_eq!(point.u < f64::from(middle.size[0]), in_middle, "{px}");
            assert!((mapping.inverse(point).expect("a layer") - px).length() < 1e-6);
            let native = px.x >= low.x && px.y >= low.y && px.x < high.x && px.y < high.y;
            assert_eq!(mapping.is_native(px), native);
            assert!(in_middle || !native, "the middle layer lies around the inner one");
            let height = heights[point.u.min(heights.len() as f64 - 1.0) as usize];
            assert_eq!(mapping.column_height(point.u), f64::from(height));
        }
        if display.farthest_corner_px(mapping.gaze_px()) < size_px.length() {
            assert!(mapping.is_native(mapping.gaze_px().clamp(DVec2::ZERO, size_px - 1.0)), "{gaze_px}");
        }
    }
    let mapping = GuenterMapping::new(display, display.center_px(), GuenterParams::default());
    let [native_band, middle_band] = mapping.blend_bands_px();
    assert!((1.0..=8.0).contains(&native_band) && middle_band > native_band);
    let full_turn = LpPoint { u: TAU, v_share: 1.0 };
    assert!(mapping.inverse(full_turn).is_some_and(|px| px.y <= mapping.layers()[0].origin_px.y + 1440.0));
}
