//! The report page and the maps in it.

mod shared;

use compare::{Comparison, Entry, GivenNoise, HeatKind, Masks, Parameter, Reference, Report, round_scale};
use rgbd::{Picture, PixelWindow, Plane, Truth};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 12, height: 8 };

fn flat(level: f32) -> Picture {
    Picture::filled(WINDOW, [level, level, level, 1.0])
}

fn entry(name: &str, reference: &Reference, candidate: &Picture, masks: &Masks) -> Entry {
    let comparison = Comparison::new(reference, candidate, masks).unwrap();
    Entry { name: name.into(), note: format!("{name}, as it came"), comparison }
}

/// A noisy truth, a candidate as good as its noise, one that is wrong, one with a hole, and a picture without blur.
fn with_report<T>(check: impl FnOnce(&Report<'_>) -> T) -> T {
    let half = |sign: f32| {
        Picture::from_fn(WINDOW, |x, y| [0.5 + sign * if (x + y) % 2 == 0 { 0.01 } else { -0.01 }, 0.5, 0.5, 1.0])
    };
    let truth = Truth { display: WINDOW, camera: None, halves: [half(1.0), half(-1.0)], samples: [8, 8] };
    let reference = Reference::from_truth(&truth).unwrap();
    let masks = Masks::without_depth(WINDOW);
    let mut hole = flat(0.5);
    hole.set(3, 3, [f32::NAN; 4]);
    let report = Report {
        title: "Miniature <3 & more".into(),
        about: String::new(),
        reference_name: "truth".into(),
        reference: &reference,
        masks: &masks,
        unfiltered: Some(entry("pinhole", &reference, &flat(0.9), &masks)),
        candidates: vec![
            entry("gather", &reference, &flat(0.5001), &masks),
            entry("naive", &reference, &flat(0.4), &masks),
            entry("holed", &reference, &hole, &masks),
        ],
        exposure_stops: 0.5,
        parameters: vec![Parameter::new("focal length in mm", 50), Parameter::new("</script>", "\"a\" < b")],
        commands: vec!["tiltshift compare truth.exr gather.exr --report out".into()],
    };
    check(&report)
}

#[test]
fn the_page_holds_everything_and_fetches_nothing() {
    let html = with_report(|report| report.to_html().unwrap());
    for outside in ["http://", "https://", "src=\"/", "@import", "url("] {
        assert!(!html.contains(outside), "{outside} would leave the page");
    }
    for wanted in [
        "<title>Miniature &lt;3 &amp; more</title>",
        "below noise",
        "unfiltered",
        "tiltshift compare truth.exr gather.exr --report out",
        "focal length in mm",
        "+0.50 stops",
        "holed: 1 pixels hold no finite number",
        "type=\"range\"",
        "100.0 % of the pixels",
        "noise of the reference",
    ] {
        assert!(html.contains(wanted), "the page lacks {wanted:?}");
    }
    // Reference, and picture with three maps for each of four entries
    assert_eq!(html.matches("data:image/png;base64,").count(), 1 + 4 * 4);
    assert_eq!(html.matches("<script").count(), 2, "a parameter must not open or close a script");
    assert_eq!(html.matches("</script>").count(), 2);
}

/// The opening tags of an element.
fn tags<'a>(html: &'a str, element: &str) -> Vec<&'a str> {
    let end_of_name = |rest: &str| rest.starts_with([' ', '>']);
    let parts = html.split(&format!("<{element}")).skip(1).filter(|rest| end_of_name(rest)).collect::<Vec<_>>();
    parts.into_iter().map(|rest| &rest[..rest.find('>').unwrap()]).collect()
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let value = tag.split_once(&format!(" {name}=\""))?.1;
    Some(&value[..value.find('"').unwrap()])
}

/// All values of an attribute in the markup, script and style aside.
fn values<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let markup = &html[html.find("<body>").unwrap()..html.find("<script").unwrap()];
    let parts = markup.split(&format!(" {name}=\"")).skip(1).collect::<Vec<_>>();
    parts.into_iter().map(|rest| &rest[..rest.find('"').unwrap()]).collect()
}

