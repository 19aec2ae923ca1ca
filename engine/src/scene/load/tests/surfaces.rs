//! Materials, textures, lights and cameras.

use std::io::Cursor;

use glam::{DVec3, Vec2, Vec3, Vec4};
use image::{DynamicImage, ImageBuffer, ImageFormat};
use serde_json::{Value, json};

use super::{File, TRIANGLE, check_whole, load_text};
use crate::scene::load::LoadOptions;
use crate::scene::{AlphaMode, LightKind, Scene, Wrap};

fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, ImageFormat::Png).expect("an image in memory");
    bytes.into_inner()
}

/// A scene of a triangle with a material, and one texture of each of the images.
fn with_material(material: Value, images: &[Vec<u8>], more: Value) -> crate::Result<Scene> {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let uvs = file.floats("VEC2", &[0., 1., 1., 1., 1., 0.]);
    let views: Vec<_> = images.iter().map(|bytes| file.view(bytes)).collect();
    let attributes = json!({ "POSITION": positions, "TEXCOORD_3": uvs });
    let mut rest = super::one_primitive(json!({ "attributes": attributes, "material": 0 }));
    rest["materials"] = json!([material]);
    rest["images"] = views.iter().map(|&view| json!({ "bufferView": view })).collect();
    rest["textures"] = (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect();
    rest["samplers"] = json!([{ "wrapS": 33071, "magFilter": 9728, "minFilter": 9985 }]);
    for (key, value) in more.as_object().into_iter().flatten() {
        rest[key] = value.clone();
    }
    load_text(&file.text(rest), &LoadOptions::default())
}

#[test]
fn texture_transforms_scale_turn_and_move() {
    let transform = json!({
        "offset": [0.25, 0.5], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 4], "texCoord": 3
    });
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let image = png(ImageBuffer::from_pixel(1, 1, image::Rgb([10u8, 20, 30])));
    let material = json!({ "normalTexture": info, "emissiveTexture": { "index": 0 } });
    let scene = with_material(material, &[image], json!({})).expect("valid");
    check_whole(&scene);
    let used = scene.materials[0].normal_texture.expect("there");
    let [u, v] = used.uv_transform;
    let at = |x, y| Vec2::new(u.dot(Vec3::new(x, y, 1.0)), v.dot(Vec3::new(x, y, 1.0)));
    // One step along u becomes two up the picture, one along v four to the right.
    assert!(at(0.0, 0.0).distance(Vec2::new(0.25, 0.5)) < 1e-6);
    assert!(at(1.0, 0.0).distance(Vec2::new(0.25, -1.5)) < 1e-6);
    assert!(at(0.0, 1.0).distance(Vec2::new(4.25, 0.5)) < 1e-6);
    // Set 3 has taken the place of set 1.
    assert_eq!((used.uv_set, scene.materials[0].emissive_texture.map(|used| used.uv_set)), (1, Some(0)));
    let corner = scene.meshes[0].vertices.iter().find(|vertex| vertex.position == Vec3::X).expect("there");
    assert_eq!(corner.uv1, Vec2::ONE);
    // Along +u of the turned picture runs -v of the set and so +y of the triangle... which is up.
    assert!((corner.tangent[1].abs() - 1.0).abs() < 1e-5, "{:?}", corner.tangent);
}

#[test]
fn images_of_all_depths_become_rgba8() {
    let images = [
        png(ImageBuffer::from_pixel(2, 1, image::Luma([0x8080u16]))),
        png(ImageBuffer::from_pixel(1, 1, image::LumaA([7u8, 9]))),
        png(ImageBuffer::from_pixel(1, 2, image::Rgba([0xffffu16, 0, 0x0101, 0x8080]))),
    ];
    let material = json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 1 } },
        "occlusionTexture": { "index": 2, "strength": 0.25 },
        "emissiveTexture": { "index": 2 },
    });
    let scene = with_material(material, &images, json!({})).expect("valid");
    check_whole(&scene);
    let texture = |used: Option<crate::scene::TextureUse>| &scene.textures[used.expect("there").texture];
    let material = &scene.materials[0];
    let base = texture(material.base_color_texture);
    assert_eq!((base.size, &base.rgba8[..4], base.srgb), ([2, 1], &[0x80, 0x80, 0x80, 255][..], true));
    let metallic = texture(material.metallic_roughness_texture);
    assert_eq!((&metallic.rgba8[..], metallic.srgb), (&[7, 7, 7, 9][..], false));
    let (occlusion, emissive) = (texture(material.occlusion_texture), texture(material.emissive_texture));
    assert_eq!(&occlusion.rgba8[..4], &[255, 0, 1, 0x80]);
    assert!(!occlusion.srgb && emissive.srgb && std::sync::Arc::ptr_eq(&occlusion.rgba8, &emissive.rgba8));
    assert_eq!(material.occlusion_strength, 0.25);
    assert_eq!((base.sampler.wrap_u, base.sampler.wrap_v), (Wrap::ClampToEdge, Wrap::Repeat));
    assert!(!base.sampler.mag_linear && base.sampler.min_linear);
    assert_eq!(base.sampler.mip_linear, Some(false));
}

