//! Scene files of any text: understood or refused. Good seeds are `data/scenes/*.toml` and the example of
//! `data/scenes/FORMAT.md`.
#![no_main]

mod watch;

libfuzzer_sys::fuzz_target!(init: watch::let_caught_panics_pass(), |text: &str| {
    // A folder without meshes
    if let Ok(file) = trace::SceneFile::parse(text, "/nonexistent/scene.toml") {
        for (name, shot) in file.shots() {
            let _ = (shot, file.shot_at(name, 7));
        }
    }
});
