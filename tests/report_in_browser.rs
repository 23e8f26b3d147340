//! The report page in a real browser: it opens, its slider moves, its pixels are read, and no script complains.
#![cfg(unix)]
#![allow(clippy::print_stdout, reason = "what is skipped is told")]

mod support {
    pub(crate) mod browser;
}

use std::path::Path;
use std::process::Command;

use support::browser::{Page, program};
use tempfile::TempDir;

/// Size of the pictures.
const SIZE: [u32; 2] = [64, 36];

/// A report of the demo, small.
fn report(folder: &Path) {
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let demo = ["demo", "--scene", "simple", "--spp", "8", "--rgbd-spp", "8", "--size", &size, "--out", "."];
    let output = Command::new(env!("CARGO_BIN_EXE_tiltshift")).args(demo).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_report_opens_moves_its_slider_and_reads_pixels_without_a_script_error() {
    let Some(program) = program() else {
        println!("skipped: no Chromium or Chrome on this machine (TILTSHIFT_BROWSER names one)");
        return;
    };
    let (folder, browser) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    report(folder.path());
    let mut page = Page::start(&program, browser.path());
    page.open(&folder.path().join("report.html"));
    assert_eq!(page.value("document.getElementById('viewer').hidden"), false, "the viewer is there");

    // Every picture has come with the page
    let loaded = "[...document.images].every((image) => image.complete && image.naturalWidth > 0)";
    assert_eq!(page.value(loaded), true);
    assert!(page.value("document.images.length").as_u64().unwrap() >= 6);

    // The slider follows the keys
    let cut = "getComputedStyle(document.getElementById('stage')).getPropertyValue('--cut')";
    page.value("document.getElementById('cut').focus()");
    for _ in 0..4 {
        page.press("ArrowLeft", 37);
    }
    assert_eq!(page.value("document.getElementById('cut').value"), "48");
    assert_eq!(page.value(cut), "48%", "the seam follows");

    // The pixel under the pointer is read out of every picture
    let place = page.value(
        "(() => { const stage = document.getElementById('stage'); stage.scrollIntoView(); \
         const box = stage.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })()",
    );
    let place: Vec<f64> = place.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let (x, y) = (40, 20);
    let at =
        |start: f64, length: f64, pixel: i32, count: u32| start + length * (f64::from(pixel) + 0.5) / f64::from(count);
    page.point(at(place[0], place[2], x, SIZE[0]), at(place[1], place[3], y, SIZE[1]));
    assert_eq!(page.value("document.getElementById('position').textContent"), format!("x {x}, y {y}"));
    let read = page.value("document.querySelector('[data-of=picture-reference]').textContent");
    let truth = image::open(folder.path().join("truth.png")).unwrap().to_rgb8();
    let [r, g, b] = truth.get_pixel(x as u32, y as u32).0;
    assert_eq!(read, format!("{r} {g} {b}"), "the reference's pixel is the picture's");
    let all = "[...document.querySelectorAll('[data-of]')].every((o) => /^\\d+ \\d+ \\d+$/.test(o.textContent))";
    assert_eq!(page.value(all), true);

    // Zooming takes all pictures along
    page.value("document.getElementById('closer').click()");
    assert!(page.value("view.zoom").as_f64().unwrap() > 1.0);

    // A phone's width is enough
    for width in [1280, 400] {
        page.resize(width, 900);
        let wide = page.value("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= u64::from(width), "the page is {wide} pixels wide in a window of {width}");
    }
    assert!(page.errors.is_empty(), "{:?}", page.errors);
}
