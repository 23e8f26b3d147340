//! Three numbers, or one for all three.

use glam::DVec3;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// `0.5` or `[0.1, 0.2, 0.3]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triple(pub(crate) DVec3);

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TripleVisitor)
    }
}

struct TripleVisitor;

impl<'de> Visitor<'de> for TripleVisitor {
    type Value = Triple;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a number or three numbers")
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<Triple, E> {
        Ok(Triple(DVec3::splat(x)))
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Triple, E> {
        self.visit_f64(x as f64)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<Triple, E> {
        self.visit_f64(x as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Triple, A::Error> {
        let mut values = [0.0; 3];
        for (i, value) in values.iter_mut().enumerate() {
            *value = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::invalid_length(4, &self));
        }
        Ok(Triple(DVec3::from_array(values)))
    }
}
