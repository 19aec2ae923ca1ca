//! The contact sheet: every rendered frame small, with where the gaze was taken to be and where it was.

use glam::DVec2;
use image::imageops::{FilterType, overlay, resize};
use image::{Rgba, RgbaImage};

/// Width of a frame on the sheet, px.
const TILE_PX: u32 = 320;
/// Between frames, and the width of a frame's border, px.
const GAP_PX: u32 = 6;
/// The most frames that a sheet holds: 8 rows of 8.
pub const MOST_TILES: usize = 64;

const BACKGROUND: Rgba<u8> = Rgba([24, 24, 28, 255]);
const USED: Rgba<u8> = Rgba([255, 40, 40, 255]);
const TRUE: Rgba<u8> = Rgba([255, 255, 255, 255]);
const DARK: Rgba<u8> = Rgba([0, 0, 0, 255]);

/// How a frame fared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The true gaze lay within the radius of full quality.
    Inside,
    /// It lay outside.
    Outside,
    /// Not judged: a saccade, its suppression, a blink, or the truth is not known.
    NotCounted,
}

impl Verdict {
    fn color(self) -> Rgba<u8> {
        match self {
            Self::Inside => Rgba([70, 190, 110, 255]),
            Self::Outside => Rgba([255, 150, 40, 255]),
            Self::NotCounted => Rgba([110, 110, 120, 255]),
        }
    }
}

/// A frame on the sheet.
pub struct Tile {
    picture: RgbaImage,
}

impl Tile {
    /// Of a picture in RGBA, 8 bits each; the points as fractions of the display. `None` where the size
    /// is not that of the picture.
    pub fn new(
        size: [u32; 2],
        rgba8: Vec<u8>,
        verdict: Verdict,
        used: Option<DVec2>,
        truth: Option<DVec2>,
    ) -> Option<Self> {
        let picture = RgbaImage::from_raw(size[0], size[1], rgba8)?;
        let height = (f64::from(TILE_PX) * f64::from(size[1]) / f64::from(size[0])).round().max(1.0) as u32;
        let small = resize(&picture, TILE_PX, height, FilterType::Triangle);
        let border = 2 * GAP_PX;
        let mut framed = RgbaImage::from_pixel(TILE_PX + border, height + border, verdict.color());
        overlay(&mut framed, &small, i64::from(GAP_PX), i64::from(GAP_PX));
        if let Some(truth) = truth {
            mark(&mut framed, [TILE_PX, height], truth, TRUE, |dx, dy| (dx * dx + dy * dy - 64).abs() <= 12);
        }
        if let Some(used) = used {
            mark(&mut framed, [TILE_PX, height], used, USED, |dx, dy| dx == 0 || dy == 0);
        }
        Some(Self { picture: framed })
    }
}

/// Colours what `part_of` says of the surroundings of a point, with a dark edge.
fn mark(
    tile: &mut RgbaImage,
    inner: [u32; 2],
    at: DVec2,
    color: Rgba<u8>,
    part_of: impl Fn(i64, i64) -> bool,
) {
    const REACH: i64 = 9;
    let centre = (at * DVec2::from_array(inner.map(f64::from))).round() + f64::from(GAP_PX);
    // Far off the display, or not finite: there is nothing to draw, and no integer to hold it.
    if !centre.is_finite() || centre.abs().max_element() > 1e6 {
        return;
    }
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let near = (-1..=1).any(|y| (-1..=1).any(|x| part_of(dx + x, dy + y)));
            let color = if part_of(dx, dy) { color } else { DARK };
            let place = [centre.x as i64 + dx, centre.y as i64 + dy].map(u32::try_from);
            let [Ok(x), Ok(y)] = place else { continue };
            if near && x < tile.width() && y < tile.height() {
                tile.put_pixel(x, y, color);
            }
        }
    }
}

/// All tiles, in rows from the top left: size and RGBA. `None` where there is none.
pub fn sheet(tiles: &[Tile]) -> Option<([u32; 2], Vec<u8>)> {
    let first = &tiles.first()?.picture;
    let columns = (tiles.len() as f64).sqrt().ceil() as u32;
    let rows = u32::try_from(tiles.len()).ok()?.div_ceil(columns);
    let step = [first.width() + GAP_PX, first.height() + GAP_PX];
    let mut whole = RgbaImage::from_pixel(columns * step[0] + GAP_PX, rows * step[1] + GAP_PX, BACKGROUND);
    for (index, tile) in (0..).zip(tiles) {
        let x = GAP_PX + index % columns * step[0];
        let y = GAP_PX + index / columns * step[1];
        overlay(&mut whole, &tile.picture, i64::from(x), i64::from(y));
    }
    Some(([whole.width(), whole.height()], whole.into_raw()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(verdict: Verdict, used: Option<DVec2>, truth: Option<DVec2>) -> Tile {
        Tile::new([64, 32], vec![128; 64 * 32 * 4], verdict, used, truth).expect("a tile")
    }

    #[test]
    fn marks_lie_where_the_gaze_is() {
        let tile = grey(Verdict::Inside, Some(DVec2::new(0.25, 0.5)), Some(DVec2::new(0.75, 0.5)));
        assert_eq!(tile.picture.get_pixel(GAP_PX + 80, GAP_PX + 80), &USED);
        // The ring is hollow, its radius 8.
        assert_eq!(tile.picture.get_pixel(GAP_PX + 240, GAP_PX + 80)[0], 128);
        assert_eq!(tile.picture.get_pixel(GAP_PX + 248, GAP_PX + 80), &TRUE);
        assert_eq!(tile.picture.get_pixel(0, 0), &Verdict::Inside.color());
    }

    #[test]
    fn a_gaze_off_the_display_marks_nothing_within() {
        let plain = grey(Verdict::Outside, None, None);
        for off in [DVec2::new(-3.0, 0.5), DVec2::splat(1e300), DVec2::NAN, DVec2::INFINITY] {
            assert!(grey(Verdict::Outside, Some(off), Some(off)).picture == plain.picture, "{off}");
        }
    }

    #[test]
    fn the_sheet_holds_every_tile() {
        assert!(sheet(&[]).is_none());
        let tiles: Vec<_> = (0..5).map(|_| grey(Verdict::NotCounted, None, None)).collect();
        let (size, pixels) = sheet(&tiles).expect("a sheet");
        // Three columns and two rows.
        assert_eq!(size, [3 * (332 + 6) + 6, 2 * (172 + 6) + 6]);
        let border = Verdict::NotCounted.color();
        let count = pixels.chunks_exact(4).filter(|pixel| *pixel == border.0).count();
        assert_eq!(count, 5 * (332 * 172 - 320 * 160));
    }
}
