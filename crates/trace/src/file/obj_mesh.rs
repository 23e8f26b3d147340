//! Wavefront OBJ with its material library.

use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::mesh::Mesh;
use super::model::Model;
use super::resources::Resources;
use super::scene_file::refuse_special;
use crate::{Alpha, Encoding, Finish, Material, Pigment, TextureMap};

/// Reads triangles (polygons are cut into fans) with normals, coordinates and colours, and of their materials Kd, Ke, d and
/// map_Kd.
pub(super) fn read(path: &Path) -> Result<Model, String> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    check_indices(&bytes)?;
    let library = |name: &Path| library(&path.parent().unwrap_or(Path::new("")).join(name));
    let loaded = tobj::load_obj_buf(&mut bytes.as_slice(), &options, library);
    let (models, materials) = loaded.map_err(|error| error.to_string())?;
    let materials = materials.map_err(|error| format!("its material library: {error}"))?;
    let mut resources = Resources::beside(path);
    let mut mesh = Mesh::default();
    for source in &materials {
        let (material, finish) = material(source, &mut resources);
        mesh.add_finished(material, finish);
    }
    let mut plain = None;
    for model in models {
        let source = model.mesh;
        let first = u32::try_from(mesh.vertices.len()).map_err(|_| "too many vertices".to_owned())?;
        let material = match source.material_id {
            Some(id) => id as u32,
            None => *plain.get_or_insert_with(|| mesh.add_default_material()),
        };
        mesh.vertices.extend(source.positions.as_chunks::<3>().0.iter().map(|&p| Vec3::from_array(p).as_dvec3()));
        mesh.add_corners(&source, first, material);
    }
    mesh.warnings = resources.warnings;
    Ok(Model { mesh, ..Model::default() })
}

/// Fails for faces that name what cannot be there: the crate counts with such numbers before it looks.
fn check_indices(bytes: &[u8]) -> Result<(), String> {
    /// Most vertices, coordinates or normals of a file.
    const MOST: i64 = 1 << 31;
    let mut counts = [0_i64; 3];
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii_start();
        let kind = match line {
            [b'v', b't', ..] => Some(1),
            [b'v', b'n', ..] => Some(2),
            [b'v', ..] => Some(0),
            _ => None,
        };
        if let Some(kind) = kind {
            counts[kind] += 1;
        }
        if !matches!(line, [b'f' | b'l' | b'p', b' ' | b'\t', ..]) {
            continue;
        }
        for corner in line[1..].split(u8::is_ascii_whitespace) {
            for (index, &count) in corner.split(|&byte| byte == b'/').zip(&counts) {
                let index = std::str::from_utf8(index).ok().and_then(|text| text.parse::<i64>().ok());
                if let Some(index) = index.filter(|&index| index < -count || index > MOST) {
                    return Err(format!("line {} names element {index}, which is not there", number + 1));
                }
            }
        }
    }
    Ok(())
}

/// Reads a material library. The crate takes it for granted that colours have three numbers: look first.
fn library(path: &Path) -> tobj::MTLLoadResult {
    let bytes = refuse_special(path).and_then(|()| std::fs::read(path)).map_err(|_| tobj::LoadError::OpenFileFailed)?;
    let is_color = |word: &str| matches!(word, "Ka" | "Kd" | "Ks" | "Ke");
    let is_short = |line: &str| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(is_color) && words.count() < 3
    };
    if String::from_utf8_lossy(&bytes).lines().any(is_short) {
        return Err(tobj::LoadError::MaterialParseError);
    }
    tobj::load_mtl_buf(&mut bytes.as_slice())
}

