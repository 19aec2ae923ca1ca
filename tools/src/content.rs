//! What is rendered, and from where.

use crate::failure::Failure;
use crate::library;
use crate::options::{HallArgs, parse_point};
use clap::Args;
use glam::{DMat4, DVec3, DVec4};
use macula::fovea::DisplayGeometry;
use macula::headless::Content;
use macula::scene::environment::Environment;
use macula::scene::{Scene, sdf};
use std::path::{Path, PathBuf};

/// What the user names on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A .gltf or .glb file.
    File(PathBuf),
    /// The generated hall.
    Hall,
    /// The ray-marched scene.
    Sdf,
}

/// `hall`, `sdf`, `sdf:primitives`, or a path.
pub fn parse_source(text: &str) -> Result<Source, String> {
    match text {
        "" => Err("expected a .gltf or .glb file, `hall` or `sdf:primitives`".into()),
        "hall" => Ok(Source::Hall),
        "sdf" | "sdf:primitives" => Ok(Source::Sdf),
        other => match other.strip_prefix("sdf:") {
            Some(name) => Err(format!("there is no ray-marched scene `{name}`; there is sdf:primitives")),
            None => Ok(Source::File(other.into())),
        },
    }
}

impl Source {
    /// A short name for tables.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            Self::Hall => "hall".into(),
            Self::Sdf => "sdf".into(),
        }
    }

    /// Loads or generates it.
    ///
    /// # Errors
    /// Those of loading and generating.
    pub fn open(&self, hall: &HallArgs, time_s: f64) -> Result<Subject, Failure> {
        match self {
            Self::File(path) => {
                library::load_scene(path, time_s).map(|scene| Subject::Scene(Box::new(scene)))
            }
            Self::Hall => {
                let scene = library::hall_scene(&library::hall_options(hall)?)?;
                Ok(Subject::Scene(Box::new(scene)))
            }
            Self::Sdf => Ok(Subject::Sdf),
        }
    }
}

/// What is rendered, in memory.
pub enum Subject {
    /// Triangles.
    Scene(Box<Scene>),
    /// The ray-marched scene.
    Sdf,
}

impl Subject {
    /// As the engine takes it.
    pub fn content<'a>(&'a self, environment: Option<&'a Environment>) -> Content<'a> {
        match self {
            Self::Scene(scene) => Content::Scene { scene, environment },
            Self::Sdf => Content::SdfPrimitives,
        }
    }

    /// The scene, where it is one of triangles.
    pub fn scene(&self) -> Option<&Scene> {
        match self {
            Self::Scene(scene) => Some(scene),
            Self::Sdf => None,
        }
    }
}

/// Loads an environment map and says in `warnings` what had to be mended.
///
/// # Errors
/// Those of loading.
pub fn load_environment(path: &Path, warnings: &mut Vec<String>) -> Result<Environment, Failure> {
    let environment = Environment::load(path)?;
    if environment.repaired > 0 {
        warnings.push(format!(
            "{}: {} pixels were negative or not finite and were mended",
            path.display(),
            environment.repaired
        ));
    }
    Ok(environment)
}

/// Light for a scene that would be black: one of triangles without any lamp, where no environment is
/// given. Says so in `warnings`.
pub fn neutral_light(subject: &Subject, warnings: &mut Vec<String>) -> Option<Environment> {
    let unlit = subject.scene().is_some_and(|scene| scene.lights.is_empty());
    unlit.then(|| {
        warnings.push("the scene has no lamps; lit by an even grey environment (--env gives another)".into());
        Environment::uniform([0.5; 3])
    })
}

/// Where the eye stands.
#[derive(Args, Clone, Debug, Default)]
pub struct CameraArgs {
    /// Camera of the scene, by name; `macula info SCENE` lists them [default: the first one, or else
    /// a view that holds the whole scene]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at", "up"])]
    pub camera: Option<String>,
    /// Where the eye stands, metres in world space (+Y up)
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at")]
    pub eye: Option<DVec3>,
    /// A point on the view axis
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<DVec3>,
    /// Direction that is up in the picture [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub up: Option<DVec3>,
}

