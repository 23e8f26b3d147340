//! Renders that are stopped go on to the same bits, from memory and from files.

mod lit_spheres;

use std::sync::atomic::{AtomicU64, Ordering};

use lit_spheres::{WINDOW, camera, scene};
use rgbd::{Compression, LensAttributes, Notes, Progress, Silent};
use trace::{Goal, Job, Part, PartError, RenderError};

const GOALS: [Goal; 2] = [Goal::Samples(0..150), Goal::Noise { rmse: 0.05, most: 4096 }];

fn finished(goal: &Goal) -> Job {
    let mut job = Job::new(camera(), WINDOW, 5);
    job.run(&scene(), goal, &Silent).unwrap();
    job
}

/// Stops the work after so many chunks of pixels.
struct After(AtomicU64);

impl Progress for After {
    fn report(&self, done: u64, total: u64) {
        assert!(done <= total, "{done} of {total}");
    }

    fn is_cancelled(&self) -> bool {
        self.0.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| left.checked_sub(1)).is_err()
    }
}

/// Runs a job a bit; whether it is done.
fn run(job: &mut Job, goal: &Goal, chunks: u64) -> bool {
    match job.run(&scene(), goal, &After(AtomicU64::new(chunks))) {
        Ok(()) => true,
        Err(RenderError::Cancelled(_)) => false,
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_stopped_render_goes_on_to_the_same_bits() {
    for goal in GOALS {
        let whole = finished(&goal);
        for chunks in [1, 5, 17] {
            let mut job = Job::new(camera(), WINDOW, 5);
            let mut stops = 0;
            while !run(&mut job, &goal, chunks) {
                stops += 1;
            }
            assert!(stops >= 2, "{stops}");
            assert!(job.sums() == whole.sums(), "{goal:?}, {chunks} chunks at a time");
        }
    }
}

#[test]
fn a_file_gives_back_every_bit_of_a_stopped_render() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.exr");
    for goal in GOALS {
        // 12 chunks are the picture once: stop in the first round, between rounds and in a later one
        for chunks in [0, 5, 12, 19] {
            let mut job = Job::new(camera(), WINDOW, 5);
            assert!(!run(&mut job, &goal, chunks));
            let part = Part { job, scene: 77, lens: LensAttributes { f_number: Some(2.8), ..Default::default() } };
            part.write(&path, Compression::Rle, &Notes::new()).unwrap();
            let mut read = Part::read(&path, 1 << 20).unwrap();
            assert!(read.job == part.job, "{goal:?}, {chunks} chunks");
            assert_eq!((read.scene, read.lens.f_number), (77, Some(2.8)));
            assert!(run(&mut read.job, &goal, u64::MAX));
            assert!(read.job.sums() == finished(&goal).sums(), "{goal:?}, {chunks} chunks");
        }
    }
}

#[test]
fn a_part_is_a_picture_for_everybody_and_other_pictures_are_no_parts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.exr");
    let job = finished(&GOALS[0]);
    let picture = job.sums().picture();
    let part = Part { job, scene: 1, lens: LensAttributes::default() };
    part.write(&path, Compression::Zips, &Notes::new()).unwrap();
    assert_eq!(rgbd::read_picture(&path, &rgbd::ReadOptions::default()).unwrap().value, picture);
    assert!(matches!(Part::read(&path, 100), Err(PartError::Read(rgbd::ReadError::TooLarge { .. }))));

    rgbd::write_picture(&path, &picture, &rgbd::Head::new(WINDOW), &rgbd::WriteOptions::default()).unwrap();
    assert!(matches!(Part::read(&path, 1 << 20), Err(PartError::Invalid { .. })));
}

#[test]
fn goals_do_not_mix() {
    let scene = scene();
    let noise = Goal::Noise { rmse: 0.05, most: 4096 };
    assert_eq!(finished(&Goal::Samples(0..20)).run(&scene, &noise, &Silent), Err(RenderError::AnotherGoal));
    assert_eq!(finished(&noise).run(&scene, &Goal::Samples(0..5000), &Silent), Err(RenderError::AnotherGoal));
    let mut job = Job::new(camera(), WINDOW, 5);
    let none = Goal::Noise { rmse: 0.05, most: 0 };
    assert!(matches!(job.run(&scene, &none, &Silent), Err(RenderError::SampleRange { .. })));
}
