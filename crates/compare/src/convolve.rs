//! Separable convolution with short, even or odd kernels; the row and the tap order are fixed, so are the bits.

use std::ops::{Add, AddAssign, Mul, Sub};

use rayon::prelude::*;

/// f32 or f64.
pub(crate) trait Number:
    Copy + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + AddAssign
{
}
impl Number for f32 {}
impl Number for f64 {}

/// What lies beyond the border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Border {
    /// The border pixel again and again.
    Clamp,
    /// The picture mirrored about its outline: c b a | a b c.
    Reflect,
}

impl Border {
    /// The index in 0..n that stands for `i`.
    fn fold(self, i: isize, n: usize) -> usize {
        let n = n as isize;
        match self {
            Self::Clamp => i.clamp(0, n - 1) as usize,
            Self::Reflect => {
                let j = i.rem_euclid(2 * n);
                (if j < n { j } else { 2 * n - 1 - j }) as usize
            }
        }
    }
}

/// A kernel of 2 r + 1 taps, given by the taps 0..=r; the others mirror them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kernel<T> {
    taps: Vec<T>,
    /// Whether the tap at -k is minus the one at +k.
    odd: bool,
}

impl<T: Number> Kernel<T> {
    /// An even kernel; `taps[k]` stands at +k and -k.
    pub(crate) fn even(taps: Vec<T>) -> Self {
        Self { taps, odd: false }
    }

    /// An odd kernel; `taps[k]` stands at +k, minus that at -k; `taps[0]` is not used.
    pub(crate) fn odd(taps: Vec<T>) -> Self {
        Self { taps, odd: true }
    }

    fn radius(&self) -> usize {
        self.taps.len() - 1
    }

    /// out = sum over k of taps[k] (after[k] +- before[k]), each given as the row at offset +k or -k.
    fn gather<'a>(&self, out: &mut [T], row_at: impl Fn(isize) -> &'a [T])
    where
        T: 'a,
    {
        // Start with the centre
        if self.odd {
            out.fill(T::default());
        } else {
            out.iter_mut().zip(row_at(0)).for_each(|(o, &a)| *o = self.taps[0] * a);
        }

        // Add the pairs around it
        for (k, &tap) in self.taps.iter().enumerate().skip(1) {
            let (after, before) = (row_at(k as isize), row_at(-(k as isize)));
            if self.odd {
                out.iter_mut().zip(after).zip(before).for_each(|((o, &a), &b)| *o += tap * (a - b));
            } else {
                out.iter_mut().zip(after).zip(before).for_each(|((o, &a), &b)| *o += tap * (a + b));
            }
        }
    }
}

/// `source` (rows of `width`) correlated along x with each kernel.
pub(crate) fn along_x<T: Number, const N: usize>(
    source: &[T],
    width: usize,
    border: Border,
    kernels: [&Kernel<T>; N],
) -> [Vec<T>; N] {
    let reach = kernels.iter().map(|kernel| kernel.radius()).max().unwrap_or(0);
    let mut outputs = kernels.map(|_| vec![T::default(); source.len()]);
    let padded_rows: Vec<Vec<T>> = source
        .par_chunks(width)
        .map(|row| {
            let at = |i: usize| row[border.fold(i as isize - reach as isize, width)];
            (0..width + 2 * reach).map(at).collect()
        })
        .collect();
    for (kernel, output) in kernels.iter().zip(&mut outputs) {
        output.par_chunks_mut(width).zip(&padded_rows).for_each(|(out, padded)| {
            kernel.gather(out, |k| {
                let start = (reach as isize + k) as usize;
                &padded[start..start + width]
            });
        });
    }
    outputs
}

/// `source` (rows of `width`) correlated along y with a kernel.
pub(crate) fn along_y<T: Number>(source: &[T], width: usize, border: Border, kernel: &Kernel<T>) -> Vec<T> {
    let height = source.len() / width;
    let mut output = vec![T::default(); source.len()];
    output.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        kernel.gather(out, |k| {
            let start = border.fold(y as isize + k, height) * width;
            &source[start..start + width]
        });
    });
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reflected_border_repeats_the_border_pixel() {
        let seen: Vec<usize> = (-4..7).map(|i| Border::Reflect.fold(i, 3)).collect();
        assert_eq!(seen, [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(Border::Reflect.fold(-3, 1), 0, "a picture narrower than the kernel folds again");
    }

    #[test]
    fn an_odd_kernel_is_a_derivative_and_an_even_one_keeps_a_constant() {
        let ramp: Vec<f64> = (0..7).flat_map(|_| (0..9).map(f64::from)).collect();
        let [slope, mean] =
            along_x(&ramp, 9, Border::Clamp, [&Kernel::odd(vec![0.0, 0.25, 0.125]), &Kernel::even(vec![0.5, 0.25])]);
        assert_eq!(slope[9 + 4], 1.0);
        assert_eq!(mean[9 + 4], 4.0);
        assert_eq!(along_y(&ramp, 9, Border::Clamp, &Kernel::odd(vec![0.0, 0.5])), vec![0.0; 63]);
        assert_eq!(along_y(&ramp, 9, Border::Reflect, &Kernel::even(vec![0.5, 0.25])), ramp);
    }
}
