//! glTF files: `.gltf` and `.glb` of version 2.x, with what lies next to them.
//!
//! Files come from anywhere, so nothing in them is believed: every index and range is checked,
//! sizes and work are limited, and what cannot be brought into a [`Scene`]'s form is refused in
//! one line. What is merely unusual is mended or ignored, with a warning in the scene.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DVec3};

mod accessor;
mod animation;
mod context;
mod deform;
mod document;
mod geometry;
mod lights;
mod material;
mod nodes;
mod parse;
mod shading;
#[cfg(test)]
mod tests;
mod texture;
mod uri;

use context::{Context, Outcome, get, label, name_or};
use document::Document;
use material::Materials;
use nodes::Hierarchy;

use super::{Instance, Material, Scene};
use crate::error::{Error, Result};

/// What to take out of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// The time at which animations are evaluated, in seconds; times outside of the animation's
    /// length are wrapped into it. Only the file's first animation plays: where there are several
    /// they are mostly alternatives.
    pub time_s: f64,
    /// Which of the file's scenes; the file's choice, or else the first one, where `None`.
    pub scene_index: Option<usize>,
}

/// Loads a glTF file.
///
/// Files without a scene or without triangles give a scene without instances. Skinned meshes come
/// in world space, their instances at most moving them. Where a material uses other UV sets than
/// the first two, its meshes have those in their place.
///
/// # Errors
///
/// [`Error::Io`] where the file itself cannot be read, [`Error::File`] where it is broken, needs
/// what is not supported or would take more than 2 GiB of memory, [`Error::Setting`] where
/// `options.time_s` is not finite.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    if !options.time_s.is_finite() {
        return Err(Error::Setting(format!("a scene's time must be finite, not {}", options.time_s)));
    }
    let document = Document::open(path)?;
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    load_document(&document, name, options).map_err(|cause| Error::file(path, cause))
}

fn load_document(document: &Document, name: String, options: &LoadOptions) -> Outcome<Scene> {
    let context = Context::new(document);
    document::check_extensions(&context)?;
    let hierarchy = nodes::evaluate(&context, options)?;
    let mut builder = Builder {
        context: &context,
        hierarchy: &hierarchy,
        materials: Materials::default(),
        known: HashMap::new(),
        uses: Vec::new(),
        scene: Scene { name, ..Scene::default() },
    };
    for &node in &hierarchy.in_scene {
        builder.add_node(node)?;
    }
    let mut scene = builder.finish()?;
    scene.warnings = context.into_warnings();
    Ok(scene)
}

/// A primitive's mesh and material (`None`: the default) in the scene.
#[derive(Clone, Copy)]
struct Drawn {
    mesh: usize,
    material: Option<usize>,
}

/// A mesh's primitive, and by which weights it is morphed.
type Shape = (usize, usize, Vec<u32>);

struct Builder<'a> {
    context: &'a Context<'a>,
    hierarchy: &'a Hierarchy,
    materials: Materials,
    /// What has become of unskinned primitives, which many nodes can use.
    known: HashMap<Shape, Option<Drawn>>,
    uses: Vec<(Drawn, DMat4)>,
    scene: Scene,
}

