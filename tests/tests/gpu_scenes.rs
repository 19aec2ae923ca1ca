//! Every scene of the shared data that loads also renders: no NaN, no hole, no message of the validation
//! layer. And: environments, gazes, sizes and kernels of every kind.

use glam::{DMat4, DVec2, DVec3};
use macula::Error;
use macula::fovea::Kernel;
use macula::headless::{FrameInput, OffscreenRenderer};
use macula::scene::Scene;
use macula::scene::environment::Environment;
use macula::scene::load::{LoadOptions, load};
use macula::settings::Method;
use macula_tests::scenes::{at, camera_of, one, point_of_pixel, quad, sun, unlit, white};
use macula_tests::{ahead, data, gpu, kfr, kfr_with, next_frame, render, render_content, settings, upload};
use std::path::{Path, PathBuf};

/// The scene, or `None` where it is refused, which must be in one line that names the file.
fn load_or_refuse(path: &Path) -> Option<Scene> {
    match load(path, &LoadOptions { time_s: 0.5, ..LoadOptions::default() }) {
        Ok(scene) => Some(scene),
        Err(error @ (Error::File { .. } | Error::Io { .. })) => {
            let line = error.to_string();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            assert!(!line.contains('\n') && line.contains(&*name), "{line}");
            None
        }
        Err(error) => panic!("{}: {error}", path.display()),
    }
}

/// Renders each file by each of the methods; gives how many have triangles.
fn render_files(files: &[PathBuf], methods: &[Method]) -> usize {
    let gpu = gpu();
    let mut rendered = 0;
    let mut empty_done = false;
    for path in files {
        let Some(scene) = load_or_refuse(path) else { continue };
        // Files without triangles are all the same to the renderer: the first one stands for them.
        if scene.instances.is_empty() && std::mem::replace(&mut empty_done, true) {
            continue;
        }
        let content = upload(&gpu, &scene, None);
        for method in methods {
            let settings = settings([96, 64], 70.0, method.clone());
            let input = FrameInput { world_from_view: camera_of(&scene), ..ahead(&settings) };
            render_content(&gpu, &content, &settings, &input).check_whole(&path.to_string_lossy());
        }
        gpu.check();
        rendered += usize::from(!scene.instances.is_empty());
    }
    println!("{rendered} scenes with triangles");
    rendered
}

/// Every second file that is meant to load, from a first one on.
fn render_shared(first: usize) {
    let Some(folder) = data::shared("data/scenes") else { return };
    let files = data::gltf_files(&folder).into_iter();
    let good = files.filter(|path| !path.starts_with(folder.join("negative")));
    let half: Vec<_> = good.skip(first).step_by(2).collect();
    assert!(render_files(&half, &[Method::Full, kfr(1.8, 4.0)]) > 10);
}

#[test]
fn every_shared_scene_renders_by_both_methods() {
    render_shared(0);
}

#[test]
fn every_other_shared_scene_renders_by_both_methods() {
    render_shared(1);
}

#[test]
fn every_file_meant_to_be_invalid_is_refused_or_renders() {
    let Some(folder) = data::shared("data/scenes/negative") else { return };
    assert!(render_files(&data::gltf_files(&folder), &[kfr(1.8, 4.0)]) > 10);
}

#[test]
fn every_environment_file_lights_a_scene_or_is_refused() {
    let Some(folder) = data::shared("data/scenes/env") else { return };
    let gpu = gpu();
    let scene = one(quad(1.0, 1.0), at(0.0, 0.0, -3.0), white(0.5, 0.4));
    let mut loaded = 0;
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for path in files.iter().filter(|path| path.extension().is_some_and(|end| end == "exr" || end == "hdr")) {
        let environment = match Environment::load(path) {
            Ok(environment) => environment,
            Err(error) => {
                assert!(!error.to_string().contains('\n'), "{error}");
                continue;
            }
        };
        let content = upload(&gpu, &scene, Some(&environment));
        let settings = settings([96, 64], 80.0, kfr(1.8, 4.0));
        let frame = render_content(&gpu, &content, &settings, &ahead(&settings));
        frame.check_whole(&path.to_string_lossy());
        assert!(frame.at(2, 2).iter().sum::<f64>() > 0.0, "{}: black sky", path.display());
        assert!(frame.at(48, 32).iter().sum::<f64>() > 0.0, "{}: black surface", path.display());
        loaded += 1;
    }
    assert!(loaded >= 5, "{loaded} environments");
}

