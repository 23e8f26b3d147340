//! Clipped highlights raised before the blur.

use filter::{FilterError, Highlights, Method};
use rgbd::{Frame, Picture};

use crate::scenes::{DISPLAY, filtered, layer, noise, untilted};

fn highlights(gain: f32) -> Highlights {
    Highlights::new(gain, Highlights::DEFAULT_THRESHOLD).unwrap()
}

#[test]
fn what_is_below_the_threshold_and_all_alpha_stay_bit_for_bit() {
    for i in 0..1000 {
        let n = |salt| noise(i, 0, salt);
        let alpha = n(1);
        let dim = [n(2), n(3), n(4)].map(|c| 0.9 * c * alpha);
        let rgba = [dim[0], dim[1], dim[2], alpha];
        assert_eq!(highlights(50.0).recovered(rgba).map(f32::to_bits), rgba.map(f32::to_bits));
        let bright = [3.0 * n(2), 3.0 * n(3), 3.0 * n(4), alpha];
        assert_eq!(highlights(50.0).recovered(bright)[3], alpha);
    }
    // A gain of 1 gives nothing
    assert_eq!(highlights(1.0).recovered([1.0, 0.5, 0.2, 1.0]), [1.0, 0.5, 0.2, 1.0]);
}

#[test]
fn brighter_stays_brighter_and_no_step_shows() {
    let recover = highlights(30.0);
    let values: Vec<f32> = (0..4000).map(|i| recover.recovered([i as f32 / 2000.0, 0.0, 0.0, 1.0])[0]).collect();
    // The steepest place of the tone scale rises by 1.5 (gain - 1) over 0.1
    let steepest = 1.0 + 1.5 * 29.0 / 0.1;
    for pair in values.windows(2) {
        assert!(pair[0] < pair[1] && pair[1] - pair[0] < 1.001 * steepest / 2000.0, "{pair:?}");
    }
}

#[test]
fn white_becomes_the_gain_in_any_hue_and_under_any_alpha() {
    for alpha in [1.0, 0.5, 0.01] {
        let [r, g, b, _] = highlights(8.0).recovered([0.25 * alpha, alpha, 0.5 * alpha, alpha]);
        for (got, wanted) in [(r, 2.0), (g, 8.0), (b, 4.0)] {
            assert!((got / (wanted * alpha) - 1.0).abs() < 1e-6, "{got} {wanted} {alpha}");
        }
    }
}

#[test]
fn whatever_a_file_holds_comes_out_no_worse() {
    let wild = [f32::NAN, f32::INFINITY, -f32::INFINITY, -1.0, 0.0, 1e-45, 1.0, 65504.0, f32::MAX];
    for (r, g) in wild.iter().flat_map(|&r| wild.iter().map(move |&g| (r, g))) {
        for alpha in wild {
            let rgba = [r, g, 0.5, alpha];
            for (got, was) in highlights(65504.0).recovered(rgba).into_iter().zip(rgba) {
                assert!(got.is_finite() || !was.is_finite(), "{rgba:?}: {was} became {got}");
            }
        }
    }
}

#[test]
fn a_lamp_out_of_focus_shines_as_much_as_it_was_raised() {
    // A lamp of one pixel on black, all at one depth: the blur keeps its light, and nothing clips it again
    let lamp = layer(DISPLAY, |x, y| f32::from((x, y) == (32, 24)), |_, _| 2.0);
    let frame = Frame::new(DISPLAY, vec![lamp]).unwrap();
    let camera = untilted(4.0, 0.2);
    let light = |picture: &Picture| picture.planes()[0].values().iter().sum::<f32>();
    let clipped = light(&filtered(&frame, &camera, &Method::default()));
    let recovered = filtered(&highlights(400.0).recover(frame), &camera, &Method::default());
    assert!((light(&recovered) / clipped - 400.0).abs() < 0.01, "{} {clipped}", light(&recovered));
    // Its disc of 5 px radius is brighter than white, which 1/80 of clipped light never is
    assert!(recovered.at(34, 25)[0] > 1.0);
}

#[test]
fn only_highlights_gain_light_and_hidden_layers_are_raised_too() {
    let color = |x, y| 1.2 * noise(x, y, 7);
    let frame =
        Frame::new(DISPLAY, vec![layer(DISPLAY, color, |_, _| 2.0), layer(DISPLAY, color, |_, _| 4.0)]).unwrap();
    let raised = highlights(5.0).recover(frame.clone());
    assert_eq!(raised.layers()[0].depth, frame.layers()[0].depth);
    for (layer, was) in raised.layers().iter().zip(frame.layers()) {
        for (x, y) in DISPLAY.pixels() {
            let (now, was) = (layer.color.at(x, y)[0], was.color.at(x, y)[0]);
            assert!(if was > 0.9 { now > was } else { now == was }, "{was} became {now}");
        }
    }
}

#[test]
fn settings_outside_their_range_are_named() {
    for (gain, threshold, name) in [
        (0.5, 0.9, "gain"),
        (f32::NAN, 0.9, "gain"),
        (f32::INFINITY, 0.9, "gain"),
        (2.0, 1.0, "threshold"),
        (2.0, -0.1, "threshold"),
        (2.0, f32::NAN, "threshold"),
    ] {
        let error = Highlights::new(gain, threshold).unwrap_err();
        assert!(matches!(error, FilterError::BadSetting { what, .. } if what.contains(name)), "{error}");
    }
}
