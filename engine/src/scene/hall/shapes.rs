//! Solids and surfaces that the hall is put together from.

use super::materials::Material;
use super::math::{cos, sin_cos, turn};
use super::mesh::{Facing, Mesh};
use glam::{DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::{PI, TAU};

/// One stretch of a profile: where it ends, and how far it bows outwards as a share of its chord.
pub type Stretch = ([f64; 2], f64);

/// A rectangle from `origin`, seen from the side of `edge_u x edge_v`; texture v runs against `edge_v`.
pub fn rectangle(
    mesh: &mut Mesh,
    material: Material,
    origin: DVec3,
    edge_u: DVec3,
    edge_v: DVec3,
    per_metre: f64,
) {
    let (length_u, length_v) = (edge_u.length(), edge_v.length());
    let segments = [mesh.segments(length_u * per_metre, 1), mesh.segments(length_v * per_metre, 1)];
    mesh.grid(material, segments, Facing::Natural, [false; 2], |u, v| {
        (origin + edge_u * u + edge_v * v, dvec2(u * length_u, -v * length_v))
    });
}

/// A box from `low` to `high` whose upper edges are chamfered by `chamfer` metres; `bottom` says
/// whether its underside is seen.
pub fn block(mesh: &mut Mesh, material: Material, low: DVec3, high: DVec3, chamfer: f64, bottom: bool) {
    let size = high - low;
    let per_metre = 0.7;
    // Corners as seen from above, counter-clockwise.
    let corner = |k: usize, y: f64, inset: f64| {
        let x = if k == 0 || k == 3 { low.x + inset } else { high.x - inset };
        let z = if k < 2 { high.z - inset } else { low.z + inset };
        dvec3(x, y, z)
    };
    for k in 0..4 {
        let (a, b) = (corner(k, low.y, 0.0), corner((k + 1) % 4, low.y, 0.0));
        rectangle(mesh, material, a, b - a, DVec3::Y * (size.y - chamfer), per_metre);
        let [c, d] = [k, (k + 1) % 4].map(|k| corner(k, high.y - chamfer, 0.0));
        let [e, f] = [k, (k + 1) % 4].map(|k| corner(k, high.y, chamfer));
        let length = (d - c).length();
        let segments = [mesh.segments(length * per_metre, 1), mesh.segments(0.8, 1)];
        let start = size.y - chamfer;
        mesh.grid(material, segments, Facing::Natural, [false; 2], |u, v| {
            (c.lerp(d, u).lerp(e.lerp(f, u), v), dvec2(u * length, -start - v * chamfer))
        });
    }
    let top = corner(0, high.y, chamfer);
    let (along_x, along_z) = (DVec3::X * (size.x - 2.0 * chamfer), DVec3::Z * (size.z - 2.0 * chamfer));
    rectangle(mesh, material, top, along_x, -along_z, per_metre);
    if bottom {
        rectangle(mesh, material, low, DVec3::X * size.x, DVec3::Z * size.z, per_metre);
    }
}

/// A surface of revolution about the `+Y` axis of the mesh's frame. `profile` gives, over 0..=1 and
/// upwards on the outside, radius and height; the radius may vary with the share of the turn.
pub fn revolve(
    mesh: &mut Mesh,
    material: Material,
    segments: [usize; 2],
    poles: [bool; 2],
    profile: impl Fn(f64, f64) -> DVec2,
) {
    // The texture must meet itself: a whole number of tiles around.
    let circumference = (1..8).fold(0.0f64, |r, k| r.max(profile(0.0, f64::from(k) / 8.0).x)) * TAU;
    let tile = material.tile_m();
    let around = (circumference / tile).round().max(1.0) * tile;
    let length: f64 = (0..8)
        .map(|k| (profile(0.0, f64::from(k + 1) / 8.0) - profile(0.0, f64::from(k) / 8.0)).length())
        .sum();
    mesh.grid(material, segments, Facing::Natural, poles, |u, v| {
        let (at, direction) = (profile(u, v), turn(u));
        (dvec3(at.x * direction.x, at.y, -at.x * direction.y), dvec2(u * around, -v * length))
    });
}

/// A turned body: stretches of profile, upwards on the outside, from `start`.
pub fn turned(mesh: &mut Mesh, material: Material, around: usize, start: [f64; 2], stretches: &[Stretch]) {
    let mut from = DVec2::from_array(start);
    for &(to, bulge) in stretches {
        let to = DVec2::from_array(to);
        let chord = to - from;
        let outwards = dvec2(chord.y, -chord.x) * bulge * 4.0;
        let along = if bulge == 0.0 { 1 } else { mesh.segments(5.0, 1) };
        let poles = [from.x == 0.0, to.x == 0.0];
        revolve(mesh, material, [around, along], poles, |_, t| from + chord * t + outwards * (t * (1.0 - t)));
        from = to;
    }
}

/// A sphere.
pub fn sphere(mesh: &mut Mesh, material: Material, centre: DVec3, radius: f64, around: usize) {
    let frame = mesh.frame;
    mesh.frame = frame * glam::DAffine3::from_translation(centre);
    revolve(mesh, material, [around, (around / 2).max(3)], [true; 2], |_, t| {
        let (sin, cos) = sin_cos(PI * t);
        dvec2(sin * radius, -cos * radius)
    });
    mesh.frame = frame;
}

/// A tube along `path` (over 0..=1). `side` gives a direction that is nowhere parallel to the path;
/// `radius` may vary with the share of the way and of the turn.
pub fn tube(
    mesh: &mut Mesh,
    material: Material,
    [along, around]: [usize; 2],
    path: impl Fn(f64) -> DVec3,
    side: impl Fn(f64) -> DVec3,
    radius: impl Fn(f64, f64) -> f64,
) {
    let length: f64 =
        (0..32).map(|k| (path(f64::from(k + 1) / 32.0) - path(f64::from(k) / 32.0)).length()).sum();
    let tile = material.tile_m();
    let girth = (TAU * radius(0.5, 0.25) / tile).round().max(1.0) * tile;
    mesh.grid(material, [along, around], Facing::Natural, [false; 2], |u, v| {
        // The tangent from a wider step than the mesh's own, whose differences this one enters.
        let step = 1e-3;
        let tangent = (path(u + step) - path(u - step)).normalize();
        let out = side(u);
        let first = (out - tangent * out.dot(tangent)).normalize();
        let second = first.cross(tangent);
        let direction = turn(v);
        let offset = (first * direction.x + second * direction.y) * radius(u, v);
        (path(u) + offset, dvec2(u * length, -v * girth))
    });
}

/// A straight tube without ends.
pub fn rod(mesh: &mut Mesh, material: Material, from: DVec3, to: DVec3, radius: f64, around: usize) {
    let side = (to - from).normalize().any_orthonormal_vector();
    tube(mesh, material, [1, around], |u| from.lerp(to, u), |_| side, |_, _| radius);
}

/// A ring in the plane of `x_axis` and `y_axis` (which may differ in length).
pub fn ring(mesh: &mut Mesh, material: Material, segments: [usize; 2], axes: [DVec3; 2], radius: f64) {
    let path = |u: f64| {
        let at = turn(u);
        axes[0] * at.x + axes[1] * at.y
    };
    let side = axes[0].cross(axes[1]);
    tube(mesh, material, segments, path, |_| side, |_, _| radius);
}

/// A moulding: a profile of (outwards, upwards) carried along a straight line. `out` is the
/// horizontal unit direction away from the wall.
pub fn moulding(
    mesh: &mut Mesh,
    material: Material,
    origin: DVec3,
    along: DVec3,
    out: DVec3,
    start: [f64; 2],
    stretches: &[Stretch],
) {
    let mut from = DVec2::from_array(start);
    let mut way = 0.0;
    let length = along.length();
    for &(to, bulge) in stretches {
        let to = DVec2::from_array(to);
        let chord = to - from;
        let bow = dvec2(chord.y, -chord.x) * bulge * 4.0;
        let across = if bulge == 0.0 { 1 } else { mesh.segments(5.0, 1) };
        let segments = [mesh.segments(length * 0.8, 1), across];
        let facing = Facing::Along(out * chord.y - DVec3::Y * chord.x);
        mesh.grid(material, segments, facing, [false; 2], |u, t| {
            let at = from + chord * t + bow * (t * (1.0 - t));
            let position = origin + along * u + out * at.x + DVec3::Y * at.y;
            (position, dvec2(u * length, -way - t * chord.length()))
        });
        way += chord.length();
        from = to;
    }
}

/// Sizes of an [`inset`] panel.
#[derive(Clone, Copy)]
pub struct Inset {
    /// Width of the flat frame; 0: none.
    pub margin: f64,
    /// Width of the slope between frame and panel.
    pub slope: f64,
    /// Height of the frame and of the panel above the surface.
    pub heights: [f64; 2],
    /// Segments along a side, of the slope, and of the panel in each direction.
    pub segments: [usize; 3],
}

/// A rectangular panel, sunken or raised, in a frame. `place` takes two coordinates along the
/// surface and the height above it.
pub fn inset(
    mesh: &mut Mesh,
    materials: [Material; 2],
    [low, high]: [DVec2; 2],
    shape: Inset,
    facing: Facing,
    place: impl Fn(DVec2, f64) -> DVec3,
) {
    let corner = |k: usize, by: f64| {
        let x = if k == 0 || k == 3 { low.x + by } else { high.x - by };
        let y = if k < 2 { low.y + by } else { high.y - by };
        dvec2(x, y)
    };
    let [side, slope, panel] = shape.segments;
    let mut strip = |material, [inner, outer]: [f64; 2], [bottom, top]: [f64; 2], across| {
        for k in 0..4 {
            let [a, b] = [k, (k + 1) % 4].map(|k| corner(k, outer));
            let [c, d] = [k, (k + 1) % 4].map(|k| corner(k, inner));
            mesh.grid(material, [side, across], facing, [false; 2], |u, v| {
                let at = a.lerp(b, u).lerp(c.lerp(d, u), v);
                (place(at, bottom + (top - bottom) * v), dvec2(at.x, -at.y))
            });
        }
    };
    let inner = shape.margin + shape.slope;
    if shape.margin > 0.0 {
        strip(materials[0], [shape.margin, 0.0], [shape.heights[0]; 2], 1);
    }
    strip(materials[0], [inner, shape.margin], shape.heights, slope);
    let (a, b) = (corner(0, inner), corner(2, inner));
    mesh.grid(materials[1], [panel, panel], facing, [false; 2], |u, v| {
        let at = a + (b - a) * dvec2(u, v);
        (place(at, shape.heights[1]), dvec2(at.x, -at.y))
    });
}

/// A rosette of petals, 2 `radius` wide, in the plane of x and z, seen from `+Y`.
pub fn rosette(mesh: &mut Mesh, material: Material, radius: f64, petals: f64, segments: [usize; 2]) {
    mesh.grid(material, segments, Facing::Natural, [false, true], |u, v| {
        let lobe = 0.5 + 0.5 * cos(TAU * u * petals);
        let out = radius * (1.0 - v) * (0.8 + 0.2 * lobe);
        let swell = v * (1.0 - v) * (1.6 + 1.2 * lobe) + 0.5 * v * v * (1.0 - v);
        let direction = turn(u);
        let height = radius * (0.06 + 0.5 * swell);
        (dvec3(out * direction.x, height, -out * direction.y), dvec2(u * radius * 4.0, -v * radius))
    });
}

/// Leans a point of a square onto a circle's outline: half-way between both, for cushions.
pub fn squircle(share: f64) -> f64 {
    let at = turn(share);
    let farthest = at.x.abs().max(at.y.abs());
    1.0 / (0.5 + 0.5 * farthest)
}
