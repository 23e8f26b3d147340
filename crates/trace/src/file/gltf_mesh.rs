//! glTF 2.0, text or binary: meshes under their nodes, materials, cameras and lights.

use std::path::Path;

use glam::{DAffine3, DMat4, DVec3, Vec2, Vec3, Vec4};
use gltf::buffer::Source;
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::mesh::Mode;

use super::gltf_access::{self, COLORS, COORDINATES, INDICES, PLACES};
use super::gltf_material::Materials;
use super::mesh::{Attributes, Mesh};
use super::model::{Model, ModelCamera};
use super::resources::Resources;
use crate::Light;

/// Lumens of a watt: lights are in candela and lux, radiance here in what is emitted.
const LUMENS_PER_WATT: f32 = 683.0;

/// Most triangles, all copies of a mesh counted: a small file can name one mesh a million times.
const MOST_TRIANGLES: usize = 1 << 25;

/// Reads the default scene (all scenes if none is marked). Skins and morph targets stay at rest.
pub(super) fn read(path: &Path) -> Result<Model, String> {
    let (document, mut blob) = parse(path)?;
    let mut resources = Resources::beside(path);
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or("its binary chunk is missing")?,
            Source::Uri(uri) => resources.read_uri(uri).map_err(|error| {
                if uri.starts_with("data:") { error } else { format!("its buffer {uri:?}: {error}") }
            })?,
        };
        if bytes.len() < buffer.length() {
            return Err(format!("buffer {} has {} bytes instead of {}", buffer.index(), bytes.len(), buffer.length()));
        }
        buffers.push(bytes);
    }

    // Take materials and cameras as they are listed
    let mut model = Model::default();
    let mut materials = Materials { resources: &mut resources, buffers: &buffers };
    for material in document.materials() {
        let (material, finish) = materials.read(&material);
        model.mesh.add_finished(material, finish);
    }
    model.cameras = document.cameras().map(|source| camera(&source)).collect();

    // Walk down the node trees, in which each node stands once
    let scenes: Vec<_> = document.default_scene().map_or_else(|| document.scenes().collect(), |scene| vec![scene]);
    let mut open: Vec<_> = scenes.iter().flat_map(gltf::Scene::nodes).map(|node| (node, DAffine3::IDENTITY)).collect();
    open.reverse();
    let most = document.nodes().count() * scenes.len().max(1);
    let mut count = 0;
    while let Some((node, world_from_parent)) = open.pop() {
        count += 1;
        if count > most {
            return Err("its nodes are no tree: one has two parents, or is its own".to_owned());
        }
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let world_from_node = world_from_parent * DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            add(&mut model.mesh, &primitive, &buffers, world_from_node)?;
        }
        if let Some(source) = node.camera() {
            let camera = &mut model.cameras[source.index()];
            camera.world_from_camera.get_or_insert(world_from_node);
        }
        if let Some(source) = node.light() {
            model.lights.extend(light(&source, &world_from_node, &mut resources));
        }
        open.extend(node.children().map(|child| (child, world_from_node)));
    }
    model.mesh.warnings.extend(resources.warnings);
    Ok(model)
}

/// What a file says, if it keeps to the format.
fn parse(path: &Path) -> Result<(gltf::Document, Option<Vec<u8>>), String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    // The crate takes the 12 bytes of a binary header off the length that it states
    let stated = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..)?.first_chunk());
    if stated.is_some_and(|length| u32::from_le_bytes(*length) < 12) {
        return Err("its header states a length that is less than its own".to_owned());
    }
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(&bytes).map_err(|error| one_line(&error))?;
    // The crate looks at these accessors before it has found out that they exist
    let mut json = document.into_json();
    let count = json.accessors.len();
    let mut attributes = json.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|one| one.attributes.values());
    if let Some(index) = attributes.find(|index| index.value() >= count) {
        return Err(format!("a primitive names accessor {} of {count}", index.value()));
    }
    // And takes it for granted that pictures are somewhere, and say what they are
    for (i, image) in json.images.iter_mut().enumerate() {
        if image.buffer_view.is_none() && image.uri.is_none() {
            return Err(format!("image {i} is nowhere"));
        }
        image.mime_type.get_or_insert_with(|| gltf::json::image::MimeType("image/png".to_owned()));
    }
    Ok((gltf::Document::from_json(json).map_err(|error| one_line(&error))?, blob))
}

