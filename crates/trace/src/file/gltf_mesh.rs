//! glTF 2.0, text or binary, with its node transforms.

use std::path::Path;

use base64::Engine;
use glam::{DAffine3, DMat4, Vec3};
use gltf::buffer::Source;
use gltf::mesh::Mode;

use super::mesh::Mesh;
use crate::{Material, Pigment};

/// Reads the triangles of the default scene (of all scenes if none is marked), with base colour and emission factors
/// of their materials. Textures are not read: their surfaces take the factor. Skins and morph targets stay at rest.
pub(super) fn read(path: &Path) -> Result<Mesh, String> {
    let gltf::Gltf { document, mut blob } = gltf::Gltf::open(path).map_err(|error| error.to_string())?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or("its binary chunk is missing")?,
            Source::Uri(uri) => read_uri(folder, uri)?,
        };
        if bytes.len() < buffer.length() {
            return Err(format!("buffer {} has {} bytes instead of {}", buffer.index(), bytes.len(), buffer.length()));
        }
        buffers.push(bytes);
    }

    // Walk down the node trees
    let mut mesh = Mesh { materials: document.materials().map(|m| material(&m)).collect(), ..Mesh::default() };
    let scenes: Vec<_> = document.default_scene().map_or_else(|| document.scenes().collect(), |scene| vec![scene]);
    let mut open: Vec<_> = scenes.iter().flat_map(gltf::Scene::nodes).map(|node| (node, DAffine3::IDENTITY)).collect();
    open.reverse();
    while let Some((node, world_from_parent)) = open.pop() {
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let world_from_node = world_from_parent * DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            add(&mut mesh, &primitive, &buffers, world_from_node)?;
        }
        open.extend(node.children().map(|child| (child, world_from_node)));
    }
    Ok(mesh)
}

/// The bytes behind a URI: base64 data, or a file beside the glTF.
fn read_uri(folder: &Path, uri: &str) -> Result<Vec<u8>, String> {
    match uri.strip_prefix("data:") {
        Some(data) => {
            let (_, payload) = data.split_once(";base64,").ok_or("a data URI is not base64")?;
            let engine = base64::engine::general_purpose::STANDARD;
            engine.decode(payload).map_err(|error| format!("a data URI: {error}"))
        }
        None => std::fs::read(folder.join(uri)).map_err(|error| format!("its buffer {uri:?}: {error}")),
    }
}

fn material(source: &gltf::Material<'_>) -> Material {
    let [r, g, b, _] = source.pbr_metallic_roughness().base_color_factor();
    let strength = Vec3::from_array(source.emissive_factor());
    Material { pigment: Pigment::Constant(Vec3::new(r, g, b)), emission: strength }
}

/// Adds one primitive's triangles; points and lines have no surface and are left out.
fn add(
    mesh: &mut Mesh,
    primitive: &gltf::Primitive<'_>,
    buffers: &[Vec<u8>],
    world_from_node: DAffine3,
) -> Result<(), String> {
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let Some(positions) = reader.read_positions() else { return Ok(()) };
    let first = u32::try_from(mesh.vertices.len()).map_err(|_| "too many vertices".to_owned())?;
    mesh.vertices.extend(positions.map(|p| world_from_node.transform_point3(Vec3::from_array(p).as_dvec3())));
    let count = mesh.vertices.len() as u32 - first;
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..count).collect(),
    };
    if let Some(index) = indices.iter().find(|&&i| i >= count) {
        return Err(format!("a primitive names vertex {index} of {count}"));
    }
    let triangles: Vec<[u32; 3]> = match primitive.mode() {
        Mode::Triangles => indices.as_chunks::<3>().0.to_vec(),
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => indices.windows(2).skip(1).map(|pair| [indices[0], pair[0], pair[1]]).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    };
    // A node that mirrors turns its triangles inside out
    let mirrored = world_from_node.matrix3.determinant() < 0.0;
    let material = match primitive.material().index() {
        Some(index) => index as u32,
        None => mesh.add_default_material(),
    };
    for [a, b, c] in triangles {
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        mesh.triangles.push(corners.map(|i| first + i));
        mesh.material_of.push(material);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// One triangle under a node that moves it, its buffer inside the file.
    fn document(extra: &str) -> String {
        let mut bytes = Vec::new();
        for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(x.to_le_bytes());
        }
        let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
            "nodes": [{{"children": [1], "scale": [2, 2, 2]}}, {{"mesh": 0, "translation": [0, 0, -3]{extra}}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.5, 0.25, 0.125, 1]}},
                            "emissiveFactor": [0, 0.5, 1]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 0]}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
        )
    }

    #[test]
    fn nodes_move_triangles_and_factors_colour_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("one.gltf");
        std::fs::write(&path, document("")).unwrap();
        let mesh = read(&path).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.vertices[1], DVec3::new(2.0, 0.0, -6.0));
        assert_eq!(mesh.materials[0].pigment, Pigment::Constant(Vec3::new(0.5, 0.25, 0.125)));
        assert_eq!(mesh.materials[0].emission, Vec3::new(0.0, 0.5, 1.0));
        // A mirroring node keeps the outside out
        std::fs::write(&path, document(r#", "scale": [-1, 1, 1]"#)).unwrap();
        assert_eq!(read(&path).unwrap().triangles, [[0, 2, 1]]);
        std::fs::write(&path, "{}").unwrap();
        assert!(read(&path).is_err());
    }
}
