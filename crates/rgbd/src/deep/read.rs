//! A deep part into the layers of a frame.

use rayon::prelude::*;

use super::DeepTally;
use super::block::{ChannelPlace, DeepBlock};
use super::chunks::{Chunks, PackedBlock};
use super::layers::GrowingLayers;
use super::pixel::Sample;
use crate::choose::Plan;
use crate::depth_convention::DepthReading;
use crate::exr_file::{ExrFile, refusal};
use crate::guard::guarded;
use crate::{Layer, PixelWindow, ReadError};

/// The layers of a deep part, nearest first, and what it held.
pub(crate) struct DeepFrame {
    pub(crate) layers: Vec<Layer>,
    pub(crate) tally: DeepTally,
}

/// The channels that make samples.
struct SampleChannels {
    rgb: [ChannelPlace; 3],
    alpha: Option<ChannelPlace>,
    depth: ChannelPlace,
    back: Option<ChannelPlace>,
}

/// Reads the deep part that `plan` takes colour and depth from, in `window`, which should hold most of it.
///
/// Blocks are unpacked a few at a time, so that the samples of the whole picture are never in memory at once.
pub(crate) fn read_deep(
    file: &ExrFile,
    plan: &Plan,
    window: PixelWindow,
    reading: DepthReading<'_>,
) -> Result<DeepFrame, ReadError> {
    const BATCH: usize = 64; // blocks; is enough for all cores
    const BATCH_BYTES: usize = 32 << 20; // bounds the memory where blocks are large
    let channels = sample_channels(file, plan)?;
    let part = plan.color.part;
    let header = &file.meta().headers[part];
    let data = file.survey().parts[part].window;
    let mut layers = GrowingLayers::new(window);
    let mut chunks = Chunks::of(file, part)?;
    let mut samples = Vec::new();
    loop {
        // Take a few
        let (mut batch, mut bytes) = (Vec::<PackedBlock>::new(), 0);
        while batch.len() < BATCH && bytes < BATCH_BYTES {
            let Some(chunk) = chunks.next().transpose()? else { break };
            bytes += chunk.unpacked + chunk.samples.len() + 4 * chunk.place.area();
            batch.push(chunk);
        }
        if batch.is_empty() {
            break;
        }

        // Unpack them on all threads, and lay them out in order
        let unpacked = batch.into_par_iter().map(|packed| guarded(|| DeepBlock::unpack(header, packed)));
        let blocks: Vec<DeepBlock> =
            unpacked.collect::<exr::error::Result<_>>().map_err(|error| refusal(file.path(), error))?;
        for block in &blocks {
            for (row, column) in rows_and_columns(block.place) {
                let (x, y) = (data.x + block.place.x + column as i32, data.y + block.place.y + row as i32);
                for sample in block.samples(row, column) {
                    let value = |channel| block.value(row, sample, channel);
                    let rgb = channels.rgb.map(value);
                    let alpha = channels.alpha.map_or(1.0, value);
                    let z = value(channels.depth);
                    let back = channels.back.map_or(z, value);
                    let is_volume = back > z && back.is_finite();
                    layers.count_volumes(u64::from(is_volume));
                    let stored = if is_volume { 0.5 * (z + back) } else { z };
                    let depth = reading.planar(stored, alpha, (x, y));
                    samples.push(Sample { depth, rgba: [rgb[0], rgb[1], rgb[2], alpha] });
                }
                layers.put(x, y, &mut samples);
            }
        }
    }
    let (layers, tally) = layers.finish();
    Ok(DeepFrame { layers, tally })
}

/// The channels of a plan; an error unless all are of one part.
fn sample_channels(file: &ExrFile, plan: &Plan) -> Result<SampleChannels, ReadError> {
    let (part, survey) = (plan.color.part, file.survey());
    let header = &file.meta().headers[part];
    let place = |channel: usize| ChannelPlace::of(header, channel);
    let depth = plan.depth.filter(|depth| depth.part == part).ok_or_else(|| ReadError::Unsupported {
        path: file.path().into(),
        what: "deep colour and depth in different parts".into(),
        remedy: "take colour and depth from one part (--color, --depth)",
    })?;

    // The far end of a volume has the name of the near one
    let name = |channel: usize| survey.parts[part].channels[channel].name.as_str();
    let wanted = name(depth.channel).strip_suffix(['Z', 'z']).map(|layer| format!("{layer}ZBack"));
    let back = wanted.and_then(|wanted| (0..header.channels.list.len()).find(|&channel| name(channel) == wanted));
    Ok(SampleChannels {
        rgb: plan.color.rgb.map(|at| place(at.channel)),
        alpha: plan.color.alpha.map(|at| place(at.channel)),
        depth: place(depth.channel),
        back: back.map(place),
    })
}

/// The rows and columns of a block, row by row.
fn rows_and_columns(place: PixelWindow) -> impl Iterator<Item = (usize, usize)> {
    let (width, height) = (place.width as usize, place.height as usize);
    (0..height).flat_map(move |row| (0..width).map(move |column| (row, column)))
}