#[test]
fn fallbacks_and_broken_images() {
    let good = png(ImageBuffer::from_pixel(1, 1, image::Rgb([10u8, 20, 30])));
    let material = json!({ "emissiveTexture": { "index": 0 } });
    let images = [good, b"no image".to_vec()];
    let webp = json!([{ "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } }]);
    let scene = with_material(material.clone(), &images, json!({ "textures": webp })).expect("valid");
    assert_eq!(scene.warnings, ["image 1 is neither PNG nor JPEG nor WebP; image 0 used instead"]);
    let error = |textures: Value| {
        let more = json!({ "textures": textures });
        with_material(material.clone(), &images, more).expect_err("broken").to_string()
    };
    assert!(error(json!([{ "source": 1 }])).ends_with("image 1 is neither PNG nor JPEG nor WebP"));
    assert!(error(json!([{}])).contains("texture 0 has no image in a format that is read"));
    let elsewhere = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    assert!(error(elsewhere).contains("texture 0 has no image"));
    // What no material uses may be as broken as it likes.
    let unused = with_material(json!({}), &images, json!({})).expect("valid");
    assert!(unused.textures.is_empty());
}

#[test]
fn huge_images_are_refused_before_they_are_decoded() {
    let mut bytes = Cursor::new(Vec::new());
    let image = DynamicImage::from(ImageBuffer::from_pixel(8, 8, image::Rgb([1u8, 2, 3])));
    image.write_to(&mut bytes, ImageFormat::Jpeg).expect("an image in memory");
    let mut bytes = bytes.into_inner();
    let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).expect("a frame header");
    bytes[frame + 5..frame + 9].fill(0xff);
    let material = json!({ "emissiveTexture": { "index": 0 } });
    let line = with_material(material, &[bytes], json!({})).expect_err("huge").to_string();
    assert!(line.contains("image 0 "), "{line}");
}

/// Two rings of triangles around a point, one few enough for MikkTSpace and one not.
#[test]
fn crowded_points_still_get_tangents() {
    let material = json!({ "normalTexture": { "index": 0 } });
    let image = png(ImageBuffer::from_pixel(1, 1, image::Rgb([128u8, 128, 255])));
    for (segments, crowded) in [(100u16, false), (3000, true)] {
        let mut file = File::default();
        let rim = |i: u16| std::f32::consts::TAU * f32::from(i) / f32::from(segments);
        let mut positions = vec![0.0, 0.0, 0.0];
        positions.extend((0..segments).flat_map(|i| [rim(i).cos(), rim(i).sin(), 0.0]));
        // The picture lies upright on the disc: v runs down.
        let uvs: Vec<f32> = positions.chunks_exact(3).flat_map(|p| [p[0], -p[1]]).collect();
        let normals = [0.0, 0.0, 1.0].repeat(usize::from(segments) + 1);
        let corners: Vec<u16> = (0..segments).flat_map(|i| [0, i + 1, (i + 1) % segments + 1]).collect();
        let view = file.view(&image);
        let primitive = json!({
            "attributes": {
                "POSITION": file.floats("VEC3", &positions),
                "NORMAL": file.floats("VEC3", &normals),
                "TEXCOORD_0": file.floats("VEC2", &uvs),
            },
            "indices": file.indices(&corners),
            "material": 0,
        });
        let mut rest = super::one_primitive(primitive);
        rest["materials"] = json!([material]);
        rest["images"] = json!([{ "bufferView": view }]);
        rest["textures"] = json!([{ "source": 0 }]);
        let scene = file.load(rest).expect("valid");
        check_whole(&scene);
        assert_eq!(scene.warnings.len(), usize::from(crowded), "{:?}", scene.warnings);
        for vertex in &scene.meshes[0].vertices {
            let [x, _, _, sign] = vertex.tangent;
            assert!((x - 1.0).abs() < 1e-3 && sign == 1.0, "{segments}: {vertex:?}");
        }
    }
}

/// Heaps of triangles that share corners, overlap, have no area in the texture or huge coordinates.
#[test]
fn random_triangles_get_tangents() {
    let image = png(ImageBuffer::from_pixel(1, 1, image::Rgb([128u8, 128, 255])));
    let mut state = 1u64;
    let mut random = move |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for round in 0..300 {
        let scale = [1.0, 1e-30, 1e30, 3e38][round % 4];
        let mut file = File::default();
        let mut floats = |count: usize, scale: f32| -> Vec<f32> {
            (0..count).map(|_| (random(4) as f32 / 3.0 - 0.5) * scale).collect()
        };
        let (positions, normals, uvs) = (floats(90, scale), floats(90, 1.0), floats(60, scale));
        let corners: Vec<u16> = (0..180).map(|_| random(30) as u16).collect();
        let view = file.view(&image);
        let primitive = json!({
            "attributes": {
                "POSITION": file.floats("VEC3", &positions),
                "NORMAL": file.floats("VEC3", &normals),
                "TEXCOORD_0": file.floats("VEC2", &uvs),
            },
            "indices": file.indices(&corners),
            "material": 0,
        });
        let mut rest = super::one_primitive(primitive);
        rest["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
        rest["images"] = json!([{ "bufferView": view }]);
        rest["textures"] = json!([{ "source": 0 }]);
        let scene = file.load(rest).expect("valid");
        check_whole(&scene);
        let gave_up = scene.warnings.iter().any(|line| line.contains("MikkTSpace"));
        assert!(!gave_up, "round {round}: {:?}", scene.warnings);
    }
}

#[test]
fn material_numbers_are_brought_into_range() {
    let material = json!({
        "name": "odd",
        "pbrMetallicRoughness": { "baseColorFactor": [2, 0.5, -1, 0.25], "metallicFactor": 0, "roughnessFactor": 1e300 },
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "MASK",
        "doubleSided": true,
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 }, "KHR_materials_unlit": {} },
    });
    let scene = with_material(material, &[], json!({})).expect("valid");
    let material = &scene.materials[0];
    assert_eq!(material.base_color, Vec4::new(1.0, 0.5, 0.0, 0.25));
    assert_eq!((material.metallic, material.roughness), (0.0, 1.0));
    assert_eq!(material.emissive, Vec3::new(8.0, 4.0, 0.0));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert!(material.double_sided && material.unlit);
    assert_eq!(scene.materials.len(), 2);
    assert!(scene.warnings.contains(&"material 0 \"odd\": base colour 2 brought into 0 to 1".to_owned()));
}

#[test]
fn lights_and_cameras_stand_where_their_nodes_do() {
    let down = json!([-std::f64::consts::FRAC_1_SQRT_2, 0, 0, std::f64::consts::FRAC_1_SQRT_2]);
    let light = |light: usize| json!({ "KHR_lights_punctual": { "light": light } });
    let text = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "rotation": down, "scale": [3, 3, 3], "translation": [1, 2, 3], "extensions": light(0) },
            { "extensions": light(1) },
            { "name": "eye", "camera": 0, "scale": [-2, 2, 2], "translation": [0, 0, 5] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "spot", "intensity": 10, "color": [1, 0.5, 0], "range": 7,
              "spot": { "innerConeAngle": 0.3, "outerConeAngle": 0.3 } },
            { "type": "point", "intensity": -1 },
        ] } },
    });
    let scene = load_text(&text.to_string(), &LoadOptions::default()).expect("valid");
    check_whole(&scene);
    let spot = &scene.lights[0];
    assert_eq!(spot.intensity, Vec3::new(10.0, 5.0, 0.0));
    assert_eq!(spot.position, DVec3::new(1.0, 2.0, 3.0));
    assert!(spot.direction.distance(DVec3::NEG_Y) < 1e-12);
    let LightKind::Spot { range, inner_angle, outer_angle } = spot.kind else {
        panic!("{spot:?}");
    };
    assert!(range == 7.0 && inner_angle < outer_angle && outer_angle == 0.3);
    assert_eq!(scene.lights[1].kind, LightKind::Point { range: f32::INFINITY });
    assert_eq!(scene.lights[1].intensity, Vec3::ZERO);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.yfov_rad), ("eye", Some(0.5)));
    assert_eq!(camera.world_from_view, glam::DMat4::from_translation(DVec3::new(0.0, 0.0, 5.0)));
}
