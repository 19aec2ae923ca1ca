//! The mapping of the method in use: what the shaders are given of it, each frame anew.

use super::graph_of::mapping_spec;
use crate::error::Result;
use crate::fovea::{
    AxesMapping, ColumnLayout, ColumnRow, DisplayGeometry, FORWARD_KNOTS, ForwardKnot, FoveaParams,
    GuenterMapping, Kernel, KfrMapping, LafrMapping, Mapping, RadialMapping, RmfrMapping, VafrMapping,
    VisualPolarMapping, axes_knots, axes_table_rows, fill_axes_columns, fill_axes_forward, fill_columns,
    fill_forward,
};
use crate::gpu::Context;
use crate::passes::{FrameBuffers, LpRoom, PointMapper, PointRoom, PointTables, Way};
use crate::settings::{KfrSettings, LpFilter, Method, RenderSettings};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// How the shaders map; the values of `MAPPING_KIND` in `shaders/shared/mapping.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MappingKind {
    Kernel = 0,
    Radial = 1,
    Axes = 2,
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
    Lafr(Box<LafrMapping>),
    VisualPolar(Box<VisualPolarMapping>),
    Rmfr(Box<RmfrMapping>),
    Guenter(Box<GuenterMapping>),
}

impl Active {
    fn new(method: &Method, display: &DisplayGeometry) -> Self {
        let gaze_px = display.center_px();
        match method {
            Method::Full => Self::None,
            Method::Kfr(kfr) => Self::Kernel(kfr.clone()),
            Method::Vafr(vafr) => {
                let acuity = Arc::new(vafr.acuity.clone());
                Self::Vafr(Box::new(VafrMapping::new(vafr.form, display, gaze_px, &acuity)))
            }
            Method::Lafr(params) => Self::Lafr(Box::new(LafrMapping::new(*display, gaze_px, *params))),
            Method::VisualPolar(params) => {
                Self::VisualPolar(Box::new(VisualPolarMapping::new(*display, gaze_px, *params)))
            }
            Method::Rmfr(params) => Self::Rmfr(Box::new(RmfrMapping::new(*display, gaze_px, *params))),
            Method::Guenter(params) => {
                Self::Guenter(Box::new(GuenterMapping::new(*display, gaze_px, *params)))
            }
        }
    }

    /// The columns of the methods whose tables the CPU computes.
    fn columns(&self) -> Option<&ColumnLayout> {
        match self {
            Self::None | Self::Kernel(_) => None,
            Self::Vafr(mapping) => Some(mapping.columns()),
            Self::Lafr(mapping) => Some(mapping.columns()),
            Self::VisualPolar(mapping) => Some(mapping.columns()),
            Self::Rmfr(mapping) => Some(mapping.columns()),
            Self::Guenter(mapping) => Some(mapping.columns()),
        }
    }

    /// Rows of 16 bytes of the table by columns and rows, and knots of the forward table.
    fn table_sizes(&self) -> [usize; 2] {
        match self {
            Self::Rmfr(mapping) => [axes_table_rows(mapping.as_ref()), axes_knots(mapping.as_ref())],
            Self::Guenter(mapping) => [axes_table_rows(mapping.as_ref()), axes_knots(mapping.as_ref())],
            _ => [2 * self.columns().map_or(0, |columns| columns.heights().len()), FORWARD_KNOTS],
        }
    }

    /// The block for a gaze. `room`: native pixels, height of the LP-buffer's image.
    fn params(
        &mut self,
        display: &DisplayGeometry,
        (native, height): (u64, u32),
        gaze_px: DVec2,
    ) -> FoveaParams {
        match self {
            Self::None => FoveaParams::new(&KfrMapping::new(display.size_px, gaze_px, Kernel::Sine, 1.0)),
            Self::Kernel(kfr) => kernel_params(display, kfr, native, gaze_px),
            Self::Vafr(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_radial(mapping.as_ref(), height).with_box(mapping.native_box_px())
            }
            Self::Lafr(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_radial(mapping.as_ref(), height)
            }
            Self::VisualPolar(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_radial(mapping.as_ref(), height)
            }
            Self::Rmfr(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_axes(mapping.as_ref(), height)
            }
            Self::Guenter(mapping) => {
                mapping.retarget(gaze_px);
                FoveaParams::of_axes(mapping.as_ref(), height)
            }
        }
    }

    fn fill(&self, rows: &mut [ColumnRow], knots: &mut [ForwardKnot]) {
        match self {
            Self::None | Self::Kernel(_) => {}
            Self::Vafr(mapping) => fill_radial(mapping.as_ref(), rows, knots),
            Self::Lafr(mapping) => fill_radial(mapping.as_ref(), rows, knots),
            Self::VisualPolar(mapping) => fill_radial(mapping.as_ref(), rows, knots),
            Self::Rmfr(mapping) => fill_axes(mapping.as_ref(), rows, knots),
            Self::Guenter(mapping) => fill_axes(mapping.as_ref(), rows, knots),
        }
    }
}