impl Mesh {
    /// Adds the triangles of a part, whose corners have indices of their own for each thing that is said of them.
    fn add_corners(&mut self, source: &tobj::Mesh, first: u32, material: u32) {
        let normals = source.normals.as_chunks::<3>().0;
        let uvs = source.texcoords.as_chunks::<2>().0;
        let colors = source.vertex_color.as_chunks::<3>().0;
        let at = |indices: &[u32], corner: usize| indices.get(corner).map(|&i| i as usize);
        let corners = 0..source.indices.len() / 3 * 3;
        let normal = |corner: usize| at(&source.normal_indices, corner).and_then(|i| normals.get(i).copied());
        let uv = |corner: usize| at(&source.texcoord_indices, corner).and_then(|i| uvs.get(i).copied());
        let color = |corner: usize| at(&source.indices, corner).and_then(|i| colors.get(i).copied());
        // v counts up from the bottom there
        let attributes = super::mesh::Attributes {
            normals: if normals.is_empty() {
                Vec::new()
            } else {
                corners.clone().map(|corner| normal(corner).map_or(Vec3::ZERO, Vec3::from_array)).collect()
            },
            uvs: [
                if uvs.is_empty() {
                    Vec::new()
                } else {
                    corners
                        .clone()
                        .map(|corner| uv(corner).map_or(Vec2::ZERO, |[u, v]| Vec2::new(u, 1.0 - v)))
                        .collect()
                },
                Vec::new(),
            ],
            colors: if colors.is_empty() {
                Vec::new()
            } else {
                corners
                    .clone()
                    .map(|corner| color(corner).map_or(Vec4::ONE, |c| Vec3::from_array(c).extend(1.0)))
                    .collect()
            },
        };
        // Number the corners for that, then name the vertices
        let before = self.triangles.len();
        let numbers = (0..corners.end as u32).step_by(3).map(|i| [i, i + 1, i + 2]);
        self.add_triangles(numbers, 0, material, &attributes);
        let triangles = self.triangles[before..].iter_mut();
        for (triangle, corners) in triangles.zip(source.indices.as_chunks::<3>().0) {
            *triangle = corners.map(|i| first.saturating_add(i));
        }
    }
}

fn material(source: &tobj::Material, resources: &mut Resources) -> (Material, Finish) {
    let material = Material {
        pigment: Pigment::Constant(source.diffuse.map_or(Vec3::splat(0.8), Vec3::from_array)),
        emission: source.emissive.map_or(Vec3::ZERO, Vec3::from_array),
    };
    let mut finish = Finish { name: source.name.clone(), ..Finish::default() };
    finish.is_light = material.emission != Vec3::ZERO;
    if let Some(opacity) = source.dissolve.filter(|opacity| (0.0..1.0).contains(opacity)) {
        (finish.alpha, finish.opacity) = (Alpha::Blend, opacity);
    }
    if let Some(name) = &source.diffuse_texture {
        // Options come before the file's name
        let file = name.rsplit(" -").next().filter(|_| name.starts_with('-')).and_then(|rest| rest.rsplit(' ').next());
        let file = file.unwrap_or(name).trim();
        let picture = resources.texture(file, Encoding::Color, |own| own.read_uri(file));
        finish.color_map = picture.map(TextureMap::new);
    }
    (material, finish)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pigment;

    #[test]
    fn a_square_with_a_colour_becomes_two_triangles() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.obj");
        std::fs::write(folder.path().join("m.mtl"), "newmtl red\nKd 0.8 0.1 0.2\nKe 1 2 3\n").unwrap();
        let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n";
        std::fs::write(&path, text).unwrap();
        let mesh = read(&path).unwrap().mesh;
        assert_eq!(mesh.triangles.len(), 2);
        assert_eq!(mesh.vertices.len(), 4);
        let material = mesh.materials[mesh.material_of[1] as usize];
        assert_eq!(material.pigment, Pigment::Constant(Vec3::new(0.8, 0.1, 0.2)));
        assert_eq!(material.emission, Vec3::new(1.0, 2.0, 3.0));
        // A named library that is missing is an error, not a grey model
        std::fs::remove_file(folder.path().join("m.mtl")).unwrap();
        assert!(read(&path).unwrap_err().contains("material library"));
        assert!(read(&folder.path().join("none.obj")).is_err());
    }
}
