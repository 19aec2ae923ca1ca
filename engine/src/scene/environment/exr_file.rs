//! OpenEXR files, through the `exr` crate.
//!
//! The crate trusts sizes in headers and has assertions that damaged blocks can reach, so all sizes
//! are checked here before pixels are read, blocks go straight into the picture, and what still
//! panics is caught (see [`decode`]).

use super::read::{Decoded, Picture, check_size};
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::lines::LineRef;
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, EnvironmentMap, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use half::f16;
use rayon::prelude::*;
use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The most bytes that the largest level of the part that is read may decode to, all channels.
const MAX_DECODED_BYTES: usize = 1 << 29;

/// The most bytes that one block may decode to. The largest honest one is 256 rows of 8192 texels
/// of four floats.
const MAX_BLOCK_BYTES: usize = 1 << 25;

/// The most parts in a file.
const MAX_PARTS: usize = 256;

/// The most channels in a part.
const MAX_CHANNELS: usize = 256;

/// Blocks that are decompressed at once.
const BATCH: usize = 32;

/// What a channel contributes to a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    /// Component 0, 1 or 2.
    Color(usize),
    /// Luminance, alone or with `RedChroma` and `BlueChroma`.
    Luminance,
    /// (R - Y) / Y
    RedChroma,
    /// (B - Y) / Y
    BlueChroma,
    Ignored,
}

/// The part that is read.
struct Part {
    index: usize,
    size: [usize; 2],
    /// For each channel of the part.
    roles: Vec<Role>,
    /// Luminance and chroma, not red, green and blue.
    luminance: bool,
}

/// Decodes a whole file.
///
/// A panic of the decoder ends in an error like any other damage; the process's panic hook has then
/// already written its message to the standard error output. Of many thousand damaged files, those
/// that came to this had B44 blocks whose differences fall below 0, in builds with overflow checks.
/// Blocks are decompressed on rayon's common threads, not on the crate's own, on which a panic would
/// end the process.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn decode(bytes: &[u8]) -> Decoded {
    catch_unwind(AssertUnwindSafe(|| decode_unguarded(bytes)))
        .unwrap_or_else(|_| Err("the OpenEXR decoder failed on it; the file is damaged".into()))
}

fn explained(error: exr::error::Error) -> String {
    match error {
        exr::error::Error::NotSupported(what) => {
            format!("{what}; re-save it as flat RGB with ZIP compression")
        }
        other => format!("{other}; the file is damaged"),
    }
}

fn decode_unguarded(bytes: &[u8]) -> Decoded {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(explained)?;
    if meta.headers.len() > MAX_PARTS {
        return Err(format!("{} parts; at most {MAX_PARTS} are supported", meta.headers.len()));
    }
    check_chunk_counts(&meta, bytes.len())?;
    let part = choose_part(&meta)?;
    let header = &meta.headers[part.index];
    check_part(header, &part)?;

    let reader = exr::block::read(Cursor::new(bytes), false).map_err(explained)?;
    let chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == part.index && tile.level_index == Vec2(0, 0))
        .map_err(explained)?;
    let mut canvas = Canvas::new(&part);
    let mut batch = Vec::with_capacity(BATCH);
    for chunk in chunks {
        batch.push(chunk.map_err(explained)?);
        if batch.len() == BATCH {
            canvas.add(&meta, header, std::mem::take(&mut batch))?;
        }
    }
    canvas.add(&meta, header, batch)?;
    canvas.finished()
}

/// Every block has its 8 bytes in the file's table; without that, a few header bytes could ask for
/// billions of blocks.
fn check_chunk_counts(meta: &MetaData, file_bytes: usize) -> Result<(), String> {
    let mut blocks = 0_usize;
    for header in &meta.headers {
        blocks = blocks.saturating_add(header.chunk_count);
    }
    if blocks > file_bytes / 8 {
        return Err(format!("{blocks} blocks in a file of {file_bytes} bytes; the file is damaged"));
    }
    Ok(())
}

/// The first part with usable channels.
fn choose_part(meta: &MetaData) -> Result<Part, String> {
    let mut deep = false;
    for (index, header) in meta.headers.iter().enumerate() {
        deep |= header.deep;
        if header.deep || header.channels.list.len() > MAX_CHANNELS {
            continue;
        }
        let names: Vec<String> =
            header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
        if let Some(roles) = roles_of(&names) {
            let size = [header.layer_size.width(), header.layer_size.height()];
            let luminance = roles.contains(&Role::Luminance);
            return Ok(Part { index, size, roles, luminance });
        }
    }
    Err(if deep {
        "deep data is not supported; flatten it and re-save it with ZIP compression".into()
    } else {
        "no channels R, G, B or Y; re-save it as RGB".into()
    })
}

