//! Each check finds what is wrong with a mapping that has one thing wrong with it.

use super::super::family::Finding;
use super::super::subject::methods;
use super::{Situation, layout, rate, round_trip, shape};
use glam::DVec2;
use macula::fovea::{ColumnLayout, DisplayGeometry, LpPoint, Mapping, Rates, TexelJacobian};

/// A sound mapping, but for one result.
struct Planted {
    sound: Box<dyn Mapping>,
    columns: ColumnLayout,
    fault: Fault,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    /// Back to a place a thousandth of a pixel off.
    InverseOff,
    /// The Jacobian is 3 % too large.
    JacobianOff,
    /// A rate is 3 % too high.
    RateOff,
    /// u is NaN in one row.
    NotFinite,
    /// u falls beyond 100 px from the gaze.
    Falls,
    /// v is a hundredth of a turn farther below the gaze than above it.
    Seam,
    /// No pixel is native.
    NothingNative,
    /// A column has a texel too many.
    Height,
}

impl Mapping for Planted {
    fn display(&self) -> &DisplayGeometry {
        self.sound.display()
    }

    fn gaze_px(&self) -> DVec2 {
        self.sound.gaze_px()
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, u: f64) -> f64 {
        self.sound.column_height(u)
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let mut point = self.sound.forward(px)?;
        let offset = px - self.gaze_px();
        match self.fault {
            Fault::NotFinite if px.y == 0.5 => point.u = f64::NAN,
            Fault::Falls if offset.length() > 100.0 => point.u -= 5.0,
            Fault::Seam if offset.y > 0.0 => point.v_share = (point.v_share + 0.01) % 1.0,
            _ => {}
        }
        Some(point)
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let off_px = if self.fault == Fault::InverseOff { 1e-3 } else { 0.0 };
        Some(self.sound.inverse(point)? + DVec2::new(0.0, off_px))
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let sound = self.sound.jacobian(px)?;
        let scale = if self.fault == Fault::JacobianOff { 1.03 } else { 1.0 };
        Some(TexelJacobian { du_dx: sound.du_dx * scale, du_dy: sound.du_dy * scale, ..sound })
    }

    fn is_native(&self, px: DVec2) -> bool {
        self.fault != Fault::NothingNative && self.sound.is_native(px)
    }

    fn rates(&self, px: DVec2) -> Option<Rates> {
        let sound = self.sound.rates(px)?;
        let scale = if self.fault == Fault::RateOff { 1.03 } else { 1.0 };
        Some(Rates { tangential_cpd: sound.tangential_cpd * scale, ..sound })
    }
}

type Check = fn(&Situation, &dyn Mapping, &mut Finding);

/// What a check finds with KFR on a common display.
fn found(fault: Fault, check: Check) -> Finding {
    let display = DisplayGeometry::symmetric([640, 360], 90.0);
    let gaze_px = DVec2::new(236.5, 219.5);
    let subject = methods().into_iter().find(|subject| subject.name == "kfr").expect("KFR");
    let sound = subject.mapping(&display, gaze_px).expect("a mapping");
    let mut heights = sound.columns().heights().to_vec();
    if fault == Fault::Height {
        heights[7] += 1;
    }
    let mapping = Planted { sound, columns: ColumnLayout::new(heights), fault };
    let situation = Situation { subject, display, gaze_px, id: "planted".to_owned() };
    let mut finding = Finding::default();
    check(&situation, &mapping, &mut finding);
    finding
}

fn seam(_: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    shape::across_seam(mapping, mapping.gaze_px() + DVec2::X * 200.0, 1e-3, finding);
}

/// Each check with its family's bound and the faults that it must find.
const CHECKS: [(Check, f64, &[Fault]); 10] = [
    (round_trip::pixels, 1e-6, &[Fault::InverseOff, Fault::NotFinite]),
    (round_trip::texels, 1e-6, &[Fault::InverseOff, Fault::Falls, Fault::Seam]),
    (round_trip::gazed_pixel, 1e-6, &[Fault::NothingNative]),
    (shape::finite, 0.0, &[Fault::NotFinite]),
    (shape::around_the_gaze, 1e-9, &[Fault::NothingNative]),
    (shape::monotone, 1e-9, &[Fault::Falls]),
    (seam, 1e-6, &[Fault::Seam]),
    (layout::columns, 0.5 + 1e-9, &[Fault::Height]),
    (rate::jacobian, 0.01, &[Fault::JacobianOff]),
    (rate::rates, 0.01, &[Fault::RateOff]),
];

#[test]
fn a_sound_mapping_passes_every_check() {
    for (index, (check, bound, _)) in CHECKS.into_iter().enumerate() {
        let finding = found(Fault::None, check);
        assert!(finding.worst <= bound && finding.broken.is_none(), "check {index}: {finding:?}");
        assert!(finding.checks > 0, "check {index} compares nothing");
    }
}

#[test]
fn planted_faults_are_found() {
    for (index, (check, bound, faults)) in CHECKS.into_iter().enumerate() {
        for &fault in faults {
            let finding = found(fault, check);
            let caught = finding.worst > bound || finding.broken.is_some();
            assert!(caught, "check {index} misses fault {}: {finding:?}", fault as u8);
        }
    }
}