impl Builder<'_> {
    fn add_node(&mut self, index: usize) -> Outcome<()> {
        let node = &self.context.document.root.nodes[index];
        let user = label("node", index, node.name.as_deref());
        let world = self.hierarchy.world[index];
        let extensions = node.extensions.as_ref();
        if let Some(light) = extensions.and_then(|all| all.khr_lights_punctual.as_ref()) {
            self.scene.lights.extend(lights::light(self.context, light.light.value(), &world, &user)?);
        }
        if let Some(camera) = node.camera {
            let name = node.name.as_deref().filter(|name| !name.is_empty());
            self.scene.cameras.extend(lights::camera(self.context, camera.value(), name, &world, &user)?);
        }
        match node.mesh {
            Some(mesh) => self.add_mesh(index, mesh.value(), &user),
            None => Ok(()),
        }
    }

    fn add_mesh(&mut self, node: usize, mesh: usize, user: &str) -> Outcome<()> {
        let root = &self.context.document.root;
        let file = get(&root.meshes, "mesh", mesh, user)?;
        let world = self.hierarchy.world[node];
        let invertible = nodes::is_invertible(&world);
        let joints = match root.nodes[node].skin {
            Some(skin) if file.primitives.iter().any(deform::is_skinnable) => {
                Some(deform::joint_matrices(self.context, self.hierarchy, skin.value())?)
            }
            Some(_) => {
                self.context.warn(format!("{user}: its mesh has no joints and is not skinned"));
                None
            }
            None => None,
        };
        let weights = self.hierarchy.weights[node].as_deref().or(file.weights.as_deref()).unwrap_or_default();
        for (index, primitive) in file.primitives.iter().enumerate() {
            // A thousand nodes may use a mesh of a thousand primitives.
            self.context.charge(1, size_of::<Instance>(), user)?;
            if let Some(joints) = joints.as_deref().filter(|_| deform::is_skinnable(primitive)) {
                if let Some((drawn, origin)) = self.build(mesh, index, weights, Some(joints))? {
                    self.uses.push((drawn, DMat4::from_translation(origin)));
                }
                continue;
            }
            if !invertible {
                self.context.warn(format!("{user} ignored: its transform is singular or not finite"));
                continue;
            }
            let used = &weights[..weights.len().min(primitive.targets.as_ref().map_or(0, Vec::len))];
            let shape = (mesh, index, used.iter().map(|weight| weight.to_bits()).collect());
            let drawn = match self.known.get(&shape) {
                Some(&known) => known,
                None => {
                    let drawn = self.build(mesh, index, used, None)?.map(|(drawn, _)| drawn);
                    self.known.insert(shape, drawn);
                    drawn
                }
            };
            self.uses.extend(drawn.map(|drawn| (drawn, world)));
        }
        Ok(())
    }

    /// Makes a scene's mesh of a primitive, in the world's space (moved to the returned origin)
    /// where it is skinned by `joints`. `None` where there is nothing to draw.
    fn build(
        &mut self,
        mesh: usize,
        index: usize,
        weights: &[f32],
        joints: Option<&[DMat4]>,
    ) -> Outcome<Option<(Drawn, DVec3)>> {
        let context = self.context;
        let file = &context.document.root.meshes[mesh];
        let primitive = &file.primitives[index];
        let user = format!("{}, primitive {index}", label("mesh", mesh, file.name.as_deref()));
        let material = match primitive.material {
            Some(material) => Some(self.materials.index(context, material.value(), &user)?),
            None => None,
        };
        let used = material.map(|material| &self.materials.list[material]);
        let uv_sets = used.map_or([0, 1], |used| used.uv_sets);
        let Some(mut surface) = geometry::read(context, primitive, uv_sets, &user)? else {
            return Ok(None);
        };
        deform::morph(context, &mut surface, primitive, weights, &user)?;
        let origin = match joints {
            Some(joints) => deform::skin(context, &mut surface, primitive, joints, &user)?,
            None => DVec3::ZERO,
        };
        shading::drop_degenerate(&mut surface);
        if surface.triangles.is_empty() {
            context.warn(format!("{user} ignored: its triangles have no area"));
            return Ok(None);
        }
        let normal_texture = used.and_then(|used| used.material.normal_texture.as_ref());
        shading::complete(context, &mut surface, normal_texture, &user)?;
        let mut name = name_or(file.name.as_deref(), "mesh", mesh);
        if file.primitives.len() > 1 {
            name = format!("{name}/{index}");
        }
        self.scene.meshes.push(surface.into_mesh(name));
        Ok(Some((Drawn { mesh: self.scene.meshes.len() - 1, material }, origin)))
    }

    fn finish(self) -> Outcome<Scene> {
        let mut scene = self.scene;
        scene.textures = self.materials.textures.decode(self.context)?;
        scene.materials = self.materials.list.into_iter().map(|used| used.material).collect();
        let default = scene.materials.len();
        scene.materials.push(Material { name: "default".to_owned(), ..Material::default() });
        let instance = |(drawn, world_from_mesh): (Drawn, DMat4)| Instance {
            mesh: drawn.mesh,
            material: drawn.material.unwrap_or(default),
            world_from_mesh,
        };
        scene.instances = self.uses.into_iter().map(instance).collect();
        Ok(scene)
    }
}