/// What each channel is for, or `None` if no picture can be made of them.
fn roles_of(names: &[String]) -> Option<Vec<Role>> {
    let split = |name: &str| -> (String, String) {
        name.rsplit_once('.').map_or_else(
            || (String::new(), name.to_owned()),
            |(layer, channel)| (layer.to_owned(), channel.to_owned()),
        )
    };
    let parts: Vec<(String, String)> = names.iter().map(|name| split(name)).collect();
    let has = |layer: &str, channel: &str| parts.iter().any(|(l, c)| l == layer && c == channel);
    let is_rgb = |layer: &str| ["R", "G", "B"].iter().all(|channel| has(layer, channel));
    let (layer, luminance) = if ["R", "G", "B"].iter().any(|channel| has("", channel)) {
        (String::new(), false)
    } else if has("", "Y") {
        (String::new(), true)
    } else {
        (parts.iter().find(|(layer, _)| is_rgb(layer))?.0.clone(), false)
    };
    let chroma = luminance && has("", "RY") && has("", "BY");
    let role = |(l, channel): &(String, String)| match channel.as_str() {
        _ if *l != layer => Role::Ignored,
        "R" if !luminance => Role::Color(0),
        "G" if !luminance => Role::Color(1),
        "B" if !luminance => Role::Color(2),
        "Y" if luminance => Role::Luminance,
        "RY" if chroma => Role::RedChroma,
        "BY" if chroma => Role::BlueChroma,
        _ => Role::Ignored,
    };
    Some(parts.iter().map(role).collect())
}

/// Sizes and kinds, before any memory is taken for pixels.
fn check_part(header: &Header, part: &Part) -> Result<(), String> {
    check_size(part.size)?;
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        return Err("a cube map; re-save it as a latitude-longitude map".into());
    }
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err("subsampled channels (luminance and chroma) are not supported; re-save it as RGB".into());
    }
    if matches!(header.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
        return Err("HTJ2K compression is not supported; re-save it with ZIP compression".into());
    }
    let bytes_per_texel: usize =
        header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
    if part.size[0] * part.size[1] * bytes_per_texel > MAX_DECODED_BYTES {
        return Err(format!(
            "its {} channels of {}x{} decode to more than {} MB; re-save it as RGB alone",
            header.channels.list.len(),
            part.size[0],
            part.size[1],
            MAX_DECODED_BYTES >> 20
        ));
    }
    let block = match header.blocks {
        BlockDescription::Tiles(tiles) => tiles.tile_size.width().saturating_mul(tiles.tile_size.height()),
        BlockDescription::ScanLines => header.compression.scan_lines_per_block() * part.size[0],
    };
    if block.saturating_mul(bytes_per_texel) > MAX_BLOCK_BYTES {
        return Err(format!(
            "its blocks of {block} texels of {bytes_per_texel} bytes are too large; re-save it in scan lines"
        ));
    }
    Ok(())
}

/// The picture while blocks arrive.
struct Canvas<'a> {
    part: &'a Part,
    pixels: Vec<[f32; 4]>,
    /// Where the blocks lie that have arrived.
    seen: HashSet<[usize; 2]>,
    /// Texels that they cover.
    covered: usize,
}

impl<'a> Canvas<'a> {
    fn new(part: &'a Part) -> Self {
        Self { part, pixels: vec![[0.0; 4]; part.size[0] * part.size[1]], seen: HashSet::new(), covered: 0 }
    }

    /// Decompresses blocks and puts them into the picture.
    fn add(&mut self, meta: &MetaData, header: &Header, chunks: Vec<Chunk>) -> Result<(), String> {
        let blocks: Vec<Result<UncompressedBlock, String>> =
            chunks.into_par_iter().map(|chunk| decompressed(chunk, meta)).collect();
        for block in blocks {
            let block = block?;
            let Vec2(x, y) = block.index.pixel_position;
            let Vec2(width, height) = block.index.pixel_size;
            let inside = block.index.layer == self.part.index
                && block.index.level == Vec2(0, 0)
                && x + width <= self.part.size[0]
                && y + height <= self.part.size[1];
            if !inside || !self.seen.insert([x, y]) {
                return Err("a block lies where none belongs; the file is damaged".into());
            }
            self.covered += width * height;
            for line in block.lines(&header.channels) {
                self.add_line(&header.channels.list[line.location.channel], line);
            }
        }
        Ok(())
    }

