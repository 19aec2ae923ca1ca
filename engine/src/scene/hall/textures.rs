//! The hall's textures, computed from noise and patterns. Colours are written as sRGB bytes, so
//! that no power function is needed.

use super::math::{cos, fractal, noise, sin, smooth_step};
use crate::error::{Error, Result};
use glam::{DVec3, dvec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::f64::consts::TAU;

/// One of the pictures in the file, in the order of [`ALL`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
#[allow(missing_docs, reason = "the names say what they show")]
pub enum Picture {
    StoneBase,
    StoneSurface,
    StoneNormal,
    MarblePale,
    MarbleDark,
    MarbleSurface,
    ClayBase,
    ClaySurface,
    ClayNormal,
    WoodBase,
    WoodSurface,
    WoodNormal,
    BrickBase,
    BrickSurface,
    BrickNormal,
    BrickOcclusion,
    PlasterBase,
    PlasterNormal,
    HammeredSurface,
    HammeredNormal,
    PatinaBase,
    PatinaSurface,
    BrushedSurface,
    BrushedNormal,
    Banner,
    WeaveNormal,
    Rug,
    Glass,
    Embers,
    Lattice,
    Leaf,
}

/// What a picture shows at a point of the unit square (v downwards).
enum Content {
    /// Height in texels of a 512-texel square; becomes a normal map.
    Height(fn(f64, f64, u64) -> f64),
    /// Colour, or roughness in y and metallic in z, 0..=1.
    Color(fn(f64, f64, u64) -> DVec3),
    /// Colour, and whether the point is solid: above 0.5.
    Mask(fn(f64, f64, u64) -> (DVec3, f64)),
}

/// All pictures: name, texels along a side, content.
static ALL: [(&str, u32, Content); 31] = {
    use Content::{Color, Height, Mask};
    [
        ("stone base colour", 512, Color(stone_base)),
        ("stone roughness", 256, Color(stone_surface)),
        ("stone normals", 512, Height(stone_height)),
        ("pale marble base colour", 512, Color(marble_pale)),
        ("dark marble base colour", 512, Color(marble_dark)),
        ("marble roughness", 256, Color(marble_surface)),
        ("clay tile base colour", 256, Color(clay_base)),
        ("clay tile roughness", 256, Color(clay_surface)),
        ("clay tile normals", 256, Height(clay_height)),
        ("wood base colour", 512, Color(wood_base)),
        ("wood roughness", 256, Color(wood_surface)),
        ("wood normals", 512, Height(wood_height)),
        ("brick base colour", 512, Color(brick_base)),
        ("brick roughness", 256, Color(brick_surface)),
        ("brick normals", 512, Height(brick_height)),
        ("brick occlusion", 256, Color(brick_occlusion)),
        ("plaster base colour", 256, Color(plaster_base)),
        ("plaster normals", 256, Height(plaster_height)),
        ("hammered metal roughness", 256, Color(hammered_surface)),
        ("hammered metal normals", 256, Height(hammered_height)),
        ("patina base colour", 256, Color(patina_base)),
        ("patina roughness and metal", 256, Color(patina_surface)),
        ("brushed metal roughness", 256, Color(brushed_surface)),
        ("brushed metal normals", 256, Height(brushed_height)),
        ("banner base colour", 512, Color(banner)),
        ("weave normals", 256, Height(weave_height)),
        ("rug base colour", 512, Color(rug)),
        ("lantern glass", 256, Color(glass)),
        ("embers", 256, Color(embers)),
        ("lattice", 512, Mask(lattice)),
        ("leaf", 256, Mask(leaf)),
    ]
};

/// How many pictures there are.
pub const COUNT: usize = ALL.len();

/// The name of the picture with this number.
pub fn name(number: usize) -> &'static str {
    ALL[number].0
}

/// The picture with this number as a PNG file's bytes.
pub fn png(number: usize, seed: u64) -> Result<Vec<u8>> {
    let (name, size, content) = &ALL[number];
    let (pixels, format) = pixels(*size, content, seed);
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(&pixels, *size, *size, format)
        .map_err(|cause| Error::file(name, cause))?;
    Ok(bytes)
}

