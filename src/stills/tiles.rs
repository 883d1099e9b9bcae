//! Which windows a picture is drawn through.

use terrane_planet::draw::view::Window;

/// Sides of tiles are multiples of this: pixels are shaded in squares of two.
const STEP: u32 = 2;

/// The windows of a picture in rows from the top, all of one size, so that none has more than `most` pixels a side where each of them
/// is drawn `ssaa` times as wide and high. The last ones reach beyond the picture where they do not divide it. One is the whole picture.
pub(super) fn windows(picture: [u32; 2], ssaa: u32, most: u32) -> Vec<Window> {
    let most = most / ssaa.max(1);
    if picture.iter().all(|&side| side <= most) {
        return vec![Window::whole(picture)];
    }
    let most = (most / STEP * STEP).max(STEP);
    let counts = picture.map(|side| side.div_ceil(most));
    let size = [0, 1].map(|k| picture[k].div_ceil(counts[k]).next_multiple_of(STEP));
    let rows = (0..picture[1]).step_by(size[1] as usize);
    rows.flat_map(|y| (0..picture[0]).step_by(size[0] as usize).map(move |x| Window { origin: [x, y], size })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_window_and_no_window_is_too_large() {
        for (picture, ssaa, most) in
            [([7680, 4320], 1, 2048), ([7680, 4320], 3, 1024), ([97, 61], 1, 64), ([130, 16], 2, 64), ([17, 999], 4, 10)]
        {
            let windows = windows(picture, ssaa, most);
            let covers = |window: &Window, k: usize, at: u32| (window.origin[k]..window.origin[k] + window.size[k]).contains(&at);
            for at in [[0, 0], [picture[0] - 1, picture[1] - 1], [picture[0] / 2, picture[1] / 3], [63, 15], [64, 14]] {
                let at = [at[0].min(picture[0] - 1), at[1].min(picture[1] - 1)];
                assert_eq!(windows.iter().filter(|w| covers(w, 0, at[0]) && covers(w, 1, at[1])).count(), 1, "{at:?}");
            }
            assert!(windows.iter().all(|w| w.size == windows[0].size && w.size.iter().all(|s| s * ssaa <= most)), "{windows:?}");
        }
    }

    #[test]
    fn a_picture_that_fits_is_one_window_of_its_own_size() {
        assert_eq!(windows([641, 479], 2, 1282), [Window::whole([641, 479])]);
    }
}
