//! Compiles every shader under `shaders/` with glslang, reflects it, and writes the bindings that
//! the engine finds by name (`$OUT_DIR/shaders.rs`). A shader that does not compile stops the
//! build with glslang's message.

use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, Program, Shader, ShaderInput, ShaderSource, ShaderStage, SourceLanguage,
    SpirvVersion, Target, VulkanVersion,
};
use spirq::prelude::*;
use spirq::ty::{DescriptorType, Type};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

fn main() {
    if let Err(message) = run() {
        eprintln!("{message}");
        process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let variable = |name: &str| env::var(name).map_err(|error| format!("{name}: {error}"));
    let root = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("../shaders");
    println!("cargo:rerun-if-changed={}", root.display());
    let mut sources = Vec::new();
    find_sources(&root, &mut sources)?;
    sources.sort();
    let mut code = String::from("use super::reflect::*;\n\n");
    let mut names = Vec::new();
    for source in &sources {
        names.push(emit_shader(&root, source, &mut code)?);
    }
    let _ = writeln!(code, "/// Every shader.\npub static ALL: &[&ShaderInfo] = &[");
    for name in names {
        let _ = writeln!(code, "    &{name},");
    }
    code.push_str("];\n");
    let path = Path::new(&variable("OUT_DIR")?).join("shaders.rs");
    fs::write(&path, code).map_err(|error| format!("{}: {error}", path.display()))
}

/// All `.vert`, `.frag` and `.comp` files under `folder`; tells cargo to watch every file.
fn find_sources(folder: &Path, sources: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|error| error.to_string())?.path();
        println!("cargo:rerun-if-changed={}", path.display());
        if path.is_dir() {
            find_sources(&path, sources)?;
        } else if stage_of(&path).is_some() {
            sources.push(path);
        }
    }
    Ok(())
}

fn stage_of(path: &Path) -> Option<(ShaderStage, &'static str)> {
    match path.extension()?.to_str()? {
        "vert" => Some((ShaderStage::Vertex, "Vertex")),
        "frag" => Some((ShaderStage::Fragment, "Fragment")),
        "comp" => Some((ShaderStage::Compute, "Compute")),
        _ => None,
    }
}

/// Finds `#include`d files from the root of `shaders/`.
struct Includes<'a>(&'a Path);

impl IncludeHandler for Includes<'_> {
    fn include(&mut self, _: IncludeType, header: &str, _: &str, depth: usize) -> Option<IncludeResult> {
        if depth > 16 {
            return None;
        }
        let data = fs::read_to_string(self.0.join(header)).ok()?;
        Some(IncludeResult { name: header.to_owned(), data })
    }
}

fn compile(root: &Path, path: &Path, stage: ShaderStage) -> Result<Vec<u32>, String> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = fs::read_to_string(path).map_err(|error| at(&error))?;
    let compiler = Compiler::acquire().ok_or("glslang could not be initialised")?;
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_3, spirv_version: SpirvVersion::SPIRV1_6 },
        ..Default::default()
    };
    let source = ShaderSource::from(text);
    let mut includes = Includes(root);
    let input =
        ShaderInput::new(&source, stage, &options, None::<&[(&str, Option<&str>)]>, Some(&mut includes))
            .map_err(|error| at(&error))?;
    let shader = Shader::new(compiler, input).parse().map_err(|error| at(&error))?;
    let mut program = Program::new(compiler);
    program.add_shader(&shader);
    program.compile(stage).map_err(|error| at(&error))
}

/// The reflected parts of one shader, in the order in which they are written.
#[derive(Default)]
struct Reflected {
    bindings: BTreeMap<(u32, u32), String>,
    spec: BTreeMap<u32, String>,
    structs: BTreeMap<String, String>,
    push_constant_bytes: usize,
}