fn fill_radial(mapping: &impl RadialMapping, rows: &mut [ColumnRow], knots: &mut [ForwardKnot]) {
    fill_columns(mapping, rows);
    fill_forward(mapping, knots);
}

fn fill_axes(mapping: &impl AxesMapping, rows: &mut [ColumnRow], knots: &mut [ForwardKnot]) {
    fill_axes_columns(mapping, rows);
    fill_axes_forward(mapping, knots);
}

impl Foveation {
    /// For checked settings.
    pub(super) fn new(settings: &RenderSettings) -> Self {
        let display = settings.display;
        let room = LpRoom { size: [1, 1], texels: 1, native: 0, table_rows: 1, knots: 1 };
        let mut made = Self {
            display,
            active: Active::new(&settings.method, &display),
            lp_filter: settings.method.lp_filter(),
            room,
            widest_box_px: [0, 0],
            knots: vec![[0.0; 2]],
            rows: Vec::new(),
        };
        made.make_room();
        made
    }

    fn make_room(&mut self) {
        let [width, height] = self.display.size_px.map(u64::from);
        if let Active::Kernel(kfr) = &self.active {
            let centre = self.display.center_px();
            let size = KfrMapping::new(self.display.size_px, centre, kfr.kernel, kfr.sigma).lp_size();
            let texels = u64::from(size[0]) * u64::from(size[1]);
            self.room = LpRoom {
                size,
                texels,
                native: (width * height).min(texels / 2 + KFR_NATIVE_ROOM),
                table_rows: 2 * u64::from(size[0]) + u64::from(size[1]),
                knots: 1,
            };
        } else if let Some(columns) = self.active.columns() {
            let (size, texels) = (columns.size(), columns.texels());
            let [rows, knots] = self.active.table_sizes();
            self.rows = vec![[[0.0; 4]; 2]; rows.div_ceil(2)];
            self.knots = vec![[0.0; 2]; knots];
            let table_rows = 2 * self.rows.len() as u64;
            self.room = LpRoom { size, texels, native: 0, table_rows, knots: knots as u64 };
        }
        self.widest_box_px = self.find_widest_box_px();
        if self.active.columns().is_some() {
            let [box_width, box_height] = self.widest_box_px.map(u64::from);
            self.room.native = (box_width * box_height).min(width * height);
        }
    }

    pub(super) fn kind(&self) -> MappingKind {
        match self.active {
            Active::None | Active::Kernel(_) => MappingKind::Kernel,
            Active::Vafr(_) | Active::Lafr(_) | Active::VisualPolar(_) => MappingKind::Radial,
            Active::Rmfr(_) | Active::Guenter(_) => MappingKind::Axes,
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
        let mut params = self.active.params(&self.display, (self.room.native, self.room.size[1]), gaze_px);
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
        let [_, _, columns, rows] = params.size;
        self.active
            .columns()
            .map_or(u64::from(columns) * u64::from(rows), |of| of.offsets()[columns as usize])
    }

    /// What maps single points for the method and display of this.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub(super) fn point_mapper(&self, context: &Arc<Context>, method: &Method) -> Result<PointMapper> {
        let room = PointRoom {
            table_bytes: 16 * self.room.table_rows,
            computed: self.kind() == MappingKind::Kernel,
            knots: self.room.knots,
        };
        PointMapper::new(context, &mapping_spec(self.kind(), method), room)
    }

    /// Maps points on the GPU for a gaze, as the passes do.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub(super) fn map_points(
        &mut self,
        mapper: &mut PointMapper,
        gaze_px: DVec2,
        way: Way,
        points: &[[f32; 4]],
    ) -> Result<Vec<[f32; 4]>> {
        let params = self.params(gaze_px);
        self.active.fill(&mut self.rows, &mut self.knots);
        let lp_tables = (self.kind() != MappingKind::Kernel).then_some(&self.rows[..]);
        mapper.map(&PointTables { params, lp_tables, forward: &self.knots }, way, points)
    }

    /// Writes the tables that do not depend on the gaze, once for each frame slot.
    pub(super) fn write_fixed_tables(&mut self, buffers: &mut FrameBuffers) {
        if matches!(self.active, Active::Vafr(_)) {
            for slot in 0..buffers.lp_tables.len() {
                self.write_tables(buffers, slot);
            }
        }
    }

    /// Writes the tables that follow the gaze of the last block.
    pub(super) fn write_gaze_tables(&mut self, buffers: &mut FrameBuffers, slot: usize) {
        if self.kind() != MappingKind::Kernel && !matches!(self.active, Active::Vafr(_)) {
            self.write_tables(buffers, slot);
        }
    }

    fn write_tables(&mut self, buffers: &mut FrameBuffers, slot: usize) {
        self.active.fill(&mut self.rows, &mut self.knots);
        buffers.lp_tables[slot].write(0, &self.rows);
        buffers.forward_tables[slot].write(0, &self.knots);
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
