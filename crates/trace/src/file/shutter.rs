//! How long a shutter is open, as it is written.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// When it opens and closes, in frames after the frame: `0.5` for [-0.25, 0.25], or both.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ShutterSpec(pub(crate) [f64; 2]);

impl ShutterSpec {
    /// Open about the frame.
    pub(crate) fn centred(frames: f64) -> Self {
        Self([-0.5 * frames, 0.5 * frames])
    }
}

impl<'de> Deserialize<'de> for ShutterSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ShutterVisitor)
    }
}

struct ShutterVisitor;

impl<'de> Visitor<'de> for ShutterVisitor {
    type Value = ShutterSpec;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a number of frames, or [open, close] in frames")
    }

    fn visit_f64<E: Error>(self, frames: f64) -> Result<ShutterSpec, E> {
        Ok(ShutterSpec::centred(frames))
    }

    fn visit_i64<E: Error>(self, frames: i64) -> Result<ShutterSpec, E> {
        self.visit_f64(frames as f64)
    }

    fn visit_u64<E: Error>(self, frames: u64) -> Result<ShutterSpec, E> {
        self.visit_f64(frames as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<ShutterSpec, A::Error> {
        let mut times = [0.0; 2];
        for (i, time) in times.iter_mut().enumerate() {
            *time = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::invalid_length(3, &self));
        }
        Ok(ShutterSpec(times))
    }
}
