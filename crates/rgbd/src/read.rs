//! Frames, pictures and truths out of OpenEXR files, our own and others'.

use std::collections::BTreeSet;
use std::path::Path;

use crate::attributes::{file_kind, head, lens_attributes, notes};
use crate::choose::choose;
use crate::convert::{Converted, assemble, convert_frame, convert_picture, picture_from};
use crate::encode_exr::FileKind;
use crate::exr_file::ExrFile;
use crate::survey::ChannelIndex;
use crate::write::{half_prefix, layer_prefix};
use crate::{
    Choice, DepthConvention, Frame, Head, Layer, LensAttributes, Notes, Picture, Plane, ReadError, ReadOptions, Survey,
    Truth,
};

/// What was read, and all that the file says besides.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T> {
    /// The frame, picture or truth.
    pub value: T,
    /// Windows, colours, unit, camera.
    pub head: Head,
    /// Which channels were taken, and why.
    pub choice: Choice,
    /// What the header says of lens and sensor.
    pub lens: LensAttributes,
    /// The free text of a file of ours.
    pub notes: Notes,
}

/// What there is in a file, without reading a pixel; windows of more than `max_pixels` are refused.
pub fn survey_file(path: &Path, max_pixels: u64) -> Result<Survey, ReadError> {
    Ok(ExrFile::open(path, max_pixels)?.survey().clone())
}

/// Reads colour and depth: a file of ours bit for bit, with layers, planes and camera; any other as detected.
pub fn read_frame(path: &Path, options: &ReadOptions) -> Result<Loaded<Frame>, ReadError> {
    let file = ExrFile::open(path, options.max_pixels)?;
    let head = head_of(&file, options)?;
    match file_kind(path, file.meta())? {
        Some(FileKind::Frame { layers }) if !overridden(options) => own_frame(&file, head, layers, options.max_pixels),
        _ => {
            let mut plan = choose(path, file.survey(), options, true)?;
            let Converted { frame, deep, is_turned } = convert_frame(&file, &plan, &head, options)?;
            if let Some(tally) = deep {
                plan.choice.hidden = (1..frame.layers().len()).map(|i| format!("L{}", i + 1)).collect();
                plan.choice.reason = format!("{}; {tally}", plan.choice.reason);
            }
            if is_turned {
                plan.choice.reason = format!("{}, its negative numbers with their sign turned", plan.choice.reason);
            }
            Ok(loaded(&file, frame, head, plan.choice))
        }
    }
}

/// Reads colour only, of any file that has some; of a truth the mean.
pub fn read_picture(path: &Path, options: &ReadOptions) -> Result<Loaded<Picture>, ReadError> {
    let file = ExrFile::open(path, options.max_pixels)?;
    let head = head_of(&file, options)?;
    let plan = choose(path, file.survey(), options, false)?;
    let picture = convert_picture(&file, &plan, &head, options)?;
    Ok(loaded(&file, picture, head, plan.choice))
}

/// Reads a truth of ours: its halves bit for bit.
pub fn read_truth(path: &Path, max_pixels: u64) -> Result<Loaded<Truth>, ReadError> {
    let file = ExrFile::open(path, max_pixels)?;
    let head = head(path, file.meta())?;
    let found = match file_kind(path, file.meta())? {
        Some(FileKind::Truth { samples }) => {
            let [a, b] = [own_color(&file, &half_prefix(0))?, own_color(&file, &half_prefix(1))?];
            let mut planes = file.planes(&[a, b].concat())?;
            let second = picture_from(planes.split_off(4));
            let halves = [picture_from(planes), second];
            let truth = Truth { display: head.display, camera: head.camera, halves, samples };
            return Ok(loaded(&file, truth, head, own_choice(&["half0.RGBA", "half1.RGBA"], None)));
        }
        Some(FileKind::Frame { .. }) => "a frame",
        Some(FileKind::Picture) => "a picture",
        None => "a picture of another program",
    };
    Err(ReadError::WrongKind { path: path.into(), found, wanted: "a traced truth with its two halves" })
}