impl CameraArgs {
    /// The eye's pose.
    ///
    /// # Errors
    /// [`Failure::Usage`] for an unknown camera or a view without a direction.
    pub fn world_from_view(&self, subject: &Subject, display: &DisplayGeometry) -> Result<DMat4, Failure> {
        if let (Some(eye), Some(look_at)) = (self.eye, self.look_at) {
            return look_from(eye, look_at, self.up);
        }
        match (subject, &self.camera) {
            (Subject::Sdf, Some(_)) => {
                Err(Failure::usage("the ray-marched scene has no cameras; use --eye and --look-at"))
            }
            (Subject::Sdf, None) => look_from(sdf::DEFAULT_EYE, sdf::DEFAULT_LOOK_AT, None),
            (Subject::Scene(scene), Some(name)) => camera_by_name(scene, name),
            (Subject::Scene(scene), None) => match scene.cameras.first() {
                Some(camera) => Ok(camera.world_from_view),
                None => Ok(framed(scene.bounds().unwrap_or([DVec3::ZERO; 2]), display)),
            },
        }
    }
}

fn camera_by_name(scene: &Scene, name: &str) -> Result<DMat4, Failure> {
    if let Some(camera) = scene.cameras.iter().find(|camera| camera.name == name) {
        return Ok(camera.world_from_view);
    }
    let names = scene.cameras.iter().map(|camera| format!("`{}`", camera.name)).collect::<Vec<_>>();
    let known =
        if names.is_empty() { "no cameras; use --eye and --look-at".into() } else { names.join(", ") };
    Err(Failure::usage(format!("{} has no camera `{name}`; it has {known}", scene.name)))
}

fn pose(eye: DVec3, forward: DVec3, right: DVec3) -> DMat4 {
    let up = right.cross(forward);
    let column = |axis: DVec3| DVec4::from((axis, 0.0));
    DMat4::from_cols(column(right), column(up), column(-forward), DVec4::from((eye, 1.0)))
}

/// The pose of an eye that looks at a point.
fn look_from(eye: DVec3, look_at: DVec3, up: Option<DVec3>) -> Result<DMat4, Failure> {
    let Some(forward) = (look_at - eye).try_normalize() else {
        return Err(Failure::usage("--eye and --look-at are the same point; the view has no direction"));
    };
    let right_of = |up: DVec3| {
        let right = forward.cross(up.normalize_or_zero());
        (right.length() > 1e-6).then(|| right.normalize())
    };
    let right = match up {
        Some(up) => right_of(up).ok_or_else(|| {
            Failure::usage("--up is 0 or lies along the view axis; give a direction across the view")
        })?,
        // Straight up or down: any direction across the view will do.
        None => right_of(DVec3::Y).unwrap_or_else(|| forward.any_orthonormal_vector()),
    };
    Ok(pose(eye, forward, right))
}

/// A view from the front, from a little above and to the right, far enough for the whole box.
fn framed(bounds: [DVec3; 2], display: &DisplayGeometry) -> DMat4 {
    let [low, high] = bounds;
    let centre = low + (high - low) / 2.0;
    let forward = DVec3::new(-0.5, -0.35, -1.0).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let mut distance = 0.0_f64;
    for corner in 0..8 {
        let pick = |bit: u32| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
        let offset = (high - low) * DVec3::new(pick(0), pick(1), pick(2));
        let (x, y, depth) = (offset.dot(right), offset.dot(up), offset.dot(forward));
        // |x| <= tan (distance + depth), and likewise for y.
        let across = if x < 0.0 { x / display.tan_left } else { x / display.tan_right };
        let along = if y < 0.0 { y / display.tan_down } else { y / display.tan_up };
        distance = distance.max(across.max(along) - depth);
    }
    // A margin of a twentieth; a scene of one point is looked at from a metre away.
    let distance = if distance > 0.0 { distance * 1.05 } else { 1.0 };
    pose(centre - forward * distance, forward, right)
}

