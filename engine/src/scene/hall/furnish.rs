//! What stands and hangs in the hall.

use super::materials::Material as M;
use super::math::{noise, sin, turn, yaw};
use super::mesh::{Detail, Facing, Mesh};
use super::model::Model;
use super::shapes;
use super::structure::{ARCH_HALF, BAY, BAYS, COLUMN_X, HALF_LENGTH, NAVE_HALF, SPRING, WALL};
use super::structure::{OUTER_HALF, bay_z};
use glam::{DAffine3, DQuat, DVec3, dvec2, dvec3};
use std::f64::consts::{PI, TAU};

/// Height of the dais.
pub const DAIS_HEIGHT: f64 = 0.7;
/// Middle of the sculpture.
pub const SCULPTURE: DVec3 = DVec3::new(0.0, 3.75, -24.5);
/// Where the pedestals with spheres stand, on both sides.
const PEDESTALS_Z: [f64; 4] = [15.0, 5.0, -5.0, -13.0];
/// Chandeliers in the nave.
pub const CHANDELIERS_Z: [f64; 3] = [10.0, -5.0, -17.0];
/// Height of their rings.
pub const CHANDELIER_HEIGHT: f64 = 9.2;
/// Where the braziers stand.
pub const BRAZIERS: [DVec3; 6] = [
    dvec3(-2.9, 0.0, -18.3),
    dvec3(2.9, 0.0, -18.3),
    dvec3(-3.3, 0.0, 20.0),
    dvec3(3.3, 0.0, 20.0),
    dvec3(-9.0, 0.0, -26.5),
    dvec3(9.0, 0.0, -26.5),
];

/// Middle of a lantern under the arch of this bay on the left (-1) or right (1).
pub fn lantern_place(bay: u32, side: f64) -> DVec3 {
    dvec3(side * COLUMN_X, SPRING + ARCH_HALF - 1.75, bay_z(bay))
}

fn dais(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("dais", detail);
    for step in 0..4u32 {
        let by = 0.38 * f64::from(step);
        let low = dvec3(-4.75 + 0.3 * by, 0.175 * f64::from(step), -HALF_LENGTH);
        let high = dvec3(4.75 - 0.3 * by, low.y + 0.175, -19.3 - by);
        shapes::block(&mut mesh, M::DaisMarble, low, high, 0.025, false);
    }
    mesh
}

fn sculpture(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("knot", detail);
    let around = mesh.segments(48.0, 10);
    let profile = [
        ([1.15, 0.14], 0.0),
        ([1.05, 0.24], 0.4),
        ([0.9, 0.32], -0.3),
        ([0.86, 1.0], 0.0),
        ([1.02, 1.1], -0.3),
        ([1.02, 1.2], 0.3),
        ([0.0, 1.2], 0.0),
    ];
    shapes::turned(&mut mesh, M::NeroMarble, around, [1.15, 0.0], &profile);
    mesh.frame = DAffine3::from_translation(dvec3(0.0, SCULPTURE.y - DAIS_HEIGHT, 0.0));
    let core = |u: f64| {
        let at = turn(2.0 * u);
        dvec3(at.x, at.y, 0.0)
    };
    let path = |u: f64| {
        let at = turn(3.0 * u);
        core(u) * (1.06 + 0.5 * at.x) + DVec3::Z * (0.5 * at.y)
    };
    let segments = [mesh.segments(260.0, 40), mesh.segments(32.0, 5)];
    // Four rounded lobes that wind six times on the way round.
    let lobes = |u: f64, v: f64| 0.235 * (1.0 + 0.13 * turn(4.0 * v + 6.0 * u).x);
    shapes::tube(&mut mesh, M::PolishedGold, segments, path, |u| path(u) - core(u) * 1.06, lobes);
    mesh
}

