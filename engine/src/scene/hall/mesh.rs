//! Meshes from parametric surfaces: positions from the caller, normals and tangents from their
//! derivatives, winding from the side that the surface shows.

use super::materials::Material;
use glam::{DAffine3, DVec2, DVec3};

/// Step of the central differences, in parameter units: far above rounding (1e-16), far below any
/// feature of a surface.
const STEP: f64 = 1e-5;

/// Which side of a surface is seen.
#[derive(Clone, Copy)]
pub enum Facing {
    /// The side from which u goes right and v goes up: `dP/du x dP/dv`.
    Natural,
    /// The side that looks into this direction, at the middle of the surface.
    Along(DVec3),
    /// The side that looks at this point, at the middle of the surface.
    Towards(DVec3),
}

/// The triangles of one material.
pub struct Part {
    /// What they are made of.
    pub material: Material,
    /// Positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents and the bitangent's sign.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// A mesh that is being built, or only counted: while the level of detail is searched, no surface
/// is evaluated.
pub struct Mesh {
    /// For messages.
    pub name: &'static str,
    /// One for each material in use; empty while counting.
    pub parts: Vec<Part>,
    /// Triangles so far.
    pub triangles: u64,
    /// Where following surfaces are placed: rotation, uniform scale, translation.
    pub frame: DAffine3,
    detail: Detail,
}

/// How finely surfaces are divided.
#[derive(Clone, Copy)]
pub struct Detail {
    /// Factor on all numbers of segments; about 1 for 250 000 triangles.
    pub level: f64,
    /// Triangles are counted, not made.
    pub counting: bool,
}

impl Detail {
    /// The level is at least this: what only finer scenes hold asks here, each thing with a level
    /// of its own, so that the triangles grow in small steps.
    pub fn shows(self, level: f64) -> bool {
        self.level >= level
    }

    /// Segments: `at_one` at level 1, at least `least`; of the smallest scenes, two thirds of that.
    pub fn segments(self, at_one: f64, least: usize) -> usize {
        let least = if self.shows(0.16) { least } else { (2 * least).div_ceil(3).max(least.min(3)) };
        ((at_one * self.level).round() as usize).max(least)
    }
}

impl Mesh {
    /// An empty mesh.
    pub fn new(name: &'static str, detail: Detail) -> Self {
        Self { name, parts: Vec::new(), triangles: 0, frame: DAffine3::IDENTITY, detail }
    }

    /// Shorthand for [`Detail::shows`].
    pub fn shows(&self, level: f64) -> bool {
        self.detail.shows(level)
    }

    /// Shorthand for [`Detail::segments`].
    pub fn segments(&self, at_one: f64, least: usize) -> usize {
        self.detail.segments(at_one, least)
    }

    /// A surface over the unit square, `segments[0]` by `segments[1]` quads. `surface` gives the
    /// position and the texture coordinates in metres (v downwards). `poles` says whether all points
    /// of v = 0 and of v = 1 fall together.
    pub fn grid(
        &mut self,
        material: Material,
        segments: [usize; 2],
        facing: Facing,
        poles: [bool; 2],
        surface: impl Fn(f64, f64) -> (DVec3, DVec2),
    ) {
        let [nu, nv] = segments;
        debug_assert!(nu > 0 && nv > usize::from(poles[0] && poles[1]));
        let lost = poles.iter().filter(|&&pole| pole).count() * nu;
        self.triangles += (2 * nu * nv - lost) as u64;
        if self.detail.counting {
            return;
        }
        let local = Differentiated { surface: &surface };
        let flip = match facing {
            Facing::Natural => false,
            Facing::Along(direction) => local.normal(0.5, 0.5).dot(direction) < 0.0,
            Facing::Towards(point) => local.normal(0.5, 0.5).dot(point - surface(0.5, 0.5).0) < 0.0,
        };
        let frame = self.frame;
        let placed = |u: f64, v: f64| {
            let (position, uv) = surface(u, v);
            (frame.transform_point3(position), uv)
        };
        let at = match self.parts.iter().position(|part| part.material == material) {
            Some(at) => at,
            None => {
                self.parts.push(Part::new(material));
                self.parts.len() - 1
            }
        };
        self.parts[at].add(segments, flip, poles, &Differentiated { surface: &placed });
    }
}

/// A surface with its derivatives.
struct Differentiated<'a, F> {
    surface: &'a F,
}

