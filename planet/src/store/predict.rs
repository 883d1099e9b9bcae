//! Prediction of grid values from their neighbours, so that what is stored is small; and the splitting of numbers into planes
//! of bytes, so that the entropy coder sees alike bytes together.

/// Grid points in coarse-to-fine order, each with the points it is predicted from: the dyadic midpoint order of a square grid
/// of `cells` (a power of two) cells a side. Corners first; then, halving the step, the middles of squares (from the four
/// corners of their square) and the middles of edges (from the two to four points around them).
pub(super) fn midpoint_order(cells: usize, mut visit: impl FnMut(usize, &[usize])) {
    let row = cells + 1;
    let at = |i: usize, j: usize| j * row + i;
    visit(0, &[]);
    visit(at(cells, 0), &[0]);
    visit(at(0, cells), &[0]);
    visit(at(cells, cells), &[at(cells, 0), at(0, cells)]);
    let mut step = cells;
    while step > 1 {
        let half = step / 2;
        for j in (half..cells).step_by(step) {
            for i in (half..cells).step_by(step) {
                let around = [at(i - half, j - half), at(i + half, j - half), at(i - half, j + half), at(i + half, j + half)];
                visit(at(i, j), &around);
            }
        }
        for j in (0..=cells).step_by(half) {
            let first = if (j / half).is_multiple_of(2) { half } else { 0 };
            for i in (first..=cells).step_by(step) {
                visit_edge(i, j, half, cells, &mut visit);
            }
        }
        step = half;
    }
}

fn visit_edge(i: usize, j: usize, half: usize, cells: usize, visit: &mut impl FnMut(usize, &[usize])) {
    let row = cells + 1;
    let mut around = [0; 4];
    let mut count = 0;
    let mut add = |inside: bool, i: usize, j: usize| {
        if inside {
            around[count] = j * row + i;
            count += 1;
        }
    };
    add(i >= half, i.wrapping_sub(half), j);
    add(i + half <= cells, i + half, j);
    add(j >= half, i, j.wrapping_sub(half));
    add(j + half <= cells, i, j + half);
    visit(j * row + i, &around[..count]);
}

/// Mean of the values a point is predicted from; 0 without any.
pub(super) fn mean(values: &[i32], around: &[usize]) -> i32 {
    let sum: i64 = around.iter().map(|&k| i64::from(values[k])).sum();
    if around.is_empty() {
        0
    } else {
        sum.div_euclid(around.len() as i64) as i32
    }
}

/// Signed to unsigned with small magnitudes first.
pub(super) fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

/// Inverse of [`zigzag`].
pub(super) fn unzigzag(code: u32) -> i32 {
    (code >> 1) as i32 ^ -((code & 1) as i32)
}

/// Byte `plane` (0 is the lowest) of every number.
pub(super) fn plane(numbers: &[u32], plane: u32) -> Vec<u8> {
    numbers.iter().map(|n| (n >> (8 * plane)) as u8).collect()
}

/// Adds a plane's bytes to the numbers.
pub(super) fn merge_plane(numbers: &mut [u32], bytes: &[u8], plane: u32) {
    for (n, &b) in numbers.iter_mut().zip(bytes) {
        *n |= u32::from(b) << (8 * plane);
    }
}

/// The gradient predictor of images: the median of left, up and left + up - corner (median edge detector, Weinberger and others
/// 1996). Without branches, which on noisy ground nothing could predict.
#[inline(always)]
pub(super) fn median_edge(left: u8, up: u8, corner: u8) -> u8 {
    let (low, high) = (i16::from(left.min(up)), i16::from(left.max(up)));
    let gradient = i16::from(left) + (i16::from(up) - i16::from(corner));
    gradient.min(high).max(low) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_visited_once_and_after_what_predicts_it() {
        for cells in [8, 16, 32] {
            let mut seen = vec![false; (cells + 1) * (cells + 1)];
            midpoint_order(cells, |v, around| {
                assert!(!seen[v] && around.iter().all(|&a| seen[a]), "{v} from {around:?}");
                seen[v] = true;
            });
            assert!(seen.into_iter().all(|s| s));
        }
    }

    #[test]
    fn zigzag_inverts_at_the_ends() {
        for value in [0, 1, -1, 12345, -12345, i32::MAX, i32::MIN] {
            assert_eq!(unzigzag(zigzag(value)), value);
        }
    }
}
