//! OBJ files with their material libraries.

use crate::support::{check_sentence, load_files};
use glam::{DVec3, Vec3};
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::scene::{CameraPose, Lens, SceneDescription};
use mlt_scene::{BUILTIN, Loaded, SceneError, bounds, camera_framing, open};
use std::{collections::HashMap, fmt::Write};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn load(obj: &str) -> Result<Loaded, SceneError> {
    load_files(&[("scene.obj", obj.as_bytes())])
}

fn load_with(obj: &str, mtl: &str) -> Result<Loaded, SceneError> {
    let obj = format!("mtllib scene.mtl\nusemtl m\n{TRIANGLE}{obj}");
    load_files(&[("scene.obj", obj.as_bytes()), ("scene.mtl", mtl.as_bytes())])
}

/// A built-in scene as OBJ and MTL, with indices that count from the start or from the end.
fn as_obj(scene: &Loaded, relative: bool) -> (String, String) {
    let (mut obj, mut mtl) = ("# made by a test\nmtllib scene.mtl\n".to_owned(), String::new());
    for material in &scene.description.materials {
        let kd = match &material.bsdf {
            Bsdf::Lambert(lambert) => lambert.reflectance,
            _ => Vec3::ZERO,
        };
        let ke = material.emission;
        writeln!(mtl, "newmtl {}\nKd {} {} {}\nKe {} {} {}", material.name, kd.x, kd.y, kd.z, ke.x, ke.y, ke.z)
            .unwrap();
    }
    let (mut vertices, mut normals) = (0i64, 0i64);
    for mesh in &scene.description.meshes {
        let material = &scene.description.materials[mesh.material as usize].name;
        writeln!(obj, "o {}\nusemtl {material}", mesh.name).unwrap();
        mesh.positions.iter().for_each(|p| writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap());
        mesh.normals.iter().for_each(|n| writeln!(obj, "vn {} {} {}", n.x, n.y, n.z).unwrap());
        let (v, n) = (mesh.positions.len() as i64, mesh.normals.len() as i64);
        let (v_base, n_base) = if relative { (-v, -n) } else { (vertices + 1, normals + 1) };
        for triangle in &mesh.triangles {
            let corner = |i: u32| match n {
                0 => format!("{}", v_base + i64::from(i)),
                _ => format!("{}//{}", v_base + i64::from(i), n_base + i64::from(i)),
            };
            let [a, b, c] = triangle.map(corner);
            writeln!(obj, "f {a} {b} {c}").unwrap();
        }
        (vertices, normals) = (vertices + v, normals + n);
    }
    (obj, mtl)
}

#[test]
fn obj_and_gltf_of_the_built_in_scenes_agree() {
    for (name, relative) in BUILTIN.iter().flat_map(|scene| [(scene.name, false), (scene.name, true)]) {
        let gltf = open(name).unwrap();
        let (obj, mtl) = as_obj(&gltf, relative);
        let obj = load_files(&[("scene.obj", obj.as_bytes()), ("scene.mtl", mtl.as_bytes())]).unwrap();
        assert!(obj.warnings.is_empty() && obj.description.cameras.is_empty(), "{:?}", obj.warnings);
        assert_eq!(format!("{:?}", obj.description.materials), {
            let mut materials = gltf.description.materials.clone();
            materials.iter_mut().for_each(|m| m.emits_both_sides = false);
            format!("{materials:?}")
        });
        let meshes: HashMap<_, _> = obj.description.meshes.iter().map(|m| (&m.name, m)).collect();
        for mesh in &gltf.description.meshes {
            let other = meshes[&mesh.name];
            assert_eq!(
                (&mesh.positions, &mesh.triangles, mesh.material),
                (&other.positions, &other.triangles, other.material)
            );
            assert_eq!(mesh.normals.len(), other.normals.len());
            assert!(mesh.normals.iter().zip(&other.normals).all(|(a, b)| a.distance(*b) < 1e-6));
        }
    }
}