impl<F: Fn(f64, f64) -> (DVec3, DVec2)> Differentiated<'_, F> {
    /// Differences of position and texture coordinates along u and along v, one-sided at borders,
    /// so that surfaces need no meaning outside the unit square.
    fn differences(&self, u: f64, v: f64) -> [(DVec3, DVec2); 2] {
        let between =
            |a: (DVec3, DVec2), b: (DVec3, DVec2), span: f64| ((b.0 - a.0) / span, (b.1 - a.1) / span);
        let (u0, u1) = ((u - STEP).max(0.0), (u + STEP).min(1.0));
        let (v0, v1) = ((v - STEP).max(0.0), (v + STEP).min(1.0));
        let f = self.surface;
        [between(f(u0, v), f(u1, v), u1 - u0), between(f(u, v0), f(u, v1), v1 - v0)]
    }

    /// Towards the natural side; not of length 1.
    fn normal(&self, u: f64, v: f64) -> DVec3 {
        let [du, dv] = self.differences(u, v);
        du.0.cross(dv.0)
    }

    /// Position, unit normal on the natural side, unit tangent, sign of the texture's area, and
    /// texture coordinates.
    fn vertex(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3, f64, DVec2) {
        let (position, uv) = (self.surface)(u, v);
        let mut differences = self.differences(u, v);
        let cross = |d: &[(DVec3, DVec2); 2]| d[0].0.cross(d[1].0);
        let flat = |d: &[(DVec3, DVec2); 2]| {
            cross(d).length() <= 1e-6 * d[0].0.length().max(d[1].0.length()).powi(2)
        };
        if flat(&differences) {
            // A pole: the direction a little way off is the limit's to within the step.
            differences = self.differences(0.5 + (u - 0.5) * 0.998, 0.5 + (v - 0.5) * 0.998);
        }
        let [du, dv] = differences;
        let normal = cross(&differences).normalize_or(DVec3::Y);
        // Along growing texture u at constant texture v.
        let area = du.1.perp_dot(dv.1);
        let along = (du.0 * dv.1.y - dv.0 * du.1.y) * if area < 0.0 { -1.0 } else { 1.0 };
        let tangent = (along - normal * along.dot(normal)).normalize_or(normal.any_orthonormal_vector());
        (position, normal, tangent, area, uv)
    }
}

/// A multiple of a micrometre as `f32`.
fn rounded(value: f64) -> f32 {
    ((value * 1e6).round() / 1e6) as f32
}

impl Part {
    fn new(material: Material) -> Self {
        Self {
            material,
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uvs: Vec::new(),
            indices: Vec::new(),
        }
    }

    fn add<F: Fn(f64, f64) -> (DVec3, DVec2)>(
        &mut self,
        [nu, nv]: [usize; 2],
        flip: bool,
        poles: [bool; 2],
        surface: &Differentiated<'_, F>,
    ) {
        let first = self.positions.len() as u32;
        let per_metre = 1.0 / self.material.tile_m();
        let side = if flip { -1.0 } else { 1.0 };
        for j in 0..=nv {
            for i in 0..=nu {
                let (position, normal, tangent, area, uv) =
                    surface.vertex(i as f64 / nu as f64, j as f64 / nv as f64);
                // Texture v points down, the normal map's y up: a surface whose texture is not
                // mirrored has, seen from its front, a negative area in (u, v).
                let sign = if area * side < 0.0 { 1.0 } else { -1.0 };
                self.positions.push(position.to_array().map(rounded));
                self.normals.push((normal * side).to_array().map(|x| x as f32));
                let [x, y, z] = tangent.to_array().map(|x| x as f32);
                self.tangents.push([x, y, z, sign]);
                self.uvs.push((uv * per_metre).to_array().map(rounded));
            }
        }
        let row = nu as u32 + 1;
        for j in 0..nv as u32 {
            for i in 0..nu as u32 {
                let a = first + j * row + i;
                let (b, c, d) = (a + 1, a + row + 1, a + row);
                if !(poles[0] && j == 0) {
                    self.indices.extend(if flip { [a, c, b] } else { [a, b, c] });
                }
                if !(poles[1] && j + 1 == nv as u32) {
                    self.indices.extend(if flip { [a, d, c] } else { [a, c, d] });
                }
            }
        }
    }
}
