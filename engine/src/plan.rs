//! The effect plan: what this scene, view and these settings call for, and why the rest is left out.

use crate::content::SceneFeatures;
use crate::passes::MAX_SHADOW_VIEWS;
use crate::scene::{Light, LightKind};
use crate::settings::{LpFilter, Method, RenderSettings};
use crate::stats::{EffectNote, Effects};

/// What is built.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EffectPlan {
    /// The lights in the order in which the shaders go through them: directional ones, others that
    /// cast shadows, the rest; each with its first shadow view, or `None`.
    pub lights: Vec<(usize, Option<u32>)>,
    /// Directional lights, which come first in `lights`.
    pub directional_count: u32,
    /// Lights below it are directional or cast shadows.
    pub shadowed_end: u32,
    /// Shadow views to draw.
    pub shadow_views: u32,
    /// The shadow pass runs.
    pub shadows: bool,
    /// The forward pass is built.
    pub forward: bool,
    /// The filter over the LP-buffer.
    pub lp_filter: LpFilter,
    /// The post filter runs.
    pub post_filter: bool,
    /// Maps are sampled by the samples' footprints.
    pub footprint_maps: bool,
    /// Values of the shading kernel's specialization constants.
    pub shading_spec: Vec<(&'static str, u32)>,
    /// Values of the material's specialization constants, without those of single maps.
    pub material_spec: Vec<(&'static str, u32)>,
    /// Alpha-masked surfaces have a pipeline of their own.
    pub alpha_mask: bool,
    /// For people.
    pub effects: Effects,
}

/// Collects decisions and the words for them.
struct Decisions {
    force: bool,
    effects: Effects,
}

impl Decisions {
    /// Decides for an effect: `called_for` with a reason for each answer.
    fn decide(&mut self, name: &'static str, called_for: bool, yes: String, no: &str) -> bool {
        if called_for {
            self.effects.run.push(EffectNote { name, why: yes });
        } else if self.force {
            self.effects.run.push(EffectNote { name, why: format!("forced, although {no}") });
        } else {
            self.effects.skipped.push(EffectNote { name, why: no.to_owned() });
        }
        called_for || self.force
    }

    /// As [`Self::decide`], but what the caller switched off stays off.
    fn setting(&mut self, name: &'static str, on: bool, yes: &str, no: &str) -> bool {
        let list = if on { &mut self.effects.run } else { &mut self.effects.skipped };
        list.push(EffectNote { name, why: if on { yes } else { no }.to_owned() });
        on
    }
}

/// Views that a light's shadow needs.
fn views_of(light: &Light) -> u32 {
    match light.kind {
        LightKind::Directional | LightKind::Spot { .. } => 1,
        LightKind::Point { .. } => 6,
    }
}

fn count(number: u32, what: &str) -> String {
    format!("the scene has {number} {what}{}", if number == 1 { "" } else { "s" })
}

impl EffectPlan {
    /// Decides for a triangle scene. `lights` in the order of [`crate::content::GpuScene::lights`].
    #[must_use]
    pub fn of_scene(features: &SceneFeatures, lights: &[Light], settings: &RenderSettings) -> Self {
        let mut d = Decisions { force: settings.force_effects, effects: Effects::default() };
        let mut plan = Self::default();
        plan.order_lights(lights, settings);
        d.setting("gbuffer", true, "a triangle scene is shaded from its G-buffer", "");
        let casters = features.opaque && plan.shadow_views > 0;
        let shadow_why = if features.lights() == 0 {
            "the scene has no lamps"
        } else if settings.shadowed_lights == 0 {
            "shadows are switched off"
        } else {
            "nothing casts a shadow"
        };
        let lit = plan.lights.iter().filter(|(_, view)| view.is_some()).count() as u32;
        plan.shadows = d.decide("shadows", casters, count(lit, "shadowed light"), shadow_why);
        if !casters {
            plan.lights.iter_mut().for_each(|(_, view)| *view = None);
            plan.shadowed_end = plan.directional_count;
            // Forced: the pass draws one view, which no light reads.
            plan.shadow_views = u32::from(plan.shadows);
        }
        let f = features;
        let lights = [
            ("directional lights", "HAS_DIRECTIONAL", f.directional_lights, "directional light"),
            ("point lights", "HAS_POINT", f.point_lights, "point light"),
            ("spot lights", "HAS_SPOT", f.spot_lights, "spot light"),
        ];
        for (name, constant, number, what) in lights {
            let on = d.decide(name, number > 0, count(number, what), &format!("the scene has no {what}"));
            plan.shading_spec.push((constant, u32::from(on)));
        }
        plan.shading_spec.push(("HAS_SHADOWS", u32::from(plan.shadows)));
        let yes = |what: &str| format!("the scene has {what}");
        let on = d.decide(
            "environment",
            f.environment,
            yes("an environment map: sky and ambient light"),
            "there is no environment map",
        );
        plan.shading_spec.push(("HAS_ENVIRONMENT", u32::from(on)));
        let on = d.decide("emissive", f.emissive, yes("emissive materials"), "no material emits light");
        plan.shading_spec.push(("HAS_EMISSIVE", u32::from(on)));
        plan.material_spec.push(("HAS_MATERIAL_EMISSIVE", u32::from(on)));
        // Maps are specialised material by material; here they are only reported.
        d.decide("normal maps", f.normal_maps, yes("normal maps"), "no material has a normal map");
        d.decide("occlusion maps", f.occlusion, yes("occlusion maps"), "no material has an occlusion map");
        let on =
            d.decide("vertex colours", f.vertex_colors, yes("vertex colours"), "no mesh has vertex colours");
        plan.material_spec.push(("HAS_VERTEX_COLORS", u32::from(on)));
        plan.alpha_mask = d.decide(
            "alpha mask",
            f.alpha_mask,
            yes("alpha-masked materials"),
            "no material is alpha-masked",
        );
        plan.forward = d.decide("transparency", f.blend, yes("blended materials"), "no material is blended");
        if settings.foveated() {
            plan.footprints(&mut d, features, settings);
        }
        plan.after_shading(&mut d, settings);
        plan.effects = d.effects;
        plan
    }

    /// Shading over footprints larger than a pixel.
    fn footprints(&mut self, d: &mut Decisions, features: &SceneFeatures, settings: &RenderSettings) {
        const NAMES: [&str; 2] = ["footprints of maps", "footprints of surfaces"];
        if !settings.footprint {
            for name in NAMES {
                d.setting(name, false, "", "switched off");
            }
            return;
        }
        self.footprint_maps = d.decide(
            NAMES[0],
            features.opaque_maps,
            "peripheral samples cover several pixels of the scene's maps each".into(),
            "no opaque material has a map",
        );
        let on = d.decide(
            NAMES[1],
            features.opaque_lit || features.opaque_maps,
            "peripheral samples cover several pixels of lit or mapped surfaces each".into(),
            "every opaque surface has one colour, whatever its normals",
        );
        self.shading_spec.push(("HAS_TAPS", u32::from(on)));
    }

    /// Decides for the ray-marched scene.
    #[must_use]
    pub fn of_sdf(settings: &RenderSettings) -> Self {
        let mut d = Decisions { force: false, effects: Effects::default() };
        let mut plan = Self::default();
        d.setting("ray marching", true, "the scene is made of signed-distance primitives", "");
        d.setting("gbuffer", false, "", "rays start from the samples themselves");
        d.setting("shadows", false, "", "soft shadows are marched, there are no shadow maps");
        d.setting("transparency", false, "", "no primitive is blended");
        plan.after_shading(&mut d, settings);
        plan.effects = d.effects;
        plan
    }

    /// Gives the first lights shadow views, and puts the lights into the shaders' order.
    fn order_lights(&mut self, lights: &[Light], settings: &RenderSettings) {
        for (index, light) in lights.iter().enumerate() {
            let views = views_of(light);
            let wanted = self.lights.len() < settings.shadowed_lights as usize
                && self.shadow_views + views <= MAX_SHADOW_VIEWS;
            self.lights.push((index, wanted.then_some(self.shadow_views)));
            self.shadow_views += if wanted { views } else { 0 };
        }
        let directional = |index: usize| matches!(lights[index].kind, LightKind::Directional);
        let rank = |&(index, view): &(usize, Option<u32>)| match (directional(index), view) {
            (true, _) => 0,
            (false, Some(_)) => 1,
            (false, None) => 2,
        };
        // Stable: within a rank the brightest stay first.
        self.lights.sort_by_key(rank);
        let below = |limit: u8| self.lights.iter().filter(|light| rank(light) < limit).count() as u32;
        (self.directional_count, self.shadowed_end) = (below(1), below(2));
    }

    fn after_shading(&mut self, d: &mut Decisions, settings: &RenderSettings) {
        self.lp_filter = settings.method.lp_filter();
        if settings.foveated() {
            let yes = match self.lp_filter {
                LpFilter::None => "",
                LpFilter::Gaussian => "Gaussian: peripheral texels cover several pixels each",
                LpFilter::Fxaa => "FXAA: peripheral texels cover several pixels each",
            };
            d.setting("LP filter", self.lp_filter != LpFilter::None, yes, "switched off");
        } else {
            d.setting("foveation", false, "", "full shading was asked for");
        }
        if let Method::Kfr(kfr) = &settings.method {
            self.post_filter =
                d.setting("post filter", kfr.post_filter, "switched on (Eq. 2.14)", "not switched on");
        }
        d.setting("motion vectors", false, "", "nothing reads them");
        d.setting("check of finite values", settings.check_finite, "asked for", "not asked for");
    }
}
