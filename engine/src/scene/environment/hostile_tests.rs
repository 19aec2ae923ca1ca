//! Damaged files: every one ends in a picture or an error, in bounded time.

use super::{exr_file, radiance_file};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage, f16,
};
use std::io::Cursor;
use std::time::Instant;

/// Changed copies of each file.
const COPIES: usize = 300;

/// A little generator, so that every run makes the same files.
fn next(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

/// A 23x37 picture in one of the formats that the `exr` crate writes.
fn exr(compression: Compression, blocks: Blocks, half: bool) -> Vec<u8> {
    let values: Vec<f32> = (0..23 * 37).map(|i| (i % 23) as f32 * 0.1 + (i / 23 % 5) as f32).collect();
    let channel = |name: &str| {
        let samples = if half {
            FlatSamples::F16(values.iter().map(|&value| f16::from_f32(value)).collect())
        } else {
            FlatSamples::F32(values.clone())
        };
        AnyChannel::new(name, samples)
    };
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(["R", "G", "B"].into_iter().map(channel).collect());
    let layer = Layer::new((23, 37), LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A 40x3 picture: a row of coded components, one of plain pixels, one with runs of pixels.
pub(super) fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\n# comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 3 +X 40\n".to_vec();
    bytes.extend([2, 2, 0, 40]);
    for component in 0..4 {
        bytes.extend([128 + 30, 64 + component, 10]);
        bytes.extend((0..10).map(|i| 128 + i));
    }
    bytes.extend((0..40).flat_map(|i| [10 + i, 20, 30, 128]));
    bytes.extend([200, 100, 50, 130, 1, 1, 1, 38, 7, 7, 7, 120]);
    bytes
}

/// Overwrites, cuts or repeats some bytes.
fn damage(whole: &[u8], state: &mut u64) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..1 + next(state) % 4 {
        let at = next(state) as usize % bytes.len();
        match next(state) % 8 {
            0 => bytes.truncate(at.max(8)),
            1 => bytes[at] = 0xff,
            2 => bytes[at] = 0,
            3 => {
                let from = next(state) as usize % bytes.len();
                let count = (next(state) % 16) as usize;
                let count = count.min(bytes.len() - at).min(bytes.len() - from);
                bytes.copy_within(from..from + count, at);
            }
            4 => bytes[at] ^= 1 << (next(state) % 8),
            _ => bytes[at] = next(state) as u8,
        }
    }
    bytes
}

#[test]
fn damaged_exr_files_end_in_an_error_or_a_picture() {
    let mut state = 1;
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ];
    for compression in compressions {
        for blocks in [Blocks::ScanLines, Blocks::Tiles((16, 16).into())] {
            for half in [false, true] {
                let whole = exr(compression, blocks, half);
                let picture = exr_file::decode(&whole).unwrap();
                assert_eq!(picture.size, [23, 37]);
                let start = Instant::now();
                let (mut read, mut failed) = (0, 0);
                for _ in 0..COPIES {
                    match exr_file::decode(&damage(&whole, &mut state)) {
                        Ok(picture) => {
                            let [width, height] = picture.size.map(|side| side as usize);
                            assert_eq!(picture.pixels.len(), width * height);
                            read += 1;
                        }
                        Err(cause) => failed += usize::from(cause.contains("decoder failed")),
                    }
                }
                let seconds = start.elapsed().as_secs_f64();
                println!(
                    "{compression}, half {half}, {blocks:?}: {read} read, {failed} panics, {seconds:.2} s"
                );
                assert!(seconds < 60.0, "{compression}: {seconds} s");
            }
        }
    }
}

#[test]
fn damaged_hdr_files_end_in_an_error_or_a_picture() {
    let whole = hdr();
    let mut state = 2;
    for length in 0..whole.len() {
        assert!(radiance_file::decode(&whole[..length]).is_err(), "{length}");
    }
    for _ in 0..20 * COPIES {
        if let Ok(picture) = radiance_file::decode(&damage(&whole, &mut state)) {
            assert_eq!(picture.pixels.len(), (picture.size[0] * picture.size[1]) as usize);
        }
    }
}

#[test]
fn hdr_values_follow_the_format() {
    let picture = radiance_file::decode(&hdr()).unwrap();
    assert_eq!(picture.size, [40, 3]);
    // 64 * 2^(67 - 136) in the run, and so on along the components.
    assert_eq!(picture.pixels[0][0], 64.0 * (67.0_f32 - 136.0).exp2());
    assert_eq!(picture.pixels[40], [10.0 / 256.0, 20.0 / 256.0, 30.0 / 256.0, 1.0]);
    assert_eq!(picture.pixels[80][..3], [200.0 / 64.0, 100.0 / 64.0, 50.0 / 64.0]);
    assert_eq!(picture.pixels[118], picture.pixels[80]);
    assert_eq!(picture.pixels[119][0], 7.0 / 65536.0);
}

#[test]
fn hdr_headers_are_understood_or_refused() {
    let file = |resolution: &str| {
        let mut bytes = format!("#?RGBE\n\n{resolution}\n").into_bytes();
        bytes.extend([[128, 0, 0, 129], [0, 128, 0, 129], [0, 0, 128, 129], [64, 64, 64, 129]].concat());
        radiance_file::decode(&bytes).map(|picture| picture.pixels)
    };
    let [red, green, blue, grey] =
        [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0], [0.5, 0.5, 0.5, 1.0]];
    assert_eq!(file("-Y 2 +X 2").unwrap(), [red, green, blue, grey]);
    assert_eq!(file("+Y 2 +X 2").unwrap(), [blue, grey, red, green]);
    assert_eq!(file("-Y 2 -X 2").unwrap(), [green, red, grey, blue]);
    for refused in
        ["+X 2 +Y 2", "-Y 0 +X 2", "-Y 99999 +X 99999", "-Y 4294967295 +X 2", "-Y -1 +X 2", "-Y 2", ""]
    {
        assert!(file(refused).is_err(), "{refused}");
    }
    assert!(radiance_file::decode(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\0\0\0\0").is_err());
}
