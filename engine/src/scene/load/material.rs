//! Materials, with their numbers brought into the ranges that the shaders count on.

use std::collections::HashMap;

use glam::{Vec3, Vec4};

use gltf::json::Index;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{self as json, AlphaMode as FileAlphaMode};
use gltf::json::texture::{Info, Texture};
use gltf::json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use super::context::{Context, Outcome, get, label, name_or};
use super::parse;
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
    pub uv_sets: [u32; 2],
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

/// A material's references to textures, in the order of [`Material`]'s.
struct References {
    base_color: Option<Reference>,
    metallic_roughness: Option<Reference>,
    normal: Option<Reference>,
    occlusion: Option<Reference>,
    emissive: Option<Reference>,
}

/// What the crate's three types of references have in common.
struct Reference {
    texture: usize,
    uv_set: u32,
    transform: Option<TextureTransform>,
}

impl Reference {
    fn new(texture: Index<Texture>, tex_coord: u32, transform: Option<TextureTransform>) -> Self {
        let uv_set = transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(tex_coord);
        Self { texture: texture.value(), uv_set, transform }
    }

    fn of_info(info: &Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|all| all.texture_transform.clone());
        Self::new(info.index, info.tex_coord, transform)
    }
}

impl References {
    fn new(file: &json::Material, user: &str) -> Outcome<Self> {
        let pbr = &file.pbr_metallic_roughness;
        // The crate leaves the transforms of these two unread.
        let read = |value: Option<&Value>| {
            let read = value.map(TextureTransform::deserialize).transpose();
            read.map_err(|error| format!("{user}: KHR_texture_transform: {}", parse::reword(&error)))
        };
        let name = "KHR_texture_transform";
        let normal = match &file.normal_texture {
            Some(info) => {
                let transform = read(info.extensions.as_ref().and_then(|all| all.others.get(name)))?;
                Some(Reference::new(info.index, info.tex_coord, transform))
            }
            None => None,
        };
        let occlusion = match &file.occlusion_texture {
            Some(info) => {
                let transform = read(info.extensions.as_ref().and_then(|all| all.others.get(name)))?;
                Some(Reference::new(info.index, info.tex_coord, transform))
            }
            None => None,
        };
        Ok(Self {
            base_color: pbr.base_color_texture.as_ref().map(Reference::of_info),
            metallic_roughness: pbr.metallic_roughness_texture.as_ref().map(Reference::of_info),
            normal,
            occlusion,
            emissive: file.emissive_texture.as_ref().map(Reference::of_info),
        })
    }

    fn all(&self) -> impl Iterator<Item = &Reference> {
        let all = [&self.base_color, &self.metallic_roughness, &self.normal, &self.occlusion, &self.emissive];
        all.into_iter().flatten()
    }
}

fn convert(context: &Context, file: &json::Material, index: usize, textures: &mut Wanted) -> Outcome<Used> {
    let user = label("material", index, file.name.as_deref());
    let pbr = &file.pbr_metallic_roughness;
    let fraction = |value: f32, what: &str| within(context, value, 0.0, 1.0, &user, what);
    let references = References::new(file, &user)?;
    let uv_sets = uv_sets(context, &references, &user);
    let mut texture = |reference: &Option<Reference>, srgb: bool| -> Outcome<Option<TextureUse>> {
        let Some(reference) = reference else {
            return Ok(None);
        };
        get(&context.document.root.textures, "texture", reference.texture, &user)?;
        Ok(Some(TextureUse {
            texture: textures.index(reference.texture, srgb),
            uv_set: u32::from(reference.uv_set == uv_sets[1]),
            uv_transform: uv_transform(context, reference, &user),
        }))
    };
    let extensions = file.extensions.as_ref();
    let strength = extensions.and_then(|all| all.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let strength = within(context, strength, 0.0, f32::MAX, &user, "emissive strength");
    let emissive = file.emissive_factor.0.map(|factor| fraction(factor, "emissive factor") * strength);
    let alpha_mode = match file.alpha_mode {
        Checked::Valid(FileAlphaMode::Opaque) => AlphaMode::Opaque,
        Checked::Valid(FileAlphaMode::Mask) => {
            let cutoff = file.alpha_cutoff.unwrap_or_default().0;
            AlphaMode::Mask { cutoff: fraction(cutoff, "alpha cutoff") }
        }
        Checked::Valid(FileAlphaMode::Blend) => AlphaMode::Blend,
        Checked::Invalid => {
            context.warn(format!("{user}: unknown alpha mode, taken as opaque"));
            AlphaMode::Opaque
        }
    };
    let occlusion = file.occlusion_texture.as_ref().map_or(1.0, |info| info.strength.0);
    let material = Material {
        name: name_or(file.name.as_deref(), "material", index),
        base_color: Vec4::from_array(pbr.base_color_factor.0.map(|value| fraction(value, "base colour"))),
        metallic: fraction(pbr.metallic_factor.0, "metallic factor"),
        roughness: fraction(pbr.roughness_factor.0, "roughness"),
        emissive: Vec3::from_array(emissive),
        normal_scale: file.normal_texture.as_ref().map_or(1.0, |info| info.scale),
        occlusion_strength: fraction(occlusion, "occlusion strength"),
        alpha_mode,
        double_sided: file.double_sided,
        unlit: extensions.is_some_and(|all| all.unlit.is_some()),
        base_color_texture: texture(&references.base_color, true)?,
        metallic_roughness_texture: texture(&references.metallic_roughness, false)?,
        normal_texture: texture(&references.normal, false)?,
        occlusion_texture: texture(&references.occlusion, false)?,
        emissive_texture: texture(&references.emissive, true)?,
    };
    Ok(Used { material, uv_sets })
}

/// `value` brought into `low..=high`, with a warning where it was not. JSON has no NaN.
fn within(context: &Context, value: f32, low: f32, high: f32, user: &str, what: &str) -> f32 {
    let clamped = value.clamp(low, high);
    if clamped != value {
        context.warn(format!("{user}: {what} {value} brought into {low} to {high}"));
    }
    clamped
}

/// Which two of the file's UV sets the material needs: 0 and 1 wherever those suffice.
fn uv_sets(context: &Context, references: &References, user: &str) -> [u32; 2] {
    let mut needed: Vec<u32> = references.all().map(|reference| reference.uv_set).collect();
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
fn uv_transform(context: &Context, reference: &Reference, user: &str) -> [Vec3; 2] {
    let Some(transform) = &reference.transform else {
        return [Vec3::X, Vec3::Y];
    };
    let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
    let ([x, y], [u, v]) = (transform.scale.0.map(f64::from), transform.offset.0.map(f64::from));
    let rows = [[x * cos, y * sin, u], [-x * sin, y * cos, v]];
    let rows = rows.map(|row| Vec3::from_array(row.map(|value| value as f32)));
    if rows.iter().all(|row| row.is_finite()) {
        rows
    } else {
        context.warn(format!("{user}: texture transform ignored, its numbers are too large"));
        [Vec3::X, Vec3::Y]
    }
}
