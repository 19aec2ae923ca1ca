//! What every generated hall must satisfy.

use super::*;
use glam::Vec3;

fn hall(triangles: u32, lights: u32) -> Vec<u8> {
    generate_glb(&HallOptions { triangles, lights, ..HallOptions::default() }).expect("options in range")
}

/// Triangles drawn, after all checks of the file's geometry.
fn checked_triangles(bytes: &[u8]) -> u64 {
    let glb = gltf::Gltf::from_slice(bytes).expect("valid glTF");
    let blob = glb.blob.clone().expect("a binary chunk");
    let mut of_mesh = vec![0; glb.meshes().len()];
    for mesh in glb.meshes() {
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(&blob));
            let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
            let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
            let tangents: Vec<[f32; 4]> = reader.read_tangents().unwrap().collect();
            let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            let name = format!("{} / {:?}", mesh.name().unwrap(), primitive.material().name());
            for (normal, tangent) in normals.iter().zip(&tangents) {
                let along = Vec3::new(tangent[0], tangent[1], tangent[2]);
                assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: normal {normal}");
                assert!((along.length() - 1.0).abs() < 1e-5, "{name}: tangent {along}");
                assert!(along.dot(*normal).abs() < 1e-4, "{name}: tangent not across the normal");
                assert!(tangent[3].abs() == 1.0);
            }
            assert!(positions.iter().all(|p| p.is_finite()) && uvs.iter().flatten().all(|x| x.is_finite()));
            assert!(indices.len().is_multiple_of(3) && !indices.is_empty());
            let mut against = 0;
            for corners in indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|k| corners[k] as usize);
                assert!(a.max(b).max(c) < positions.len(), "{name}: index out of range");
                let area = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
                assert!(area.length() > 1e-10, "{name}: a triangle without area at {}", positions[a]);
                // A coarse surface's corner may look away; the three together may not.
                let side = normals[a] + normals[b] + normals[c];
                against += u32::from(area.dot(side) <= 0.0);
            }
            assert_eq!(against, 0, "{name}: wound against the normals, of {}", indices.len() / 3);
            of_mesh[mesh.index()] += indices.len() as u64 / 3;
        }
    }
    glb.nodes().filter_map(|node| node.mesh()).map(|mesh| of_mesh[mesh.index()]).sum()
}

fn hold_to(triangles: u32) {
    let drawn = checked_triangles(&hall(triangles, 256)) as f64;
    let wanted = f64::from(triangles);
    assert!((drawn - wanted).abs() <= 0.02 * wanted, "{drawn} of {wanted}");
}

/// Six times the volume that a part's triangles enclose; positive where they face outwards.
fn volume(part: &mesh::Part) -> f64 {
    let corner = |index: u32| Vec3::from(part.positions[index as usize]).as_dvec3();
    part.indices.chunks_exact(3).map(|c| corner(c[0]).dot(corner(c[1]).cross(corner(c[2])))).sum()
}

#[test]
fn hall_closed_bodies_face_outwards() {
    let mut body = mesh::Mesh::new("body", mesh::Detail { level: 1.0, counting: false });
    let from = |body: &mut mesh::Mesh, build: &dyn Fn(&mut mesh::Mesh)| {
        body.parts.clear();
        build(body);
        volume(&body.parts[0])
    };
    use glam::dvec3;
    use materials::Material::Chrome;
    let unit = [dvec3(-0.5, -0.5, -0.5), dvec3(0.5, 0.5, 0.5)];
    let cube = from(&mut body, &|m| shapes::block(m, Chrome, unit[0], unit[1], 0.001, true));
    assert!((cube / 6.0 - 1.0).abs() < 0.01, "{cube}");
    let ball = from(&mut body, &|m| shapes::sphere(m, Chrome, dvec3(3.0, 1.0, 2.0), 1.0, 64));
    assert!((ball / 6.0 - 4.18879).abs() < 0.05, "{ball}");
    let axes = [dvec3(1.0, 0.0, 0.0), dvec3(0.0, 1.0, 0.0)];
    let torus = from(&mut body, &|m| shapes::ring(m, Chrome, [96, 48], axes, 0.25));
    assert!((torus / 6.0 - 1.2337).abs() < 0.02, "{torus}");
}

#[test]
fn hall_meets_small_triangle_counts() {
    for triangles in [10_000, 23_456, 50_000, 70_000, 100_000] {
        hold_to(triangles);
    }
}

#[test]
fn hall_meets_the_default_triangle_count() {
    hold_to(250_000);
}

#[test]
fn hall_meets_a_million_triangles() {
    hold_to(1_000_000);
}

#[test]
#[ignore = "takes seconds in release, a minute otherwise"]
fn hall_meets_five_million_triangles() {
    hold_to(2_000_000);
    hold_to(5_000_000);
}

#[test]
fn hall_lists_what_was_asked_for() {
    for lights in [1, 2, 17, 256, 1000] {
        let bytes = hall(10_000, lights);
        let glb = gltf::Gltf::from_slice(&bytes).expect("valid glTF");
        assert_eq!(glb.lights().map(|all| all.len()), Some(lights as usize));
        let nodes = glb.nodes().filter(|node| node.light().is_some()).count();
        assert_eq!(nodes, lights as usize);
        let names: Vec<_> = glb.cameras().filter_map(|camera| camera.name()).collect();
        assert_eq!(names, ["main", "aisle", "dais"]);
        assert!(glb.materials().filter(|m| m.index().is_some()).count() >= 20);
        assert!(glb.materials().all(|m| m.alpha_mode() != gltf::material::AlphaMode::Blend));
    }
}

#[test]
fn hall_is_the_same_twice_and_varies_with_its_seed() {
    let first = hall(10_000, 40);
    assert!(first == hall(10_000, 40));
    let other = HallOptions { triangles: 10_000, lights: 40, seed: 2, ..HallOptions::default() };
    assert!(first != generate_glb(&other).expect("options in range"));
}

#[test]
fn hall_materials_stand_at_their_own_place() {
    for (place, look) in materials::TABLE.iter().enumerate() {
        assert_eq!(look.material as usize, place, "{}", look.name);
    }
}

#[test]
fn hall_refuses_numbers_out_of_range() {
    let fine = HallOptions::default();
    assert!(fine.check().is_ok());
    for options in [
        HallOptions { triangles: 9_999, ..fine },
        HallOptions { triangles: 5_000_001, ..fine },
        HallOptions { lights: 0, ..fine },
        HallOptions { lights: 1001, ..fine },
    ] {
        let message = generate_glb(&options).expect_err("out of range").to_string();
        assert!(message.starts_with("hall: ") && !message.contains('\n'));
    }
}

#[test]
fn hall_file_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = HallOptions { triangles: 10_000, lights: 3, seed: 4, ..HallOptions::default() };
    let path = folder.path().join("hall.glb");
    write_glb(&path, &options).expect("a file in a fresh folder");
    assert!(std::fs::read(&path).expect("it was written") == generate_glb(&options).expect("in range"));
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1);
    let message = write_glb(folder.path().join("none/hall.glb"), &options).expect_err("no such folder");
    assert!(message.to_string().contains("none"));
}
