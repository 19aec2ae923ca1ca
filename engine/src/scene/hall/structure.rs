//! The building: walls with their openings, columns, vault, floor and roofs.
//!
//! The nave runs along z; its walls stand on two rows of columns. All meshes of a bay are built
//! round the bay's middle on the inner face of the wall, which looks towards `+X`.

use super::materials::Material as M;
use super::math::{Random, sin_cos, smooth_step, turn, yaw};
use super::mesh::{Detail, Facing, Mesh};
use super::model::Model;
use super::shapes::{self, Inset, Stretch};
use glam::{DAffine3, DMat3, DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::{PI, TAU};

/// Length of one bay, metres.
pub const BAY: f64 = 5.0;
/// Number of bays.
pub const BAYS: u32 = 12;
/// Half the hall's length.
pub const HALF_LENGTH: f64 = 0.5 * BAY * BAYS as f64;
/// From the middle of the nave to its walls.
pub const NAVE_HALF: f64 = 5.0;
/// Thickness of the nave's walls.
pub const WALL: f64 = 1.0;
/// From the middle to the outer walls.
pub const OUTER_HALF: f64 = 12.0;
/// Where the arches spring.
pub const SPRING: f64 = 6.0;
/// Half the clear width of an arch.
pub const ARCH_HALF: f64 = 1.9;
/// Height of the aisles' ceiling.
pub const AISLE_HEIGHT: f64 = 8.2;
/// Where the vault springs.
pub const VAULT_SPRING: f64 = 11.0;
/// Distance of the columns' axes from the middle.
pub const COLUMN_X: f64 = NAVE_HALF + 0.5 * WALL;
/// Below these levels the vault, the nave's and the aisles' floor stay flat: their relief alone would
/// take all triangles.
const RELIEF_LEVELS: [f64; 3] = [0.4, 0.52, 0.66];

/// Middle of the bay with this number.
pub fn bay_z(bay: u32) -> f64 {
    (f64::from(bay) + 0.5) * BAY - HALF_LENGTH
}

/// A round-headed opening in a wall: half width, height of the sill and of the arch's springing.
#[derive(Clone, Copy)]
pub struct Opening {
    half: f64,
    sill: f64,
    spring: f64,
}

/// What lies in an opening.
#[derive(Clone, Copy)]
enum Depth {
    /// It goes through a wall of this thickness.
    Through(f64),
    /// It is a niche, half a cylinder under a quarter of a sphere.
    Niche,
}

/// A wall of `width` between two heights, its front at x = 0, pierced in the middle.
struct Wall {
    width: f64,
    heights: [f64; 2],
    opening: Opening,
    depth: Depth,
    front: M,
    inside: M,
}

impl Wall {
    /// The point `s` to the right, `t` up and `d` into the wall, as seen from the front.
    fn at(s: f64, t: f64, d: f64) -> DVec3 {
        dvec3(-d, t, -s)
    }

    fn build(&self, mesh: &mut Mesh) {
        self.face(mesh, 0.0, DVec3::X);
        match self.depth {
            Depth::Through(thickness) => {
                self.face(mesh, thickness, DVec3::NEG_X);
                self.jambs(mesh, thickness);
            }
            Depth::Niche => self.niche(mesh),
        }
    }

    /// Segments below the sill, beside the opening, beside the arch, across, and to the sides.
    fn segments(&self, mesh: &Mesh) -> [usize; 5] {
        let Opening { half, sill, spring } = self.opening;
        let flat = |length: f64| mesh.segments(0.8 * length, 1);
        [
            flat(sill - self.heights[0]),
            flat(spring - sill),
            flat(self.heights[1] - spring),
            mesh.segments(14.0, 6),
            flat(0.5 * self.width - half),
        ]
    }

    /// One side of the wall as patches whose borders share their points.
    fn face(&self, mesh: &mut Mesh, d: f64, out: DVec3) {
        let Opening { half, sill, spring } = self.opening;
        let [low, high] = self.heights;
        let [below, beside, above, across, side] = self.segments(mesh);
        let right = if out.x > 0.0 { 1.0 } else { -1.0 };
        let mut patch = |segments, at: &dyn Fn(f64, f64) -> DVec2| {
            mesh.grid(self.front, segments, Facing::Along(out), [false; 2], |u, v| {
                let p = at(u, v);
                (Self::at(p.x, p.y, d), dvec2(p.x * right, -p.y))
            });
        };
        let mut rows = vec![(spring, high, above)];
        if spring > sill {
            rows.push((sill, spring, beside));
        }
        if sill > low {
            rows.push((low, sill, below));
        }
        for &(from, to, count) in &rows {
            for (a, b) in [(-0.5 * self.width, -half), (half, 0.5 * self.width)] {
                patch([side, count], &|u, v| dvec2(a + (b - a) * u, from + (to - from) * v));
            }
        }
        if sill > low {
            patch([across, below], &|u, v| dvec2((2.0 * u - 1.0) * half, low + (sill - low) * v));
        }
        patch([across, above], &|u, v| {
            let at = turn(0.5 - 0.5 * u) * half;
            dvec2(at.x, spring + at.y + (high - spring - at.y) * v)
        });
    }

    /// The opening's own surfaces through the wall.
    fn jambs(&self, mesh: &mut Mesh, thickness: f64) {
        let Opening { half, sill, spring } = self.opening;
        let [_, beside, _, across, _] = self.segments(mesh);
        let centre = Self::at(0.0, 0.5 * (sill + spring), 0.5 * thickness);
        let deep = mesh.segments(2.0 * thickness, 1);
        let mut strip = |count, at: &dyn Fn(f64) -> DVec2, length: f64| {
            mesh.grid(self.inside, [deep, count], Facing::Towards(centre), [false; 2], |u, v| {
                let p = at(v);
                (Self::at(p.x, p.y, u * thickness), dvec2(u * thickness, -v * length))
            });
        };
        strip(across, &|t| turn(0.5 - 0.5 * t) * half + dvec2(0.0, spring), PI * half);
        if spring > sill {
            for side in [-half, half] {
                strip(beside, &|t| dvec2(side, sill + (spring - sill) * t), spring - sill);
            }
            if sill > self.heights[0] {
                strip(across, &|t| dvec2((2.0 * t - 1.0) * half, sill), 2.0 * half);
            }
        }
    }

    fn niche(&self, mesh: &mut Mesh) {
        let Opening { half, sill, spring } = self.opening;
        let [_, beside, _, across, _] = self.segments(mesh);
        let centre = Self::at(0.0, spring - 0.3, 0.0);
        let round = |u: f64, radius: f64| turn(0.5 - 0.5 * u) * radius;
        mesh.grid(self.inside, [across, beside], Facing::Towards(centre), [false; 2], |u, v| {
            let at = round(u, half);
            let height = sill + (spring - sill) * v;
            (Self::at(at.x, height, at.y), dvec2(u * PI * half, -height))
        });
        // The dome is a lathe about the line from the arch's middle into the wall.
        let around = mesh.segments(6.0, 3);
        mesh.grid(self.inside, [across, around], Facing::Towards(centre), [false, true], |u, v| {
            let (sin, cos) = sin_cos(0.5 * PI * v);
            let at = round(u, half * cos);
            (Self::at(at.x, spring + at.y, half * sin), dvec2(u * PI * half, -v * half))
        });
        let sill_centre = Self::at(0.0, sill + 1.0, 0.0);
        mesh.grid(M::DaisMarble, [across, 1], Facing::Towards(sill_centre), [true, false], |u, v| {
            let at = round(u, half * v);
            (Self::at(at.x, sill, at.y), at)
        });
    }
}

/// Half a ring of moulding round an arch on the wall's front.
fn archivolt(mesh: &mut Mesh, material: M, spring: f64, half: f64, thickness: f64) {
    let segments = [mesh.segments(16.0, 6), mesh.segments(7.0, 4)];
    let path = |u: f64| {
        let at = turn(0.5 - 0.5 * u) * half;
        Wall::at(at.x, spring + at.y, 0.0)
    };
    shapes::tube(mesh, material, segments, path, |_| DVec3::X, |_, _| thickness);
}

/// The cornice's profile: out of the wall, round, and back in.
const CORNICE: [Stretch; 5] =
    [([0.12, 0.06], 0.0), ([0.2, 0.2], 0.18), ([0.34, 0.3], -0.18), ([0.34, 0.38], 0.0), ([0.0, 0.42], 0.0)];

fn nave_wall(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("nave wall", detail);
    let opening = Opening { half: ARCH_HALF, sill: SPRING, spring: SPRING };
    let depth = Depth::Through(WALL);
    let heights = [SPRING, 8.4];
    let (front, inside) = (M::Limestone, M::ColumnMarble);
    Wall { width: BAY, heights, opening, depth, front, inside }.build(&mut mesh);
    let opening = Opening { half: 0.95, sill: 8.95, spring: 9.6 };
    let heights = [8.4, VAULT_SPRING];
    Wall { width: BAY, heights, opening, depth, front, inside: M::Plaster }.build(&mut mesh);
    if mesh.shows(0.06) {
        archivolt(&mut mesh, M::ColumnMarble, SPRING, ARCH_HALF + 0.14, 0.13);
    }
    if mesh.shows(0.22) {
        archivolt(&mut mesh, M::Plaster, 9.6, 0.95 + 0.08, 0.07);
    }
    let cornices: &[f64] = if mesh.shows(0.1) { &[8.3, 10.7] } else { &[8.3] };
    for &y in cornices {
        let from = dvec3(0.0, y, 0.5 * BAY);
        shapes::moulding(&mut mesh, M::Plaster, from, DVec3::NEG_Z * BAY, DVec3::X, [0.0, 0.0], &CORNICE);
    }
    if !mesh.shows(0.14) {
        return mesh;
    }
    // The same arch from the aisle.
    mesh.frame = DAffine3::from_rotation_translation(yaw(PI), dvec3(-WALL, 0.0, 0.0));
    archivolt(&mut mesh, M::ColumnMarble, SPRING, ARCH_HALF + 0.14, 0.13);
    // A keystone with a gilt rosette over each arch.
    mesh.frame = DAffine3::IDENTITY;
    let low = dvec3(-0.1, SPRING + ARCH_HALF - 0.02, -0.2);
    shapes::block(&mut mesh, M::ColumnMarble, low, low + dvec3(0.28, 0.46, 0.4), 0.03, true);
    let axes = DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y);
    mesh.frame = DAffine3 { matrix3: axes, translation: dvec3(0.18, 8.13, 0.0) };
    let segments = [mesh.segments(20.0, 6), mesh.segments(4.0, 2)];
    shapes::rosette(&mut mesh, M::GiltOrnament, 0.15, 6.0, segments);
    mesh
}

