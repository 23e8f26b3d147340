//! Files appear whole or not at all.

use std::fs;
use std::path::Path;

use rgbd::{
    Frame, Head, Layer, Picture, PixelWindow, Plane, ReadOptions, WriteError, WriteOptions, read_picture, write_frame,
    write_picture, write_png,
};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 9, height: 7 };

fn write(path: &Path, level: f32) -> Result<(), WriteError> {
    write_picture(path, &Picture::filled(WINDOW, [level; 4]), &Head::new(WINDOW), &WriteOptions::default())
}

fn level(path: &Path) -> f32 {
    read_picture(path, &ReadOptions::default()).unwrap().value.at(3, 3)[0]
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_new_file_takes_the_old_ones_place_and_leaves_nothing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, 0.25).unwrap();
    write(&path, 0.5).unwrap();
    assert_eq!(level(&path), 0.5);
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[test]
fn a_refused_frame_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, 0.25).unwrap();
    let layer = Layer::from_raw_depth(Picture::filled(WINDOW, [0.0; 4]), Plane::filled(WINDOW, 1.0));
    let mut frame = Frame::new(WINDOW, vec![layer]).unwrap();
    frame.planes.insert("A".into(), Plane::filled(WINDOW, 0.0));
    assert!(write_frame(&path, &frame, &WriteOptions::default()).is_err());
    assert_eq!(level(&path), 0.25);
}

/// The name of the unfinished file is taken by a folder, so that it cannot be made.
#[test]
fn a_failure_while_writing_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, 0.25).unwrap();
    let unfinished = folder.path().join(format!(".a.exr.tmp-{}", std::process::id()));
    fs::create_dir(&unfinished).unwrap();
    let error = write(&path, 0.5).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
    assert_eq!(level(&path), 0.25);
}

#[test]
fn a_folder_is_not_replaced_and_nothing_is_left_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    fs::create_dir(&path).unwrap();
    assert!(write(&path, 0.5).is_err());
    assert!(write_png(&path, &Picture::filled(WINDOW, [0.0; 4]), 0.0).is_err());
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[test]
fn a_missing_folder_is_an_error_that_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let error = write(&folder.path().join("missing/a.exr"), 0.5).unwrap_err().to_string();
    assert!(error.contains("missing/a.exr"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (path, link) = (folder.path().join("a.exr"), folder.path().join("link.exr"));
    write(&path, 0.25).unwrap();
    std::os::unix::fs::symlink(&path, &link).unwrap();
    write(&link, 0.5).unwrap();
    assert!(link.symlink_metadata().unwrap().is_symlink());
    assert_eq!(level(&path), 0.5);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_to_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe)
    });
    let picture = Picture::filled(WINDOW, [0.5; 4]);
    write_png(&pipe, &picture, 0.0).unwrap();
    // Before waiting for the reader, who would wait for ever at a replaced pipe
    assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    assert_eq!(reader.join().unwrap().unwrap(), rgbd::encode_png(&picture, 0.0).unwrap());
}
