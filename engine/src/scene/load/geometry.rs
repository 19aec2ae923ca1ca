//! Primitives: from attributes and indices to a list of triangles over the vertices in use.

use glam::{Vec2, Vec3};

use gltf::json::Index;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessor;
use super::context::{Context, Outcome};
use crate::scene::{Mesh, Vertex};

/// A primitive's triangles while they are being brought into shape. The attributes have one entry
/// for each vertex.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Which element of the file's attributes each vertex is.
    pub source: Vec<u32>,
    pub positions: Vec<Vec3>,
    /// Empty where the file has none.
    pub normals: Vec<Vec3>,
    /// Empty where the file has none.
    pub tangents: Vec<[f32; 4]>,
    /// Empty where the file has none.
    pub uvs: [Vec<Vec2>; 2],
    /// Empty where the file has none.
    pub colors: Vec<[u8; 4]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a primitive, or notes why it has nothing to draw. `uv_sets` says which of the file's sets
/// go where the vertices have room for two.
pub fn read(
    context: &Context,
    primitive: &Primitive,
    uv_sets: [u32; 2],
    user: &str,
) -> Outcome<Option<Surface>> {
    let mode = match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
        Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => {
            context.warn(format!("{user} ignored: it holds points or lines"));
            return Ok(None);
        }
        Checked::Invalid => return Err(format!("{user} has an unknown mode")),
    };
    let Some(positions) = attribute(primitive, Semantic::Positions) else {
        context.warn(format!("{user} ignored: it has no positions"));
        return Ok(None);
    };
    let positions = Accessor::open(context, positions, &format!("{user}, POSITION"), &[3])?;
    let corners = read_corners(context, primitive, positions.count, user)?;
    let mut triangles = assemble(context, mode, &corners, user)?;
    let source = compact(&mut triangles);
    if triangles.is_empty() {
        context.warn(format!("{user} ignored: it has no triangles"));
        return Ok(None);
    }
    context.charge(source.len(), size_of::<Vertex>(), user)?;
    let attributes = Attributes { context, primitive, user, count: positions.count };
    let mut surface = Surface { triangles, ..Surface::default() };
    for &element in &source {
        let position = positions.vec3(element as usize);
        if !position.is_finite() {
            return Err(format!("{user}, POSITION: vertex {element} is not finite"));
        }
        surface.positions.push(position);
    }
    surface.normals = attributes.read(&source, Semantic::Normals, &[3], |a, i| a.vec3(i))?;
    surface.tangents = attributes.read(&source, Semantic::Tangents, &[4], |a, i| a.vec4(i).to_array())?;
    for (uvs, set) in surface.uvs.iter_mut().zip(uv_sets) {
        *uvs = attributes.read(&source, Semantic::TexCoords(set), &[2], |a, i| a.vec2(i))?;
        if uvs.iter().any(|uv| !uv.is_finite()) {
            context.warn(format!("{user}: texture coordinates that are not finite set to 0"));
            uvs.iter_mut().filter(|uv| !uv.is_finite()).for_each(|uv| *uv = Vec2::ZERO);
        }
    }
    surface.colors = attributes.read(&source, Semantic::Colors(0), &[3, 4], color)?;
    surface.source = source;
    Ok(Some(surface))
}

/// Which accessor holds an attribute.
pub fn attribute(primitive: &Primitive, name: Semantic) -> Option<Index<gltf::json::Accessor>> {
    primitive.attributes.get(&Checked::Valid(name)).copied()
}

/// The order in which the vertices are used.
fn read_corners(context: &Context, primitive: &Primitive, vertices: usize, user: &str) -> Outcome<Vec<u32>> {
    let Some(indices) = primitive.indices else {
        context.charge(vertices, size_of::<u32>(), user)?;
        // Accessors have no more than 2^32 - 1 elements.
        return Ok((0..vertices as u32).collect());
    };
    let user = format!("{user}, indices");
    let indices = Accessor::open(context, indices, &user, &[1])?;
    if !indices.is_integer() {
        return Err(format!("{user}: not unsigned integers"));
    }
    context.charge(indices.count, size_of::<u32>(), &user)?;
    let corners: Vec<u32> = (0..indices.count).map(|i| indices.integer(i, 0)).collect();
    match corners.iter().find(|&&corner| corner as usize >= vertices) {
        Some(beyond) => Err(format!("{user}: {beyond} is out of range, there are {vertices} vertices")),
        None => Ok(corners),
    }
}