fn pedestal(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("pedestal", detail);
    if !mesh.shows(0.09) {
        let profile = [([0.24, 1.12], 0.0), ([0.0, 1.12], 0.0)];
        shapes::turned(&mut mesh, M::ColumnMarble, 4, [0.3, 0.0], &profile);
        return mesh;
    }
    let low = dvec3(-0.34, 0.0, -0.34);
    shapes::block(&mut mesh, M::NeroMarble, low, dvec3(0.34, 0.14, 0.34), 0.02, false);
    let around = mesh.segments(28.0, 6);
    let profile = [
        ([0.24, 0.2], 0.4),
        ([0.19, 0.28], -0.3),
        ([0.17, 0.95], 0.02),
        ([0.27, 1.06], -0.25),
        ([0.27, 1.12], 0.3),
        ([0.0, 1.12], 0.0),
    ];
    shapes::turned(&mut mesh, M::ColumnMarble, around, [0.28, 0.14], &profile);
    mesh
}

fn ball(detail: Detail, material: M) -> Mesh {
    let mut mesh = Mesh::new("ball", detail);
    let around = mesh.segments(48.0, 8);
    shapes::sphere(&mut mesh, material, dvec3(0.0, 1.5, 0.0), 0.38, around);
    mesh
}

fn twist(detail: Detail, material: M) -> Mesh {
    let mut mesh = Mesh::new("twisted pillar", detail);
    let low = dvec3(-0.6, 0.0, -0.6);
    shapes::block(&mut mesh, M::NeroMarble, low, dvec3(0.6, 0.4, 0.6), 0.04, false);
    mesh.frame = DAffine3::from_translation(DVec3::Y * 0.4);
    let segments = [mesh.segments(48.0, 8), mesh.segments(70.0, 8)];
    // The vertices turn with the square, so that they stay on its edges.
    mesh.grid(material, segments, Facing::Natural, [false, true], |u, t| {
        let radius = 0.42 * (1.0 - t * t * t) * (1.0 - 0.25 * sin(PI * t));
        let at = turn(u + 0.8 * t) * radius * shapes::squircle(u);
        (dvec3(at.x, 2.9 * t, -at.y), dvec2(3.2 * u, -2.9 * t))
    });
    mesh
}

/// The vessels in the niches: four shapes in four materials.
fn vessel(detail: Detail, kind: usize) -> Mesh {
    let mut mesh = Mesh::new(["amphora", "bottle", "urn", "draped figure"][kind], detail);
    let around = mesh.segments(36.0, 6);
    if !mesh.shows(0.11) {
        let profile = [([0.36, 1.1], 0.0), ([0.1, 1.9], 0.0)];
        shapes::turned(&mut mesh, M::Terracotta, around, [0.24, 0.0], &profile);
        return mesh;
    }
    let low = dvec3(-0.36, 0.0, -0.36);
    shapes::block(&mut mesh, M::DaisMarble, low, dvec3(0.36, 0.3, 0.36), 0.02, false);
    mesh.frame = DAffine3::from_translation(DVec3::Y * 0.3);
    match kind {
        0 => {
            let profile =
                [([0.14, 0.1], -0.3), ([0.42, 0.95], 0.2), ([0.15, 1.45], 0.12), ([0.16, 1.62], -0.1)];
            shapes::turned(&mut mesh, M::Terracotta, around, [0.2, 0.0], &profile);
            let lip = [([0.22, 1.7], 0.3), ([0.17, 1.71], 0.3), ([0.13, 1.5], 0.0), ([0.0, 1.4], 0.0)];
            shapes::turned(&mut mesh, M::Terracotta, around, [0.16, 1.62], &lip);
            for side in [-1.0, 1.0] {
                let segments = [mesh.segments(16.0, 5), mesh.segments(8.0, 4)];
                let path = |u: f64| {
                    let at = turn(0.31 - 0.56 * u);
                    dvec3(side * (0.24 + 0.17 * at.x), 1.3 + 0.25 * at.y, 0.0)
                };
                shapes::tube(&mut mesh, M::Terracotta, segments, path, |_| DVec3::Z, |_, _| 0.032);
            }
        }
        1 => {
            let profile =
                [([0.36, 0.45], 0.22), ([0.09, 0.98], 0.25), ([0.075, 1.55], 0.0), ([0.14, 1.66], -0.2)];
            shapes::turned(&mut mesh, M::CobaltGlaze, around, [0.24, 0.0], &profile);
            let lip = [([0.06, 1.64], 0.3), ([0.0, 1.2], 0.0)];
            shapes::turned(&mut mesh, M::CobaltGlaze, around, [0.14, 1.66], &lip);
        }
        2 => {
            let along = mesh.segments(30.0, 5);
            // Gadroons: eighteen round ribs on the belly.
            shapes::revolve(&mut mesh, M::CeladonGlaze, [around, along], [false; 2], |u, t| {
                let ribs = if around >= 72 { 0.02 * turn(18.0 * u).x * sin(PI * t).powi(2) } else { 0.0 };
                dvec2(0.16 + 0.3 * sin(PI * (0.08 + 0.84 * t)) + ribs, 1.05 * t)
            });
            let lid = [([0.27, 1.1], 0.0), ([0.06, 1.42], 0.2), ([0.1, 1.5], 0.5), ([0.0, 1.6], 0.4)];
            shapes::turned(&mut mesh, M::GiltOrnament, around, [0.24, 1.05], &lid);
        }
        _ => {
            let along = mesh.segments(36.0, 8);
            shapes::revolve(&mut mesh, M::AgedBronze, [around, along], [false, true], |u, t| {
                let body = 0.36 - 0.5 * t + 0.62 * t * t;
                let shoulders = 1.0 - (t * t * t * t * t * t);
                let folds =
                    if around >= 28 { 1.0 - 0.09 * (1.0 - t) * turn(7.0 * u + 0.4 * t).x } else { 1.0 };
                dvec2(body * shoulders * folds * 0.85, 1.55 * t)
            });
            shapes::sphere(&mut mesh, M::AgedBronze, dvec3(0.0, 1.68, 0.0), 0.16, around.min(24));
        }
    }
    mesh
}