#[test]
fn polygons_become_triangles_and_the_rest_is_named() {
    let obj =
        format!("{TRIANGLE}v 1 1 0\nv 5 5 5 1 0 0\nvt 0 0\no square\nf 1/1 2/99 4/-7 3 # comment\nl 1 2 4\np 1\n");
    let loaded = load(&obj).unwrap();
    let mesh = &loaded.description.meshes[0];
    assert_eq!((mesh.triangles.len(), mesh.positions.len(), mesh.name.as_str()), (2, 4, "square"));
    assert_eq!(
        loaded.warnings,
        [
            "points and lines are not supported and left out",
            "some vertices have colours and some have none; all colours are left out",
            "faces name texture coordinates that are not there; all are left out"
        ]
    );
    assert!(matches!(&loaded.description.materials[0].bsdf, Bsdf::Lambert(_)));

    let loaded = load(&format!("{TRIANGLE}vn 0 0 1\nf 1//1 2 3\n")).unwrap();
    assert!(loaded.description.meshes[0].normals.is_empty() && loaded.warnings[0].contains("some have none"));
    let loaded = load(&format!("{TRIANGLE}v 0 nan 0\nf 1 2 3\nf 1 2 4\n")).unwrap();
    assert_eq!(loaded.description.meshes[0].triangles.len(), 1);
    assert!(loaded.warnings[0].contains("1 vertices"), "{:?}", loaded.warnings);
    assert_eq!(load("").unwrap().warnings, ["the scene has no triangles"]);
}

#[test]
fn far_positions_keep_double_precision() {
    let loaded = load("v 4000000.001 0 0\nv 4000001 0 0\nv 4000000 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(loaded.description.meshes[0].positions[0].x, 4_000_000.001);
}

#[test]
fn a_missing_library_or_material_is_grey_with_a_warning() {
    for (library, needle) in
        [("gone.mtl", "gone.mtl: cannot be read"), ("../x.mtl", "outside"), ("C:\\x.mtl", "outside")]
    {
        let loaded = load(&format!("mtllib {library}\n{TRIANGLE}usemtl red\nf 1 2 3\n")).unwrap();
        assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains(needle), "{:?}", loaded.warnings);
        assert!(matches!(&loaded.description.materials[0].bsdf, Bsdf::Lambert(l) if l.reflectance == Vec3::splat(0.5)));
    }
    let loaded = load_with("usemtl n\nf 1 2 3", "newmtl m\nKd 1 1 1").unwrap();
    assert_eq!(loaded.warnings, ["no material library defines `n`; grey stands in"]);
}

#[test]
fn materials_warn_about_what_they_cannot_say() {
    let loaded = load_with("f 1 2 3", "newmtl m\nKd 2 0 0\nmap_opacity a.png\naniso 1\ndisp c.png").unwrap();
    assert_eq!(
        loaded.warnings,
        [
            "material `m`: Kd is [2, 0, 0]; [1, 0, 0] is taken instead",
            "material `m`: not supported and left out: aniso, disp, map_opacity"
        ]
    );
    let grey = load_with("f 1 2 3", "newmtl m\nKd 0.25").unwrap();
    assert!(matches!(&grey.description.materials[0].bsdf, Bsdf::Lambert(l) if l.reflectance == Vec3::splat(0.25)));
}

#[test]
fn what_does_not_parse_is_refused_with_the_line() {
    for (tail, needle) in [
        ("f 1 2 4", "out of bounds at line 4"),
        ("f 1 2 0", "out of bounds"),
        ("f 1 2 x", "face parse error at line 4"),
        ("f 9223372036854775807 -9223372036854775808 1", "scene.obj"),
        ("v 1 2", "position parse error at line 4"),
        ("v a b c", "position"),
        ("v 1 2 3 0", "scaling"),
        ("vn 0 0 1\nf 1//2 2//1 3//1", "normal index"),
    ] {
        let error = load(&format!("{TRIANGLE}{tail}\n")).unwrap_err().to_string();
        check_sentence(&error);
        assert!(error.contains(needle), "{tail}: {error}");
    }
}

/// The names of the first mesh's material, and the warnings.
fn material_of(obj: &str, mtl: &str) -> (String, Vec<String>) {
    let files: [(&str, &[u8]); 2] = [("scene.obj", obj.as_bytes()), ("scene.mtl", mtl.as_bytes())];
    let loaded = load_files(&files).unwrap_or_else(|error| panic!("{obj:?} {mtl:?}: {error}"));
    let SceneDescription { meshes, materials, .. } = loaded.description;
    (materials[meshes[0].material as usize].name.clone(), loaded.warnings)
}

