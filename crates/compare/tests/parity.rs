//! FLIP and SSIM are those of the programs that define them, on ten pairs of pictures that differ in ten ways.
//!
//! `data/parity.json` holds what they computed, with their versions: means, and every map at every 97th pixel (a number
//! prime to the width). `benches/peers/perceptual.py` makes it from the pictures that the ignored test here writes, and
//! holds the whole maps to each other.

mod pairs;

use std::path::PathBuf;

use compare::{Comparison, GivenNoise, Masks, Reference};
use rgbd::{Head, Picture, WriteOptions, write_picture};
use serde_json::Value;

use pairs::{Pair, pairs};

/// What was asked of FLIP; SSIM is in f64 on both sides.
const MEAN: f64 = 1e-4;
const MAP: f64 = 2e-3;

/// Pixels from one that is looked at to the next.
const STRIDE: usize = 97;

fn compared(pair: &Pair) -> Comparison {
    let window = pair.reference.window();
    let reference = Reference::from_picture(&pair.reference, window, GivenNoise::default()).unwrap();
    Comparison::new(&reference, &pair.candidate, &Masks::without_depth(window)).unwrap()
}

#[test]
fn flip_and_ssim_are_those_of_the_reference_implementations_on_ten_pairs() {
    let expected: Value = serde_json::from_str(include_str!("data/parity.json")).unwrap();
    let pairs = pairs();
    assert_eq!(expected["pairs"].as_array().unwrap().len(), pairs.len());
    for pair in &pairs {
        let comparison = compared(pair);
        let all = comparison.all();
        for (figure, mean, map) in [
            ("ssim", all.ssim, &comparison.ssim),
            ("flip_ldr", all.flip_ldr, &comparison.flip_ldr),
            ("flip_hdr", all.flip_hdr, &comparison.flip_hdr),
        ] {
            let named = |wanted: &&Value| wanted["name"] == pair.name;
            let wanted = &expected["pairs"].as_array().unwrap().iter().find(named).unwrap()[figure];
            let wanted_mean = wanted["mean"].as_f64().unwrap();
            assert!((mean - wanted_mean).abs() < MEAN, "{}, {figure}: {mean} instead of {wanted_mean}", pair.name);
            let probes: Vec<f64> = wanted["map"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
            let found = map.values().iter().step_by(STRIDE);
            assert_eq!(found.len(), probes.len());
            for (i, (&found, wanted)) in found.zip(probes).enumerate() {
                let place = i * STRIDE;
                let off = (f64::from(found) - wanted).abs();
                assert!(off < MAP, "{}, {figure} at pixel {place}: {found} instead of {wanted}", pair.name);
            }
        }
    }
}

#[test]
#[ignore = "writes the pictures that benches/peers/perceptual.py reads, into the folder PARITY_PAIRS"]
fn write_the_pairs() {
    let folder = PathBuf::from(std::env::var_os("PARITY_PAIRS").expect("a folder in PARITY_PAIRS"));
    let write = |name: String, picture: &Picture| {
        let head = Head::new(picture.window());
        write_picture(&folder.join(name), picture, &head, &WriteOptions::default()).unwrap();
    };
    for pair in pairs() {
        let Comparison { ssim, flip_ldr, flip_hdr, .. } = compared(&pair);
        let alpha = pair.reference.planes()[3].clone();
        let maps = Picture::from_planes([ssim, flip_ldr, flip_hdr, alpha]).unwrap();
        write(format!("{}.reference.exr", pair.name), &pair.reference);
        write(format!("{}.candidate.exr", pair.name), &pair.candidate);
        write(format!("{}.maps.exr", pair.name), &maps);
    }
}