fn banner(detail: Detail, cloth: M) -> Mesh {
    let mut mesh = Mesh::new("banner", detail);
    let segments = [mesh.segments(22.0, 2), mesh.segments(44.0, 3)];
    mesh.grid(cloth, segments, Facing::Along(DVec3::Z), [false; 2], |u, v| {
        let tail = 0.35 * v * (1.0 - (2.0 * u - 1.0).abs());
        let wave = 0.07 * v * sin(9.0 * u + 3.0 * v) + 0.05 * v * sin(6.0 * v - 2.0 * u);
        (dvec3(0.12 + 1.2 * u, -v * (3.0 - tail), wave), dvec2(u, v))
    });
    if !mesh.shows(0.09) {
        return mesh;
    }
    let around = mesh.segments(10.0, 4);
    shapes::rod(&mut mesh, M::AgedBronze, DVec3::ZERO, DVec3::X * 1.42, 0.028, around);
    shapes::sphere(&mut mesh, M::GiltOrnament, DVec3::X * 1.45, 0.06, around);
    mesh
}

/// A chain from `top` down to `bottom`, of links where the level of detail allows them.
fn chain(mesh: &mut Mesh, top: f64, bottom: f64) {
    if mesh.segments(10.0, 0) < 8 {
        return shapes::rod(mesh, M::WroughtIron, DVec3::Y * bottom, DVec3::Y * top, 0.012, 3);
    }
    let links = ((top - bottom) / 0.1).round();
    let frame = mesh.frame;
    let segments = [mesh.segments(10.0, 8), mesh.segments(5.0, 3)];
    for link in 0..links as u32 {
        let middle = top + (bottom - top) * (f64::from(link) + 0.5) / links;
        mesh.frame = frame * DAffine3::from_translation(DVec3::Y * middle);
        let wide = if link % 2 == 0 { DVec3::X } else { DVec3::Z };
        shapes::ring(mesh, M::WroughtIron, segments, [wide * 0.035, DVec3::Y * 0.062], 0.011);
    }
    mesh.frame = frame;
}

