//! The mapping of rectangular mapping-based foveated rendering (RMFR, Ye et al. 2022).
//!
//! Zhang et al. 2025 name its parameters (`f_x = 0.2 W`, `f_y = 0.2 H`, `delta = 2.6`) but no formula. The
//! authors describe it as motivated by the lens equation, and their published demonstration has, per axis
//! and side of the gaze, with `d` the distance from the gaze and `D` that of the display's edge:
//! share of the side's texels `N(d)/N(D)`, `N(d) = f d/(f + d)`. Each side keeps its share of the LP-buffer,
//! so that the gaze lies at the same place in it as on the display. That is what is built here.
//!
//! For a gaze off the display, of which the authors say nothing, the side that faces the display covers it
//! all and is continued: the share between the near edge at `G` and the far one is
//! `(N(d) - N(G))/(N(D) - N(G))`, which is the same formula with `f + G` for `f`.
//!
//! At 1440x1600 and 110 degrees the radial rate along the x axis lies below the acuity model from the
//! gaze to the edge, as Zhang et al. say. They add "especially in the tangential direction", which holds
//! here only within about 20 degrees.

use super::axes::AxesLayer;
use super::display::{DisplayGeometry, size_dvec2_px};
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use super::method::{below_one, gaze_in_use_px, reduced_columns, within};
use crate::error::Result;
use glam::DVec2;

/// Parameters of [`RmfrMapping`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RmfrParams {
    /// Focal length as a share of the display's width, 0.01..=100. Smaller: more texels near the gaze.
    pub focal_x_share: f64,
    /// Focal length as a share of the display's height, 0.01..=100.
    pub focal_y_share: f64,
    /// Display width over LP-buffer width, 1..=64. Larger: fewer samples.
    pub delta: f64,
}

impl RmfrParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`crate::error::Error::Setting`] for a parameter outside its range.
    pub fn check(&self) -> Result<()> {
        within("RMFR's horizontal focal length", self.focal_x_share, 0.01, 100.0)?;
        within("RMFR's vertical focal length", self.focal_y_share, 0.01, 100.0)?;
        within("RMFR's delta", self.delta, 1.0, 64.0)
    }
}

impl Default for RmfrParams {
    /// The original paper's values.
    fn default() -> Self {
        Self { focal_x_share: 0.2, focal_y_share: 0.2, delta: 2.6 }
    }
}

/// One axis on one side of the gaze: distances count away from the gaze.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side {
    /// Where the side begins: at the gaze, or at the edge nearest to it. px
    start_px: f64,
    /// Length, px; 0 where the side does not exist.
    length_px: f64,
    /// Focal length, and the gap between gaze and display, px.
    focal_px: f64,
}

impl Side {
    /// Share of the side's texels within a distance from its start.
    fn share(&self, distance_px: f64) -> f64 {
        let distance_px = distance_px.min(self.length_px);
        distance_px / self.length_px * ((self.focal_px + self.length_px) / (self.focal_px + distance_px))
    }

    fn distance_px(&self, share: f64) -> f64 {
        self.length_px * share * self.focal_px / (self.focal_px + self.length_px * (1.0 - share))
    }

    /// Per px.
    fn slope(&self, distance_px: f64) -> f64 {
        let reach_px = self.focal_px + distance_px;
        (self.focal_px + self.length_px) / reach_px * (self.focal_px / reach_px) / self.length_px
    }
}

/// One axis: a display coordinate to a share of the LP-buffer and back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Axis {
    length_px: f64,
    lower: Side,
    upper: Side,
}

impl Axis {
    fn new(length_px: f64, gaze_px: f64, focal_share: f64) -> Self {
        let focal_px = focal_share * length_px;
        // On the display the gaze splits it; off the display one side has all of it.
        let start_px = gaze_px.clamp(0.0, length_px);
        let focal_px = focal_px + (gaze_px - start_px).abs();
        Self {
            length_px,
            lower: Side { start_px, length_px: start_px, focal_px },
            upper: Side { start_px, length_px: length_px - start_px, focal_px },
        }
    }

    fn split_share(&self) -> f64 {
        self.upper.start_px / self.length_px
    }

    fn share(&self, px: f64) -> f64 {
        let px = px.clamp(0.0, self.length_px);
        let split = self.split_share();
        let share = if px < self.lower.start_px {
            split * (1.0 - self.lower.share(self.lower.start_px - px))
        } else if self.upper.length_px > 0.0 {
            split + (1.0 - split) * self.upper.share(px - self.upper.start_px)
        } else {
            1.0
        };
        share.clamp(0.0, 1.0)
    }

