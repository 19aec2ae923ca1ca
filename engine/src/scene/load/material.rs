//! Materials, with their numbers brought into the ranges that the shaders count on.

use std::collections::HashMap;

use glam::{Vec3, Vec4};

use super::context::{Context, Outcome, get, label, name_or};
use super::schema::{self, TextureInfo};
use super::texture::Wanted;
use crate::scene::{AlphaMode, Material, TextureUse};

/// The materials that the scene's primitives turned out to use.
#[derive(Default)]
pub struct Materials {
    /// In the order of [`crate::scene::Scene::materials`], without the default material.
    pub list: Vec<Used>,
    /// The textures of those.
    pub textures: Wanted,
    indices: HashMap<usize, usize>,
}

/// A material in use.
pub struct Used {
    /// As the scene has it.
    pub material: Material,
    /// Which of the file's UV sets its `uv_set` 0 and 1 are.
    pub uv_sets: [u64; 2],
}

impl Materials {
    /// The scene's index of the file's material `index`.
    pub fn index(&mut self, context: &Context, index: usize, user: &str) -> Outcome<usize> {
        if let Some(&known) = self.indices.get(&index) {
            return Ok(known);
        }
        let file = get(&context.document.root.materials, "material", index, user)?;
        let used = convert(context, file, index, &mut self.textures)?;
        self.list.push(used);
        self.indices.insert(index, self.list.len() - 1);
        Ok(self.list.len() - 1)
    }
}

fn convert(context: &Context, file: &schema::Material, index: usize, textures: &mut Wanted) -> Outcome<Used> {
    let user = label("material", index, file.name.as_deref());
    let pbr = &file.pbr_metallic_roughness;
    let fraction = |value: f64, what: &str| within(context, value, 0.0, 1.0, &user, what);
    let finite = |value: f64, what: &str| {
        within(context, value, f64::from(f32::MIN), f64::from(f32::MAX), &user, what)
    };
    let uv_sets = uv_sets(context, file, &user);
    let mut texture = |info: &Option<Box<TextureInfo>>, srgb: bool| {
        let used = info.as_ref().map(|info| TextureUse {
            texture: textures.index(info.index, srgb),
            uv_set: u32::from(uv_set(info) == uv_sets[1]),
            uv_transform: uv_transform(context, info, &user),
        });
        match info {
            Some(info) => get(&context.document.root.textures, "texture", info.index, &user).map(|_| used),
            None => Ok(None),
        }
    };
    let strength = file.extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
    let strength = f64::from(within(context, strength, 0.0, f64::from(f32::MAX), &user, "emissive strength"));
    let emissive =
        file.emissive_factor.map(|factor| f64::from(fraction(factor, "emissive factor")) * strength);
    let material = Material {
        name: name_or(file.name.as_deref(), "material", index),
        base_color: Vec4::from_array(pbr.base_color_factor.map(|value| fraction(value, "base colour"))),
        metallic: fraction(pbr.metallic_factor, "metallic factor"),
        roughness: fraction(pbr.roughness_factor, "roughness"),
        emissive: Vec3::from_array(emissive.map(|value| value as f32)),
        normal_scale: finite(number(&file.normal_texture, |info| info.scale), "normal scale"),
        occlusion_strength: fraction(
            number(&file.occlusion_texture, |info| info.strength),
            "occlusion strength",
        ),
        alpha_mode: match file.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask { cutoff: fraction(file.alpha_cutoff, "alpha cutoff") },
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => {
                context.warn(format!("{user}: unknown alpha mode, taken as opaque"));
                AlphaMode::Opaque
            }
        },
        double_sided: file.double_sided,
        unlit: file.extensions.unlit.is_some(),
        base_color_texture: texture(&pbr.base_color_texture, true)?,
        metallic_roughness_texture: texture(&pbr.metallic_roughness_texture, false)?,
        normal_texture: texture(&file.normal_texture, false)?,
        occlusion_texture: texture(&file.occlusion_texture, false)?,
        emissive_texture: texture(&file.emissive_texture, true)?,
    };
    Ok(Used { material, uv_sets })
}

/// The texture's own scale or strength, 1 where there is none.
fn number(info: &Option<Box<TextureInfo>>, field: impl Fn(&TextureInfo) -> Option<f64>) -> f64 {
    info.as_deref().and_then(field).unwrap_or(1.0)
}

/// `value` brought into `low..=high`, with a warning where it was not. JSON has no NaN.
fn within(context: &Context, value: f64, low: f64, high: f64, user: &str, what: &str) -> f32 {
    let clamped = value.clamp(low, high);
    if clamped != value {
        context.warn(format!("{user}: {what} {value} brought into {low} to {high}"));
    }
    clamped as f32
}

fn uv_set(info: &TextureInfo) -> u64 {
    info.extensions.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord)
}

/// Which two of the file's UV sets the material needs: 0 and 1 wherever those suffice.
fn uv_sets(context: &Context, file: &schema::Material, user: &str) -> [u64; 2] {
    let pbr = &file.pbr_metallic_roughness;
    let infos = [
        &pbr.base_color_texture,
        &pbr.metallic_roughness_texture,
        &file.normal_texture,
        &file.occlusion_texture,
        &file.emissive_texture,
    ];
    let mut needed: Vec<u64> = infos.into_iter().flatten().map(|info| uv_set(info)).collect();
    needed.sort_unstable();
    needed.dedup();
    if needed.len() > 2 {
        context.warn(format!("{user}: more than two sets of texture coordinates; the others ignored"));
    }
    match needed[..] {
        [only] if only > 1 => [0, only],
        [first, second, ..] => [first, second],
        _ => [0, 1],
    }
}

/// `KHR_texture_transform`: scaled, then turned, then moved. Positive angles turn counter-clockwise
/// as one sees the picture, that is from u towards *minus* v, since v runs down; the formula in the
/// extension's text turns the other way, unlike its words and all of its test models.
fn uv_transform(context: &Context, info: &TextureInfo, user: &str) -> [Vec3; 2] {
    let Some(transform) = &info.extensions.transform else {
        return [Vec3::X, Vec3::Y];
    };
    let (sin, cos) = transform.rotation.sin_cos();
    let ([x, y], [u, v]) = (transform.scale, transform.offset);
    let rows = [[x * cos, y * sin, u], [-x * sin, y * cos, v]];
    let rows = rows.map(|row| Vec3::from_array(row.map(|value| value as f32)));
    if rows.iter().all(|row| row.is_finite()) {
        rows
    } else {
        context.warn(format!("{user}: texture transform ignored, its numbers are too large"));
        [Vec3::X, Vec3::Y]
    }
}
