//! Wavefront OBJ with its material library.

use std::path::Path;

use glam::Vec3;

use super::mesh::Mesh;
use crate::{Material, Pigment};

/// Reads triangles, and Kd and Ke of their materials; polygons are cut into fans. Textures are not read: their
/// surfaces take the plain colour.
pub(super) fn read(path: &Path) -> Result<Mesh, String> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let (models, materials) = tobj::load_obj(path, &options).map_err(|error| error.to_string())?;
    let materials = materials.map_err(|error| format!("its material library: {error}"))?;
    let mut mesh = Mesh { materials: materials.iter().map(material).collect(), ..Mesh::default() };
    let mut plain = None;
    for model in models {
        let first = u32::try_from(mesh.vertices.len()).map_err(|_| "too many vertices".to_owned())?;
        let material = match model.mesh.material_id {
            Some(id) => id as u32,
            None => *plain.get_or_insert_with(|| mesh.add_default_material()),
        };
        mesh.vertices.extend(model.mesh.positions.as_chunks::<3>().0.iter().map(|&p| Vec3::from_array(p).as_dvec3()));
        for &corners in model.mesh.indices.as_chunks::<3>().0 {
            mesh.triangles.push(corners.map(|i| first.saturating_add(i)));
            mesh.material_of.push(material);
        }
    }
    Ok(mesh)
}

fn material(source: &tobj::Material) -> Material {
    Material {
        pigment: Pigment::Constant(source.diffuse.map_or(Vec3::splat(0.8), Vec3::from_array)),
        emission: source.emissive.map_or(Vec3::ZERO, Vec3::from_array),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_a_colour_becomes_two_triangles() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.obj");
        std::fs::write(folder.path().join("m.mtl"), "newmtl red\nKd 0.8 0.1 0.2\nKe 1 2 3\n").unwrap();
        let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n";
        std::fs::write(&path, text).unwrap();
        let mesh = read(&path).unwrap();
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
