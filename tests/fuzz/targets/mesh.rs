//! Meshes of any bytes, in a scene and as a scene: the first byte chooses OBJ, glTF or binary glTF, the rest is the file. Good seeds are small meshes with
//! a byte before them.
#![no_main]

mod watch;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let ending = ["obj", "gltf", "glb"][usize::from(*kind) % 3];
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join(format!("mesh.{ending}"));
    std::fs::write(&path, bytes).expect("room for a small file");
    let scene = format!("format = 1\n[meshes.m]\nfile = \"mesh.{ending}\"\n[[objects]]\nmesh = \"m\"\n");
    let _ = trace::SceneFile::parse(&scene, folder.path().join("scene.toml"));
    if let Ok(file) = trace::SceneFile::open(&path) {
        for (name, shot) in file.shots() {
            let _ = (shot, file.shot_at(name, 0));
        }
    }
});
