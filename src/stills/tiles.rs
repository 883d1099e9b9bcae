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

/// The windows that are drawn so that every pixel of some windows of a picture has the pixels around it: `margin` to each side (an even
/// number), or as far as the picture goes. All are of one size.
pub(super) fn drawn(windows: &[Window], picture: [u32; 2], margin: u32) -> Vec<Window> {
    if windows.len() == 1 {
        return windows.to_vec();
    }
    let whole = picture.map(|side| side.next_multiple_of(STEP));
    let widened = |window: &Window| {
        let size = [0, 1].map(|k| (window.size[k] + 2 * margin).min(whole[k].max(window.size[k])));
        let origin = [0, 1].map(|k| window.origin[k].saturating_sub(margin).min(whole[k].saturating_sub(size[k])));
        Window { origin, size }
    };
    windows.iter().map(widened).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_windows_hold_a_margin_as_far_as_the_picture_goes() {
        for (picture, most, margin) in
            [([3840, 2160], 2048, 132), ([151, 98], 64, 132), ([130, 16], 64, 10), ([999, 301], 100, 0)]
        {
            let kept = windows(picture, 1, most);
            let drawn = drawn(&kept, picture, margin);
            assert!(drawn.iter().all(|window| window.size == drawn[0].size && window.size.iter().all(|side| side % 2 == 0)));
            for (kept, drawn) in kept.iter().zip(&drawn) {
                for (k, side) in picture.into_iter().enumerate() {
                    let end = (kept.origin[k] + kept.size[k]).min(side);
                    assert!(drawn.origin[k] <= kept.origin[k].saturating_sub(margin) && drawn.origin[k] % 2 == 0);
                    assert!(drawn.origin[k] + drawn.size[k] >= (end + margin).min(side), "{kept:?} {drawn:?}");
                }
            }
        }
    }

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
