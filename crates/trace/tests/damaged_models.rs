//! Damaged model files are refused or read, and never more.

use std::path::Path;

use base64::Engine;
use glam::DVec3;
use trace::SceneFile;

/// A textured square and a light under nodes, with indices, normals, coordinates and colours, all inside one file.
fn document() -> (String, Vec<u8>) {
    let mut bytes: Vec<u8> = Vec::new();
    let mut floats = |values: &[f32]| values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]); // places: 0, 48 bytes
    floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 1.0]); // normals: 48, 48 bytes
    floats(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]); // coordinates: 96, 32 bytes
    bytes.extend([255, 128, 0, 255, 255, 255, 255, 255, 0, 0, 0, 255, 9, 9, 9, 9]); // colours: 128, 16 bytes
    for index in [0_u16, 1, 2, 0, 2, 3] {
        bytes.extend(index.to_le_bytes()); // indices: 144, 12 bytes
    }
    let picture = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([80 * x as u8, 100 * y as u8, 7, 200]));
    let mut png = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let start = bytes.len();
    bytes.extend(&png);
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform"],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "spot", "intensity": 50,
            "spot": {{"innerConeAngle": 0.2, "outerConeAngle": 0.5}}}}]}}}},
        "nodes": [{{"children": [1, 2, 3], "scale": [2, 2, 2]}}, {{"mesh": 0, "translation": [0, 0, -3]}},
            {{"translation": [0, 2, 0], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}},
            {{"camera": 0, "rotation": [0, 0, 0, 1]}}],
        "cameras": [{{"type": "perspective", "perspective": {{"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.25}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3}},
            "indices": 4, "material": 0}}]}}],
        "materials": [{{"alphaMode": "MASK", "alphaCutoff": 0.5, "emissiveFactor": [0, 0.1, 0],
            "normalTexture": {{"index": 0, "scale": 0.5}},
            "pbrMetallicRoughness": {{"baseColorFactor": [0.5, 0.25, 0.125, 1], "roughnessFactor": 0.4,
            "baseColorTexture": {{"index": 0, "extensions": {{"KHR_texture_transform":
                {{"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3]}}}}}}}}}}],
        "textures": [{{"source": 0, "sampler": 0}}], "samplers": [{{"wrapS": 33071, "wrapT": 33648}}],
        "images": [{{"bufferView": 5, "mimeType": "image/png"}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}},
            {{"bufferView": 3, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"}},
            {{"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 48}},
            {{"buffer": 0, "byteOffset": 96, "byteLength": 32}}, {{"buffer": 0, "byteOffset": 128, "byteLength": 16}},
            {{"buffer": 0, "byteOffset": 144, "byteLength": 12}},
            {{"buffer": 0, "byteOffset": {start}, "byteLength": {}}}],
        "buffers": [{{"byteLength": {}"#,
        png.len(),
        bytes.len()
    );
    (json, bytes)
}

/// As text with its buffer in base64.
fn text() -> Vec<u8> {
    let (json, bytes) = document();
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(r#"{json}, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#).into_bytes()
}

/// As a binary file.
fn binary() -> Vec<u8> {
    let (json, mut bytes) = document();
    let mut json = format!("{json}}}]}}").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    let word = |file: &mut Vec<u8>, x: usize| file.extend((x as u32).to_le_bytes());
    word(&mut file, 2);
    word(&mut file, 12 + 8 + json.len() + 8 + bytes.len());
    word(&mut file, json.len());
    file.extend(b"JSON");
    file.extend(json);
    word(&mut file, bytes.len());
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}

fn open(path: &Path, bytes: &[u8]) -> Result<SceneFile, trace::FileError> {
    std::fs::write(path, bytes).unwrap();
    SceneFile::open(path)
}

#[test]
fn the_whole_file_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("a.gltf", text()), ("a.glb", binary())] {
        let file = open(&folder.path().join(name), &bytes).unwrap();
        assert!(file.warnings().is_empty(), "{:?}", file.warnings());
        let needs = file.scene().needs().join(", ");
        for need in ["glossy", "textured", "holes", "smooth", "colours", "point light"] {
            assert!(needs.contains(need), "{need} in {needs}");
        }
        // At the node's place, 0.8 radians from top to bottom, 1.25 times as wide
        let camera = file.shot(Some("camera0")).unwrap().camera;
        assert_eq!((camera.pose.position, camera.film.width(), camera.film.height()), (DVec3::ZERO, 1280, 1024));
        assert!((camera.film.max().y - 0.4_f64.tan()).abs() < 1e-6, "{:?}", camera.film);
        assert!((camera.pose.direction_to_world(DVec3::Z) - DVec3::NEG_Z).length() < 1e-6);
    }
}

#[test]
fn a_binary_file_that_states_to_be_shorter_than_its_header_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for length in [0_u32, 9, 11] {
        let mut bytes = binary();
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        let error = open(&folder.path().join("short.glb"), &bytes).unwrap_err().to_string();
        assert!(error.contains("length that is less"), "{length}: {error}");
    }
    // Nor is a file that ends in its header more than refused
    assert!(open(&folder.path().join("short.glb"), b"glTF'\0\0\0\0\0\0").is_err());
}

#[test]
fn an_orthographic_camera_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let whole = String::from_utf8(text()).unwrap();
    let view = r#"{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.25}}"#;
    let flat = r#"{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 10, "znear": 0.1}}"#;
    let file = open(&folder.path().join("o.gltf"), whole.replacen(view, flat, 1).as_bytes()).unwrap();
    assert!(file.shots().is_empty() && file.shot(None).is_ok());
    assert!(file.warnings()[0].contains("camera 0 is left out: it is orthographic"), "{:?}", file.warnings());
}

#[test]
fn no_byte_of_a_file_makes_it_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut outcomes = [0, 0];
    for (name, bytes) in [("b.gltf", text()), ("b.glb", binary())] {
        let path = folder.path().join(name);
        // Every second byte is changed, and at some places the file ends
        for place in (0..bytes.len()).step_by(2) {
            let mut changed = bytes.clone();
            changed[place] = match place / 2 % 4 {
                0 => changed[place] ^ 1,
                1 => changed[place] ^ 0x40,
                2 => b'9',
                _ => 0xff,
            };
            outcomes[usize::from(open(&path, &changed).is_ok())] += 1;
            if place % 64 == 0 {
                assert!(open(&path, &bytes[..place]).is_err());
            }
        }
    }
    assert!(outcomes[0] > 500 && outcomes[1] > 300, "{outcomes:?}: the test would say little");
}

#[test]
fn numbers_that_lie_are_refused_before_they_cost_anything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.gltf");
    let whole = String::from_utf8(text()).unwrap();
    let lies = [
        (r#""count": 4, "type": "VEC2""#, r#""count": 4000000000, "type": "VEC2""#),
        (r#""count": 6, "type": "SCALAR""#, r#""count": 0, "type": "SCALAR""#),
        (r#""byteOffset": 96, "byteLength": 32"#, r#""byteOffset": 18446744073709551615, "byteLength": 32"#),
        (r#""byteOffset": 48, "byteLength": 48"#, r#""byteOffset": 48, "byteStride": 8, "byteLength": 48"#),
        (r#""componentType": 5123, "count": 6"#, r#""componentType": 5126, "count": 6"#),
        (r#""children": [1, 2, 3], "scale""#, r#""children": [1, 2, 0], "scale""#),
        (r#""children": [1, 2, 3], "scale""#, r#""children": [1, 1, 1, 1, 1], "scale""#),
        (r#""extensionsUsed": ["#, r#""extensionsRequired": ["KHR_draco_mesh_compression"], "extensionsUsed": ["#),
    ];
    for (truth, lie) in lies {
        let changed = whole.replacen(truth, lie, 1);
        assert_ne!(changed, whole, "{truth}");
        let error = open(&path, changed.as_bytes()).err().unwrap_or_else(|| panic!("{lie} was believed"));
        let message = error.to_string();
        assert!(message.contains("c.gltf") && !message.contains('\n') && message.len() < 300, "{message}");
    }
}

#[test]
fn vertices_at_infinity_and_normals_of_nothing_are_lived_with() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv inf 0 0\nv nan nan nan\nvn 0 0 0\nvn nan 0 0\n\
                f 1//1 2//1 3//2\nf 1//1 2//1 4//1\nf 1//1 5//2 3//2\n";
    match open(&path, text.as_bytes()) {
        Ok(file) => {
            let shot = file.shot(None).unwrap();
            let ray = trace::Ray::new(shot.camera.pose.position, DVec3::new(0.3, 0.3, 0.0) - shot.camera.pose.position);
            assert!(file.scene().radiance(&ray).is_finite());
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

#[test]
fn no_byte_of_an_obj_or_its_library_makes_it_panic() {
    let folder = tempfile::tempdir().unwrap();
    let obj = b"# a square\nmtllib l.mtl\no s\nv 0 0 0 1 1 1\nv 1 0 0 0.5 0.2 1\nv 1 1 0 1 0 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
        vn 0 0 1\nvn 0.1 0 1\nusemtl m\nf 1/1/1 2/2/1 3/3/2 -1/1/1\nf 1//2 2//2 3//1\nf 1 2 3\nl 1 2\np 1\n";
    let library =
        b"newmtl m\nKd 0.5 0.4 0.3\nKe 0 0.1 0\nNs 10\nd 0.5\nillum 2\nmap_Kd -s 1 1 1 t.png\nmap_Bump t.png\n";
    let (path, beside) = (folder.path().join("e.obj"), folder.path().join("l.mtl"));
    std::fs::write(&beside, library).unwrap();
    open(&path, obj).unwrap();
    for place in 0..obj.len() {
        for byte in [b'9', b'-', b'/', b' ', b'\n', 0xff] {
            let mut changed = obj.to_vec();
            changed[place] = byte;
            let _ = open(&path, &changed);
        }
        let _ = open(&path, &obj[..place]);
    }
    for place in 0..library.len() {
        for byte in [b'9', b'-', b' ', b'\n', 0xff] {
            let mut changed = library.to_vec();
            changed[place] = byte;
            std::fs::write(&beside, &changed).unwrap();
            let _ = open(&path, obj);
        }
    }
    let text = String::from_utf8(obj.to_vec()).unwrap();
    let numbers = ["4294967295", "4294967296", "18446744073709551616", "-9223372036854775808", "9223372036854775807"];
    for number in numbers.into_iter().chain(["-5", "-9", "0", "99", "1e9", "nan"]) {
        for corner in [
            format!("{number}/{number}/{number}"),
            format!("{number}/3/2"),
            format!("3/{number}/2"),
            format!("3/3/{number}"),
        ] {
            let _ = open(&path, text.replace("3/3/2", &corner).as_bytes());
        }
    }
}