#[test]
fn names_are_found_however_they_are_written() {
    let two = "newmtl other\nKd 1 0 0\n";
    for (used, defined) in [
        ("usemtl\twall red", "newmtl wall red"),
        ("usemtl wall red  ", "newmtl\twall red\t"),
        ("usemtl \"wall red\"", "newmtl wall red"),
        ("usemtl wall", "newmtl \"wall\" # the wall"),
        ("usemtl wall # the wall", "newmtl wall"),
        ("usemtl wall #the wall", "newmtl wall#the wall\nnewmtl wall"),
        ("usemtl wall #2", "newmtl wall #1\nnewmtl wall #2"),
        ("usemtl wall\\\n red", "newmtl wall red"),
        ("USEMTL Wall", "NEWMTL Wall"),
        ("usemtl", "newmtl"),
        ("usemtl # none", "newmtl unnamed"),
    ] {
        let (name, warnings) = material_of(
            &format!("mtllib scene.mtl\n{TRIANGLE}{used}\nf 1 2 3\n"),
            &format!("{two}{defined}\nKd 0 1 0\n"),
        );
        assert!(name != "other" && name != "grey" && warnings.is_empty(), "{used} {defined}: {name} {warnings:?}");
        assert!(!used.contains("#2") || name.contains("#2"), "{name}");
    }
    let (name, warnings) = material_of(&format!("mtllib scene.mtl\n{TRIANGLE}usemtl \nf 1 2 3\n"), two);
    assert_eq!((name.as_str(), warnings.len()), ("grey", 1), "{warnings:?}");
}

#[test]
fn libraries_are_found_however_they_are_written() {
    for statement in [
        "mtllib scene.mtl",
        "mtllib \t\"scene.mtl\"",
        "mtllib scene.mtl # all of them",
        "MTLLIB scene.mtl",
        "mtllib gone.mtl scene.mtl",
        "mtllib a b.mtl scene.mtl",
        "mtllib \"a b.mtl\" \"scene.mtl\"",
        "mtllib gone scene.mtl",
        "mtllib gone \\\nscene.mtl",
        "mtllib .\\scene.mtl",
        "mtllib scene.mtl scene.mtl\nmtllib scene.mtl",
    ] {
        let (name, warnings) =
            material_of(&format!("{statement}\n{TRIANGLE}usemtl m\nf 1 2 3\n"), "newmtl m\nKd 1 0 0\n");
        let missing = usize::from(statement.contains("gone") || statement.contains("a b"));
        assert!(name == "m" && warnings.len() == missing, "{statement}: {name} {warnings:?}");
    }
    let all: [(&str, &[u8]); 3] = [
        ("scene.obj", b"mtllib a b\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl y\nf 1 2 3"),
        ("a", b"newmtl x"),
        ("b", b"newmtl y"),
    ];
    assert_eq!(load_files(&all).unwrap().warnings, [""; 0]);
}

#[test]
fn statements_that_cannot_be_read_are_left_out_with_a_warning() {
    for statement in [
        "Ks 0 0",
        "Kd xyz 1 1 1",
        "Kd spectral a.rfl 1",
        "Ns",
        "illum x",
        "d -halo 0.5",
        "map_Kd",
        "Ke 1 nan? 1",
        "Ni -1.#IND",
    ] {
        let loaded = load_with("f 1 2 3", &format!("Kd 1 1\nnewmtl m\n{statement}\nKd 0.25 0.5 0.75\n")).unwrap();
        let expected = format!("material `m`: `{statement}` cannot be read; the default stands in");
        assert!(loaded.warnings.contains(&expected) && loaded.warnings.len() == 2, "{:?}", loaded.warnings);
        let diffuse = Vec3::new(0.25, 0.5, 0.75);
        assert!(matches!(&loaded.description.materials[0].bsdf, Bsdf::Lambert(l) if l.reflectance == diffuse));
    }
    let loaded = load_with("f 1 2 3", "newmtl m\nillum 2.0 # it is\nKA spectral x\nKD 0.25 # grey\nNS\t9\n").unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert!(matches!(&loaded.description.materials[0].bsdf, Bsdf::Lambert(l) if l.reflectance == Vec3::splat(0.25)));
}

#[test]
fn lines_may_end_and_go_on_as_they_like() {
    let plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let expected = load(plain).unwrap().description.meshes;
    for text in [
        plain.replace('\n', "\r"),
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        plain.replace(' ', "\t \t").replace('\n', " \t\n"),
        plain.replace(' ', " \\\n"),
        plain.replace(' ', " \\  \r\n "),
        plain.replace('\n', " # remark \\\n"),
        plain.replace('v', "V").replace('f', "fo"),
        plain.to_uppercase(),
        plain.replace("f 1 2 3 4", "g\no\ns\nf 1// 2// -2// -1// \\"),
    ] {
        let meshes = load(&text).unwrap_or_else(|error| panic!("{text:?}: {error}")).description.meshes;
        assert_eq!(
            (&meshes[0].positions, &meshes[0].triangles),
            (&expected[0].positions, &expected[0].triangles),
            "{text:?}"
        );
    }
    let error = load(&format!("{TRIANGLE}v 0 \\\n 0 \\\n 1\nf 1 2 x\n")).unwrap_err().to_string();
    assert!(error.contains("line 7"), "{error}");
}