fn aisle(detail: Detail, niche: bool) -> Mesh {
    let mut mesh = Mesh::new(if niche { "aisle bay with niche" } else { "aisle bay with window" }, detail);
    let heights = [0.0, AISLE_HEIGHT];
    let front = M::Limestone;
    let wall = if niche {
        let opening = Opening { half: 0.95, sill: 0.9, spring: 3.4 };
        Wall { width: BAY, heights, opening, depth: Depth::Niche, front, inside: M::Brick }
    } else {
        let opening = Opening { half: 0.85, sill: 1.7, spring: 4.7 };
        Wall { width: BAY, heights, opening, depth: Depth::Through(0.8), front, inside: M::Limestone }
    };
    wall.build(&mut mesh);
    let whole = dvec3(0.0, 0.0, 0.5 * BAY);
    let back = DVec3::NEG_Z * BAY;
    if mesh.shows(0.18) {
        archivolt(&mut mesh, M::ColumnMarble, wall.opening.spring, wall.opening.half + 0.09, 0.08);
        let skirting = [([0.12, 0.28], 0.0), ([0.0, 0.42], 0.2)];
        shapes::moulding(&mut mesh, M::NeroMarble, whole, back, DVec3::X, [0.12, 0.0], &skirting);
        let top = whole + DVec3::Y * (AISLE_HEIGHT - 0.4);
        shapes::moulding(&mut mesh, M::Oak, top, back, DVec3::X, [0.0, 0.0], &CORNICE);
    }
    // Ceiling, beams and roof.
    let span = OUTER_HALF - NAVE_HALF - WALL;
    let corner = dvec3(0.0, AISLE_HEIGHT, -0.5 * BAY);
    shapes::rectangle(&mut mesh, M::Oak, corner, DVec3::X * span, DVec3::Z * BAY, 0.6);
    mesh.frame = DAffine3::from_scale_rotation_translation(
        DVec3::ONE,
        glam::DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0),
        dvec3(span, AISLE_HEIGHT, 0.0),
    );
    let beams = if mesh.shows(0.28) { 4 } else { usize::from(mesh.shows(0.08)) };
    let all = [(-2.5, 0.18, 0.4), (-1.25, 0.09, 0.2), (0.0, 0.09, 0.2), (1.25, 0.09, 0.2)];
    for &(z, half, height) in &all[..beams] {
        let low = dvec3(0.0, -0.02, z - half);
        shapes::block(&mut mesh, M::Oak, low, dvec3(span, height, z + half), 0.03, false);
    }
    mesh.frame = DAffine3::IDENTITY;
    let eaves = dvec3(-1.1, AISLE_HEIGHT + 0.15, 0.5 * BAY);
    let slope = dvec3(span + 1.1, 0.45, 0.0);
    shapes::rectangle(&mut mesh, M::RoofSlate, eaves, slope, back, 0.3);
    if !niche {
        // The lattice stands inside the wall's thickness, so that its corners are hidden by the arch.
        let low = dvec3(-0.45, 1.7, 0.95);
        let (wide, tall) = (DVec3::NEG_Z * 1.9, DVec3::Y * 4.0);
        shapes::rectangle(&mut mesh, M::LatticeScreen, low, wide, tall, 0.5);
    } else {
        let low = dvec3(-0.97, 0.0, 0.5 * BAY);
        shapes::rectangle(&mut mesh, M::RoofSlate, low, back, DVec3::Y * AISLE_HEIGHT, 0.2);
    }
    mesh
}

