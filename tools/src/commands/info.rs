//! `macula info`: what a scene holds.

use crate::content::{Source, Subject, parse_source};
use crate::failure::Failure;
use crate::options::HallArgs;
use crate::output;
use clap::Args;
use macula::scene::{AlphaMode, LightKind, Scene};
use serde::Serialize;
use std::fmt::Write;

/// Show what a scene holds: counts, bounds, materials, lights, cameras, and what was ignored or mended
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula info sponza.glb\n  macula info hall --json")]
pub struct InfoArgs {
    /// A .gltf or .glb file, or `hall`
    #[arg(value_parser = parse_source)]
    scene: Source,
    /// Time at which animations are evaluated, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    time: f64,
}

#[derive(Serialize)]
struct Info {
    name: String,
    triangles: u64,
    vertices: u64,
    meshes: usize,
    instances: usize,
    textures: usize,
    texture_texels: u64,
    /// World-space least and greatest corner, metres.
    bounds: Option<[[f64; 3]; 2]>,
    materials: Vec<MaterialInfo>,
    lights: Lights,
    cameras: Vec<CameraInfo>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct MaterialInfo {
    name: String,
    alpha: &'static str,
    double_sided: bool,
    unlit: bool,
    emissive: bool,
    textures: Vec<&'static str>,
}

#[derive(Serialize, Default)]
struct Lights {
    directional: usize,
    point: usize,
    spot: usize,
}

#[derive(Serialize)]
struct CameraInfo {
    name: String,
    yfov_deg: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// Those of loading the scene.
pub fn run(args: &InfoArgs, json: bool) -> Result<(), Failure> {
    let subject = args.scene.open(&HallArgs::default(), args.time)?;
    let Subject::Scene(scene) = subject else {
        return Err(Failure::usage(
            "the ray-marched scene has no file to tell of; name a .gltf or .glb file",
        ));
    };
    let info = info_of(&scene);
    if json { output::print_json(&info) } else { output::print(&text(&info)) }
}

fn info_of(scene: &Scene) -> Info {
    let mut lights = Lights::default();
    for light in &scene.lights {
        match light.kind {
            LightKind::Directional => lights.directional += 1,
            LightKind::Point { .. } => lights.point += 1,
            LightKind::Spot { .. } => lights.spot += 1,
        }
    }
    let texels = |size: [u32; 2]| u64::from(size[0]) * u64::from(size[1]);
    Info {
        name: scene.name.clone(),
        triangles: scene.triangle_count(),
        vertices: scene.meshes.iter().map(|mesh| mesh.vertices.len() as u64).sum(),
        meshes: scene.meshes.len(),
        instances: scene.instances.len(),
        textures: scene.textures.len(),
        texture_texels: scene.textures.iter().map(|texture| texels(texture.size)).sum(),
        bounds: scene.bounds().map(|bounds| bounds.map(|corner| corner.to_array())),
        materials: scene.materials.iter().map(material_info).collect(),
        lights,
        cameras: scene
            .cameras
            .iter()
            .map(|camera| CameraInfo {
                name: camera.name.clone(),
                yfov_deg: camera.yfov_rad.map(f64::to_degrees),
            })
            .collect(),
        warnings: scene.warnings.clone(),
    }
}

fn material_info(material: &macula::scene::Material) -> MaterialInfo {
    let textures = [
        ("base colour", material.base_color_texture),
        ("metallic-roughness", material.metallic_roughness_texture),
        ("normal", material.normal_texture),
        ("occlusion", material.occlusion_texture),
        ("emissive", material.emissive_texture),
    ];
    MaterialInfo {
        name: material.name.clone(),
        alpha: match material.alpha_mode {
            AlphaMode::Opaque => "opaque",
            AlphaMode::Mask { .. } => "mask",
            AlphaMode::Blend => "blend",
        },
        double_sided: material.double_sided,
        unlit: material.unlit,
        emissive: material.emissive.max_element() > 0.0,
        textures: textures.iter().filter_map(|(name, texture)| texture.map(|_| *name)).collect(),
    }
}

fn text(info: &Info) -> String {
    let mut text = format!("{}\n", info.name);
    let mut line = |name: &str, value: &str| _ = writeln!(text, "  {name:<10} {value}");
    line("triangles", &output::grouped(info.triangles));
    line("vertices", &output::grouped(info.vertices));
    line("meshes", &format!("{} in {} instances", info.meshes, info.instances));
    line("textures", &format!("{} with {} texels", info.textures, output::grouped(info.texture_texels)));
    match info.bounds {
        Some([low, high]) => {
            let corner = |[x, y, z]: [f64; 3]| format!("({x:.3}, {y:.3}, {z:.3})");
            line("bounds", &format!("{} to {} m", corner(low), corner(high)));
        }
        None => line("bounds", "none: the scene has no triangles"),
    }
    let Lights { directional, point, spot } = info.lights;
    line("lights", &format!("{directional} directional, {point} point, {spot} spot"));
    for camera in &info.cameras {
        let fov = camera.yfov_deg.map(|degrees| format!(", {degrees:.1} degrees high")).unwrap_or_default();
        line("camera", &format!("`{}`{fov}", camera.name));
    }
    let rows = info.materials.iter().map(|material| {
        let flags = [
            (material.double_sided, "double-sided"),
            (material.unlit, "unlit"),
            (material.emissive, "emissive"),
        ];
        let notes = flags.iter().filter_map(|(is_set, name)| is_set.then_some(*name));
        let notes = notes.chain(material.textures.iter().copied()).collect::<Vec<_>>();
        vec![material.name.clone(), material.alpha.to_owned(), notes.join(", ")]
    });
    let rows = rows.collect::<Vec<_>>();
    text.push('\n');
    text.push_str(&output::table(&["material", "alpha", "has"], &rows));
    for warning in &info.warnings {
        _ = writeln!(text, "warning: {warning}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::scene::{Camera, Material};

    #[test]
    fn an_empty_scene_has_no_bounds() {
        let info = info_of(&Scene::default());
        assert_eq!((info.triangles, info.bounds), (0, None));
        assert!(text(&info).contains("no triangles"));
    }

    #[test]
    fn materials_and_cameras_are_listed() {
        let material = Material { name: "glass".into(), alpha_mode: AlphaMode::Blend, ..Material::default() };
        let camera =
            Camera { name: "door".into(), world_from_view: glam::DMat4::IDENTITY, yfov_rad: Some(1.0) };
        let scene = Scene { materials: vec![material], cameras: vec![camera], ..Scene::default() };
        let text = text(&info_of(&scene));
        assert!(text.contains("glass") && text.contains("blend"), "{text}");
        assert!(text.contains("`door`, 57.3 degrees high"), "{text}");
    }
}