fn lantern(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("lantern", detail);
    if !mesh.shows(0.07) {
        let glass = [([0.2, 0.2], 0.0), ([0.0, 0.5], 0.0)];
        shapes::turned(&mut mesh, M::LanternGlass, 4, [0.14, -0.3], &glass);
        return mesh;
    }
    chain(&mut mesh, 1.75, 0.62);
    let around = mesh.segments(24.0, 6);
    let glass = [([0.2, -0.1], 0.1), ([0.2, 0.2], 0.08), ([0.14, 0.34], 0.0)];
    shapes::turned(&mut mesh, M::LanternGlass, around, [0.12, -0.3], &glass);
    let cap = [([0.25, 0.36], 0.2), ([0.1, 0.48], -0.25), ([0.04, 0.62], -0.1), ([0.0, 0.64], 0.2)];
    shapes::turned(&mut mesh, M::AgedBronze, around, [0.14, 0.32], &cap);
    let foot = [([0.05, -0.4], -0.2), ([0.14, -0.34], 0.1), ([0.12, -0.29], 0.3)];
    shapes::turned(&mut mesh, M::AgedBronze, around, [0.0, -0.46], &foot);
    if !mesh.shows(0.2) {
        return mesh;
    }
    let sides = mesh.segments(6.0, 3);
    for k in 0..6u32 {
        let at = turn(f64::from(k) / 6.0);
        let direction = dvec3(at.x, 0.0, at.y);
        let (low, high) = (direction * 0.14 - DVec3::Y * 0.32, direction * 0.225 - DVec3::Y * 0.1);
        shapes::rod(&mut mesh, M::AgedBronze, low, high, 0.012, sides);
        shapes::rod(&mut mesh, M::AgedBronze, high, direction * 0.22 + DVec3::Y * 0.34, 0.012, sides);
    }
    mesh
}

fn chandelier(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("chandelier", detail);
    let rim = [mesh.segments(72.0, 12), mesh.segments(9.0, 4)];
    for (radius, height) in [(1.5, 0.0), (0.75, 0.6)] {
        mesh.frame = DAffine3::from_translation(DVec3::Y * height);
        shapes::ring(&mut mesh, M::AgedBronze, rim, [DVec3::X * radius, DVec3::Z * -radius], 0.05);
    }
    mesh.frame = DAffine3::IDENTITY;
    let around = mesh.segments(16.0, 5);
    let candles = if mesh.shows(0.16) { 12 } else { 0 };
    for k in 0..candles {
        let at = turn(f64::from(k) / 12.0) * 1.5;
        mesh.frame = DAffine3::from_translation(dvec3(at.x, 0.0, at.y));
        let candle = [([0.1, 0.09], 0.1), ([0.035, 0.1], 0.0), ([0.07, 0.2], 0.3), ([0.0, 0.38], 0.1)];
        shapes::turned(&mut mesh, M::GiltOrnament, around, [0.03, 0.02], &candle[..2]);
        shapes::turned(&mut mesh, M::LanternGlass, around, [0.035, 0.1], &candle[2..]);
    }
    mesh.frame = DAffine3::IDENTITY;
    if !mesh.shows(0.06) {
        return mesh;
    }
    for k in 0..4u32 {
        let at = turn(f64::from(k) / 4.0);
        let out = dvec3(at.x, 0.0, at.y);
        shapes::rod(&mut mesh, M::WroughtIron, out * 1.5, out * 0.75 + DVec3::Y * 0.6, 0.02, 4);
        shapes::rod(&mut mesh, M::WroughtIron, out * 0.75 + DVec3::Y * 0.6, DVec3::Y * 1.9, 0.02, 4);
    }
    chain(&mut mesh, 6.6, 1.9);
    mesh
}

