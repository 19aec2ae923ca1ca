//! Normals and tangents: mended where the file's are broken, made where it has none.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec3, Vec2, Vec3};

use super::context::{Context, Outcome};
use super::geometry::Surface;
use crate::scene::{TextureUse, Vertex};

/// Corners at one position up to which MikkTSpace is used. It recurses around a vertex, once for
/// each triangle there, and compares them all with each other; beyond this it would be slow, and
/// much farther beyond overflow the stack.
const MAX_CORNERS_AT_ONE_POSITION: u32 = 1024;

/// Drops triangles without area, which have no normal and show nothing.
pub fn drop_degenerate(surface: &mut Surface) {
    let positions = &surface.positions;
    surface.triangles.retain(|&triangle| area_normal(positions, triangle).length_squared() > 0.0);
}

/// Leaves a unit normal and a unit tangent at every vertex. `normal_texture` is what the tangents
/// are for; where there is none they only have to be there.
pub fn complete(
    context: &Context,
    surface: &mut Surface,
    normal_texture: Option<&TextureUse>,
    user: &str,
) -> Outcome<()> {
    if surface.normals.is_empty() {
        // glTF asks for flat normals, and for tangents to be ignored where normals are missing.
        surface.tangents.clear();
        context.charge(surface.triangles.len(), 3 * size_of::<Vertex>(), user)?;
        surface.unshare();
        surface.normals = vec![Vec3::ZERO; surface.positions.len()];
        fill_normals(surface);
    } else {
        let broken = normalize(&mut surface.normals);
        if broken > 0 {
            context.warn(format!("{user}: normals without a direction computed anew"));
            fill_normals(surface);
        }
    }
    if !surface.tangents.is_empty() {
        if mend_tangents(surface) > 0 {
            context.warn(format!("{user}: broken tangents replaced"));
        }
        return Ok(());
    }
    let uvs = normal_texture.map(|texture| texture_coordinates(surface, texture)).unwrap_or_default();
    if uvs.is_empty() {
        if normal_texture.is_some() {
            context.warn(format!("{user}: a normal texture without texture coordinates"));
        }
        surface.tangents = surface.normals.iter().map(|&normal| any_tangent(normal)).collect();
        return Ok(());
    }
    let corners = match mikktspace(context, surface, &uvs, user) {
        Some(corners) => corners,
        None => simple_tangents(surface, &uvs),
    };
    split_by_tangent(context, surface, &corners, user)?;
    // Triangles without area in the texture give none.
    mend_tangents(surface);
    Ok(())
}

/// Perpendicular to the triangle and as long as twice its area. In double precision, where the
/// squares of the least and the greatest `f32` neither vanish nor overflow.
fn area_normal(positions: &[Vec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Brings the normals to length 1 and those that have no direction to 0; tells how many.
fn normalize(normals: &mut [Vec3]) -> usize {
    let mut broken = 0;
    for normal in normals {
        let length = normal.as_dvec3().length();
        if length.is_finite() && length > 1e-6 {
            *normal = (normal.as_dvec3() / length).as_vec3();
        } else {
            *normal = Vec3::ZERO;
            broken += 1;
        }
    }
    broken
}

/// Gives normals of length 0 the mean direction of the triangles around, by area.
fn fill_normals(surface: &mut Surface) {
    let mut sums = vec![DVec3::ZERO; surface.positions.len()];
    let mut anyone = vec![DVec3::ZERO; surface.positions.len()];
    for &triangle in &surface.triangles {
        let normal = area_normal(&surface.positions, triangle);
        for vertex in triangle {
            sums[vertex as usize] += normal;
            anyone[vertex as usize] = normal;
        }
    }
    for ((normal, sum), anyone) in surface.normals.iter_mut().zip(sums).zip(anyone) {
        if *normal == Vec3::ZERO {
            // The triangles of a two-sided sheet can cancel; then one of them has to do.
            let balanced = sum.length() <= 1e-6 * anyone.length();
            let direction = if balanced { anyone } else { sum };
            // Vertices that no triangle uses any more get any normal.
            *normal = direction.try_normalize().unwrap_or(DVec3::Z).as_vec3();
        }
    }
}

/// A unit tangent perpendicular to a unit normal.
fn any_tangent(normal: Vec3) -> [f32; 4] {
    normal.any_orthonormal_vector().extend(1.0).to_array()
}

/// Brings tangents to length 1 and their signs to -1 or 1, replacing those without a direction of
/// their own; tells how many.
fn mend_tangents(surface: &mut Surface) -> usize {
    let mut broken = 0;
    for (tangent, &normal) in surface.tangents.iter_mut().zip(&surface.normals) {
        let [x, y, z, sign] = *tangent;
        let direction = DVec3::new(x.into(), y.into(), z.into());
        let length = direction.length();
        // Along the normal it would leave no room for the bitangent.
        let across = direction.cross(normal.as_dvec3()).length();
        if length.is_finite() && length > 1e-6 && across > 1e-3 * length {
            let unit = (direction / length).as_vec3();
            *tangent = unit.extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array();
            broken += usize::from(sign.abs() != 1.0);
        } else {
            *tangent = any_tangent(normal);
            broken += 1;
        }
    }
    broken
}

/// Where the normal texture is sampled: its own transform counts, since the tangents have to run
/// along the picture's axes. Empty where the surface lacks the set.
fn texture_coordinates(surface: &Surface, texture: &TextureUse) -> Vec<Vec2> {
    let uvs = &surface.uvs[usize::from(texture.uv_set == 1)];
    let [u, v] = texture.uv_transform;
    let transformed = |uv: &Vec2| Vec2::new(u.dot(uv.extend(1.0)), v.dot(uv.extend(1.0)));
    // Large numbers can overflow, and MikkTSpace is not made for NaN.
    uvs.iter().map(transformed).map(|uv| if uv.is_finite() { uv } else { Vec2::ZERO }).collect()
}

/// MikkTSpace's view of a surface.
struct Faces<'a> {
    surface: &'a Surface,
    uvs: &'a [Vec2],
    tangents: Vec<[f32; 4]>,
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.surface.triangles[face][corner] as usize
    }
}