fn pixels(size: u32, content: &Content, seed: u64) -> (Vec<u8>, ExtendedColorType) {
    let byte = |value: f64| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let mut pixels = Vec::with_capacity(4 * (size * size) as usize);
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(size);
    let heights: Vec<f64> = match content {
        Content::Height(height) => {
            (0..size * size).map(|k| height(at(k % size), at(k / size), seed)).collect()
        }
        _ => Vec::new(),
    };
    let height_at = |x: u32, y: u32| heights[(y % size * size + x % size) as usize];
    for y in 0..size {
        for x in 0..size {
            let (u, v) = (at(x), at(y));
            match content {
                Content::Color(color) => pixels.extend(color(u, v, seed).to_array().map(byte)),
                Content::Mask(color) => {
                    let (color, alpha) = color(u, v, seed);
                    pixels.extend(color.to_array().map(byte));
                    pixels.push(byte(alpha));
                }
                Content::Height(_) => {
                    let scale = 0.5 * f64::from(size) / 512.0;
                    let right = height_at(x + 1, y) - height_at(x + size - 1, y);
                    let down = height_at(x, y + 1) - height_at(x, y + size - 1);
                    // The map's y points up, the rows down.
                    let normal = dvec3(-right * scale, down * scale, 1.0).normalize();
                    pixels.extend((normal * 0.5 + 0.5).to_array().map(byte));
                }
            }
        }
    }
    let mask = matches!(content, Content::Mask(_));
    (pixels, if mask { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 })
}

/// Blocks in running bond: how deep in the joint (0 block, 1 joint), and the block's own random value.
fn bond(u: f64, v: f64, [columns, rows]: [f64; 2], joint: [f64; 2], seed: u64) -> (f64, f64) {
    let row = (v * rows).floor();
    let shift = if row.rem_euclid(2.0) < 0.5 { 0.0 } else { 0.5 };
    let (x, y) = (u * columns + shift, v * rows);
    let (fx, fy) = (x - x.floor(), y - row);
    let edge = (fx.min(1.0 - fx) / joint[0]).min(fy.min(1.0 - fy) / joint[1]);
    let column = x.floor().rem_euclid(columns);
    let row = row.rem_euclid(rows);
    let own = noise((column + 0.5) / columns, (row + 0.5) / rows, 37, seed);
    (1.0 - smooth_step(0.35, 1.0, edge), own)
}

fn gray(value: f64) -> DVec3 {
    DVec3::splat(value)
}

fn rough(value: f64) -> DVec3 {
    dvec3(1.0, value, 1.0)
}

fn stone_bond(u: f64, v: f64, seed: u64) -> (f64, f64) {
    bond(u, v, [2.0, 3.0], [0.012, 0.018], seed)
}

fn stone_base(u: f64, v: f64, seed: u64) -> DVec3 {
    let (joint, own) = stone_bond(u, v, seed);
    let grain = fractal(u, v, 8, 6, seed + 1);
    let fine = noise(u, v, 170, seed + 2);
    let value = 0.68 + 0.14 * own + 0.18 * (grain - 0.5) + 0.07 * (fine - 0.5) - 0.2 * joint;
    dvec3(value, value * 0.985, value * (0.93 + 0.04 * own))
}

fn stone_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    rough(0.72 + 0.22 * fractal(u, v, 12, 4, seed + 3) + 0.1 * stone_bond(u, v, seed).0)
}

fn stone_height(u: f64, v: f64, seed: u64) -> f64 {
    let pits = smooth_step(0.25, 0.4, noise(u, v, 60, seed + 4));
    7.0 * fractal(u, v, 8, 6, seed + 1) + 0.6 * pits - 4.0 * stone_bond(u, v, seed).0
}

/// Veins where warped noise crosses its middle: 1 on a vein.
fn veins(u: f64, v: f64, cells: u32, width: f64, seed: u64) -> f64 {
    let warp = |k| 0.22 * (fractal(u, v, 3, 5, seed + k) - 0.5);
    let value = fractal(u + warp(10), v + warp(20), cells, 4, seed + 30) - 0.5;
    1.0 - smooth_step(0.0, width, value.abs())
}