    fn px(&self, share: f64) -> f64 {
        let share = share.clamp(0.0, 1.0);
        let split = self.split_share();
        if share < split {
            self.lower.start_px - self.lower.distance_px((split - share) / split)
        } else if split < 1.0 {
            self.upper.start_px + self.upper.distance_px((share - split) / (1.0 - split))
        } else {
            self.length_px
        }
    }

    /// Share per px; 0 off the display. At the gaze that of the upper side.
    fn slope(&self, px: f64) -> f64 {
        if !(0.0..=self.length_px).contains(&px) {
            return 0.0;
        }
        let (side, distance_px) = if px < self.lower.start_px || self.upper.length_px == 0.0 {
            (&self.lower, self.lower.start_px - px)
        } else {
            (&self.upper, px - self.upper.start_px)
        };
        side.slope(distance_px) * side.length_px / self.length_px
    }
}

/// RMFR's mapping of one frame: u from x and v from y, not polar, `w = W/delta` and `h = H/delta` rounded,
/// all columns of equal height. Positions off the display are clamped to its edge.
///
/// No pixel is native: the mapping is not singular at the gaze. With the default parameters the gaze at
/// the display's centre has 1.35 texels per px on each axis, so that the gazed pixel is interpolated
/// between samples of its own; nearer than 0.32 of the display to an edge the side towards that edge has
/// less than one, down to 0.38.
#[derive(Clone, Debug)]
pub struct RmfrMapping {
    display: DisplayGeometry,
    params: RmfrParams,
    columns: ColumnLayout,
    /// Width and height of the LP-buffer, texels.
    size: DVec2,
    gaze_px: DVec2,
    axes: [Axis; 2],
    axes_layers: [AxesLayer; 1],
}

impl RmfrMapping {
    /// The mapping for a checked display, checked parameters and a gaze on the display or off it. A gaze
    /// farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken as the
    /// display's centre.
    #[must_use]
    pub fn new(display: DisplayGeometry, gaze_px: DVec2, params: RmfrParams) -> Self {
        debug_assert!(params.check().is_ok(), "the parameters are checked by the settings");
        let columns = reduced_columns(display.size_px, params.delta);
        let size = size_dvec2_px(columns.size());
        let axes_layers = [AxesLayer { first_column: 0, rows: columns.size()[1] }];
        let mut mapping =
            Self { display, params, columns, size, gaze_px, axes: Default::default(), axes_layers };
        mapping.retarget(gaze_px);
        mapping
    }

    /// The one layer.
    pub(super) fn axes_layers(&self) -> &[AxesLayer] {
        &self.axes_layers
    }

    /// Changes the gaze; the LP-buffer keeps its size, and nothing is allocated.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.gaze_px = gaze_in_use_px(self.display.size_px, gaze_px);
        let size_px = size_dvec2_px(self.display.size_px);
        self.axes = [
            Axis::new(size_px.x, self.gaze_px.x, self.params.focal_x_share),
            Axis::new(size_px.y, self.gaze_px.y, self.params.focal_y_share),
        ];
    }

    /// Where the two sides of each axis part, px: the gaze, and for one off the display the edge nearest
    /// to it. It has the same share of the LP-buffer as of the display.
    #[must_use]
    pub fn split_px(&self) -> DVec2 {
        let [x, y] = &self.axes;
        DVec2::new(x.upper.start_px, y.upper.start_px)
    }

    /// Focal length of each axis and the gap between gaze and display, px: with the distance `d` from
    /// [`Self::split_px`] and the side's length `D`, `d (f + D) / (D (f + d))` of the side's texels lie
    /// within `d`.
    #[must_use]
    pub fn focal_px(&self) -> DVec2 {
        let [x, y] = &self.axes;
        DVec2::new(x.upper.focal_px, y.upper.focal_px)
    }
}

impl Mapping for RmfrMapping {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }

    fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, _u: f64) -> f64 {
        self.size.y
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let [x, y] = &self.axes;
        Some(LpPoint { u: self.size.x * x.share(px.x), v_share: below_one(y.share(px.y)) })
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let [x, y] = &self.axes;
        Some(DVec2::new(x.px(point.u / self.size.x), y.px(point.v_share)))
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let [x, y] = &self.axes;
        Some(TexelJacobian {
            du_dx: self.size.x * x.slope(px.x),
            du_dy: 0.0,
            dv_dx: 0.0,
            dv_dy: self.size.y * y.slope(px.y),
        })
    }

    fn is_native(&self, _px: DVec2) -> bool {
        false
    }
}
