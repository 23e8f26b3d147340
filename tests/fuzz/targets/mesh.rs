//! Meshes of any bytes: the first byte chooses OBJ, glTF or binary glTF, the rest is the file. Good seeds are small meshes with
//! a byte before them.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let ending = ["obj", "gltf", "glb"][usize::from(*kind) % 3];
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    std::fs::write(folder.path().join(format!("mesh.{ending}")), bytes).expect("room for a small file");
    let scene = format!("format = 1\n[meshes.m]\nfile = \"mesh.{ending}\"\n[[objects]]\nmesh = \"m\"\n");
    let _ = trace::SceneFile::parse(&scene, folder.path().join("scene.toml"));
});
