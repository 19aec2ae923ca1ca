//! The hall's lights: a sun, and lamps where lamps are seen, as many as were asked for.

use super::furnish::{BRAZIERS, CHANDELIER_HEIGHT, CHANDELIERS_Z, SCULPTURE, lantern_place};
use super::math::{Random, turn};
use super::structure::{AISLE_HEIGHT, BAYS, HALF_LENGTH, NAVE_HALF, OUTER_HALF, bay_z};
use glam::{DVec3, dvec3};

/// Illuminance by the sun, lux: a patch of sunlight on a pale floor comes out near white.
const SUN_LUX: f64 = 10.0;
/// Candela of all lamps together; shared among them, so that the hall stays as bright whatever
/// their number. Turned up, the hall gets brighter in proportion.
const LAMPS_CANDELA: f64 = 1000.0;
/// No lamp is brighter, where there are few.
const BRIGHTEST_CANDELA: f64 = 90.0;

/// One light.
pub struct Lamp {
    /// For messages.
    pub name: &'static str,
    /// Linear, the greatest component 1.
    pub color: [f64; 3],
    /// Lux or candela.
    pub intensity: f64,
    /// Metres.
    pub position: DVec3,
    /// Unit, where it shines; of meaning for the sun and spots.
    pub direction: DVec3,
    /// Which kind, and its range in metres.
    pub kind: Kind,
}

/// Kinds of lamp.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// From infinitely far.
    Sun,
    /// In all directions, within a range.
    Point(f64),
    /// In a cone, within a range; inner and outer half angle in radians.
    Spot(f64, [f64; 2]),
}

const WARM: [f64; 3] = [1.0, 0.68, 0.38];
const FIRE: [f64; 3] = [1.0, 0.5, 0.2];
const CREAM: [f64; 3] = [1.0, 0.86, 0.68];
const COOL: [f64; 3] = [0.55, 0.74, 1.0];

fn point(name: &'static str, color: [f64; 3], weight: f64, position: DVec3, range: f64) -> Lamp {
    Lamp { name, color, intensity: weight, position, direction: DVec3::NEG_Y, kind: Kind::Point(range) }
}

fn spot(name: &'static str, color: [f64; 3], weight: f64, position: DVec3, target: DVec3) -> Lamp {
    let direction = (target - position).normalize();
    Lamp { name, color, intensity: weight, position, direction, kind: Kind::Spot(14.0, [0.3, 0.6]) }
}

/// The lamps that have a place of their own, the most telling first.
fn fixtures() -> Vec<Lamp> {
    let mut lamps = Vec::new();
    for (x, y) in [(-3.2, 8.0), (3.4, 7.6), (0.3, 9.6)] {
        let from = dvec3(x, y, SCULPTURE.z + 4.5);
        lamps.push(spot("sculpture spot", CREAM, 3.0, from, SCULPTURE));
    }
    for z in CHANDELIERS_Z {
        let at = dvec3(0.0, CHANDELIER_HEIGHT + 0.5, z);
        lamps.push(point("chandelier", CREAM, 3.0, at, 14.0));
    }
    for at in BRAZIERS {
        lamps.push(point("brazier", FIRE, 1.6, at + DVec3::Y * 1.55, 9.0));
    }
    // Every fifth bay first, so that few lamps are spread over the whole hall.
    for k in 0..BAYS {
        let bay = k * 5 % BAYS;
        for side in [-1.0, 1.0] {
            lamps.push(point("lantern", WARM, 1.3, lantern_place(bay, side), 10.0));
        }
    }
    for bay in 0..BAYS {
        for side in [-1.0, 1.0] {
            let z = bay_z(bay);
            if bay % 2 == 1 {
                let from = dvec3(side * (OUTER_HALF - 1.2), 5.2, z);
                let niche = dvec3(side * (OUTER_HALF + 0.2), 1.8, z);
                lamps.push(spot("niche spot", CREAM, 1.0, from, niche));
            } else {
                let at = dvec3(side * 9.0, AISLE_HEIGHT - 1.0, z);
                lamps.push(point("aisle lamp", COOL, 0.9, at, 8.5));
            }
            let from = dvec3(side * (NAVE_HALF - 0.5), 11.3, z);
            lamps.push(spot("vault light", COOL, 1.1, from, dvec3(-side * 1.5, 15.5, z)));
        }
    }
    lamps
}

/// One of the many small lamps beyond the fixtures: along the cornices, the vault and the aisles.
fn small_lamp(random: &mut Random, number: usize) -> Lamp {
    let side = if number.is_multiple_of(2) { -1.0 } else { 1.0 };
    let z = random.range(-HALF_LENGTH + 0.5, HALF_LENGTH - 0.5);
    let (warm, range) = (random.unit() < 0.6, random.range(8.0, 12.0));
    let color = if warm { WARM } else { COOL };
    match number % 5 {
        0 => point("cornice candle", WARM, 0.5, dvec3(side * (NAVE_HALF - 0.55), 8.95, z), range),
        1 => point("aisle candle", color, 0.5, dvec3(side * random.range(6.8, 11.3), 0.5, z), 8.0),
        2 => {
            let from = dvec3(side * random.range(7.0, 11.0), AISLE_HEIGHT - 0.5, z);
            let aim = turn(random.unit()) * random.range(0.2, 1.5);
            spot("aisle spot", color, 0.7, from, dvec3(from.x + aim.x, 0.0, z + aim.y))
        }
        3 => {
            let from = dvec3(side * (NAVE_HALF - 0.6), random.range(10.0, 10.6), z);
            let target = dvec3(random.range(-3.0, 3.0), 0.0, z + random.range(-3.0, 3.0));
            spot("nave spot", color, 0.8, from, target)
        }
        _ => point("vault candle", color, 0.6, dvec3(side * 4.3, random.range(11.2, 12.2), z), range),
    }
}

/// The sun and `count - 1` lamps.
pub fn lights(count: u32, seed: u64) -> Vec<Lamp> {
    let mut lights = vec![Lamp {
        name: "sun",
        color: [1.0, 0.91, 0.76],
        intensity: SUN_LUX,
        position: DVec3::Y * 20.0,
        direction: dvec3(-0.66, -0.68, 0.32).normalize(),
        kind: Kind::Sun,
    }];
    let lamps = count.max(1) as usize - 1;
    let mut random = Random::new(seed, 3);
    lights.extend(fixtures().into_iter().take(lamps));
    for number in 0..lamps + 1 - lights.len().min(lamps + 1) {
        lights.push(small_lamp(&mut random, number));
    }
    let weights: f64 = lights.iter().skip(1).map(|lamp| lamp.intensity).sum();
    for lamp in lights.iter_mut().skip(1) {
        lamp.intensity = (lamp.intensity * LAMPS_CANDELA / weights).min(BRIGHTEST_CANDELA);
    }
    lights
}
