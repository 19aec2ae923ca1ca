//! The mapping of the method in use: what the shaders are given of it, each frame anew.

use crate::fovea::{
    ColumnRow, DisplayGeometry, FORWARD_KNOTS, ForwardKnot, FoveaParams, Kernel, KfrMapping, Mapping,
    VafrMapping, fill_columns, fill_forward,
};
use crate::passes::{FrameBuffers, LpRoom};
use crate::settings::{KfrSettings, LpFilter, Method, RenderSettings};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// How the shaders map; the values of `MAPPING_KIND` in `shaders/shared/mapping.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MappingKind {
    Kernel = 0,
    Radial = 1,
}

/// The mapping in use.
pub(super) struct Foveation {
    display: DisplayGeometry,
    active: Active,
    lp_filter: LpFilter,
    room: LpRoom,
    /// The native box of any gaze on the display is at most as large, px.
    widest_box_px: [u32; 2],
    /// Kept to allocate nothing.
    knots: Vec<ForwardKnot>,
    rows: Vec<ColumnRow>,
}

enum Active {
    /// Full shading; the block is still bound.
    None,
    Kernel(KfrSettings),
    Vafr(Box<VafrMapping>),
}

impl Foveation {
    /// For checked settings.
    pub(super) fn new(settings: &RenderSettings) -> Self {
        let display = settings.display;
        let centre = display.center_px();
        let active = match &settings.method {
            Method::Full => Active::None,
            Method::Kfr(kfr) => Active::Kernel(kfr.clone()),
            Method::Vafr(vafr) => Active::Vafr(Box::new(VafrMapping::new(
                vafr.form,
                &display,
                centre,
                &Arc::new(vafr.acuity.clone()),
            ))),
        };
        let room = LpRoom { size: [1, 1], texels: 1, native: 0, table_rows: 1, knots: 1 };
        let mut made = Self {
            display,
            active,
            lp_filter: settings.method.lp_filter(),
            room,
            widest_box_px: [0, 0],
            knots: Vec::new(),
            rows: Vec::new(),
        };
        made.make_room();
        made
    }

    fn make_room(&mut self) {
        let [width, height] = self.display.size_px.map(u64::from);
        match &self.active {
            Active::None => {}
            Active::Kernel(kfr) => {
                let size =
                    KfrMapping::new(self.display.size_px, self.display.center_px(), kfr.kernel, kfr.sigma)
                        .lp_size();
                let texels = u64::from(size[0]) * u64::from(size[1]);
                self.room = LpRoom {
                    size,
                    texels,
                    native: (width * height).min(texels / 2 + KFR_NATIVE_ROOM),
                    table_rows: 2 * u64::from(size[0]) + u64::from(size[1]),
                    knots: 1,
                };
            }
            Active::Vafr(mapping) => {
                let columns = mapping.columns();
                self.room = LpRoom {
                    size: columns.size(),
                    texels: columns.texels(),
                    native: 0,
                    table_rows: 2 * columns.heights().len() as u64,
                    knots: FORWARD_KNOTS as u64,
                };
                self.rows = vec![[[0.0; 4]; 2]; columns.heights().len()];
                self.knots = vec![[0.0; 2]; FORWARD_KNOTS];
            }
        }
        self.widest_box_px = self.find_widest_box_px();
        if self.room.native == 0 && !matches!(self.active, Active::None) {
            let [box_width, box_height] = self.widest_box_px.map(u64::from);
            self.room.native = (box_width * box_height).min(width * height);
        }
    }

    pub(super) fn kind(&self) -> MappingKind {
        match self.active {
            Active::None | Active::Kernel(_) => MappingKind::Kernel,
            Active::Vafr(_) => MappingKind::Radial,
        }
    }

    pub(super) fn room(&self) -> LpRoom {
        self.room
    }

    /// Room for the native box of any gaze on the display, px.
    pub(super) fn widest_box_px(&self) -> [u32; 2] {
        self.widest_box_px
    }