#[test]
fn what_is_no_number_is_dropped_in_any_spelling() {
    for word in ["nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND00", "inf", "1.#INF"] {
        let loaded = load(&format!("{TRIANGLE}v 0 {word} 0 # no\nvn {word} 0 0\nf 1//1 2//1 3//1\nf 1 2 4\n")).unwrap();
        assert_eq!(loaded.description.meshes[0].triangles.len(), 1, "{word}");
        assert!(loaded.warnings.iter().any(|w| w.contains("1 vertices")), "{word}: {:?}", loaded.warnings);
    }
}

#[test]
fn concave_polygons_are_filled_and_crossing_ones_are_named() {
    let arrow = "v 0 0 2\nv -1 0 0\nv 0 0 .5\nv 1 0 0\n";
    for face in ["f 1 2 3 4", "f 2 3 4 1", "f 4 3 2 1", "f -1 -4 -3 -2"] {
        let mesh = load(&format!("{arrow}{face}\n")).unwrap().description.meshes.remove(0);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let sum: f64 = mesh.triangles.iter().map(area).sum();
        assert!((sum - 1.5).abs() < 1e-12, "{face}: {sum}");
    }
    let crossing = load("o bow\nv 0 0 0\nv 3 2 0\nv 3 0 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    assert_eq!(crossing.warnings, ["mesh `bow`: the outlines of 1 polygons cross themselves; fans stand in"]);
}

#[test]
fn names_in_latin_1_are_told_apart() {
    let obj: &[u8] = b"mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gr\xfcn\nf 1 2 3\n";
    let mtl: &[u8] = b"newmtl gr\xfcn\nKd 0 1 0\nnewmtl gr\xe4n\nKd 1 0 0\n";
    let loaded = load_files(&[("scene.obj", obj), ("scene.mtl", mtl)]).unwrap();
    assert_eq!(loaded.description.meshes[0].material, 0);
}

#[test]
fn utf_16_is_read_in_either_order() {
    for unit in [u16::to_le_bytes, u16::to_be_bytes] {
        let text: Vec<u8> = format!("\u{feff}o Würfel\n{TRIANGLE}f 1 2 3\n").encode_utf16().flat_map(unit).collect();
        let loaded = load_files(&[("scene.obj", &text)]).unwrap();
        assert_eq!(loaded.description.meshes[0].name, "Würfel");
    }
}

#[test]
fn cameras_for_files_without_any() {
    let [from, to] = [DVec3::new(3.0, 4.0, 5.0), DVec3::new(3.0, 4.0, -5.0)];
    let camera = CameraPose::look_at(from, to, 1.0);
    assert_eq!((camera.forward, camera.up, camera.lens), (Vec3::NEG_Z, Vec3::Y, Lens::Pinhole { vertical_fov: 1.0 }));
    for to in [from, from + DVec3::Y, from - DVec3::Y, DVec3::NAN] {
        let camera = CameraPose::look_at(from, to, 1.0);
        assert!((camera.forward.length() - 1.0).abs() < 1e-6 && (camera.up.length() - 1.0).abs() < 1e-6, "{camera:?}");
        assert!(camera.forward.dot(camera.up).abs() < 1e-6);
    }

    let scene = load(&format!("{TRIANGLE}f 1 2 3\n")).unwrap().description;
    let around = bounds(&scene).unwrap();
    assert_eq!(around, [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)]);
    let camera = camera_framing(around);
    let half = f64::from(camera.lens.vertical_fov().unwrap() / 2.0);
    for point in scene.meshes.iter().flat_map(|m| &m.positions) {
        let to_point = *point - camera.position;
        assert!(to_point.angle_between(camera.forward.as_dvec3()) <= half);
    }
}

#[test]
fn materials_get_the_simplest_bsdf() {
    let bsdf = |mtl: &str| load_with("f 1 2 3", &format!("newmtl m\n{mtl}")).unwrap().description.materials[0].bsdf;
    assert!(matches!(bsdf("Kd 1 0 0\nKs 0 0 0\nNs 9"), Bsdf::Lambert(_)));
    assert!(matches!(bsdf("Kd 0 0 0\nKe 1 1 1"), Bsdf::Black));
    assert!(matches!(bsdf("Ks 1 1 1\nillum 3"), Bsdf::Mirror(_)));
    assert!(matches!(bsdf("Ni 1.5\nillum 7"), Bsdf::Dielectric(_)));
    assert!(matches!(bsdf("Kd 1 0 0\nKs 0.1 0.1 0.1\nNs 50"), Bsdf::Glossy(_)));
    assert!(matches!(bsdf("Kd 1 0 0\nPm 1\nPr 0.3"), Bsdf::Conductor(_)));
}