#[test]
fn every_picture_has_a_name_and_says_what_it_shows() {
    let html = with_report(|report| report.to_html().unwrap());
    let images = tags(&html, "img");
    // The pictures and maps, and the two that the slider borrows
    assert_eq!(images.len(), 1 + 4 * 4 + 2);
    for image in &images {
        assert!(attribute(image, "alt").is_some_and(|alt| !alt.trim().is_empty()), "no alt text: {image:.80}");
        assert!(attribute(image, "id").is_some(), "no name: {image:.80}");
    }
    let named: Vec<_> = images.iter().map(|image| attribute(image, "alt").unwrap()).collect();
    for wanted in
        ["Reference: truth", "gather", "naive", "pinhole", "Signed difference of gather", "HDR-FLIP of pinhole"]
    {
        assert_eq!(named.iter().filter(|alt| **alt == wanted).count(), 1, "{wanted}");
    }
    // Without a script they stand there as they are
    assert_eq!(images.iter().filter(|image| image.contains("src=\"data:")).count(), 1 + 4 * 4);
}

#[test]
fn every_control_is_there_and_has_a_label() {
    let html = with_report(|report| report.to_html().unwrap());
    let expected = [("input", 1), ("select", 2), ("button", 3)];
    for (element, count) in expected {
        let controls = tags(&html, element);
        assert_eq!(controls.len(), count, "{element}");
        for control in controls {
            let before = &html[..control.as_ptr() as usize - html.as_ptr() as usize];
            let in_label = before.rfind("<label").is_some_and(|start| !before[start..].contains("</label>"));
            assert!(in_label || attribute(control, "aria-label").is_some(), "no label: {control}");
        }
    }
    let [slider] = tags(&html, "input")[..] else { panic!("one slider") };
    assert_eq!(attribute(slider, "type"), Some("range"));
    assert!(attribute(slider, "aria-label").is_some_and(|label| label.contains("left picture")));
    // Any two pictures can be put beside each other, and any can be read out
    for picture in ["picture-reference", "picture-0", "picture-1", "picture-2", "picture-3"] {
        assert_eq!(values(&html, "value").iter().filter(|value| **value == picture).count(), 2, "{picture}");
        assert_eq!(values(&html, "data-of").iter().filter(|of| **of == picture).count(), 2, "{picture}");
    }
}

#[test]
fn whatever_the_page_refers_to_is_in_it() {
    let html = with_report(|report| report.to_html().unwrap());
    let mut ids = values(&html, "id");
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "two elements of one name");
    ids.push("report-data");

    let by_script = html.split("byId(\"").skip(1).map(|rest| &rest[..rest.find('"').unwrap()]);
    let by_choice = values(&html, "value").into_iter().filter(|value| value.starts_with("picture"));
    let by_label =
        [values(&html, "aria-labelledby"), values(&html, "aria-describedby"), values(&html, "data-of")].concat();
    for id in by_script.chain(by_choice).chain(by_label) {
        assert!(ids.contains(&id), "nothing is called {id}");
    }
}

#[test]
fn the_embedded_figures_are_those_of_the_json() {
    with_report(|report| {
        let (html, json) = (report.to_html().unwrap(), report.to_json());
        let start = html.find("type=\"application/json\">").unwrap() + "type=\"application/json\">".len();
        let embedded = &html[start..start + html[start..].find("</script>").unwrap()];
        assert_eq!(serde_json::from_str::<serde_json::Value>(embedded).unwrap(), json);

        let gather = &json["candidates"][0]["figures"][0];
        assert_eq!(gather["below_noise"], true);
        assert!(gather["corrected_psnr_db"].is_null() && gather["psnr_db"].is_number());
        let naive = &json["candidates"][1]["figures"][0];
        assert!((naive["corrected_psnr_db"].as_f64().unwrap() - 20.0).abs() < 0.1, "{naive}");
        assert_eq!(json["candidates"][2]["non_finite_pixels"], 1);
        assert_eq!(json["unfiltered"]["name"], "pinhole");
        // Red alone differs by 0.02 between the halves: a quarter of its square, a third of the channels
        let noise = json["reference"]["noise_mse"]["all"].as_f64().unwrap();
        assert!((noise - 1e-4 / 3.0).abs() < 1e-9, "{noise}");
        assert_eq!(json["parameters"][1]["value"], "\"a\" < b");
    });
}