    /// Of gazes on a grid over the display: the box changes slowly with the gaze, and is greatest for the
    /// centre, the edges' middles or the corners. A little is added for what lies between.
    fn find_widest_box_px(&mut self) -> [u32; 2] {
        let size = DVec2::from_array(self.display.size_px.map(f64::from));
        let mut widest = [0, 0];
        for index in 0..25 {
            let share = DVec2::new(f64::from(index % 5), f64::from(index / 5)) / 4.0;
            let [x0, y0, x1, y1] = self.params(share * size).native_box;
            widest = [widest[0].max(x1 - x0), widest[1].max(y1 - y0)];
        }
        let [width, height] = self.display.size_px;
        let grown = widest.map(|side| side as u32 + side as u32 / 16 + 2);
        [grown[0].min(width), grown[1].min(height)]
    }

    /// The block for a gaze.
    pub(super) fn params(&mut self, gaze_px: DVec2) -> FoveaParams {
        let mut params = match &mut self.active {
            Active::None => {
                FoveaParams::new(&KfrMapping::new(self.display.size_px, gaze_px, Kernel::Sine, 1.0))
            }
            Active::Kernel(kfr) => kernel_params(&self.display, kfr, self.room.native, gaze_px),
            Active::Vafr(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_radial(mapping.as_ref(), mapping.native_box_px(), self.room.size[1])
            }
        };
        // KFR's Gaussian leaves out the columns whose texels are finer than a pixel or little coarser.
        match (self.lp_filter, &self.active) {
            (LpFilter::None, _) => params.ring[2] = 1.0,
            (LpFilter::Gaussian, Active::Kernel(_)) => {}
            (LpFilter::Gaussian | LpFilter::Fxaa, _) => params.ring[2] = 0.0,
        }
        params
    }

    /// Texels of the columns that a block uses.
    pub(super) fn texels_in_use(&self, params: &FoveaParams) -> u64 {
        match &self.active {
            Active::None | Active::Kernel(_) => u64::from(params.size[2]) * u64::from(params.size[3]),
            Active::Vafr(mapping) => mapping.columns().offsets()[params.size[2] as usize],
        }
    }

    /// Writes what does not depend on the gaze, once for each frame slot.
    pub(super) fn write_tables(&mut self, buffers: &mut FrameBuffers) {
        if let Active::Vafr(mapping) = &self.active {
            fill_columns(mapping.as_ref(), &mut self.rows);
            fill_forward(mapping.as_ref(), &mut self.knots);
            for (tables, forward) in buffers.lp_tables.iter_mut().zip(&mut buffers.forward_tables) {
                tables.write(0, &self.rows);
                forward.write(0, &self.knots);
            }
        }
    }
}

/// Native pixels for which KFR's sample list has room on top of half the LP-buffer's texels. Inside the
/// mapping's own disc there are fewer pixels than texels, and a disc holds a tenth of them at most in
/// the published settings; the disc is kept within this room.
const KFR_NATIVE_ROOM: u64 = 65536;

/// KFR's block, with its native disc.
fn kernel_params(display: &DisplayGeometry, kfr: &KfrSettings, room: u64, gaze_px: DVec2) -> FoveaParams {
    let mapping = KfrMapping::new(display.size_px, gaze_px, kfr.kernel, kfr.sigma);
    let disc_px = native_radius_px(display, gaze_px, mapping.native_radius_px());
    let most_px = ((room as f64 / PI).sqrt() - 1.0).max(0.0);
    FoveaParams::new(&mapping).with_disc(disc_px.min(most_px))
}

/// Eccentricity that KFR's native disc should cover, degrees: the fovea and the parafovea.
const NATIVE_DEG: f64 = 5.0;

/// How much the disc may grow beyond the radius inside which texels are smaller than pixels. Farther
/// out the mapping was asked to be coarse.
const NATIVE_GROWTH: f64 = 1.5;

/// Radius of KFR's native disc, px: the mapping's own, or a little more where the gaze is off the view
/// axis and a degree holds more pixels than at the display's centre.
fn native_radius_px(display: &DisplayGeometry, gaze_px: DVec2, mapping_px: f64) -> f64 {
    let gaze = display.ray_of_px(gaze_px).normalize();
    // Pixels to a degree grow away from the view axis, so the farthest point of the cone around the
    // gaze lies on the side that is away from it.
    let outwards = (gaze.truncate().extend(0.0)).reject_from_normalized(gaze).normalize_or(DVec3::X);
    let edge = gaze + outwards * NATIVE_DEG.to_radians().tan();
    let wanted_px = display.px_of_ray(edge).map_or(f64::INFINITY, |px| px.distance(gaze_px));
    mapping_px.max(wanted_px.min(NATIVE_GROWTH * mapping_px))
}