fn marble_pale(u: f64, v: f64, seed: u64) -> DVec3 {
    let cloud = fractal(u, v, 3, 5, seed + 40);
    let vein = 0.5 * veins(u, v, 3, 0.02, seed + 41) + 0.22 * veins(u, v, 6, 0.03, seed + 90);
    let value = 0.93 - 0.12 * cloud;
    dvec3(value - 0.32 * vein, value * 0.985 - 0.33 * vein, value * 0.955 - 0.3 * vein)
}

fn marble_dark(u: f64, v: f64, seed: u64) -> DVec3 {
    let cloud = fractal(u, v, 4, 5, seed + 50);
    let vein = 0.7 * veins(u, v, 3, 0.012, seed + 51) + 0.2 * veins(u, v, 7, 0.02, seed + 130);
    let value = 0.2 + 0.12 * cloud;
    dvec3(value * 0.9, value * 1.04, value) + gray(0.5 * vein)
}

fn marble_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    rough(0.55 + 0.35 * fractal(u, v, 5, 5, seed + 60))
}

fn clay_bond(u: f64, v: f64, seed: u64) -> (f64, f64) {
    // Square tiles in straight courses: double rows hide the bond's shift.
    let (fx, fy) = ((u * 4.0).fract().abs(), (v * 4.0).fract().abs());
    let edge = fx.min(1.0 - fx).min(fy.min(1.0 - fy));
    let own = noise(((u * 4.0).floor() + 0.5) / 4.0, ((v * 4.0).floor() + 0.5) / 4.0, 37, seed);
    (1.0 - smooth_step(0.012, 0.035, edge), own)
}

fn clay_base(u: f64, v: f64, seed: u64) -> DVec3 {
    let (joint, own) = clay_bond(u, v, seed + 70);
    let shade = 0.8 + 0.25 * own + 0.3 * (fractal(u, v, 8, 4, seed + 71) - 0.5);
    (dvec3(0.66, 0.4, 0.3) * shade).lerp(dvec3(0.5, 0.47, 0.43), joint)
}

fn clay_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    let (joint, own) = clay_bond(u, v, seed + 70);
    rough(0.42 + 0.2 * own + 0.2 * fractal(u, v, 8, 4, seed + 72) + 0.3 * joint)
}

fn clay_height(u: f64, v: f64, seed: u64) -> f64 {
    4.0 * fractal(u, v, 8, 4, seed + 71) - 5.0 * clay_bond(u.rem_euclid(1.0), v.rem_euclid(1.0), seed + 70).0
}

/// Planks along v: distance into the gap, the plank's own value, and its grain.
fn planks(u: f64, v: f64, seed: u64) -> (f64, f64, f64) {
    let x = u.rem_euclid(1.0) * 5.0;
    let plank = x.floor();
    let own = noise((plank + 0.5) / 5.0, 0.5, 41, seed + 80);
    let edge = (x - plank).min(1.0 - (x - plank));
    let along = v + own * 3.0;
    let bend = 0.06 * fractal(u, along, 4, 3, seed + 81);
    let rings = 0.5 + 0.5 * sin(TAU * 26.0 * (u + bend));
    let streak = fractal(u * 1.0, along * 0.0 + 0.03 * (along.fract()), 90, 2, seed + 82);
    (1.0 - smooth_step(0.01, 0.03, edge), own, 0.55 * rings + 0.45 * streak)
}

fn wood_base(u: f64, v: f64, seed: u64) -> DVec3 {
    let (gap, own, grain) = planks(u, v, seed);
    dvec3(0.53, 0.37, 0.24) * (0.7 + 0.3 * own + 0.3 * grain) * (1.0 - 0.75 * gap)
}

fn wood_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    let (gap, _, grain) = planks(u, v, seed);
    rough(0.45 + 0.2 * grain + 0.3 * gap)
}

fn wood_height(u: f64, v: f64, seed: u64) -> f64 {
    let (gap, _, grain) = planks(u, v, seed);
    1.2 * grain - 5.0 * gap
}

fn bricks(u: f64, v: f64, seed: u64) -> (f64, f64) {
    bond(u, v, [6.0, 18.0], [0.035, 0.1], seed + 100)
}

