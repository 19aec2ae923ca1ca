//! What a scene has: it decides which effects run and how shaders are specialised.

use crate::scene::environment::Environment;
use crate::scene::{AlphaMode, LightKind, Material, Scene};

/// What the materials that are in use, the lights and the surroundings of a scene need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneFeatures {
    /// Opaque or masked triangles.
    pub opaque: bool,
    /// Blended triangles.
    pub blend: bool,
    /// Alpha-masked materials.
    pub alpha_mask: bool,
    /// Normal maps.
    pub normal_maps: bool,
    /// Maps of any kind on surfaces that are not blended.
    pub opaque_maps: bool,
    /// Surfaces that are lit and not blended.
    pub opaque_lit: bool,
    /// Emissive or unlit materials.
    pub emissive: bool,
    /// Occlusion maps.
    pub occlusion: bool,
    /// Vertex colours.
    pub vertex_colors: bool,
    /// Directional lights.
    pub directional_lights: u32,
    /// Point lights.
    pub point_lights: u32,
    /// Spot lights.
    pub spot_lights: u32,
    /// An environment map.
    pub environment: bool,
}

impl SceneFeatures {
    /// Looks through a scene.
    #[must_use]
    pub fn of(scene: &Scene, environment: Option<&Environment>) -> Self {
        let mut features = Self { environment: environment.is_some(), ..Self::default() };
        for instance in &scene.instances {
            let material = &scene.materials[instance.material];
            let blend = material.alpha_mode == AlphaMode::Blend;
            features.blend |= blend;
            features.opaque |= !blend;
            features.opaque_maps |= !blend && MaterialVariant::of(material).has_maps();
            features.opaque_lit |= !blend && !material.unlit;
            features.alpha_mask |= matches!(material.alpha_mode, AlphaMode::Mask { .. });
            features.normal_maps |= material.normal_texture.is_some();
            features.emissive |= material.unlit || material.emissive.max_element() > 0.0;
            features.occlusion |= material.occlusion_texture.is_some();
            features.vertex_colors |= scene.meshes[instance.mesh].has_colors;
        }
        for light in &scene.lights {
            match light.kind {
                LightKind::Directional => features.directional_lights += 1,
                LightKind::Point { .. } => features.point_lights += 1,
                LightKind::Spot { .. } => features.spot_lights += 1,
            }
        }
        features
    }

    /// All punctual lights.
    #[must_use]
    pub fn lights(&self) -> u32 {
        self.directional_lights + self.point_lights + self.spot_lights
    }
}

/// Which maps a material has, and whether it is masked: what its pipeline is specialised to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct MaterialVariant(u8);

/// The bits of a [`MaterialVariant`], by the names of their specialization constants.
const VARIANT_BITS: [&str; 6] = [
    "HAS_BASE_COLOR_MAP",
    "HAS_METALLIC_ROUGHNESS_MAP",
    "HAS_NORMAL_MAP",
    "HAS_OCCLUSION_MAP",
    "HAS_EMISSIVE_MAP",
    "HAS_ALPHA_MASK",
];

/// The place of the last of them.
const ALPHA_MASK_BIT: usize = VARIANT_BITS.len() - 1;

impl MaterialVariant {
    /// The variant of a material.
    #[must_use]
    pub fn of(material: &Material) -> Self {
        let has = [
            material.base_color_texture.is_some(),
            material.metallic_roughness_texture.is_some(),
            material.normal_texture.is_some(),
            material.occlusion_texture.is_some(),
            material.emissive_texture.is_some(),
            matches!(material.alpha_mode, AlphaMode::Mask { .. }),
        ];
        Self((0..).zip(has).fold(0, |bits, (bit, has)| bits | u8::from(has) << bit))
    }

    /// Has a map.
    #[must_use]
    pub fn has_maps(self) -> bool {
        self.0 & !(1 << ALPHA_MASK_BIT) != 0
    }

    /// Alpha-masked.
    #[must_use]
    pub fn masked(self) -> bool {
        self.0 >> ALPHA_MASK_BIT & 1 == 1
    }

    /// The specialization constants; `force`: all on.
    pub fn spec(self, force: bool) -> impl Iterator<Item = (&'static str, u32)> {
        let bit = move |index: usize| u32::from(force || self.0 >> index & 1 == 1);
        VARIANT_BITS.into_iter().enumerate().map(move |(index, name)| (name, bit(index)))
    }
}
