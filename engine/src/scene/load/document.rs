//! The file: JSON or GLB, its version, its extensions and its buffers.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use gltf::Glb;
use gltf::binary::{ChunkType, Error as GlbError};
use gltf::json::buffer::View;
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::{Index, Root};

use super::context::{Context, Outcome, get, label};
use super::parse::{self, Parsed};
use super::uri::{self, Uri};
use crate::error::{Error, Result};

/// The document may be this large, and so may be all that it refers to together.
const MAX_FILE_BYTES: u64 = 2 << 30;

/// An object is a few bytes in the file and up to a thousand in memory.
const MAX_JSON_OBJECTS: usize = 1_000_000;

/// A number in an array is two bytes in the file and 32 in memory.
const MAX_JSON_ITEMS: usize = 16_000_000;

/// What is read; whatever other extensions a file merely uses is ignored.
pub const KNOWN_EXTENSIONS: [&str; 6] = [
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A glTF file, with its buffers as far as they were needed.
pub struct Document {
    /// The file's JSON.
    pub root: Root,
    /// See [`Parsed::origins`].
    pub origins: Vec<Option<[f64; 3]>>,
    folder: PathBuf,
    /// What the file holds; a GLB's binary chunk is a part of it.
    bytes: Vec<u8>,
    binary_chunk: Option<std::ops::Range<usize>>,
    buffers: Vec<OnceLock<Outcome<Vec<u8>>>>,
    /// What all buffers and images together may still bring from other files and data URIs.
    unread: AtomicU64,
}

impl Document {
    /// Reads `path` and checks its version; buffers are read when they are first asked for, so
    /// that what the scene does not use may be missing.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = read_file(path, MAX_FILE_BYTES).map_err(|source| Error::io(path, source))?;
        Self::from_bytes(path, bytes).map_err(|cause| Error::file(path, cause))
    }

    fn from_bytes(path: &Path, bytes: Vec<u8>) -> Outcome<Self> {
        let (json, binary_chunk) = if bytes.starts_with(b"glTF") {
            split_glb(&bytes)?
        } else {
            check_is_json(path, &bytes)?;
            (0..bytes.len(), None)
        };
        let json = &bytes[json];
        // Not allowed by the specification, and harmless.
        let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
        check_size(json)?;
        let Parsed { root, origins } = parse::parse(json)?;
        let buffers = root.buffers.iter().map(|_| OnceLock::new()).collect();
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        let unread = AtomicU64::new(MAX_FILE_BYTES);
        Ok(Self { root, origins, folder, bytes, binary_chunk, buffers, unread })
    }

    /// The lights that nodes can hold.
    pub fn lights(&self) -> &[Light] {
        let extension = self.root.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
        extension.map_or(&[], |extension| &extension.lights)
    }

    /// The bytes of a buffer, exactly as many as it promises.
    fn buffer(&self, index: usize, user: &str) -> Outcome<&[u8]> {
        let buffer = get(&self.root.buffers, "buffer", index, user)?;
        let name = || label("buffer", index, buffer.uri.as_deref().filter(|uri| !uri.starts_with("data:")));
        let bytes: &[u8] = match (&buffer.uri, &self.binary_chunk) {
            (Some(uri), _) => {
                let read = || self.read_uri(uri).map_err(|e| format!("{}: {e}", name()));
                // One cell for each buffer, see `from_bytes`; `index` is in range.
                self.buffers[index].get_or_init(read).as_ref().map_err(Clone::clone)?
            }
            (None, Some(chunk)) if index == 0 => &self.bytes[chunk.clone()],
            (None, _) => return Err(format!("{} has no data", name())),
        };
        // The format demands a length and knows none of 0, which is what the crate takes it for
        // where it is left out.
        let promised = if buffer.byte_length.0 == 0 { bytes.len() as u64 } else { buffer.byte_length.0 };
        usize::try_from(promised)
            .ok()
            .and_then(|promised| bytes.get(..promised))
            .ok_or_else(|| format!("{} promises {promised} bytes and has {}", name(), bytes.len()))
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: Index<View>, user: &str) -> Outcome<(&View, &[u8])> {
        let index = index.value();
        let view = get(&self.root.buffer_views, "buffer view", index, user)?;
        let buffer = self.buffer(view.buffer.value(), &label("buffer view", index, None))?;
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        let start = usize::try_from(offset).ok();
        let end = offset.checked_add(view.byte_length.0).and_then(|end| usize::try_from(end).ok());
        let bytes = start.zip(end).and_then(|(start, end)| buffer.get(start..end)).ok_or_else(|| {
            format!(
                "buffer view {index} takes {} bytes from {offset} on of buffer {}, which has {}",
                view.byte_length.0,
                view.buffer,
                buffer.len()
            )
        })?;
        Ok((view, bytes))
    }

    /// The bytes that a URI stands for.
    pub fn read_uri(&self, uri: &str) -> Outcome<Vec<u8>> {
        let bytes = match uri::parse(uri)? {
            Uri::Data(bytes) => bytes,
            Uri::Relative(decoded, written) => {
                let written = self.folder.join(written);
                let decoded = self.folder.join(decoded);
                let path = if !decoded.exists() && written.exists() { written } else { decoded };
                let limit = self.unread.load(Ordering::Relaxed);
                read_file(&path, limit).map_err(|e| format!("{}: {e}", path.display()))?
            }
        };
        // Two threads may both read up to the limit; what matters is that it stops somewhere.
        let size = bytes.len() as u64;
        let _ = self
            .unread
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| Some(left.saturating_sub(size)));
        Ok(bytes)
    }
}