/// Reads planes of a picture of ours by their names, in that order, bit for bit.
pub fn read_planes(path: &Path, names: &[&str], max_pixels: u64) -> Result<Loaded<Vec<Plane>>, ReadError> {
    let file = ExrFile::open(path, max_pixels)?;
    let head = head(path, file.meta())?;
    let wanted: Vec<_> = names.iter().map(|name| own_channel(&file, name)).collect::<Result<_, _>>()?;
    let planes = file.planes(&wanted)?;
    Ok(loaded(&file, planes, head, own_choice(names, None)))
}

/// What the file says, with what the options know better.
fn head_of(file: &ExrFile, options: &ReadOptions) -> Result<Head, ReadError> {
    let head = head(file.path(), file.meta())?;
    Ok(Head { metres_per_unit: options.metres_per_unit.or(head.metres_per_unit), ..head })
}

/// Whether the options ask for something else than what a file of ours says of itself.
fn overridden(options: &ReadOptions) -> bool {
    options.color.is_some()
        || options.depth.is_some()
        || options.view.is_some()
        || options.convention != DepthConvention::Planar
        || options.depth_range.is_some()
        || options.background.is_some()
}

/// A frame as `write_frame` wrote it.
fn own_frame(file: &ExrFile, head: Head, count: usize, max_pixels: u64) -> Result<Loaded<Frame>, ReadError> {
    // Find the layers' channels; what is left are planes
    let mut wanted = Vec::new();
    for prefix in (0..count).map(layer_prefix) {
        wanted.extend(own_color(file, &prefix)?);
        wanted.push(own_channel(file, &format!("{prefix}Z"))?);
    }
    let taken: BTreeSet<usize> = wanted.iter().map(|at| at.channel).collect();
    let rest = file.survey().channels().filter(|at| at.part == 0 && !taken.contains(&at.channel));
    let rest: Vec<ChannelIndex> = rest.collect();
    wanted.extend(&rest);

    // Put them together
    let mut planes = file.planes(&wanted)?.into_iter();
    let mut layers = Vec::with_capacity(count);
    for _ in 0..count {
        let color = picture_from(planes.by_ref().take(4).collect());
        if let Some(depth) = planes.next() {
            layers.push(Layer::from_raw_depth(color, depth));
        }
    }
    let mut frame = assemble(file, &head, layers, max_pixels)?;
    frame.planes = rest.iter().map(|&at| file.survey().label(at)).zip(planes).collect();
    let mut choice = own_choice(&["R", "G", "B", "A"], Some("Z"));
    choice.hidden = (1..count).map(|i| layer_prefix(i).trim_end_matches('.').to_owned()).collect();
    Ok(loaded(file, frame, head, choice))
}

/// The channel of that name, which a file of ours must have.
fn own_channel(file: &ExrFile, name: &str) -> Result<ChannelIndex, ReadError> {
    file.survey().named(name).ok_or_else(|| ReadError::NotFound {
        path: file.path().into(),
        what: "channel",
        name: name.into(),
        available: file.survey().channel_names(),
    })
}

fn own_color(file: &ExrFile, prefix: &str) -> Result<Vec<ChannelIndex>, ReadError> {
    ["R", "G", "B", "A"].into_iter().map(|name| own_channel(file, &format!("{prefix}{name}"))).collect()
}

fn own_choice(color: &[&str], depth: Option<&str>) -> Choice {
    Choice {
        color: color.iter().map(|&name| name.to_owned()).collect(),
        depth: depth.map(str::to_owned),
        is_stated: true,
        reason: "the file says so itself".into(),
        ..Choice::default()
    }
}

fn loaded<T>(file: &ExrFile, value: T, head: Head, choice: Choice) -> Loaded<T> {
    let header = &file.meta().headers[0];
    Loaded { value, head, choice, lens: lens_attributes(header), notes: notes(header) }
}