/// A white wall under a slanting sun.
fn lit_wall() -> Scene {
    let mut scene = one(quad(2.0, 2.0), at(0.0, 0.0, -3.0), white(0.0, 0.6));
    scene.lights.push(sun(3.0, DVec3::new(0.3, -0.4, -1.0)));
    scene
}

#[test]
fn any_gaze_renders_and_an_invalid_one_holds_the_last() {
    let gpu = gpu();
    let scene = lit_wall();
    let content = upload(&gpu, &scene, None);
    for kernel in [Kernel::Power { alpha: 4.0 }, Kernel::Exponential] {
        let settings = settings([96, 64], 90.0, kfr_with(1.8, kernel));
        let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
        let mut frame_at = |gaze_px: DVec2| {
            let frame = next_frame(&mut renderer, &settings, &FrameInput { gaze_px, ..ahead(&settings) });
            frame.check_whole(&format!("{kernel:?} {gaze_px}"));
            frame
        };
        for (x, y) in [
            (0.0, 0.0),
            (96.0, 64.0),
            (95.5, 63.5),
            (48.25, 0.0),
            (-1.0, 32.0),
            (97.0, 65.0),
            (192.0, 32.0),
            (-96.0, -64.0),
            (1e6, -1e6),
            (-1e6, 3.0),
            (1e300, 1e300),
        ] {
            assert!(!frame_at(DVec2::new(x, y)).stats.gaze_held, "{x}, {y}");
        }
        let before = frame_at(DVec2::new(20.0, 40.0));
        for bad in [DVec2::NAN, DVec2::new(f64::INFINITY, 3.0), DVec2::new(1.0, f64::NEG_INFINITY)] {
            let held = frame_at(bad);
            assert!(held.stats.gaze_held, "{bad}");
            assert!(held.hdr == before.hdr, "{bad}: not the picture of the last valid gaze");
        }
        // As valid as any other afterwards.
        assert!(!frame_at(DVec2::new(48.0, 32.0)).stats.gaze_held);
    }
}

#[test]
fn any_size_renders() {
    let gpu = gpu();
    let scene = lit_wall();
    let content = upload(&gpu, &scene, None);
    for (size, sigma) in [([1, 1], 1.8), ([1, 7], 1.8), ([3, 2], 4.0), ([13, 11], 1.0), ([97, 61], 1.8)] {
        let settings = settings(size, 8.0, kfr(sigma, 4.0));
        let frame = render_content(&gpu, &content, &settings, &ahead(&settings));
        frame.check_whole(&format!("{size:?}"));
        assert_eq!(frame.rgba8.len(), 4 * size[0] as usize * size[1] as usize);
        // The wall fills this view: no pixel may be black.
        assert!(frame.hdr.chunks(4).all(|pixel| pixel[0] > 0.01), "{size:?}");
    }
    let settings = settings([1, 1], 50.0, Method::Full);
    render_content(&gpu, &content, &settings, &ahead(&settings)).check_whole("full, 1x1");
}

#[test]
fn every_kernel_and_sigma_renders() {
    let gpu = gpu();
    let scene = lit_wall();
    let content = upload(&gpu, &scene, None);
    let sigmas = [1.0, 1.3, 2.0, 3.0, 4.0, 16.0, 64.0];
    let mut kernels: Vec<_> = (1..=6).map(|alpha| Kernel::Power { alpha: f64::from(alpha) }).collect();
    kernels.push(Kernel::Power { alpha: 2.5 });
    kernels.push(Kernel::Sine);
    kernels.push(Kernel::Exponential);
    kernels.push(Kernel::polynomial(&[0.0, 0.25, 0.25, 0.5]).unwrap());
    for (kernel, sigma) in kernels.into_iter().zip(sigmas.into_iter().cycle()) {
        let settings = settings([96, 64], 60.0, kfr_with(sigma, kernel));
        let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
        for gaze_px in [DVec2::new(48.0, 32.0), DVec2::new(3.0, 60.5)] {
            let frame = next_frame(&mut renderer, &settings, &FrameInput { gaze_px, ..ahead(&settings) });
            frame.check_whole(&format!("{kernel:?} sigma {sigma}"));
            assert!(
                frame.hdr.chunks(4).all(|pixel| pixel[0] > 0.01),
                "{kernel:?} sigma {sigma}: a black pixel"
            );
        }
    }
}

