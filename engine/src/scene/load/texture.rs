//! Textures: which are needed, in which colour space, and their pixels.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use gltf::json::Index;
use gltf::json::texture::{
    MagFilter, MinFilter, Sampler as FileSampler, Texture as FileTexture, WrappingMode,
};
use gltf::json::validation::Checked;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;

use super::context::{Context, Outcome, get, label, name_or};
use super::parse;
use crate::scene::{Sampler, Texture, Wrap};

/// Width and height that images may have.
const MAX_SIDE: u32 = 16384;

/// The textures that the materials turned out to need.
#[derive(Default)]
pub struct Wanted {
    /// The file's texture and whether it is read as sRGB, in the order of [`crate::scene::Scene::textures`].
    list: Vec<(usize, bool)>,
    indices: HashMap<(usize, bool), usize>,
}

impl Wanted {
    /// The index that the texture will have in the scene. A texture that is read both ways is two.
    pub fn index(&mut self, texture: usize, srgb: bool) -> usize {
        *self.indices.entry((texture, srgb)).or_insert_with(|| {
            self.list.push((texture, srgb));
            self.list.len() - 1
        })
    }

    /// Decodes all of them, each image once.
    pub fn decode(self, context: &Context) -> Outcome<Vec<Texture>> {
        let textures = &context.document.root.textures;
        let mut sources = Vec::new();
        for &(texture, _) in &self.list {
            let user = label("texture", texture, textures.get(texture).and_then(|t| t.name.as_deref()));
            sources.push(candidates(get(textures, "texture", texture, "a material")?, &user)?);
        }
        let mut firsts: Vec<usize> = sources.iter().map(|images| images[0]).collect();
        firsts.sort_unstable();
        firsts.dedup();
        let decode_each = |&image: &usize| (image, decode_image(context, image));
        let mut decoded: HashMap<usize, Outcome<Pixels>> = firsts.par_iter().map(decode_each).collect();
        let mut result = Vec::with_capacity(self.list.len());
        for ((texture, srgb), images) in self.list.into_iter().zip(sources) {
            let mut image = images[0];
            if let (Some(Err(cause)), Some(&other)) = (decoded.get(&image), images.get(1)) {
                context.warn(format!("{cause}; {} used instead", label("image", other, None)));
                image = other;
            }
            let pixels = decoded.entry(image).or_insert_with(|| decode_image(context, image)).clone()?;
            let file = &textures[texture];
            let own_name = file.name.as_deref().filter(|name| !name.is_empty());
            result.push(Texture {
                name: own_name.map_or_else(|| image_name(context, image), str::to_owned),
                size: pixels.size,
                rgba8: pixels.rgba8,
                srgb,
                sampler: sampler(context, file.sampler)?,
            });
        }
        Ok(result)
    }
}

#[derive(Clone)]
struct Pixels {
    size: [u32; 2],
    rgba8: Arc<[u8]>,
}

/// The images that a texture can be made from, best first; at least one.
fn candidates(texture: &FileTexture, user: &str) -> Outcome<Vec<usize>> {
    let extension = texture.extensions.as_ref().and_then(|all| all.others.get("EXT_texture_webp"));
    let webp = extension.and_then(|webp| webp.get("source")?.as_u64());
    let webp = webp.map(|index| usize::try_from(index).unwrap_or(usize::MAX));
    let images: Vec<usize> = webp.into_iter().chain(parse::optional(texture.source)).collect();
    if images.is_empty() {
        return Err(format!("{user} has no image in a format that is read (PNG, JPEG or WebP)"));
    }
    Ok(images)
}

fn image_name(context: &Context, index: usize) -> String {
    let Some(image) = context.document.root.images.get(index) else {
        return label("image", index, None);
    };
    let uri = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    name_or(image.name.as_deref().or(uri), "image", index)
}

fn decode_image(context: &Context, index: usize) -> Outcome<Pixels> {
    let image = get(&context.document.root.images, "image", index, "a texture")?;
    let uri = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let user = label("image", index, uri.or(image.name.as_deref()));
    let bytes: Cow<[u8]> = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => context.document.read_uri(uri).map_err(|e| format!("{user}: {e}"))?.into(),
        (None, Some(view)) => context.document.view(view, &user)?.1.into(),
        (None, None) => return Err(format!("{user} has neither a URI nor a buffer view")),
    };
    decode(context, &bytes, &user)
}

fn decode(context: &Context, bytes: &[u8], user: &str) -> Outcome<Pixels> {
    let format = image::guess_format(bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP))
        .ok_or_else(|| format!("{user} is neither PNG nor JPEG nor WebP"))?;
    let broken = |error| format!("{user} cannot be decoded: {error}");
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(context.bytes_left());
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("{user} is {width} x {height} pixels; 1 to {MAX_SIDE} on a side are possible"));
    }
    context.charge(width as usize * height as usize, 4, user)?;
    // What the decoder makes first; 16 bits a channel take twice the room.
    let raw = usize::try_from(decoder.total_bytes()).unwrap_or(usize::MAX);
    context.charge(raw, 1, user)?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(broken)?.into_rgba8();
    context.refund(raw, 1);
    Ok(Pixels { size: [width, height], rgba8: pixels.into_raw().into() })
}

fn sampler(context: &Context, index: Option<Index<FileSampler>>) -> Outcome<Sampler> {
    let Some(index) = index.map(|index| index.value()) else {
        return Ok(Sampler::default());
    };
    let sampler = get(&context.document.root.samplers, "sampler", index, "a texture")?;
    let unknown = |what: &str| context.warn(format!("sampler {index}: unknown {what}; the default is used"));
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::Repeat) => Wrap::Repeat,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Invalid => {
            unknown("wrap mode");
            Wrap::Repeat
        }
    };
    let mag_linear = match sampler.mag_filter {
        None | Some(Checked::Valid(MagFilter::Linear)) => true,
        Some(Checked::Valid(MagFilter::Nearest)) => false,
        Some(Checked::Invalid) => {
            unknown("magnification filter");
            true
        }
    };
    let min_filter = match sampler.min_filter.unwrap_or(Checked::Valid(MinFilter::LinearMipmapLinear)) {
        Checked::Valid(filter) => filter,
        Checked::Invalid => {
            unknown("minification filter");
            MinFilter::LinearMipmapLinear
        }
    };
    let (min_linear, mip_linear) = match min_filter {
        MinFilter::Nearest => (false, None),
        MinFilter::Linear => (true, None),
        MinFilter::NearestMipmapNearest => (false, Some(false)),
        MinFilter::LinearMipmapNearest => (true, Some(false)),
        MinFilter::NearestMipmapLinear => (false, Some(true)),
        MinFilter::LinearMipmapLinear => (true, Some(true)),
    };
    Ok(Sampler {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        mag_linear,
        min_linear,
        mip_linear,
    })
}
