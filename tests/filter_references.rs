//! The filter against pictures and on files that nobody here made: reference pictures of another renderer, Blender's
//! Cycles, and RGB-D files from elsewhere. They lie in the folder that `TILTSHIFT_SHARED` names.

mod support {
    pub(crate) mod cases;
    #[allow(dead_code, reason = "other tests use the rest")]
    pub(crate) mod score;
    pub(crate) mod shared;
    pub(crate) mod table;
}

use compare::MaskKind;
use filter::{FrameView, GatherSettings, Method};
use optics::Camera;
use rgbd::{Frame, Picture, Silent};

use support::cases::Case;
use support::score::Score;
use support::shared;
use support::table::Table;

/// A row of DESIGN's table: what a brute-force prototype reached (PSNR all / edges / interior).
struct Row {
    case: &'static str,
    largest_radius_px: f64,
    unfiltered: Score,
    one_layer: Score,
    two_layers: Score,
}

const fn row(case: &'static str, largest_radius_px: f64, figures: [[f64; 3]; 3]) -> Row {
    let [unfiltered, one_layer, two_layers] = figures;
    let [unfiltered, one_layer, two_layers] = [Score(unfiltered), Score(one_layer), Score(two_layers)];
    Row { case, largest_radius_px, unfiltered, one_layer, two_layers }
}

#[rustfmt::skip]
const PROTOTYPE: [Row; 6] = [
    row("simple_untilted", 6.6, [[21.2, 22.8, 21.1], [42.9, 32.0, 50.9], [45.6, 35.5, 50.8]]),
    row("simple_tilt", 7.2, [[36.0, 26.1, 40.8], [39.6, 29.0, 46.2], [45.0, 38.6, 46.2]]),
    row("simple_tilt_2R", 14.4, [[30.1, 24.8, 32.3], [36.5, 28.9, 43.3], [41.9, 37.6, 43.3]]),
    row("simple_combined", 5.7, [[22.9, 24.3, 22.8], [41.3, 31.8, 45.3], [43.0, 34.9, 45.3]]),
    row("landscape_untilted", 15.8, [[28.2, 28.6, 27.9], [45.2, 42.3, 56.6], [49.2, 46.5, 56.8]]),
    row("landscape_reverse", 24.2, [[25.7, 25.8, 25.3], [46.7, 45.2, 57.9], [49.4, 48.0, 58.1]]),
];

/// How far below the prototype the filter may stay where there is nothing to gain: another order of sums moves the interior
/// by as much.
const SLACK_DB: f64 = 0.5;

/// How far above the prototype it must be near edges, of one layer and of two: silhouettes taken apart, the background
/// filled in, and the hidden part of the lens. Measured: 2.3 to 8.8 and 2.0 to 7.7 dB.
const GAIN_AT_EDGES_DB: [f64; 2] = [2.0, 1.7];

/// The table has one digit after the point, and masks may part by a few pixels whose jump is just 3 px.
const SAME_DB: f64 = 0.1;

fn filtered(frame: &Frame, camera: &Camera, method: Method) -> Picture {
    let view = FrameView::whole(frame);
    filter::apply(&view, camera, &method, frame.display, &Silent).expect("a frame of the camera's size").picture
}

/// The default method, of one layer or all.
fn merged(layers: usize) -> Method {
    Method::Merged(GatherSettings { layers, ..GatherSettings::default() })
}

#[test]
fn the_filter_reaches_the_prototype_on_every_reference() {
    let Some(folder) = shared::folder() else { return };
    let mut table = Table::new("Filter against the reference pictures, PSNR in dB");
    let mut failures = Vec::new();
    for row in PROTOTYPE {
        let case = Case::read(&folder.join("reference"), row.case);
        let score = |method| Score::new(&case.reference, &filtered(&case.frame, &case.camera, method), &case.masks);

        // Check camera and masks by what does not depend on any filter
        let radius = case.masks.largest_coc_radius_px().expect("a depth");
        if (radius - row.largest_radius_px).abs() > SAME_DB {
            failures.push(format!("{}: largest radius {radius:.2} px, not {}", row.case, row.largest_radius_px));
        }
        let unfiltered = score(Method::Pinhole);
        table.note(&format!("edges: {:.1} % of the pixels", 100.0 * case.masks.share(MaskKind::Edges)));
        table.row(row.case, "unfiltered", unfiltered, Some(row.unfiltered));
        for (found, wanted) in unfiltered.0.into_iter().zip(row.unfiltered.0) {
            if (found - wanted).abs() > SAME_DB {
                failures.push(format!("{}, unfiltered: {found:.2} dB instead of {wanted} dB", row.case));
            }
        }

        // Hold the filter to the table
        for (how, layers, prototype) in [("one layer", 1, row.one_layer), ("two layers", 2, row.two_layers)] {
            let found = score(merged(layers));
            let [all, edges, interior] = prototype.0;
            let floor = Score([all, edges + GAIN_AT_EDGES_DB[layers - 1], interior - SLACK_DB]);
            table.row(row.case, how, found, Some(floor));
            failures.extend(found.shortfalls(&format!("{}, {how}", row.case), floor));
        }
    }
    table.print();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Floors over the whole picture and near edges, half a decibel below what was measured. On the same data the best of
/// other programs reaches 42.7 and 34.8 dB on `simple`, 33.4 and 29.7 dB on `occluder`.
const CYCLES_FLOORS: [(&str, [f64; 2]); 2] = [("simple", [45.0, 39.7]), ("occluder", [36.6, 32.9])];

#[test]
fn the_filter_comes_near_pictures_that_cycles_took() {
    let Some(folder) = shared::folder() else { return };
    let mut table = Table::new("Filter against Cycles, one layer, PSNR in dB without the reference's noise");
    let mut failures = Vec::new();
    for (scene, [all, edges]) in CYCLES_FLOORS {
        let Case { frame, camera, masks, reference } = Case::of_cycles(&folder.join("reference/blender"), scene);
        let score = |method| Score::new(&reference, &filtered(&frame, &camera, method), &masks);
        let (unfiltered, found) = (score(Method::Pinhole), score(merged(1)));
        let floor = Score([all, edges, f64::NEG_INFINITY]);
        table.row(scene, "unfiltered", unfiltered, None);
        table.row(scene, "one layer", found, Some(floor));
        failures.extend(found.shortfalls(scene, floor));
    }
    table.print();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