/// An end of the hall, seen along `+X`: the middle is the nave's.
fn end_wall(detail: Detail, gate: bool) -> Mesh {
    let mut mesh = Mesh::new(if gate { "gate wall" } else { "apse wall" }, detail);
    let opening = if gate {
        Opening { half: 1.6, sill: 0.0, spring: 3.2 }
    } else {
        Opening { half: 3.1, sill: 0.7, spring: 5.9 }
    };
    let (depth, front, inside) = (Depth::Through(WALL), M::Limestone, M::ColumnMarble);
    let width = 2.0 * (NAVE_HALF + WALL);
    Wall { width, heights: [0.0, VAULT_SPRING], opening, depth, front, inside }.build(&mut mesh);
    archivolt(&mut mesh, M::ColumnMarble, opening.spring, opening.half + 0.15, 0.16);
    let eye = dvec2(0.0, VAULT_SPRING + 2.2);
    let eye_radius = 1.35;
    let segments = [mesh.segments(14.0, 6), mesh.segments(3.0, 1)];
    let outline = |over: bool, u: f64| {
        let rim =
            if over { turn(0.5 - 0.5 * u) * NAVE_HALF } else { dvec2((1.0 - 2.0 * u) * NAVE_HALF, 0.0) };
        rim + dvec2(0.0, VAULT_SPRING)
    };
    // From the corners, the round window's rim is seen at these shares of a turn.
    let (left, right) = (0.5 + 0.066, -0.066);
    for over in [true, false] {
        for (d, out) in [(0.0, DVec3::X), (WALL, DVec3::NEG_X)] {
            mesh.grid(M::Limestone, segments, Facing::Along(out), [false; 2], |u, v| {
                let share = if over { left + (right - left) * u } else { right + (left - 1.0 - right) * u };
                let p = (eye + turn(share) * eye_radius).lerp(outline(over, u), v);
                (Wall::at(p.x, p.y, d), dvec2(p.x, -p.y))
            });
        }
    }
    let middle = Wall::at(eye.x, eye.y, 0.5 * WALL);
    mesh.grid(M::Plaster, [segments[0] * 2, 1], Facing::Towards(middle), [false; 2], |u, v| {
        let p = eye + turn(u) * eye_radius;
        (Wall::at(p.x, p.y, v * WALL), dvec2(u * TAU * eye_radius, v))
    });
    let axes = [DVec3::NEG_Z, DVec3::Y].map(|axis| axis * (eye_radius + 0.1));
    mesh.frame = DAffine3::from_translation(Wall::at(eye.x, eye.y, 0.0));
    let rim = [mesh.segments(28.0, 10), mesh.segments(7.0, 4)];
    shapes::ring(&mut mesh, M::GiltOrnament, rim, axes, 0.1);
    let span = OUTER_HALF - NAVE_HALF - WALL;
    let opening = Opening { half: 1.3, sill: 1.2, spring: 4.6 };
    for side in [-1.0, 1.0] {
        let to = dvec3(0.0, 0.0, side * (NAVE_HALF + WALL + 0.5 * span));
        mesh.frame = DAffine3::from_translation(to);
        Wall { width: span, heights: [0.0, AISLE_HEIGHT], opening, depth, front, inside }.build(&mut mesh);
        archivolt(&mut mesh, M::ColumnMarble, opening.spring, opening.half + 0.12, 0.1);
        let (low, wide) = (dvec3(-0.5, 1.2, 1.4), DVec3::NEG_Z * 2.8);
        shapes::rectangle(&mut mesh, M::LatticeScreen, low, wide, DVec3::Y * 4.8, 0.5);
    }
    mesh.frame = DAffine3::IDENTITY;
    if gate && mesh.shows(0.1) {
        for z in [-1.6, 0.02] {
            let low = dvec3(-0.6, 0.0, z);
            shapes::block(&mut mesh, M::Oak, low, dvec3(-0.45, 4.85, z + 1.58), 0.02, false);
        }
    }
    mesh
}

