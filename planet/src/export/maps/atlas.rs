//! Where the patches of a mesh lie in one picture: square tiles of equal size, a power of two texels a side, with gutters.
//!
//! A tile's gutter is a sixteenth of its side and holds the ground beyond the patch, so that filtering shows no seam at a patch's border, nor
//! does any mip level down to the one where a tile has 16 texels and its gutter one. Coarser ones show where a patch covers fewer
//! than 14 pixels.

use super::super::ExportError;

/// Fewest texels a side of a tile: its gutter is one texel then.
const SMALLEST_TILE: u32 = 16;

/// Share of a tile's side that its gutter takes at each end.
const GUTTERS: u32 = 16;

/// Tiles of a picture, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Atlas {
    /// Texels of the picture, from left to right and from top to bottom.
    pub(crate) size: [u32; 2],
    /// Texels a side of a tile.
    pub(crate) tile: u32,
}

impl Atlas {
    /// The largest tiles with which so many patches fit into a picture of so many texels a side. The picture is half as high, or a
    /// quarter, where that is enough.
    pub(crate) fn new(patches: usize, side: u32) -> Result<Atlas, ExportError> {
        let most = (side / SMALLEST_TILE).pow(2) as usize;
        if patches > most {
            return Err(ExportError::MapTiles { patches, side, most });
        }
        let mut columns = 1_u32;
        while ((columns * columns) as usize) < patches {
            columns *= 2;
        }
        let tile = side / columns;
        let rows = patches.div_ceil(columns as usize).max(1) as u32;
        Ok(Atlas { size: [side, rows.next_power_of_two() * tile], tile })
    }

    /// Texels of a gutter.
    pub(crate) fn gutter(&self) -> u32 {
        self.tile / GUTTERS
    }

    /// Texels of a patch's side, without the gutters.
    pub(crate) fn inner(&self) -> u32 {
        self.tile - 2 * self.gutter()
    }

    /// The upper left corner of a tile.
    pub(crate) fn corner(&self, number: usize) -> [u32; 2] {
        let columns = (self.size[0] / self.tile) as usize;
        [(number % columns) as u32 * self.tile, (number / columns) as u32 * self.tile]
    }

    /// The place in the picture of a place in a patch, each counted in shares of a side: of the patch from its first corner, of the
    /// picture from its upper left one.
    pub(crate) fn place(&self, number: usize, [along, up]: [f64; 2]) -> [f32; 2] {
        let [left, top] = self.corner(number).map(f64::from);
        let (gutter, inner) = (f64::from(self.gutter()), f64::from(self.inner()));
        let texels = [left + gutter + along * inner, top + gutter + (1.0 - up) * inner];
        [0, 1].map(|k| (texels[k] / f64::from(self.size[k])) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_side_by_side_and_patches_inside_them() {
        for (patches, side) in [(1, 64), (2, 64), (3, 256), (17, 1024), (150, 2048), (16, 64)] {
            let atlas = Atlas::new(patches, side).unwrap();
            assert!(atlas.size.iter().all(|s| s.is_power_of_two() && *s <= side) && atlas.tile.is_power_of_two());
            let corners: Vec<[u32; 2]> = (0..patches).map(|k| atlas.corner(k)).collect();
            for (k, [left, top]) in corners.iter().enumerate() {
                assert!(left + atlas.tile <= atlas.size[0] && top + atlas.tile <= atlas.size[1], "{patches} in {side}");
                assert!(!corners[..k].contains(&[*left, *top]));
                let [u, v] = atlas.place(k, [0.0, 1.0]);
                let texel = [u * atlas.size[0] as f32, v * atlas.size[1] as f32];
                assert_eq!(texel, [(left + atlas.gutter()) as f32, (top + atlas.gutter()) as f32]);
            }
            let used = patches as f64 * f64::from(atlas.tile).powi(2) / (f64::from(atlas.size[0]) * f64::from(atlas.size[1]));
            assert!(used > 0.25, "{patches} in {side}: {used} of the texels are used");
        }
        assert!(matches!(Atlas::new(17, 64), Err(ExportError::MapTiles { most: 16, .. })));
    }
}