impl Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.surface.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.surface.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.surface.normals[self.vertex(face, vert)].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, vert)].to_array()
    }

    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, vert: usize) {
        let [x, y, z, sign] = tangent_space.map_or([0.0; 4], |space| space.tangent_encoded());
        // glTF's v runs down the picture and its bitangents up.
        self.tangents[face * 3 + vert] = [x, y, z, -sign];
    }
}

/// A tangent for each corner, or `None` where MikkTSpace is not up to the surface.
fn mikktspace(context: &Context, surface: &Surface, uvs: &[Vec2], user: &str) -> Option<Vec<[f32; 4]>> {
    let mut crowds: HashMap<[u32; 3], u32> = HashMap::new();
    for &corner in surface.triangles.as_flattened() {
        // Adding 0 makes -0 the same as 0.
        let place = (surface.positions[corner as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        *crowds.entry(place).or_default() += 1;
    }
    let steps = crowds.values().map(|&corners| u64::from(corners).pow(2)).sum();
    let crowded = crowds.values().any(|&corners| corners > MAX_CORNERS_AT_ONE_POSITION);
    if crowded || context.work(steps, user).is_err() {
        context.warn(format!("{user}: too many triangles meet in one point for MikkTSpace tangents"));
        return None;
    }
    let tangents = vec![[0.0; 4]; surface.triangles.len() * 3];
    let mut faces = Faces { surface, uvs, tangents };
    // The crate asserts what holds for all meshes that it was tried with; a file made to break it
    // must not end the program. Nothing is used of what a panic leaves behind.
    match catch_unwind(AssertUnwindSafe(|| generate_tangents(&mut faces))) {
        Ok(Ok(())) => Some(faces.tangents),
        _ => {
            context.warn(format!("{user}: no MikkTSpace tangents possible"));
            None
        }
    }
}

/// A tangent for each corner from the mean direction in which u grows around each vertex.
fn simple_tangents(surface: &Surface, uvs: &[Vec2]) -> Vec<[f32; 4]> {
    let mut sums = vec![[DVec3::ZERO; 2]; surface.positions.len()];
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|i| surface.positions[i as usize].as_dvec3());
        let [p, q, r] = triangle.map(|i| uvs[i as usize].as_dvec2());
        let (e, f, s, t) = (b - a, c - a, q - p, r - p);
        // The sign of the area in the texture; its size is left out, so that large triangles count
        // more than small ones.
        let sign = s.perp_dot(t).signum();
        for vertex in triangle {
            sums[*vertex as usize][0] += (e * t.y - f * s.y) * sign;
            sums[*vertex as usize][1] += (f * s.x - e * t.x) * sign;
        }
    }
    let tangent = |&corner: &u32| {
        let normal = surface.normals[corner as usize].as_dvec3();
        let [along_u, along_v] = sums[corner as usize];
        let tangent = (along_u - normal * normal.dot(along_u)).normalize_or_zero();
        let sign = if normal.cross(tangent).dot(along_v) > 0.0 { -1.0 } else { 1.0 };
        tangent.as_vec3().extend(sign).to_array()
    };
    surface.triangles.as_flattened().iter().map(tangent).collect()
}

/// Gives the corners their tangents, splitting vertices whose corners differ.
fn split_by_tangent(
    context: &Context,
    surface: &mut Surface,
    corners: &[[f32; 4]],
    user: &str,
) -> Outcome<()> {
    let mut known: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut from = Vec::new();
    let mut tangents = Vec::new();
    for (corner, tangent) in surface.triangles.as_flattened_mut().iter_mut().zip(corners) {
        let vertex = *known.entry((*corner, tangent.map(f32::to_bits))).or_insert_with(|| {
            from.push(*corner);
            tangents.push(*tangent);
            // No more than corners, which are counted in 32 bits.
            (from.len() - 1) as u32
        });
        *corner = vertex;
    }
    context.charge(from.len().saturating_sub(surface.positions.len()), size_of::<Vertex>(), user)?;
    surface.gather(&from);
    surface.tangents = tangents;
    Ok(())
}