#[test]
fn near_and_far_share_a_view() {
    let gpu = gpu();
    // At 1e-3 m over the left half, at 1e5 m everywhere, at 0.9e5 m over the upper right quarter.
    let mut scene = one(quad(1e-3, 1e-2), at(-1e-3, 0.0, -1e-3), unlit(1.0, 0.0, 0.0));
    let add = macula_tests::scenes::add;
    add(&mut scene, quad(4e5, 4e5), at(0.0, 0.0, -1e5), unlit(0.0, 1.0, 0.0));
    add(&mut scene, quad(2e5, 2e5), at(2e5, 2e5, -0.9e5), unlit(0.0, 0.0, 1.0));
    let settings = settings([64, 64], 60.0, Method::Full);
    let frame = render(&gpu, &scene, None, &settings, &ahead(&settings));
    frame.check_whole("near and far");
    for y in 0..64 {
        for x in 0..64 {
            let expected = match (x < 32, y < 32) {
                (true, _) => [1.0, 0.0, 0.0],
                (false, true) => [0.0, 0.0, 1.0],
                (false, false) => [0.0, 1.0, 0.0],
            };
            assert_eq!(frame.at(x, y), expected, "{x}, {y}");
        }
    }
}

#[test]
fn a_world_far_from_its_origin_looks_the_same() {
    let gpu = gpu();
    let offset = DVec3::new(1e6, -1e6, 1e6);
    let mut near = lit_wall();
    near.lights.push(macula_tests::scenes::light(
        6.0,
        DVec3::new(0.5, 0.5, -2.0),
        DVec3::NEG_Z,
        macula::scene::LightKind::Point { range: 5.0 },
    ));
    macula_tests::scenes::add(&mut near, quad(0.2, 0.2), at(-0.3, 0.2, -2.5), white(1.0, 0.3));
    let mut far = near.clone();
    for instance in &mut far.instances {
        instance.world_from_mesh = DMat4::from_translation(offset) * instance.world_from_mesh;
    }
    for light in &mut far.lights {
        light.position += offset;
    }
    for method in [Method::Full, kfr(1.8, 4.0)] {
        let mut settings = settings([128, 96], 60.0, method);
        settings.shadowed_lights = 2;
        let here = render(&gpu, &near, None, &settings, &ahead(&settings));
        let moved = FrameInput { world_from_view: DMat4::from_translation(offset), ..ahead(&settings) };
        let there = render(&gpu, &far, None, &settings, &moved);
        there.check_whole("far");
        let psnr = macula_tests::psnr(&here, &there);
        assert!(psnr > 50.0, "{psnr} dB");
        // Not equal for want of light.
        let point = point_of_pixel(&settings.display, 64, 48, 3.0);
        assert!(here.at(64, 48)[0] > 0.1, "{point}");
    }
}

#[test]
fn the_shared_scene_with_a_huge_offset_is_not_black() {
    let Some(path) = data::shared("data/scenes/edge-transforms/huge_offset.glb") else { return };
    let gpu = gpu();
    let mut scene = load(&path, &LoadOptions::default()).unwrap();
    let view = camera_of(&scene);
    scene.lights.push(sun(5.0, -view.z_axis.truncate() + DVec3::new(0.1, -0.3, 0.2)));
    let settings = settings([160, 90], 70.0, Method::Full);
    let frame =
        render(&gpu, &scene, None, &settings, &FrameInput { world_from_view: view, ..ahead(&settings) });
    frame.check_whole("huge offset");
    let lit = frame.hdr.chunks(4).filter(|pixel| pixel[..3].iter().sum::<f32>() > 0.02).count();
    assert!(lit > 160 * 90 / 50, "only {lit} of {} pixels are lit", 160 * 90);
}