fn brazier(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("brazier", detail);
    let around = mesh.segments(32.0, 6);
    let bowl = [([0.34, 1.0], 0.2), ([0.46, 1.12], -0.1), ([0.5, 1.16], 0.4), ([0.4, 1.13], 0.2)];
    shapes::turned(&mut mesh, M::WroughtIron, around, [0.0, 0.82], &bowl);
    shapes::turned(&mut mesh, M::WroughtIron, around, [0.4, 1.13], &[([0.3, 1.0], 0.0)]);
    let along = mesh.segments(14.0, 3);
    shapes::revolve(&mut mesh, M::Embers, [around, along], [false, true], |u, t| {
        let lumps = 0.06 * noise(u, 0.9 * t, 9, 77);
        dvec2(0.33 * (1.0 - t), 1.03 + (0.16 + lumps) * t * (2.0 - t))
    });
    if !mesh.shows(0.06) {
        return mesh;
    }
    let sides = mesh.segments(8.0, 3);
    for k in 0..3u32 {
        let at = turn(f64::from(k) / 3.0);
        let out = dvec3(at.x, 0.0, at.y);
        shapes::rod(&mut mesh, M::WroughtIron, out * 0.42, out * 0.3 + DVec3::Y * 1.0, 0.03, sides);
    }
    let rim = [mesh.segments(24.0, 6), mesh.segments(6.0, 3)];
    mesh.frame = DAffine3::from_translation(DVec3::Y * 0.35);
    shapes::ring(&mut mesh, M::WroughtIron, rim, [DVec3::X * 0.38, DVec3::Z * -0.38], 0.02);
    mesh
}

fn railing(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("railing", detail);
    let around = mesh.segments(14.0, 4);
    let balusters = if mesh.shows(0.13) { 9 } else { 0 };
    for k in 0..balusters {
        mesh.frame = DAffine3::from_translation(dvec3(0.15 + 0.3 * f64::from(k), 0.08, 0.0));
        let profile = [([0.075, 0.3], 0.25), ([0.03, 0.55], -0.1), ([0.055, 0.74], 0.0)];
        shapes::turned(&mut mesh, M::ColumnMarble, around, [0.05, 0.0], &profile);
    }
    mesh.frame = DAffine3::IDENTITY;
    shapes::block(&mut mesh, M::DaisMarble, dvec3(0.0, 0.0, -0.1), dvec3(2.7, 0.08, 0.1), 0.015, false);
    shapes::block(&mut mesh, M::DaisMarble, dvec3(0.0, 0.82, -0.11), dvec3(2.7, 0.95, 0.11), 0.03, true);
    mesh
}

fn screen(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("screen", detail);
    let (wide, tall) = (OUTER_HALF - NAVE_HALF - WALL, 3.4);
    let (right, up) = (DVec3::X * wide, DVec3::Y * tall);
    shapes::rectangle(&mut mesh, M::LatticeScreen, DVec3::ZERO, right, up, 1.0);
    for (low, high) in [
        (dvec3(0.0, tall, -0.05), dvec3(wide, tall + 0.12, 0.05)),
        (dvec3(0.5 * wide - 0.05, 0.0, -0.05), dvec3(0.5 * wide + 0.05, tall, 0.05)),
    ] {
        shapes::block(&mut mesh, M::WroughtIron, low, high, 0.01, true);
    }
    mesh
}

fn rug(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("rug", detail);
    let (from, to) = (-18.9, 24.0);
    let segments = [mesh.segments(14.0, 3), mesh.segments(150.0, 8)];
    mesh.grid(M::RugWool, segments, Facing::Along(DVec3::Y), [false; 2], |u, v| {
        let z = from + (to - from) * v;
        let edge = (12.0 * u.min(1.0 - u)).min(1.0);
        let folds = 0.008 * (sin(1.7 * z) + sin(2.9 * z + 4.0 * u)) + 0.014;
        (dvec3(-1.2 + 2.4 * u, 0.004 + edge * (0.012 + folds.max(0.0)), z), dvec2(2.4 * u, z))
    });
    mesh
}

fn bench(detail: Detail) -> Mesh {
    let mut mesh = Mesh::new("bench", detail);
    let seat = (dvec3(-1.1, 0.42, -0.22), dvec3(1.1, 0.5, 0.22));
    shapes::block(&mut mesh, M::Oak, seat.0, seat.1, 0.015, true);
    let legs: &[f64] = if mesh.shows(0.08) { &[-0.95, 0.83] } else { &[] };
    for &x in legs {
        let (low, high) = (dvec3(x, 0.0, -0.18), dvec3(x + 0.12, 0.43, 0.18));
        shapes::block(&mut mesh, M::Oak, low, high, 0.01, false);
    }
    mesh
}