/// A fluted column with base and capital, round the `+Y` axis.
fn column(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("column", detail);
    let around = mesh.segments(32.0, 7);
    if mesh.shows(0.05) {
        let low = dvec3(-0.66, 0.0, -0.66);
        shapes::block(&mut mesh, M::NeroMarble, low, dvec3(0.66, 0.3, 0.66), 0.03, false);
    } else {
        shapes::turned(&mut mesh, M::NeroMarble, 4, [0.7, 0.0], &[([0.5, 0.7], 0.0)]);
    }
    let base = [
        ([0.6, 0.48], 0.5),
        ([0.54, 0.5], 0.0),
        ([0.52, 0.58], -0.25),
        ([0.54, 0.6], 0.0),
        ([0.5, 0.7], 0.5),
    ];
    if mesh.shows(0.05) {
        shapes::turned(&mut mesh, M::ColumnMarble, around, [0.6, 0.3], &base);
    }
    // Flutes need four segments each; a coarser shaft is smooth.
    let fluted = mesh.segments(3.6, 0) >= 3;
    let shaft = if fluted { 20 * mesh.segments(3.6, 3) } else { around };
    let flutes = if fluted { 0.026 } else { 0.0 };
    let along = mesh.segments(12.0, 1);
    shapes::revolve(&mut mesh, M::ColumnMarble, [shaft, along], [false; 2], |u, t| {
        // Entasis: the shaft swells a little before it tapers.
        let radius = 0.465 - 0.075 * t + 0.05 * t * (1.0 - t);
        let ends = smooth_step(0.01, 0.04, t) * (1.0 - smooth_step(0.96, 0.99, t));
        let hollow = 0.5 - 0.5 * turn(20.0 * u).x;
        dvec2(radius - flutes * ends * hollow, 0.7 + 4.35 * t)
    });
    let necking = [([0.43, 5.11], 0.5), ([0.4, 5.13], 0.0), ([0.6, 5.74], -0.14)];
    let necking = if mesh.shows(0.05) { &necking[..] } else { &necking[2..] };
    shapes::turned(&mut mesh, M::ColumnMarble, around, [0.39, 5.05], necking);
    let low = dvec3(-0.64, 5.74, -0.64);
    mesh.frame = DAffine3::IDENTITY;
    shapes::block(&mut mesh, M::ColumnMarble, low, dvec3(0.64, SPRING + 0.001, 0.64), 0.04, true);
    let leaf = [mesh.segments(4.0, 1), mesh.segments(7.0, 2)];
    let rows = if mesh.shows(0.24) { 2 } else { u32::from(mesh.shows(0.12)) };
    for row in 0..rows {
        for k in 0..8u32 {
            let middle = (f64::from(k) + 0.5 * f64::from(row)) / 8.0;
            let height = 0.3 + 0.24 * f64::from(row);
            mesh.grid(M::GiltOrnament, leaf, Facing::Natural, [false; 2], |u, v| {
                let width = 0.058 * (1.0 - 0.75 * v * v);
                let share = middle + width * (2.0 * u - 1.0);
                let crease = 1.0 - (2.0 * u - 1.0) * (2.0 * u - 1.0);
                // The tip leaves the bell and curls down.
                let out = 0.415 + 0.1 * v * height + 0.03 * crease + 0.26 * v * v * v * v;
                let rise = 5.13 + height * (v + 0.2 * v * v - 0.34 * v * v * v * v);
                let at = turn(share) * out;
                (dvec3(at.x, rise, -at.y), dvec2(u * 0.3, -v * height))
            });
        }
    }
    mesh
}

