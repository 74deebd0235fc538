//! STL and OBJ files.

use super::{Corners, RADIUS, cylinder, mesh, open_box};
use crate::common::{Setup, grain};
use makadam::Simulation;
use makadam::scene::{Scene, Shape, TriangleMesh};

fn binary(triangles: &[Corners]) -> Vec<u8> {
    let mut bytes = b"solid, says the head of this binary file".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle.iter().flatten().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text(triangles: &[Corners]) -> String {
    let mut text = String::from("solid test\n");
    for triangle in triangles {
        text += " facet normal 0 0 0\n  outer loop\n";
        triangle
            .iter()
            .for_each(|[x, y, z]| text += &format!("   vertex {:e} {:e} {:e}\n", *x as f32, *y as f32, *z as f32));
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid test\n"
}

fn obj(triangles: &[Corners]) -> String {
    let mut text = String::from("# test\n\no box\n");
    triangles
        .iter()
        .flatten()
        .for_each(|[x, y, z]| text += &format!("v {:e} {:e} {:e}\n", *x as f32, *y as f32, *z as f32));
    (0..triangles.len()).for_each(|k| text += &format!("f {}//1 {}/2/3 {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3));
    text
}

#[test]
fn text_binary_and_obj_give_the_same_mesh() {
    let triangles = open_box([0.0; 3], [0.0625, 0.0625, 0.125], 2);
    let [one, two, three] = [binary(&triangles), text(&triangles).into_bytes(), obj(&triangles).into_bytes()]
        .map(|bytes| TriangleMesh::read(&bytes).unwrap());
    assert_eq!(one, two);
    assert_eq!(one, three);
    assert_eq!(one.len(), 40);
    assert_eq!(one.dropped(), [0, 0]);
}

#[test]
fn a_polygon_of_an_obj_file_is_a_fan() {
    let mesh = TriangleMesh::read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n").unwrap();
    assert_eq!(mesh.len(), 2);
}

#[test]
fn a_concave_polygon_of_an_obj_file_keeps_its_area() {
    // The letter L, from each of its corners, and with one point on a side; then a square with a slit to a square hole.
    let ell = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 3], [0, 3], [0, 2]];
    let hole = [[0, 0], [3, 0], [3, 3], [0, 3], [0, 0], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1]];
    let area = |polygon: &[[i32; 2]], first: usize| {
        let points: String = polygon.iter().map(|[x, y]| format!("v {x} {y} {}\n", x + 2 * y)).collect();
        let face: String = (0..polygon.len()).map(|i| format!(" {}", (first + i) % polygon.len() + 1)).collect();
        let mesh = TriangleMesh::read(format!("{points}f{face}\n").as_bytes()).unwrap();
        let double = |[a, b, c]: [[f64; 3]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        // All triangles have the sense of the polygon, so that none overlap.
        assert!(mesh.corners().all(|corners| double(corners) > 0.0), "from corner {first}");
        mesh.corners().map(|corners| 0.5 * double(corners)).sum::<f64>()
    };
    for first in 0..7 {
        assert!((area(&ell, first) - 4.0).abs() < 1e-12, "from corner {first}");
    }
    for first in 0..10 {
        assert!((area(&hole, first) - 8.0).abs() < 1e-12, "from corner {first}");
    }
}

#[test]
fn triangles_without_area_and_repeated_ones_are_dropped_and_counted() {
    let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0]];
    let last_bit = [1.0 + 1e-7, 0.0, 0.0];
    let mesh = TriangleMesh::new(&[[a, b, c], [c, a, b], [b, a, c], [a, a, c], [a, d, b], [a, last_bit, c]]).unwrap();
    assert_eq!((mesh.len(), mesh.dropped()), (1, [2, 3]));
}