/// Balls on pedestals and twisted pillars.
fn place_sculptures(model: &mut Model, detail: Detail) {
    let knot = model.add(sculpture(detail));
    model.place(knot, dvec3(SCULPTURE.x, DAIS_HEIGHT, SCULPTURE.z), yaw(0.3));
    let stand = model.add(pedestal(detail));
    let finishes = [
        M::Chrome,
        M::RedRubber,
        M::PolishedGold,
        M::WhiteLacquer,
        M::CobaltGlaze,
        M::BlueSatinMetal,
        M::Copper,
        M::CeladonGlaze,
    ];
    for (k, finish) in finishes.into_iter().enumerate() {
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let at = dvec3(side * 3.5, 0.0, PEDESTALS_Z[k / 2]);
        model.place(stand, at, DQuat::IDENTITY);
        let ball = model.add(ball(detail, finish));
        model.place(ball, at, DQuat::IDENTITY);
    }
    let pillars = [M::Copper, M::AgedBronze].map(|material| model.add(twist(detail, material)));
    for (k, z) in [17.5, -2.5].into_iter().enumerate() {
        for side in [-1.0, 1.0] {
            model.place(pillars[k], dvec3(side * 9.2, 0.0, z), DQuat::IDENTITY);
        }
    }
}

/// Builds the furniture and places it.
pub fn build(model: &mut Model, detail: Detail) {
    let platform = model.add(dais(detail));
    model.place(platform, DVec3::ZERO, DQuat::IDENTITY);
    place_sculptures(model, detail);
    let vessels: [usize; 4] = std::array::from_fn(|kind| model.add(vessel(detail, kind)));
    let cloths = [M::BannerCrimson, M::BannerAzure, M::BannerForest];
    let banners = cloths.map(|cloth| model.add(banner(detail, cloth)));
    let (lantern, bench) = (model.add(lantern(detail)), model.add(bench(detail)));
    for bay in 0..BAYS {
        for (side, angle) in [(-1.0, 0.0), (1.0, PI)] {
            let z = bay_z(bay);
            model.place(lantern, lantern_place(bay, side), DQuat::IDENTITY);
            if bay % 2 == 1 {
                let kind = (bay as usize / 2 + usize::from(side > 0.0)) % 4;
                model.place(vessels[kind], dvec3(side * (OUTER_HALF + 0.35), 0.9, z), yaw(angle));
                let wall = dvec3(side * NAVE_HALF, 8.05, z - 0.5 * BAY);
                model.place(banners[bay as usize / 2 % 3], wall, yaw(angle));
            } else if bay % 4 == 0 && bay > 0 {
                let wall = dvec3(side * (OUTER_HALF - 0.5), 0.0, z);
                model.place(bench, wall, yaw(0.5 * PI));
            }
        }
    }
    let chandelier = model.add(chandelier(detail));
    for z in CHANDELIERS_Z {
        model.place(chandelier, dvec3(0.0, CHANDELIER_HEIGHT, z), DQuat::IDENTITY);
    }
    let brazier = model.add(brazier(detail));
    for (k, at) in BRAZIERS.into_iter().enumerate() {
        model.place(brazier, at, yaw(TAU * k as f64 / 7.0));
    }
    let railing = model.add(railing(detail));
    for x in [-4.4, 1.7] {
        model.place(railing, dvec3(x, DAIS_HEIGHT, -20.75), DQuat::IDENTITY);
    }
    let (screen, rug) = (model.add(screen(detail)), model.add(rug(detail)));
    for x in [-OUTER_HALF, NAVE_HALF + WALL] {
        model.place(screen, dvec3(x, 0.0, -20.0), DQuat::IDENTITY);
        for section in [0.3, 3.0] {
            model.place(railing, dvec3(x + section, 0.0, -14.0), DQuat::IDENTITY);
        }
    }
    model.place(rug, DVec3::ZERO, DQuat::IDENTITY);
}