fn vault(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("vault bay", detail);
    let radius = NAVE_HALF;
    let place = |at: DVec2, height: f64| {
        let direction = turn(0.5 - 0.5 * at.x / (PI * radius)) * (radius - height);
        dvec3(direction.x, VAULT_SPRING + direction.y, 0.5 * BAY - at.y)
    };
    let inwards = Facing::Towards(dvec3(0.0, VAULT_SPRING + 0.2, 0.0));
    let around = mesh.segments(20.0, 8);
    if !detail.shows(RELIEF_LEVELS[0]) {
        mesh.grid(M::Plaster, [around, 2], inwards, [false; 2], |u, v| {
            let at = dvec2(PI * radius * u, BAY * v);
            (place(at, 0.0), dvec2(at.x, -at.y))
        });
    } else {
        let cell = dvec2(PI * radius / 9.0, 0.5 * BAY);
        let segments = [mesh.segments(2.0, 1), mesh.segments(1.0, 1), mesh.segments(3.0, 1)];
        for k in 0..18u32 {
            let low = cell * dvec2(f64::from(k % 9), f64::from(k / 9));
            let shape = Inset { margin: 0.24, slope: 0.16, heights: [0.0, -0.24], segments };
            let materials = [M::Plaster, M::Plaster];
            shapes::inset(&mut mesh, materials, [low, low + cell], shape, inwards, place);
            if !detail.shows(0.6) {
                continue;
            }
            let middle = low + 0.5 * cell;
            let up = (place(middle, 0.0) - place(middle, -1.0)).normalize();
            let side = DVec3::Z.cross(up);
            let axes = DMat3::from_cols(side, up, side.cross(up));
            mesh.frame = DAffine3 { matrix3: axes, translation: place(middle, -0.24) };
            let petals = [mesh.segments(16.0, 8), mesh.segments(3.0, 2)];
            shapes::rosette(&mut mesh, M::GiltOrnament, 0.36, 8.0, petals);
            mesh.frame = DAffine3::IDENTITY;
        }
    }
    let out = NAVE_HALF + WALL;
    mesh.grid(M::RoofSlate, [around / 2, 1], Facing::Along(DVec3::Y), [false; 2], |u, v| {
        let at = turn(0.5 - 0.5 * u) * out;
        (dvec3(at.x, VAULT_SPRING + at.y, (0.5 - v) * BAY), dvec2(u * PI * out, v * BAY))
    });
    mesh
}

