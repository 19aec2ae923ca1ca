//! Radiance HDR (RGBE) files.
//!
//! Read here and not by the `image` crate: that one refuses the `#?RGBE` signature and flipped
//! pictures, and its run length arithmetic overflows on hostile input.

use super::read::{Decoded, Picture, check_size};

/// A header has a few short lines; a longer one is none.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// What is left of the file.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err("the file ends within its pixels; get a whole copy of it".into());
        };
        self.rest = rest;
        Ok(taken)
    }

    fn rgbe(&mut self) -> Result<[u8; 4], String> {
        let bytes = self.take(4)?;
        Ok([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    fn line(&mut self) -> Result<String, String> {
        let searched = &self.rest[..self.rest.len().min(MAX_HEADER_BYTES)];
        let Some(end) = searched.iter().position(|&byte| byte == b'\n') else {
            return Err("the header does not end; this is no Radiance HDR file".into());
        };
        let line = String::from_utf8_lossy(&self.rest[..end]).trim_end_matches('\r').to_owned();
        self.rest = &self.rest[end + 1..];
        Ok(line)
    }
}

/// Size and orientation from the line after the header.
struct Resolution {
    size: [usize; 2],
    bottom_up: bool,
    right_to_left: bool,
}

fn resolution(line: &str) -> Result<Resolution, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let parsed = |word: &str| word.parse::<u32>().ok().map(|side| side as usize);
    let broken = || format!("the resolution line {:?} is broken", line.chars().take(40).collect::<String>());
    let &[y, height, x, width] = words.as_slice() else {
        return Err(broken());
    };
    if !matches!((y, x), ("-Y" | "+Y", "+X" | "-X")) {
        return Err(format!("{}; rows along X are not supported, re-save it upright", broken()));
    }
    let size = [parsed(width).ok_or_else(broken)?, parsed(height).ok_or_else(broken)?];
    check_size(size)?;
    Ok(Resolution { size, bottom_up: y == "+Y", right_to_left: x == "-X" })
}

/// The lines up to the empty one: only the pixel format matters. `EXPOSURE` and `COLORCORR` are left
/// aside, as most programs do; they would only scale the whole picture.
fn skip_header(reader: &mut Reader<'_>) -> Result<(), String> {
    let length_before = reader.rest.len();
    loop {
        let line = reader.line()?;
        if line.is_empty() {
            return Ok(());
        }
        if let Some(format) = line.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            return Err(format!(
                "pixel format {:?} is not supported; re-save it as 32-bit_rle_rgbe",
                format.chars().take(40).collect::<String>()
            ));
        }
        if length_before - reader.rest.len() > MAX_HEADER_BYTES {
            return Err("the header does not end; this is no Radiance HDR file".into());
        }
    }
}

fn wrong_run() -> String {
    "a run of equal pixels leaves its row; the file is damaged".into()
}

/// A row in which each of the four components is run-length coded by itself.
fn component_row(reader: &mut Reader<'_>, row: &mut [[u8; 4]]) -> Result<(), String> {
    for component in 0..4 {
        let mut x = 0;
        while x < row.len() {
            let code = usize::from(reader.take(1)?[0]);
            let (count, values) = if code > 128 {
                (code - 128, [reader.take(1)?[0]].repeat(code - 128))
            } else {
                (code, reader.take(code)?.to_vec())
            };
            let Some(run) = row.get_mut(x..x + count) else {
                return Err(wrong_run());
            };
            for (texel, value) in run.iter_mut().zip(values) {
                texel[component] = value;
            }
            x += count;
        }
    }
    Ok(())
}

/// A row of plain pixels, of which those with the mantissas 1, 1, 1 repeat the one before.
fn pixel_row(reader: &mut Reader<'_>, first: [u8; 4], row: &mut [[u8; 4]]) -> Result<(), String> {
    let mut x = 0_usize;
    let mut shift = 0;
    let mut pixel = first;
    loop {
        if pixel[..3] == [1, 1, 1] {
            // Consecutive markers are the digits of one count. A row needs two at most.
            let Some(previous) = x.checked_sub(1).and_then(|x| row.get(x).copied()) else {
                return Err(wrong_run());
            };
            let count = usize::from(pixel[3]) << shift;
            let run = row.get_mut(x..x + count).filter(|_| shift <= 16).ok_or_else(wrong_run)?;
            run.fill(previous);
            x += count;
            shift += 8;
        } else {
            // Invariant: the loop ends before x reaches the row's length.
            row[x] = pixel;
            x += 1;
            shift = 0;
        }
        if x >= row.len() {
            return Ok(());
        }
        pixel = reader.rgbe()?;
    }
}

/// The value of a texel: mantissas with a common exponent of bias 128.
fn radiance([r, g, b, exponent]: [u8; 4]) -> [f32; 4] {
    if exponent == 0 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    let scale = (f64::from(exponent) - 136.0).exp2();
    let value = |mantissa: u8| (f64::from(mantissa) * scale) as f32;
    [value(r), value(g), value(b), 1.0]
}

/// Decodes a whole file.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn decode(bytes: &[u8]) -> Decoded {
    let mut reader = Reader { rest: bytes };
    skip_header(&mut reader)?;
    let Resolution { size: [width, height], bottom_up, right_to_left } = resolution(&reader.line()?)?;
    let mut row = vec![[0_u8; 4]; width];
    // Grows with the rows that are there, not with the size that a header may claim.
    let mut pixels: Vec<[f32; 4]> = Vec::new();
    for _ in 0..height {
        let first = reader.rgbe()?;
        if first[0] == 2 && first[1] == 2 && first[2] < 128 {
            let coded = usize::from(first[2]) << 8 | usize::from(first[3]);
            if coded != width {
                return Err(format!(
                    "a row of {coded} pixels in a picture {width} wide; the file is damaged"
                ));
            }
            component_row(&mut reader, &mut row)?;
        } else {
            pixel_row(&mut reader, first, &mut row)?;
        }
        pixels.extend(row.iter().copied().map(radiance));
    }
    if right_to_left {
        pixels.chunks_mut(width).for_each(<[_]>::reverse);
    }
    if bottom_up {
        pixels = pixels.chunks(width).rev().flatten().copied().collect();
    }
    Ok(Picture { size: [width as u32, height as u32], pixels })
}