fn brick_base(u: f64, v: f64, seed: u64) -> DVec3 {
    let (joint, own) = bricks(u, v, seed);
    let shade = 0.75 + 0.4 * own + 0.3 * (fractal(u, v, 20, 4, seed + 101) - 0.5);
    (dvec3(0.56, 0.33, 0.26) * shade).lerp(dvec3(0.66, 0.62, 0.56), joint)
}

fn brick_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    rough(0.75 + 0.2 * fractal(u, v, 20, 3, seed + 102))
}

fn brick_height(u: f64, v: f64, seed: u64) -> f64 {
    3.5 * fractal(u, v, 20, 4, seed + 101) - 5.0 * bricks(u, v, seed).0
}

fn brick_occlusion(u: f64, v: f64, seed: u64) -> DVec3 {
    gray(1.0 - 0.55 * bricks(u, v, seed).0)
}

fn plaster_base(u: f64, v: f64, seed: u64) -> DVec3 {
    let value = 0.86 + 0.14 * (fractal(u, v, 4, 5, seed + 110) - 0.5);
    dvec3(value, value * 0.98, value * 0.94)
}

fn plaster_height(u: f64, v: f64, seed: u64) -> f64 {
    6.0 * fractal(u, v, 10, 4, seed + 111)
}

fn hammered_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    rough(0.75 + 0.25 * fractal(u, v, 10, 3, seed + 120))
}

fn hammered_height(u: f64, v: f64, seed: u64) -> f64 {
    10.0 * noise(u, v, 14, seed + 121) + 3.0 * noise(u, v, 31, seed + 122)
}

fn verdigris(u: f64, v: f64, seed: u64) -> f64 {
    smooth_step(0.5, 0.66, fractal(u, v, 5, 5, seed + 125))
}

fn patina_base(u: f64, v: f64, seed: u64) -> DVec3 {
    gray(0.9).lerp(dvec3(0.5, 0.95, 0.85), verdigris(u, v, seed))
}

fn patina_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    let green = verdigris(u, v, seed);
    dvec3(1.0, 0.6 + 0.4 * green, 1.0 - 0.85 * green)
}

fn brushed(u: f64, v: f64, seed: u64) -> f64 {
    0.6 * noise(u, v, 128, seed + 140) * noise(0.5, v, 199, seed + 141) + 0.4 * noise(0.5, v, 97, seed + 142)
}

fn brushed_surface(u: f64, v: f64, seed: u64) -> DVec3 {
    rough(0.7 + 0.3 * brushed(u, v, seed))
}

fn brushed_height(u: f64, v: f64, seed: u64) -> f64 {
    0.8 * brushed(u, v, seed)
}

/// A pale border and a sun with rays on a tinted field.
fn banner(u: f64, v: f64, seed: u64) -> DVec3 {
    let (x, y) = (u - 0.5, (v - 0.38) * 2.6);
    let radius = (x * x + y * y).sqrt();
    // Twelve rays from the twelfth harmonic of the angle, by repeated doubling of (x + iy)/r.
    let mut ray = (x / radius.max(1e-9), y / radius.max(1e-9));
    let square = |(a, b): (f64, f64)| (a * a - b * b, 2.0 * a * b);
    let third = {
        let second = square(ray);
        (second.0 * ray.0 - second.1 * ray.1, second.0 * ray.1 + second.1 * ray.0)
    };
    ray = square(square(third));
    let reach = 0.2 + 0.07 * ray.0;
    let sun = 1.0 - smooth_step(reach, reach + 0.01, radius);
    let core = smooth_step(0.085, 0.095, radius) * (1.0 - smooth_step(0.11, 0.12, radius));
    let border = smooth_step(0.36, 0.37, x.abs()) * (1.0 - smooth_step(0.41, 0.42, x.abs()));
    let bars = smooth_step(0.0, 0.01, v - 0.72) * (1.0 - smooth_step(0.0, 0.01, v - 0.75));
    let pale = (sun * (1.0 - core)).max(border).max(bars);
    let cloth = 0.82 + 0.18 * fractal(u, v, 6, 5, seed + 150);
    gray(0.72 * cloth).lerp(dvec3(1.0, 0.98, 0.9), pale)
}

fn weave_height(u: f64, v: f64, _: u64) -> f64 {
    let (x, y) = (sin(TAU * 32.0 * u), sin(TAU * 32.0 * v));
    1.6 * (x * x * smooth_step(-0.2, 0.2, x * y) + y * y * smooth_step(-0.2, 0.2, -x * y))
}