/// A pose that a slow head has moved from: turned about the vertical axis, and moved to its right by
/// millimetres.
pub fn moved(world_from_view: DMat4, yaw_deg: f64, right_mm: f64) -> DMat4 {
    let right = world_from_view.x_axis.truncate() * (right_mm * 1e-3);
    let eye = world_from_view.w_axis.truncate();
    let turned = DMat4::from_axis_angle(DVec3::Y, yaw_deg.to_radians())
        * DMat4::from_translation(-eye)
        * world_from_view;
    DMat4::from_translation(eye + right) * turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::scene::Camera;

    #[test]
    fn sources_by_name() {
        assert_eq!(parse_source("hall"), Ok(Source::Hall));
        assert_eq!(parse_source("sdf:primitives"), Ok(Source::Sdf));
        assert_eq!(parse_source("./hall"), Ok(Source::File("./hall".into())));
        assert!(parse_source("sdf:teapot").is_err());
        assert!(parse_source("").is_err());
    }

    #[test]
    fn the_framed_view_holds_every_corner() {
        for (size, hfov) in [([1920, 1080], 100.0), ([300, 900], 20.0), ([64, 64], 170.0)] {
            let display = DisplayGeometry::symmetric(size, hfov);
            for bounds in [
                [DVec3::splat(-1.0), DVec3::ONE],
                [DVec3::new(100.0, 0.0, -3.0), DVec3::new(101.0, 50.0, -3.0)],
                [DVec3::splat(-1e-4), DVec3::new(2e-4, 0.0, 1e-4)],
            ] {
                let view_from_world = framed(bounds, &display).inverse();
                for corner in 0..8 {
                    let pick = |bit: u32, axis: usize| bounds[(corner >> bit & 1) as usize][axis];
                    let world = DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2));
                    let view = view_from_world.transform_point3(world);
                    assert!(view.z < 0.0, "{view}");
                    let (x, y) = (view.x / -view.z, view.y / -view.z);
                    assert!(x >= display.tan_left && x <= display.tan_right, "{x} of {display:?}");
                    assert!(y >= display.tan_down && y <= display.tan_up, "{y} of {display:?}");
                }
            }
        }
    }

    #[test]
    fn a_point_is_seen_from_a_metre() {
        let pose = framed([DVec3::ONE; 2], &DisplayGeometry::symmetric([8, 8], 90.0));
        assert!((pose.w_axis.truncate().distance(DVec3::ONE) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn only_scenes_without_lamps_get_neutral_light() {
        let mut warnings = Vec::new();
        assert!(neutral_light(&Subject::Sdf, &mut warnings).is_none() && warnings.is_empty());
        let dark = Subject::Scene(Box::default());
        assert!(neutral_light(&dark, &mut warnings).is_some());
        assert_eq!(warnings.len(), 1);
    }

    #[test]
    fn looking_needs_a_direction() {
        assert!(look_from(DVec3::ONE, DVec3::ONE, None).is_err());
        assert!(look_from(DVec3::ZERO, DVec3::Y, Some(DVec3::Y)).is_err());
        assert!(look_from(DVec3::ZERO, DVec3::Z, Some(DVec3::ZERO)).is_err());
        for target in [DVec3::Y, -DVec3::Y, DVec3::new(1.0, 2.0, 3.0)] {
            let Ok(pose) = look_from(DVec3::ZERO, target, None) else { panic!("{target}") };
            assert!((pose.determinant() - 1.0).abs() < 1e-12);
            assert!((-pose.z_axis.truncate()).distance(target.normalize()) < 1e-12);
        }
    }

    #[test]
    fn cameras_by_name_or_the_first() {
        let named = |name: &str, x: f64| Camera {
            name: name.into(),
            world_from_view: DMat4::from_translation(DVec3::X * x),
            yfov_rad: None,
        };
        let scene = Scene { cameras: vec![named("a", 1.0), named("b", 2.0)], ..Scene::default() };
        let subject = Subject::Scene(Box::new(scene));
        let display = DisplayGeometry::symmetric([8, 8], 90.0);
        let eye_x = |camera: Option<&str>| {
            let args = CameraArgs { camera: camera.map(str::to_owned), ..CameraArgs::default() };
            args.world_from_view(&subject, &display).map(|pose| pose.w_axis.x)
        };
        assert!(matches!(eye_x(None), Ok(1.0)));
        assert!(matches!(eye_x(Some("b")), Ok(2.0)));
        let Err(Failure::Usage(message)) = eye_x(Some("c")) else { panic!() };
        assert!(message.contains("`a`, `b`"), "{message}");
    }
}
