//! Blocks of pixels of large pictures. The pixels of a block share the measurements of the
//! prefix-ray pilot (small simulation before the first pass).

/// Largest number of pixels that the prefix-ray pilot (small simulation before the first pass)
/// traces in one picture. In a picture with more pixels, the pilot divides the film into
/// [blocks](PilotBlocks), and traces one pixel of each.
///
/// Highlights and caustics cover more pixels of a larger picture, so fewer rays per pixel find
/// them. Pictures of more pixels trace at least about a quarter of this number.
const MAX_TRACED_PIXELS: u32 = 1 << 19;

/// Division of the film into square blocks of pixels. Each picture of the prefix-ray pilot (small
/// simulation before the first pass) traces one pixel of each block. Blocks are cut off at the
/// right and lower edge of the film.
#[derive(Clone, Copy, Debug)]
pub(super) struct PilotBlocks {
    /// Number of pixels per row and column of a block.
    pub edge: usize,
    /// Width and height of the film \[pixels].
    pub film_size: (usize, usize),
}

impl PilotBlocks {
    /// Divides a film of the given width and height \[pixels] into the smallest blocks whose number
    /// is at most about [`MAX_TRACED_PIXELS`].
    pub fn new((width, height): (u32, u32)) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        let is_enough = |edge: &u64| pixels <= u64::from(MAX_TRACED_PIXELS) * edge * edge;
        let edge = (1..).find(is_enough).unwrap_or(1) as usize;
        Self { edge, film_size: (width as usize, height as usize) }
    }

    /// Returns the numbers of columns and rows of blocks, the squares of pixels that divide the
    /// film.
    pub fn size(&self) -> (usize, usize) {
        (self.film_size.0.div_ceil(self.edge), self.film_size.1.div_ceil(self.edge))
    }

    /// Returns the number of blocks, the squares of pixels that divide the film.
    pub fn count(&self) -> usize {
        self.size().0 * self.size().1
    }

    /// Returns the block that contains pixel `pixel`. Blocks and pixels are indices by rows from
    /// the top.
    pub fn block_of_pixel(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.film_size.0, pixel / self.film_size.0);
        y / self.edge * self.size().0 + x / self.edge
    }

    /// Returns the number of pixels of `block`, an index by rows from the top. Blocks at the right
    /// and lower edge of the film may be smaller.
    pub fn pixel_count(&self, block: usize) -> usize {
        let (column, row) = (block % self.size().0, block / self.size().0);
        let extent = |at: usize, end: usize| self.edge.min(end - at * self.edge);
        extent(column, self.film_size.0) * extent(row, self.film_size.1)
    }

    /// True if picture `i` of the pilot traces another pixel of each block than the picture before
    /// it. Blocks of one pixel have no other pixel.
    pub fn starts_new_pixels(&self, i: u32) -> bool {
        self.edge > 1 && i > 0 && i.is_multiple_of(2)
    }

    /// Returns the pixel of `block` that picture `i` traces. Two consecutive pictures trace the
    /// same pixel, so that their difference shows the noise of one pixel; the next two trace
    /// another one, except in blocks that the edge of the film cuts off. Blocks and pixels are
    /// indices by rows from the top.
    pub fn traced_pixel(&self, block: usize, i: u32) -> usize {
        let (columns, edge) = (self.size().0, self.edge);
        // edge + 1 has no common factor with edge², so no pixel is repeated before all others.
        let turn = (i / 2) as usize * (edge + 1) % (edge * edge);
        let x = (block % columns * edge + turn % edge).min(self.film_size.0 - 1);
        let y = (block / columns * edge + turn / edge).min(self.film_size.1 - 1);
        y * self.film_size.0 + x
    }
}