/// A woollen runner: borders along both sides, lozenges down the middle.
fn rug(u: f64, v: f64, seed: u64) -> DVec3 {
    let x = (u - 0.5).abs();
    let wool =
        0.85 + 0.3 * (noise(u, v, 200, seed + 160) - 0.5) + 0.2 * (fractal(u, v, 5, 3, seed + 161) - 0.5);
    let lozenge = |count: f64, size: f64| {
        let y = ((v * count).fract() - 0.5).abs() / count;
        x * 0.8 + y < size
    };
    let color = if x > 0.46 {
        dvec3(0.62, 0.5, 0.3)
    } else if x > 0.4 {
        let key = ((v * 24.0).floor() as i64 + ((x > 0.43) as i64)) % 2 == 0;
        if key { dvec3(0.75, 0.62, 0.38) } else { dvec3(0.13, 0.15, 0.3) }
    } else if x > 0.385 {
        dvec3(0.75, 0.62, 0.38)
    } else if lozenge(2.0, 0.1) {
        dvec3(0.7, 0.58, 0.36)
    } else if lozenge(2.0, 0.16) {
        dvec3(0.14, 0.17, 0.33)
    } else if lozenge(2.0, 0.18) {
        dvec3(0.75, 0.62, 0.38)
    } else {
        let dots = cos(TAU * 14.0 * u) * cos(TAU * 14.0 * v);
        dvec3(0.5, 0.09, 0.1) * if dots > 0.75 { 1.5 } else { 1.0 }
    };
    color * wool
}

fn glass(u: f64, v: f64, seed: u64) -> DVec3 {
    let pane =
        (u * 3.0).fract().min(1.0 - (u * 3.0).fract()).min((v * 3.0).fract().min(1.0 - (v * 3.0).fract()));
    let light = 0.72 + 0.28 * fractal(u, v, 5, 4, seed + 170);
    gray(light * smooth_step(0.01, 0.07, pane).max(0.25))
}

fn embers(u: f64, v: f64, seed: u64) -> DVec3 {
    let heat = smooth_step(0.38, 0.7, fractal(u, v, 6, 4, seed + 180));
    dvec3(0.25 + 0.75 * heat, 0.12 + 0.85 * heat * heat, 0.1 + 0.6 * heat * heat * heat)
}

/// Interlaced circles and a diagonal net.
fn lattice(u: f64, v: f64, seed: u64) -> (DVec3, f64) {
    let ring = |cx: f64, cy: f64| {
        let wrap = |d: f64| d - d.round();
        let (x, y) = (wrap(u * 4.0 - cx), wrap(v * 4.0 - cy));
        ((x * x + y * y).sqrt() - 0.36).abs()
    };
    let bar = |t: f64| (t - t.round()).abs();
    let net = bar(4.0 * (u + v)).min(bar(4.0 * (u - v)));
    let edge = (ring(0.0, 0.0) / 0.055).min(ring(0.5, 0.5) / 0.055).min(net / 0.05);
    let frame = bar(4.0 * u).min(bar(4.0 * v)) / 0.035;
    let solid = 1.0 - smooth_step(0.85, 1.15, edge.min(frame));
    (gray(0.75 + 0.25 * fractal(u, v, 8, 4, seed + 190)), solid)
}

/// A pointed leaf with a rib, upright in the picture.
fn leaf(u: f64, v: f64, seed: u64) -> (DVec3, f64) {
    let (x, y) = ((u - 0.5).abs(), v);
    let half = 1.55 * y * (1.0 - y) * (1.15 - 0.6 * y) + 0.012;
    let notch = 0.02 * sin(TAU * 9.0 * y);
    let solid = 1.0 - smooth_step(half + notch - 0.006, half + notch + 0.006, x);
    let rib = 1.0 - smooth_step(0.006, 0.016, x.min((x * 0.8 + y * 5.0).fract().abs() * 0.2));
    let tone = fractal(u, v, 4, 4, seed + 200);
    (dvec3(0.72, 0.4, 0.14).lerp(dvec3(0.55, 0.5, 0.14), tone) * (0.85 + 0.2 * rib), solid)
}
