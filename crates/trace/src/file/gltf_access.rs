//! Whether what a glTF file says of its buffers is true: only then may the `gltf` crate read them.

use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, buffer};

use DataType::{F32, I8, I16, U8, U16, U32};
use Dimensions::{Mat2, Mat3, Mat4, Scalar, Vec2, Vec3, Vec4};

/// Elements that an accessor without bytes behind it may have.
const MOST_WITHOUT_BYTES: usize = 1 << 24;

/// What a reader can take for an attribute.
pub(super) type Kind = (&'static [Dimensions], &'static [DataType]);
pub(super) const PLACES: Kind = (&[Vec3], &[F32]);
pub(super) const COORDINATES: Kind = (&[Vec2], &[F32, U8, U16]);
pub(super) const COLORS: Kind = (&[Vec3, Vec4], &[F32, U8, U16]);
pub(super) const INDICES: Kind = (&[Scalar], &[U8, U16, U32]);

/// Fails unless all elements of an accessor of one of the kinds lie within its buffers.
pub(super) fn check(accessor: &Accessor<'_>, (shapes, types): Kind, buffers: &[Vec<u8>]) -> Result<(), String> {
    let fault = |what: &str| Err(format!("accessor {} {what}", accessor.index()));
    if !shapes.contains(&accessor.dimensions()) || !types.contains(&accessor.data_type()) {
        return fault("is not of the kind that its use needs");
    }
    let size = bytes_of(accessor.data_type()) * numbers_of(accessor.dimensions());
    let count = accessor.count();
    if count == 0 {
        return fault("has no elements");
    }
    if let Some(view) = accessor.view() {
        let stride = view.stride().unwrap_or(size);
        if stride < size || !holds(&view, accessor.offset(), stride, count, size, buffers) {
            return fault("reaches beyond its buffer");
        }
    } else if accessor.sparse().is_none() || count > MOST_WITHOUT_BYTES {
        return fault("has no bytes");
    }
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let index_size = indices.index_type().size();
        let within = |view: &buffer::View<'_>, offset: usize, size: usize| {
            let stride = view.stride().unwrap_or(size);
            stride >= size && holds(view, offset, stride, sparse.count(), size, buffers)
        };
        if sparse.count() == 0
            || !within(&indices.view(), indices.offset(), index_size)
            || !within(&values.view(), values.offset(), size)
        {
            return fault("has sparse elements beyond its buffer");
        }
    }
    Ok(())
}

/// The bytes of a view.
pub(super) fn bytes<'a>(view: &buffer::View<'_>, buffers: &'a [Vec<u8>]) -> Option<&'a [u8]> {
    let end = view.offset().checked_add(view.length())?;
    buffers.get(view.buffer().index())?.get(view.offset()..end)
}

/// Whether a view holds `count` elements.
fn holds(
    view: &buffer::View<'_>,
    offset: usize,
    stride: usize,
    count: usize,
    size: usize,
    buffers: &[Vec<u8>],
) -> bool {
    let end = || stride.checked_mul(count - 1)?.checked_add(offset)?.checked_add(size);
    bytes(view, buffers).is_some_and(|bytes| end().is_some_and(|end| end <= bytes.len()))
}

fn bytes_of(kind: DataType) -> usize {
    match kind {
        I8 | U8 => 1,
        I16 | U16 => 2,
        U32 | F32 => 4,
    }
}

fn numbers_of(dimensions: Dimensions) -> usize {
    match dimensions {
        Scalar => 1,
        Vec2 => 2,
        Vec3 => 3,
        Vec4 | Mat2 => 4,
        Mat3 => 9,
        Mat4 => 16,
    }
}