#[test]
fn the_maps_show_sign_and_size() {
    let reference = Reference::from_picture(&flat(0.5), WINDOW, GivenNoise::default()).unwrap();
    let candidate = Picture::from_fn(WINDOW, |x, _| [if x < 6 { 0.2 } else { 0.8 }, 0.5, 0.5, 1.0]);
    let comparison = Comparison::new(&reference, &candidate, &Masks::without_depth(WINDOW)).unwrap();
    let signed = HeatKind::Signed.values(&reference, &comparison);
    assert!((signed.at(0, 0) + 0.1).abs() < 1e-6 && (signed.at(11, 0) - 0.1).abs() < 1e-6);
    let absolute = HeatKind::Absolute.values(&reference, &comparison);
    assert!(absolute.values().iter().all(|d| (d - 0.1).abs() < 1e-6));

    let map = HeatKind::Signed.draw(&signed, 0.1);
    let (dark, bright) = (map.at(0, 0), map.at(11, 0));
    assert!(dark[2] > dark[0] && bright[0] > bright[2], "blue is too dark, red too bright");
    let none = HeatKind::Absolute.draw(&Plane::filled(WINDOW, 0.0), 0.1).at(0, 0);
    let much = HeatKind::Absolute.draw(&absolute, 0.1).at(0, 0);
    assert!(none[1] < 0.01 && much[1] > 0.8, "dark is right, light is wrong");
}

#[test]
fn scales_are_round_and_ignore_outliers() {
    let plane = |largest: f32| {
        let window = PixelWindow::of_size(1000, 1);
        Plane::from_fn(window, |x, _| if x == 500 { 1e6 } else { largest * x as f32 / 999.0 })
    };
    for (largest, scale) in [(0.9, 1.0), (0.11, 0.2), (0.04, 0.05), (0.000_01, 0.001), (7.0, 10.0)] {
        assert_eq!(round_scale(&[&plane(largest)]), scale, "for {largest}");
    }
    assert_eq!(round_scale(&[]), 0.001);
}

/// Also leaves the page where `TILTSHIFT_REPORT_OUT` says, to look at.
#[test]
fn a_report_of_real_pictures() {
    let load = |name: &str| shared::load(&format!("reference/blender/{name}.exr"));
    let Some((lens, _)) = load("simple_dof40px_reference_192spp") else { return };
    let (pinhole, depth) = load("simple_pinhole_1280x720_64spp_RGBZ").expect("the scene without a lens");
    let (frame, camera) = shared::blender_frame(pinhole.clone(), depth.expect("a depth channel"), 10.0, 0.61);
    let masks = Masks::from_frame(&frame, &camera, None).unwrap();
    let noise = GivenNoise { all: Some(9.068e-6), edges: Some(9.667e-6), interior: None };
    let reference = Reference::from_picture(&lens, lens.window(), noise).unwrap();

    // A candidate that is a tenth as wrong as no filter at all
    let nearly = Picture::from_fn(lens.window(), |x, y| {
        let (lens, pinhole) = (lens.at(x, y), pinhole.at(x, y));
        [0, 1, 2, 3].map(|c| lens[c] + 0.1 * (pinhole[c] - lens[c]))
    });
    let report = Report {
        title: "Simple scene, 40 px of blur".into(),
        about: "How much is gained by nine tenths of the blur?".into(),
        reference_name: "192 samples".into(),
        reference: &reference,
        masks: &masks,
        unfiltered: Some(entry("pinhole", &reference, &pinhole, &masks)),
        candidates: vec![
            entry("nine tenths", &reference, &nearly, &masks),
            entry("the reference itself", &reference, &lens, &masks),
        ],
        exposure_stops: 0.0,
        parameters: vec![Parameter::new("aperture diameter, scene units", 0.61), Parameter::new("depth of focus", 10)],
        commands: vec!["tiltshift compare lens.exr nearly.exr lens.exr --unfiltered pinhole.exr --report out".into()],
    };

    // The difference is a tenth, noise and all: 20 dB everywhere
    for kind in masks.kinds() {
        let psnr = |entry: &Entry| entry.comparison.within(kind).unwrap().psnr_db();
        let gain = psnr(&report.candidates[0]) - psnr(report.unfiltered.as_ref().unwrap());
        assert!((gain - 20.0).abs() < 1e-3, "{kind:?}: {gain} dB");
    }
    let json = report.to_json();
    let verdicts = [0, 1, 2].map(|i| json["candidates"][1]["figures"][i]["below_noise"] == true);
    assert_eq!(verdicts, [true; 3]);
    let html = report.to_html().unwrap();
    assert!(html.contains("edges") && html.contains("10.3 %"));
    if let Some(path) = std::env::var_os("TILTSHIFT_REPORT_OUT") {
        std::fs::write(path, html).unwrap();
    }
}