/// Reads a whole ordinary file; a pipe or a device could be endless or never answer.
fn read_file(path: &Path, limit: u64) -> std::io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    let refuse = |why: String| std::io::Error::new(std::io::ErrorKind::InvalidInput, why);
    if !metadata.is_file() {
        return Err(refuse("is not a file".to_owned()));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(refuse(format!("takes what is read beyond {} GiB", MAX_FILE_BYTES >> 30)));
    }
    Ok(bytes)
}

/// A clear word about files of other kinds, which the JSON parser would only call malformed.
fn check_is_json(path: &Path, bytes: &[u8]) -> Outcome<()> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match text.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(()),
        None => Err("the file is empty".to_owned()),
        Some(_) => {
            let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
            let kind = match extension.as_deref() {
                Some("gltf" | "glb") | None => String::new(),
                Some(other) => format!(", but an .{} file", other.escape_debug()),
            };
            Err(format!("is not a glTF file{kind}; scenes are .gltf (JSON) or .glb (binary) files"))
        }
    }
}

/// The sizes of a GLB's header and of those of its chunks, and where its JSON begins.
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const GLB_JSON: usize = GLB_HEADER + CHUNK_HEADER;

const NO_JSON_CHUNK: &str = "the GLB has no JSON chunk at its beginning";

type Chunks = (std::ops::Range<usize>, Option<std::ops::Range<usize>>);

/// Where a GLB's JSON and binary chunks lie.
fn split_glb(bytes: &[u8]) -> Outcome<Chunks> {
    let Some(&[a, b, c, d]) = bytes.get(8..12) else {
        return Err("the GLB header is cut off".to_owned());
    };
    let length = u32::from_le_bytes([a, b, c, d]) as usize;
    // The crate takes the header's length from this one without a look.
    if length < GLB_HEADER {
        return Err(format!("the GLB promises {length} bytes, fewer than its header has"));
    }
    // What follows after the promised length is no part of the file.
    let bytes = bytes.get(..length).unwrap_or(bytes);
    let (json, binary) = match Glb::from_slice(bytes) {
        Ok(glb) => (glb.json.len(), glb.bin.map(|chunk| chunk.len())),
        Err(gltf::Error::Binary(GlbError::UnknownChunkType(_))) => (only_json(bytes)?, None),
        Err(error) => return Err(glb_error(error, bytes)),
    };
    // The chunks follow each other, each after a header of its own.
    let json = GLB_JSON..GLB_JSON + json;
    let binary = binary.map(|size| json.end + CHUNK_HEADER..json.end + CHUNK_HEADER + size);
    Ok((json, binary))
}

/// The size of the JSON chunk before one of a kind unknown to the crate, which is to be skipped;
/// the binary chunk can only be the second.
fn only_json(bytes: &[u8]) -> Outcome<usize> {
    let size = match bytes.get(GLB_HEADER..GLB_JSON) {
        Some(&[a, b, c, d, b'J', b'S', b'O', b'N']) => u32::from_le_bytes([a, b, c, d]) as usize,
        _ => return Err(NO_JSON_CHUNK.to_owned()),
    };
    match GLB_JSON.checked_add(size) {
        Some(end) if end <= bytes.len() => Ok(size),
        _ => Err(format!("a GLB chunk of {size} bytes reaches beyond the end of the file")),
    }
}

fn glb_error(error: gltf::Error, bytes: &[u8]) -> String {
    let gltf::Error::Binary(error) = error else {
        return format!("the GLB cannot be read: {error}");
    };
    match error {
        GlbError::Version(version) => format!("is a GLB of version {version}; version 2 is read"),
        GlbError::Length { length, .. } => {
            let promised = u64::from(length) + GLB_HEADER as u64;
            format!("the GLB promises {promised} bytes and has {}", bytes.len())
        }
        GlbError::ChunkLength { length, .. } => {
            format!("a GLB chunk of {length} bytes reaches beyond the end of the file")
        }
        GlbError::Io(_) if bytes.len() == GLB_HEADER => NO_JSON_CHUNK.to_owned(),
        GlbError::Io(_) => "a GLB chunk's header is cut off".to_owned(),
        GlbError::ChunkType(ChunkType::Bin) => NO_JSON_CHUNK.to_owned(),
        GlbError::ChunkType(ChunkType::Json) => "the GLB has two JSON chunks".to_owned(),
        error => format!("the GLB cannot be read: {error}"),
    }
}

/// Bounds the memory that parsing takes. Braces and commas within strings count too; the base64 of
/// large buffers has neither.
fn check_size(json: &[u8]) -> Outcome<()> {
    let count = |wanted: u8| json.iter().filter(|&&byte| byte == wanted).count();
    if count(b'{') > MAX_JSON_OBJECTS || count(b',') > MAX_JSON_ITEMS {
        return Err("the JSON holds more objects than could be meant".to_owned());
    }
    Ok(())
}

/// Refuses unknown extensions that the file requires, and notes those that it merely uses.
pub fn check_extensions(context: &Context) -> Outcome<()> {
    let root = &context.document.root;
    let is_known = |name: &String| KNOWN_EXTENSIONS.contains(&name.as_str());
    let short = |name: &str| -> String { name.chars().take(60).flat_map(char::escape_debug).collect() };
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
        return Err(format!("requires the extension {}, which is not supported", short(name)));
    }
    for name in root.extensions_used.iter().filter(|name| !is_known(name)) {
        context.warn(format!("extension {} ignored", short(name)));
    }
    Ok(())
}