#[test]
fn what_is_no_mesh_is_refused_with_a_remedy() {
    for (bytes, problem) in [
        (&b"solid x\nvertex 1 2\nendloop"[..], "no three numbers in line 2; "),
        (b"solid x\nvertex 1 2 3\nendloop", "without three corners in line 3; "),
        (b"solid x\nvertex 1 2 3\n", "ends within a facet; "),
        (b"solid x\nvertex 1 2 3\nvertex 2 2 3\nvertex 4 5 7\nendloop\n", "ends without endsolid, "),
        (b"solid x\nendsolid\n", "no triangle with an area; "),
        (b"solid x\nvertex nan 2 3\nvertex 1 2 3\nvertex 4 5 7\nendloop\nendsolid", "not finite in triangle 1; "),
        (b"", "neither STL nor OBJ; "),
        (b"name = 'scene'\n", "neither STL nor OBJ; "),
        (&[0xff; 100], "neither STL nor OBJ"),
        (b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4\n", "without three known corners in line 4; "),
        (b"v 0 0 0\nv 2 0 0\nv 0 1 0\nv 3 2 0\nf 1 2 3 4\n", "crosses itself in line 5; triangulate"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2\n", "without three known corners in line 3; "),
    ] {
        let message = TriangleMesh::read(bytes).unwrap_err();
        assert!(message.contains(problem), "{message}");
        assert!(message.contains("; "), "no remedy: {message}");
    }
}

/// Text of a scene with a mesh from a file.
fn scene_text(file: &str, more: &str) -> String {
    let setup = Setup { body: grain(RADIUS, [0.02, 0.02, 0.02], [0.0; 3]), ..Setup::default() };
    let text = toml::to_string(&setup.scene()).unwrap();
    let wall =
        format!("[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'mesh', file = '{file}'{more} }}\n");
    text.replace("wall = []\n", "") + &wall
}

#[test]
fn a_scene_finds_its_files_beside_it_and_is_complete_when_written() {
    let folder = std::env::temp_dir().join(format!("makadam-mesh-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let triangles = open_box([0.0; 3], [40.0, 40.0, 80.0], 3);
    std::fs::write(folder.join("box.stl"), binary(&triangles)).unwrap();
    let more = ", scale = 0.001, translate = [0, 0.001, 0], rotate = { axis = [0, 0, 1], angle = 90 }";
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene_text("box.stl", more)).unwrap();
    let read = Scene::load(&file);
    let missing = Scene::parse_in(&scene_text("none.stl", more), &folder).unwrap_err().to_string();
    std::fs::write(folder.join("bad.stl"), b"solid\nendsolid").unwrap();
    let bad = Scene::parse_in(&scene_text("bad.stl", ""), &folder).unwrap_err().to_string();
    std::fs::remove_dir_all(&folder).unwrap();
    let scene = read.unwrap_or_else(|error| panic!("{error}"));
    assert!(missing.contains("none.stl' cannot be read") && missing.contains("wall[0].shape.file"), "{missing}");
    assert!(bad.contains("bad.stl' has no triangle"), "{bad}");
    // Turned by a right angle: from -0.04 to 0 along x.
    let [(low, high)] = scene.wall[0].shape.bounds()[..] else { panic!("one box") };
    for (found, expected) in low.iter().chain(&high).zip([-0.04, 0.001, 0.0, 0.0, 0.041, 0.08]) {
        assert!((found - expected).abs() < 1e-12, "{low:?} {high:?}");
    }
    // The written scene needs no file.
    let written = toml::to_string(&scene).unwrap();
    let again = Scene::parse(&written).unwrap();
    assert_eq!(again, scene);
    let Shape::Mesh { content, .. } = &again.wall[0].shape else { panic!("a mesh") };
    assert_eq!(content.len(), triangles.len());
    assert!(Scene::parse(&written.replace("content = \"", "content = \"AAAA")).is_err());
}

#[test]
fn a_mesh_in_millimetres_is_found_by_its_size() {
    let setup = Setup { body: grain(RADIUS, [0.02, 0.02, 0.02], [0.0; 3]), ..Setup::default() };
    let of = |factor: f64| {
        let triangles = open_box([0.0; 3], [0.04 * factor, 0.05 * factor, 0.08 * factor], 2);
        let mut scene = super::scene(&setup, &[mesh("box", &triangles)]);
        scene.domain = makadam::Domain { min: [-0.1; 3], max: [0.1; 3], periodic: Vec::new() };
        scene
            .findings(None)
            .into_iter()
            .map(|finding| finding.to_string())
            .filter(|text| text.contains("'box'"))
            .collect::<Vec<_>>()
    };
    assert_eq!(of(1.0), Vec::<String>::new());
    assert_eq!(of(20.0), Vec::<String>::new());
    // Small parts are larger than the grains.
    assert_eq!(of(0.13), Vec::<String>::new());
    assert!(of(0.12)[0].contains("spans 0.0048 x 0.006 x 0.0096 m"), "{:?}", of(0.12));
    let expected = "wall[0].shape.scale: 'box' spans 40 x 50 x 80 m where the longest side of the domain is 0.2 m, and the smallest grain \
                    0.01 m wide; is the file in millimetres? scale = 0.001 makes it fit";
    assert_eq!(of(1000.0), [expected]);
    assert!(of(39.0)[0].contains("is the file in inches? scale = 0.0254"), "{:?}", of(39.0));
    let triangle = [[0.0; 3], [0.04, 0.0, 0.0], [0.0, 0.04, 0.0]];
    let mut scene =
        super::scene(&setup, &[mesh("floor", &[triangle, triangle, [triangle[0], triangle[0], triangle[1]]])]);
    scene.domain = makadam::Domain { min: [-0.1; 3], max: [0.1; 3], periodic: Vec::new() };
    let findings = scene.findings(None);
    assert!(findings.iter().any(|one| one.problem.contains("1 triangles without area and 1 repeated")), "{findings:?}");
}

#[test]
fn grains_in_a_mesh_at_the_start_and_meshes_on_periodic_axes_are_refused() {
    let setup = Setup { body: grain(RADIUS, [0.0, 0.05, -0.098], [0.0; 3]), ..Setup::default() };
    let mut scene = super::scene(&setup, &[mesh("shell", &cylinder(0.1, 0.1, 40, 2))]);
    let error = Simulation::new(&scene, 1).err().unwrap().to_string();
    assert!(error.contains("inside or behind wall 'shell'"), "{error}");
    scene.domain.periodic.push(makadam::Axis::Y);
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("its shape has edges"), "{error}");
}