    /// One channel of one row of a block that lies inside the picture.
    fn add_line(&mut self, channel: &ChannelDescription, line: LineRef<'_>) {
        let component = match self.part.roles[line.location.channel] {
            Role::Color(component) => component,
            Role::Luminance => 1,
            Role::RedChroma => 0,
            Role::BlueChroma => 2,
            Role::Ignored => return,
        };
        let Vec2(x, y) = line.location.position;
        let start = y * self.part.size[0] + x;
        let texels = &mut self.pixels[start..start + line.location.sample_count];
        let bytes = line.value;
        // Invariant of the crate: samples are in the machine's byte order.
        match channel.sample_type {
            SampleType::F16 => {
                for (texel, bytes) in texels.iter_mut().zip(bytes.as_chunks().0) {
                    texel[component] = f16::from_ne_bytes(*bytes).to_f32();
                }
            }
            SampleType::F32 => {
                for (texel, bytes) in texels.iter_mut().zip(bytes.as_chunks().0) {
                    texel[component] = f32::from_ne_bytes(*bytes);
                }
            }
            SampleType::U32 => {
                for (texel, bytes) in texels.iter_mut().zip(bytes.as_chunks().0) {
                    texel[component] = u32::from_ne_bytes(*bytes) as f32;
                }
            }
        }
    }

    /// The whole picture as RGB.
    fn finished(mut self) -> Decoded {
        if self.covered != self.pixels.len() {
            return Err("blocks are missing; get a whole copy of the file".into());
        }
        if self.part.luminance {
            let chroma = self.part.roles.contains(&Role::RedChroma);
            self.pixels.par_iter_mut().for_each(|texel| *texel = rgb_of_luminance(*texel, chroma));
        }
        let size = self.part.size.map(|side| side as u32);
        Ok(Picture { size, pixels: self.pixels })
    }
}

/// RGB from (red chroma, luminance, blue chroma), with the weights of Rec. 709 (OpenEXR, "Technical
/// Introduction", luminance/chroma images).
fn rgb_of_luminance([red, luminance, blue, _]: [f32; 4], chroma: bool) -> [f32; 4] {
    if !chroma {
        return [luminance, luminance, luminance, 1.0];
    }
    let (r, b) = ((red + 1.0) * luminance, (blue + 1.0) * luminance);
    [r, (luminance - 0.2126 * r - 0.0722 * b) / 0.7152, b, 1.0]
}

/// Decompresses one block, after a look at what would make the crate take memory without bound.
fn decompressed(chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock, String> {
    let header = meta.headers.get(chunk.layer_index).ok_or("a block of no part; the file is damaged")?;
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err("deep data is not supported; flatten it".into()),
    };
    let place = header
        .get_block_data_indices(&chunk.compressed_block)
        .and_then(|tile| header.get_absolute_block_pixel_coordinates(tile))
        .map_err(explained)?;
    let expected = place.size.area() * header.channels.bytes_per_pixel;
    // A block of just the right length is stored as it is, whatever the compression.
    if bytes.len() != expected {
        let largest = match header.compression {
            Compression::RLE => run_length(bytes),
            Compression::DWAA(_) | Compression::DWAB(_) => largest_dwa_section(bytes),
            _ => 0,
        };
        if largest > 4 * expected + (1 << 16) {
            return Err("a block decodes to more than its size; the file is damaged".into());
        }
    }
    UncompressedBlock::decompress_chunk(chunk, meta, false).map_err(explained)
}

/// The most bytes to which a section of a DWA block says that it decodes. A block begins with eleven
/// counters; of those, 1, 6 and 7 are decoded lengths in bytes, 8 and 9 numbers of 16 bit
/// coefficients. The crate reserves what they say, and honest ones are near the block's own size.
fn largest_dwa_section(bytes: &[u8]) -> usize {
    let counters = bytes.as_chunks().0.iter().take(11).map(|counter| u64::from_le_bytes(*counter));
    let length = |(index, counter): (usize, u64)| match index {
        1 | 6 | 7 => counter,
        8 | 9 => counter.saturating_mul(2),
        _ => 0,
    };
    let longest = counters.enumerate().map(length).max().unwrap_or(0);
    usize::try_from(longest).unwrap_or(usize::MAX)
}

/// The number of bytes that run-length coded bytes stand for. The crate expands them all.
fn run_length(bytes: &[u8]) -> usize {
    let (mut at, mut length) = (0, 0);
    while let Some(&code) = bytes.get(at) {
        let code = i32::from(code as i8);
        let (taken, given) = if code < 0 { (-code, -code) } else { (1, code + 1) };
        at += 1 + taken as usize;
        length += given as usize;
    }
    length
}