fn rib(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("vault rib", detail);
    let segments = [mesh.segments(32.0, 8), mesh.segments(8.0, 3)];
    let path = |u: f64| {
        let at = turn(0.5 - 0.5 * u) * NAVE_HALF;
        dvec3(at.x, VAULT_SPRING + at.y, 0.0)
    };
    shapes::tube(&mut mesh, M::ColumnMarble, segments, path, |_| DVec3::Z, |_, _| 0.24);
    mesh
}

/// Tiles with chamfered edges, each a little tilted; chequered by two materials.
fn tiles(mesh: &mut Mesh, materials: [M; 2], low: DVec2, [columns, rows]: [u32; 2], random: &mut Random) {
    let relief = RELIEF_LEVELS[if materials[0] == materials[1] { 2 } else { 1 }];
    if !mesh.shows(relief) {
        let size = dvec2(f64::from(columns), f64::from(rows));
        let from = dvec3(low.x, 0.0, low.y + size.y);
        let (wide, long) = (DVec3::X * size.x, DVec3::NEG_Z * size.y);
        return shapes::rectangle(mesh, materials[0], from, wide, long, 0.5);
    }
    let segments = [mesh.segments(1.6, 1), mesh.segments(1.0, 1), mesh.segments(1.6, 1)];
    let shape = Inset { margin: 0.0, slope: 0.012, heights: [-0.008, 0.0], segments };
    for k in 0..columns * rows {
        let (column, row) = (k % columns, k / columns);
        let material = materials[((column + row) % 2) as usize];
        let corner = low + dvec2(f64::from(column), f64::from(row));
        let tilt = dvec2(random.range(-0.0025, 0.0025), random.range(-0.0025, 0.0025));
        let place = |at: DVec2, height: f64| {
            // Joints stay level, so that neighbours meet; the tops tilt.
            let share = (height + 0.008) / 0.008;
            dvec3(at.x, height + share * tilt.dot(at - corner - 0.5), at.y)
        };
        let facing = Facing::Along(DVec3::Y);
        shapes::inset(mesh, [material; 2], [corner, corner + 1.0], shape, facing, place);
    }
}

