//! A small chart of a real shot: figures, files and drawing.

use std::path::Path;

use compare::{Comparison, Masks, Reference};
use optics::Camera;
use rgbd::{Cancelled, PixelWindow, Progress, Silent};
use study::{
    Chart, Clock, Conditions, Family, HybridSettings, Machine, Point, PointError, Rung, StudyError, Subject, Timing,
    measure,
};
use tempfile::TempDir;
use trace::{LayerSettings, SceneFile};

/// Truth, frame, rungs and what they made.
fn charted(folder: &Path) -> Chart {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/simple.toml");
    let file = SceneFile::open(path).unwrap();
    let shot = file.shot(Some("blur")).unwrap().camera;
    let camera = Camera { film: shot.film.resized(96, 54).unwrap(), ..shot };
    let display = PixelWindow::of_size(96, 54);
    let truth = trace::truth(file.scene(), &camera, display, 1024, 1, &Silent).unwrap();
    let settings = LayerSettings { seed: 2, ..LayerSettings::default() };
    let frame = trace::layers(file.scene(), &camera, &settings, &Silent).unwrap().frame;

    let mut rungs = Rung::of_filter(2);
    rungs.push(Rung::Hybrid(HybridSettings { tolerance: 0.01, samples: 64, ..HybridSettings::default() }));
    rungs.extend([2, 16, 64].map(|samples| Rung::Trace { samples }));
    let subject = Subject { scene: file.scene(), camera: &camera, frame: &frame, seed: 3, folder };
    let measured = measure(&subject, &rungs, 3, &Silent).unwrap();

    let reference = Reference::from_truth(&truth).unwrap();
    let masks = Masks::from_frame(&frame, &camera, None).unwrap();
    let error = |picture| PointError::from(&Comparison::new(&reference, picture, &masks).unwrap());
    let mut points: Vec<Point> = measured.iter().map(|m| Point::of_rung(m, error(&m.picture))).collect();
    // A program that makes the tracer's picture, and takes a year for it
    let slow = Timing::new(vec![3e7]).unwrap();
    points.push(Point::of_candidate("slow, \"but\" <good>".to_owned(), slow, error(&measured[9].picture)));
    let conditions = Conditions {
        subject: "simple, blur".to_owned(),
        size: [96, 54],
        largest_coc_radius_px: masks.largest_coc_radius_px(),
        truth_samples: 1024,
        truth_noise_rmse: truth.noise_rmse(display),
        rgbd_seconds: 1.0,
        runs: 3,
        machine: Machine::this(),
        command: "tiltshift chart".to_owned(),
    };
    Chart::new(conditions, points)
}

#[test]
fn a_chart_places_every_method_and_says_which_are_needless() {
    let folder = TempDir::new().unwrap();
    let chart = charted(folder.path());
    let point = |name: &str| chart.points().iter().find(|point| point.name == name).unwrap();

    // Errors fall along the ladder, and with samples as noise does
    let rmse = |name: &str| point(name).error.all.rmse;
    assert!(rmse("merged 2 layers") < 0.5 * rmse("pinhole"));
    assert!(rmse("hybrid 0.01 64") < rmse("merged 2 layers"));
    assert!(rmse("trace 16") < 0.5 * rmse("trace 2") && rmse("trace 64") < 0.6 * rmse("trace 16"));

    // The whole command takes longer than what it runs, and each run was timed
    for point in chart.points().iter().filter(|point| point.family != Family::Candidate) {
        assert_eq!(point.kernel.runs().len(), 3);
        let pairs = point.kernel.runs().iter().zip(point.command.runs());
        assert!(pairs.into_iter().all(|(kernel, command)| command > kernel), "{}", point.name);
    }

    // No blur is fastest and stands on the frontier; a year is too long for any picture
    assert_eq!(point("pinhole").dominated_by(Clock::Kernel), None);
    let slow = point("slow, \"but\" <good>");
    for clock in [Clock::Kernel, Clock::Command] {
        let better = point(slow.dominated_by(clock).unwrap());
        assert!(better.error.all.rmse <= slow.error.all.rmse && better.time(clock).median() < 3e7);
    }

    // Files of each step lie in the folder
    for name in ["rgbd_1.exr", "rgbd_2.exr", "trace_16.exr", "merged_2_layers.exr", "hybrid_0.01_64.exr"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }

    // All say the same
    let json = chart.to_json();
    assert_eq!((&json["format"], &json["points"][0]["family"]), (&1.into(), &"pinhole".into()));
    assert_eq!(json["points"].as_array().unwrap().len(), chart.points().len());
    let csv = chart.to_csv();
    assert_eq!(csv.lines().count(), 1 + chart.points().len());
    let last = csv.lines().last().unwrap();
    assert!(last.starts_with("\"slow, \"\"but\"\" <good>\",candidate,,,,30000000,"), "{last}");
    let columns = |line: &str| line.split(',').count();
    let mut lines = csv.lines();
    let heading = columns(lines.next().unwrap());
    assert!(lines.take(12).all(|line| columns(line) == heading), "{csv}");
    for clock in [Clock::Kernel, Clock::Command] {
        let svg = chart.to_svg(clock);
        assert!(svg.contains("slow, &quot;but&quot; &lt;good&gt;") && svg.len() < 200_000);
        assert_eq!(svg.matches("dominated by ").count(), {
            chart.points().iter().filter(|point| point.dominated_by(clock).is_some()).count()
        });
        assert!(svg.contains("prefers-color-scheme: dark") && !svg.contains("NaN"), "{svg}");
    }
}

/// Stops at once.
struct Stop;

impl Progress for Stop {
    fn report(&self, _done: u64, _total: u64) {}

    fn is_cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_measurement_can_be_stopped() {
    let folder = TempDir::new().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/simple.toml");
    let file = SceneFile::open(path).unwrap();
    let shot = file.shot(Some("tilt")).unwrap().camera;
    let camera = Camera { film: shot.film.resized(32, 18).unwrap(), ..shot };
    let frame = trace::layers(file.scene(), &camera, &LayerSettings::default(), &Silent).unwrap().frame;
    let subject = Subject { scene: file.scene(), camera: &camera, frame: &frame, seed: 3, folder: folder.path() };
    let stopped = measure(&subject, &[Rung::Trace { samples: 2 }], 1, &Stop);
    assert!(matches!(
        stopped,
        Err(StudyError::Render(trace::RenderError::Cancelled(Cancelled)) | StudyError::Cancelled(Cancelled))
    ));
}
