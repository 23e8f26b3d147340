//! Glass as files say it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec3, Vec3};
use trace::{Ray, SceneFile};

/// A cube from -1 to 1 of a glTF material.
fn cube(material: &str) -> SceneFile {
    let corner = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0_f32 } else { -1.0 };
    let corners: Vec<Vec3> = (0..8).map(|i| Vec3::new(corner(i, 0), corner(i, 1), corner(i, 2))).collect();
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    let mut bytes: Vec<u8> = corners.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect();
    bytes.extend(triangles.flatten().flat_map(u16::to_le_bytes));
    let (length, data) = (bytes.len(), STANDARD.encode(&bytes));
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}],
        "materials": [{material}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]}},
            {{"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 96}}, {{"buffer": 0, "byteOffset": 96, "byteLength": 72}}],
        "buffers": [{{"byteLength": {length}, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cube.gltf");
    std::fs::write(&path, text).unwrap();
    SceneFile::open(&path).unwrap()
}

#[test]
fn a_volume_of_gltf_absorbs_by_its_own_thickness() {
    let material = |thickness: f32| {
        format!(
            r#"{{"pbrMetallicRoughness": {{"metallicFactor": 0, "roughnessFactor": 0}}, "extensions": {{
            "KHR_materials_transmission": {{"transmissionFactor": 1}}, "KHR_materials_ior": {{"ior": 1}},
            "KHR_materials_volume": {{"thicknessFactor": {thickness}, "attenuationColor": [0.9, 0.5, 0.1],
            "attenuationDistance": 4}}}}}}"#
        )
    };
    let ray = Ray::new(DVec3::new(0.3, 0.2, 5.0), DVec3::NEG_Z);
    for (thickness, way) in [(0.01, 2.0), (0.0, 0.0)] {
        let file = cube(&material(thickness));
        let scene = file.scene();
        // Of index 1 nothing is reflected; what matters is the way through the mesh. Without thickness its sides are panes
        let expected = scene.sky() * Vec3::new(0.9, 0.5, 0.1).powf(way / 4.0);
        let off = (scene.radiance(&ray) - expected).abs().max_element();
        assert!(off < 1e-5, "{thickness}: {} instead of {expected}", scene.radiance(&ray));
    }
}

#[test]
fn glass_of_a_scene_file_says_what_it_lacks() {
    let parse = |glass: &str| {
        let text = format!(
            "format = 1\n[materials.g]\nglass = {{ {glass} }}\n[shapes]\nball = {{ sphere = {{ radius = 1 }} }}\n\
             [[objects]]\nshape = \"ball\"\nmaterial = \"g\"\n"
        );
        SceneFile::parse(&text, "glass.toml")
    };
    assert!(parse("roughness = 0.3, attenuation_color = [0.9, 0.5, 0.1], attenuation_distance = 2").is_ok());
    let says = |glass: &str, what: &str| {
        let error = parse(glass).unwrap_err().to_string();
        assert!(error.contains(what) && !error.contains('\n'), "{error}");
    };
    says("thin = true, attenuation_color = 0.5, attenuation_distance = 2", "thin glass has no inside");
    says("attenuation_color = 0.5", "needs both");
    says("attenuation_color = 0.5, attenuation_distance = 0", "attenuation distance of glass is 0");
    says("attenuation_color = 1.5, attenuation_distance = 1", "attenuation colour of glass is 1.5");
    says("attenuation_color = nan, attenuation_distance = 1", "attenuation colour of glass is NaN");
    says("roughness = 2", "roughness is 2");
}
