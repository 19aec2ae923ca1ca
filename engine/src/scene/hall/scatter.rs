//! Leaves and pebbles on the floor: small things that bring the number of triangles to what was asked.

use super::materials::Material as M;
use super::math::Random;
use super::mesh::{Detail, Facing, Mesh};
use super::shapes;
use super::structure::{COLUMN_X, HALF_LENGTH, OUTER_HALF};
use glam::{DAffine3, DVec3, dvec2, dvec3};
use std::f64::consts::TAU;

/// Triangles of a leaf and of a pebble.
const LEAF: u64 = 8;
const PEBBLE: u64 = 10;

/// As many leaves and pebbles as `triangles` allow.
pub fn litter(triangles: u64, seed: u64) -> Mesh {
    let mut mesh = Mesh::new("leaves and pebbles", Detail { level: 1.0, counting: false });
    let mut random = Random::new(seed, 5);
    while mesh.triangles + LEAF <= triangles {
        let place = spot(&mut random);
        mesh.frame = DAffine3::from_rotation_translation(super::math::yaw(random.range(0.0, TAU)), place);
        if mesh.triangles + PEBBLE <= triangles && random.unit() < 0.3 {
            pebble(&mut mesh, &mut random);
        } else {
            leaf(&mut mesh, &mut random);
        }
    }
    mesh
}

/// A place on the floor: mostly where wind leaves things, along walls and round columns.
fn spot(random: &mut Random) -> DVec3 {
    let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let z = random.range(-HALF_LENGTH + 10.8, HALF_LENGTH - 0.3);
    let heap = random.unit() * random.unit();
    let x = match random.unit() {
        share if share < 0.45 => COLUMN_X - 0.75 - 1.6 * heap,
        share if share < 0.85 => OUTER_HALF - 0.2 - 2.5 * heap,
        _ => random.range(1.3, OUTER_HALF - 0.3),
    };
    // Columns and their plinths stay clear.
    let x = if (x - COLUMN_X).abs() < 0.72 { x + 1.45 } else { x };
    dvec3(side * x, 0.004, z)
}

fn leaf(mesh: &mut Mesh, random: &mut Random) {
    let length = random.range(0.07, 0.15);
    let (curl, roll) = (random.range(0.1, 0.5), random.range(-0.2, 0.5));
    mesh.grid(M::FallenLeaf, [2, 2], Facing::Along(DVec3::Y), [false; 2], |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let height = 0.004 + length * 0.5 * (curl * x * x + roll.max(0.0) * y * y);
        (dvec3(0.5 * length * x, height, 0.5 * length * y), dvec2(u, v) * M::FallenLeaf.tile_m())
    });
}

fn pebble(mesh: &mut Mesh, random: &mut Random) {
    let (radius, flat) = (random.range(0.01, 0.035), random.range(0.4, 0.8));
    let bulge = random.range(0.8, 1.25);
    shapes::revolve(mesh, M::Pebble, [5, 2], [true; 2], |u, t| {
        let wide = if u < 0.5 { bulge } else { 1.0 };
        dvec2(4.0 * t * (1.0 - t) * radius * wide, 2.0 * t * radius * flat)
    });
}