/// Triangles of lists, strips and fans, without those that use a vertex twice.
fn assemble(context: &Context, mode: Mode, corners: &[u32], user: &str) -> Outcome<Vec<[u32; 3]>> {
    let listed = mode == Mode::Triangles;
    if listed && !corners.len().is_multiple_of(3) {
        context.warn(format!("{user}: the last corners are no whole triangle"));
    }
    let count = if listed { corners.len() / 3 } else { corners.len().saturating_sub(2) };
    context.charge(count, size_of::<[u32; 3]>(), user)?;
    let mut triangles = Vec::with_capacity(count);
    for i in 0..count {
        let [a, b, c] = match mode {
            Mode::Triangles => [i * 3, i * 3 + 1, i * 3 + 2],
            // Every second triangle of a strip runs the other way round.
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            _ => [i + 1, i + 2, 0],
        };
        let triangle = [corners[a], corners[b], corners[c]];
        if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
            triangles.push(triangle);
        }
    }
    Ok(triangles)
}

/// Renumbers the triangles' corners over the elements in use, which are returned in their order:
/// large files often cut many small primitives out of one large buffer.
fn compact(triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    if used.last().is_some_and(|&last| last as usize >= used.len()) {
        for corner in triangles.as_flattened_mut() {
            // Found, since `used` holds every corner; positions fit into 32 bits as they do.
            *corner = used.binary_search(corner).unwrap_or(0) as u32;
        }
    }
    used
}

/// What the optional attributes of one primitive have in common.
struct Attributes<'a> {
    context: &'a Context<'a>,
    primitive: &'a Primitive,
    user: &'a str,
    count: usize,
}

impl Attributes<'_> {
    /// The attribute of all vertices, or nothing where the file has none that fits.
    fn read<T>(
        &self,
        source: &[u32],
        name: Semantic,
        lanes: &[usize],
        element: impl Fn(&Accessor, usize) -> T,
    ) -> Outcome<Vec<T>> {
        let user = format!("{}, {}", self.user, name.to_string());
        // Colours must be fractions; some files forget to say so.
        let is_color = matches!(name, Semantic::Colors(_));
        let Some(index) = attribute(self.primitive, name) else {
            return Ok(Vec::new());
        };
        let accessor = Accessor::open(self.context, index, &user, lanes)?;
        if accessor.count != self.count {
            self.context
                .warn(format!("{user} ignored: {} elements for {} positions", accessor.count, self.count));
            return Ok(Vec::new());
        }
        let accessor = if is_color { accessor.normalized() } else { accessor };
        Ok(source.iter().map(|&i| element(&accessor, i as usize)).collect())
    }
}

fn color(accessor: &Accessor, index: usize) -> [u8; 4] {
    std::array::from_fn(|lane| {
        let value = if lane < accessor.lanes { accessor.number(index, lane) } else { 1.0 };
        // A NaN becomes 0 in the conversion.
        (value.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

impl Surface {
    /// Gives every corner a vertex of its own.
    pub fn unshare(&mut self) {
        let corners: Vec<u32> = self.triangles.as_flattened().to_vec();
        self.gather(&corners);
        for (index, corner) in self.triangles.as_flattened_mut().iter_mut().enumerate() {
            // As many as the corners, which were counted in 32 bits, times three at most.
            *corner = index as u32;
        }
    }

    /// Makes the vertices those at `from`; the triangles are left as they are.
    pub fn gather(&mut self, from: &[u32]) {
        fn gather<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
            if !values.is_empty() {
                *values = from.iter().map(|&i| values[i as usize]).collect();
            }
        }
        gather(&mut self.source, from);
        gather(&mut self.positions, from);
        gather(&mut self.normals, from);
        gather(&mut self.tangents, from);
        gather(&mut self.colors, from);
        for uvs in &mut self.uvs {
            gather(uvs, from);
        }
    }

    /// The finished mesh; normals and tangents are there and of length 1.
    pub fn into_mesh(self, name: String) -> Mesh {
        let mut bounds = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let vertices = (0..self.positions.len()).map(|i| {
            let position = self.positions[i];
            bounds = [bounds[0].min(position), bounds[1].max(position)];
            Vertex {
                position,
                normal: self.normals[i],
                tangent: self.tangents[i],
                uv0: self.uvs[0].get(i).copied().unwrap_or_default(),
                uv1: self.uvs[1].get(i).copied().unwrap_or_default(),
                color: self.colors.get(i).copied().unwrap_or([255; 4]),
                padding: 0,
            }
        });
        let vertices = vertices.collect();
        let indices = self.triangles.as_flattened().to_vec();
        Mesh { name, vertices, indices, bounds, has_colors: !self.colors.is_empty() }
    }
}