fn reflect(words: &[u32]) -> Result<Reflected, String> {
    let entry_points = ReflectConfig::new()
        .spv(words)
        .ref_all_rscs(true)
        .combine_img_samplers(true)
        .reflect()
        .map_err(|error| error.to_string())?;
    let mut reflected = Reflected::default();
    for variable in entry_points.iter().flat_map(|entry| &entry.vars) {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, nbind } => {
                let name = name.clone().filter(|name| !name.is_empty()).or_else(|| struct_name(ty));
                let name = name.ok_or("a descriptor has no name")?;
                let (set, binding) = (desc_bind.set(), desc_bind.bind());
                let kind = descriptor_kind(desc_ty).ok_or(format!("{name}: unsupported descriptor"))?;
                let line = format!(
                    "BindingInfo {{ name: {name:?}, set: {set}, binding: {binding}, kind: DescriptorKind::{kind}, count: {nbind} }}"
                );
                reflected.bindings.insert((set, binding), line);
                collect_structs(ty, &mut reflected.structs);
            }
            Variable::PushConstant { ty, .. } => {
                reflected.push_constant_bytes = ty.nbyte().unwrap_or(0);
                collect_structs(ty, &mut reflected.structs);
            }
            Variable::SpecConstant { name, spec_id, .. } => {
                let name = name.clone().unwrap_or_default();
                reflected.spec.insert(*spec_id, format!("({name:?}, {spec_id})"));
            }
            _ => {}
        }
    }
    Ok(reflected)
}

fn struct_name(ty: &Type) -> Option<String> {
    match ty {
        Type::Struct(of) => of.name.clone(),
        _ => None,
    }
}

fn descriptor_kind(ty: &DescriptorType) -> Option<&'static str> {
    match ty {
        DescriptorType::CombinedImageSampler() => Some("CombinedImageSampler"),
        DescriptorType::SampledImage() => Some("SampledImage"),
        DescriptorType::StorageImage(_) => Some("StorageImage"),
        DescriptorType::UniformBuffer() => Some("UniformBuffer"),
        DescriptorType::UniformTexelBuffer() => Some("UniformTexelBuffer"),
        DescriptorType::StorageBuffer(_) => Some("StorageBuffer"),
        _ => None,
    }
}

/// Notes the member offsets of `ty` and of every struct inside it.
fn collect_structs(ty: &Type, structs: &mut BTreeMap<String, String>) {
    match ty {
        Type::Struct(of) => {
            let mut members = String::new();
            for member in &of.members {
                collect_structs(&member.ty, structs);
                if let (Some(name), Some(offset)) = (&member.name, member.offset) {
                    let _ = write!(members, "({name:?}, {offset}), ");
                }
            }
            if let Some(name) = of.name.clone().filter(|name| !name.is_empty()) {
                let size = ty.nbyte().unwrap_or(0);
                let line = format!("StructInfo {{ name: {name:?}, size: {size}, members: &[{members}] }}");
                structs.insert(name, line);
            }
        }
        Type::Array(of) => collect_structs(&of.element_ty, structs),
        _ => {}
    }
}

/// Writes one shader's constant and returns the constant's name.
fn emit_shader(root: &Path, path: &Path, code: &mut String) -> Result<String, String> {
    let (stage, stage_name) = stage_of(path).ok_or("not a shader")?;
    let words = compile(root, path, stage)?;
    let reflected = reflect(&words).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = path.file_name().and_then(|name| name.to_str()).ok_or("a shader's name is not UTF-8")?;
    let constant = file.replace(['.', '-'], "_").to_uppercase();
    let list = |lines: Vec<String>| format!("&[{}]", lines.join(", "));
    let _ = writeln!(
        code,
        "/// `{file}`\npub static {constant}: ShaderInfo = ShaderInfo {{\n    name: {file:?},\n    stage: Stage::{stage_name},\n    spirv: &{words:?},\n    bindings: {},\n    spec: {},\n    structs: {},\n    push_constant_bytes: {},\n}};\n",
        list(reflected.bindings.into_values().collect()),
        list(reflected.spec.into_values().collect()),
        list(reflected.structs.into_values().collect()),
        reflected.push_constant_bytes,
    );
    Ok(constant)
}
