//! The causes of the filter's error where the cause is known.

use std::path::Path;

use compare::Reference;
use optics::{Camera, Iris};
use rgbd::{Cancelled, PixelWindow, Progress, Silent};
use study::{Cause, Causes, CausesSettings, StudyError, Verdict, causes};
use trace::SceneFile;

const SIZE: [u32; 2] = [64, 36];

/// No pixel farther from the border sees beyond it: 6 px of blur, and 2 over which errors are averaged.
const REACH: i32 = 8;

/// Few samples and few finer pixels: what is asked for here is larger than what they leave.
fn study(
    shot: &str,
    change: impl Fn(CausesSettings) -> CausesSettings,
    progress: &dyn Progress,
) -> Result<[Causes; 2], StudyError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/simple.toml");
    let file = SceneFile::open(path).unwrap();
    let shot = file.shot(Some(shot)).unwrap().camera;
    // Four times the iris, so that few pixels are blurred as much as many are with the shot's own
    let iris = Iris::new(shot.iris.normal(), 4.0 * shot.iris.radius(), shot.iris.shape()).unwrap();
    let camera = Camera { film: shot.film.resized(SIZE[0], SIZE[1]).unwrap(), iris, ..shot };
    let window = PixelWindow::of_size(SIZE[0], SIZE[1]);
    let truth = trace::truth(file.scene(), &camera, window, 512, 1, &Silent).unwrap();
    let settings = CausesSettings { fine: 2, lens_samples: 16, color_samples: 64, ..CausesSettings::shipped(&camera) };
    causes(file.scene(), &camera, &Reference::from_truth(&truth).unwrap(), &change(settings), progress)
}

fn share(causes: &Causes, cause: Cause) -> [f64; 2] {
    causes.shares.causes.iter().find(|share| share.cause == cause).expect("a cause of the chain").range()
}

#[test]
fn a_missing_margin_is_found_to_be_the_cause_and_a_whole_one_is_none() {
    let [one, _] = study("blur", |settings| CausesSettings { margin: [0; 2], ..settings }, &Silent).unwrap();
    let [low, high] = share(&one, Cause::Border);
    // Measured 0.087 to 0.095; with everything there it is 0 to the bit, so that half of it tells them apart
    assert!(low > 0.04, "a missing margin has its share in either order: {low} to {high}");

    // It leads within the reach of the blur from the border, and nowhere else
    let shares = &one.shares;
    let [mut near, mut far] = [0; 2];
    for ((x, y), (_, verdict)) in shares.window().pixels().zip(&shares.map) {
        if *verdict == Verdict::Cause(Cause::Border) {
            let from_border = x.min(y).min(SIZE[0] as i32 - 1 - x).min(SIZE[1] as i32 - 1 - y);
            *(if from_border <= REACH { &mut near } else { &mut far }) += 1;
        }
    }
    assert!(near > 20 && far == 0, "{near} pixels near the border, {far} elsewhere");

    let [whole, two] = study("blur", |settings| settings, &Silent).unwrap();
    assert_eq!(share(&whole, Cause::Border), [0.0; 2], "nothing is missing, to the bit");
    assert!(whole.shares.mse < one.shares.mse && whole.shares.rest < 0.5, "{:?}", whole.shares.causes);

    // What the second layer knows is no longer a cause where it is given
    assert!(two.shares.causes.iter().all(|share| share.cause != Cause::SecondLayer));
    assert!(two.shares.mse < whole.shares.mse);
}

#[test]
fn bad_settings_and_cancellation_are_errors() {
    struct Stopped;
    impl Progress for Stopped {
        fn report(&self, _: u64, _: u64) {}
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    let error = study("blur", |settings| CausesSettings { fine: 1, ..settings }, &Silent).unwrap_err();
    assert_eq!(error.to_string(), "number of finer pixels in a pixel's side is 1; it must be 2 to 8");
    let error = study("blur", |settings| settings, &Stopped).unwrap_err();
    assert!(error.to_string().contains(&Cancelled.to_string()), "{error}");
}
