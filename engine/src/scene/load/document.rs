//! The file: JSON or GLB, its version, its extensions and its buffers.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::context::{Context, Outcome, get, label};
use super::schema::{self, Head, Root};
use super::uri::{self, Uri};
use crate::error::{Error, Result};

/// The document may be this large, and so may be all that it refers to together.
const MAX_FILE_BYTES: u64 = 2 << 30;

/// An empty object is two bytes in the file and hundreds in memory.
const MAX_JSON_OBJECTS: usize = 2_000_000;

/// An empty string in an array is three bytes in the file and 24 in memory.
const MAX_JSON_ITEMS: usize = 64_000_000;

const KNOWN_EXTENSIONS: [&str; 6] = [
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
        check_version(json)?;
        let root: Root =
            serde_json::from_slice(json).map_err(|e| format!("the JSON is not glTF 2.0: {e}"))?;
        let buffers = root.buffers.iter().map(|_| OnceLock::new()).collect();
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        let unread = AtomicU64::new(MAX_FILE_BYTES);
        Ok(Self { root, folder, bytes, binary_chunk, buffers, unread })
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
        let promised = buffer.byte_length.unwrap_or(bytes.len() as u64);
        usize::try_from(promised)
            .ok()
            .and_then(|promised| bytes.get(..promised))
            .ok_or_else(|| format!("{} promises {promised} bytes and has {}", name(), bytes.len()))
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: usize, user: &str) -> Outcome<(&schema::BufferView, &[u8])> {
        let view = get(&self.root.buffer_views, "buffer view", index, user)?;
        let buffer = self.buffer(view.buffer, &label("buffer view", index, None))?;
        let start = usize::try_from(view.byte_offset).ok();
        let end = view.byte_offset.checked_add(view.byte_length).and_then(|end| usize::try_from(end).ok());
        let bytes = start.zip(end).and_then(|(start, end)| buffer.get(start..end)).ok_or_else(|| {
            format!(
                "buffer view {index} takes {} bytes from {} on of buffer {}, which has {}",
                view.byte_length,
                view.byte_offset,
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

type Chunks = (std::ops::Range<usize>, Option<std::ops::Range<usize>>);

/// Where a GLB's JSON and binary chunks lie.
fn split_glb(bytes: &[u8]) -> Outcome<Chunks> {
    let word = |at: usize| {
        let word = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the GLB header is cut off".to_owned());
    };
    if version != 2 {
        return Err(format!("is a GLB of version {version}; version 2 is read"));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(format!("the GLB promises {length} bytes and has {}", bytes.len()));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12usize;
    // What follows after the promised length is no part of the file.
    while at < length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err("a GLB chunk's header is cut off".to_owned());
        };
        let start = at + 8;
        let end = start.saturating_add(size as usize);
        if end > length {
            return Err(format!("a GLB chunk of {size} bytes reaches beyond the end of the file"));
        }
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() && at == 12 => json = Some(start..end),
            b"BIN\0" if binary.is_none() => binary = Some(start..end),
            b"JSON" | b"BIN\0" => return Err("the GLB has a chunk twice or in the wrong place".to_owned()),
            // Unknown chunks are to be skipped.
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or("the GLB has no JSON chunk at its beginning")?;
    Ok((json, binary))
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

/// Only glTF 2.x; must come before the whole is read, because glTF 1.0 differs everywhere.
fn check_version(json: &[u8]) -> Outcome<()> {
    let head: Head = serde_json::from_slice(json).map_err(|e| format!("the JSON cannot be read: {e}"))?;
    let asset = head.asset.ok_or("has no \"asset\" and so is not glTF")?;
    let version = asset.version.ok_or("does not say its glTF version")?;
    let numbers = |text: &str| {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    };
    match numbers(&version) {
        Some((2, _)) => {}
        _ => return Err(format!("is glTF version \"{}\"; version 2.0 is read", version.escape_debug())),
    }
    match asset.min_version {
        Some(least) if numbers(&least).is_none_or(|least| least > (2, 0)) => {
            Err(format!("needs glTF version \"{}\"; version 2.0 is read", least.escape_debug()))
        }
        _ => Ok(()),
    }
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