fn one_line(error: &gltf::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

fn camera(source: &gltf::Camera<'_>) -> ModelCamera {
    let view = match source.projection() {
        Projection::Perspective(view) => Some((f64::from(view.yfov()), view.aspect_ratio().map(f64::from))),
        Projection::Orthographic(_) => None,
    };
    ModelCamera { name: source.name().unwrap_or_default().to_owned(), world_from_camera: None, view }
}

/// A light of KHR_lights_punctual, which shines along -z.
fn light(source: &gltf::khr_lights_punctual::Light<'_>, map: &DAffine3, resources: &mut Resources) -> Option<Light> {
    // Radiance of a white surface is irradiance over pi
    let strength = Vec3::from_array(source.color()) * source.intensity() / (LUMENS_PER_WATT * std::f32::consts::PI);
    let along = map.transform_vector3(DVec3::NEG_Z);
    let made = match source.kind() {
        Kind::Directional => Light::sun(-along, strength).ok(),
        Kind::Point => Some(Light::Point { at: map.translation, strength, cone: None }),
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let [inner, outer] = [inner_cone_angle, outer_cone_angle].map(f64::from);
            let cone = crate::Cone::new(along, inner, outer).ok();
            cone.map(|cone| Light::Point { at: map.translation, strength, cone: Some(cone) })
        }
    };
    let is_valid = |light: &Light| light.strength().is_finite() && light.strength().min_element() >= 0.0;
    let made = made.filter(|light| is_valid(light) && map.translation.is_finite());
    if made.is_none() {
        resources.warnings.push(format!("light {} is left out: its numbers make none", source.index()));
    }
    made
}

/// Adds one primitive's triangles; points and lines have no surface and are left out.
fn add(
    mesh: &mut Mesh,
    primitive: &gltf::Primitive<'_>,
    buffers: &[Vec<u8>],
    world_from_node: DAffine3,
) -> Result<(), String> {
    let Some(positions) = primitive.get(&gltf::Semantic::Positions) else { return Ok(()) };
    gltf_access::check(&positions, PLACES, buffers)?;
    if let Some(indices) = primitive.indices() {
        gltf_access::check(&indices, INDICES, buffers)?;
    }
    let has = |semantic: gltf::Semantic, kind: gltf_access::Kind| match primitive.get(&semantic) {
        Some(accessor) => gltf_access::check(&accessor, kind, buffers).map(|()| true),
        None => Ok(false),
    };
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let first = u32::try_from(mesh.vertices.len()).map_err(|_| "too many vertices".to_owned())?;
    let places = reader.read_positions().into_iter().flatten();
    mesh.vertices.extend(places.map(|p| world_from_node.transform_point3(Vec3::from_array(p).as_dvec3())));
    let count = (mesh.vertices.len() - first as usize) as u32;
    if first.checked_add(count).is_none() {
        return Err("too many vertices".to_owned());
    }
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

    if mesh.triangles.len() + triangles.len() > MOST_TRIANGLES {
        return Err(format!("its nodes make more than {MOST_TRIANGLES} triangles"));
    }

    // What else it says of its vertices
    let normal_from_node = world_from_node.matrix3.inverse().transpose();
    let normals: Vec<Vec3> = if has(gltf::Semantic::Normals, PLACES)? {
        let normals = reader.read_normals().into_iter().flatten();
        normals.map(|n| (normal_from_node * Vec3::from_array(n).as_dvec3()).as_vec3()).collect()
    } else {
        Vec::new()
    };
    let mut uvs: [Vec<Vec2>; 2] = [Vec::new(), Vec::new()];
    for (set, uvs) in uvs.iter_mut().enumerate() {
        if has(gltf::Semantic::TexCoords(set as u32), COORDINATES)? {
            let read =
                reader.read_tex_coords(set as u32).into_iter().flat_map(gltf::mesh::util::ReadTexCoords::into_f32);
            uvs.extend(read.map(Vec2::from_array));
        }
    }
    let colors: Vec<Vec4> = if has(gltf::Semantic::Colors(0), COLORS)? {
        let colors = reader.read_colors(0).into_iter().flat_map(gltf::mesh::util::ReadColors::into_rgba_f32);
        colors.map(Vec4::from_array).collect()
    } else {
        Vec::new()
    };

    // A node that mirrors turns its triangles inside out
    let mirrored = world_from_node.matrix3.determinant() < 0.0;
    let material = match primitive.material().index() {
        Some(index) => index as u32,
        None => mesh.add_default_material(),
    };
    let triangles = triangles.into_iter().map(|[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] });
    mesh.add_triangles(triangles, first, material, &Attributes { normals, uvs, colors });
    Ok(())
}

#[cfg(test)]
mod tests {
    use base64::Engine;
    use glam::DVec3;

    use super::*;
    use crate::Pigment;

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
        let mesh = read(&path).unwrap().mesh;
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.vertices[1], DVec3::new(2.0, 0.0, -6.0));
        assert_eq!(mesh.materials[0].pigment, Pigment::Constant(Vec3::new(0.5, 0.25, 0.125)));
        assert_eq!(mesh.materials[0].emission, Vec3::new(0.0, 0.5, 1.0));
        // A mirroring node keeps the outside out
        std::fs::write(&path, document(r#", "scale": [-1, 1, 1]"#)).unwrap();
        assert_eq!(read(&path).unwrap().mesh.triangles, [[0, 2, 1]]);
        std::fs::write(&path, "{}").unwrap();
        assert!(read(&path).is_err());
    }
}