fn floor(detail: Detail, seed: u64, nave: bool) -> Mesh {
    let mut random = Random::new(seed, 11 + u64::from(nave));
    let mut mesh = Mesh::new(if nave { "nave floor" } else { "aisle floor" }, detail);
    if nave {
        tiles(&mut mesh, [M::TileLight, M::TileDark], dvec2(-6.0, -2.5), [12, 5], &mut random);
    } else {
        tiles(&mut mesh, [M::TileClay, M::TileClay], dvec2(0.0, -2.5), [6, 5], &mut random);
    }
    mesh
}

/// Builds the building and places it.
pub fn build(model: &mut Model, detail: Detail, seed: u64) {
    let wall = model.add(nave_wall(detail));
    let aisles = [model.add(aisle(detail, false)), model.add(aisle(detail, true))];
    let floors = [floor(detail, seed, true), floor(detail, seed, false)].map(|mesh| model.add(mesh));
    let (vault, rib) = (model.add(vault(detail)), model.add(rib(detail)));
    let column = model.add(column(detail));
    for bay in 0..BAYS {
        let z = bay_z(bay);
        for (side, angle) in [(-1.0, 0.0), (1.0, PI)] {
            model.place(wall, dvec3(side * NAVE_HALF, 0.0, z), yaw(angle));
            model.place(aisles[(bay % 2) as usize], dvec3(side * OUTER_HALF, 0.0, z), yaw(angle));
            model.place(floors[1], dvec3(side * OUTER_HALF, 0.0, z), yaw(angle));
            if bay > 0 {
                model.place(column, dvec3(side * COLUMN_X, 0.0, z - 0.5 * BAY), yaw(0.0));
            }
        }
        model.place(floors[0], dvec3(0.0, 0.0, z), yaw(if bay % 2 == 0 { 0.0 } else { PI }));
        model.place(vault, dvec3(0.0, 0.0, z), yaw(0.0));
    }
    for k in 0..=BAYS {
        model.place(rib, dvec3(0.0, 0.0, f64::from(k) * BAY - HALF_LENGTH), yaw(0.0));
    }
    let ends = [end_wall(detail, false), end_wall(detail, true)].map(|mesh| model.add(mesh));
    model.place(ends[0], dvec3(0.0, 0.0, -HALF_LENGTH), yaw(-0.5 * PI));
    model.place(ends[1], dvec3(0.0, 0.0, HALF_LENGTH), yaw(0.5 * PI));
}
